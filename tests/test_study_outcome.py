"""What comes of a sweep: Sobol's indices against those that are known, and plots that are the same bytes again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.errors import SimulateError, UnknownNameError
from symdyn.scene import Scene
from symdyn.scene.values.entry import Faults
from symdyn.study.design import Design, read_design
from symdyn.study.distributions import read_over
from symdyn.study.plots import PLOTS, drawn_runs, fitting, plot, swing
from symdyn.study.runs import Runs

Columns = Mapping[str, np.ndarray]

HOSTILE = "</svg><script>alert(1)</script>$\\frac$"


def planned(over: Mapping[str, object], kind: str, count: int | None) -> Design:
    faults = Faults("")
    found = read_design(read_over(Scene("p"), over, over, faults), kind, count, 3, faults)
    assert found is not None, faults.lines
    return found


def study(over: Mapping[str, object], kind: str, count: int | None, of: Callable[..., Columns]) -> Runs:
    design = planned(over, kind, count)
    values = design.values()
    made, units = of(*values.T), {"x1": "kg", "y": "N m"}
    about = {"design": kind, "seed": 3}
    return Runs(HOSTILE, design.names, units, values, made, np.ones(len(values), np.uint8), about=about)


def ishigami(x1: np.ndarray, x2: np.ndarray, x3: np.ndarray) -> Columns:
    return {"y": np.sin(x1) + 7 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1)}


OVER_ISHIGAMI = dict.fromkeys(("x1", "x2", "x3"), "uniform(-pi,pi)")


def known_indices() -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of Ishigami's function with a = 7, b = 0.1 (Ishigami and Homma 1990)."""
    a, b = 7.0, 0.1
    one, two = 0.5 * (1 + b * np.pi**4 / 5) ** 2, a**2 / 8
    both = b**2 * np.pi**8 * (1 / 18 - 1 / 50)
    total = one + two + both
    return np.array([one, two, 0]) / total, np.array([one + both, two, both]) / total


def test_sobol_indices_of_ishigami_are_the_known_ones_and_lie_in_their_intervals() -> None:
    found = study(OVER_ISHIGAMI, "saltelli", 4096, ishigami).indices("y")
    first, total = known_indices()

    assert found.groups == 4096
    np.testing.assert_allclose(found.first, first, atol=0.02)
    np.testing.assert_allclose(found.total, total, atol=0.02)
    for values, interval in ((first, found.first_interval), (total, found.total_interval)):
        assert np.all((interval[:, 0] <= values) & (values <= interval[:, 1]))
        assert np.all(np.ptp(interval, axis=1) < 0.15)
    with pytest.raises(SimulateError, match=r'name one of y, z, \.indices\("y"\)$'):
        study(OVER_ISHIGAMI, "saltelli", 8, lambda *x: ishigami(*x) | {"z": x[0]}).indices()
    again = study(OVER_ISHIGAMI, "saltelli", 4096, ishigami).indices("y")
    assert np.array_equal(again.first_interval, found.first_interval)


def test_groups_of_the_design_differ_in_one_entry_and_any_stretch_is_the_same() -> None:
    design = planned(OVER_ISHIGAMI, "saltelli", 9)

    assert design.count == 16 * 5  # the next power of two
    groups = design.values().reshape(16, 5, 3)
    for k in range(3):
        assert np.array_equal(groups[:, 2 + k, k], groups[:, 1, k])
        rest = [j for j in range(3) if j != k]
        assert np.array_equal(groups[:, 2 + k][:, rest], groups[:, 0][:, rest])
    for first, last in ((0, 1), (3, 17), (40, 80), (79, 80)):
        assert np.array_equal(design.values(first, last), groups.reshape(-1, 3)[first:last])


def test_groups_with_a_failed_run_are_left_out_and_it_is_said() -> None:
    def partly(*x: np.ndarray) -> Columns:
        y = np.array(ishigami(*x)["y"])
        y[7] = np.nan
        return {"y": y}

    found = study(OVER_ISHIGAMI, "saltelli", 256, partly).indices("y")

    assert found.groups == 128
    assert "1 of 256 groups have a run without a value" in found.notes[0]
    failed = study(OVER_ISHIGAMI, "saltelli", 8, lambda *x: {"y": np.full(len(x[0]), np.nan)})
    with pytest.raises(SimulateError, match=r"0 of 8 groups of 5 runs have values throughout.*raise count"):
        failed.indices("y")


@pytest.mark.parametrize("count", [16, 64, 1024])
def test_the_widest_interval_of_indices_is_told_where_it_is_wide(count: int) -> None:
    """Beside the intervals that are returned: bounds in their order, and the largest difference of two."""
    found = study(OVER_ISHIGAMI, "saltelli", count, ishigami).indices("y")

    bounds = np.concatenate([found.first_interval, found.total_interval])
    assert np.all(bounds[:, 0] < bounds[:, 1])
    widest = max(high - low for low, high in bounds.tolist())
    told = [note for note in found.notes if "wide" in note]
    assert len(told) == (widest > 0.3)
    assert all(f"an interval is {widest:.2g} wide" in note for note in told)


def test_a_measure_that_never_changes_has_no_variance_to_share_out() -> None:
    found = study(OVER_ISHIGAMI, "saltelli", 8, lambda *x: {"y": np.full(len(x[0]), 3.0)}).indices("y")

    assert not found.first.any()
    assert "no variance" in found.notes[0]


def test_other_designs_and_names_are_refused_in_words() -> None:
    drawn = study(OVER_ISHIGAMI, "random", 32, ishigami)
    with pytest.raises(SimulateError, match="need runs of the design saltelli, and these are of random"):
        drawn.indices("y")
    with pytest.raises(UnknownNameError, match="no measure z"):
        study(OVER_ISHIGAMI, "saltelli", 8, ishigami).indices("z")
    with pytest.raises(SimulateError, match=r"heat shows two varied names; 3 vary here; of these .* are tornado"):
        drawn_runs(drawn, "svg", kind="heat")
    with pytest.raises(SimulateError, match="plot: tornato is not known; did you mean tornado"):
        drawn_runs(drawn, "svg", kind="tornato")
    with pytest.raises(SimulateError, match="z is no measure; there are y"):
        drawn_runs(drawn, "svg", ["z"])
    none = study(OVER_ISHIGAMI, "random", 3, lambda *x: {"y": np.full(3, np.nan)})
    with pytest.raises(SimulateError, match="no run has a value of y"):
        drawn_runs(none, "svg")
    half = study(OVER_ISHIGAMI, "random", 9, lambda *x: {"y": np.full(9, np.nan), "z": np.arange(9.0)})
    assert "z (no run has a value of y)" in drawn_runs(half, "svg").decode()


@pytest.mark.long
@pytest.mark.runs("cc")
def test_indices_of_a_scene_find_that_only_length_and_gravity_move_a_small_pendulum() -> None:
    over = {"m": "uniform(1,2)", "q1": "uniform(0.1,0.3)"}
    made = symdyn.sweep(symdyn.example("pendulum"), over, "max(abs(q1))", until=1, design="saltelli", count=32)

    found = made.indices()  # of the one measure
    assert found.measure == "max(abs(q1))"
    assert found.total[made.names.index("q1")] > 0.7
    assert found.total[made.names.index("m")] < 0.05


def test_a_tornado_tells_the_means_where_a_name_is_lowest_and_highest() -> None:
    grid = study({"x1": "linspace(0,1,3)", "x2": "[5, 6]"}, "grid", None, lambda a, b: {"y": 2 * a + b})

    low, high = swing(grid, "y")
    np.testing.assert_allclose(low, [5.5, 6.0])
    np.testing.assert_allclose(high, [7.5, 7.0])

    drawn = study({"x1": "uniform(0,1)"}, "sobol", 256, lambda a: {"y": a})  # a tenth of its runs at each end
    np.testing.assert_allclose(np.ravel(swing(drawn, "y")), [0.05, 0.95], atol=0.005)


def partly(a: np.ndarray, b: np.ndarray) -> Columns:
    return {"y": np.where(a * b > 1, a, np.nan)}


STUDIES = {
    "indices": study(OVER_ISHIGAMI, "saltelli", 8, ishigami),
    "scatter": study({"x1": "linspace(0,1,9)"}, "grid", None, lambda a: {"y": a**2}),
    "heat": study({"x1": "linspace(0,1,9)", "x2": "[1, 2, 4]"}, "grid", None, partly),
    "tornado": study(dict.fromkeys(("x1", "x2", "x3"), "[1, 2]"), "grid", None, ishigami),
    "histogram": study(dict.fromkeys(("x1", "x2", "x3"), "normal(0,1)"), "random", 50, ishigami),
}


@pytest.mark.long(0)
@pytest.mark.wide("scatter")
@pytest.mark.parametrize("kind", sorted(PLOTS))
def test_each_kind_of_plot_fits_its_study_is_the_same_bytes_and_obeys_no_name(kind: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    one = STUDIES[kind]

    assert fitting(one) == kind
    first = drawn_runs(one, "svg")
    assert first == drawn_runs(one, "svg", ["y"], kind)
    for ending in ("svg", "png", "pdf", "html"):
        plot(one, tmp_path / f"plot.{ending}")
        assert (tmp_path / f"plot.{ending}").stat().st_size > 1000
    assert (tmp_path / "plot.svg").read_bytes() == first
    assert "<script" not in (tmp_path / "plot.html").read_text(encoding="utf-8")
    shown = one.plot()
    assert "image/svg+xml" in shown._repr_mimebundle_()  # type: ignore[attr-defined]
    assert shown.axes[0].get_title(loc="left").startswith("y")
