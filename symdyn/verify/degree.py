"""How far two different graphs can look alike over a random field: degrees, heights, and what they allow.

Every node is read as N / (D^scale Π g_k^e_k), where N is a Laurent polynomial with integer coefficients in the symbols
and in the units of the angles, D the common denominator of all constants, and g_k the numerators of the divisors met
so far. Keeping the divisors apart, instead of multiplying denominators out at every sum, keeps the bounds small: a
division by g cancels an earlier multiplication by g. Of N the degree is bounded, and the sum of the absolute values of
its coefficients (which multiply, and add): a prime at which N vanishes identically divides them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import log, log10
from typing import NamedTuple

from symdyn.algebra import Needs
from symdyn.graph import Expr, Op, arithmetic, reachable

UNEVENNESS = 64  # a prime after a long gap is drawn more often than the average one; no gap there is this much longer


UNDIVIDED: dict[int, int] = {}


class Degree(NamedTuple):
    """Bounds of one node.

    Attributes:
        numerator: degree of N.
        bits: log2 of the sum of the absolute coefficients of N.
        scale: exponent of D below.
        below: exponents of the divisors below (negative: above).
    """

    numerator: int
    bits: float = 0.0
    scale: int = 0
    below: dict[int, int] = UNDIVIDED


class Degrees:
    """The algebra of these bounds."""

    def __init__(self, needs: Needs) -> None:
        """Start without divisors; `needs` tells D and how finely angles are divided."""
        self.needs = needs
        self.denominator_bits = float((2 * needs.denominator).bit_length())  # 2 is below every sine
        self.divisors: list[Degree] = []  # N of g_k
        self.hashed: list[int] = []  # degree of whatever stands below a function or an angle

    def constant(self, value: Fraction) -> Degree:
        """Return degree 0."""
        if value.denominator == 1:
            return Degree(0, float(value.numerator.bit_length()))
        return Degree(0, value.numerator.bit_length() + self.denominator_bits, 1)

    def pi(self) -> Degree:
        """Return degree 1: π is an independent value."""
        return Degree(1)

    def add(self, a: Degree, b: Degree) -> Degree:
        """Return the bounds of a sum over the common denominator."""
        below, scale = a.below, max(a.scale, b.scale)
        if b.below is not below and b.below != below:
            below = {k: max(a.below.get(k, 0), b.below.get(k, 0)) for k in {**a.below, **b.below}}
        (one, bits), (other, more) = self._lifted(a, below, scale), self._lifted(b, below, scale)
        return Degree(max(one, other), max(bits, more) + 1, scale, below)

    sub = add

    def mul(self, a: Degree, b: Degree) -> Degree:
        """Return the bounds of a product."""
        if not a.below or not b.below:
            below = a.below or b.below
        else:
            keys = {**a.below, **b.below}
            below = {k: e for k in keys if (e := a.below.get(k, 0) + b.below.get(k, 0))}
        return Degree(a.numerator + b.numerator, a.bits + b.bits, a.scale + b.scale, below)

    def div(self, a: Degree, b: Degree) -> Degree:
        """Return the bounds of a quotient; the numerator of b becomes a divisor of its own."""
        self.divisors.append(Degree(b.numerator, b.bits))
        inverse = {k: -e for k, e in b.below.items()}
        inverse[len(self.divisors) - 1] = 1
        return self.mul(a, Degree(0, b.scale * self.denominator_bits, 0, inverse))

    def neg(self, a: Degree) -> Degree:
        """Return the same bounds."""
        return a

    def function(self, node: Expr, args: Sequence[Degree]) -> Degree:
        """Return the degree in units of a sine or a root, and 1 for an uninterpreted function: an independent value."""
        if node.op is Op.SQRT and node.args[0].op is Op.CONSTANT:
            return Degree(0, float(self.needs.denominator.bit_length()) + 64, 1)
        if node.op is Op.SQRT:  # a formal root: weighed like its radicand, it stays above all its conjugates
            radicand = self.total(args[0])
            return Degree(radicand.numerator, radicand.bits)
        self.hashed += [self.total(arg).numerator for arg in args]
        if node.op in (Op.SIN, Op.COS):
            form = node.args[0].linear_form()
            degree = abs(form.constant) * self.needs.radian
            degree += sum(abs(coefficient) for _, coefficient in form.terms) * self.needs.atom
            return Degree(int(degree), self.denominator_bits, 1)
        return Degree(1)

    def total(self, a: Degree) -> Degree:
        """Return the bounds with everything multiplied out; degrees count twice, as exponents have either sign."""
        degree, bits = self._lifted(a, UNDIVIDED, a.scale)
        for k, e in a.below.items():
            degree += abs(e) * self.divisors[k].numerator
            bits += abs(e) * self.divisors[k].bits
        return Degree(2 * degree, bits)

    def _lifted(self, a: Degree, below: dict[int, int], scale: int) -> tuple[int, float]:
        """Return degree and bits of the numerator when the denominator is raised to `below` and D^scale."""
        degree, bits = a.numerator, a.bits + (scale - a.scale) * self.denominator_bits
        if below is a.below:
            return degree, bits
        for k, e in below.items():
            spare = e - a.below.get(k, 0)
            degree += spare * self.divisors[k].numerator
            bits += spare * self.divisors[k].bits
        return degree, bits


@dataclass(frozen=True)
class Bound:
    """How sure agreement makes us.

    Attributes:
        degree: of a difference of two sides, multiplied out, and of all that a function or an angle hashes.
        height: log2 of the norm of its coefficients.
    """

    degree: int
    height: float

    def error_log10(self, needs: Needs, primes: int, points: int) -> float:
        """Return log10 of the probability that two different functions agree everywhere.

        Over each prime: it divides all coefficients (there are at most height / log2(p) such primes, among all that
        could have been drawn), or all points are zeros of the difference (degree / p each, Schwartz 1980, Zippel 1979).
        """
        low = needs.lowest_bit
        candidates = low * log10(2) - log10(low * log(2)) - log10(needs.order) - len(needs.radicands) * log10(2)
        unlucky = log10(max(self.height, 1.0) / low * UNEVENNESS) - candidates
        zeros = points * (log10(max(self.degree, 1)) - low * log10(2))
        return primes * min(0.0, log10(10**unlucky + 10**zeros))


def bound(left: Sequence[Expr], right: Sequence[Expr], needs: Needs) -> Bound:
    """Return the bound for the differences left[i] - right[i]."""
    return Bounds(needs).of(left, right)


class Bounds:
    """Bounds of many differences: what was found of a node is kept, and a divisor of several of them is one."""

    def __init__(self, needs: Needs) -> None:
        """Start without nodes."""
        self._algebra = Degrees(needs)
        self._known: dict[Expr, Degree] = {}
        self._below: dict[Expr, int] = {}  # bit k: list k of `_hashed` is of a node below
        self._hashed: list[list[int]] = []

    def of(self, left: Sequence[Expr], right: Sequence[Expr]) -> Bound:
        """Return the bound for the differences left[i] - right[i]."""
        algebra, wanted = self._algebra, self._algebra.needs
        both = zip(self._evaluated(left), self._evaluated(right), strict=True)
        totals = [algebra.total(algebra.sub(a, b)) for a, b in both]
        hashed = [degree for side in (left, right) for degree in self._hashed_below(side)]
        collisions = len(hashed) ** 2 * max(hashed, default=0)
        degree = max((total.numerator for total in totals), default=0) + collisions
        height = max((total.bits for total in totals), default=0.0) * wanted.order  # the norm to the rationals
        return Bound(degree, height)

    def _evaluated(self, outputs: Sequence[Expr]) -> list[Degree]:
        self.look(reachable(outputs, self._known))
        return [self._known[node] for node in outputs]

    def look(self, order: Sequence[Expr]) -> None:
        """Find the bounds of nodes, each behind its arguments."""
        algebra, known, below = self._algebra, self._known, self._below
        apply = arithmetic(algebra)
        for node in order:
            if node in known:
                continue
            op, args = node.op, [known[arg] for arg in node.args]
            under = 0
            for arg in node.args:
                under |= below[arg]
            if op in apply:
                known[node] = apply[op](*args)
            elif op is Op.SYMBOL:
                known[node] = Degree(1)
            elif op is Op.CONSTANT:
                known[node] = algebra.constant(node.value)  # type: ignore[arg-type]
            elif op is Op.PI:
                known[node] = algebra.pi()
            else:
                algebra.hashed = []
                known[node] = algebra.function(node, args)
                if algebra.hashed:
                    under |= 1 << len(self._hashed)
                    self._hashed.append(algebra.hashed)
            below[node] = under

    def _hashed_below(self, outputs: Sequence[Expr]) -> list[int]:
        under = 0
        for node in outputs:
            under |= self._below[node]
        return [degree for k, degrees in enumerate(self._hashed) if under >> k & 1 for degree in degrees]
