"""Sines and cosines of sums of angles: the shortest way to write a small trigonometric polynomial.

A polynomial in c_a, s_a of a few angles is rewritten in each of several bases, and the cheapest is kept:

    the angles themselves                     c2² + c2 s2 s3 …
    sums of angles as new angles              (q2, q2+q3): needs parallel axes, where such sums are angles of bodies
    Fourier, products turned into sums        cos(2 q2 + q3)

each with s² → 1 - c² or with c² → 1 - s² in every angle. Rewriting goes through exp(i k·q): a Fourier series with
integer frequencies k, in which a change of angles is a change of k. Parts are small and repeat, so all is memoised.

A polynomial is a dictionary from monomials in sines and cosines of angles to coefficients. Terms are collected as sums
of products, with common factors taken out, the one that saves most first.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import cache
from itertools import combinations
from math import gcd, lcm
from operator import itemgetter

from flint import fmpz_mat

from symdyn.algebra.form import Form, Number
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr

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


MANY_ANGLES = 3  # beyond, not every basis is tried: there are (n + 1)^(n - 1) of them


@dataclass(frozen=True)
class AngleGroup:
    """Angles whose sums are worth a try, such as those of joints with parallel axes.

    Attributes:
        atoms: the angles.
        sums: integer combinations of them, each of shape (len(atoms),); single angles are among them.
        below: for each angle its sign, and the angle that it is added to (None: to nothing); () if nothing is known.
    """

    atoms: tuple[Expr, ...]
    sums: tuple[tuple[int, ...], ...]
    below: tuple[tuple[int, Expr | None], ...] = ()

    @property
    def is_long(self) -> bool:
        """Whether the group is better written in total angles, from its first axis on, already in the ring."""
        return len(self.atoms) > MANY_ANGLES and bool(self.below)


def total_angles(groups: Iterable[AngleGroup]) -> dict[Expr, tuple[int, Expr | None]]:
    """Return sign and angle below of every angle in a long group: what a ring needs to compute in total angles."""
    return {
        atom: step for group in groups if group.is_long for atom, step in zip(group.atoms, group.below, strict=True)
    }


@dataclass
class SumFinder:
    """Rewrites polynomials in the angles `atoms` (generator numbers) of one group; memoised.

    A sum begins with a positive multiple of the atom that comes first here. Without `waves` angles stay as they are,
    as for the constant 1°, whose squared sine says more than the cosine of 2°.
    """

    atoms: tuple[int, ...]
    sums: tuple[Frequency, ...]
    waves: bool = True
    _known: dict[tuple[tuple[Monomial, Fraction], ...], Poly] = field(default_factory=dict)

    def rewrite(self, poly: Poly) -> Poly:
        """Return `poly` with its factors in this group's angles written as short as can be found."""
        parts: dict[Monomial, Poly] = {}
        for monomial, coefficient in poly.items():
            inside = tuple([item for item in monomial if item[0][1][0][0] in self.atoms])
            outside = tuple([item for item in monomial if item not in inside]) if inside else monomial
            parts.setdefault(outside, {})[inside] = coefficient
        short = [self._shortest(part) for part in parts.values()]
        if all(new is old for new, old in zip(short, parts.values(), strict=True)):
            return poly
        result: Poly = {}
        for outside, part in zip(parts, short, strict=True):
            for inside, coefficient in part.items():
                accumulate(result, tuple(sorted(outside + inside)), coefficient)
        return result

    def _shortest(self, part: Poly) -> Poly:
        if len(part) == 1 and sum(power for _, power in next(iter(part))) < 2:  # one factor at most, not squared
            return part
        items = sorted(part.items(), key=itemgetter(0))
        leading = items[0][1]
        key = tuple(items) if leading == 1 else tuple((monomial, a / leading) for monomial, a in items)
        if key not in self._known:
            self._known[key] = min((_best_elimination(p) for p in self._candidates(dict(key))), key=cost)
        short = self._known[key]
        if len(short) == len(key) and all(short.get(monomial) == a for monomial, a in key):
            return part
        return short if leading == 1 else {monomial: a * leading for monomial, a in short.items()}

    def _candidates(self, part: Poly) -> Iterable[Poly]:
        """Yield `part` in every basis that is tried, the angles themselves first."""
        yield part
        if not self.waves:
            return
        present = sorted({angle[0][0] for monomial in part for (_, angle), _ in monomial}, key=self.atoms.index)
        series = fourier(part, present)
        where = [self.atoms.index(atom) for atom in present]
        others = [k for k in range(len(self.atoms)) if k not in where]
        directions = [tuple(s[k] for k in where) for s in self.sums if not any(s[k] for k in others)]
        identity = {tuple(int(i == k) for k in range(len(present))) for i in range(len(present))}
        if 1 < len(present) <= MANY_ANGLES:
            for basis in combinations(directions, len(present)):
                inverse = integer_inverse(basis)
                if inverse is not None and set(basis) != identity:
                    yield in_basis(series, basis, inverse, present)
        yield as_sums(series, present)


def cost(poly: Poly) -> int:
    """Return how long `poly` reads: terms, factors, powers, angles that are no plain sums, numbers."""
    total = 0
    for monomial, coefficient in poly.items():
        total += 4 + 2 * (abs(coefficient) != 1)
        for (_, angle), power in monomial:
            total += 4 + 2 * (power > 1) + len(angle) - 1 + 4 * any(abs(k) > 1 for _, k in angle)
    return total


# s² → 1 - c² or c² → 1 - s²


def _best_elimination(poly: Poly) -> Poly:
    """Return `poly` with s² or c² eliminated in each angle, whichever is shorter."""
    angles = sorted({angle for monomial in poly for (_, angle), power in monomial if power > 1})
    for angle in angles:
        poly = min((poly, _eliminate(poly, "s", angle), _eliminate(poly, "c", angle)), key=cost)
    return poly


def _eliminate(poly: Poly, kind: str, angle: Angle) -> Poly:
    """Return `poly` with the square of `kind` of `angle` replaced by 1 minus the other square."""
    gone, kept = (kind, angle), ("c" if kind == "s" else "s", angle)
    result: Poly = {}
    for monomial, coefficient in poly.items():
        powers = dict(monomial)
        total = powers.pop(gone, 0)
        if total < 2:
            accumulate(result, monomial, coefficient)
            continue
        if total % 2:
            powers[gone] = 1
        base, factor = powers.get(kept, 0), coefficient
        for k in range(total // 2 + 1):  # (1 - x²)^m = Σ (-1)^k binomial(m, k) x^2k
            if base + 2 * k:
                powers[kept] = base + 2 * k
            accumulate(result, tuple(sorted(powers.items())), factor)
            factor = -factor * (total // 2 - k) / (k + 1)
    return result


Item = tuple[Fraction, Mapping[int, int]]  # one term: a number times powers of words

SMALL = 12  # integers up to this size may stay behind when a common number is taken out


class Monomials:
    """The forms that terms are products of, numbered, so that collecting compares integers."""

    def __init__(self) -> None:
        self.forms: list[Form] = []
        self._numbers: dict[Form, int] = {}

    def number(self, form: Form) -> int:
        if form not in self._numbers:
            self._numbers[form] = len(self.forms)
            self.forms.append(form)
        return self._numbers[form]

    def powers(self, factors: Mapping[int, int]) -> list[Form]:
        """Return the factors of a term as forms."""
        return [self.forms[word].power(power) for word, power in factors.items()]

    def term(self, item: Item) -> Form:
        """Return number · Π word^power."""
        return Form.product([Number(item[0]), *self.powers(item[1])])

    def collect(self, items: Sequence[Item]) -> Form:
        """Return Σ number · Π word^power with common factors taken out."""
        if len(items) == 1:
            return self.term(items[0])
        number, common, rest = take_out(items)
        inner = Form.sum(self.collect(part) for part in partition(rest)).plus_first
        return Form.product([Number(number), inner, *self.powers(common)])


def partition(items: Sequence[Item]) -> list[list[Item]]:
    """Return the terms in parts that share a factor: the factor that saves most first, the rest alone."""
    counts: dict[tuple[int, int], int] = {}
    for _, factors in items:
        for word, power in factors.items():
            for k in range(1, power + 1):
                counts[word, k] = counts.get((word, k), 0) + 1
    best, saving = None, 0
    for (word, power), count in counts.items():
        if (count - 1) * power > saving:
            best, saving = (word, power), (count - 1) * power
    if best is None:
        return [[item] for item in items]
    word, power = best
    chosen = [item for item in items if item[1].get(word, 0) >= power]
    return [chosen, *partition([item for item in items if item[1].get(word, 0) < power])]


def take_out(items: Sequence[Item]) -> tuple[Fraction, dict[int, int], list[Item]]:
    """Return (number, common factors, what is left of the terms)."""
    number = content([a for a, _ in items])
    common = dict(items[0][1]) if items else {}
    for _, factors in items[1:]:
        if not common:
            break
        common = {word: min(power, factors[word]) for word, power in common.items() if word in factors}
    rest: list[Item] = []
    for a, factors in items:
        left = {word: power - common.get(word, 0) for word, power in factors.items()} if common else factors
        rest.append((a if number == 1 else a / number, {word: power for word, power in left.items() if power}))
    return number, common, rest


def content(numbers: Sequence[Fraction]) -> Fraction:
    """Return a number worth taking out of a sum: what leaves small integers, else 1; with the sign of the majority."""
    negative = sum(a < 0 for a in numbers)
    minority = 2 * negative < len(numbers) or (2 * negative == len(numbers) and (not numbers or numbers[0] > 0))
    sign = 1 if minority else -1
    if not numbers:
        return Fraction(1)
    if len(numbers) == 1:
        return numbers[0]
    scale = lcm(*(a.denominator for a in numbers))
    wholes = [a.numerator * (scale // a.denominator) for a in numbers]
    divisor = gcd(*wholes)
    if max(map(abs, wholes)) <= SMALL * divisor:
        return Fraction(sign * divisor, scale)
    return Fraction(sign)


def rounded(number: Fraction, digits: int) -> Fraction:
    """Return a number rounded to significant decimal digits."""
    with localcontext(prec=digits):
        return Fraction(Decimal(number.numerator) / number.denominator)
