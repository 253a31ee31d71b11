"""Curves over axes, drawn as pictures of mechanisms are: the same style sheet, so the same in every format.

A chart is a column of panels, which share a width. Looks are classes of the style sheet of `symdyn.draw`; curves differ
by dashes too, so that nobody has to tell colours apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import Diagram, Text

WIDE, HIGH = 420.0, 190.0  # of a panel, units of the picture
GAP = 62.0  # between panels
TICKS = 6  # at most, along an axis
NARROW = 0.8  # of the width of a text that lettering reckons on the wide side
SOLID, DASHED, DOTTED, FAINT = "link body0", "link body1 sense", "link body2 gap", "stem"
"""Looks of curves."""

STABLE, UNSTABLE = "particle body0", "com"
"""Looks of marks: filled for what is stable, empty for what is not."""


@dataclass(frozen=True)
class Curve:
    """A curve.

    Attributes:
        points: shape (k, 2), in units of the axes; it is interrupted where it leaves the panel or has no value.
        look: one of the looks above.
        name: in the legend; None for none.
    """

    points: Array
    look: str = SOLID
    name: Text | None = None
    size: float = 2.0


@dataclass(frozen=True)
class Panel:
    """Axes and what is drawn between them.

    Attributes:
        x, y: what the axes show, with units.
        low, high: corners, in units of the axes, shape (2,).
        turns: whether each axis is an angle, marked in parts of π.
        marks: points with their looks.
    """

    x: Text
    y: Text
    low: tuple[float, float]
    high: tuple[float, float]
    curves: Sequence[Curve]
    marks: Sequence[tuple[tuple[float, float], str]] = ()
    turns: tuple[bool, bool] = (False, False)
    high_units: float = HIGH


def chart(title: str, panels: Sequence[Panel], written: Callable[[float], str], prefix: str) -> str:
    """Return panels one below the other as SVG; `written` writes numbers, `prefix` stands in front of ids."""
    sheet, top = Diagram(title, "curves"), 0.0
    for panel in panels:
        top = _panel(sheet, panel, top, written) + GAP
    return sheet.svg(prefix)


def _panel(sheet: Diagram, panel: Panel, top: float, written: Callable[[float], str]) -> float:
    """Draw one panel and return where it ends."""
    named = [curve for curve in panel.curves if curve.name is not None]
    for k, curve in enumerate(named):
        y = top + k * 1.25 * sheet.FONT
        sheet.line(curve.look, [(6.0, y), (44.0, y)], curve.size)
        assert curve.name is not None, "those alone are listed"
        sheet.text(curve.name, 54.0 + NARROW * curve.name.width / 2, y)
    top += len(named) * 1.25 * sheet.FONT + (14.0 if named else 0.0)
    low, high = np.array(panel.low), np.array(panel.high)
    size = np.array([WIDE, panel.high_units])

    def placed(points: Array) -> Array:
        part = (np.asarray(points, dtype=np.float64) - low) / (high - low)
        return np.asarray(np.stack([part[..., 0] * size[0], top + (1 - part[..., 1]) * size[1]], axis=-1))

    bottom = top + float(size[1])
    for value, name in _ticks(panel.low[0], panel.high[0], panel.turns[0], written):
        x = float(placed(np.array([value, panel.low[1]]))[0])
        sheet.line("leader", [(x, top), (x, bottom)], 0.5)
        sheet.text(name, x, bottom + 1.15 * sheet.FONT)
    for value, name in _ticks(panel.low[1], panel.high[1], panel.turns[1], written):
        y = float(placed(np.array([panel.low[0], value]))[1])
        sheet.line("leader", [(0.0, y), (WIDE, y)], 0.5)
        sheet.text(name, -9.0 - name.width / 2, y)
    sheet.line("stem", [(0.0, top), (0.0, bottom), (WIDE, bottom)])
    sheet.text(panel.y, panel.y.width / 2 - 20, top - 1.1 * sheet.FONT)
    sheet.text(panel.x, WIDE + 10 + panel.x.width / 2, bottom)
    for curve in panel.curves:
        inside = np.all((curve.points >= low - 1e-9) & (curve.points <= high + 1e-9), axis=1)  # false where it is NaN
        cuts = np.flatnonzero(np.diff(inside.astype(int))) + 1
        for part in np.split(np.arange(len(inside)), cuts):
            if len(part) > 1 and inside[part[0]]:
                sheet.line(curve.look, placed(_thinned(curve.points[part])), curve.size)
    for at, look in panel.marks:
        if np.all(np.array(at) >= low) and np.all(np.array(at) <= high):
            sheet.dot(look, placed(np.array(at)), 5.0)
    return bottom


def _thinned(points: Array, most: int = 160) -> Array:
    """Return a curve with fewer points."""
    return np.asarray(points[np.unique(np.linspace(0, len(points) - 1, min(most, len(points))).round().astype(int))])


def _ticks(low: float, high: float, turns: bool, written: Callable[[float], str]) -> list[tuple[float, Text]]:
    """Return round numbers between two, and how they are written; of angles parts of π where these are few."""
    if turns and high - low > 2.5:
        step = next(one for one in (Fraction(1, 4), Fraction(1, 2), *map(Fraction, (1, 2, 5, 10, 20, 50)))
                    if (high - low) / (float(one) * math.pi) <= TICKS)  # fmt: skip
        first, last = math.ceil(low / (float(step) * math.pi) - 1e-9), math.floor(high / (float(step) * math.pi) + 1e-9)
        return [(float(k * step) * math.pi, Text.as_written(_part(k * step))) for k in range(first, last + 1)]
    size = round_up((high - low) / TICKS)
    first, last = math.ceil(low / size - 1e-9), math.floor(high / size + 1e-9)
    return [(k * size, Text.as_written(written(k * size))) for k in range(first, last + 1)]


def round_up(size: float) -> float:
    """Return the next round number."""
    power = 10.0 ** math.floor(math.log10(size))
    return float(next(one * power for one in (1, 2, 5, 10) if one * power >= size * (1 - 1e-9)))


def _part(x: Fraction) -> str:
    """Return x π as it is written."""
    sign, over = "−" if x < 0 else "", abs(x.numerator)
    if not x:
        return "0"
    below = f"/{x.denominator}" if x.denominator > 1 else ""
    return f"{sign}{'' if over == 1 else over}π{below}"


def contours(x: Array, y: Array, z: Array, level: float) -> list[Array]:
    """Return the lines z = level on a grid, z of shape (len(x), len(y)): polylines of shape (k, 2).

    Edges of cells are crossed where linear interpolation says; crossings of one cell are joined, in pairs.
    """
    over = z > level
    joins: dict[tuple[int, int, int], list[tuple[int, int, int]]] = {}
    cells = over[:-1, :-1].astype(int) + over[1:, :-1] + over[:-1, 1:] + over[1:, 1:]
    finite = np.isfinite(z[:-1, :-1] + z[1:, :-1] + z[:-1, 1:] + z[1:, 1:])
    for i, j in np.argwhere((cells > 0) & (cells < 4) & finite).tolist():
        edges = [(i, j, 0), (i + 1, j, 1), (i, j + 1, 0), (i, j, 1)]  # below, right, above, left
        ends = [((i, j), (i + 1, j)), ((i + 1, j), (i + 1, j + 1)), ((i, j + 1), (i + 1, j + 1)), ((i, j), (i, j + 1))]
        crossed = [edge for edge, (a, b) in zip(edges, ends, strict=True) if over[a] != over[b]]
        for a, b in zip(crossed[::2], crossed[1::2], strict=True):
            joins.setdefault(a, []).append(b)
            joins.setdefault(b, []).append(a)

    def point(edge: tuple[int, int, int]) -> tuple[float, float]:
        i, j, upward = edge
        k, m = (i, j + 1) if upward else (i + 1, j)
        part = (level - z[i, j]) / (z[k, m] - z[i, j])
        return float(x[i] + part * (x[k] - x[i])), float(y[j] + part * (y[m] - y[j]))

    found, left = [], set(joins)
    for start in sorted(joins, key=lambda edge: (len(joins[edge]), edge)):  # ends of open lines first
        if start not in left:
            continue
        way, here = [start], start
        left.discard(start)
        while (after := next((one for one in joins[here] if one in left), None)) is not None:
            left.discard(after)
            way.append(after)
            here = after
        if len(way) > 2 and start in joins[here]:
            way.append(start)
        if len(way) > 1:
            found.append(np.array([point(edge) for edge in way]))
    return found
