"""Laws of mechanics over small scenes with names and over seeded random trees: proved, and looked at in numbers."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest
from arms import cart_pole, chain, puma560, spatial_arm, two_link
from mechanisms import COUPLED, TREES, random_tree, whole_tree
from oracles import BIG
from running import agreements, call, matrix, random_fractions, workspace

from symdyn.algebra.numeric import Batches, Floats
from symdyn.dynamics import OUTPUTS, derive, derive_one, expected, formulations_of
from symdyn.dynamics.outputs.arm_outputs import ARMS as ANGLES
from symdyn.dynamics.recursive.crba import crba, crba_in_runs
from symdyn.errors import DerivationError
from symdyn.graph import Op, reachable
from symdyn.scene import Quantity, Scene, body, prismatic, read_text, revolute, scene
from symdyn.verdict import Verdict
from symdyn.verify.certificate import on_unit_sphere
from symdyn.verify.equality import Claim, prove
from symdyn.verify.laws import laws

ARMS = [two_link(), cart_pole(), spatial_arm(), chain(3)]
SCENES = [*ARMS, *TREES, *COUPLED]


def by_name(one):
    return one.name


def str_or_name(one):
    return getattr(one, "name", one)


def test_random_trees_have_every_kind_of_joint_and_angle():
    kinds = {joint.type for tree in TREES for joint in tree.joints}
    torques = [derive(tree, ["inverse_dynamics"])["inverse_dynamics"].entries for tree in TREES]
    nodes = [node for entries in torques for node in reachable(entries)]
    roots = {node.args[0].value for node in nodes if node.op is Op.SQRT}
    angles = {node.args[0].value for node in nodes if node.op is Op.SIN}

    assert kinds == {"revolute", "prismatic", "fixed"}
    assert {2, 3, 14} <= roots  # 45° or axis (1, 1, 0); 30° and 60°; axis (1, 2, 3)
    assert {"beta", Fraction(3, 10)} <= angles  # a parameter; 0.3 rad


@pytest.mark.wide("two_link", "coupled4")
@pytest.mark.long
@pytest.mark.parametrize("one", SCENES, ids=by_name)
def test_all_formulations_of_all_outputs_are_proved_equal(one):
    claims = agreements(workspace(one), [*expected(one, "request"), *kinematics(one)])
    empty = {claim.name for claim in claims if not claim.left}  # k_C of one coordinate
    findings = prove(on_unit_sphere(one, [claim for claim in claims if claim.left]))[1]

    assert {finding.claim for finding in findings if finding.verdict != Verdict.PROVED} == set()
    assert empty <= {"k_C"}
    several = {
        name.partition(":")[0] for name, row in OUTPUTS.items() if row.exists_in(one) and len(row.formulations) > 1
    }
    assert {finding.claim.split(":")[0] for finding in findings} == several - empty


@pytest.mark.parametrize("seed", [3, 11, 15, 22, 25, 35])
def test_formulations_agree_where_ratios_are_one_by_chance(seed):
    findings = prove(agreements(workspace(whole_tree(seed)), ["inverse_dynamics", "forward_dynamics"]))[1]

    assert {finding.claim for finding in findings if finding.verdict != Verdict.PROVED} == set()


def kinematics(one):
    """Return every kinematic output of the last body, and of one in the middle; `test_arm_outputs.py` has angles."""
    names = dict.fromkeys((one.bodies[-1].name, one.bodies[len(one.bodies) // 2].name))
    every = [name for name, row in OUTPUTS.items() if row.place in ("body", "point") and name not in ANGLES]
    return [f"{name}:{place}" for place in names for name in every]


@pytest.mark.wide(4)
@pytest.mark.long
@pytest.mark.parametrize("one", SCENES, ids=by_name)
def test_every_law_is_proved(one):
    findings = prove(on_unit_sphere(one, laws(workspace(one), expected(one, "request"))))[1]

    assert len(findings) == 25 + sum(OUTPUTS[f"zero_dynamics{led}"].exists_in(one) for led in ("", ":passive"))
    assert {finding.claim for finding in findings if finding.verdict != Verdict.PROVED} == set()


# In numbers


def a_state(one, seed):
    """Return a random state; parameters are positive, as masses and lengths are."""
    rng, n = random.Random(seed), len(one.coordinates)
    state = {name: random_fractions(rng, n) for name in ("q", "qd", "qdd", "tau")}
    return {**state, "params": [abs(x) for x in random_fractions(rng, len(one.free_parameters))]}


def floats(state):
    return {name: [float(x) for x in values] for name, values in state.items()}


@pytest.mark.parametrize("one", [*SCENES, puma560()], ids=by_name)
def test_mass_matrix_is_symmetric_positive_definite(one):
    equations, n = derive(one, ["mass_matrix"]), len(one.coordinates)
    for seed in range(5):
        M = np.array(matrix(call(equations, "mass_matrix", Floats(), **floats(a_state(one, seed))), n))

        assert np.array_equal(M, M.T)
        np.linalg.cholesky(M)  # raises for anything that is not positive definite


@pytest.mark.wide(2)
@pytest.mark.parametrize("one", [*TREES, *COUPLED], ids=by_name)
def test_coriolis_matrix_leaves_a_skew_remainder(one):
    """Ṁ by a central difference in big floats along q̇, apart from all differentiation on the graph."""
    equations, n = derive(one, ["mass_matrix", "coriolis_matrix"]), len(one.coordinates)
    state = {name: [BIG.constant(x) for x in values] for name, values in a_state(one, 3).items()}
    h = BIG.number("1e-20")

    def mass(step):
        moved = [q + step * v for q, v in zip(state["q"], state["qd"], strict=True)]
        return call(equations, "mass_matrix", BIG, **{**state, "q": moved})

    rates = [(a - b) / (2 * h) for a, b in zip(mass(h), mass(-h), strict=True)]
    C = matrix(call(equations, "coriolis_matrix", BIG, **state), n)
    S = [[rates[n * i + j] - 2 * C[i][j] for j in range(n)] for i in range(n)]

    assert all(abs(S[i][j] + S[j][i]) < 1e-30 for i in range(n) for j in range(n))
    assert any(abs(S[i][j]) > 1e-3 for i in range(n) for j in range(n)) or n == 1


@pytest.mark.wide(8)
@pytest.mark.long
@pytest.mark.parametrize(
    ("one", "formulation"),
    [(one, formulation) for one in SCENES for formulation in formulations_of("forward_dynamics", one)],
    ids=str_or_name,
)
def test_forward_dynamics_inverts_inverse_dynamics(one, formulation):
    state = {name: [BIG.constant(x) for x in values] for name, values in a_state(one, 5).items()}
    tau = call(derive(one, ["inverse_dynamics"]), "inverse_dynamics", BIG, **state)

    back = call(derive(one, ["forward_dynamics"], formulation), "forward_dynamics", BIG, **{**state, "tau": tau})

    assert all(abs(a - b) < 1e-40 for a, b in zip(back, state["qdd"], strict=True))


@pytest.mark.wide(2)
@pytest.mark.parametrize("one", SCENES, ids=by_name)
def test_power_in_is_the_rate_of_energy(one):
    """Energy is differenced along the motion q + q̇ t + q̈ t²/2; dampers take damping · (rate of their joint)²."""
    equations = derive(one, ["inverse_dynamics", "kinetic_energy", "potential_energy"])
    state = {name: [BIG.constant(x) for x in values] for name, values in a_state(one, 7).items()}
    h = BIG.number("1e-18")

    def energy(t):
        motion = list(zip(state["q"], state["qd"], state["qdd"], strict=True))
        moved = {"q": [q + v * t + a * t * t / 2 for q, v, a in motion], "qd": [v + a * t for _, v, a in motion]}
        there = {**state, **moved}
        return sum(call(equations, name, BIG, **there)[0] for name in ("kinetic_energy", "potential_energy"))

    tau = call(equations, "inverse_dynamics", BIG, **state)
    power = sum(t * v for t, v in zip(tau, state["qd"], strict=True)) - dissipation(one, state)

    assert abs((energy(h) - energy(-h)) / (2 * h) - power) < 1e-30 * (1 + abs(power))


def dissipation(one, state):
    """Return the power that dampers take."""
    rates = dict(zip(one.coordinates, state["qd"], strict=True))
    known = dict(zip((p.name for p in one.free_parameters), state["params"], strict=True))
    total = BIG.constant(Fraction(0))
    for joint in one.joints:
        if joint.damping != Quantity.number(0):
            led = joint.coupling.ratios if joint.coupling else ((joint.coordinate, Quantity.ONE),)
            factors = ((known.get(ratio.value) or BIG.constant(ratio.value), rates[name]) for name, ratio in led)
            total += BIG.constant(joint.damping.value) * sum(factor * rate for factor, rate in factors) ** 2
    return total


@pytest.mark.parametrize("one", TREES[:3], ids=by_name)
def test_a_batch_of_states_is_its_states_one_by_one(one):
    equations = derive(one, ["forward_dynamics"])
    states = [floats(a_state(one, seed)) for seed in range(4)]
    batch = {name: list(np.array([state[name] for state in states]).T) for name in states[0]}

    together = np.array(np.broadcast_arrays(*call(equations, "forward_dynamics", Batches(), **batch)))

    for k, state in enumerate(states):
        alone = call(equations, "forward_dynamics", Floats(), **state)
        assert np.allclose(together[:, k], alone, rtol=1e-12)


# Gravity


def dropped(axis, gravity=None):
    joints = [prismatic("fall", "ground", "stone", axis=axis)]
    return scene("dropped", bodies=[body("stone", mass=3, com=["1/2", 1, 2])], joints=joints, gravity=gravity)


@pytest.mark.parametrize("formulation", formulations_of("forward_dynamics"))
@pytest.mark.parametrize(
    ("axis", "gravity", "expected"),
    [
        ([0, 0, 1], None, "-9.81"),
        ([0, 0, -1], None, "9.81"),
        ([1, 0, 0], None, "0"),
        ([0, 1, 0], [0, "9.81", 0], "9.81"),
        ([0, 3, -4], None, "7.848"),
    ],
)
def test_a_dropped_body_falls_at_g(formulation, axis, gravity, expected):
    (qdd,) = derive(dropped(axis, gravity), ["forward_dynamics"], formulation)["forward_dynamics"].entries
    graph = qdd.graph
    drive = graph.symbol("tau[0]")

    fall = Claim("fall", "qdd", "g + F/m", (qdd,), (graph.constant(Fraction(expected)) + drive / 3,))
    assert prove([fall])[1][0].verdict == Verdict.PROVED


def test_holding_a_body_up_takes_its_weight():
    (tau,) = derive(dropped([0, 0, 1]), ["gravity_forces"])["gravity_forces"].entries

    assert tau.value == 3 * Fraction("9.81")


@pytest.mark.parametrize("formulation", formulations_of("forward_dynamics"))
def test_a_horizontal_rod_begins_to_fall_with_three_halves_of_g_over_l(formulation):
    rod = scene(
        "rod",
        bodies=[body("rod", mass=2, com=["1/2", 0, 0], inertia=[0, "1/6", "1/6"], about="com")],  # m l²/12, l = 1
        joints=[revolute("pin", "ground", "rod", axis=[0, -1, 0])],
    )
    found = call(derive(rod, ["forward_dynamics"], formulation), "forward_dynamics", BIG, q=[0], qd=[0], tau=[0])

    assert abs(found[0] + BIG.number("14.715")) < 1e-40  # positive lifts the rod


@pytest.mark.parametrize("formulation", formulations_of("gravity_forces"))
@pytest.mark.parametrize("one", TREES[:3], ids=by_name)
def test_without_gravity_no_gravity_term_is_left_in_the_graph(one, formulation):
    weightless = one.with_gravity((Quantity.number(0),) * 3)
    forces = derive(weightless, ["gravity_forces"], formulation)["gravity_forces"].entries

    assert all(entry.is_zero for entry in forces)
    (P,) = derive(weightless, ["potential_energy"])["potential_energy"].entries
    assert P.is_zero


# Growth and refusal


@pytest.mark.long
@pytest.mark.parametrize("name", ["inverse_dynamics", "forward_dynamics", "mass_matrix"])
def test_a_tree_of_thirty_joints_is_derived(name):
    tree = random_tree(5, n=30)

    assert all(entry.graph.nodes for entry in derive(tree, [name])[name].entries)


@pytest.mark.parametrize("formulation", formulations_of("forward_dynamics"))
def test_a_massless_tip_has_no_forward_dynamics(formulation):
    arm = scene(
        "massless",
        bodies=[body("heavy", mass=1, com=[1, 0, 0]), body("nothing")],
        joints=[revolute("a", "ground", "heavy"), revolute("b", "heavy", "nothing")],
    )
    with pytest.raises(DerivationError, match="a motion of the joint b, which carries nothing, moves no mass"):
        derive(arm, ["forward_dynamics"], formulation)


BESIDE = """
name = "beside"
[bodies.heavy]
mass = 1
com = [0.1, 0, 0]
inertia = [0.02, 0.03, 0.04]
inertia_about = "com"
[bodies.tip]
particles = [{ mass = 1, at = [0, 0, 1] }]
[joints.arm]
type = "revolute"
parent = "ground"
child = "heavy"
axis = [0, 1, 0]
%s
[joints.socket]
type = "spherical"
parent = "heavy"
child = "tip"
"""


@pytest.mark.parametrize("more", ["", 'motion = "2*t"'], ids=["tree", "prescribed"])
def test_a_body_that_spins_without_inertia_is_named_though_its_joint_has_three_velocities(more):
    with pytest.raises(DerivationError, match=r"beside: .* the joint socket, which carries tip, moves no mass"):
        derive(read_text(BESIDE % more), ["forward_dynamics"])


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ("inverse", "there is no output 'inverse'; did you mean inverse_dynamics"),
        ("pose", "pose needs a point; write pose:NAME"),
        ("mass_matrix:link1", "mass_matrix is about the whole scene"),
        ("pose:link9", "there is no body or point 'link9'; did you mean link2. .there are link1, link2"),
        ("com_acceleration:end", "there is no body 'end'"),
    ],
)
def test_an_unknown_output_or_place_is_named(request_, message):
    with pytest.raises(DerivationError, match=message):
        derive(two_link(), [request_])


def test_an_unknown_formulation_is_named():
    with pytest.raises(DerivationError, match="mass_matrix has no formulation 'aba'; there are crba, lagrange"):
        derive(two_link(), ["mass_matrix"], "aba")


SHELF = """
name = "shelf"
[dh]
convention = "modified"
[[dh.links]]
alpha = "pi/3"
mass = 2
com = [0.1, 0.2, 0.3]
inertia = { xx = 3, yy = 4, zz = 5 }
inertia_about = "com"
[[dh.links]]
a = 0.5
d = 0.7
mass = 3
com = [0.3, -0.1, 0.2]
inertia = { xx = 1, yy = 2, zz = 2, xy = 0.1 }
inertia_about = "com"
[[dh.links]]
a = 0.4
d = 0.6
mass = 5
com = [0.2, 0.3, -0.4]
inertia = { xx = 2, yy = 2, zz = 3, yz = 0.2 }
inertia_about = "com"
[[dh.links]]
type = "prismatic"
a = 0.3
mass = 7
com = [0.6, 0.1, 0.5]
inertia = { xx = 2, yy = 3, zz = 3, xz = 0.3 }
inertia_about = "com"
"""


FIRST = "[[dh.links]]\nmass = 1\ncom = [0.2, 0.1, 0.3]\n"
SWIVEL = SHELF.replace("[[dh.links]]", f"{FIRST}[[dh.links]]", 1) + f'{FIRST}a = 0.2\nalpha = "pi/4"\n'
"""The shelf between two oblique axes."""


def stairs() -> Scene:
    """Three parallel axes; the shifts between them have two parameters each, and no length that is one."""
    places = [[], [("Tx", "a"), ("Ty", "b"), ("Tz", "1/3")], [("Tx", "b"), ("Ty", "a"), ("Tz", "1/5")]]
    bodies = [body(f"b{k}", mass=k + 1, com=["1/3", "1/5", "1/7"]) for k in range(3)]
    joints = [
        revolute(f"j{k}", f"b{k - 1}" if k else "ground", f"b{k}", origin=place) for k, place in enumerate(places)
    ]
    return scene("stairs", parameters=dict.fromkeys(("a", "b")), bodies=bodies, joints=joints)


def fork() -> Scene:
    """Two parallel axes between oblique ones; a second child has lifted the frame that the first one turns in."""
    joints = [
        revolute("j0", "ground", "b0", axis=[1, 0, 0]),
        revolute("j1", "b0", "b1", origin=[("Ty", "3/10"), ("Tz", "1/5")]),
        revolute("j2", "b1", "b2", origin=[("Tx", "1/2"), ("Tz", "7/10")]),
        revolute("j3", "b2", "b3", origin=[("Tx", "3/10"), ("Tz", "1/5")], axis=[1, 0, 0]),
        revolute("j4", "b1", "b4", origin=[("Ty", "2/5"), ("Tz", "11/10")], axis=[0, 1, 0]),
    ]
    return scene("fork", bodies=[body(f"b{k}", mass=k + 1, com=["1/3", "1/5", "1/7"]) for k in range(5)], joints=joints)


def test_a_run_of_parallel_axes_may_have_a_shift_along_them():
    reduced = workspace(fork()).reduced
    (k,) = (k for k in reduced.outward() if reduced.parent[k] and not reduced.X[k].fixed)

    assert not reduced.X[k].shift[2].is_zero


@pytest.mark.parametrize("way", [crba, crba_in_runs])
@pytest.mark.parametrize(
    "one", [read_text(SHELF), read_text(SWIVEL), stairs(), fork()], ids=["shelf", "swivel", "stairs", "fork"]
)
def test_every_variant_of_the_composite_body_algorithm_is_right(one, way):
    """Not only the cheapest: parallel axes beside and above each other, a slide, a branch or another axis at an end."""
    w = workspace(one)
    entries = [entry for row in way(w.reduced) for entry in row]
    other = derive_one(w, "mass_matrix", "lagrange").entries

    assert {f.verdict for f in prove([Claim("M", "crba", "lagrange", entries, other)])[1]} == {Verdict.PROVED}
