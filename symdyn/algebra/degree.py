"""Degrees: how many zeros a difference of two graphs can have, so how sure a random point makes us.

Every node is read as N / Π g_k^e_k, where N is a Laurent polynomial in the symbols and in the units of the angles, and
g_k are the numerators of the divisors met so far. Keeping the divisors apart, instead of multiplying denominators out
at every sum, is what keeps the bound finite in practice: a division by g cancels an earlier multiplication by g.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from symdyn.algebra.finite_field import Needs
from symdyn.graph import Expr, Op, evaluate, linear_form, reachable


@dataclass(frozen=True)
class Degree:
    """Bound of one node: degree of its numerator, exponents of the divisors below (negative: above)."""

    numerator: int
    below: dict[int, int] = field(default_factory=dict)


class Degrees:
    """The algebra of degree bounds."""

    def __init__(self, wanted: Needs) -> None:
        """Start without divisors; `wanted` tells how finely angles are divided."""
        self.needs = wanted
        self.divisors: list[int] = []  # degree of g_k

    def constant(self, value: Fraction) -> Degree:
        """Return degree 0."""
        return Degree(0)

    def pi(self) -> Degree:
        """Return degree 1: π is an independent value."""
        return Degree(1)

    def add(self, a: Degree, b: Degree) -> Degree:
        """Return the bound of a sum over the common denominator."""
        keys = {**a.below, **b.below}
        below = {k: max(a.below.get(k, 0), b.below.get(k, 0)) for k in keys}
        return Degree(max(self._lifted(a, below), self._lifted(b, below)), below)

    sub = add

    def mul(self, a: Degree, b: Degree) -> Degree:
        """Return the bound of a product."""
        keys = {**a.below, **b.below}
        below = {k: e for k in keys if (e := a.below.get(k, 0) + b.below.get(k, 0))}
        return Degree(a.numerator + b.numerator, below)

    def div(self, a: Degree, b: Degree) -> Degree:
        """Return the bound of a quotient; the numerator of b becomes a divisor of its own."""
        self.divisors.append(b.numerator)
        inverse = {k: -e for k, e in b.below.items()}
        inverse[len(self.divisors) - 1] = 1
        return self.mul(a, Degree(0, inverse))

    def neg(self, a: Degree) -> Degree:
        """Return the same bound."""
        return a

    def function(self, node: Expr, args: Sequence[Degree]) -> Degree:
        """Return the degree in units of a sine, and 1 for an uninterpreted function: an independent value."""
        if node.op in (Op.SIN, Op.COS):
            form = linear_form(node.args[0])
            degree = abs(form.constant) * self.needs.radian
            degree += sum(abs(coefficient) for _, coefficient in form.terms) * self.needs.atom
            return Degree(int(degree))
        return Degree(0 if node.op is Op.SQRT and node.args[0].op is Op.CONSTANT else 1)

    def total(self, a: Degree) -> int:
        """Return a bound of the zeros of a: twice the Laurent degree of everything multiplied out."""
        return 2 * self._lifted(a, {}) + 2 * sum(abs(e) * self.divisors[k] for k, e in a.below.items())

    def _lifted(self, a: Degree, below: dict[int, int]) -> int:
        """Return the numerator's degree when the denominator is raised to `below`."""
        spare = ((e - a.below.get(k, 0)) * self.divisors[k] for k, e in below.items())
        return a.numerator + sum(spare)


def degree_bound(left: Sequence[Expr], right: Sequence[Expr], wanted: Needs) -> int:
    """Return a bound on the degree of every difference left[i] - right[i], as a Laurent polynomial over one divisor."""
    bound = 0
    algebra = Degrees(wanted)
    sides = []
    for outputs in (left, right):
        symbols = {node: Degree(1) for node in reachable(outputs) if node.op is Op.SYMBOL}
        sides.append(evaluate(outputs, algebra, symbols))
    for a, b in zip(*sides, strict=True):
        bound = max(bound, algebra.total(algebra.sub(a, b)))
    return bound
