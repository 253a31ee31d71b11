"""Work against precision: points of a motion whose truth is known."""

from __future__ import annotations

from pathlib import Path

from symdyn.bench import Bench
from symdyn.bench.report import html, markdown, pictures
from symdyn.bench.work_precision import curves, lively
from symdyn.scene import read

EXAMPLES = Path(__file__).parent.parent / "examples"


def test_finer_tolerances_take_more_work_and_leave_less_error() -> None:
    (curve,) = curves(read(EXAMPLES / "double_pendulum.toml"), 1.0, ("dop853",), (1e-4, 1e-7, 1e-10))

    errors = [point.error for point in curve.points]
    assert [point.tolerance for point in curve.points] == [1e-4, 1e-7, 1e-10]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 1e3 * errors[-1] > 0
    assert curve.points[0].evaluations < curve.points[-1].evaluations
    assert all(point.seconds > 0 for point in curve.points)

    report = Bench("double_pendulum", "", (), {}, (), (curve,))
    assert set(pictures(report)) == {"trajectory", "energy"}
    assert "| dop853 | 1e-07 |" in markdown(report)
    assert html(report).count("<svg") == 2


def test_a_tree_at_rest_is_moved_and_one_with_a_start_is_not() -> None:
    assert set(lively(read(EXAMPLES / "cart_pole.toml")).values()) == {"1/10", "1/2"}
    assert lively(read(EXAMPLES / "heavy_top.toml")) == {}
