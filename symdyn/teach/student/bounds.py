"""What is too large for a formula that a person wrote: checked before anything is multiplied out."""

from __future__ import annotations

from fractions import Fraction
from math import comb

from symdyn.algebra.form import Form, Function, Number, Power, Product, Sum

LARGEST = 10**60  # a number, or one over it
MOST_TERMS = 20_000
HIGHEST = 64  # degree


def too_large(number: Number) -> bool:
    """Whether a number is larger than anything that is measured, or smaller."""
    size = abs(number.value)
    return size > LARGEST or 0 < size < Fraction(1, LARGEST)


def is_small(form: Form) -> bool:
    """Whether a form stays readable when it is multiplied out."""
    terms, degree = _expanded(form)
    return terms <= MOST_TERMS and degree <= HIGHEST


def _expanded(form: Form) -> tuple[int, int]:
    """Return upper bounds for the number of terms, and for the degree, of a form that is multiplied out."""
    if isinstance(form, Sum):
        found = [_expanded(term) for term in form.terms]
        return sum(n for n, _ in found), max((d for _, d in found), default=0)
    if isinstance(form, Product):
        terms, degree = 1, 0
        for n, d in map(_expanded, form.factors):
            terms, degree = min(terms * n, MOST_TERMS + 1), degree + d
        return terms, degree
    if isinstance(form, Power):
        (terms, degree), exponent = _expanded(form.base), abs(form.exponent)
        return min(comb(terms + exponent - 1, exponent), MOST_TERMS + 1), degree * exponent
    if isinstance(form, Function):  # the cosine of a sum is a sum of products
        inner = max((_expanded(x)[0] for x in form.args), default=1)
        return 2 ** min(inner - 1, 20), inner
    return 1, 0 if isinstance(form, Number) else 1
