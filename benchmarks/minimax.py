"""Coefficients of the generated sincos: minimax polynomials by Remez' exchange, rounded one after the other.

    sin y = y + y³ S(z),   cos y = 1 - z/2 + z² C(z),   z = y², |y| ≤ π/4

S minimises the relative error of sin, C the absolute error of cos. Short ones minimise both absolute errors, and leave
more of cos open: cos y = 1 + z C(z). Each leading coefficient is rounded to the real
type and the rest is fitted again, so that rounding costs almost nothing. The parts of π/2 are cut, not rounded: k times
one of the first ones is exact for |k| < 2²⁰, and all are positive, which keeps the sign of -0.

    python benchmarks/minimax.py        prints what stands in symdyn/emit/targets/c/writer.py, and in
                                        symdyn/emit/code/spelling.py
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mpmath
from mpmath import mp, mpf

mp.dps = 60
EDGE = (mp.pi / 4) ** 2 * (1 + mpf(2) ** -20)
Function = Callable[[mpf], mpf]


def sine_rest(z: mpf) -> mpf:
    """Return (sin y - y) / y³ at z = y²."""
    return mpmath.nsum(lambda k: (-1) ** (k + 1) * z**k / mpmath.factorial(2 * k + 3), [0, 30])


def cosine_rest(z: mpf) -> mpf:
    """Return (cos y - 1 + z/2) / z² at z = y²."""
    return mpmath.nsum(lambda k: (-1) ** k * z**k / mpmath.factorial(2 * k + 4), [0, 30])


def sine_weight(z: mpf) -> mpf:
    """Return what an error of S counts in sin, relatively."""
    y = mpmath.sqrt(z)
    return z * y / mpmath.sin(y) if y else mpf(0)


def cosine_weight(z: mpf) -> mpf:
    """Return what an error of C counts in cos, absolutely."""
    return z**2


def cosine_quotient(z: mpf) -> mpf:
    """Return (cos y - 1) / z at z = y²."""
    return z * cosine_rest(z) - mpf(1) / 2


def absolute_sine_weight(z: mpf) -> mpf:
    """Return what an error of S counts in sin, absolutely."""
    return z * mpmath.sqrt(z)


def quotient_weight(z: mpf) -> mpf:
    """Return what an error of (cos y - 1) / z counts in cos, absolutely."""
    return z


FULL = (("sine", sine_rest, sine_weight), ("cosine", cosine_rest, cosine_weight))
SHORT = (("sine", sine_rest, absolute_sine_weight), ("cosine", cosine_quotient, quotient_weight))


def remez(f: Function, weight: Function, powers: Sequence[int]) -> tuple[list[mpf], mpf]:
    """Return the coefficients of `powers` that minimise the largest weighted error on [0, EDGE], and that error."""
    n = len(powers)
    points = [EDGE * (1 - mpmath.cos(mp.pi * (i + mpf(1) / 2) / (n + 1))) / 2 for i in range(n + 1)]
    grid = [EDGE * mpf(i) / 400 for i in range(1, 401)]
    values, weights = [f(z) for z in grid], [weight(z) for z in grid]
    for _ in range(8):
        rows = [[z**p for p in powers] + [(-1) ** i / weight(z)] for i, z in enumerate(points)]
        solved = mpmath.lu_solve(mpmath.matrix(rows), mpmath.matrix([f(z) for z in points]))
        found = [solved[i] for i in range(n)]
        errors = [
            w * (v - sum(c * z**p for c, p in zip(found, powers, strict=True)))
            for z, v, w in zip(grid, values, weights, strict=True)
        ]
        points = extremes(grid, errors, n + 1)
    return found, max(abs(error) for error in errors)


def extremes(grid: Sequence[mpf], errors: Sequence[mpf], count: int) -> list[mpf]:
    """Return the places of the largest errors of alternating sign, `count` of them."""
    best: list[int] = []
    for i, error in enumerate(errors):
        if best and (errors[best[-1]] > 0) == (error > 0):
            if abs(error) > abs(errors[best[-1]]):
                best[-1] = i
        else:
            best.append(i)
    while len(best) > count:
        best.pop(0 if abs(errors[best[0]]) < abs(errors[best[-1]]) else -1)
    assert len(best) == count, "the error must alternate; use a finer grid"
    return [grid[i] for i in best]


def rounded(f: Function, weight: Function, terms: int) -> tuple[list[float], mpf]:
    """Return coefficients as doubles, lowest power first, and the largest weighted error."""
    fixed: list[float] = []
    while len(fixed) < terms:
        powers = range(len(fixed), terms)
        rest, _ = remez(lambda z: f(z) - sum(c * z**p for p, c in enumerate(fixed)), weight, powers)
        fixed.append(float(rest[0]))
    grid = [EDGE * mpf(i) / 1000 for i in range(1, 1001)]
    return fixed, max(abs(weight(z) * (f(z) - sum(c * z**p for p, c in enumerate(fixed)))) for z in grid)


def parts_of_half_pi(bits: int, count: int) -> list[float]:
    """Return π/2 cut into `count` parts of `bits` bits and a last double."""
    rest, parts = mp.pi / 2, []
    for _ in range(count):
        unit = mpf(2) ** (mpmath.floor(mpmath.log(rest, 2)) + 1 - bits)
        parts.append(float(mpmath.floor(rest / unit) * unit))
        rest -= mpf(parts[-1])
    return [*parts, float(rest)]


if __name__ == "__main__":
    for label, both, terms in (("double", FULL, (6, 6)), ("float", FULL, (4, 4)), ("1e-10", SHORT, (4, 5))):
        for (name, f, weight), count in zip(both, terms, strict=True):
            coefficients, error = rounded(f, weight, count)
            print(f"{label} {name}: error 2^{float(mpmath.log(error, 2)):.1f}")
            print("\n".join(f"    {value!r}," for value in coefficients))
    print("half pi:", *parts_of_half_pi(33, 3), sep="\n    ")
    print("two over pi:", float(2 / mp.pi), " pi over two:", float(mp.pi / 2))
