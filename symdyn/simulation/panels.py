"""Runs in files: CSV and NumPy's .npz, plots as svg, pdf, png or html, and what moving pictures may be.

A plot of a run has axes of one unit each: coordinates, velocities, driving forces and energies over time.
"""

from __future__ import annotations

import fnmatch
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import FilledFigure, Reel, check_film as check_reel
from symdyn.dynamics.mechanism import TIME
from symdyn.emit import Contents, in_html, render, write
from symdyn.errors import DrawError, EmitError, SimulateError, UnknownNameError
from symdyn.extras import EXTRAS, install
from symdyn.simulation.columns import ENERGIES, FORCES, Column, missing
from symdyn.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symdyn.simulation.trajectory import Trajectory


def write_npz(trajectory: Trajectory, file: IO[bytes]) -> None:
    """Write t, q, qd, qdd, tau, each extra column by its name, the names of columns, and JSON of how it was made.

    Of runs with 31 digits, `low` is what q and qd are beyond their doubles.
    """
    scene = trajectory.scene
    arrays: dict[str, Any] = {name: getattr(trajectory, name) for name in ("t", "q", "qd", "qdd", "tau")}
    arrays |= dict(trajectory.extra) | ({} if trajectory.low is None else {"low": trajectory.low})
    arrays["coordinates"], arrays["velocities"] = np.array(scene.coordinates), np.array(scene.velocities)
    told = trajectory.about() | {"notes": list(trajectory.notes)}
    arrays["about"] = np.array(json.dumps(told, ensure_ascii=False))
    np.savez_compressed(file, **arrays)


WRITERS: Mapping[str, Callable[[Trajectory], Contents]] = {
    ".csv": lambda trajectory: trajectory.to_csv(),
    ".npz": lambda trajectory: partial(write_npz, trajectory),
}


PLOTS = (".svg", ".pdf", ".png", ".html")


def check_record(path: Path) -> None:
    """Raise SimulateError for an ending that no table has."""
    if path.suffix.lower() not in WRITERS:
        raise SimulateError(f"{path}: trajectories are written to {' or '.join(WRITERS)} files")


def check_film(path: Path, reel: Reel | None = None) -> None:
    """Raise SimulateError for an ending that no moving picture has, or what such a file cannot be."""
    try:
        check_reel(path, reel)
    except DrawError as fault:
        raise SimulateError(str(fault)) from None


def check_plot(path: Path | None = None) -> None:
    """Raise SimulateError where a plot cannot be made: an ending that is not known, or no matplotlib.

    Without a path it is shown, and not written.
    """
    if path is not None and path.suffix.lower() not in PLOTS:
        raise SimulateError(f"{path}: plots are written to {', '.join(PLOTS)} files")
    if not EXTRAS["plot"].there:
        raise SimulateError(f"plots need matplotlib; {install('plot')}")


CHECKS: Mapping[str, Callable[..., None]] = {"table": check_record, "plot": check_plot, "film": check_film}
"""What raises SimulateError where a file cannot be a table of a run, a plot or a film, before anything is computed."""


def record(trajectory: Trajectory, path: Path) -> None:
    """Write a trajectory to a .csv or .npz file.

    Raises:
        SimulateError: another ending, or a file that cannot be written.
    """
    check_record(path)
    write_whole(path, WRITERS[path.suffix.lower()](trajectory))


def write_whole(path: Path, contents: Contents) -> None:
    """Write a file, all of it or nothing.

    Raises:
        SimulateError: it cannot be written, and why.
    """
    try:
        write({path.name: contents}, path.parent)
    except EmitError as fault:
        raise SimulateError(str(fault)) from None


USUAL = (
    "coordinates",
    "velocities",
    "inputs",
    FORCES,
    "outputs",
    ENERGIES,
    "error of the energy balance",
    "residual of the loops",
)
"""Kinds of columns that are drawn where nobody chooses."""

NOTHING = 1e-12
"""Forces below it, over the largest of them and at least 1 N, are zero: left out where nobody asks for them."""


@dataclass(frozen=True)
class Curve:
    """One curve: its column, its numbers, shape (N,), and what they are counted from."""

    column: Column
    values: Array
    zero: float = 0.0

    @property
    def label(self) -> str:
        """What it is called: a symbol between dollars, or words."""
        symbol = self.column.latex
        name = f"${symbol}$" if symbol else self.column.words
        sign = "\N{MINUS SIGN}" if self.zero > 0 else "+"
        return name + (f" {sign} {abs(self.zero):.5g} {self.column.unit}".rstrip() if self.zero else "")


@dataclass(frozen=True)
class Panel:
    """Curves that share an axis, and so a unit."""

    curves: tuple[Curve, ...]

    @property
    def title(self) -> str:
        """What they are."""
        return ", ".join(dict.fromkeys(one.column.kind for one in self.curves))

    @property
    def unit(self) -> str:
        """Their unit as it is printed, such as "m/s²"."""
        return self.curves[0].column.printed_unit


def panels(trajectory: Trajectory, names: Sequence[str] = ()) -> list[Panel]:
    """Return the axes of a plot, one a unit: of the columns that names choose, or of the usual kinds.

    Raises:
        UnknownNameError: a name or pattern that chooses nothing.
    """
    every, (_, table) = trajectory.columns, trajectory.table()
    numbers = {one.name: x for one, x in reversed(list(zip(every, table.T, strict=True)))}
    if names:
        wanted = chosen([one.name for one in every], names, trajectory.scene.name)
        picked = [one for name in wanted for one in every if one.name == name]
        by_unit = {unit: [one for one in picked if one.unit == unit] for unit in (one.unit for one in picked)}
        groups = list(by_unit.values())
    else:
        still = _zero([one for one in every if one.kind == FORCES], numbers)
        shown = sorted((one for one in every if one.kind in USUAL), key=lambda one: USUAL.index(one.kind))
        moved = [one for one in shown if one.name not in still]
        groups = []
        for _, kind in groupby(moved, key=lambda one: one.kind):
            some = list(kind)
            groups += [[one for one in some if one.unit == unit] for unit in dict.fromkeys(one.unit for one in some)]
    return [Panel(_from_zeros([(one, numbers[one.name]) for one in group])) for group in groups]


def chosen(every: Sequence[str], names: Iterable[str], where: str) -> tuple[str, ...]:
    """Return the columns among all that names and patterns, such as "point_*", choose, in the order they are given.

    Raises:
        UnknownNameError: one that chooses nothing.
    """
    found: list[str] = []
    for name in names:
        wanted = [] if not isinstance(name, str) else [name] if name in every else fnmatch.filter(every, name)
        if not wanted:
            raise UnknownNameError(f"{where}: {missing(name, every)}")
        found += wanted
    return tuple(one for one in dict.fromkeys(found) if one != TIME or TIME in names)


def _zero(forces: Sequence[Column], numbers: dict[str, Array]) -> set[str]:
    """Return the names of forces that are zero all the time."""
    sizes = {one.name: float(np.abs(numbers[one.name]).max(initial=0.0)) for one in forces}
    return {name for name, size in sizes.items() if size <= NOTHING * max(1.0, *sizes.values())}


def _from_zeros(group: Sequence[tuple[Column, Array]]) -> tuple[Curve, ...]:
    """Return curves, energies far from zero counted from their least value, or nobody would see how they move."""
    energies = [x for column, x in group if column.kind == ENERGIES and len(x)]
    moved = max((float(np.ptp(x)) for x in energies), default=0.0)
    found = []
    for column, x in group:
        away = float(np.abs(x).min(initial=np.inf))
        far = column.kind == ENERGIES and len(energies) > 1 and np.isfinite(moved) and away > max(moved, NOTHING)
        zero = float(x.min()) if far else 0.0
        found.append(Curve(column, x - zero, zero))
    return tuple(found)


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
