"""Big floats of flint: what mpmath's compute, an order of magnitude sooner, where only many digits are wanted.

Values are balls of a precision that holds inside `with midpoints:`, for the whole process, and their radii are never
looked at: a function is taken of a midpoint, and its value is a midpoint again. So they round as `BigFloats` do, in the
last bit perhaps the other way, and stand in its place below `RunningErrors`, whose bounds are wider than any radius.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from symdyn.algebra.balls import FUNCTIONS_OF_BALLS, Balls
from symdyn.graph import Expr

BITS_A_DIGIT = 3.3219280948873626
SPARE_BITS = 3
LARGEST = arb(2) ** 1_000_000


class _Functions:
    """What slopes are written in."""

    inf = arb.pos_inf()
    mpf: Callable[[Any], Any] = arb
    sin, cos = arb.sin, arb.cos


class Midpoints(Balls):
    """Big floats by the midpoints of balls; what is not real raises ValueError."""

    def __init__(self, digits: int = 50) -> None:
        """Set the precision; `digits` are decimal."""
        super().__init__(bits_of(digits))
        self.context: Any = _Functions

    def constant(self, value: Fraction) -> Any:
        """Return the value rounded to the precision."""
        return super().constant(value).mid()

    def pi(self) -> Any:
        """Return π rounded to the precision."""
        return super().pi().mid()

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args).

        Raises:
            ValueError: it is no real number.
            OverflowError: an argument beyond 2^1000000, whose sine would need as many digits of π.
        """
        there = [arg.mid() for arg in args]
        if any(abs(arg) >= LARGEST for arg in there):
            raise OverflowError(f"an argument of {node.op.name.lower()} is too large")
        value = FUNCTIONS_OF_BALLS[node.op](*there).mid()
        if not value.is_finite():
            raise ValueError(f"{node.op.name.lower()} is not real there")
        return value


def bits_of(digits: int) -> int:
    """Return the bits that so many decimal digits take, and a few more."""
    return round(digits * BITS_A_DIGIT) + SPARE_BITS


class RealBalls(Balls):
    """Balls of what is real and finite: whatever may be neither raises."""

    def __init__(self, digits: int) -> None:
        """Set the precision; `digits` are decimal."""
        super().__init__(bits_of(digits))

    def div(self, a: Any, b: Any) -> Any:
        """Return a / b; raise ZeroDivisionError where b may be zero for all that is known of it."""
        if b.contains(0):
            raise ZeroDivisionError("a divisor is all rounding error")
        return a / b

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return a ball that holds node.op of everything in `args`; raise ValueError where there is none.

        Raises:
            OverflowError: an argument beyond 2^1000000, whose sine would need as many digits of π.
        """
        if any(abs(arg) >= LARGEST for arg in args):
            raise OverflowError(f"an argument of {node.op.name.lower()} is too large")
        value = super().function(node, args)
        if not value.is_finite():
            raise ValueError(f"{node.op.name.lower()} is not real there")
        return value
