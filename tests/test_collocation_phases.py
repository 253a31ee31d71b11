"""Collocation through contacts: optima in closed form, impacts beside their formula, and runs that follow."""

from __future__ import annotations

import pickle
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contact_scenes import sliders
from scipy.optimize import minimize_scalar

import symdyn
from symdyn.errors import SimulateError
from symdyn.scene.toml import read_text
from symdyn.transcription import Collocation, Solution, along
from symdyn.transcription.solution import lagrangian

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long]
IPOPT = pytest.mark.targets  # it comes with CasADi

EXAMPLES = Path(__file__).parent.parent / "examples"

G = 9.81

BALL = 'name = "ball"\n' + sliders("z", of="mass = 2", z='drive = "F"\nstart = 1')
BALL += '[contacts.floor]\nbody = "b"\nrestitution = 0.5\n'

JUGGLER = """
name = "juggler"
[bodies]
hand = { mass = 1 }
ball = { mass = 0.2 }
[joints]
h = { type = "prismatic", parent = "ground", child = "hand", axis = [0, 0, 1], coordinate = "h", drive = "F" }
b = { type = "prismatic", parent = "ground", child = "ball", axis = [0, 0, 1], coordinate = "b", drive = false }
[contacts.palm]
type = "gap"
gap = "b - h"
"""

ROD = 'name = "rod"\n' + sliders("xz", of="", x="drive = false", z="drive = false\nstart = 0.8")
ROD += """
[bodies.rod]
mass = 2
inertia = [0.1, 0.1, 0.1]
[joints.t]
type = "revolute"
parent = "b"
child = "rod"
axis = [0, 1, 0]
coordinate = "t1"
drive = "M"
start = 0.3
[contacts.tip]
body = "rod"
at = [0, 0, -0.5]
friction = 2
"""

BLOCK = 'name = "block"\n' + sliders("xz", "m1", "mass = 2", x='drive = "F"', z="drive = false")
BLOCK += '[contacts.sole]\nbody = "m1"\nfriction = 0.3\n'

CART = f"""
name = "cart"
[bodies.m1]
mass = 2
[joints.rail]
type = "prismatic"
parent = "ground"
child = "m1"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
friction = {{ coulomb = {0.6 * G} }}
limits = {{ lower = -1, upper = 2, restitution = 0 }}
"""


def switches(found: Solution) -> list[int]:
    """Return the last row of each phase but the last."""
    return np.flatnonzero(np.diff(found.run.t) == 0).tolist()


def bounce() -> tuple[Collocation, float, float]:
    """Return the least ∫ F² from a height over the floor to another, and what it is in closed form: cost, velocity.

    Where F is that of a double integrator, z'' = F/m - g, from (0, a) to (d, b) in T it is linear in time, and
    ∫ (F/m)² = 12 (d' - (a' + b') T/2)²/T³ + (b' - a')²/T with what the weight adds taken off.
    """

    def least(d: float, a: float, b: float, T: float) -> float:
        d, b = d + G * T * T / 2, b + G * T
        return 4.0 * (12 * (d - (a + b) * T / 2) ** 2 / T**3 + (b - a) ** 2 / T)

    phases = [{"duration": 0.7}, {"strikes": "floor"}]
    problem = symdyn.collocation(read_text(BALL), 1.6, 4, cost="F**2", end={"z": 0.7}, phases=phases)
    best = minimize_scalar(lambda v: least(-1, 0, v, 0.7) + least(0.7, -0.5 * v, 0, 0.9))
    return problem, best.fun, best.x


@pytest.fixture(scope="module")
def bounced() -> Solution:
    return bounce()[0].solve()


@IPOPT
def test_a_bounce_of_least_effort_is_the_closed_form(bounced):
    _, cost, v = bounce()
    (impact,) = bounced.impacts
    before, after = (bounced.run["z_dot"][switches(bounced)[0] + k] for k in (0, 1))

    assert bounced.objective == pytest.approx(cost, rel=1e-9)
    assert impact.before == pytest.approx(v, rel=1e-7)
    assert (impact.t, impact.contact, impact.what) == (0.7, "floor", "strikes")
    assert (before, after) == pytest.approx((impact.before, -0.5 * impact.before), rel=1e-9)
    assert impact.impulse == pytest.approx((-2 * 1.5 * impact.before,), rel=1e-9)
    assert impact.lost == pytest.approx(0.75 * impact.before**2, rel=1e-9)
    assert impact.words.startswith("floor strikes at t = 0.7 s, -4.32978 to 2.16489 m/s")


@IPOPT
def test_a_run_under_the_forces_goes_through_the_impact(bounced):
    again = bounced.simulated(rtol=1e-11)

    assert again.complete
    assert [one.what for one in again.impacts] == ["strikes"]
    assert again.impacts[0].before == pytest.approx(bounced.impacts[0].before, rel=1e-8)
    assert again["z"][-1] == pytest.approx(0.7, abs=1e-8)
    assert {*bounced.run.names} <= {*again.names}


@IPOPT
def test_phases_are_parts_of_the_run(bounced):
    first, second = bounced.phases

    assert (first.t[0], first.t[-1], second.t[-1]) == pytest.approx((0, 0.7, 1.6))
    assert np.array_equal(np.concatenate([first["z"], second["z"]]), bounced.run["z"])
    assert first["gap_floor"] == pytest.approx(first["z"])
    assert not first["normal_floor"].any()
    assert not second["mode_floor"].any()


@IPOPT
def test_a_free_time_of_the_impact_is_where_effort_is_least():
    free = symdyn.collocation(read_text(BALL), 1.6, 6, cost="F**2", end={"z": 0.7}, phases=[{}, {"strikes": "floor"}])
    found = free.solve()
    around = []
    for more in (-0.02, 0.02):
        fixed = [{"duration": found.impacts[0].t + more}, {"strikes": "floor"}]
        around.append(symdyn.collocation(read_text(BALL), 1.6, 6, cost="F**2", end={"z": 0.7}, phases=fixed).solve())

    assert found.success
    assert all(one.success and one.objective > found.objective for one in around)


@pytest.mark.parametrize("method", ["hermite_simpson", "implicit_midpoint"])
def test_derivatives_are_those_of_differences(method):
    phases = [{"intervals": 2}, {"closed": "tip", "strikes": "tip", "intervals": 1, "end": {"t1": 0.1}}]
    phases.append({"slips": {"tip": -1}, "intervals": 2})
    problem = symdyn.collocation(
        read_text(ROD), (0.5, 2), method=method, cost="M**2*x", path={"z*t1_dot": 9, "x": 3}, free=(), phases=phases
    )
    random = np.random.default_rng(3)
    z, weights = problem.guess + 0.1 * random.standard_normal(problem.size), random.standard_normal(problem.rows)
    of, step = lagrangian(problem), 1e-6
    H = np.zeros((problem.size, problem.size))
    H[of.rows, of.columns] = of.values(z, 0.7, weights)
    sides = [
        np.stack([f(z + step * e) - f(z - step * e) for e in np.eye(problem.size)], axis=-1) / (2 * step)
        for f in (
            problem.residual,
            problem.objective,
            lambda z: 0.7 * problem.gradient(z) + problem.jacobian(z).T @ weights,
        )
    ]

    assert problem.jacobian(z).toarray() == pytest.approx(sides[0], abs=1e-6)
    assert problem.gradient(z) == pytest.approx(sides[1], abs=1e-6)
    assert np.triu(sides[2]) == pytest.approx(H, abs=1e-5)


@pytest.fixture(scope="module")
def fallen() -> Solution:
    phases = [{}, {"closed": "tip", "strikes": "tip", "duration": (0.2, 0.5)}]
    rod = read_text(ROD)
    problem = symdyn.collocation(
        rod, (0.1, 1.5), 8, cost="M**2", end={"t1": 0}, start_rates={"x": 0.3}, bounds={"t1": 1}, phases=phases
    )
    return problem.solve()


@IPOPT
def test_the_impact_is_that_of_the_formula(fallen):
    (k,), run = switches(fallen), fallen.run
    formula = symdyn.load(fallen.scene, ["impact:tip"]).impact_tip(run.q[k], run.qd[k])

    assert np.append(run.qd[k + 1], fallen.impacts[0].impulse) == pytest.approx(formula, abs=1e-8)


@IPOPT
def test_a_run_strikes_and_sticks_as_was_found(fallen):
    again = fallen.simulated(rtol=1e-10)

    assert [one.mode for one in again.impacts] == [("sticks",)]
    assert again.impacts[0].impulse == pytest.approx(fallen.impacts[0].impulse, rel=1e-7)
    assert again.impacts[0].lost == pytest.approx(fallen.impacts[0].lost, rel=1e-7)
    assert again.q[-1] == pytest.approx(fallen.run.q[-1], abs=1e-6)


@IPOPT
def test_what_is_closed_keeps_the_laws_of_contact(fallen):
    run, closed = fallen.run, fallen.run["mode_tip"] == 1

    assert 0 < closed.sum() < len(closed)
    assert np.abs(run["gap_tip"][closed][::2]).max() < 1e-8
    assert run["gap_tip"].min() > -1e-7
    assert not run["normal_tip"][~closed].any()
    assert np.all(np.abs(run["friction_tip"]) <= 2 * run["normal_tip"] + 1e-7)


@pytest.mark.parametrize("text", [BLOCK, CART], ids=["contact", "joint"])
@IPOPT
def test_a_block_is_pushed_as_the_closed_form_says(text):
    """F = μ m g + m a slides it by 1 m: T⁴ = 36 (m/(μ m g))², and the cost is 4/3 (μ m g)² T."""
    name = "sole" if text == BLOCK else "rail_friction"
    phases = [
        {"closed": name, "duration": (0.1, 1)}, {"slips": {name: 1}, "duration": (0.1, 1.9)}, {"closed": name}
    ]  # fmt: skip
    found = symdyn.collocation(read_text(text), 2, 6, cost="F**2", end={"x": 1}, phases=phases).solve()
    again, takes = found.simulated(rtol=1e-10), sqrt(6 / (0.3 * G))

    assert found.phases[1].t[-1] - found.phases[1].t[0] == pytest.approx(takes, rel=1e-6)
    assert found.objective == pytest.approx(4 / 3 * (0.6 * G) ** 2 * takes, rel=1e-7)
    assert [one.what for one in found.impacts] == ["slips", "sticks"]
    assert [one.what for one in again.impacts][-1] == "sticks"
    assert found.run[f"mode_{name}"][len(found.phases[0].t)] == 2
    assert again.q[-1] == pytest.approx(found.run.q[-1], abs=1e-6)


@IPOPT
def test_what_slips_the_other_way_inside_of_intervals_is_told():
    """Signs hold at ends of intervals alone: a way back along a slip that goes forth was solved with success."""
    there = [{"slips": {"sole": 1}}], [{"slips": {"sole": -1}}]
    wrong, right = (
        symdyn.collocation(read_text(BLOCK), 1, 4, cost="F**2", end={"x": -0.5}, phases=one).solve() for one in there
    )
    told = [note for note in wrong.notes if "sole slips the other way inside of an interval of phase 1: give" in note]
    assert told
    assert told[0] in wrong.run.notes
    assert not any("inside of an interval" in note for note in right.notes)


@IPOPT
def test_a_ball_is_thrown_and_caught():
    phases = [
        {"closed": "palm", "duration": (0.1, 0.6)}, {"duration": 0.5},
        {"closed": "palm", "strikes": "palm", "duration": (0.1, 0.6)},
    ]  # fmt: skip
    problem = symdyn.collocation(
        read_text(JUGGLER), 1.2, 6, cost="F**2", end={"h": 0}, bounds={"h": (-0.3, 0.3)}, phases=phases
    )
    found = pickle.loads(pickle.dumps(problem)).solve()
    again = found.simulated(rtol=1e-10)

    assert [one.what for one in found.impacts] == ["lifts off", "strikes"]
    assert [one.what for one in again.impacts] == ["lifts off", "strikes"]
    assert [one.t for one in again.impacts] == pytest.approx([one.t for one in found.impacts], abs=1e-6)
    assert again.impacts[1].impulse == pytest.approx(found.impacts[1].impulse, rel=1e-5)
    assert again.q[-1] == pytest.approx([0, 0], abs=1e-6)


@IPOPT
def test_a_closed_mechanism_bounces_off_a_stop():
    """All of it is struck: multipliers of the loop have impulses."""
    text = (EXAMPLES / "four_bar.toml").read_text()
    stop = "limits = { lower = -2, upper = 1.2, restitution = 0.5 }"
    scene = read_text(text.replace('drive = "M"', f'drive = "M"\n{stop}'))
    phases = [{"duration": (0.1, 1.4)}, {"strikes": "motor_upper"}]
    found = symdyn.collocation(scene, 1.5, 25, cost="M**2", end={"phi": 0.9}, phases=phases).solve()
    again = found.simulated(rtol=1e-10)

    assert [one.words.split(" at ")[0] for one in again.impacts] == ["motor_upper strikes"]
    assert again.impacts[0].impulse == pytest.approx(found.impacts[0].impulse, rel=1e-3)
    assert found.impacts[0].after == pytest.approx(-0.5 * found.impacts[0].before)
    assert again.q[-1] == pytest.approx(found.run.q[-1], abs=1e-3)


@pytest.mark.parametrize(
    ("text", "given", "words"),
    [
        (ROD, {}, 'there is tip; say which are closed in each phase, such as phases=[{"closed": "tip"}, {}]'),
        (ROD, {"phases": []}, "there is none in the list; leave phases out"),
        (
            ROD.partition("[contacts")[0],
            {"phases": [{}]},
            "there is no contact, stop or dry friction; leave phases out",
        ),
        (ROD, {"phases": [{"closed": "top"}]}, "phases: 1: top is no contact of rod; did you mean tip"),
        (ROD, {"phases": [{"close": "tip"}]}, "phases: 1: close is no key of a phase; did you mean closed"),
        (ROD, {"phases": [{"closed": "tip", "slips": {"tip": 1}}]}, "tip cannot both stick and slip"),
        (ROD, {"phases": [{"slips": "tip"}]}, "say which way tip slips"),
        (ROD, {"phases": [{"strikes": "tip", "closed": "tip"}]}, "tip strikes at the start, which is given whole"),
        (ROD, {"phases": [{}, {"strikes": "tip"}]}, "tip has no restitution: where it strikes it is closed"),
        (BALL, {"phases": [{}, {"strikes": "floor", "closed": "floor"}]}, "floor has a restitution: where it strikes"),
        (
            ROD.replace("friction = 2", "friction = 2\nrestitution = 0.5"),
            {"phases": [{}, {"strikes": "tip"}]},
            "tip bounces with friction: say how it leaves",
        ),
        (BALL, {"phases": [{"slips": {"floor": 1}}]}, "floor has no friction, so that nothing slips or sticks"),
        (BALL, {"phases": [{}], "cost": "t*F**2"}, "phases know no motions, forces and formulas over time t"),
        (CART, {"phases": [{}]}, "rail_friction sticks or slips always: name it in closed"),
        (CART, {"phases": [{"closed": "rail_friction"}, {"strikes": "rail_friction"}]}, "which strikes nothing"),
        (BALL, {"phases": [{"duration": (2, 1)}]}, "is no time after the start"),
        (BALL, {"phases": [{}, {"duration": "x"}]}, "phases: 2: duration = x is no time after the start"),
        (BALL, {"phases": [{"duration": 0.7}, {"duration": 0.7}]}, "durations are 1.4 s together, and until is 1 s"),
        (BALL, {"phases": [{"end": 3}]}, 'end = 3: give coordinates, such as {"z": 1}'),
        (BALL, {"phases": [{"end": {"y": 3}}]}, "end: y is not known"),
    ],
)
def test_what_phases_do_not_know_is_refused(text: str, given: dict[str, Any], words: str):
    with pytest.raises(SimulateError) as told:
        symdyn.collocation(read_text(text), 1, 3, **given)
    assert words in str(told.value)


@pytest.mark.parametrize(
    ("start", "closed", "words"), [(-0.2, "", "a contact is below its plane"), (0.2, "floor", "loops do not close")]
)
@IPOPT
def test_a_start_off_its_phase_is_told(start, closed, words):
    problem = symdyn.collocation(read_text(BALL), 1, 3, start={"z": start}, phases=[{"closed": closed}])
    with pytest.raises(SimulateError, match=words):
        problem.solve()


@IPOPT
def test_an_end_off_its_phase_is_told_by_the_phase():
    """Its time is a guess while durations are free: t = 1.001 s was told of a motion of 1 s."""
    problem = symdyn.collocation(read_text(BALL), 1, 3, end={"z": -1}, phases=[{}, {"strikes": "floor"}])
    with pytest.raises(SimulateError, match="what is given at 1 of phase 2 contradicts itself, by 1: a contact is bel"):
        problem.solve()


ROPE = 'name = "rope"\n' + sliders("z", z='drive = "F"\nstart = -0.5')
ROPE += '[ropes.r]\ntype = "slack"\nthrough = [{ body = "ground" }, { body = "b" }]\nlength = 1\n'


@IPOPT
def test_a_rope_becomes_taut_as_in_a_run():
    phases = [{}, {"closed": "r", "duration": (0.1, 1)}]
    found = symdyn.collocation(read_text(ROPE), 1.5, 5, cost="F**2", end={"z": -1}, phases=phases).solve()
    again = found.simulated(rtol=1e-10)

    assert [one.what for one in found.impacts] == [one.what for one in again.impacts] == ["becomes taut"]
    assert again.impacts[0].t == pytest.approx(found.impacts[0].t, abs=1e-8)
    assert again.impacts[0].impulse == pytest.approx(found.impacts[0].impulse, rel=1e-7)


SPACE = 'name = "space"\n' + sliders("xyz", x='drive = "U"', y='drive = "V"', z='drive = "W"\nstart = 0.3')
SPACE += '[contacts.floor]\nbody = "b"\nfriction = 0.5\n'


@IPOPT
def test_what_may_slip_any_way_sticks_in_a_round_cone():
    given = {"start_rates": {"x": 0.4, "y": -0.2}, "phases": [{}, {"closed": "floor"}]}
    found = symdyn.collocation(read_text(SPACE), 1.0, 5, cost="U**2 + V**2 + W**2", **given).solve()
    again, (normal, *push) = found.simulated(rtol=1e-10), found.impacts[0].impulse

    assert np.linalg.norm(push) <= 0.5 * normal + 1e-7
    assert [one.mode for one in again.impacts] == [("sticks",)]
    assert again.impacts[0].impulse == pytest.approx(found.impacts[0].impulse, abs=1e-6)
    with pytest.raises(SimulateError, match="floor may slip along two directions, and a phase knows slips along one"):
        symdyn.collocation(read_text(SPACE), 1.0, 5, phases=[{"slips": {"floor": 1}}])


@IPOPT
def test_what_has_no_cost_and_no_bends_is_solved():
    phases = [{"duration": 0.7}, {"duration": 0.3, "strikes": "floor"}]
    found = symdyn.collocation(read_text(BALL), 1, 4, phases=phases).solve()

    assert found.success
    assert found.violation < 1e-7


@IPOPT
def test_a_solution_is_a_guess_for_the_next(bounced):
    again = bounced.problem.solve(guess=bounced.z)

    assert again.objective == pytest.approx(bounced.objective, rel=1e-9)
    assert again.iterations <= bounced.iterations
    with pytest.raises(SimulateError, match="no smooth curve goes through impacts between phases; give the z"):
        along(bounced.problem, bounced.run)


LEG = 'name = "leg"\n' + sliders("xz", "lift", "", x="drive = false", z="drive = false\nstart = 0.6")
LEG += """
[bodies.trunk]
mass = 10
inertia = [0.2, 0.2, 0.2]
[bodies.thigh]
[bodies.foot]
mass = 1
inertia = [0.01, 0.01, 0.01]
[joints.pitch]
type = "revolute"
parent = "lift"
child = "trunk"
axis = [0, 1, 0]
coordinate = "theta"
drive = false
[joints.hip]
type = "revolute"
parent = "trunk"
child = "thigh"
axis = [0, 1, 0]
coordinate = "phi"
drive = "M"
[joints.leg]
type = "prismatic"
parent = "thigh"
child = "foot"
axis = [0, 0, -1]
coordinate = "l"
drive = "F"
start = 0.6
limits = { lower = 0.3, upper = 0.8, effort = 400 }
[contacts.toe]
body = "foot"
friction = 0.8
"""
"""It hops by a hip and a leg that grows longer, and is a free body in a plane else."""


@pytest.mark.slow
def test_a_leg_hops_as_a_run_under_its_forces_does():
    scene = read_text(LEG)
    stands = {"closed": "toe", "duration": (0.1, 0.6)}
    found = symdyn.collocation(
        scene, (0.3, 2), 20, cost="F**2/1e4 + M**2/1e2", end={"x": 0.4, "theta": 0, "phi": 0, "l": 0.6},
        bounds={"theta": 0.7, "phi": 1, "z": (0.2, 1.5)}, phases=[stands, {"duration": (0.05, 0.6)}, stands],
    ).solve(max_iter=1000)  # fmt: skip
    again, (_, k), run = found.simulated(rtol=1e-10), switches(found), found.run
    lifts, strikes = (next(one for one in again.impacts if one.what == what) for what in ("lifts off", "strikes"))
    formula = symdyn.load(scene, ["impact:toe"]).impact_toe(run.q[k], run.qd[k])

    assert found.success
    assert np.append(run.qd[k + 1], found.impacts[1].impulse) == pytest.approx(formula, abs=1e-6)
    assert (lifts.t, strikes.t) == pytest.approx([one.t for one in found.impacts], abs=1e-3)
    assert strikes.impulse == pytest.approx(found.impacts[1].impulse, rel=1e-2)
