"""Squares of sums that Horner's scheme has taken apart: (a + 2 b) a + b² is (a + b)², as an angular velocity's is read.

(a + 2 b + 2 c) a + (b + 2 c) b + c² is (a + b + c)², from the inside out; a common factor of the terms stays in front.
"""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from functools import lru_cache

from symdyn.algebra.form import (
    Form,
    Function,
    Number,
    Power,
    Product,
    Sum,
    factors_of,
    power_of,
    product_of,
    sum_of,
    terms_of,
)

TWO = Number(Fraction(2))
KEPT = 10_000  # forms whose answer is remembered: the formulas of one page share most of their parts


@lru_cache(KEPT)
def with_squares(form: Form) -> Form:
    """Return the same formula with such sums written as squares."""
    if isinstance(form, Sum):
        return _folded([with_squares(term) for term in form.terms])
    if isinstance(form, Product):
        return product_of(with_squares(factor) for factor in form.factors)
    if isinstance(form, Power):
        return power_of(with_squares(form.base), form.exponent)
    if isinstance(form, Function):
        return Function(form.op, tuple(with_squares(one) for one in form.args))
    return form


def _folded(terms: list[Form]) -> Form:
    """Return the sum of terms, two of which make a square as often as there are such two."""
    for i, first in enumerate(terms):
        for j, second in enumerate(terms):
            square = _square(first, second) if i != j else None
            if square is not None:
                rest = [term for k, term in enumerate(terms) if k not in (i, j)]
                rest.insert(min(i, len(rest)), square)
                return _folded(rest)
    return sum_of(terms)


def _square(first: Form, second: Form) -> Form | None:
    """Return r (a + b)² for r (a + 2 b) a and r b², else None."""
    factors = factors_of(first)
    for k, mixed in enumerate(factors):
        if not isinstance(mixed, Sum):
            continue
        for m, a in enumerate(factors):
            others = [term for term in mixed.terms if term != a]
            if m == k or len(others) != len(mixed.terms) - 1:
                continue
            halves = [_half(term) for term in others]
            b = sum_of(half for half in halves if half is not None)
            common = [factor for n, factor in enumerate(factors) if n not in (k, m)]
            if None not in halves and _is_square(factors_of(second), common, b):
                return product_of([*common, power_of(sum_of([a, *terms_of(b)]), 2)])
    return None


def _half(term: Form) -> Form | None:
    """Return b for 2 b."""
    factors = factors_of(term)
    return product_of(factors[1:]) if len(factors) > 1 and factors[0] == TWO else None


def _is_square(factors: tuple[Form, ...], common: list[Form], b: Form) -> bool:
    """Tell whether factors are those common and b²."""
    left = Counter(factors) - Counter(common)
    if len(factors) != len(common) + 1 or sum(left.values()) != 1:
        return False
    (one,) = left
    return isinstance(one, Power) and one.exponent == 2 and set(terms_of(one.base)) == set(terms_of(b))
