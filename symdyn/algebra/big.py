"""Numbers of any precision, against which generated code is measured: mpmath's, flint's, and balls around the truth.

`BigFloats` are mpmath's, the oracle. `Midpoints` are flint's: what mpmath's compute, an order of magnitude sooner,
where only many digits are wanted. They are balls of a precision that holds inside `with midpoints:`, for the whole
process, and their radii are never looked at: a function is taken of a midpoint, and its value is a midpoint again. So
they round as `BigFloats` do, in the last bit perhaps the other way, and stand in its place below `RunningErrors`, whose
bounds are wider than any radius.

Running error analysis is every value with a bound of the error that rounding each operation once may leave in it.

    z = x ± y    err z = err x + err y + u |z|
    z = x y      err z = |y| err x + |x| err y + u |z|
    z = x / y    err z = (err x + |z| err y) / |y| + u |z|
    z = f(x)     err z = |f'(x)| err x + v |z|

to first order in the unit roundoff u; functions of a library have a bound v of their own.

A ball is a midpoint of many bits and a radius, so that the true value lies inside whatever was rounded on the way.
Where it says too little for a function, the result says no more than is true:

    sqrt     of a ball with numbers below zero: what is left of it at zero and above, for a root that is real
    sign     of a ball with zero inside: anything from -1 to 1
    atan2    across the cut or around the origin: anything from -pi to pi
    pow      of a ball with numbers below zero, to no integer: as sqrt, for a power that is real
    select   by a ball with zero inside: anything from the one value to the other
    1/x, log of a ball with zero inside: a ball that is not finite, which holds everything

Reference: Higham, Accuracy and Stability of Numerical Algorithms (2002), section 3.3; Johansson, Arb: efficient
arbitrary-precision midpoint-radius interval arithmetic, IEEE Transactions on Computers 66 (2017).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from math import inf
from types import TracebackType
from typing import Any, NamedTuple

from flint import arb, ctx, fmpq

from symdyn.graph import ELEMENTARY, Arithmetic, Expr, Op, Piecewise

LARGEST = 1_000_000  # bits


class BigFloats(Arithmetic):
    """Big floats in a context of their own, so that nobody else's precision changes."""

    def __init__(self, digits: int = 50) -> None:
        from mpmath import MPContext  # certificates do without

        self.context: Any = MPContext()
        self.context.dps = digits
        context = self.context
        self.functions: dict[Op, Callable[..., Any]] = {
            **{op: getattr(context, op.name.lower()) for op in ELEMENTARY},
            Op.ABS: abs,
            Op.SIGN: context.sign,
            Op.ATAN2: context.atan2,
            Op.POW: self._power,
            Op.SELECT: lambda c, a, b: a if c > 0 else b if c <= 0 else c,
        }

    def constant(self, value: Fraction) -> Any:
        """Return the value rounded to the context's precision."""
        return self.context.mpf(value.numerator) / value.denominator

    def pi(self) -> Any:
        return +self.context.pi

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args).

        Raises:
            OverflowError: an argument beyond 2^1000000, whose sine would need as many digits of π.
        """
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])
        if any(self.context.isfinite(arg) and self.context.mag(arg) > LARGEST for arg in args if arg):
            raise OverflowError(f"an argument of {node.op.name.lower()} is too large")
        return self.functions[node.op](*args)

    def _power(self, x: Any, y: Any) -> Any:
        if x < 0 and y != self.context.floor(y):
            raise ValueError("a power of a negative number is not real")
        return self.context.power(x, y)

    def number(self, value: float | str) -> Any:
        """Return a float exactly, or a decimal string to the context's precision."""
        return self.context.mpf(value)


class Bounded(NamedTuple):
    """A value, and a bound of the error of the same computation in the analysed arithmetic."""

    value: Any
    error: Any


_bounded: Callable[[tuple[Any, Any]], Bounded] = partial(tuple.__new__, Bounded)
"""Makes one in half the time."""

SLOPES: dict[Op, Callable[..., tuple[Any, ...]]] = {  # z = f(x, …)  ->  (|dz/dx|, …)
    Op.SIN: lambda c, z, x: (abs(c.cos(x)),),
    Op.COS: lambda c, z, x: (abs(c.sin(x)),),
    Op.SQRT: lambda c, z, x: (abs(1 / (2 * z)) if z != 0 else c.inf,),
    Op.EXP: lambda c, z, x: (abs(z),),
    Op.LOG: lambda c, z, x: (abs(1 / x),),
    Op.TANH: lambda c, z, x: (abs(1 - z * z),),
    Op.ABS: lambda c, z, x: (1,),
    Op.SIGN: lambda c, z, x: (0,),
    Op.ATAN2: lambda c, z, y, x: (abs(x / (x * x + y * y)), abs(y / (x * x + y * y))),
    Op.POW: lambda c, z, x, y: (abs(y * z / x), abs(z * c.log(abs(x)))) if x != 0 else (0 if y > 1 else c.inf, 0),
    Op.SELECT: lambda c, z, k, a, b: (0, 1, 0) if k > 0 else (0, 0, 1),
}


class AllRoundingError(ZeroDivisionError):
    """A divisor is not zero, and no larger than what rounding may have left in it."""


class RunningErrors:
    """Big floats that know how far a shorter arithmetic may be off.

    Errors are doubles, which hold all digits that a bound of first order has; one that is none, such as that of a value
    beyond 1e308, is as big a float as the value.
    """

    @staticmethod
    def of_parts(parts: int) -> type[RunningErrors]:
        """Return the arithmetic of numbers that are sums of so many floats."""
        return RunningErrors if parts == 1 else LooseErrors

    def __init__(
        self, numbers: BigFloats | Midpoints, roundoff: float, function_roundoff: float, sines: float = 0.0
    ) -> None:
        """Analyse an arithmetic over exact enough numbers, by the roundoffs u of an operation and v of a function.

        Sines and cosines may be off by `sines` beside, whatever their size.
        """
        self.numbers = numbers
        self.sines = sines
        self.u = roundoff
        self.v = function_roundoff

    def exact(self, value: Any) -> Bounded:
        """Return an input that carries no error."""
        return _bounded((value, 0.0))

    def constant(self, value: Fraction) -> Bounded:
        return self._rounded(self.numbers.constant(value))

    def pi(self) -> Bounded:
        return self._rounded(self.numbers.pi())

    def add(self, a: Bounded, b: Bounded) -> Bounded:
        value = a.value + b.value
        error = a.error + b.error + self.u * abs(float(value))
        return _bounded((value, error if error < inf else a.error + b.error + self.u * abs(value)))

    def sub(self, a: Bounded, b: Bounded) -> Bounded:
        value = a.value - b.value
        error = a.error + b.error + self.u * abs(float(value))
        return _bounded((value, error if error < inf else a.error + b.error + self.u * abs(value)))

    def mul(self, a: Bounded, b: Bounded) -> Bounded:
        value = a.value * b.value
        error = abs(float(b.value)) * a.error + abs(float(a.value)) * b.error + self.u * abs(float(value))
        if not error < inf:
            error = abs(b.value) * a.error + abs(a.value) * b.error + self.u * abs(value)
        return _bounded((value, error))

    def div(self, a: Bounded, b: Bounded) -> Bounded:
        """Return a / b; raise AllRoundingError where b may be zero for all that is known of it."""
        if not abs(b.value) > b.error:
            raise (AllRoundingError if b.value else ZeroDivisionError)("a divisor is all rounding error")
        value = a.value / b.value
        size, below = abs(float(value)), abs(float(b.value))
        error = (a.error + size * b.error) / below + self.u * size if below else inf
        if not error < inf:
            error = (a.error + abs(value) * b.error) / abs(b.value) + self.u * abs(value)
        return _bounded((value, error))

    def neg(self, a: Bounded) -> Bounded:
        return _bounded((-a.value, a.error))

    def function(self, node: Expr, args: Sequence[Bounded]) -> Bounded:
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])  # which rounds more often than where it is looked up
        value = self.numbers.function(node, [arg.value for arg in args])
        slopes = SLOPES[node.op](self.numbers.context, value, *(arg.value for arg in args))
        carried = sum(slope * arg.error for slope, arg in zip(slopes, args, strict=True) if arg.error != 0)
        short = self.sines if node.op in (Op.SIN, Op.COS) else 0.0
        whole = carried + self.v * abs(value) + short
        error = float(whole)
        return _bounded((value, error if error < inf else whole))

    def _rounded(self, value: Any) -> Bounded:
        error = self.u * abs(float(value))
        return _bounded((value, error if error < inf else self.u * abs(value)))


class LooseErrors(RunningErrors):
    """Arithmetic whose sums are off by parts of what is added, as those of double-doubles are."""

    def add(self, a: Bounded, b: Bounded) -> Bounded:
        return self._summed(a.value + b.value, a, b)

    def sub(self, a: Bounded, b: Bounded) -> Bounded:
        return self._summed(a.value - b.value, a, b)

    def _summed(self, value: Any, a: Bounded, b: Bounded) -> Bounded:
        error = a.error + b.error + self.u * (abs(float(a.value)) + abs(float(b.value)))
        if not error < inf:
            error = a.error + b.error + self.u * (abs(a.value) + abs(b.value))
        return _bounded((value, error))


BITS = 128


def _root(x: Any) -> Any:
    """Return the root of what is not negative in a ball; not finite if there is nothing."""
    if x.lower() >= 0:
        return x.sqrt()
    return arb(0).union(x.upper().sqrt()) if x.upper() >= 0 else arb.nan()


def _power(x: Any, y: Any) -> Any:
    """Return a power; of what is not negative in a ball, where the exponent is no integer; not finite if of nothing."""
    if y.is_integer() or x > 0 or not y > 0:
        return x**y
    return arb(0).union(x.upper() ** y) if x.upper() > 0 else x.upper() ** y


def _select(c: Any, a: Any, b: Any) -> Any:
    return a if c > 0 else b if c <= 0 else a.union(b) if c.is_finite() else c


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
    Op.POW: _power,
    Op.SELECT: _select,
}


class Balls(Arithmetic):
    """Ball arithmetic of a precision that holds inside `with balls:`, for the whole process."""

    def __init__(self, bits: int = BITS) -> None:
        self.bits = bits
        self._before: list[int] = []

    def __enter__(self) -> Balls:
        self._before.append(ctx.prec)
        ctx.prec = self.bits
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        ctx.prec = self._before.pop()

    def constant(self, value: Fraction) -> Any:
        return arb(fmpq(value.numerator, value.denominator))

    def pi(self) -> Any:
        return arb.pi()

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return a ball that holds node.op of everything in `args`."""
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])
        return FUNCTIONS_OF_BALLS[node.op](*args)

    def number(self, value: float) -> Any:
        """Return a float exactly, as a ball without radius."""
        return arb(value)


BITS_A_DIGIT = 3.3219280948873626
SPARE_BITS = 3
LARGEST_BALL = arb(2) ** 1_000_000


class _Functions:
    """What slopes are written in."""

    inf = arb.pos_inf()
    mpf: Callable[[Any], Any] = arb
    sin, cos, log = arb.sin, arb.cos, arb.log


class Midpoints(Balls):
    """Big floats by the midpoints of balls; what is not real raises ValueError."""

    def __init__(self, digits: int = 50) -> None:
        super().__init__(bits_of(digits))
        self.context: Any = _Functions

    def constant(self, value: Fraction) -> Any:
        return super().constant(value).mid()

    def pi(self) -> Any:
        return super().pi().mid()

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args).

        Raises:
            ValueError: it is no real number.
            OverflowError: an argument beyond 2^1000000, whose sine would need as many digits of π.
        """
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])
        there = [arg.mid() for arg in args]
        if any(abs(arg) >= LARGEST_BALL for arg in there):
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
        if any(abs(arg) >= LARGEST_BALL for arg in args):
            raise OverflowError(f"an argument of {node.op.name.lower()} is too large")
        value = super().function(node, args)
        if not value.is_finite():
            raise ValueError(f"{node.op.name.lower()} is not real there")
        return value
