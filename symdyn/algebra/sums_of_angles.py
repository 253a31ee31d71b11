"""Sines and cosines of sums of angles: the shortest way to write a small trigonometric polynomial.

A polynomial in c_a, s_a of a few angles is rewritten in each of several bases, and the cheapest is kept:

    the angles themselves                     c2² + c2 s2 s3 …
    sums of angles as new angles              (q2, q2+q3): needs parallel axes, where such sums are angles of bodies
    Fourier, products turned into sums        cos(2 q2 + q3)

each with s² → 1 - c² or with c² → 1 - s² in every angle. Rewriting goes through exp(i k·q): a Fourier series with
integer frequencies k, in which a change of angles is a change of k. Parts are small and repeat, so all is memoised.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import combinations
from operator import itemgetter

from symdyn.algebra.waves import (
    Angle,
    Frequency,
    Monomial,
    Poly,
    accumulate,
    as_sums,
    fourier,
    in_basis,
    integer_inverse,
)
from symdyn.graph import Expr

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
        if total % 2:
            powers[gone] = 1
        base, factor = powers.get(kept, 0), coefficient
        for k in range(total // 2 + 1):  # (1 - x²)^m = Σ (-1)^k binomial(m, k) x^2k
            if base + 2 * k:
                powers[kept] = base + 2 * k
            accumulate(result, tuple(sorted(powers.items())), factor)
            factor = -factor * (total // 2 - k) / (k + 1)
    return result
