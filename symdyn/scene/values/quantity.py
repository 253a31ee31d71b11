"""Quantities: what a user may write wherever a scene wants a number.

A quantity is an exact formula: a fraction, π, a named parameter, or an operation on quantities. It is a small frozen
tree with no graph behind it, so that two scenes compare equal when they say the same.

Quantities as text that a formula reader takes back: `parse(spell(x)) == x` for whatever `parse` returned.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from decimal import Context, Decimal, Inexact
from fractions import Fraction
from math import isqrt
from numbers import Rational
from typing import ClassVar

from symdyn.errors import SceneError
from symdyn.frozen import dataclass, field, fields, is_dataclass
from symdyn.graph import Expr, Graph, Op, Piecewise, arithmetic, tangents
from symdyn.scene.values.curve import Curve

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
    Op.POW: math.pow,
}


class FormulaError(SceneError):
    """A formula that is not one; the caller knows file, table and key and puts them in front."""


@dataclass(frozen=True)
class Quantity:
    """A node of a formula.

    Attributes:
        op: what the node computes.
        args: its operands.
        value: the fraction of a constant, the name of a symbol; of SELECT in place of values to select, the table that
            is read, its name until that is known; else None.
        unit: in which its writer gave a number, such as "mm"; the quantity itself is in SI, and equals the same in
            another.
        tight: whether no space stood before the unit, as none stands before a letter that is multiplied.
    """

    op: Op
    args: tuple[Quantity, ...] = ()
    value: Fraction | str | Curve | Piecewise | None = None
    unit: str = field(default="", compare=False, repr=False)
    tight: bool = field(default=False, compare=False, repr=False)

    ZERO: ClassVar[Quantity]
    ONE: ClassVar[Quantity]
    PI: ClassVar[Quantity]

    @staticmethod
    def number(value: Fraction | int) -> Quantity:
        return Quantity(Op.CONSTANT, (), value if type(value) is Fraction else Fraction(value))

    @staticmethod
    def symbol(name: str) -> Quantity:
        """Return a named parameter, coordinate or velocity."""
        return Quantity(Op.SYMBOL, (), name)

    def __float__(self) -> float:
        if (value := self.at({})) is None:
            raise FormulaError(f"{spell(self)} is a formula, and no number")
        return float(value)

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
    def is_zero(self) -> bool:
        """Whether it is zero for all values of its symbols; not where it divides by zero, which its reader reports."""
        try:
            return self.express(Graph()).is_zero
        except ZeroDivisionError:
            return False

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
        if isinstance(self.value, Piecewise):
            return graph.lookup(self.value, args[0])
        if isinstance(self.value, Curve):
            return graph.table(self.value.name, self.value.body(graph, args), tuple(args))
        if self.value is not None:
            raise FormulaError(f"{spell(self)} stands in formulas of a scene with this table only")
        if self.op.is_function:
            return graph.function(self.op, *args)
        return arithmetic(graph)[self.op](*args)  # type: ignore[no-any-return]

    def slope(self, name: str) -> Quantity:
        """Return the derivative by a symbol, all others held.

        Raises:
            ZeroDivisionError: the formula divides by a constant zero.
        """
        return self.rate({name: Quantity.ONE})

    def rate(self, rates: Mapping[str, Quantity]) -> Quantity:
        """Return the rate of a formula by those of its symbols; symbols without one are held.

        Raises:
            ZeroDivisionError: the formula, or a rate, divides by a constant zero.
        """

        def formula(node: Expr) -> Quantity:
            return Quantity(node.op, tuple(map(formula, node.args)), node.value)

        moving, graph = {name: rates[name] for name in self.symbols if name in rates}, Graph()
        if not moving:
            return Quantity.ZERO
        value = self.express(graph)
        (found,) = tangents([value], {graph.symbol(name): rate.express(graph) for name, rate in moving.items()})
        return formula(found)

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
    if q.value is not None:
        if isinstance(q.value, str) or len(known) < len(args):
            return None
        return _tame(q.value.at(Fraction(known[0])) if isinstance(q.value, Piecewise) else q.value.at(known))
    return _tame(_apply(q.op, known)) if len(known) == len(args) else None


def _apply(op: Op, args: list[Value]) -> Value:
    a, b = args[0], args[-1]
    if op in _ARITHMETIC:
        return _ARITHMETIC[op](a, b)
    if op is Op.SIGN:
        return Fraction((a > 0) - (a < 0))
    if op is Op.SELECT:
        return args[1] if a > 0 else b
    if op is Op.SQRT:
        return _root(a)
    if op is Op.POW and a < 0 and float(b) % 1:
        raise FormulaError(f"takes {float(a):.6g} to the power {float(b):.6g}; the base must not be negative")
    if op is Op.POW and a == 0 and b < 0:
        raise ZeroDivisionError
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


_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = range(5)


def spell(quantity: Quantity | Rational) -> str:
    """Return a formula as text, with no bracket too many.

    A number is a decimal where that is exact and short, else p/q.

    >>> from symdyn.scene import parse
    >>> spell(parse("0.5*(pi) + 1/3 - (a*(b))"))
    'pi/2 + 1/3 - a*b'
    """
    return _spell(quantity)[0] if isinstance(quantity, Quantity) else _decimal(Fraction(quantity))


def _decimal(value: Fraction) -> str:
    """Return a decimal where it is exact and short, else p/q."""
    digits = next((k for k in range(20) if 10**k % value.denominator == 0), None)
    if digits is None:
        return str(value)
    text = str(abs(value.numerator) * 10**digits // value.denominator).rjust(digits + 1, "0")
    text = f"{text[:-digits]}.{text[-digits:]}" if digits else text
    return f"-{text}" if value < 0 else text


def _spell(q: Quantity) -> tuple[str, int]:
    if isinstance(q.value, Fraction):
        text = _decimal(q.value)
        return text, _PRODUCT if "/" in text else _SIGN if q.value < 0 else _ATOM
    if q.op is Op.SYMBOL:
        return str(q.value), _ATOM
    if q.op is Op.PI:
        return "pi", _ATOM
    if q.op is Op.NEG:
        return f"-{_at_least(q.args[0], _PRODUCT)}", _SIGN
    if q.op in (Op.ADD, Op.SUB):
        left, right = _at_least(q.args[0], _SUM), _at_least(q.args[1], _PRODUCT)
        return f"{left} {'+' if q.op is Op.ADD else '-'} {right}", _SUM
    if q.op is Op.MUL:
        return _product(q.args[0], q.args[1])
    if q.op is Op.DIV:
        return f"{_at_least(q.args[0], _PRODUCT)}/{_at_least(q.args[1], _POWER)}", _PRODUCT
    if q.op is Op.POW:
        return f"{_at_least(q.args[0], _ATOM)}**{_at_least(q.args[1], _ATOM)}", _POWER
    if q.value is not None:
        name = q.value if isinstance(q.value, str) else q.value.name
        return f'table("{name}", {", ".join(map(spell, q.args))})', _ATOM
    if q.op is Op.SELECT:
        return _selection(*q.args), _ATOM
    return f"{q.op.name.lower()}({', '.join(spell(arg) for arg in q.args)})", _ATOM


def _selection(guard: Quantity, a: Quantity, b: Quantity) -> str:
    """Return max(a, b) or min(a, b) where a selection is one, else if(condition, a, b)."""
    for word, larger, smaller in (("max", a, b), ("min", b, a)):
        if guard == (larger if smaller == Quantity.ZERO else Quantity(Op.SUB, (larger, smaller))):
            return f"{word}({spell(a)}, {spell(b)})"
    sides = guard.args if guard.op is Op.SUB else (guard, Quantity.ZERO)
    return f"if({' > '.join(map(spell, sides))}, {spell(a)}, {spell(b)})"


def _product(a: Quantity, b: Quantity) -> tuple[str, int]:
    factor = a.value
    if a == b:
        return f"{_at_least(a, _ATOM)}**2", _POWER
    if not isinstance(factor, Fraction):
        return f"{_at_least(a, _PRODUCT)}*{_at_least(b, _POWER)}", _PRODUCT
    rest = _at_least(b, _PRODUCT)
    if "/" not in _decimal(factor) and factor.denominator not in (2, 4, 8):
        return f"{_decimal(factor)}*{rest}", _PRODUCT
    front = {1: "", -1: "-"}.get(factor.numerator, f"{factor.numerator}*")
    return f"{front}{rest}/{factor.denominator}", _PRODUCT


def _at_least(q: Quantity, level: int) -> str:
    text, own = _spell(q)
    return text if own >= level else f"({text})"


MOST_DIGITS = 40
"""A decimal longer than this is written as the nearest double, or as a fraction."""

EXACT = Context(prec=MOST_DIGITS, traps=[Inexact])


def exact_decimal(value: Fraction) -> Decimal:
    """Return a fraction as a decimal without zeros behind it.

    Raises:
        Inexact: it has none of at most `MOST_DIGITS` digits.
    """
    return EXACT.normalize(EXACT.divide(Decimal(value.numerator), Decimal(value.denominator)))
