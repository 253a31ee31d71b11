"""Decimals that stand for multiples of π, as files write them because they cannot write π.

    1.57079633  is π/2 rounded at its last digit
    1.5708      is too, and stays a decimal: π/2 differs from it by 4e-6, which other readers of the file do not add
    1.57079632  is π/2 cut off, not rounded: it stays a decimal

The multiple must be simple, k π / d with d in `DENOMINATORS` and |k / d| <= 2, or whole degrees, and the text must be
that multiple *correctly rounded at its own last digit*, which has at least seven before it: what reading changes is
below 5e-8 rad. Beyond fifteen digits a text is often a double printed in full, right only in its first sixteen
(1.57079632679489655800): then it is enough that the double nearest to the text is the double nearest to the multiple.
"""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from fractions import Fraction

from symdyn.scene.values import folding
from symdyn.scene.values.quantity import Quantity

DENOMINATORS = (1, 2, 3, 4, 5, 6, 8, 9, 10, 12)
DEGREES = 180

FEWEST_DIGITS = 8
"""Significant digits from which on a decimal may be a multiple of π."""

DIGITS_OF_A_DOUBLE = 15
"""Every decimal of so many digits survives being stored as a double; one of more digits may not."""

LONGEST_TEXT = 60

PI_50 = Fraction("3.14159265358979323846264338327950288419716939937511")

_DECIMAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?\Z")


def snap_angle(text: str) -> Quantity | None:
    """Return the simple multiple of π that a decimal is rounded from, None if it is not clear that it is one.

    Args:
        text: a decimal as the file writes it, rad, such as "-1.5707963" or "7.853981634e-1".
    """
    text = text.strip()
    if len(text) > LONGEST_TEXT or not _DECIMAL.match(text):
        return None
    for denominator in (*DENOMINATORS, DEGREES):
        turns = Fraction(round(Fraction(text) * denominator / PI_50), denominator)
        if turns and abs(turns) <= 2 and is_rounding(text, turns * PI_50):
            return folding.mul(Quantity.number(turns), Quantity.PI)
    return None


def is_rounding(text: str, exact: Fraction, fewest_digits: int = FEWEST_DIGITS) -> bool:
    """Return whether a decimal is a number rounded correctly at the decimal's own last digit.

    Args:
        text: a decimal such as "0.70711".
        exact: the number, or a fraction within 1e-50 of it.
        fewest_digits: significant digits that the decimal must have.
    """
    try:
        decimal = Decimal(text)
    except InvalidOperation:
        return False
    _, digits, exponent = decimal.as_tuple()
    if not isinstance(exponent, int) or len(digits) < fewest_digits:
        return False
    if len(digits) > DIGITS_OF_A_DOUBLE and float(decimal) == float(exact):
        return True
    return abs(Fraction(decimal) - exact) * 2 <= Fraction(10) ** exponent
