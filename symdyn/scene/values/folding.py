"""Building quantities in one canonical form: constants folded, and a product's constant in front.

So `pi/2`, `0.5*pi` and `90 deg` are one quantity, and two scenes that say the same compare equal in the simple cases.
A change of quantities goes through every formula that a thing of the scene holds, and is folded again.

Folded constants stay within what a double can hold, so no formula of a few characters can keep the machine busy.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from math import isqrt
from typing import Any, NamedTuple, TypeVar

from symdyn.errors import hint, nearest
from symdyn.graph import Graph, Op
from symdyn.scene.values.curve import Curve
from symdyn.scene.values.quantity import FormulaError, Quantity

LARGEST = Fraction(sys.float_info.max)
SMALLEST = Fraction(1, 2**1074)
HARMLESS_BITS = 1000
LONGEST_BITS = 8192


def constant(value: Fraction) -> Quantity:
    """Return an exact constant that a double can hold."""
    bits = value.denominator.bit_length()
    if abs(value.numerator.bit_length() - bits) > HARMLESS_BITS:
        if abs(value) > LARGEST:
            raise FormulaError("a number is beyond the largest double, 1.8e308; choose units that keep it smaller")
        if value and 2 * abs(value) <= SMALLEST:  # a double rounds it to zero, which has no logarithm
            raise FormulaError("a number is below the smallest double, 4.9e-324; write 0, or choose other units")
    if bits > LONGEST_BITS:
        raise FormulaError("an exact number has too many digits; round it, 17 digits are all that a double keeps")
    return Quantity.number(value)


def fraction(quantity: Quantity) -> Fraction | None:
    """Return the value of a folded constant, None for anything else."""
    return quantity.value if isinstance(quantity.value, Fraction) else None


def add(a: Quantity, b: Quantity) -> Quantity:
    """Return a + b."""
    x, y = fraction(a), fraction(b)
    if x is not None and y is not None:
        return constant(x + y)
    return b if x == 0 else a if y == 0 else Quantity(Op.ADD, (a, b))


def sub(a: Quantity, b: Quantity) -> Quantity:
    """Return a - b."""
    x, y = fraction(a), fraction(b)
    if x is not None and y is not None:
        return constant(x - y)
    return neg(b) if x == 0 else a if y == 0 else Quantity(Op.SUB, (a, b))


def neg(a: Quantity) -> Quantity:
    """Return -a."""
    factor, rest = split(a)
    return _scaled(-factor, rest)


def mul(a: Quantity, b: Quantity) -> Quantity:
    """Return a b."""
    (x, rest_a), (y, rest_b) = split(a), split(b)
    rest = (
        rest_b if rest_a == Quantity.ONE else rest_a if rest_b == Quantity.ONE else Quantity(Op.MUL, (rest_a, rest_b))
    )
    return _scaled(x * y, rest)


def div(a: Quantity, b: Quantity) -> Quantity:
    """Return a / b; FormulaError where b is zero."""
    (x, rest_a), (y, rest_b) = split(a), split(b)
    if y == 0:
        raise FormulaError("it divides by zero; check the denominator")
    return _scaled(x / y, rest_a if rest_b == Quantity.ONE else Quantity(Op.DIV, (rest_a, rest_b)))


def power(base: Quantity, exponent: Quantity) -> Quantity:
    """Return a power: an integer one multiplied out, a square root for one half (1 / sqrt for minus one half).

    Raises:
        FormulaError: an integer beyond the bound, zero to a negative power, what is not real, or no double holds.
    """
    number = fraction(exponent)
    if number is None:
        return function(Op.POW, base, exponent)
    if abs(number) == Fraction(1, 2):
        root = function(Op.SQRT, base)
        return root if number > 0 else div(Quantity.ONE, root)
    if number.denominator != 1:
        return function(Op.POW, base, exponent)
    if abs(number) > Graph.LARGEST_POWER:
        raise FormulaError(f"the exponent {number} is no integer up to {Graph.LARGEST_POWER}; name it as a parameter")
    n = int(number)
    if n < 0:
        return div(Quantity.ONE, power(base, constant(-number)))
    value = fraction(base)
    if value is not None:
        if max(value.numerator.bit_length(), value.denominator.bit_length()) * n > LONGEST_BITS:
            raise FormulaError("a power has too many digits; choose units that keep it smaller")
        return constant(value**n)
    result, square = Quantity.ONE, base
    while n:
        if n & 1:
            result = mul(result, square)
        n >>= 1
        if n:
            square = mul(square, square)
    return result


def function(op: Op, *args: Quantity) -> Quantity:
    """Return op(args), folded where the result is rational.

    Raises:
        FormulaError: the square root, logarithm or power of a number that has none.
    """
    x = fraction(args[0])
    if op is Op.SELECT and args[1] == args[2]:
        return args[1]
    if x is None or op is Op.ATAN2:
        return Quantity(op, args)
    if op is Op.SELECT:
        return args[1] if x > 0 else args[2]
    if op is Op.POW:
        exponent = args[1]
        y = fraction(exponent)
        if x < 0 and y is not None:
            raise FormulaError(f"({x})**({y}) is not real; take the power of a number that is not negative")
        if x == 0 and y is not None:
            return div(Quantity.ONE, Quantity.ZERO) if y < 0 else Quantity.ZERO
        return Quantity.ONE if x == 1 else Quantity(Op.POW, (Quantity.number(x), exponent))
    if op is Op.SQRT:
        if x < 0:
            raise FormulaError(f"sqrt({x}) is not real; take the root of a number that is not negative")
        above, below = isqrt(x.numerator), isqrt(x.denominator)
        if above**2 == x.numerator and below**2 == x.denominator:
            return Quantity.number(Fraction(above, below))
    if op is Op.LOG and x <= 0:
        raise FormulaError(f"log({x}) is not real; take the logarithm of a positive number")
    if op is Op.ABS:
        return Quantity.number(abs(x))
    if op is Op.SIGN:
        return Quantity.number((x > 0) - (x < 0))
    if x == 0 and op in (Op.SIN, Op.TANH):
        return Quantity.ZERO
    if (x == 0 and op in (Op.COS, Op.EXP)) or (x == 1 and op is Op.LOG):
        return Quantity.ONE if op is not Op.LOG else Quantity.ZERO
    return Quantity(op, args)


def select(guard: Quantity, a: Quantity, b: Quantity) -> Quantity:
    """Return a where the guard is positive, b elsewhere."""
    return function(Op.SELECT, guard, a, b)


def maximum(a: Quantity, b: Quantity) -> Quantity:
    """Return the larger of two, a zero last."""
    return select(sub(a, b), a, b) if a != Quantity.ZERO else maximum(b, a) if b != a else a


def minimum(a: Quantity, b: Quantity) -> Quantity:
    """Return the smaller of two, a zero first."""
    return select(sub(b, a), a, b) if b != Quantity.ZERO else minimum(b, a) if b != a else a


def split(a: Quantity) -> tuple[Fraction, Quantity]:
    """Return the constant in front of a product, and the rest (ONE for a constant)."""
    value = fraction(a)
    if value is not None:
        return value, Quantity.ONE
    if a.op is Op.NEG:
        factor, rest = split(a.args[0])
        return -factor, rest
    if a.op is Op.MUL:
        value = fraction(a.args[0])
        if value is not None:
            return value, a.args[1]
    return Fraction(1), a


def _scaled(factor: Fraction, rest: Quantity) -> Quantity:
    if rest == Quantity.ONE or factor == 0:
        return constant(factor)
    if factor == 1:
        return rest
    return Quantity(Op.NEG, (rest,)) if factor == -1 else Quantity(Op.MUL, (constant(factor), rest))


DEGREE = mul(Quantity.number(Fraction(1, 180)), Quantity.PI)

CONSTANTS: Mapping[str, Quantity] = {"pi": Quantity.PI, "deg": DEGREE}

UNARY_FUNCTIONS: Mapping[str, Op] = {
    "sin": Op.SIN,
    "cos": Op.COS,
    "sqrt": Op.SQRT,
    "exp": Op.EXP,
    "log": Op.LOG,
    "tanh": Op.TANH,
    "abs": Op.ABS,
    "sign": Op.SIGN,
}


def _sine_and_leg(name: str, x: Quantity) -> tuple[Quantity, Quantity]:
    """Return x and sqrt(1 - x^2), which keeps its digits where x is near 1."""
    value = fraction(x)
    if value is not None and abs(value) > 1:
        raise FormulaError(f"{name}({value}) is not real; take it of a number from -1 to 1")
    below, above = sub(Quantity.ONE, x), add(Quantity.ONE, x)
    return x, function(Op.SQRT, mul(below, above))


def _cosh(x: Quantity) -> Quantity:
    both = add(function(Op.EXP, x), function(Op.EXP, neg(x)))
    return div(both, Quantity.number(2))


class Composed(NamedTuple):
    """A function that is written in others."""

    arguments: int  # how many it takes
    times: int  # how often the first of them stands in it
    make: Callable[..., Quantity]  # the formula


COMPOSED: Mapping[str, Composed] = {
    "deg": Composed(1, 1, lambda x: mul(x, DEGREE)),
    "tan": Composed(1, 2, lambda x: div(function(Op.SIN, x), function(Op.COS, x))),
    "atan2": Composed(2, 1, lambda y, x: function(Op.ATAN2, y, x)),
    "atan": Composed(1, 1, lambda x: function(Op.ATAN2, x, Quantity.ONE)),
    "asin": Composed(1, 3, lambda x: function(Op.ATAN2, *_sine_and_leg("asin", x))),
    "acos": Composed(1, 3, lambda x: function(Op.ATAN2, *_sine_and_leg("acos", x)[::-1])),
    "cosh": Composed(1, 2, _cosh),
    "sinh": Composed(1, 3, lambda x: mul(function(Op.TANH, x), _cosh(x))),
}
"""sinh as tanh times cosh, which has all its digits near zero."""

EXTREMES = {"max": maximum, "min": minimum}

COMPARISONS: Mapping[type[ast.cmpop], Callable[[Quantity, Quantity, Quantity, Quantity], Quantity]] = {
    ast.Gt: lambda x, y, a, b: select(sub(x, y), a, b),
    ast.GtE: lambda x, y, a, b: select(sub(y, x), b, a),
    ast.Lt: lambda x, y, a, b: select(sub(y, x), a, b),
    ast.LtE: lambda x, y, a, b: select(sub(x, y), b, a),
}
"""a where x > y and so on, b elsewhere."""


T = TypeVar("T")

_FOLDED: Mapping[Op, Callable[..., Quantity]] = {
    Op.ADD: add,
    Op.SUB: sub,
    Op.MUL: mul,
    Op.DIV: div,
    Op.NEG: neg,
    Op.POW: power,
}


def map_quantities(thing: T, change: Callable[[Quantity], Quantity]) -> T:
    """Return `thing`, a noun of the scene or a tuple of them, with `change` applied to every quantity inside."""
    return _mapped(thing, change)  # type: ignore[no-any-return]


def _mapped(thing: Any, change: Callable[[Quantity], Quantity]) -> Any:
    if isinstance(thing, Quantity):
        return change(thing)
    if isinstance(thing, tuple):
        return tuple(_mapped(part, change) for part in thing)
    if is_dataclass(thing) and not isinstance(thing, type):
        return replace(thing, **{field.name: _mapped(getattr(thing, field.name), change) for field in fields(thing)})
    return thing


def tables_in(thing: object) -> list[Curve]:
    """Return the tables in the formulas of a noun, once each, in order."""
    found: dict[Curve, None] = {}
    waiting = [*Quantity.inside(thing)][::-1]
    while waiting:
        one = waiting.pop()
        waiting += one.args[::-1]
        if isinstance(one.value, Curve):
            found[one.value] = None
    return list(found)


def with_tables(quantity: Quantity, read: Callable[[str, int], Curve]) -> Quantity:
    """Return the formula with tables in place of their names, of which `read` gives one of so many arguments."""
    args = tuple(with_tables(arg, read) for arg in quantity.args)
    if quantity.op is Op.SELECT and isinstance(quantity.value, str):
        return replace(quantity, args=args, value=read(quantity.value, len(args)))
    same = all(new is old for new, old in zip(args, quantity.args, strict=True))
    return quantity if same else replace(quantity, args=args)


def vanishes(quantity: Quantity, values: Mapping[str, Quantity]) -> bool:
    """Tell whether a formula is zero with values of its symbols; not where it has none, which its reader reports."""
    try:
        return substituted(quantity, values).is_zero
    except FormulaError:
        return False


def substituted(quantity: Quantity, values: Mapping[str, Quantity]) -> Quantity:
    """Return the formula with quantities in place of symbols, folded again.

    Raises:
        FormulaError: it divides by what is now zero, or takes a root or logarithm that no longer exists.
    """
    if quantity.op is Op.SYMBOL:
        return values.get(str(quantity.value), quantity)
    if not quantity.args:
        return quantity
    args = [substituted(arg, values) for arg in quantity.args]
    if all(new is old for new, old in zip(args, quantity.args, strict=True)):
        return quantity
    if quantity.value is not None:
        return replace(quantity, args=tuple(args))
    operation = _FOLDED.get(quantity.op)
    return operation(*args) if operation else function(quantity.op, *args)


def instead_of(name: str, of_time: bool = False) -> str:
    """Return what is to be written in place of a function that there is not, such as that of x(t)."""
    known = (*UNARY_FUNCTIONS, *COMPOSED, *EXTREMES)
    near, product = nearest(name, known), "write * for a product"
    letter = len(name) < 3  # or a word and a number: no name of a function
    product = f"of a symbol write {name} alone" if of_time else product
    usual = f"did you mean {near}?" if near else product if letter else f"{product}; functions are {', '.join(known)}"
    return str(hint("formulas", name.lower()) or usual)
