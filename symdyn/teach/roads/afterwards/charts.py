"""Curves over axes, drawn as pictures of mechanisms are: the same style sheet, so the same in every format.

A chart is a column of panels, which share a width. Looks are classes of the style sheet of `symdyn.draw`; curves differ
by dashes too, so that nobody has to tell colours apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from symdyn.draw import FONT, Array, Drawing, Item, Label, Put, Run, Shape, Text, Title, dot, path, svg

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


@dataclass
class _Sheet:
    written: Callable[[float], str]
    shapes: list[Shape] = field(default_factory=list)
    labels: list[Put] = field(default_factory=list)

    def text(self, text: Text, x: float, y: float) -> None:
        """Put a text with its middle at a point."""
        label = Label(f"label-{len(self.labels)}", text, np.array([[x, y]]), 0.0)
        self.labels.append(Put(label, np.zeros(2)))

    def line(self, look: str, *points: tuple[float, float], size: float = 1.0) -> None:
        self.shapes.append(path(look, np.array([points], dtype=np.float64), size=size))


def plain(text: str) -> Text:
    """Return words as they are lettered."""
    return Text((Run(text, "", 0),))


def chart(title: str, panels: Sequence[Panel], written: Callable[[float], str], prefix: str) -> str:
    """Return panels one below the other as SVG; `written` writes numbers, `prefix` stands in front of ids."""
    sheet, top = _Sheet(written), 0.0
    for panel in panels:
        top = _panel(sheet, panel, top) + GAP
    item = Item("curves", Title("{text}", text=title), 1, np.zeros(1), tuple(sheet.shapes))
    return svg(Drawing(title, (item,), tuple(sheet.labels)), prefix)


def _panel(sheet: _Sheet, panel: Panel, top: float) -> float:
    """Draw one panel and return where it ends."""
    named = [curve for curve in panel.curves if curve.name is not None]
    for k, curve in enumerate(named):
        y = top + k * 1.25 * FONT
        sheet.line(curve.look, (6.0, y), (44.0, y), size=curve.size)
        assert curve.name is not None, "those alone are listed"
        sheet.text(curve.name, 54.0 + NARROW * curve.name.width / 2, y)
    top += len(named) * 1.25 * FONT + (14.0 if named else 0.0)
    low, high = np.array(panel.low), np.array(panel.high)
    size = np.array([WIDE, panel.high_units])

    def placed(points: Array) -> Array:
        part = (np.asarray(points, dtype=np.float64) - low) / (high - low)
        return np.asarray(np.stack([part[..., 0] * size[0], top + (1 - part[..., 1]) * size[1]], axis=-1))

    bottom = top + float(size[1])
    for value, name in _ticks(panel.low[0], panel.high[0], panel.turns[0], sheet.written):
        x = float(placed(np.array([value, panel.low[1]]))[0])
        sheet.line("leader", (x, top), (x, bottom), size=0.5)
        sheet.text(name, x, bottom + 1.15 * FONT)
    for value, name in _ticks(panel.low[1], panel.high[1], panel.turns[1], sheet.written):
        y = float(placed(np.array([panel.low[0], value]))[1])
        sheet.line("leader", (0.0, y), (WIDE, y), size=0.5)
        sheet.text(name, -9.0 - name.width / 2, y)
    sheet.line("stem", (0.0, top), (0.0, bottom), (WIDE, bottom))
    sheet.text(panel.y, panel.y.width / 2 - 20, top - 1.1 * FONT)
    sheet.text(panel.x, WIDE + 10 + panel.x.width / 2, bottom)
    for curve in panel.curves:
        inside = np.all((curve.points >= low - 1e-9) & (curve.points <= high + 1e-9), axis=1)  # false where it is NaN
        cuts = np.flatnonzero(np.diff(inside.astype(int))) + 1
        for part in np.split(np.arange(len(inside)), cuts):
            if len(part) > 1 and inside[part[0]]:
                sheet.shapes.append(path(curve.look, placed(_thinned(curve.points[part]))[None], size=curve.size))
    for at, look in panel.marks:
        if np.all(np.array(at) >= low) and np.all(np.array(at) <= high):
            sheet.shapes.append(dot(look, placed(np.array(at))[None], 5.0))
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
        return [(float(k * step) * math.pi, plain(_part(k * step))) for k in range(first, last + 1)]
    span = (high - low) / TICKS
    power = 10.0 ** math.floor(math.log10(span))
    size = next(one * power for one in (1, 2, 5, 10) if one * power >= span * (1 - 1e-9))
    first, last = math.ceil(low / size - 1e-9), math.floor(high / size + 1e-9)
    return [(k * size, plain(written(k * size))) for k in range(first, last + 1)]


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


def with_unit(text: Text, unit: str) -> Text:
    """Return the words of an axis with its unit behind, as they are where it has none."""
    return Text((*text.runs, Run(f", {unit}", "", 0))) if unit else text
