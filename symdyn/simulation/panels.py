"""Runs in files: CSV and NumPy's .npz, plots as svg, pdf, png or html, and what moving pictures may be.

A plot of a run has panels of one unit each, or those that a user groups: coordinates, velocities, driving forces and
energies over time, and reactions where the run has them. How well laws were kept is told by monitors, and drawn where
it is asked for.
"""

from __future__ import annotations

import fnmatch
import json
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import native
from symdyn.draw import FilledFigure, Reel, check_film as check_reel
from symdyn.dynamics.mechanism import TIME
from symdyn.emit import in_html, render, write_file
from symdyn.errors import DrawError, SimulateError, UnknownNameError
from symdyn.extras import EXTRAS, install
from symdyn.frozen import dataclass, replace
from symdyn.scene import Scene
from symdyn.simulation.columns import ENERGIES, FORCES, Column, missing
from symdyn.table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from symdyn.simulation.trajectory import Trajectory


def write_npz(trajectory: Trajectory, path: Path) -> None:
    """Write a .npz file with t, q, qd, qdd, tau, each extra column and JSON of how it was made, with names and units.

    Of runs with 31 digits, `low` is what q and qd are beyond their doubles.

    Raises:
        SimulateError: another ending, or a file that cannot be written.
    """
    check_record(path, (".npz",))
    scene = trajectory.scene
    arrays: dict[str, Any] = {name: getattr(trajectory, name) for name in ("t", "q", "qd", "qdd", "tau")}
    arrays |= dict(trajectory.extra) | ({} if trajectory.low is None else {"low": trajectory.low})
    arrays["coordinates"], arrays["velocities"] = np.array(scene.coordinates), np.array(scene.velocities)
    told = trajectory.about() | {"notes": list(trajectory.notes)}
    told["units"] = {one.name: one.unit for one in trajectory.columns}  # in the order of the columns
    arrays["about"] = np.array(json.dumps(told, ensure_ascii=False))
    write_file(path, lambda file: np.savez_compressed(file, **arrays), SimulateError)


TABLES = (".csv", ".npz")

PLOTS = (".svg", ".pdf", ".png", ".html")


def check_record(path: Path, endings: Sequence[str] = TABLES) -> None:
    """Raise SimulateError for an ending that no table has."""
    if path.suffix.lower() not in endings:
        raise SimulateError(f"{path}: trajectories are written to {' or '.join(endings)} files")


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


USUAL = ("coordinates", "velocities", "inputs", "states", FORCES, "reactions", "multipliers", "outputs", ENERGIES)
"""Kinds of columns that are drawn where nobody chooses."""

PUSHING = (FORCES, "reactions", "multipliers")

NOTHING = 1e-12
"""Forces of a kind and unit below it, over the largest or 1, are zero: left out where nobody asks for them."""


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


Names = Sequence[str | Sequence[str]]
"""Names of columns or patterns; those of a list within share a panel."""


@dataclass(frozen=True)
class Panel:
    """Curves that share an axis, and what they are with their unit, as "coordinates, rad"."""

    curves: tuple[Curve, ...]
    title: str

    @property
    def mixed(self) -> bool:
        """Whether they have several units."""
        return len({one.column.unit for one in self.curves}) > 1


def panels(trajectory: Trajectory, names: Names = (), degrees: bool = False) -> list[Panel]:
    """Return the panels of a plot: of the columns that names choose, or of the usual kinds; angles in rad or degrees.

    Raises:
        UnknownNameError: a name or pattern that chooses nothing.
    """
    every, (_, table) = trajectory.columns, trajectory.table()
    numbers = {one.name: x for one, x in reversed(list(zip(every, table.T, strict=True)))}
    if degrees:
        numbers |= {one.name: np.degrees(numbers[one.name]) for one in every if one.unit in ANGLES}
        every = tuple(replace(one, unit=ANGLES.get(one.unit, one.unit)) for one in every)
    groups: dict[Hashable, list[Column]] = {}
    for k, one in enumerate(names := list(names)):
        loose = isinstance(one, str) or not isinstance(one, Iterable)
        some: Iterable[Any] = [one] if loose else one
        for name in chosen(trajectory.names, some, trajectory.scene):
            column = next(one for one in every if one.name == name)
            group = groups.setdefault(column.unit if loose else k, [])
            group += [] if column in group else [column]
    if names and not groups:
        raise UnknownNameError(f"{trajectory.scene.name}: {missing('', trajectory.names, trajectory.scene)}")
    if not names:
        for usual in sorted((one for one in every if one.kind in USUAL), key=lambda one: USUAL.index(one.kind)):
            groups.setdefault((usual.kind, usual.unit), []).append(usual)
        groups = {key: _moved(some, numbers) if some[0].kind in PUSHING else some for key, some in groups.items()}
    found = [some for some in groups.values() if some]
    titles = [_title(some, [one.kind for one in some]) for some in found]
    return [
        Panel(
            _from_zeros([(one, numbers[one.name]) for one in some]),
            title if titles.count(title) == 1 else _title(some, [one.words for one in some]),
        )
        for some, title in zip(found, titles, strict=True)
    ]


ANGLES = {f"rad{per}": f"deg{per}" for per in ("", "/s", "/s^2")}


def _title(group: Sequence[Column], words: Sequence[str]) -> str:
    units = filter(None, dict.fromkeys(one.printed_unit for one in group))
    return ", ".join(dict.fromkeys([*words, " and ".join(units)])).removesuffix(", ")


def chosen(every: Sequence[str], names: Iterable[str], scene: Scene) -> tuple[str, ...]:
    """Return the columns among all that names and patterns, such as "point_*", choose, in the order they are given.

    Raises:
        UnknownNameError: one that chooses nothing.
    """
    found: list[str] = []
    for name in names:
        wanted = [] if not isinstance(name, str) else [name] if name in every else fnmatch.filter(every, name)
        if not wanted:
            raise UnknownNameError(f"{scene.name}: {missing(name, every, scene)}")
        found += wanted
    return tuple(one for one in dict.fromkeys(found) if one != TIME or TIME in names)


def _moved(forces: Sequence[Column], numbers: Mapping[str, Array]) -> list[Column]:
    sizes = [float(np.abs(numbers[one.name]).max(initial=0.0)) for one in forces]
    return [one for one, size in zip(forces, sizes, strict=True) if not size <= NOTHING * max(1.0, *sizes)]


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


@dataclass(frozen=True)
class PlotSize:
    """Width of a plot and height of its panels, inches, size of its letters, points, and whether it has a heading."""

    width: float
    height: float = 1.9
    letters: float = 9.0
    headed: bool = True


SIZES: Mapping[str | None, PlotSize] = {
    None: PlotSize(8.0),
    "column": PlotSize(3.3, 1.1, 7.0, headed=False),
    "slide": PlotSize(11.0, 2.7, 16.0),
}
"""Sizes by name: of a paper's column, 84 mm, whose caption is its heading, and of a slide."""


def size_of(width: float | str | None) -> PlotSize:
    """Return the size of a plot; SimulateError of a width that is none."""
    if width is None or isinstance(width, str):
        if width not in SIZES:
            raise SimulateError(f'width = "{width}": write "column", "slide" or inches')
        return SIZES[width]
    (inches,) = native(float, width)
    if not 1 <= inches <= 50:
        raise SimulateError(f"width = {inches:g} in: give 1 to 50 inches")
    return PlotSize(inches) if inches >= 5 else replace(SIZES["column"], width=inches)


def plot(trajectory: Trajectory, path: Path, names: Names = (), width: float | str | None = None) -> None:
    """Write a plot of a trajectory: of columns that names or patterns choose, or of the usual ones.

    Raises:
        SimulateError: an ending that is not known, no matplotlib, or a file that cannot be written.
        UnknownNameError: a name that chooses nothing.
    """
    check_plot(path)
    write_picture(path, trajectory.scene.name, partial(draw, trajectory, names=names, width=width), _facts(trajectory))


def write_picture(
    path: Path, title: str, picture: Callable[[str], bytes], facts: Sequence[tuple[str, str]] = ()
) -> None:
    """Write a picture, made as "svg", "pdf" or "png", to a file of `PLOTS`; a page says the facts beside it.

    Raises:
        SimulateError: the file cannot be written.
    """
    kind = path.suffix.lower()
    if kind != ".html":
        write_file(path, picture(kind[1:]), SimulateError)
        return
    svg = picture("svg").decode()
    inside = {"title": in_html(title), "picture": svg[svg.index("<svg") :], "facts": Table(("", ""), facts)}
    write_file(path, render("plot/page.html.jinja", inside), SimulateError)


def figure(
    trajectory: Trajectory,
    names: Names = (),
    axes: Axes | Sequence[Axes] | None = None,
    width: float | str | None = None,
    x: str | None = None,
    degrees: bool = False,
) -> Figure:
    """Return a plot as a figure of matplotlib, which a notebook shows; arguments as of `Trajectory.plot`.

    Raises:
        SimulateError: matplotlib is not installed, or no such width.
        DrawError: another number of axes than of panels.
        UnknownNameError: a name that chooses nothing.
    """
    parts = panels(trajectory, names, degrees)
    over = None if x is None else panels(trajectory, [x], degrees)[0].curves[0]
    check_plot()
    count = len(trajectory.t) * sum(len(part.curves) for part in parts)
    size = size_of(width) if axes is None else replace(size_of(width), headed=False)
    return _plot(trajectory, parts, size, over).figure(count, axes)


def draw(trajectory: Trajectory, kind: str, names: Names = (), width: float | str | None = None) -> bytes:
    """Return the picture as "svg", "pdf" or "png"; the same trajectory, the same bytes."""
    return _plot(trajectory, panels(trajectory, names), size_of(width)).picture(kind)


def _plot(trajectory: Trajectory, parts: Sequence[Panel], size: PlotSize, over: Curve | None = None) -> FilledFigure:
    lines = [min(len(part.curves), MOST_LINES) * size.headed for part in parts]
    heights = [max(size.height, 0.3 + size.letters / 48 * count) for count in lines]  # of legends beside them

    def fill(figure: Any) -> None:
        ratios = {"height_ratios": heights}
        axes: Any = figure.subplots(len(parts), 1, sharex=True, squeeze=False, gridspec_kw=ratios)[:, 0]
        _fill(axes, trajectory, parts, size.headed, size.letters / 9.0, over)

    height = max(2.2 if size.headed else 0.0, 0.4 + sum(heights))
    return FilledFigure(trajectory.scene.name, (size.width, height), fill, size.letters, size.headed)


def _fill(
    axes: Sequence[Any],
    trajectory: Trajectory,
    parts: Sequence[Panel],
    beside: bool = False,
    line: float = 1.0,
    over: Curve | None = None,
) -> None:
    """Draw panels over t, or a curve, what curves are called inside or beside, in lines of a width, points."""
    along = trajectory.t if over is None else over.values
    for axis, part in zip(axes, parts, strict=True):
        there = [words.partition(" (run ")[0] for words in axis.get_legend_handles_labels()[1]]
        for one in part.curves[:MOST_LINES]:
            label = _label(one, part.mixed)
            label += f" (run {there.count(label) + 1})" * (label in there)
            style = "steps-post" if one.column.name in trajectory.held and over is None else "default"
            axis.plot(along, one.values, label=label, linewidth=line, drawstyle=style)
        more = len(part.curves) - MOST_LINES
        title = part.title + (f" (and {more} more)" if more > 0 else "")
        axis.set_title(title, loc="left", fontsize="medium").set_parse_math(False)  # a unit is a stranger's text
        axis.grid(alpha=0.3)
        outside: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "frameon": False}
        axis.legend(**(outside if beside else {"loc": "best", "framealpha": 0.7}), fontsize="medium")
        for event in trajectory.events if over is None else ():
            axis.axvline(event.t, color="0.5", linewidth=0.6, linestyle=":")
        if over is not None:
            told = title if part.curves[1:] else _label(part.curves[0], mixed=True)
            axis.set_ylabel(told).set_parse_math(not part.curves[1:])
    if parts and over is not None:
        axes[-1].set_xlabel(_label(over, mixed=True))
    elif parts:
        axes[-1].set_xlabel("$t$, s" if trajectory.columns[0].unit else "$t$")


def _label(curve: Curve, mixed: bool = False) -> str:
    """Return what a curve is called, among mixed ones with its unit; its name where matplotlib lacks a letter."""
    from matplotlib.mathtext import MathTextParser

    unit = f", {curve.column.printed_unit}" if mixed and curve.column.unit else ""
    try:
        MathTextParser("path").parse(curve.label + unit)
    except ValueError:
        return curve.column.words
    return curve.label + unit


def _facts(trajectory: Trajectory) -> list[tuple[str, str]]:
    facts = [("scene", trajectory.scene.name)]
    tolerances = f", tolerances {trajectory.rtol:g} relative, {trajectory.atol:g} absolute"
    if trajectory.method:
        facts += [
            ("method", trajectory.method + tolerances * (trajectory.rtol > 0)),
            ("steps", f"{trajectory.steps}"),
            ("ended by", trajectory.stopped),
        ]
    facts += [(words, f"{value:.3g}") for words, value in trajectory.monitor_rows]
    facts += [(f"event {event.formula}", f"t = {event.t!r} s") for event in trajectory.events]
    facts += [("saturation", line) for line in trajectory.cut_lines]
    return facts + [("note", line) for line in trajectory.notes]
