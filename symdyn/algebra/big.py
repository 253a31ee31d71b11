"""mpmath numbers of any precision: the oracle that generated code is measured against, and how far that may be off.

Running error analysis is every value with a bound of the error that rounding each operation once may leave in it.

    z = x ± y    err z = err x + err y + u |z|
    z = x y      err z = |y| err x + |x| err y + u |z|
    z = x / y    err z = (err x + |z| err y) / |y| + u |z|
    z = f(x)     err z = |f'(x)| err x + v |z|

to first order in the unit roundoff u; functions of a library have a bound v of their own. Reference: Higham, Accuracy
and Stability of Numerical Algorithms (2002), section 3.3.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

from symdyn.graph import Arithmetic, Expr, Op

if TYPE_CHECKING:
    from symdyn.algebra.balls import Midpoints

LARGEST = 1_000_000  # bits


class BigFloats(Arithmetic):
    """Big floats in a context of their own, so that nobody else's precision changes."""

    def __init__(self, digits: int = 50) -> None:
        """Set the precision; `digits` are decimal."""
        from mpmath import MPContext  # certificates do without

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
        """Return a constant, rounded once."""
        return self._rounded(self.numbers.constant(value))

    def pi(self) -> Bounded:
        """Return π, rounded once."""
        return self._rounded(self.numbers.pi())

    def add(self, a: Bounded, b: Bounded) -> Bounded:
        """Return a + b."""
        value = a.value + b.value
        error = a.error + b.error + self.u * abs(float(value))
        return _bounded((value, error if error < inf else a.error + b.error + self.u * abs(value)))

    def sub(self, a: Bounded, b: Bounded) -> Bounded:
        """Return a - b."""
        value = a.value - b.value
        error = a.error + b.error + self.u * abs(float(value))
        return _bounded((value, error if error < inf else a.error + b.error + self.u * abs(value)))

    def mul(self, a: Bounded, b: Bounded) -> Bounded:
        """Return a b."""
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
        """Return -a, which rounds nothing."""
        return _bounded((-a.value, a.error))

    def function(self, node: Expr, args: Sequence[Bounded]) -> Bounded:
        """Return node.op(args)."""
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
        """Return a + b."""
        return self._summed(a.value + b.value, a, b)

    def sub(self, a: Bounded, b: Bounded) -> Bounded:
        """Return a - b."""
        return self._summed(a.value - b.value, a, b)

    def _summed(self, value: Any, a: Bounded, b: Bounded) -> Bounded:
        error = a.error + b.error + self.u * (abs(float(a.value)) + abs(float(b.value)))
        if not error < inf:
            error = a.error + b.error + self.u * (abs(a.value) + abs(b.value))
        return _bounded((value, error))
