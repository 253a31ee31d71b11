"""Charts of curves over axes, and the steps that show them: energy landscapes and the phase portrait of one freedom.

A chart is a column of panels, which share a width. Looks are classes of the style sheet of `symdyn.draw`, as those of
pictures of mechanisms, so charts look the same in every format. Curves differ by dashes too, not by colour alone. The
energy landscape is shown of one freedom and of two.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.draw import Diagram, Text
from symdyn.emit.print import latex_symbols
from symdyn.frozen import dataclass
from symdyn.graph import Expr, evaluate
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.elsewhere import elsewhere
from symdyn.teach.derivations.equilibria import Rests
from symdyn.teach.derivations.reduced import GRID, Reduced
from symdyn.teach.document import Block, Letter, Picture, Step
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen

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
    """A curve."""

    points: Array  # shape (k, 2), in units of the axes; it is interrupted where it leaves the panel or has no value
    look: str = SOLID  # one of the looks above
    name: Text | None = None  # in the legend; None for none
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


BELOW, ABOVE = (0.06, 0.25, 0.55, 0.85), (1.3, 1.8)
"""Energies of curves, from the deepest valley to the lowest pass, and beyond the highest."""

PLACES, LEVELS = 61, 14
"""Of a landscape over two coordinates: places along each, and lines."""


def phase_step(lesson: Lesson, left: Reduced) -> Step | None:
    """Return V over r, and below it the curves of constant energy; None where V has no valley and no hill there."""
    if told := elsewhere(lesson, "phase"):
        return Step("phase", told, ())
    low, high = span(left.chosen, left.q, left.turns)
    x = np.linspace(low, high, GRID)
    m, V = left.at(x)
    rests = left.level(low, high)
    finite = V[np.isfinite(V)]
    if not rests or not len(finite) or np.ptp(finite) <= 1e-12 * (1 + np.abs(finite).max()):
        return None
    valley = float(finite.min())
    passes = sorted(_at(left, place) for place, curvature, _ in rests if curvature < 0)
    passes = [one for one in passes if one > valley + 1e-9 * (1 + abs(valley))]
    here = _energy(left)
    lowest, highest = (passes[0], passes[-1]) if passes else (max(here, valley + 1e-9), max(here, valley + 1e-9))
    levels = [valley + part * (lowest - valley) for part in BELOW]
    levels += [valley + part * (highest - valley) for part in ABOVE]
    top = max(levels)
    at_valley = float(m[np.nanargmin(np.where(np.isfinite(V), V, np.inf))])
    fastest = math.sqrt(2 * (top - valley) / at_valley) * 1.05
    curves = [curve for level in levels for curve in _curves(x, m, V, level, SOLID)]
    curves += [curve for level in passes for curve in _curves(x, m, V, level, DASHED)]
    q, rate = _spelled(lesson, left.r)
    shown = lesson.scene.shown_unit
    unit, per_second = (shown("rad"), shown("rad/s")) if left.turns else (shown("m"), shown("m/s"))
    bottom, ceiling = valley - 0.08 * (top - valley), valley + 1.06 * (top - valley)
    marks = [(place, STABLE if curvature > 0 else UNSTABLE) for place, curvature, _ in rests]
    marks += [(-math.pi, look) for place, look in marks if left.turns and abs(place - math.pi) < 1e-6]
    of = "W" if left.led else "V"
    letter = lesson.called("V:", Letter(of))
    lines = [Curve(np.stack([x, np.where(level >= V, level, np.nan)], axis=1), FAINT, size=0.8) for level in levels]
    energy = Text.of_name(lesson.letters.latex(of))
    hill = Panel(
        q.with_unit(unit), energy.with_unit(shown("J")), (low, bottom), (high, ceiling),
        [*lines, Curve(np.stack([x, V], axis=1))], [((place, _at(left, place)), look) for place, look in marks],
        (left.turns, False), 130.0,
    )  # fmt: skip
    flow = Panel(
        q.with_unit(unit), rate.with_unit(per_second), (low, -fastest), (high, fastest), curves,
        [((place, 0.0), look) for place, look in marks], (left.turns, False),
    )  # fmt: skip
    title = lesson.text("phase.alt", scene=lesson.scene.name)
    svg = chart(title, [hill, flow], lesson.written, "phase-")
    blocks: list[Block] = [Picture(svg, lesson.say("phase.caption", V=letter), title, "phase")]
    others = [named(lesson.state.q[k]) for k in (*left.cyclic, *left.led)]
    if left.cyclic:
        blocks.append(lesson.say("phase.momenta", names=together(others)))
    if passes:
        blocks.append(lesson.say("phase.pass"))
    key = "led" if left.led else "kept" if left.cyclic else "plain"
    claim = lesson.say(f"phase.{key}", q=named(left.q))
    return Step("phase", claim, tuple(blocks), lesson.say("phase.reason"), show=("phase", "energies"))


def landscape_step(lesson: Lesson, rests: Rests, chosen: Chosen) -> Step | None:
    """Return the lines of equal potential energy over two coordinates; None where others decide."""
    if len(rests.q) != 2:
        return None
    if told := elsewhere(lesson, "landscape"):
        return Step("landscape", told, ())
    state, units = lesson.state, SceneUnits(lesson.scene).coordinates
    which = [state.q.index(q) for q in rests.q]
    places = np.array([place.q[which] for place in rests.places]).reshape(-1, 2)
    turns = [units[k] == "rad" for k in which]
    spans = [span(chosen, q, turns[j], places[:, j]) for j, q in enumerate(rests.q)]
    x, y = (np.linspace(low, high, PLACES) for low, high in spans)
    values = {**chosen.values, rests.q[0]: x[:, None], rests.q[1]: y[None, :]}
    with np.errstate(all="ignore"):
        (z,) = evaluate([lesson.energy.P], Batches(), values)
    z = np.broadcast_to(np.asarray(z, dtype=np.float64), (PLACES, PLACES))
    good = z[np.isfinite(z)]
    if not len(good) or np.ptp(good) <= 1e-12 * (1 + np.abs(good).max()):
        return None
    low, high = float(good.min()), float(np.quantile(good, 0.97))
    step = round_up((high - low) / LEVELS)
    first = math.ceil(low / step + 1e-9)
    levels = [k * step for k in range(first, math.floor(high / step) + 1)]
    curves = [Curve(line, SOLID, size=1.4) for level in levels for line in contours(x, y, z, level)]
    marks = [
        (at, STABLE if place.kind == "stable" else UNSTABLE)
        for place in rests.places
        for at in _images(place.q[which], turns)
    ]
    names = [_spelled(lesson, k)[0].with_unit(lesson.scene.shown_unit(units[k])) for k in which]
    panel = Panel(
        names[0], names[1], (spans[0][0], spans[1][0]), (spans[0][1], spans[1][1]), curves,
        marks, (turns[0], turns[1]), 330.0,
    )  # fmt: skip
    title = lesson.text("landscape.alt", scene=lesson.scene.name)
    svg = chart(title, [panel], lesson.written, "landscape-")
    caption = lesson.say("landscape.caption", step=lesson.scene.in_shown_unit(lesson.written(step), "J"))
    claim = lesson.say("landscape", names=together([named(q) for q in rests.q]))
    shown = Picture(svg, caption, title, "landscape")
    return Step("landscape", claim, (shown,), lesson.say("landscape.reason"), show=("energies", "angles"))


def span(chosen: Chosen, q: Expr, turns: bool, places: Array | None = None) -> tuple[float, float]:
    """Return from where to where a coordinate is shown: a turn, or a way about where it is and rests."""
    if turns:
        return -math.pi, math.pi
    found = [chosen.values[q], *([] if places is None else places.tolist())]
    low, high = min(found), max(found)
    room = max(0.6 * (high - low), 0.4 * max(abs(low), abs(high)), 1e-3)
    return low - room, high + room


def _images(at: Array, turns: list[bool]) -> list[tuple[float, float]]:
    """Return a place and where else on a map of one turn it is: what is at π is at -π too."""
    both = [turn and abs(x - math.pi) < 1e-9 for x, turn in zip(at, turns, strict=True)]
    ways = [(float(x), -math.pi) if two else (float(x),) for x, two in zip(at, both, strict=True)]
    return [(a, b) for a in ways[0] for b in ways[1]]


def _at(left: Reduced, place: float) -> float:
    return float(left.at(np.array([place]))[1][0])


def _energy(left: Reduced) -> float:
    """Return ½ m ṙ² + V at the state of the lesson."""
    here, rate = left.chosen.values[left.q], left.chosen.values[left.lesson.state.qd[left.r]]
    m, V = left.at(np.array([here]))
    return float(0.5 * m[0] * rate**2 + V[0])


def _curves(x: Array, m: Array, V: Array, level: float, look: str) -> list[Curve]:
    """Return ṙ = ± √(2 (E - V)/m) where it is real, ended on the axis where it turns back."""
    over = np.where(np.isfinite(V) & (m > 0), level - V, -np.inf)
    real, found = over > 0, []
    cuts = np.flatnonzero(np.diff(real.astype(int))) + 1
    for part in np.split(np.arange(len(x)), cuts):
        if not real[part[0]]:
            continue
        up = np.stack([x[part], np.sqrt(2 * over[part] / m[part])], axis=1)
        ends = [_turn(x, over, k) for k in (part[0], part[-1] + 1)]
        head, tail = ([] if end is None else [[end, 0.0]] for end in ends)
        curve = np.array([*head, *up.tolist(), *tail])
        found += [Curve(curve, look, size=1.8), Curve(curve * [1, -1], look, size=1.8)]
    return found


def _turn(x: Array, over: Array, k: int) -> float | None:
    """Return where E = V between places k - 1 and k, None at the edges."""
    if not 0 < k < len(x) or not np.isfinite(over[k - 1] + over[k]):
        return None
    return float(x[k - 1] + (x[k] - x[k - 1]) * over[k - 1] / (over[k - 1] - over[k]))


def _spelled(lesson: Lesson, k: int) -> tuple[Text, Text]:
    """Return a coordinate and its rate as they are lettered."""
    symbols = latex_symbols(lesson.scene)
    state = lesson.state
    return Text.of_name(symbols[str(state.q[k].value)]), Text.of_name(symbols[str(state.qd[k].value)])
