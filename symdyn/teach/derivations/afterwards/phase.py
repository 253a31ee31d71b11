"""Steps: the energy landscape and the phase portrait of one freedom, the landscape of two."""

from __future__ import annotations

import math

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.draw import Text
from symdyn.emit.print import latex_symbols
from symdyn.graph import Expr, evaluate
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.afterwards.charts import (
    DASHED,
    FAINT,
    SOLID,
    STABLE,
    UNSTABLE,
    Curve,
    Panel,
    chart,
    contours,
    round_up,
)
from symdyn.teach.derivations.afterwards.equilibria import Rests
from symdyn.teach.derivations.afterwards.reduced import GRID, Reduced
from symdyn.teach.document import Block, Letter, Picture, Step
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen

BELOW, ABOVE = (0.06, 0.25, 0.55, 0.85), (1.3, 1.8)
"""Energies of curves, from the deepest valley to the lowest pass, and beyond the highest."""

PLACES, LEVELS = 61, 14
"""Of a landscape over two coordinates: places along each, and lines."""


def phase_step(lesson: Lesson, left: Reduced) -> Step | None:
    """Return V over r, and below it the curves of constant energy; None where V has no valley and no hill there."""
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
    letter = lesson.called("V:", Letter("V"))
    lines = [Curve(np.stack([x, np.where(level >= V, level, np.nan)], axis=1), FAINT, size=0.8) for level in levels]
    energy = Text.of_name(lesson.letters.latex("V"))
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
