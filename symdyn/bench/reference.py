"""The same graph at 50 digits, with its running error bounds: what every implementation is measured against.

Values are balls of 170 bits, whose radii are below the 50th digit; bounds are computed in double, where a few digits of
them are enough. mpmath would give the same digits and take several times as long.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra.balls import Balls
from symdyn.algebra.numeric import Floats
from symdyn.algebra.running_error import Bounded, RunningErrors
from symdyn.dynamics import Function
from symdyn.graph import evaluate, reachable
from symdyn.verify.accuracy import FUNCTION_ULPS, ROUNDOFF, values_of

Array = npt.NDArray[np.float64]

BITS = 170


class _Doubles(Floats):
    """Doubles in the place of big floats, for the bounds."""

    context = SimpleNamespace(mpf=float, cos=math.cos, sin=math.sin, inf=math.inf)

    def constant(self, value: Fraction) -> float:
        """Return the nearest double."""
        return float(value)


@dataclass(frozen=True)
class Reference:
    """Exact results at states.

    Attributes:
        kept: which of the states have one: the function is real and finite there.
        high, low: the result as a sum of two doubles, shape (kept, size).
        bound: running error bounds of one rounding of every operation, shape (kept, size), for double.
        balls: the results, one list a kept state.
    """

    kept: npt.NDArray[np.intp]
    high: Array
    low: Array
    bound: Array
    balls: list[list[Any]]

    def errors(self, computed: Array) -> Array:
        """Return |computed - exact|, shape (kept, size), from results at all states."""
        found = np.asarray(computed, float).reshape(len(computed), -1)[self.kept]
        with np.errstate(all="ignore"):
            gap: Array = np.abs((found - self.high) - self.low)
        return np.where(np.isfinite(found), gap, np.inf)


def reference(function: Function, states: Mapping[str, Array], count: int) -> Reference:
    """Return the exact results of a function at `count` states."""
    doubles = RunningErrors(_Doubles(), ROUNDOFF["double"], 2 * FUNCTION_ULPS * ROUNDOFF["double"])  # type: ignore[arg-type]
    kept, balls, bounds = [], [], []
    order = reachable(function.entries)
    with Balls(BITS) as algebra:
        for k in range(count):
            state = state_of(states, k)
            given = values_of(function, [state[argument.name] for argument in function.arguments])
            try:
                rough = evaluate(function.entries, doubles, {s: Bounded(v, 0.0) for s, v in given.items()}, order)
            except (ValueError, ZeroDivisionError, OverflowError):
                continue
            exact = evaluate(function.entries, algebra, {s: algebra.number(v) for s, v in given.items()}, order)
            if all(ball.is_finite() for ball in exact):
                kept.append(k)
                balls.append(exact)
                bounds.append([float(one.error) for one in rough])
        high = [[float(ball) for ball in row] for row in balls]
        low = [
            [float(b - algebra.number(h)) for b, h in zip(*pair, strict=True)] for pair in zip(balls, high, strict=True)
        ]
    size = len(function.entries)
    shape = (len(kept), size)
    return Reference(
        np.array(kept, dtype=np.intp),
        np.array(high).reshape(shape),
        np.array(low).reshape(shape),
        np.array(bounds).reshape(shape),
        balls,
    )


def state_of(states: Mapping[str, Array], k: int) -> dict[str, Array]:
    """Return one of many states; what all have in common is in each."""
    return {name: value[k] if value.ndim == 2 else value for name, value in states.items()}
