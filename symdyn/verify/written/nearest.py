"""Correct rounding, worked out apart from the printer: the number of a type that is nearest to an exact one."""

from __future__ import annotations

from fractions import Fraction

import numpy as np


def nearest(value: Fraction, real: str) -> Fraction:
    """Return the number of the type "double" or "float" that is nearest to `value`, ties to even, exactly.

    Raises:
        OverflowError: `value` is too large for the type.
    """
    number = float(value)  # a quotient of integers, which Python rounds correctly
    if real == "double":
        return Fraction(number)
    with np.errstate(over="ignore", under="ignore"):
        near = np.float32(number)  # rounded twice, so perhaps not the nearest, but beside it
        beside = [np.nextafter(near, np.float32(end)) for end in (-np.inf, np.inf)]
    known = [Fraction(float(one)) for one in (near, *beside) if np.isfinite(one)]
    if not known or abs(value) >= Fraction(2**128 - 2**103):
        raise OverflowError(f"{number} is too large for the type float")
    unit = Fraction(2) ** -149
    return min(known, key=lambda one: (abs(one - value), one / unit % 2 ** (_exponent(one) + 1) != 0))


def _exponent(number: Fraction) -> int:
    """Return k such that the last bit of a float of this size is worth 2^(k - 149)."""
    size = int(abs(number) * 2**149)
    return max(0, size.bit_length() - 24)
