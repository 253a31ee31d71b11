"""Big floats that are moved by one rounding after every operation, up or down by lot: what rounding does, tried.

Where a bound of the error would be wider than the value itself, as after many divisions in a row, a few runs say how
far rounding goes. Reference: Vignes, A stochastic arithmetic for reliable scientific computation (1993).
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from symdyn.algebra import BigFloats, Midpoints
from symdyn.graph import Arithmetic, Expr


class Shaken(Arithmetic):
    """An arithmetic whose results are off by the roundoff u of an operation, or v of a function, up or down."""

    def __init__(self, numbers: BigFloats | Midpoints, roundoff: Any, function_roundoff: Any, rng: random.Random):
        """Shake exact enough numbers."""
        self.numbers = numbers
        self.factors = [1 + sign * numbers.context.mpf(roundoff) for sign in (-1, 1)]
        self.function_factors = [1 + sign * numbers.context.mpf(function_roundoff) for sign in (-1, 1)]
        self.rng = rng

    def constant(self, value: Fraction) -> Any:
        """Return a constant, rounded once."""
        return self._rounded(self.numbers.constant(value))

    def pi(self) -> Any:
        """Return π, rounded once."""
        return self._rounded(self.numbers.pi())

    def add(self, a: Any, b: Any) -> Any:
        """Return a + b."""
        return self._rounded(a + b)

    def sub(self, a: Any, b: Any) -> Any:
        """Return a - b."""
        return self._rounded(a - b)

    def mul(self, a: Any, b: Any) -> Any:
        """Return a b."""
        return self._rounded(a * b)

    def div(self, a: Any, b: Any) -> Any:
        """Return a / b."""
        if b == 0:
            raise ZeroDivisionError("a divisor is zero")
        return self._rounded(a / b)

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args)."""
        return self.numbers.function(node, args) * self.rng.choice(self.function_factors)

    def _rounded(self, value: Any) -> Any:
        return value * self.rng.choice(self.factors)
