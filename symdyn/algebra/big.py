"""mpmath numbers of any precision: the oracle that generated code is measured against."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from mpmath import MPContext

from symdyn.graph import Arithmetic, Expr, Op

LARGEST = 1_000_000  # bits


class BigFloats(Arithmetic):
    """Big floats in a context of their own, so that nobody else's precision changes."""

    def __init__(self, digits: int = 50) -> None:
        """Set the precision; `digits` are decimal."""
        self.context: Any = MPContext()
        self.context.dps = digits
        context = self.context
        self.functions: dict[Op, Callable[..., Any]] = {
            Op.SIN: context.sin,
            Op.COS: context.cos,
            Op.SQRT: context.sqrt,
            Op.EXP: context.exp,
            Op.LOG: context.log,
            Op.TANH: context.tanh,
            Op.ABS: abs,
            Op.SIGN: context.sign,
            Op.ATAN2: context.atan2,
        }

    def constant(self, value: Fraction) -> Any:
        """Return the value rounded to the context's precision."""
        return self.context.mpf(value.numerator) / value.denominator

    def pi(self) -> Any:
        """Return π."""
        return +self.context.pi

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args).

        Raises:
            OverflowError: an argument beyond 2^1000000, whose sine would need as many digits of π.
        """
        if any(self.context.isfinite(arg) and self.context.mag(arg) > LARGEST for arg in args if arg):
            raise OverflowError(f"an argument of {node.op.name.lower()} is too large")
        return self.functions[node.op](*args)

    def number(self, value: float | str) -> Any:
        """Return a float exactly, or a decimal string to the context's precision."""
        return self.context.mpf(value)
