"""The normal of level ground: against gravity as the scene declares it, whatever values its parameters get later."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence

from symdyn.scene.values.folding import neg
from symdyn.scene.values.mapping import substituted
from symdyn.scene.values.model import Parameter
from symdyn.scene.values.quantity import FormulaError, Quantity, Vector
from symdyn.scene.values.spelling import spell

DRAWS, SAME = 6, 1e-12
"""Random values of free parameters at which a direction is looked at, and what it may differ by."""


def level_normal(gravity: Vector, parameters: Sequence[Parameter]) -> Vector | str:
    """Return the direction against gravity, free of symbols; or why it is not decided, for a message.

    Parameters with a value have that value; the direction must be the same whatever the others are.
    """
    given = {p.name: p.value for p in parameters if p.value is not None}
    free = [p for p in parameters if p.value is None]
    text = f"gravity = [{', '.join(spell(x) for x in gravity)}]"
    draws = [given | drawn for drawn in _drawn(free)]
    directions = [found for values in draws if (found := _unit(gravity, values)) is not None]
    if len(directions) < len(draws):
        return f"{text} has no direction"
    if any(math.dist(directions[0], one) > SAME for one in directions):
        names = [p.name for p in free if any(p.name in x.symbols for x in gravity)]
        return f"the direction of {text} depends on {', '.join(names)}, which may be negative"
    lengths = [k for k in range(3) if abs(directions[0][k]) > SAME]
    if len(lengths) == 1:
        up = Quantity.ONE if directions[0][lengths[0]] < 0 else neg(Quantity.ONE)
        x, y, z = (up if k == lengths[0] else Quantity.ZERO for k in range(3))
    else:
        x, y, z = (neg(substituted(entry, draws[0])) for entry in gravity)
    return (x, y, z)


def _drawn(free: Sequence[Parameter]) -> list[dict[str, Quantity]]:
    """Return values of free parameters: ones, ones with either sign, and random ones."""
    rng = random.Random("gravity")
    sizes = [[1] * len(free), [1] * len(free), *([rng.randint(1, 99) for _ in free] for _ in range(DRAWS))]
    signs = [1, -1, *(rng.choice((-1, 1)) for _ in range(DRAWS))]
    return [
        {p.name: Quantity.number(size if p.positive else sign * size) for p, size in zip(free, some, strict=True)}
        for some, sign in zip(sizes, signs, strict=True)
    ]


def _unit(vector: Vector, values: Mapping[str, Quantity]) -> tuple[float, ...] | None:
    """Return the direction of a vector at values of its symbols; None where it has none."""
    try:
        numbers = [float(substituted(x, values).at({}) or 0) for x in vector]
    except (FormulaError, ZeroDivisionError):
        return None  # reported as a formula without a value
    length = math.hypot(*numbers)
    return tuple(x / length for x in numbers) if length else None
