"""2/π in words of 64 bits, for angles of any size.

Of m 2^e 2/π what counts is the remainder by 4: bits of 2/π that make it larger than that by m 2^e alone are skipped,
192 of those that follow are multiplied by m, and 126 bits of the fraction stay. Doubles come no nearer to a multiple
of π/2 than 2^-62, so that 64 bits are right.

Reference: Payne and Hanek, Radian reduction for trigonometric functions, SIGNUM Newsletter 18 (1983).
"""

from __future__ import annotations

from functools import cache

WORDS = 20
"""The first is 0, so that a window may begin before the point; doubles end at 2^1024."""


@cache
def words() -> tuple[str, ...]:
    """Return the words as hexadecimal numbers."""
    import mpmath

    bits = 64 * (WORDS - 1)
    with mpmath.workprec(bits + 64):
        digits = int(mpmath.floor(mpmath.ldexp(2 / mpmath.pi, bits)))
    return tuple(f"0x{digits >> 64 * place & (1 << 64) - 1:016x}" for place in reversed(range(WORDS)))
