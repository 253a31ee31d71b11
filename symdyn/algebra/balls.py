"""Balls: a midpoint of many bits and a radius, so that the true value lies inside whatever was rounded on the way.

Where a ball says too little for a function, the result says no more than is true:

    sqrt     of a ball with numbers below zero: what is left of it at zero and above, for a root that is real
    sign     of a ball with zero inside: anything from -1 to 1
    atan2    across the cut or around the origin: anything from -pi to pi
    1/x, log of a ball with zero inside: a ball that is not finite, which holds everything

Reference: Johansson, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Transactions on
Computers 66 (2017).

Big floats of flint: what mpmath's compute, an order of magnitude sooner, where only many digits are wanted.

Values are balls of a precision that holds inside `with midpoints:`, for the whole process, and their radii are never
looked at: a function is taken of a midpoint, and its value is a midpoint again. So they round as `BigFloats` do, in the
last bit perhaps the other way, and stand in its place below `RunningErrors`, whose bounds are wider than any radius.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from types import TracebackType
from typing import Any

from flint import arb, ctx, fmpq

from symdyn.graph import Arithmetic, Expr, Op

BITS = 128


def _root(x: Any) -> Any:
    """Return the root of what is not negative in a ball; not finite if there is nothing."""
    if x.lower() >= 0:
        return x.sqrt()
    return arb(0).union(x.upper().sqrt()) if x.upper() >= 0 else arb.nan()


def _sign(x: Any) -> Any:
    return x.sgn() if x.is_finite() else arb(0).union(arb(1)).union(arb(-1))


FUNCTIONS_OF_BALLS: dict[Op, Callable[..., Any]] = {
    Op.SIN: lambda x: x.sin(),
    Op.COS: lambda x: x.cos(),
    Op.SQRT: _root,
    Op.EXP: lambda x: x.exp(),
    Op.LOG: lambda x: x.log(),
    Op.TANH: lambda x: x.tanh(),
    Op.ABS: abs,
    Op.SIGN: _sign,
    Op.ATAN2: arb.atan2,
}


class Balls(Arithmetic):
    """Ball arithmetic of a precision that holds inside `with balls:`, for the whole process."""

    def __init__(self, bits: int = BITS) -> None:
        """Set the precision of midpoints."""
        self.bits = bits
        self._before: list[int] = []

    def __enter__(self) -> Balls:
        """Compute with this precision from here on."""
        self._before.append(ctx.prec)
        ctx.prec = self.bits
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Compute with the precision of before."""
        ctx.prec = self._before.pop()

    def constant(self, value: Fraction) -> Any:
        """Return a ball around the value."""
        return arb(fmpq(value.numerator, value.denominator))

    def pi(self) -> Any:
        """Return a ball around π."""
        return arb.pi()

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return a ball that holds node.op of everything in `args`."""
        return FUNCTIONS_OF_BALLS[node.op](*args)

    def number(self, value: float) -> Any:
        """Return a float exactly, as a ball without radius."""
        return arb(value)


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
