"""Optimal motions: optimality of what IPOPT found once, and IPOPT itself where CasADi is installed.

`pytest tests/test_collocation_solved.py --update-golden` solves again and writes tests/data/optimal_motions.json.
"""

from __future__ import annotations

import json
import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.errors import SimulateError
from symdyn.simulation import Start
from symdyn.transcription import Collocation, Solution

pytestmark = pytest.mark.runs("cc")

ROOT = Path(__file__).parent.parent
GOLDEN = Path(__file__).parent / "data" / "optimal_motions.json"
SWING = symdyn.read(ROOT / "benchmarks" / "data" / "swing_up.toml")
FIVE = symdyn.read(ROOT / "benchmarks" / "data" / "five_bar.toml")

PONTRYAGIN = 58.807667458
"""Cost of the swing-up by the minimum principle, as `python benchmarks/swing_up.py` prints it."""


def swing_up(intervals: int, method: str = "hermite_simpson", **more) -> Collocation:
    end = {"end": {"q1": 1, "q2": "pi"}, "end_rates": {"q1": 0, "q2": 0}}
    return symdyn.collocation(SWING, 2, intervals, method, cost="u**2", **end, **more)


def line(intervals: int) -> Collocation:
    start = {"q1": 2.5972485047095892, "q2": 1.2913215826173419, "q3": -1.633337088591388, "q4": 1.2965377133062668}
    end = {"q1": 1.7604507816378998}
    return symdyn.collocation(
        FIVE, 0.5, intervals, cost="M1**2 + M2**2", start=start, end=end, end_rates={"q1": 0, "q2": 0},
        path={"point_tool_y": (0.35, 0.35)},
    )  # fmt: skip


PROBLEMS = {"swing_up": lambda: swing_up(25), "swing_up_better": lambda: swing_up(25), "five_bar": lambda: line(10)}

STARTS = {"swing_up_better": 8}
"""Starts of those that a straight way does not lead to."""

BETTER = 57.944780307
"""Cost of the other one by the minimum principle, which swings back once more."""


@pytest.mark.parametrize("name", PROBLEMS)
def test_what_ipopt_found_fulfils_the_conditions_of_an_optimum(name, request):
    """Equations hold, and the gradient is one of the equations wherever no bound is met (Karush, Kuhn, Tucker)."""
    problem = PROBLEMS[name]()
    if request.config.getoption("--update-golden"):
        found = problem.solve(tol=1e-11, starts=STARTS.get(name, 1))
        known = json.loads(GOLDEN.read_text()) if GOLDEN.exists() else {}
        known[name] = {"z": found.z.tolist(), "multipliers": found.multipliers.tolist(), "objective": found.objective}
        GOLDEN.write_text(json.dumps(known) + "\n")
    known = json.loads(GOLDEN.read_text())[name]
    z, multipliers = np.array(known["z"]), np.array(known["multipliers"])
    inside = (z - problem.lower > 1e-6) & (problem.upper - z > 1e-6)
    slope = problem.gradient(z) + multipliers @ problem.jacobian(z)

    assert problem.objective(z) == pytest.approx(known["objective"], rel=1e-10)
    assert np.abs(problem.residual(z)[problem.row["defects"]]).max() < 1e-9
    assert np.abs(problem.residual(z)[problem.row["balance"]]).max() < 1e-8
    assert np.count_nonzero(inside) > 0.9 * np.count_nonzero(~problem.given)
    assert np.abs(slope[inside]).max() < 1e-6 * np.abs(problem.gradient(z)).max()


def test_the_forces_that_were_found_swing_the_pole_up():
    problem, known = swing_up(25), json.loads(GOLDEN.read_text())["swing_up"]
    found = Solution(problem, np.array(known["z"]), np.zeros(problem.rows), known["objective"], 0.0, True, "", 0, 0.0)

    end = found.simulated(rtol=1e-9)
    start = Start(found.run.q[0], found.run.qd[0])
    again = symdyn.simulate(found.scene, forces=found.run, until=found.duration, start=start, rtol=1e-9)
    assert np.array_equal(again.q[-1], end.q[-1])

    assert end.q[-1] == pytest.approx([1, np.pi], abs=0.03)
    assert found.run.q[-1] == pytest.approx([1, np.pi])
    assert found.objective == pytest.approx(PONTRYAGIN, rel=1e-4)


@pytest.mark.parametrize(("name", "cost"), [("swing_up", PONTRYAGIN), ("swing_up_better", BETTER)])
def test_the_minimum_principle_gives_the_cost_of_the_swing_up(name, cost):
    truth = runpy.run_path(str(ROOT / "benchmarks" / "swing_up.py"))["truth"]
    problem, known = swing_up(25), json.loads(GOLDEN.read_text())[name]

    found = truth(problem, np.array(known["z"]), np.array(known["multipliers"]), 1e-6)

    assert found == pytest.approx(cost, abs=1e-7)


@pytest.mark.mends("30.control.3")
@pytest.mark.mends("30.class.optimum")
def test_the_page_shows_both_optima_of_the_swing_up():
    page = (ROOT / "docs" / "performance-of-runs.md").read_text(encoding="utf-8")

    assert [cost for cost in (BETTER, PONTRYAGIN) if f"{cost:.9f}" not in page] == []


@pytest.mark.parametrize("name", ["swing_up", "swing_up_better"])
def test_no_motion_next_to_an_optimum_of_the_swing_up_is_better(name):
    """Second derivatives along what equations leave free are above zero."""
    curvature = runpy.run_path(str(ROOT / "benchmarks" / "swing_up.py"))["curvature"]
    problem, known = swing_up(25), json.loads(GOLDEN.read_text())[name]

    assert curvature(problem, np.array(known["z"]), np.array(known["multipliers"])) > 1e-4


@pytest.mark.targets
@pytest.mark.parametrize("seed", [0, 1])
def test_eight_starts_find_both_optima_and_tell_the_better_one_first(seed):
    found = swing_up(25).solve(starts=8, seed=seed)

    costs = [one.objective for one in found.optima]
    assert costs[:2] == pytest.approx([57.938709, 58.805425], abs=1e-5)
    assert costs == sorted(costs)
    assert found.objective == costs[0]
    assert sum(count for _, count in found.searched.led) + sum(count for _, count in found.searched.failed) == 8
    assert f"8 starts (the guess, and 7 drawn by seed {seed})" in found.notes[-1]


def test_the_five_bar_keeps_to_its_line_and_its_loop_closes():
    problem, known = line(10), json.loads(GOLDEN.read_text())["five_bar"]
    found = Solution(problem, np.array(known["z"]), np.zeros(problem.rows), known["objective"], 0.0, True, "", 0, 0.0)

    end = found.simulated(rtol=1e-9)

    assert np.abs(end["point_tool_y"] - 0.35).max() < 1e-4
    assert end["point_tool_x"][-1] == pytest.approx(0.12, abs=1e-4)
    assert end.monitors["loops"] < 1e-10


@pytest.mark.targets
def test_the_cost_goes_to_that_of_the_minimum_principle_with_the_order():
    off = [swing_up(intervals, tol_method).solve().objective - PONTRYAGIN for intervals, tol_method in MESHES]

    assert np.log2(off[0] / off[1]) == pytest.approx(2, abs=0.1)
    assert abs(off[2]) < 1e-5 * PONTRYAGIN


@pytest.mark.targets
def test_accelerations_have_a_cost_and_bounds_and_velocities_of_points_a_path():
    """Of all motions of a cart over d in T from rest to rest ∫ ẍ² is least for a cubic: 12 d²/T³."""
    given = {"end": {"x": 1}, "cost": "x_ddot**2"}

    found = symdyn.collocation(symdyn.example("cart_pole"), 2, 10, **given).solve()
    assert found.objective == pytest.approx(12 / 8, rel=1e-6)
    slow = symdyn.collocation(symdyn.example("cart_pole"), 2, 20, **given, path={"point_tip_x_dot": 0.7}).solve()
    tip = symdyn.lambdify(slow.run.scene, "jacobian:tip")
    speed = np.array([tip(q)[0] @ u for q, u in zip(slow.run.q, slow.run.qd, strict=True)])
    assert np.abs(speed[::2]).max() == pytest.approx(0.7, abs=1e-6)
    held = symdyn.collocation(symdyn.example("cart_pole"), 2, 10, **given, bounds={"x_ddot": 1.2}).solve()
    assert np.abs(held.z[held.problem.place["a"][:, 0]]).max() < 1.2 + 1e-6
    assert 12 / 8 < held.objective < 2


MESHES = ((100, "trapezoidal"), (200, "trapezoidal"), (60, "hermite_simpson"))


@pytest.mark.targets
def test_second_derivatives_and_none_lead_to_the_same_motion():
    problem = swing_up(15)
    near = problem.solve(max_iter=100).z

    newton, limited = (problem.solve(near, exact=exact, tol=1e-7) for exact in (True, False))

    assert newton.success
    assert limited.success
    assert limited.objective == pytest.approx(newton.objective, rel=1e-7)
    assert newton.violation < 1e-9


@pytest.mark.targets
def test_contradictions_and_wrong_options_are_told():
    with pytest.raises(
        SimulateError, match=r"given at t = 0 s contradicts itself.*of the path point_tool_y is .*, and 1 is asked for"
    ):
        symdyn.collocation(FIVE, 1, 4, path={"point_tool_y": (1, 1)}).solve()
    with pytest.raises(SimulateError, match=r"given at t = 1 s contradicts itself.*loops do not close"):
        symdyn.collocation(FIVE, 1, 4, end={"q1": 1, "q2": 2, "q3": 0.3, "q4": 0.3}).solve()
    with pytest.raises(SimulateError, match=r"IPOPT: No such IPOPT option: max_itr; guess, starts=8 and seed are ours"):
        swing_up(4).solve(max_itr=3)
    with pytest.raises(SimulateError, match=r"has the shape \(3,\); the problem has"):
        swing_up(4).solve(np.zeros(3))
    with pytest.raises(SimulateError, match="have no value there"):
        symdyn.collocation(SWING, 2, 4, cost="1/q1").solve()


def test_without_casadi_it_is_said_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(SimulateError, match=r"pip install .symdyn\[optimal\].; or hand the problem's residual"):
        swing_up(4).solve()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"until": -1}, "until = -1 is no time after the start"),
        ({"until": (3, 1)}, r"until = \(3, 1\) is no time"),
        ({"until": "soon"}, "until = soon is no time after the start"),
        ({"intervals": 0}, "intervals = 0: they are a number of them, or rising shares"),
        ({"intervals": [0, 0.5]}, "rising shares of time from 0 to 1"),
        ({"intervals": "many"}, "intervals = 'many': give a whole number or a list of numbers"),
        ({"method": "simpson"}, "method simpson is not known; did you mean hermite_simpson"),
        ({"cost": "G**2"}, r"cost: .* uses G, which is not known here; did you mean g\?, and drives are u"),
        ({"final_cost": "u"}, "final cost: .* uses u, which is not known here"),
        ({"end": {"q9": 1}}, "end: q9 is not known; known are q1, q2"),
        ({"end": {"q1": 5}}, "end: q1 = 5 is beyond its bounds -2 … 2"),
        ({"start": {"q1": 3}}, "start: q1 = 3 is beyond its bounds -2 … 2"),
        ({"bounds": {"q1": (1, 0)}}, "^bounds: q1: nothing lies between 1 and 0; give the smaller value first$"),
        ({"bounds": {"q1": "-19"}}, "bounds: q1: '-19' is neither a size above 0 nor a smallest and a largest value"),
        ({"bounds": {"l": (0, 1)}}, "bounds: l is not known; known are q1, q2, q1_dot, q2_dot, q1_ddot, q2_ddot, u"),
        ({"bounds": {"u": (30, 40)}}, "^bounds: u: 30 … 40 leaves nothing of its joint's limits, -20 … 20$"),
        ({"bounds": {"q1": (5, None)}}, "^bounds: q1: 5 … inf leaves nothing of its joint's limits, -2 … 2$"),
        ({"end_rates": {"q1": 0, "q1_dot": 1}}, "^end rates: q1_dot is given twice, as 0 and as 1$"),
        ({"path": {"zz": (0, 1)}}, "path: .* uses zz"),
        (
            {"bounds": {"point_tip_x_dot": 1}},
            'point_tip_x_dot follows from unknowns; hold it by path={"point_tip_x_dot": 1}',
        ),
        (
            {"bounds": {"point_tip_x_ddot": 1}},
            'point_tip_x_ddot follows from unknowns; hold it by cost="point_tip_x_ddot[*][*]2"',
        ),
        ({"path": {"point_tip_x_ddot": 1}}, "and no force or acceleration; bounds limits those of joints"),
        ({"free": "zz"}, "free: zz is not known; known are m1, m2, l, g"),
        ({"until": -1, "method": "x", "end": {"q9": 1}}, "(?s)method x is not known.*until = -1"),
    ],
)
def test_what_cannot_be_asked_is_told(given, said):
    with pytest.raises(SimulateError, match=said):
        symdyn.collocation(SWING, **{"until": 2, "intervals": 4} | given)


def test_limits_of_joints_are_bounds():
    problem = swing_up(3, bounds={"q1": (-5, 1.5), "q2_dot": (None, 9)})
    q1, force, rate = problem.place["q"][1:-1, 0], problem.place["force"], problem.place["u"][1:-1, 1]

    assert set(problem.lower[q1]) == {-2.0}
    assert set(problem.upper[q1]) == {1.5}
    assert set(problem.lower[force[:, 0]]) == {-20.0}
    assert set(problem.upper[force[:, 0]]) == {20.0}
    assert (set(problem.lower[rate]), set(problem.upper[rate])) == ({-np.inf}, {9.0})


@pytest.mark.targets
@pytest.mark.long(0)
def test_the_page_of_collocation_says_what_its_examples_print(tmp_path, monkeypatch, capsys):
    text = (ROOT / "docs" / "collocation.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n((?:[^`].*\n|\n)*)```\n\n((?:    .*\n)+)", text)
    script = tmp_path / "page.py"
    script.write_text("".join(code for code, _ in blocks), encoding="utf-8")
    monkeypatch.chdir(ROOT)

    runpy.run_path(str(script))

    printed = "".join(line.removeprefix("    ") for _, said in blocks for line in said.splitlines(keepends=True))
    assert len(blocks) == text.count("```python")
    assert capsys.readouterr().out == printed
