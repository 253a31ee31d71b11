"""What a reader may try at a sentence: the parameter that crosses a threshold which the sentence states."""

from __future__ import annotations

import math

from symdyn.algebra import Form
from symdyn.errors import SymdynError
from symdyn.graph import Expr
from symdyn.teach.document import Try
from symdyn.teach.lesson import Lesson
from symdyn.teach.shown_state import Chosen

SPAN = 10.0
"""How many times its value, and what part of it, a threshold may be."""

STEPS = 200


def at_bound(lesson: Lesson, chosen: Chosen, value: Form) -> Try | None:
    """Return where |value| = 1 as one parameter changes, a rate before all others; None for what has no such place.

    The value is of parameters alone, such as g/(R Ω²), the cosine of a place that exists where this is below one.
    """
    parameters = {one.name: one for one in lesson.scene.parameters}
    names = list(dict.fromkeys(value.symbols))
    if not names or not set(names) <= set(parameters):
        return None
    node = value.express(lesson.graph)
    for name in sorted(names, key=lambda one: parameters[one].unit != "rad/s"):
        symbol = lesson.graph.symbol(name)
        (now,) = chosen.of(symbol)
        found = _crossing(chosen, node, symbol, now) if now else None
        if found is not None:
            return Try(name, found, parameters[name].unit)
    return None


def _crossing(chosen: Chosen, node: Expr, symbol: Expr, now: float) -> float | None:
    """Return the value of a symbol nearest to `now` at which |node| passes one."""

    def off(power: float) -> float:
        try:
            return abs(chosen.with_values({symbol: now * SPAN**power}).of(node)[0]) - 1
        except (SymdynError, ArithmeticError):
            return math.nan

    powers = [k / STEPS for k in range(-STEPS, STEPS + 1)]
    values = [off(power) for power in powers]
    pairs = [k for k in range(2 * STEPS) if values[k] * values[k + 1] < 0]
    if not pairs:
        return None
    low, high = (powers[min(pairs, key=lambda k: abs(powers[k])) + k] for k in (0, 1))
    rises = off(high) > 0
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (low, middle) if (off(middle) > 0) == rises else (middle, high)
    return float(now * SPAN ** ((low + high) / 2))
