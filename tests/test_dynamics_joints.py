"""Every joint type: both derivations agree and every law holds; what a joint forbids; published numbers."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from mechanisms import jointed
from oracles import BIG, assert_digits, numbers, oracle
from running import agreements, call, workspace

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import derive, expected, formulations_of
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.graph import Expr, Graph, Op, evaluate, reachable
from symdyn.scene import Quantity, Scene
from symdyn.scene.joints import JOINTS, JointMotion, joint_motion
from symdyn.scene.joints.joint_table import resting
from symdyn.scene.values import Body, Joint, Pose, folding
from symdyn.spatial import Transform, Vec, add, cross, dot, scale, sub, zero_vector
from symdyn.verdict import Verdict
from symdyn.verify.certificate import on_unit_sphere
from symdyn.verify.equality import prove
from symdyn.verify.laws import laws

CLASSES = {  # the textbook's connection of class t
    "revolute": 5,
    "prismatic": 5,
    "fixed": 6,
    "helical": 5,
    "cylindrical": 4,
    "universal": 4,
    "spherical": 3,
    "planar": 3,
    "point_on_line": 2,
    "point_on_plane": 1,
    "rod": 1,
    "free": 0,
    "custom": 4,
}

SHORT = [jointed(kind) for kind in CLASSES if kind != "fixed"]
GIMBALS = [jointed(kind, orientation="zyx") for kind in ("spherical", "free")]
CHAINS = [jointed(*types) for types in (("revolute", "spherical", "prismatic"), ("free", "universal"))]


def with_rotor(one: Scene, inertia: Quantity) -> Scene:
    """Return a scene with a rotor at its last joint."""
    return replace(one, name=f"{one.name}_rotor", joints=(*one.joints[:-1], replace(one.joints[-1], armature=inertia)))


ROTORS = [
    with_rotor(jointed("revolute", "spherical", orientation=o), Quantity.symbol("L")) for o in ("quaternion", "zxz")
]


def by_name(one: Scene) -> str:
    return one.name


@pytest.mark.parametrize("kind", CLASSES)
def test_every_type_has_its_class(kind: str) -> None:
    assert JOINTS.keys() == CLASSES.keys()
    assert JOINTS[kind].class_t(jointed("revolute", kind).joints[1]) == CLASSES[kind]


@pytest.mark.heavy("revolute_spherical_prismatic", "free_universal", "revolute_spherical_rotor0")
@pytest.mark.long
@pytest.mark.parametrize("one", [*SHORT, *GIMBALS, *CHAINS, *ROTORS], ids=by_name)
def test_both_derivations_agree(one: Scene) -> None:
    w = workspace(one)
    slow = [("forward_dynamics", "lagrange")] if w.state.n > 6 else []  # elimination of a full M
    claims = agreements(w, expected(one), slow)
    findings = prove(on_unit_sphere(one, [claim for claim in claims if claim.left]))[1]

    assert {finding.claim for finding in findings if finding.verdict != Verdict.PROVED} == set()
    assert len(findings) > 10


@pytest.mark.long
@pytest.mark.parametrize("one", [*SHORT, *GIMBALS, *ROTORS], ids=by_name)
def test_every_law_holds(one: Scene) -> None:
    claims = [claim for claim in laws(workspace(one), expected(one)) if claim.left]
    findings = prove(on_unit_sphere(one, claims))[1]

    assert {finding.claim for finding in findings if finding.verdict != Verdict.PROVED} == set()
    assert {"passivity", "power balance"} <= {finding.claim.split(":")[0] for finding in findings}


@pytest.mark.long
@pytest.mark.parametrize("orientation", ["quaternion", "zyx", "zxz"])
def test_a_rotor_at_a_ball_on_the_ground_is_inertia_of_the_body(orientation: str) -> None:
    plain, rotor = jointed("spherical", orientation=orientation), Quantity.number(Fraction(7, 10))
    xx, yy, zz, *products = plain.bodies[0].inertia
    heavier = tuple(folding.add(x, rotor) for x in (xx, yy, zz))
    body = replace(plain.bodies[0], inertia=(*heavier, *products))
    rotating, solid = with_rotor(plain, rotor), replace(plain, bodies=(body,))
    rng = np.random.default_rng(5)
    q, qd, qdd = (rng.uniform(-1, 1, len(names)) for names in (plain.coordinates, *[plain.velocities] * 2))
    q = q / np.linalg.norm(q) if orientation == "quaternion" else q
    given = {"q": q, "qd": qd, "qdd": qdd, "tau": qdd, "params": ()}
    for name in ("inverse_dynamics", "forward_dynamics", "mass_matrix", "velocity_forces", "kinetic_energy"):
        for formulation in formulations_of(name, rotating):
            told = [call(derive(scene, [name], formulation), name, Floats(), **given) for scene in (rotating, solid)]
            np.testing.assert_allclose(*told, rtol=1e-13, atol=1e-13)
            assert not np.allclose(
                told[0], call(derive(plain, [name], formulation), name, Floats(), **given), atol=1e-9
            ) or (
                name == "velocity_forces" and orientation == "quaternion"  # alike about all axes: no ω × a ω
            )


def state_of(one: Scene, graph: Graph, seed: int) -> dict[Expr, float]:
    """Return random values of all symbols, quaternions of unit length."""
    rng = random.Random(seed)
    values = {graph.symbol(name): rng.uniform(0.2, 1.0) for name in (*one.coordinates, *one.velocities, "L")}
    for group in quaternions(one):
        length = sum(values[graph.symbol(name)] ** 2 for name in group) ** 0.5
        values |= {graph.symbol(name): values[graph.symbol(name)] / length for name in group}
    return values


@pytest.mark.parametrize("kind", [kind for kind in CLASSES if kind != "custom"])
def test_what_a_joint_forbids(kind: str) -> None:
    """Wrenches do no work on the joint's motion, there are t of them, and residuals vanish where it is allowed."""
    one, graph = jointed("revolute", kind), Graph()
    joint = one.joints[1]
    motion = joint_motion(joint, graph)
    X = motion.placement
    wrenches = JOINTS[kind].forbids.wrenches(joint, X)
    twist = relative_twist(motion, graph)
    power = [dot(force, v) + dot(moment, w) for force, moment in wrenches for v, w in twist]
    known = state_of(one, graph, 3)
    rows = [entry for wrench in wrenches for part in wrench for entry in part]

    def values(nodes: list[Expr]) -> list[float]:
        return evaluate(nodes, Floats(), {x: known[x] for x in reachable(nodes) if x.op is Op.SYMBOL})

    assert len(wrenches) == CLASSES[kind]
    assert values(list(JOINTS[kind].forbids.residual(joint, X))) == pytest.approx([0.0] * len(wrenches), abs=1e-14)
    assert values(power) == pytest.approx([0.0] * len(power), abs=1e-14)
    if wrenches:
        assert np.linalg.matrix_rank(np.array(values(rows)).reshape(-1, 6)) == len(wrenches)


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "cylindrical", "planar", "point_on_line", "point_on_plane"])
@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)], ids=str)
def test_what_is_named_after_an_axis_of_its_frame_acts_along_it(kind: str, axis: tuple[int, ...]) -> None:
    """F_guide_z and multiplier_hinge_mz of joints about x were those along -z."""
    one, graph = jointed("revolute", kind), Graph()
    x, y, z = (Quantity.number(part) for part in axis)
    joint = one.joints[1].shaped(axis=(x, y, z))
    wrenches = JOINTS[kind].forbids.wrenches(joint, joint_motion(joint, graph).placement)

    for part in (part for wrench in wrenches for part in wrench):
        assert all(entry is graph.zero or entry is graph.one for entry in part)


@pytest.mark.parametrize("kind", [kind for kind, row in JOINTS.items() if row.turned is not None])
def test_a_coordinate_starts_where_it_did_when_its_joint_is_turned_round(kind: str) -> None:
    joint, turned = jointed("revolute", kind).joints[1], JOINTS[kind].turned
    assert turned is not None
    numbers = tuple(Quantity.number(k + 1) for k in range(len(joint.coordinates)))
    one = replace(joint, start=numbers, start_rates=numbers)
    other = turned(one)

    for starts in ("start", "start_rates"):
        there, before = (dict(zip(x.coordinates, getattr(x, starts), strict=True)) for x in (other, one))
        assert there == before


@pytest.mark.parametrize("kind", JOINTS)
def test_a_joint_that_is_held_is_where_its_motion_takes_it(kind: str) -> None:
    """`held` is the placement of `blocks` there; at zero, without rotation, if there are several coordinates."""
    joint, graph = jointed("revolute", kind).joints[1], Graph()
    at = (Quantity.number(Fraction(3, 10)),) if len(joint.coordinates) == 1 else resting(joint)
    steps = JOINTS[kind].held(joint, at[0] if at else Quantity.number(0))

    held, moved = Pose(steps).transform(graph), joint_motion(joint, graph).placement

    known = {graph.symbol(name): float(x.value) for name, x in zip(joint.coordinates, at, strict=True)}
    entries = [x - y for x, y in zip(flat(held), flat(moved), strict=True)]
    found = evaluate(entries, Floats(), known | {graph.symbol("L"): 1.2})
    assert found == pytest.approx([0] * 12, abs=1e-15)


def flat(X: Transform) -> list[Expr]:
    return [*(x for row in X.R for x in row), *X.p]


def relative_twist(motion: JointMotion, graph: Graph) -> list[tuple[Vec, Vec]]:
    """Return, for every velocity, that of the moved frame's origin and the angular one, joint frame."""
    tip, still = motion.placement.p, zero_vector(graph)
    twists: dict[int, tuple[Vec, Vec]] = {}
    place: Transform | None = None
    for part in motion.joints:
        before = part.before if place is None else place @ part.before
        axis = before.R @ part.axis
        v, w = (axis, still) if part.slides else (cross(axis, sub(tip, before.p)), axis)
        for k, x in part.rate:
            total = twists.get(k, (still, still))
            twists[k] = (add(total[0], scale(x, v)), add(total[1], scale(x, w)))
        place = before @ part.placement
    return list(twists.values())


@pytest.mark.parametrize("kind", [kind for kind in CLASSES if kind not in ("custom", "free")])
def test_residuals_change_as_the_wrenches_say(kind: str) -> None:
    """Near closure the rate of each residual is the power of its wrench, for every small relative displacement."""
    one, graph = jointed("revolute", kind), Graph()
    joint = one.joints[1]
    X = joint_motion(joint, graph).placement
    step = Fraction(1, 10**7)
    known = state_of(one, graph, 5)

    def value(nodes: list[Expr]) -> Any:
        return np.array(evaluate(nodes, Floats(), {x: known[x] for x in reachable(nodes) if x.op is Op.SYMBOL}))

    for k, part in enumerate(("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")):
        small = Transform.elementary(part, graph.constant(step))
        moved = Transform(X.R, tuple(a + b for a, b in zip(X.p, small.p, strict=True)))
        if k > 2:  # a turn about the origin of the moved frame, axes of the joint frame
            moved = Transform((small @ X).R, X.p)
        rate = value(list(JOINTS[kind].forbids.residual(joint, moved))) / float(step)
        wrenches = JOINTS[kind].forbids.wrenches(joint, X)
        power = value([(force if k < 3 else moment)[k % 3] for force, moment in wrenches])
        assert rate == pytest.approx(power, abs=1e-5)


# Published numbers


def top(orientation: str) -> Scene:
    """Return a body with inertia diag(1, 2, 3) on a ball."""
    body = Body("top", Quantity.number(1), inertia=tuple(Quantity.number(x) for x in (1, 2, 3, 0, 0, 0)))
    joint = Joint("ball", "spherical", "ground", "top", (("orientation", orientation),))
    units = JOINTS["spherical"].coordinates(joint)
    names = tuple(f"q{k + 1}" for k in range(len(units)))
    quasi = ("wx", "wy", "wz") if orientation == "quaternion" else ()
    return Scene("top", bodies=(body,), joints=(replace(joint, coordinates=names, velocities=quasi),)).with_gravity(
        (Quantity.number(0),) * 3
    )


@pytest.mark.parametrize("case", oracle("gimbal_lock_zyx")["cases"], ids=lambda case: f"1e-{case['k']}")
def test_a_torque_free_body_near_gimbal_lock(case: dict[str, Any]) -> None:
    """Three angles lose digits as the pitch nears 90 degrees, in 60 digits not many; body rates never do."""
    angles = numbers([case["psi"], case["theta_pitch"], case["phi"]])
    rates, none = numbers(case["rates_psi_th_ph"]), numbers(["0"] * 3)
    qdd = call(derive(top("zyx"), ["forward_dynamics"]), "forward_dynamics", BIG, q=angles, qd=rates, tau=none)
    upright, omega = numbers(["1", "0", "0", "0"]), numbers(case["omega_body"])
    ball = derive(top("quaternion"), ["forward_dynamics"])
    domega = call(ball, "forward_dynamics", BIG, q=upright, qd=omega, tau=none)

    assert_digits(domega, case["omegadot_body"], "1e-30")
    assert_digits(qdd, case["euler_qdd"], "1e-25")
