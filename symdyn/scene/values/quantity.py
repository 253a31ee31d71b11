"""Quantities: what a user may write wherever a scene wants a number.

A quantity is an exact formula: a fraction, π, a named parameter, or an operation on quantities. It is a small frozen
tree with no graph behind it, so that two scenes compare equal when they say the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from fractions import Fraction
from math import isqrt
from typing import ClassVar

from symdyn.errors import SceneError
from symdyn.graph import Expr, Graph, Op, arithmetic

Value = Fraction | float

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


class FormulaError(SceneError):
    """A formula that is not one; the caller knows file, table and key and puts them in front."""


@dataclass(frozen=True)
class Quantity:
    """A node of a formula.

    Attributes:
        op: what the node computes.
        args: its operands.
        value: the fraction of a constant, the name of a symbol, else None.
        unit: in which its writer gave a number, such as "mm"; the quantity itself is in SI, and equals the same in
            another.
    """

    op: Op
    args: tuple[Quantity, ...] = ()
    value: Fraction | str | None = None
    unit: str = field(default="", compare=False, repr=False)

    ZERO: ClassVar[Quantity]
    ONE: ClassVar[Quantity]
    PI: ClassVar[Quantity]

    @staticmethod
    def number(value: Fraction | int) -> Quantity:
        """Return an exact constant."""
        return Quantity(Op.CONSTANT, (), value if type(value) is Fraction else Fraction(value))

    @staticmethod
    def symbol(name: str) -> Quantity:
        """Return a named parameter, coordinate or velocity."""
        return Quantity(Op.SYMBOL, (), name)

    def __neg__(self) -> Quantity:
        return self if self == Quantity.ZERO else Quantity(Op.NEG, (self,))

    def __mul__(self, other: Quantity) -> Quantity:
        if Quantity.ZERO in (self, other):
            return Quantity.ZERO
        return other if self == Quantity.ONE else self if other == Quantity.ONE else Quantity(Op.MUL, (self, other))

    def __add__(self, other: Quantity) -> Quantity:
        return other if self == Quantity.ZERO else self if other == Quantity.ZERO else Quantity(Op.ADD, (self, other))

    @staticmethod
    def inside(thing: object) -> Iterator[Quantity]:
        """Yield every quantity inside a noun of the scene, or a tuple of them, in declared order."""
        if isinstance(thing, Quantity):
            yield thing
        elif isinstance(thing, tuple):
            for part in thing:
                yield from Quantity.inside(part)
        elif is_dataclass(thing) and not isinstance(thing, type):
            for one in fields(thing):
                yield from Quantity.inside(getattr(thing, one.name))

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of the symbols in the formula, in order of appearance."""
        names = {str(self.value): None} if self.op is Op.SYMBOL else {}
        for arg in self.args:
            names.update(dict.fromkeys(arg.symbols))
        return tuple(names)

    def express(self, graph: Graph) -> Expr:
        """Return the quantity as a node of `graph`; symbols keep their names.

        Raises:
            ZeroDivisionError: the formula divides by a constant zero.
        """
        if self.op is Op.CONSTANT:
            assert isinstance(self.value, Fraction)
            return graph.constant(self.value)
        if self.op is Op.SYMBOL:
            return graph.symbol(str(self.value))
        if self.op is Op.PI:
            return graph.pi
        args = [arg.express(graph) for arg in self.args]
        if self.op.is_function:
            return graph.function(self.op, *args)
        return arithmetic(graph)[self.op](*args)  # type: ignore[no-any-return]

    def at(self, values: Mapping[str, Value]) -> Value | None:
        """Return its value, exact where it is rational; None when one of its symbols has no value.

        Raises:
            FormulaError: it divides by zero, has no real value, or is beyond the largest double.
        """
        try:
            return _value(self, values)
        except ZeroDivisionError:
            raise FormulaError("divides by zero") from None
        except OverflowError:
            raise FormulaError("is beyond the largest double, 1.8e308") from None

    def known_at(self, values: Mapping[str, Value]) -> Value | None:
        """Return its value, None where it is not known, or does not exist, which is reported apart."""
        try:
            return self.at(values)
        except FormulaError:
            return None


Quantity.ZERO, Quantity.ONE, Quantity.PI = Quantity.number(0), Quantity.number(1), Quantity(Op.PI)

Vector = tuple[Quantity, Quantity, Quantity]

NULL: Vector = (Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)


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
