"""Quotients of formulas as one writes them by hand: what divides stands alone, what both sides share is left out."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra import Form, Number, Power


def quotient(above: Form, below: Form) -> Form:
    """Return above / below: terms that divide stand alone, and factors that both have are left out."""
    above, below = _laid_open(above), _factored(below)
    whole: list[tuple[Form, Form]] = []
    rest: list[tuple[Form, Form]] = []
    for term in above.terms:
        divided = _divided(term, below)
        (whole if divided[1] == Number.ONE else rest).append((term, divided[0]))
    if not whole:
        top, bottom = _divided(above, below)
        return top if bottom == Number.ONE else Form.product((top, Power(bottom, -1)))
    left = quotient(Form.sum(term for term, _ in rest), below) if rest else Number.ZERO
    return Form.sum([*(one for _, one in whole), left])


def _laid_open(form: Form) -> Form:
    """Return a product with one sum among its factors as a sum."""
    factors = form.factors
    sums = [k for k, one in enumerate(factors) if len(one.terms) > 1]
    if len(sums) != 1:
        return form
    others = [one for k, one in enumerate(factors) if k != sums[0]]
    return Form.sum(Form.product([*others, term]) for term in factors[sums[0]].terms)


def _factored(form: Form) -> Form:
    """Return a sum with the factors that all of its terms have in front."""
    terms = [list(term.factors) for term in form.terms]
    common: list[Form] = []
    for factor in terms[0] if len(terms) > 1 else []:
        base = factor.base if isinstance(factor, Power) else factor
        if not isinstance(base, Number) and all(has(base, one) for one in terms):
            terms = [less(base, one) for one in terms]
            common.append(base)
    return Form.product([*common, Form.sum(map(Form.product, terms))])


def _divided(above: Form, below: Form) -> tuple[Form, Form]:
    """Return numerator and denominator without the factors that both have; for a sum, those of all its terms."""
    terms = [list(term.factors) for term in above.terms]
    bottom: list[Form] = []
    for factor in below.factors:
        base, times = (factor.base, factor.exponent) if isinstance(factor, Power) else (factor, 1)
        for _ in range(times):
            if isinstance(base, Number):
                terms = [[Number(1 / base.value), *factors] for factors in terms]
            elif all(has(base, factors) for factors in terms):
                terms = [less(base, factors) for factors in terms]
            else:
                bottom.append(base)
    return Form.sum(map(Form.product, terms)), Form.product(bottom)


def has(base: Form, factors: Sequence[Form]) -> bool:
    """Whether a base, or a power of it, is among factors."""
    return any(one == base or (isinstance(one, Power) and one.base == base and one.exponent > 0) for one in factors)


def less(base: Form, factors: Sequence[Form]) -> list[Form]:
    """Return factors with one `base` less."""
    left = list(factors)
    place = next(k for k, one in enumerate(left) if has(base, [one]))
    found = left[place]
    left[place] = base.power(found.exponent - 1) if isinstance(found, Power) and found != base else Number.ONE
    return left
