"""Work against precision: points of a motion whose truth is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mpmath import mp

from symdyn.algebra.big import BigFloats
from symdyn.bench import Bench, Curve, MotionPrecision, Point
from symdyn.bench.measurements import UNTIL, lively, marked, motion
from symdyn.bench.report import html, markdown, pictures
from symdyn.bench.stress.motions import RUBBED
from symdyn.bench.stress.scenes import offset_pendulum, rubbing
from symdyn.errors import SimulateError
from symdyn.graph import evaluate
from symdyn.scene import Scene, read, read_text
from symdyn.simulation import simulate
from symdyn.simulation.timed_runs import DIGITS, EPSILON, FINEST, TimedRuns, truth

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"


def runs_of(scene: Scene) -> TimedRuns:
    return TimedRuns.of(scene, lively(scene))


def test_finer_tolerances_take_more_work_and_leave_less_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.bench.measurements.PATIENCE_QUICK", 1.0)  # a slow machine measures every method, too
    found = motion(read(EXAMPLES / "double_pendulum.toml"), quick=True)
    curve = next(curve for curve in found.precision if curve.method == "dop853")

    errors = [point.error for point in curve.points]
    assert [point.tolerance for point in curve.points][:2] == [1e-3, 1e-6]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 1e3 * errors[-1] > 0
    assert curve.points[0].evaluations < curve.points[-1].evaluations
    assert all(point.seconds > 0 for point in curve.points)
    assert {one.method for one in found.drift} >= {"dop853", "lsoda"}

    report = Bench("double_pendulum", "", (), {}, (), found)
    assert set(pictures(report)) == {"trajectory", "energy"}
    assert "| dop853 | 1e-06 |" in markdown(report)
    assert html(report).count("<svg") == 2


def test_a_start_without_accelerations_is_told_at_once() -> None:
    """An integrator in steps of no number would never end."""
    from symdyn.scene import body, prismatic, scene

    slab = prismatic("slide", parent="ground", child="slab", axis=(1, 0, 0), force="2*log(-1 - 3*q1**2)")
    unreal = scene("unreal", bodies=[body("slab", mass=1)], joints=[slab])

    with pytest.raises(SimulateError, match=r"unreal: start: the force of joint slide, .*, has no real value there"):
        motion(unreal)


def test_the_truth_has_more_digits_than_a_double() -> None:
    """A pendulum from rest in Jacobi's elliptic functions: sin(q/2) = k sn(K - w t), k = sin(q0/2), w^2 = g/l."""
    assert EPSILON / 4 < 10.0**-DIGITS < 4 * EPSILON  # which a page tells of it
    pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")
    runs = runs_of(offset_pendulum())
    found = runs.truth(UNTIL)

    with mp.workdps(40):
        k = mp.sin(mp.mpf(float(runs.x[0])) / 2)
        sn = mp.ellipfun("sn", mp.ellipk(k**2) - mp.sqrt(mp.mpf("9.81")) * UNTIL, m=k**2)
        gap = abs(mp.mpf(np.format_float_scientific(found.x[0], 25)) - 2 * mp.asin(k * sn))
    assert runs.x[0] == 0.5
    assert found.uncertain < 1e-17
    assert gap < 1e-17


@pytest.mark.slow
def test_the_truth_sees_dry_friction_turn() -> None:
    """A series of tanh is flat to the last digit and steps over the turn; three other methods agree with the truth."""
    pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")
    runs = runs_of(rubbing())
    found = runs.truth(UNTIL)

    assert found.uncertain < 1e-15
    assert found.x[0] == pytest.approx(RUBBED, abs=1e-16)
    assert found.distance(runs.run("dop853", 1e-12, UNTIL).x[-1]) < 1e-12
    assert found.distance(runs.run("radau", 1e-12, UNTIL).x[-1]) < 1e-12


def test_the_truth_of_a_closed_mechanism_is_where_its_loops_are_closed() -> None:
    pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")
    runs = runs_of(read(EXAMPLES / "four_bar.toml"))
    found = runs.truth(UNTIL)
    big, system = BigFloats(40), runs.system
    function = system.compiled.prepared["constraint_residual"].function
    known = [big.number(float(value)) for value in system.compiled.values(system.opened.values)]
    q = [big.context.mpf(np.format_float_scientific(value, 25)) for value in found.x[: system.nq]]
    r = evaluate(function.entries, big, function.values((known, q), lambda value: value))

    assert found.uncertain < 1e-15
    assert max(map(abs, r)) < 2e-17
    assert found.distance(runs.run("dop853", 1e-13, UNTIL).x[-1]) < 1e-11


def test_without_a_library_for_more_digits_the_finest_run_stands_in_and_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("symdyn.simulation.integrate.integration.importable", lambda module: False)
    runs = runs_of(read(EXAMPLES / "double_pendulum.toml"))
    asked = []

    def doubles(name: str, tolerance: float) -> np.ndarray:
        asked.append((name, tolerance))
        return runs.run(name, tolerance, UNTIL).x[-1]

    found = truth(runs.system, runs.x, UNTIL, doubles)

    assert asked == [("dop853", tolerance) for tolerance in FINEST]
    assert "heyoka is not installed" in found.how
    assert 0 < found.uncertain < 1e-11


def test_a_run_is_what_simulate_computes() -> None:
    runs = runs_of(read(EXAMPLES / "double_pendulum.toml"))
    ours = runs.run("dop853", 1e-9, UNTIL)
    start = lively(runs.system.scene)
    theirs = simulate(runs.system.scene, until=UNTIL, start=start, method="dop853", rtol=1e-9)

    assert np.abs(ours.x[-1, :2] - theirs.q[-1]).max() < 1e-8
    assert ours.evaluations > 100


def test_points_that_another_one_beats_are_not_marked() -> None:
    a = Curve("a", (Point(1e-3, 1.0, 1, 1e-3), Point(1e-6, 2.0, 1, 1e-6)))
    b = Curve("b", (Point(1e-3, 1.5, 1, 1e-2), Point(1e-6, 3.0, 1, 1e-9)))

    assert [[p.best for p in curve.points] for curve in marked([a, b, Curve("c", ())])] == [[True, True], [False, True]]


def test_parameters_without_values_and_scenes_at_rest_are_told() -> None:
    with pytest.raises(SimulateError, match=r"m1, m2, h1, h2, g have no value; give them, as in values=\{"):
        motion(read(EXAMPLES / "two_link.toml"))
    still = """name = "still"
        [bodies.b]
        mass = 1
        [joints.j]
        type = "prismatic"
        parent = "ground"
        child = "b"
        axis = [1, 0, 0]
        start = 0
        start_rates = 0"""
    with pytest.raises(SimulateError, match="still: nothing moves from its start; give joints start or start_rates"):
        motion(read_text(still))


def test_a_tree_at_rest_is_moved_and_one_with_a_start_is_not() -> None:
    assert set(lively(read(EXAMPLES / "cart_pole.toml")).values()) == {"1/10", "1/2"}
    assert lively(read(EXAMPLES / "heavy_top.toml")) == {}


def test_reports_tell_what_motions_are_judged_by() -> None:
    points = (Point(1e-3, 1e-3, 10, 1e-4, best=True),)
    found = MotionPrecision(
        2.0, 100.0, "an oracle", 1e-18, (Curve("taylor", points),), (Curve("taylor", points),), ("a note",)
    )
    text = markdown(Bench("s", "", (), {}, (), found))

    assert "The truth is an oracle, which may be off by 1e-18" in text
    assert "a note" in text
    assert text.count("| taylor | 1e-03 | 0.001 | 10 | 1.0e-04 | yes |") == 2
