"""Trigonometric polynomials as Fourier series, in which a change of angles is a change of integer frequencies.

A polynomial here is a dictionary from monomials in sines and cosines of angles to coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache

from flint import fmpz_mat

Angle = tuple[tuple[int, int], ...]  # ((atom, multiple), …), in the order of the group
Factor = tuple[str, Angle]  # ("c" or "s", angle)
Monomial = tuple[tuple[Factor, int], ...]  # ((factor, power), …), in ascending order
Poly = dict[Monomial, Fraction]
Frequency = tuple[int, ...]
Basis = tuple[Frequency, ...]  # rows: what each new angle is in terms of the atoms


def accumulate(poly: Poly, monomial: Monomial, coefficient: Fraction) -> None:
    """Add one term to `poly`."""
    total = poly.get(monomial, 0) + coefficient
    if total:
        poly[monomial] = total
    else:
        poly.pop(monomial, None)


# Fourier series: frequency -> (a, b) for a cos(k·q) + b sin(k·q), the first entry of k that is not 0 positive

Series = dict[Frequency, tuple[Fraction, Fraction]]
NOTHING = (Fraction(0), Fraction(0))


def fourier(part: Poly, atoms: Sequence[int]) -> Series:
    """Return a polynomial in the angles of `atoms` as a Fourier series."""
    place = {atom: k for k, atom in enumerate(atoms)}
    total: Series = {}
    for monomial, coefficient in part.items():
        powers = tuple((kind, place[angle[0][0]], angle[0][1], power) for (kind, angle), power in monomial)
        for frequency, (a, b) in _series_of_monomial(powers, len(atoms)):
            before = total.get(frequency, NOTHING)
            total[frequency] = (before[0] + coefficient * a, before[1] + coefficient * b)
    return {frequency: pair for frequency, pair in total.items() if any(pair)}


@cache
def _series_of_monomial(
    powers: tuple[tuple[str, int, int, int], ...], n: int
) -> tuple[tuple[Frequency, tuple[Fraction, Fraction]], ...]:
    """Return the series of Π c or s of (multiple · atom) to a power."""
    zero = (0,) * n
    series: Series = {zero: (Fraction(1), Fraction(0))}
    half = Fraction(1, 2)
    for kind, place, multiple, power in powers:
        step = tuple(multiple if k == place else 0 for k in range(n))
        for _ in range(power):
            grown: Series = {}
            for k, (a, b) in series.items():
                # cos(k)c = ½cos(k+1) + ½cos(k-1), sin(k)c = ½sin(k+1) + ½sin(k-1)
                # cos(k)s = ½sin(k+1) - ½sin(k-1), sin(k)s = ½cos(k-1) - ½cos(k+1)
                up = (a, b) if kind == "c" else (-b, a)
                down = (a, b) if kind == "c" else (b, -a)
                for sign, (x, y) in ((1, up), (-1, down)):
                    _add_wave(grown, tuple(p + sign * q for p, q in zip(k, step, strict=True)), half * x, half * y)
            series = grown
    return tuple(sorted(series.items()))


def _add_wave(series: Series, k: Frequency, a: Fraction, b: Fraction) -> None:
    first = next((entry for entry in k if entry), 0)
    if first < 0:
        k, b = tuple(-entry for entry in k), -b
    elif first == 0:
        b = Fraction(0)
    before = series.get(k, NOTHING)
    series[k] = (before[0] + a, before[1] + b)


def as_sums(series: Series, atoms: Sequence[int]) -> Poly:
    """Return the series as it stands: one sine or cosine a term."""
    result: Poly = {}
    for k, (a, b) in series.items():
        angle = tuple((atom, entry) for atom, entry in zip(atoms, k, strict=True) if entry)
        for kind, coefficient in (("c", a), ("s", b)):
            if coefficient:
                result[(((kind, angle), 1),) if angle else ()] = coefficient
    return result


def in_basis(series: Series, basis: Basis, inverse: Basis, atoms: Sequence[int]) -> Poly:
    """Return the series as a polynomial in sines and cosines of the angles in `basis`."""
    angles = [tuple((atom, entry) for atom, entry in zip(atoms, row, strict=True) if entry) for row in basis]
    result: Poly = {}
    for k, (a, b) in series.items():
        turned = tuple(sum(x * row[j] for x, row in zip(k, inverse, strict=True)) for j in range(len(basis)))
        for coefficient, wave in zip((a, b), _wave(turned), strict=True):
            if coefficient:
                for powers, factor in wave:
                    monomial = [
                        ((kind, angle), power)
                        for angle, pair in zip(angles, powers, strict=True)
                        for kind, power in zip("cs", pair, strict=True)
                        if power
                    ]
                    accumulate(result, tuple(sorted(monomial)), coefficient * factor)
    return result


Wave = tuple[tuple[tuple[tuple[int, int], ...], int], ...]  # ((((power of c, of s) of each angle), coefficient), …)


@cache
def _wave(k: Frequency) -> tuple[Wave, Wave]:
    """Return cos and sin of k·u as polynomials in c_u, s_u with s² eliminated."""
    pair: list[dict[tuple[tuple[int, int], ...], int]] = [{(): 1}, {}]
    for entry in k:
        turned: list[dict[tuple[tuple[int, int], ...], int]] = [{}, {}]
        single = _multiple(abs(entry))
        for i in (0, 1):
            for j in (0, 1):
                sign = (-1 if i and j else 1) * (-1 if j and entry < 0 else 1)
                target = turned[(i + j) % 2]
                for left, x in pair[i].items():
                    for right, y in single[j].items():
                        key = (*left, right)
                        target[key] = target.get(key, 0) + sign * x * y
        pair = turned
    return tuple(tuple((key, value) for key, value in wave.items() if value) for wave in pair)  # type: ignore[return-value]


@cache
def _multiple(n: int) -> tuple[dict[tuple[int, int], int], dict[tuple[int, int], int]]:
    """Return cos(n u) and sin(n u) by (power of c, power of s): Chebyshev's recurrence."""
    before: list[dict[tuple[int, int], int]] = [{(0, 0): 1}, {}]
    now: list[dict[tuple[int, int], int]] = [{(1, 0): 1}, {(0, 1): 1}]
    for _ in range(n):
        after = []
        for old, wave in zip(before, now, strict=True):
            fresh = {key: -value for key, value in old.items()}
            for (c, s), value in wave.items():
                fresh[c + 1, s] = fresh.get((c + 1, s), 0) + 2 * value
            after.append({key: value for key, value in fresh.items() if value})
        before, now = now, after
    return before[0], before[1]


def integer_inverse(rows: Sequence[Frequency]) -> Basis | None:
    """Return the inverse of a unimodular matrix, None if it is not unimodular."""
    matrix = fmpz_mat([list(row) for row in rows])
    if abs(int(matrix.det())) != 1:
        return None
    return tuple(tuple(int(x.p) for x in row) for row in matrix.inv().tolist())
