"""Values of quantities: exact where they are rational, else floats."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from math import isqrt

from symdyn.graph import Op
from symdyn.scene.values.folding import FormulaError
from symdyn.scene.values.quantity import Quantity, Value

LONGEST_BITS = 8192

_ARITHMETIC: Mapping[Op, Callable[[Value, Value], Value]] = {
    Op.ADD: lambda a, b: a + b,
    Op.SUB: lambda a, b: a - b,
    Op.MUL: lambda a, b: a * b,
    Op.DIV: lambda a, b: a / b,
    Op.NEG: lambda a, _: -a,
    Op.ABS: lambda a, _: a if a >= 0 else -a,
}

_FUNCTIONS: Mapping[Op, Callable[..., float]] = {
    Op.SIN: math.sin,
    Op.COS: math.cos,
    Op.EXP: math.exp,
    Op.LOG: math.log,
    Op.TANH: math.tanh,
    Op.ATAN2: math.atan2,
}


def value_of(quantity: Quantity, values: Mapping[str, Value]) -> Value | None:
    """Return the value of a quantity, None when one of its symbols has no value.

    Raises:
        FormulaError: it divides by zero, has no real value, or is beyond the largest double.
    """
    try:
        return _value(quantity, values)
    except ZeroDivisionError:
        raise FormulaError("divides by zero") from None
    except OverflowError:
        raise FormulaError("is beyond the largest double, 1.8e308") from None


def _value(q: Quantity, values: Mapping[str, Value]) -> Value | None:
    if isinstance(q.value, Fraction):
        return q.value
    if q.op is Op.SYMBOL:
        return values.get(str(q.value))
    if q.op is Op.PI:
        return math.pi
    args = [_value(arg, values) for arg in q.args]
    known = [arg for arg in args if arg is not None]
    return _tame(_apply(q.op, known)) if len(known) == len(args) else None


def _apply(op: Op, args: list[Value]) -> Value:
    a, b = args[0], args[-1]
    if op in _ARITHMETIC:
        return _ARITHMETIC[op](a, b)
    if op is Op.SIGN:
        return Fraction((a > 0) - (a < 0))
    if op is Op.SQRT:
        return _root(a)
    if op is Op.LOG and float(a) <= 0:  # a product of small numbers may be zero as a double only
        raise FormulaError(f"takes the logarithm of {float(a):.6g}; it must be positive")
    return _FUNCTIONS[op](*(float(arg) for arg in args))


def _root(a: Value) -> Value:
    if a < 0:
        raise FormulaError(f"takes the square root of {float(a):.6g}; it must not be negative")
    if isinstance(a, Fraction):
        above, below = isqrt(a.numerator), isqrt(a.denominator)
        if above**2 == a.numerator and below**2 == a.denominator:
            return Fraction(above, below)
    return math.sqrt(a)


def _tame(value: Value) -> Value:
    """Keep a fraction while it is short, and refuse what no double holds."""
    if isinstance(value, Fraction):
        bits = max(value.numerator.bit_length(), value.denominator.bit_length())
        return value if bits <= LONGEST_BITS and abs(float(value)) < math.inf else float(value)
    if not math.isfinite(value):
        raise OverflowError
    return value
