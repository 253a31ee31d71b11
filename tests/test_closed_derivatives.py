"""Derivatives of closed scenes along the manifold: against neighbours at sixty digits, and against each other."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from closed_mechanisms import bricard, crank_rocker, exact, four_bar, symbolic_four_bar
from closed_neighbours import Neighbours
from small_steps import BIG, Numbers, apart
from test_centre_of_mass import FLYER

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.dynamics import LoopChoices, Workspace, derive_one, formulations_of
from symdyn.dynamics.mechanism.cost import operations
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, tangents
from symdyn.linear import linearize
from symdyn.scene import Scene, read_text
from symdyn.verdict import Verdict
from symdyn.verify import Claim, certify, prove
from symdyn.verify.certificate import on_unit_sphere

pytestmark = pytest.mark.long

DATA, EXAMPLES = Path(__file__).parent / "data", Path(__file__).parent.parent / "examples"

LED = """
name = "five_bar"
gravity = [0, -9.81, 0]
[bodies.left]
mass = 1
com = [0.5, 0, 0]
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[bodies.near]
mass = 2
com = [0.7, 0.1, 0]
inertia = [0.1, 0.4, 0.4]
inertia_about = "com"
[bodies.right]
mass = 1.5
com = [0.4, 0, 0]
inertia = [0.1, 0.2, 0.2]
inertia_about = "com"
[bodies.far]
mass = 1
com = [0.6, 0, 0]
inertia = [0.1, 0.3, 0.3]
inertia_about = "com"
[joints.a]
type = "revolute"
parent = "ground"
child = "left"
axis = [0, 0, 1]
motion = "0.4*sin(3*t) + 1.9"
start = 1.9
[joints.b]
type = "revolute"
parent = "left"
child = "near"
axis = [0, 0, 1]
origin = [1, 0, 0]
drive = false
start = -0.9
[joints.c]
type = "revolute"
parent = "ground"
child = "right"
axis = [0, 0, 1]
origin = [1.5, 0, 0]
start = 1.1
damping = 0.3
[joints.d]
type = "revolute"
parent = "right"
child = "far"
axis = [0, 0, 1]
origin = [1, 0, 0]
drive = false
start = 1.1
[[loop]]
name = "tip"
type = "revolute"
parent = "near"
child = "far"
axis = [0, 0, 1]
origin = [1.4, 0, 0]
tip = [1.3, 0, 0]
[springs.s]
joint = "c"
stiffness = 40
free = 0.5
"""

HUNG = """
name = "hung"
[bodies.plate]
mass = 2
com = [0.1, 0.05, -0.02]
inertia = [0.03, 0.05, 0.06]
inertia_about = "com"
[joints.flight]
type = "free"
parent = "ground"
child = "plate"
drive = false
[[loop]]
name = "ball"
type = "spherical"
parent = "ground"
child = "plate"
tip = [0.3, 0.1, 0]
"""


def scene(name: str) -> Scene:
    return symdyn.read(
        next(path for path in (EXAMPLES, DATA / "contacts", DATA / "found") if (path / f"{name}.toml").exists())
        / f"{name}.toml"
    )


HARD: dict[str, Callable[[], Neighbours]] = {
    **{
        name: lambda name=name: Neighbours(scene(name))  # type: ignore[misc]
        for name in (
            "four_bar", "slider_crank", "spatial_slider_crank", "rssr", "rsup", "governor", "rolling_disc",
            "cart_with_wheel", "skate",
        )
    },
    "motion prescribed": lambda: Neighbours(read_text(LED)),
    "body hung up by a ball": lambda: Neighbours(read_text(HUNG)),
    "ball on a turntable": lambda: Neighbours(scene("turntable")),
    "rows redundant": lambda: Neighbours(bricard()),
    "angles": lambda: Neighbours(scene("rolling_disc_zxy")),
    "parameters free": lambda: Neighbours(symbolic_four_bar()),
    "stabilised": lambda: Neighbours(crank_rocker(), LoopChoices(alpha=Fraction(5), beta=Fraction(7))),
    "another choice": lambda: Neighbours(scene("four_bar"), LoopChoices(independent=("chi",))),
}  # fmt: skip


STILL = ("four_bar", "body hung up by a ball", "angles")
LONG = ("slider_crank", "rows redundant", "rssr", "spatial_slider_crank", "rsup", "governor", "skate", "rolling_disc")
CASES = [
    *(pytest.param(name, False, marks=[pytest.mark.slow] if name in LONG else []) for name in HARD),
    *((name, True) for name in STILL),
]


@pytest.mark.long(0)
@pytest.mark.wide(3)
@pytest.mark.parametrize(("name", "still"), CASES)
def test_derivatives_are_differences_of_neighbours_on_the_manifold(name: str, still: bool) -> None:
    near = HARD[name]()
    q, v, tau, a = near.drawn(still=still)
    for output, last, argument in [
        ("forward_dynamics", tau, "tau"),
        ("multipliers", tau, "tau"),
        ("inverse_dynamics", a, "qdd"),
    ]:
        columns = near.differences(near.entries(output), q, v, last, argument)
        function = derive_one(near.w, f"{output}_derivatives")
        found = near.values(function.entries, near.state(q, v, last, argument))
        expected = [x for row in zip(*columns, strict=True) for x in row]
        assert function.shape == (len(columns[0]), len(columns))
        off = max(abs(x - y) for x, y in zip(found, expected, strict=True))
        assert off < 1e-28 * (1 + max(map(abs, expected))), output


@pytest.mark.parametrize(
    ("name", "by"), [("parameters free", "a"), ("parameters free", "m2"), ("rolling_disc_zxy", "r")]
)
def test_dependent_positions_and_velocities_move_with_parameters_too(name: str, by: str) -> None:
    near = HARD[name]() if name in HARD else Neighbours(scene(name))
    q, v, tau, a = near.drawn()
    symbol, h = near.w.graph.symbol(by), near.mp.mpf("1e-20")
    given = near.parameters[symbol]
    for output, last, argument in (("forward_dynamics", tau, "tau"), ("inverse_dynamics", a, "qdd")):
        ends = []
        for value in (given + h, given - h):
            near.parameters[symbol] = value
            ends.append(near.values(near.entries(output), near.state(near.closed(q), v, last, argument)))
        near.parameters[symbol] = given
        expected = [(there - here) / (2 * h) for there, here in zip(*ends, strict=True)]
        known = near.state(q, v, last, argument)
        for formulation in ("forward", "lagrange"):
            found = near.values(derive_one(near.w, f"{output}_by_{by}", formulation).entries, known)
            off = max(abs(x - y) for x, y in zip(found, expected, strict=True))
            assert off < 1e-28 * (1 + max(map(abs, expected))), (output, formulation)


PARALLELOGRAM = (exact(1), exact(2), exact(1), exact(2), (exact(1), exact(2), exact(1)))


@pytest.mark.parametrize(
    ("one", "start"),
    [
        (lambda: scene("slider_crank"), (0.0, 0.0, 1.0)),  # straight, which the crank's angle can pass
        (lambda: four_bar(*PARALLELOGRAM, ("1", "-1", "1")), (1.0, -1.0, 1.0)),  # equal angles
        (lambda: four_bar(*PARALLELOGRAM, ("1", "-1", "1")), (np.pi / 2, -np.pi / 2, np.pi / 2)),  # upright
    ],
    ids=["dead centre", "equal angles", "upright"],
)
def test_natural_positions_are_differentiated_as_others(one: Callable[[], Scene], start: Sequence[float]) -> None:
    near = Neighbours(one())
    q = near.closed([near.mp.mpf(x) for x in start])
    _, v, tau, _ = near.drawn()
    expected = np.array(near.differences(near.entries("forward_dynamics"), q, v, tau, "tau"), dtype=float).T
    function = derive_one(near.w, "forward_dynamics_derivatives")
    found = np.array(near.values(function.entries, near.state(q, v, tau, "tau")), dtype=float)
    assert found.reshape(function.shape) == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max())


def test_a_folded_four_bar_is_told_to_have_none() -> None:
    folded = four_bar(*PARALLELOGRAM, ("0", "0", "0"))
    w = Workspace(folded)
    assert any("change point" in note for note in w.loops.decisions.assembly.notes)
    function = derive_one(w, "forward_dynamics_derivatives")
    assert "independent positions are q_A, velocities q_A_dot; no number where these do not" in function.text
    with np.errstate(all="ignore"):
        code = symdyn.lambdify(folded, "forward_dynamics_derivatives", target="numpy")
        assert not np.isfinite(code(np.zeros(3), np.zeros(3), np.zeros(3))).all()


@pytest.mark.parametrize(
    ("name", "request_", "words"),
    [
        ("four_bar", "forward_dynamics_hessian", "where loops .* no forward_dynamics_hessian; there .*_jvp"),
        ("four_bar", "velocities_by_qd", "velocities takes q, ui"),
        ("two_link", "motion_residual_jvp", "about closed loops and rows, of which two_link has none"),
        ("four_bar", "motion_residual_jvp_by_q", "of motion_residual there are .*_hessian, .*_by_multipliers"),
        ("two_link", "motion_residual", "about closed loops and rows, of which two_link has none"),
        ("two_link", "forward_dynamics_unprojected_derivatives", "about closed loops and rows"),
        ("two_link", "positions_derivatives", "about closed loops and rows"),
    ],
)
def test_what_a_scene_lacks_is_told(name: str, request_: str, words: str) -> None:
    with pytest.raises(DerivationError, match=words):
        derive_one(Workspace(scene(name)), request_)


def test_drives_that_are_too_many_have_no_derivatives_either() -> None:
    driven = replace(
        crank_rocker(), joints=tuple(replace(one, drives=(f"u_{one.name}",)) for one in crank_rocker().joints)
    )
    with pytest.raises(DerivationError, match="over-actuated, 3 drives"):
        derive_one(Workspace(driven), "inverse_dynamics_derivatives")


def test_unsolved_equations_have_every_word_as_an_output_of_the_full_state_has() -> None:
    """What optimisation along a motion of a closed scene takes: weighted second derivatives, against differences."""
    n = Numbers(Workspace(read_text(HUNG)))
    function = n.function("motion_residual_hessian")
    rng = random.Random(3)
    state = {one.name: [BIG.number(rng.uniform(-1, 1)) for _ in one.symbols] for one in function.arguments}
    state["q"][3:] = [BIG.context.mpf(x) / 10 for x in (1, 1, 7, 7)]
    ways = [(one.name, k) for one in function.arguments[:5] for k in range(6 if one.name == "q" else len(one.symbols))]
    assert function.shape == (len(ways), len(ways)) == (27, 27)
    J, H = n.at("motion_residual_derivatives", state), n.at("motion_residual_hessian", state)
    for j in range(len(ways)):
        slopes = n.slope("motion_residual", state, *ways[j])
        assert apart(J[j :: len(ways)], slopes) < 1e-20
        assert apart(H[j :: len(ways)], n.slope("motion_residual_vjp", state, *ways[j])) < 1e-20


# The same linear system, however it is asked for


def other_choice(near: Neighbours) -> tuple[str, ...]:
    """Return names of independent velocities that share as few as can be with those of a workspace."""
    w, m = near.w, len(near.partition.independent)
    G = w.loops.numbers.jacobian(np.array(w.loops.decisions.assembly.q))[list(w.loops.decisions.independent_rows)]

    def worst(chosen: tuple[int, ...]) -> float:
        return float(np.linalg.svd(np.delete(G, chosen, axis=1), compute_uv=False)[-1])

    every = [c for c in combinations(range(w.state.n), m) if worst(c) > 0.05]
    chosen = min(every, key=lambda c: (len(set(c) & set(near.partition.independent)), -round(worst(c), 6)))
    return tuple(w.scene.velocities[k] for k in chosen)


def change(one: Neighbours, other: Neighbours) -> tuple[list[Expr], list[Expr]]:
    """Return P of x' = P x row by row, and its rate, from the states of one choice to those of another."""
    w, p, m = one.w, len(one.position_partition.independent), len(one.partition.independent)
    places, speeds = (derive_one(w, f"{name}_derivatives").entries for name in ("positions", "velocities"))
    P = [x for k in other.position_partition.independent for x in (*places[k * p : (k + 1) * p], *[w.graph.zero] * m)]
    P += [x for k in other.partition.independent for x in speeds[k * (p + m) : (k + 1) * (p + m)]]
    return P, tangents(P, w.state.acceleration)


def matrix(near: Neighbours, entries: Sequence[Any], columns: int) -> Any:
    """Return entries as a matrix of mpmath."""
    return near.mp.matrix([list(entries[k : k + columns]) for k in range(0, len(entries), columns)])


CHOSEN = ("four_bar", "slider_crank", "rssr", "rsup", "rolling_disc", "cart_with_wheel")


@pytest.mark.wide(3)
@pytest.mark.parametrize(
    "name", [*CHOSEN, pytest.param("spatial_slider_crank", marks=pytest.mark.slow), "body hung up by a ball"]
)
def test_another_choice_of_coordinates_and_another_formulation_give_the_same_linear_system(name: str) -> None:
    one = HARD[name]()
    other = Neighbours(one.w.scene, LoopChoices(independent=other_choice(one)))
    assert one.partition.independent != other.partition.independent

    (A, B), (A2, B2), P, dP = state_space(one, other, moving=True)
    assert size(A2 * P - P * A - dP) < 1e-25 * (1 + size(A2) * size(P))
    assert size(B2 - P * B) < 1e-25 * (1 + size(B2))

    (A, B), (A2, B2), P, dP = state_space(one, other, moving=False)
    assert size(dP) < 1e-50  # at rest, and in equilibrium under the forces that hold it there
    assert size(A2 * P - P * A) < 1e-25 * (1 + size(A2) * size(P))
    polynomials = [np.poly(np.array(x.tolist(), dtype=float)) for x in (A, A2)]  # whose roots the eigenvalues are
    assert polynomials[0] == pytest.approx(polynomials[1], rel=1e-7, abs=1e-7 * np.abs(polynomials[0]).max())


def state_space(one: Neighbours, other: Neighbours, moving: bool) -> Any:
    """Return A and B by two choices and two formulations at one state, P and its rate."""
    q, v, tau, _ = one.drawn(still=not moving)
    if not moving:
        q = one.drawn()[0]
        rest = one.state(q, v, [one.mp.mpf(0)] * len(v), "qdd")
        tau = one.values(one.entries("inverse_dynamics"), rest)
    known = one.state(q, v, tau, "tau")
    known |= dict(zip(one.w.state.qdd, one.values(one.entries("forward_dynamics"), known), strict=True))
    P, dP = (one.values(entries, known) for entries in change(one, other))
    n = len(one.position_partition.independent) + len(one.partition.independent)
    found = []
    for near, formulation in ((one, "implicit"), (other, "lagrange")):
        here = {near.w.graph.symbol(str(node.value)): x for node, x in known.items()}
        AB = matrix(
            one, near.values(derive_one(near.w, "state_matrices", formulation).entries, here), n + near.w.state.n
        )
        found.append((AB[:, :n], AB[:, n:]))
    return *found, matrix(one, P, n), matrix(one, dP, n)


def size(of: Any) -> Any:
    """Return the largest entry."""
    return max(map(abs, of))


@pytest.mark.parametrize("name", ["heavy_top", "free_body"])
def test_displacements_move_as_coordinates_do(name: str) -> None:
    w = Workspace(scene(name))
    n, H, rates = w.state.n, w.directions.along, w.state.rates
    top = derive_one(w, "state_matrices").entries[: 3 * n * n]
    found, expected = [], []
    for a in range(2 * n):
        moved = tangents(rates, H[a] if a < n else {w.state.qd[a - n]: w.graph.one})
        turned = (
            tangents([H[a].get(q, w.graph.zero) for q in w.state.q], w.state.velocity) if a < n else w.zeros[:1] * 99
        )
        for q, rate, turning in zip(w.state.q, moved, turned, strict=False):
            found.append(w.graph.total(top[3 * n * k + a] * H[k][q] for k in range(n) if q in H[k]))
            expected.append(rate - turning)
    claim = Claim("H dxi/dt", "state matrices", "coordinates", tuple(found), tuple(expected))
    assert [one.verdict for one in prove(on_unit_sphere(w.scene, [claim]))[1]] == [Verdict.PROVED]


def test_the_benchmark_bicycle_at_five_metres_a_second() -> None:
    w = Workspace(symdyn.read(DATA / "contacts" / "bicycle.toml"))
    q, names = w.loops.decisions.assembly.q, list(w.scene.velocities)
    given = {names.index("lean_dot"): 0.0, names.index("steer_dot"): 0.0, names.index("rear_turn_dot"): 5 / 0.3}
    u = w.loops.numbers.fitting_rates(np.array(q), given).tolist()
    known = w.loops.values(q) | dict(zip(w.state.qd, u, strict=True)) | dict.fromkeys(w.state.tau, 0.0)
    function = derive_one(w, "state_matrices")
    A = np.array(evaluate(function.entries, Floats(), known)).reshape(function.shape)[:, : function.shape[0]]
    table = [-14.07838969279822, -0.77534188219585 - 4.46486771378823j, -0.77534188219585 + 4.46486771378823j,
             -0.32286642900409]  # fmt: skip
    assert np.sort_complex(np.linalg.eigvals(A)) == pytest.approx(np.array([*table, *[0] * 6]), abs=1e-7)


@pytest.mark.parametrize("name", ["four_bar", "rssr", "rolling_disc", "heavy_top"])
def test_state_matrices_are_what_linearize_eliminates_in_numbers(name: str) -> None:
    there = linearize(scene(name), anywhere=True)
    closing = LoopChoices(independent=there.states.names[there.positions :] if there.scene.is_constrained else ())
    w = Workspace(scene(name), closing)
    known = (
        w.loops.values(there.point.q) if w.scene.is_constrained else dict(zip(w.state.q, there.point.q, strict=True))
    )
    known |= {x: float(v) for x, v in zip(w.state.qd, there.point.u, strict=True)}
    known |= {x: float(v) for x, v in zip(w.state.tau, there.point.tau, strict=True)}
    function = derive_one(w, "state_matrices")
    found = np.array(evaluate(function.entries, Floats(), known)).reshape(function.shape)
    place = [function.labels[1].index(one) for one in there.states.names]
    assert found[:, : len(place)][np.ix_(place, place)] == pytest.approx(there.A, abs=1e-11)


# Pinocchio


def held_to_the_ground(state: dict[str, Any], point: Sequence[float]) -> Scene:
    """Return the robot of `pinocchio_closed_derivatives` where a state has it."""
    starts = {"trunk": state["q"][:7], "arm": state["q"][7:11], "hand": state["q"][11]}
    text = FLYER
    for body, start in starts.items():
        text = text.replace(f'child = "{body}"\n', f'child = "{body}"\nstart = {start}\n')
    tip = [-x for x in point]
    foot = f'origin = {state["anchor"]}\ntip = {tip}\nname = "foot"\ntype = "spherical"\n'
    return read_text(f'{text}[[loop]]\n{foot}parent = "ground"\nchild = "hand"\n')


@pytest.mark.long(0)
@pytest.mark.parametrize("number", [0, 3])
def test_a_robot_held_to_the_ground_has_pinocchios_derivatives(number: int) -> None:
    facts = json.loads((DATA / "closed_derivatives_pinocchio.json").read_text(encoding="utf-8"))
    state = facts["states"][number]
    w = Workspace(held_to_the_ground(state, facts["point"]))
    s = w.state
    known = {x: value for name in ("q", "qd", "tau") for x, value in zip(getattr(s, name), state[name], strict=True)}

    def ours(request: str) -> np.ndarray:
        function = derive_one(w, request)
        return np.array(evaluate(function.entries, Floats(), known)).reshape(function.shape)

    slopes, speeds = ours("positions_derivatives"), ours("velocities_derivatives")
    p, m = slopes.shape[1], speeds.shape[1] - slopes.shape[1]
    ends = np.zeros((s.n, s.n))
    along = np.block([[slopes, np.zeros((s.n, m)), ends], [speeds, ends], [np.zeros((s.n, p + m)), np.eye(s.n)]])
    force = np.array(state["force_derivatives"])
    theirs = np.array(state["forward_dynamics"])
    assert ours("forward_dynamics") == pytest.approx(np.array(state["qdd"]), abs=1e-11)
    assert ours("multipliers") == pytest.approx(np.array(state["multipliers"]), abs=1e-11)
    assert ours("forward_dynamics_derivatives") == pytest.approx(theirs @ along, abs=1e-10)
    assert ours("multipliers_derivatives") == pytest.approx(force @ along, abs=1e-10)
    assert ours("forward_dynamics_unprojected_derivatives") == pytest.approx(theirs, abs=1e-10)


# Formulations, and what they cost


ASKED = ("forward_dynamics", "multipliers", "inverse_dynamics")


def proved(w: Workspace, requests: Sequence[str]) -> set[str]:
    claims = []
    for request in requests:
        first, *rest = (derive_one(w, request, formulation) for formulation in formulations_of(request, w.scene))
        claims += [Claim(request, "one", other.formulation, first.entries, other.entries) for other in rest]
    return {one.verdict for one in prove(on_unit_sphere(w.scene, claims))[1]}


@pytest.mark.parametrize("name", ["four_bar", "cart_with_wheel", "skate"])
def test_formulations_are_proved_equal_off_the_manifold_too(name: str) -> None:
    blocks = [
        "forward_dynamics_by_tau",
        "inverse_dynamics_by_qdd",
        "velocities_by_ui",
        "motion_residual_by_multipliers",
    ]
    whole = [f"{one}_derivatives" for one in (*ASKED, "velocities", "positions", "motion_residual")]
    free = [f"{one}_unprojected_derivatives" for one in ASKED]
    products = [f"{one}_{way}" for one in ASKED for way in ("jvp", "vjp")]
    asked = [*whole, *blocks, *free, *products, "motion_residual", "state_matrices"]
    assert proved(Workspace(scene(name)), asked) == {Verdict.PROVED}


@pytest.mark.parametrize(
    ("name", "request_"),
    [
        pytest.param("rolling_disc", "state_matrices", marks=pytest.mark.slow),
        ("rssr", "inverse_dynamics_derivatives"),
        ("rsup", "multipliers_vjp"),
    ],
)
def test_formulations_of_what_rolls_and_turns_are_proved_equal(name: str, request_: str) -> None:
    assert proved(Workspace(scene(name)), [request_]) == {Verdict.PROVED}


@pytest.mark.parametrize("name", ["motion prescribed", "stabilised"])
def test_formulations_are_proved_equal_with_motions_and_baumgartes_terms(name: str) -> None:
    asked = ["forward_dynamics_unprojected_derivatives", "state_matrices", "multipliers_vjp", "forward_dynamics_by_t"]
    assert proved(HARD[name]().w, asked) == {Verdict.PROVED}


def test_formulations_to_derivatives_by_a_length_are_proved_equal() -> None:
    assert proved(Workspace(symbolic_four_bar()), ["forward_dynamics_by_a"]) == {Verdict.PROVED}


@pytest.mark.usefixtures("numpy_alone")
def test_code_of_what_takes_directions_weights_and_multipliers_is_certified() -> None:
    asked = ["forward_dynamics_jvp", "multipliers_vjp", "motion_residual_by_multipliers", "velocities_derivatives"]
    found = certify(scene("four_bar"), asked)
    assert found.passed
    assert {one.function for one in found.accuracy} == set(asked)


def multiplications(w: Workspace, request: str) -> int:
    function = derive_one(w, request)
    varying = [symbol for argument in function.arguments for symbol in argument.symbols]
    return Counter(operations(function.entries, varying))["multiplications"]


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "governor", "rolling_disc"])
def test_products_with_derivatives_cost_less_than_three_times_the_function(name: str) -> None:
    w = Workspace(scene(name))
    for output in ("forward_dynamics", "multipliers"):
        for way in ("jvp", "vjp"):
            assert multiplications(w, f"{output}_{way}") <= 2.83 * multiplications(w, output), (output, way)


@pytest.mark.parametrize(
    ("request_", "most"),
    [("forward_dynamics_unprojected_derivatives", (208, 139, 2)), ("state_matrices", (192, 126, 2))],
)
def test_what_the_four_bar_costs(request_: str, most: tuple[int, ...]) -> None:
    """Forward differentiation takes 232, 144 and 5; what a partition solves is differentiated for less."""
    w = Workspace(scene("four_bar"))
    counted = Counter(operations(derive_one(w, request_).entries, (*w.state.q, *w.state.qd, *w.state.tau)))
    assert (counted["multiplications"], counted["additions"], counted["divisions"]) <= most
