"""Building quantities in one canonical form: constants folded, and a product's constant in front.

So `pi/2`, `0.5*pi` and `90 deg` are one quantity, and two scenes that say the same compare equal in the simple cases.
Folded constants stay within what a double can hold, so no formula of a few characters can keep the machine busy.
"""

from __future__ import annotations

import sys
from fractions import Fraction
from math import isqrt

from symdyn.graph import Op
from symdyn.scene.values.quantity import FormulaError, Quantity

LARGEST = Fraction(sys.float_info.max)
SMALLEST = Fraction(1, 2**1074)
HARMLESS_BITS = 1000
LONGEST_BITS = 8192
LARGEST_POWER = 64


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
    """Return a / b.

    Raises:
        FormulaError: b is zero.
    """
    (x, rest_a), (y, rest_b) = split(a), split(b)
    if y == 0:
        raise FormulaError("it divides by zero; check the denominator")
    return _scaled(x / y, rest_a if rest_b == Quantity.ONE else Quantity(Op.DIV, (rest_a, rest_b)))


def in_words(exponent: Fraction | None) -> str:
    """Return what to write for a power that no integer, or nobody, tells: roots, or exponentials of plain numbers."""
    if exponent is not None and exponent.denominator == 2 and 0 < exponent < LARGEST_POWER:
        whole = int(exponent)
        return f"write {'x' if whole == 1 else f'x**{whole}'}*sqrt(x) for x**({exponent})"
    y = "y" if exponent is None else f"({exponent})"
    return f"write exp({y}*log(x/x0)) for (x/x0)**{y}, x0 a parameter in the unit of x: log takes a plain number"


def power(base: Quantity, exponent: Fraction) -> Quantity:
    """Return base to an integer power, or its square root for an exponent of one half (1 / sqrt for minus one half).

    Raises:
        FormulaError: another exponent, zero to a negative power, or a result that no double holds.
    """
    if abs(exponent) == Fraction(1, 2):
        root = function(Op.SQRT, base)
        return root if exponent > 0 else div(Quantity.ONE, root)
    if exponent.denominator != 1 or abs(exponent) > LARGEST_POWER:
        raise FormulaError(
            f"the exponent {exponent} is neither an integer up to {LARGEST_POWER} nor 1/2; {in_words(exponent)}"
        )
    n = int(exponent)
    if n < 0:
        return div(Quantity.ONE, power(base, Fraction(-n)))
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
        FormulaError: the square root or logarithm of a number that has none.
    """
    x = fraction(args[0])
    if x is None or op is Op.ATAN2:
        return Quantity(op, args)
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
