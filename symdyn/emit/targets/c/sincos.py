"""The numbers of the generated sincos: π/2 in parts and minimax polynomials, as `benchmarks/minimax.py` prints them.

    k = round(2x/π),   y = x - k π/2 = hi + lo       |y| ≤ π/4, four parts of π/2, the first three times k exact
    sin y = y + y³ S(y²),   cos y = 1 - y²/2 + y⁴ C(y²)

The reduction keeps a low part, so that the result is right to 1 ulp next to multiples of π/2 too. The error of the
second difference is folded into the third part: where it is not zero, the difference is so large that rounding the sum
does no harm. In float everything is computed in double, where the sum of three parts and short polynomials are enough,
and rounded once. The code has polynomials in h = y²/2, which is needed anyway; powers of two cost no digit. What y is
too large by is subtracted together with the rest of the series, whose signs are such that -0 stays -0.

References: Cody and Waite, Software Manual for the Elementary Functions (1980), for the reduction in parts; the order
of summation is that of FDLIBM's k_sin.c and k_cos.c.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symdyn.emit.code.short_sines import ShortSines

LIMIT_EXPONENT = 20
"""Angles below 2^20 in size are reduced here, others by the C library."""

CHAINS = 4
"""Angles that one turn of the loop takes side by side: one waits for its own results most of the time."""

LANES_AT_ONCE = 8
"""Rows of angles that go through both halves together: what remains of them waits in the nearest cache."""

TINY = 2.0**-200
"""Added and subtracted again, it leaves alone what has digits to lose; what is smaller becomes a multiple of 2^-252."""

TWO_OVER_PI = 0.6366197723675814

HALF_PI = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21, 8.4784276603689e-32)

SINE = {
    "double": (
        -0.1666666666666663,
        0.00833333333332184,
        -0.00019841269829358544,
        2.755731353852763e-06,
        -2.5050734392599535e-08,
        1.589543355068773e-10,
    ),
    "float": (
        -0.16666666640796732,
        0.008333329304823271,
        -0.00019839312266407334,
        2.7181216116233883e-06,
    ),
}

COSINE = {
    "double": (
        0.0416666666666666,
        -0.0013888888888874474,
        2.4801587289671537e-05,
        -2.7557314401030616e-07,
        2.0875729281241468e-09,
        -1.135993424414567e-11,
    ),
    "float": (
        0.04166666662282967,
        -0.0013888883753536672,
        2.4799520039253818e-05,
        -2.7210240065091214e-07,
    ),
}


def horner(coefficients: Sequence[float], variable: str) -> str:
    """Return a polynomial as C: c0 + h * (c1 + h * (…))."""
    *low, top = coefficients
    text = repr(top)
    for coefficient in reversed(low):
        text = f"{coefficient!r} + {variable} * {_factor(text)}"
    return text


def _factor(text: str) -> str:
    return f"({text})" if " " in text or text.startswith("-") else text


def in_halves(coefficients: Sequence[float], first: int) -> list[float]:
    """Return the coefficients of a polynomial in z/2 for those of one in z, the first of them times 2^first."""
    return [coefficient * 2.0**power for power, coefficient in enumerate(coefficients, first)]


def sincos_values(real: str, short: ShortSines | None = None) -> Mapping[str, Any]:
    """Return what the template of sincos is given for "double" or "float", or for shorter sines of this type."""
    if short:
        return {
            "short": short,
            "two_over_pi": repr(TWO_OVER_PI),
            "sine": horner(short.sine, "z[j]"),
            "cosine": horner(short.cosine, "z[j]"),
            "chains": CHAINS,
            "limit_exponent": short.limit_exponent,
        }
    return {
        "two_over_pi": repr(TWO_OVER_PI),
        "half_pi": tuple(map(repr, HALF_PI)),
        "sine": horner(in_halves([-c for c in SINE[real]], 1), "h[j]"),
        "cosine": horner(in_halves(COSINE[real], 2), "h[j]"),
        "short": None,
        "tiny": repr(TINY),
        "lockstep": LANES_AT_ONCE,
        "chains": CHAINS,
        "limit_exponent": LIMIT_EXPONENT,
    }
