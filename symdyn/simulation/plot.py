"""Plots of a trajectory: coordinates, velocities, driving forces and energies over time; svg, pdf, png or html."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symdyn.draw import FilledFigure
from symdyn.emit import in_html, render
from symdyn.simulation.panels import Curve, Panel, panels
from symdyn.simulation.record import check_plot, write_whole
from symdyn.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symdyn.simulation.trajectory import Trajectory

MOST_LINES = 12
"""Curves of one axis; further ones are left out, and the title says so."""


def plot(trajectory: Trajectory, path: Path, names: Sequence[str] = ()) -> None:
    """Write a plot of a trajectory: of columns that names or patterns choose, or of the usual ones.

    Raises:
        SimulateError: an ending that is not known, no matplotlib, or a file that cannot be written.
        UnknownNameError: a name that chooses nothing.
    """
    check_plot(path)
    write_picture(path, trajectory.scene.name, partial(draw, trajectory, names=names), _facts(trajectory))


def write_picture(
    path: Path, title: str, picture: Callable[[str], bytes], facts: Sequence[tuple[str, str]] = ()
) -> None:
    """Write a picture, made as "svg", "pdf" or "png", to a file of `PLOTS`; a page says the facts beside it.

    Raises:
        SimulateError: the file cannot be written.
    """
    kind = path.suffix.lower()
    if kind != ".html":
        write_whole(path, picture(kind[1:]))
        return
    svg = picture("svg").decode()
    inside = {"title": in_html(title), "picture": svg[svg.index("<svg") :], "facts": Table(("", ""), facts)}
    write_whole(path, render("plot/page.html.jinja", inside))


def figure(trajectory: Trajectory, names: Sequence[str] = ()) -> Figure:
    """Return a plot as a figure of matplotlib, which a notebook shows; arguments as for `plot`.

    Raises:
        SimulateError: matplotlib is not installed.
        UnknownNameError: a name that chooses nothing.
    """
    parts = panels(trajectory, names)
    check_plot()
    count = len(trajectory.t) * sum(len(part.curves) for part in parts)
    return _plot(trajectory, parts).figure(count)


def draw(trajectory: Trajectory, kind: str, names: Sequence[str] = ()) -> bytes:
    """Return the picture as "svg", "pdf" or "png"; the same trajectory, the same bytes."""
    return _plot(trajectory, panels(trajectory, names)).picture(kind)


def _plot(trajectory: Trajectory, parts: Sequence[Panel]) -> FilledFigure:
    """Return the axes of a run, one below the other."""

    def fill(figure: Any) -> None:
        axes: Any = figure.subplots(len(parts), 1, sharex=True, squeeze=False)[:, 0]
        for axis, part in zip(axes, parts, strict=True):
            _draw(axis, part, trajectory)
        if parts:
            axes[-1].set_xlabel("$t$, s" if trajectory.columns[0].unit else "$t$")
            figure.align_ylabels(axes)

    return FilledFigure(trajectory.scene.name, (8.0, max(2.2, 0.4 + 1.9 * len(parts))), fill)


def _draw(axis: Any, part: Panel, trajectory: Trajectory) -> None:
    """Draw the curves of one axis."""
    for one in part.curves[:MOST_LINES]:
        style = "steps-post" if one.column.name in trajectory.held else "default"
        axis.plot(trajectory.t, one.values, label=_label(one), linewidth=1.0, drawstyle=style)
    more = len(part.curves) - MOST_LINES
    axis.set_title(part.title + (f" (and {more} more)" if more > 0 else ""), loc="left", fontsize=9)
    axis.set_ylabel(part.unit).set_parse_math(False)  # a unit is a stranger's text
    axis.grid(alpha=0.3)
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9)
    for event in trajectory.events:
        axis.axvline(event.t, color="0.5", linewidth=0.6, linestyle=":")


def _label(curve: Curve) -> str:
    """Return what a curve is called; by its name where matplotlib does not know a letter of its symbol."""
    from matplotlib.mathtext import MathTextParser

    try:
        MathTextParser("path").parse(curve.label)
    except ValueError:
        return curve.column.words
    return curve.label


def _facts(trajectory: Trajectory) -> list[tuple[str, str]]:
    """Return what is known of the run."""
    facts = [("scene", trajectory.scene.name)]
    if trajectory.method:
        facts += [
            ("method", f"{trajectory.method}, tolerances {trajectory.rtol:g} relative, {trajectory.atol:g} absolute"),
            ("steps", f"{trajectory.steps}"),
            ("ended by", trajectory.stopped),
        ]
    facts += [(words, f"{value:.3g}") for words, value in trajectory.monitor_rows]
    facts += [(f"event {event.formula}", f"t = {event.t!r} s") for event in trajectory.events]
    facts += [("saturation", line) for line in trajectory.cut_lines]
    return facts + [("note", line) for line in trajectory.notes]
