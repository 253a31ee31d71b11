"""Real types of the targets: an exact constant is rounded once, to the nearest number of the type."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from symdyn.errors import EmitError


@dataclass(frozen=True)
class Real:
    """A binary floating-point type.

    Attributes:
        name: as C calls it.
        dtype: as NumPy calls it.
        suffix: of literals and of the functions of <math.h>.
        bits: of the significand.
        lowest: exponent of the smallest positive number.
        top: exponent of the first power of two that is too large.
    """

    name: str
    dtype: str
    suffix: str
    bits: int
    lowest: int
    top: int


REALS = {
    "double": Real("double", "float64", "", 53, -1074, 1024),
    "float": Real("float", "float32", "f", 24, -149, 128),
}


def find_real(name: str) -> Real:
    """Return the real type called `name`; EmitError if there is none."""
    if name not in REALS:
        raise EmitError(f"real type {name!r} is not known; give {' or '.join(REALS)}")
    return REALS[name]


def nearest(value: Fraction, real: Real) -> float:
    """Return the number of the type that is nearest to `value`, ties to even.

    Raises:
        EmitError: `value` is too large for the type.
    """
    if not value:
        return 0.0
    if real is REALS["double"] and abs(value) < 2**1023:
        return float(value)  # Python's own division is rounded correctly
    size = abs(value)
    exponent = size.numerator.bit_length() - size.denominator.bit_length()
    if size < Fraction(2) ** exponent:
        exponent -= 1
    unit = Fraction(2) ** max(exponent - real.bits + 1, real.lowest)
    rounded = round(value / unit) * unit
    if abs(rounded) >= 2**real.top:
        raise EmitError(f"a constant of about 2^{exponent} is too large for the real type {real.name}; change units")
    return float(rounded)


@lru_cache(maxsize=4096)
def digits(value: Fraction, real: Real) -> str:
    """Return the shortest decimal text that reads back as the number nearest to `value`."""
    number = nearest(value, real)
    if real.name == "double":
        return repr(number)
    texts = (f"{number:.{count}g}" for count in range(1, 18))
    short = next(text for text in texts if _reads_as(text, number, real))
    return repr(float(short))


def _reads_as(text: str, number: float, real: Real) -> bool:
    """Tell whether `text` is read as `number`; near the largest number fewer digits may be too large."""
    try:
        return nearest(Fraction(text), real) == number
    except EmitError:
        return False
