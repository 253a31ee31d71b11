"""Plots of runs, a row of `PLOTS` each: histograms, scatter, heat maps, tornado, Sobol's indices."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.draw import FilledFigure
from symdyn.errors import SimulateError, choice, suggestion
from symdyn.frozen import dataclass
from symdyn.simulation import CHECKS, write_picture
from symdyn.study.design import SALTELLI

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symdyn.study.runs import Runs


MOST_PANELS = 8
"""Measures of one figure; further ones are left out, and the title says so."""

MOST_BARS = 15
"""Names of a tornado or of indices, those with the longest bars."""

MOST_DOTS = 10_000
"""Dots of one axis; of more runs every second, third, ... is drawn, and the title says so."""

SHARES = (0.05, 0.5, 0.95)
"""Quantiles that a histogram shows."""

TENTH = 0.1
"""Part of the runs, those with the lowest and with the highest values of a name, whose means a tornado shows."""

COLOURS = {"line": "#1f5f99", "fill": "#9cc3e6", "low": "#5b9bd5", "high": "#e08a4f", "mark": "0.25"}


@dataclass(frozen=True)
class Plot:
    """A kind of plot."""

    description: str  # what it shows, one line
    draw: Callable[[Any, Runs, str], None]  # on an axis, from the runs and the name of a measure
    fault: Callable[[Runs], str] = lambda runs: ""  # why runs have no such plot; "" where they have
    height: Callable[[int], float] = lambda names: 2.6  # of one panel, inches, from how many names are varied


def _known(runs: Runs, measure: str) -> tuple[Array, Array]:
    column = runs[measure]
    there = np.isfinite(column)
    return runs.values[there], column[there]


def _histogram(axis: Any, runs: Runs, measure: str) -> None:
    column = _known(runs, measure)[1]
    bins = int(np.clip(np.sqrt(len(column)), 8, 60))
    axis.hist(column, bins=bins, color=COLOURS["fill"], edgecolor=COLOURS["line"], linewidth=0.4)
    for share, value in zip(SHARES, np.quantile(column, SHARES), strict=True):
        style = "-" if share == 0.5 else "--" if share < 0.5 else "-."
        line = axis.axvline(value, color=COLOURS["mark"], linewidth=0.9, linestyle=style)
        line.set_label(f"{100 * share:g} %: {value:.4g}")
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)
    axis.set_ylabel("runs")
    _plain(axis.set_xlabel(_label(runs, measure)))


def _scatter(axis: Any, runs: Runs, measure: str) -> None:
    values, column = _known(runs, measure)
    x = values[:, 0]
    order = np.argsort(x, kind="stable")
    if runs.about.get("design") == "grid":
        axis.plot(x[order], column[order], "o-", color=COLOURS["line"], markersize=3, linewidth=0.9)
    else:
        step = _every(len(x))
        axis.plot(x[::step], column[::step], ".", color=COLOURS["line"], markersize=3, alpha=0.6)
    _plain(axis.set_xlabel(_label(runs, runs.names[0])))
    _plain(axis.set_ylabel(_label(runs, measure)))
    axis.grid(alpha=0.3)


def _heat(axis: Any, runs: Runs, measure: str) -> None:
    values, column = _known(runs, measure)
    x, y = values.T
    columns, rows = np.unique(runs.values[:, 0]), np.unique(runs.values[:, 1])
    if runs.about.get("design") == "grid" and min(len(columns), len(rows)) > 1:
        cells = np.full((len(rows), len(columns)), np.nan)
        cells[np.searchsorted(rows, y), np.searchsorted(columns, x)] = column
        drawn = axis.pcolormesh(columns, rows, np.ma.masked_invalid(cells), shading="nearest", rasterized=True)
        axis.set_facecolor("0.85")  # cells without a value
    else:
        step = _every(len(x))
        drawn = axis.scatter(x[::step], y[::step], c=column[::step], s=8, linewidths=0)
    bar = axis.figure.colorbar(drawn, ax=axis)
    _plain(bar.ax.set_ylabel(_label(runs, measure)))
    _plain(axis.set_xlabel(_label(runs, runs.names[0])))
    _plain(axis.set_ylabel(_label(runs, runs.names[1])))


def swing(runs: Runs, measure: str) -> tuple[Array, Array]:
    """Return the means of a measure where each name is lowest, and where it is highest, shapes (k,).

    Of a grid that is its first and last value, of other designs the tenth of the runs with the lowest and highest.
    """
    values, column = _known(runs, measure)
    low, high = np.zeros(values.shape[1]), np.zeros(values.shape[1])
    for k, x in enumerate(values.T):
        share = TENTH if runs.about.get("design") != "grid" else 0.0
        ends = np.quantile(x, [share, 1 - share])
        low[k], high[k] = column[x <= ends[0]].mean(), column[x >= ends[1]].mean()
    return low, high


def _tornado(axis: Any, runs: Runs, measure: str) -> None:
    low, high = swing(runs, measure)
    middle = float(_known(runs, measure)[1].mean())
    order = np.argsort(np.ptp([low, high, np.full(len(low), middle)], axis=0), kind="stable")[-MOST_BARS:]
    for place, k in enumerate(order):
        for shift, end, colour in ((0.17, low[k], "low"), (-0.17, high[k], "high")):
            axis.barh(place + shift, end - middle, left=middle, color=COLOURS[colour], height=0.32)
    _names(axis, runs, order.tolist())
    axis.use_sticky_edges = False
    axis.autoscale_view()
    axis.axvline(middle, color=COLOURS["mark"], linewidth=0.9)
    _plain(axis.set_xlabel(_label(runs, measure)))
    _legend(axis, {"mean where the name is low": COLOURS["low"], "… and where it is high": COLOURS["high"]})


def _indices(axis: Any, runs: Runs, measure: str) -> None:
    found = runs.indices(measure)
    order = np.argsort(found.total, kind="stable")[-MOST_BARS:]
    each = ((0.2, found.first, found.first_interval, "line"), (-0.2, found.total, found.total_interval, "fill"))
    for shift, values, interval, colour in each:
        reach = np.abs(interval[order].T - values[order])
        style = {"ecolor": COLOURS["mark"], "error_kw": {"linewidth": 0.8, "capsize": 2}}
        axis.barh(np.arange(len(order)) + shift, values[order], xerr=reach, height=0.36, color=COLOURS[colour], **style)
    _names(axis, runs, order.tolist())
    axis.set_xlim(left=min(0.0, axis.get_xlim()[0]))
    _plain(axis.set_xlabel(f"part of the variance of {measure}, with {100 * found.level:g} % intervals"))
    _legend(axis, {"first order: alone": COLOURS["line"], "total: with others": COLOURS["fill"]})


def _names(axis: Any, runs: Runs, order: Sequence[int]) -> None:
    axis.set_yticks(range(len(order)))
    for label in axis.set_yticklabels([runs.names[k] for k in order]):
        _plain(label)


def _legend(axis: Any, colours: Mapping[str, str]) -> None:
    from matplotlib.patches import Patch

    patches = [Patch(color=colour, label=text) for text, colour in colours.items()]
    axis.legend(handles=patches, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)


def _plain(text: Any) -> None:
    """Let a text be no mathematics: names and units are a stranger's."""
    text.set_parse_math(False)


def _label(runs: Runs, name: str) -> str:
    unit = runs.units.get(name, "")
    return f"{name}, {unit}" if unit else name


def _every(count: int) -> int:
    return -(-count // MOST_DOTS)


def _needs(count: int, most: int | None, kind: str) -> Callable[[Runs], str]:
    def fault(runs: Runs) -> str:
        k = len(runs.names)
        if k < count or (most is not None and k > most):
            wanted = "one" if most == 1 else "two" if most else f"{count} or more"
            return f"{kind} shows {wanted} varied name{'' if most == 1 else 's'}; {k} vary here"
        return ""

    return fault


def _drawn_for_indices(runs: Runs) -> str:
    if runs.has_indices:
        return ""
    return f"indices need runs of the design {SALTELLI}; sweep again with {argument('design', SALTELLI)}"


def _bars(names: int) -> float:
    return 1.1 + 0.3 * min(names, MOST_BARS)


PLOTS: Mapping[str, Plot] = {
    "indices": Plot("parts of the variance, Sobol's indices", _indices, _drawn_for_indices, _bars),
    "scatter": Plot("the measure over the one name that is varied", _scatter, _needs(1, 1, "scatter")),
    "heat": Plot("the measure over two names as colours", _heat, _needs(2, 2, "heat"), lambda names: 3.4),
    "tornado": Plot("how far each name moves the mean", _tornado, _needs(2, None, "tornado"), _bars),
    "histogram": Plot("how often which values came out, with quantiles", _histogram),
}
"""By the word that is written."""


def fitting(runs: Runs) -> str:
    """Return the kind of plot for runs where none is chosen."""
    grid = runs.about.get("design") == "grid"
    wanted = ("indices", "scatter", "heat", "tornado") if grid else ("indices", "scatter", "histogram")
    return next(kind for kind in wanted if not PLOTS[kind].fault(runs))


def check_study_plot(path: Path | None, kind: str | None) -> None:
    """Raise SimulateError where a plot cannot be made: an ending or a kind that is not known, or no matplotlib."""
    if path is not None:
        CHECKS["plot"](path)
    if kind is not None and kind not in PLOTS:
        raise SimulateError(f"plot: {kind} is not known; {suggestion(kind, PLOTS)}")


def figure(runs: Runs, measures: Sequence[str] = (), kind: str | None = None, axes: Any = None) -> Figure:
    """Return a plot of measures, or of all, as a figure of matplotlib, which a notebook shows.

    Raises:
        SimulateError: a kind that is not known or does not fit, no run with a value, or no matplotlib.
        UnknownNameError: there is no such measure.
    """
    filled = _filled(runs, measures, kind)
    CHECKS["plot"]()
    return filled.figure(len(runs) * len(runs.names), axes)


def drawn_runs(runs: Runs, form: str, measures: Sequence[str] = (), kind: str | None = None) -> bytes:
    """Return the picture as "svg", "pdf" or "png"; the same runs, the same bytes. Errors as of `figure`."""
    return _filled(runs, measures, kind).picture(form)


def plot(runs: Runs, path: Path, measures: Sequence[str] = (), kind: str | None = None) -> None:
    """Write a plot to a .svg, .pdf, .png or .html file. Errors as of `figure`, and a file that cannot be written."""
    check_study_plot(path, kind)
    facts = [("scene", runs.scene), ("runs", str(len(runs))), ("without a value", str(runs.failed))]
    facts += [(key, str(runs.about[key])) for key in ("design", "seed") if key in runs.about]
    write_picture(path, runs.scene, partial(drawn_runs, runs, measures=measures, kind=kind), facts)


def _filled(runs: Runs, measures: Sequence[str], kind: str | None) -> FilledFigure:
    check_study_plot(None, kind)
    names = list(measures or runs.measures or runs.outcomes)
    for name in names:
        if name not in runs.outcomes:
            raise SimulateError(f"{runs.scene}: {name} is no measure; {choice(name, runs.outcomes)}")
    kind = kind or fitting(runs)
    if fault := PLOTS[kind].fault(runs):
        possible = [name for name, row in PLOTS.items() if not row.fault(runs)]
        raise SimulateError(f"{runs.scene}: {fault}; of these runs there are {', '.join(possible)}")
    empty = [name for name in names if not np.isfinite(runs[name]).any()]
    names, many = [name for name in names if name not in empty], len(names)
    if len(empty) == many:
        raise SimulateError(f"{runs.scene}: no run has a value of {', '.join(empty)}, so that there is nothing to plot")
    shown = names[:MOST_PANELS]

    def fill(made: Any) -> None:
        axes = made.subplots(len(shown), 1, squeeze=False)[:, 0]
        for axis, name in zip(axes, shown, strict=True):
            PLOTS[kind].draw(axis, runs, name)
            _plain(axis.set_title(_title(runs, name, len(names) - len(shown), empty), loc="left", fontsize=9))

    height = 0.5 + PLOTS[kind].height(len(runs.names)) * len(shown)
    return FilledFigure(runs.scene, (8.0, max(2.4, height)), fill)


def _title(runs: Runs, measure: str, more: int, empty: Sequence[str]) -> str:
    missing = int(np.count_nonzero(~np.isfinite(runs[measure])))
    parts = [f"{missing} of {len(runs)} runs without a value left out"] if missing else []
    parts += [f"{more} more measures not shown"] if more else []
    parts += [f"no run has a value of {', '.join(empty)}"] if empty else []
    return measure + (f" ({'; '.join(parts)})" if parts else "")
