"""Closed loops: rows of every joint type by two formulations, laws off the manifold, and what closure means."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from closed_mechanisms import (
    along_x,
    bricard,
    crank_rocker,
    exact,
    four_bar,
    n_four_bar,
    rssr,
    slider_crank,
    symbolic_four_bar,
)
from mechanisms import coupled_tree, random_tree, shape
from running import agreements

from symdyn.dynamics import (
    OUTPUTS,
    LoopChoices,
    Workspace,
    assemble,
    available,
    consistent,
    derive,
    derive_one,
    formulations_of,
)
from symdyn.dynamics.loops.constraint_rows import cuts, differentiated, recursive
from symdyn.dynamics.mechanism import kinematics
from symdyn.dynamics.mechanism.state import body_placements
from symdyn.emit import emit
from symdyn.errors import DerivationError
from symdyn.graph import Op, substitute, tangents
from symdyn.program import lower
from symdyn.runtime import lambdify, run_python
from symdyn.scene import Quantity, Scene, read_text
from symdyn.scene.forces.applied_forces import Spring
from symdyn.scene.forces.constraints import Formula
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Body, Joint, Pose, folding
from symdyn.scene.values.entry import compose
from symdyn.scene.values.joint import Contact, Place
from symdyn.spatial import Mat, Transform
from symdyn.verdict import Verdict
from symdyn.verify import Claim, laws, prove
from symdyn.verify.certificate import on_unit_sphere

CLOSING = [name for name in JOINTS if name not in ("free", "custom")]


def pose(rng: random.Random) -> object:
    shifts = [(kind, exact(Fraction(rng.randint(-9, 9), 10))) for kind in ("Tx", "Ty", "Tz")]
    return compose(
        *shifts, ("Rx", exact(Fraction(rng.randint(1, 9), 10))), ("Rz", exact(Fraction(rng.randint(1, 9), 10)))
    )


def with_loops(seed: int) -> Scene:
    """A random tree with a ball at its end, cut joints of all types between random bodies, and rows."""
    rng = random.Random(seed)
    tree = random_tree(seed, 5) if seed % 2 else coupled_tree(seed, 6)
    names = ["ground", *(body.name for body in tree.bodies)]
    ball = Joint(
        "ball", "spherical", names[2], "end", origin=pose(rng), tip=pose(rng),
        coordinates=("e0", "e1", "e2", "e3"), velocities=("wx", "wy", "wz"), drives=(None,) * 3,
    )  # fmt: skip
    names.append("end")
    loops = []
    for kind in CLOSING:
        parent, child = rng.sample(names, 2)
        axis = tuple(Quantity.number(x) for x in rng.choice([(1, 2, 3), (0, 0, 1), (1, 0, 0)]))
        loops.append(
            Joint(
                f"c_{kind}", kind, parent, child, shape(
                    kind, axis=axis, pitch=exact("1/5"), length=exact("3/2"),
                    second_axis=(Quantity.ONE, Quantity.ONE, Quantity.ZERO)
                ), pose(rng), pose(rng),
            )
        )  # fmt: skip
    at = (exact("1/10"), Quantity.ZERO, exact("1/5"))
    rows = (
        Contact("blade", "knife_edge", Place("end", at), axis=(Quantity.ONE, exact(2), Quantity.ZERO)),
        Formula("slow", folding.add(Quantity.symbol("wx"), folding.mul(Quantity.symbol("e1"), Quantity.symbol("wy")))),
    )
    return replace(
        tree,
        bodies=(*tree.bodies, Body("end", Quantity.ONE)),
        joints=(*tree.joints, ball),
        loops=tuple(loops),
        elements=rows,
    )


def flat(rows: object) -> tuple[object, ...]:
    return tuple(entry for row in rows for entry in row)  # type: ignore[attr-defined]


@pytest.mark.wide(2)
@pytest.mark.long(0)
@pytest.mark.parametrize("seed", range(4))
def test_rows_of_every_joint_type_agree_on_both_formulations(seed: int) -> None:
    scene = with_loops(seed)
    w = Workspace(scene)

    along, by = recursive(scene, w.tree, w.state), differentiated(scene, w.graph, w.state)
    claims = [
        Claim("residual", "recursive", "differentiation", along.residual, by.residual),
        Claim("G", "recursive", "differentiation", flat(along.G), flat(by.G)),  # type: ignore[arg-type]
        Claim("bias", "recursive", "differentiation", along.bias, by.bias),
    ]

    assert [label.owner for label in along.labels] == [label.owner for label in by.labels]
    assert {f.verdict for f in prove(on_unit_sphere(scene, claims))[1]} == {Verdict.PROVED}


def rolling(component: tuple[str, ...], reduced: str = "Rx") -> Scene:
    """A disc of radius r with free place, yaw, reduced and roll angles: its axis is y of the moved frame."""
    steps = compose(
        ("Tx", Quantity.symbol("x")),
        ("Ty", Quantity.symbol("y")),
        ("Tz", Quantity.symbol("z")),
        ("Rz", Quantity.symbol("psi")),
    )
    steps = compose(*steps.steps, (reduced, Quantity.symbol("theta")), ("Ry", Quantity.symbol("phi")))
    names = ("x", "y", "z", "psi", "theta", "phi")
    free = Joint(
        "flight", "custom", "ground", "disc", shape("custom", steps=steps, units=("m",) * 3 + ("rad",) * 3),
        coordinates=names, drives=(None,) * 6,
    )  # fmt: skip
    row = Contact("wheel", "rolling", Place("disc"), radius=exact("1/2"), components=component)
    disc = Body(
        "disc",
        Quantity.ONE,
        inertia=(exact("1/8"), exact("1/4"), exact("1/8"), Quantity.ZERO, Quantity.ZERO, Quantity.ZERO),
    )
    return Scene("disc", (), bodies=(disc,), joints=(free,), elements=(row,))


def test_rows_of_a_leaning_disc_agree_and_say_that_its_lowest_point_rests() -> None:
    scene = rolling(("along", "across", "normal"))
    w = Workspace(scene)
    along, by = recursive(scene, w.tree, w.state), differentiated(scene, w.graph, w.state)
    claims = [Claim("G", "a", "b", flat(along.G), flat(by.G)), Claim("bias", "a", "b", along.bias, by.bias)]  # type: ignore[arg-type]
    assert set() < {f.verdict for f in prove(claims)[1]} <= {Verdict.PROVED, Verdict.NUMERICAL}

    q, u = np.array([0.3, -0.2, 0.4, 0.7, 0.5, 1.1]), np.array([0.5, -0.3, 0.2, 0.9, -0.4, 2.0])
    psi, theta = q[3:5]
    Rz = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
    Rx = np.array([[1, 0, 0], [0, np.cos(theta), -np.sin(theta)], [0, np.sin(theta), np.cos(theta)]])
    a = Rz @ Rx @ np.array([0, 1, 0])
    omega = u[3] * np.array([0, 0, 1]) + u[4] * Rz @ np.array([1, 0, 0]) + u[5] * a
    n, s = np.array([0, 0, 1]), np.linalg.norm(np.cross(a, [0, 0, 1]))
    contact = u[:3] + np.cross(omega, -0.5 * (n - (n @ a) * a) / s)
    expected = [contact @ np.cross(a, n) / s, contact @ np.cross(n, np.cross(a, n)) / s, contact @ n]
    rates = lambdify(scene, "constraint_jacobian")(q) @ u
    assert rates == pytest.approx(expected, abs=1e-14)


def test_an_upright_wheel_has_rows_without_a_root() -> None:
    scene = rolling(("along", "across"))
    joint = scene.joints[0]
    steps = compose(*(step for step in dict(joint.shape)["steps"].steps if step[1].symbols != ("theta",)))
    own = shape("custom", steps=steps, units=("m",) * 3 + ("rad",) * 2)
    upright = replace(joint, shape=own, coordinates=("x", "y", "z", "psi", "phi"), drives=(None,) * 5)
    scene = replace(scene, joints=(upright,))

    assert {f.verdict for f in prove(laws(Workspace(scene), available(scene)[0]))[1]} == {Verdict.PROVED}


def test_a_row_that_is_not_linear_in_the_velocities_is_refused() -> None:
    scene = replace(
        random_tree(1), elements=(Formula("odd", folding.mul(Quantity.symbol("x0_dot"), Quantity.symbol("x0_dot"))),)
    )

    with pytest.raises(DerivationError, match=r"constraints\.odd: the formula is not linear in the velocities"):
        derive(scene, ("constraint_jacobian",))


@pytest.mark.parametrize("kind", CLOSING)
def test_where_a_loop_is_closed_residuals_change_by_the_power_of_their_wrenches(kind: str) -> None:
    """The loop closes by construction: q at random, the child's frame where the joint at those coordinates wants it."""
    scene = with_loops(3)
    loop = replace(next(one for one in scene.loops if one.type == kind), parent=scene.bodies[0].name, child="end")
    scene = replace(scene, loops=(loop,), elements=())
    w = Workspace(scene)
    (cut,), placed = cuts(scene, w.graph), body_placements(scene, w.graph)
    C = (placed[cut.parent] @ cut.on_parent).inverse() @ placed[cut.child]
    entries = [entry for row in C.R for entry in row] + list(C.p)
    names = {q: w.graph.symbol(f"there_{q.value}") for q in w.state.q}
    there = substitute(entries, names)
    K = Transform(Mat((there[:3], there[3:6], there[6:9])), tuple(there[9:]))  # type: ignore[arg-type]
    allowed = Transform.elementary("Tz", w.graph.constant(Fraction(3, 2))) if kind == "rod" else Transform.unit(w.graph)
    X = C @ K.inverse() @ allowed
    back = {symbol_: q for q, symbol_ in names.items()}

    velocity = tangents(X.p, w.state.velocity)
    turned = [tangents(row, w.state.velocity) for row in X.R]
    spin = [
        w.graph.total(a * b for a, b in zip(x, y, strict=True))
        for x, y in ((turned[2], X.R[1]), (turned[0], X.R[2]), (turned[1], X.R[0]))
    ]
    powers = [
        w.graph.total(a * b for a, b in zip((*F, *N), (*velocity, *spin), strict=True)) for F, N in cut.wrenches(X)
    ]
    residual = cut.residual(X)
    rates = tangents(residual, w.state.velocity)
    zeros = tuple([w.graph.zero] * len(residual))
    claims = [
        Claim("closed", "residual", "0", tuple(substitute(residual, back)), zeros),
        Claim("rates", "residual", "power", tuple(substitute(rates, back)), tuple(substitute(powers, back))),
    ]

    assert set() < {f.verdict for f in prove(on_unit_sphere(scene, claims))[1]} <= {Verdict.PROVED, Verdict.NUMERICAL}


MECHANISMS = [crank_rocker, symbolic_four_bar, slider_crank, rssr, bricard, lambda: n_four_bar(2)]
NAMES = ["crank_rocker", "symbolic_four_bar", "slider_crank", "rssr", "bricard", "two_four_bars"]


@pytest.mark.heavy("rssr")
@pytest.mark.long
@pytest.mark.parametrize("make", MECHANISMS, ids=NAMES)
def test_both_derivations_of_a_closed_mechanism_agree_and_keep_the_laws(make: Callable[[], Scene]) -> None:
    scene = make()
    outputs, _ = available(scene)
    w = Workspace(scene)
    claims = [*agreements(w, outputs), *laws(w, outputs)]

    assert {"forward_dynamics", "inverse_dynamics", "multipliers"} <= set(outputs)
    findings = prove(on_unit_sphere(scene, [claim for claim in claims if claim.left]))[1]
    not_proved = {f.claim for f in findings if f.verdict != Verdict.PROVED}
    assert not_proved <= {"positions: residual = 0"}  # roots of something variable have no sign in a field
    assert not [f for f in findings if f.verdict not in (Verdict.PROVED, Verdict.NUMERICAL)]


def test_a_sign_error_in_the_bias_breaks_the_proof(monkeypatch: pytest.MonkeyPatch) -> None:
    swing = kinematics._swing
    monkeypatch.setattr(kinematics, "_swing", lambda omega, alpha, d: tuple(-x for x in swing(omega, alpha, d)))
    w = Workspace(crank_rocker())
    one, other = (
        derive_one(w, "forward_dynamics", formulation) for formulation in formulations_of("forward_dynamics", w.scene)
    )

    assert prove([Claim("fd", "a", "b", one.entries, other.entries)])[1][0].verdict == Verdict.DIFFERENT


def test_baumgarte_pulls_a_loop_back() -> None:
    scene, closing = crank_rocker(), LoopChoices(alpha=Fraction(5), beta=Fraction(7))
    w = Workspace(scene, closing)
    outputs = ("forward_dynamics", "constraint_jacobian", "constraint_bias")
    (finding,) = prove(laws(w, outputs))[1]
    assert finding.verdict == Verdict.PROVED
    assert "Baumgarte" in finding.claim

    q = w.loops.decisions.assembly.q
    off = np.array([q[0], q[1] + 0.01, q[2]])  # at rest, open: G qdd = -beta^2 r
    G, r = lambdify(scene, ("constraint_jacobian", "constraint_residual"))
    forward = run_python(emit(lower(derive(scene, ("forward_dynamics",), closing=closing)), "numpy")).forward_dynamics
    assert G(off) @ forward(off, np.zeros(3), np.zeros(3)) == pytest.approx(-49 * r(off), rel=1e-12)


def test_a_users_independent_coordinate_changes_no_acceleration() -> None:
    scene = crank_rocker()
    w = Workspace(scene)
    plain = derive_one(w, "forward_dynamics").entries
    other = derive_one(Workspace(scene, LoopChoices(independent=("q_D",))), "forward_dynamics").entries

    assert other != plain
    assert prove([Claim("fd", "crank", "rocker", plain, other)])[1][0].verdict == Verdict.PROVED
    with pytest.raises(DerivationError, match="q_A, q_B given, but it has 1 degree of freedom"):
        derive(scene, ("forward_dynamics",), closing=LoopChoices(independent=("q_A", "q_B")))
    with pytest.raises(DerivationError, match="there is no velocity 'q_X'"):
        derive(scene, ("forward_dynamics",), closing=LoopChoices(independent=("q_X",)))


def test_an_independent_coordinate_that_determines_nothing_is_refused() -> None:
    scene = n_four_bar(1)
    free = replace(scene.joints[0], name="pendulum", child="bob", coordinates=("q_bob",))
    scene = replace(
        scene,
        bodies=(*scene.bodies, Body("bob", Quantity.ONE, (Quantity.ONE, Quantity.ZERO, Quantity.ZERO))),
        joints=(*scene.joints, free),
    )

    with pytest.raises(DerivationError, match="q_A0, q_B1 do not determine the other velocities"):
        derive(scene, ("forward_dynamics",), closing=LoopChoices(independent=("q_A0", "q_B1")))


def test_a_massless_coupler_is_no_obstacle_but_a_massless_motion_is() -> None:
    scene = crank_rocker()
    crank, _, rocker = scene.bodies
    light = replace(scene, bodies=(crank, Body("coupler"), rocker))
    w = Workspace(light)
    one, other = (
        derive_one(w, "forward_dynamics", formulation) for formulation in formulations_of("forward_dynamics", light)
    )
    assert prove([Claim("fd", "a", "b", one.entries, other.entries)])[1][0].verdict == Verdict.PROVED

    nothing = replace(scene, bodies=tuple(Body(body.name) for body in scene.bodies))
    with pytest.raises(DerivationError, match="the joint A, which carries crank, moves no mass"):
        derive(nothing, ("forward_dynamics",))
    outputs, left_out = available(nothing)
    assert "forward_dynamics" not in outputs
    assert any("moves no mass" in reason for reason in left_out)


def test_outputs_of_loops_are_refused_for_a_tree() -> None:
    scene = random_tree(2)

    assert not any(OUTPUTS[name].when_constrained == "only" for name in available(scene)[0])
    with pytest.raises(DerivationError, match="of which random2 has none"):
        derive(scene, ("multipliers",))


def test_planar_loops_on_oblique_axes_keep_two_rows_and_the_plane() -> None:
    """The same four-bar, tilted: no row vanishes as it is written, but rank leaves two."""
    flat_one = crank_rocker()
    tilted = compose(("Rx", exact("2/5")), ("Ry", exact("-1/3")))
    joints = tuple(
        replace(joint, origin=compose(*tilted.steps, *joint.origin.steps)) if joint.parent == "ground" else joint
        for joint in flat_one.joints
    )
    turned = replace(
        flat_one, joints=joints, loops=(flat_one.loops[0].shaped(axis=(Quantity.ZERO, Quantity.ZERO, exact(2))),)
    )
    state = assemble(turned)

    assert state.rank == 2
    assert state.q == pytest.approx(assemble(flat_one).q)


def test_positions_close_the_loop_through_a_full_turn_and_at_the_folds() -> None:
    """Crank 1, coupler 3, rocker 7/2, ground 4: crank and ground are longest apart, and closest, at π and 0."""
    scene = crank_rocker()
    positions, residual = lambdify(scene, ("positions", "constraint_residual"))
    q = positions(np.linspace(-4, 4, 81)[:, None])

    assert np.abs(residual(q)).max() < 1e-14
    assert positions([0.8]) == pytest.approx(assemble(scene).q)
    rocking = four_bar(*(exact(x) for x in ("3", "1", "3/2", "4")), (Quantity.ONE,) * 3, ("1/5", "1/2", "2"))  # type: ignore[arg-type]
    fold = float(np.arccos((9 + 16 - 2.5**2) / 24))  # coupler and rocker in line
    near = fold - 1e-12
    q = lambdify(rocking, "positions")(np.array([near]))
    assert np.abs(lambdify(rocking, "constraint_residual")(q)).max() < 1e-14


def test_positions_close_a_planar_loop_whose_bodies_lie_in_planes_one_above_the_other() -> None:
    flat = crank_rocker()
    rise = exact("3/10")
    tree = tuple(
        replace(joint, origin=Pose((*joint.origin.steps, ("Tz", rise)))) if joint.name == "B" else joint
        for joint in flat.joints
    )
    (loop,) = flat.loops
    raised = replace(loop, tip=Pose((*loop.tip.steps, ("Tz", Quantity.number(-1) * rise))))
    layered = replace(flat, joints=tree, loops=(raised,))
    q = np.linspace(-4, 4, 21)[:, None]

    assert lambdify(layered, "positions")(q) == pytest.approx(lambdify(flat, "positions")(q), abs=1e-14)
    assert np.abs(lambdify(layered, "constraint_residual")(lambdify(layered, "positions")(q))).max() < 1e-14


def test_a_loop_that_leaves_its_plane_has_no_positions_of_a_planar_one() -> None:
    scene = read_text(OBLIQUE)

    with pytest.raises(DerivationError, match="a loop does not stay in a plane"):
        lambdify(scene, "positions")


OBLIQUE = """
[bodies.b1]
mass = 1
[bodies.b2]
mass = 1
[joints.j1]
type = "revolute"
parent = "ground"
child = "b1"
[joints.j2]
type = "cylindrical"
parent = "b1"
child = "b2"
drive = false
start = [1, -0.7]
[[loop]]
type = "point_on_line"
parent = "b1"
child = "b2"
origin = [["Tx", 1], ["Tz", 0.5], ["Ry", 0.4], ["Rx", 0.4]]
tip = [["Tx", 1.5], ["Tz", -1.2], ["Ty", 0.4]]
"""


def test_velocities_and_accelerations_fit_a_numeric_motion() -> None:
    """Differences of the closed form against velocities and accelerations of the rows: G, its bias and their signs."""
    scene = slider_crank()
    positions, velocities, forward, inverse = lambdify(
        scene, ("positions", "velocities", "forward_dynamics", "inverse_dynamics")
    )
    step, q, rate = 1e-4, 0.5, 1.3
    before, here, after = (positions([q + k * step * rate]) for k in (-1, 0, 1))
    u = velocities(here, [rate])
    assert u == pytest.approx((after - before) / (2 * step), abs=1e-7)

    ahead = (after - 2 * here + before) / step**2  # at a steady crank
    tau = inverse(here, u, ahead)
    assert tau[1:] == pytest.approx(0)
    assert forward(here, u, tau) == pytest.approx(ahead, abs=1e-6)
    assert consistent(scene, assemble(scene), {"q_A_dot": rate}) == pytest.approx(u, abs=1e-12)


def test_over_driven_and_opposed_drives_have_their_own_messages() -> None:
    scene = crank_rocker()
    a, b, d = scene.joints
    both = replace(scene, joints=(a, b, replace(d, drives=("tau2",))))

    with pytest.raises(
        DerivationError, match=r"over-actuated, 2 drives \(tau of A, tau2 of D\) for 1 degree of freedom"
    ):
        derive(both, ("inverse_dynamics",))
    outputs, left_out = available(both)
    assert "inverse_dynamics" not in outputs
    assert "forward_dynamics" in outputs
    assert any("over-actuated" in reason for reason in left_out)

    twice = n_four_bar(1)
    pendulum = replace(twice.joints[0], name="P", child="bob", coordinates=("q_bob",))
    joints = (
        replace(twice.joints[0], drives=("t0",)),
        twice.joints[1],
        replace(twice.joints[2], drives=("t1",)),
        pendulum,
    )
    opposed = replace(
        twice,
        bodies=(*twice.bodies, Body("bob", Quantity.ONE, (Quantity.ONE, Quantity.ZERO, Quantity.ZERO))),
        joints=joints,
    )
    with pytest.raises(DerivationError, match=r"the drives t0 of \w+, t1 of \w+ work against each other"):
        derive(opposed, ("inverse_dynamics",))


def led_five_bar() -> Scene:
    """Two freedoms: crank A follows a formula in t, crank E is driven; a spring and a damper act beside them."""
    flat_one = crank_rocker()
    a, b, d = flat_one.joints
    wave = folding.function(Op.SIN, folding.mul(Quantity.number(2), Quantity.symbol("t")))
    joints = (
        replace(a, motion=wave),
        b,
        replace(d, name="E", coordinates=("q_E",), drives=("tau2",), origin=along_x(exact(5)), start=(exact("5/2"),)),
        replace(b, name="F", parent="rocker", child="link", coordinates=("q_F",),
                origin=along_x(exact("7/2")), start=(exact("1/2"),)),
    )  # fmt: skip
    link = replace(flat_one.bodies[1], name="link")
    loop = replace(flat_one.loops[0], child="link", tip=compose(("Tx", exact(-3))))
    spring = Spring("s", joint="B", stiffness=(exact(3), exact("1/2")), free=exact("1/5"))
    return replace(
        flat_one, name="five_bar", bodies=(*flat_one.bodies, link), joints=joints, loops=(loop,), elements=(spring,)
    )


def test_a_prescribed_motion_in_a_loop_leads_and_takes_what_it_takes() -> None:
    scene = led_five_bar()
    outputs, _ = available(scene)
    w = Workspace(scene)
    claims = [*agreements(w, outputs), *laws(w, outputs)]

    assert {"drive_forces", "forward_dynamics", "inverse_dynamics", "multipliers"} <= set(outputs)
    findings = prove([claim for claim in claims if claim.left])[1]
    assert {f.claim for f in findings if f.verdict != Verdict.PROVED} == {"positions: residual = 0"}
    qdd = derive_one(w, "forward_dynamics").entries
    assert qdd[0] is w.prescribed.acceleration[0]


def test_prescribed_motions_that_the_loops_do_not_allow_are_refused() -> None:
    scene = crank_rocker()
    a, b, d = scene.joints
    both = replace(scene, joints=(replace(a, motion=Quantity.symbol("t")), b, replace(d, motion=Quantity.symbol("t"))))

    with pytest.raises(DerivationError, match="the loops do not let the joints A, D follow their prescribed motions"):
        derive(both, ("forward_dynamics",))
