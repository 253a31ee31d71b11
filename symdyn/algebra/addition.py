"""Addition theorems, backwards: cos a cos b + sin a sin b is cos(a - b), where two terms of a sum are alike but for it.

Loops meet in angles of two branches, whose sums no generator of the ring stands for.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from symdyn.algebra.form import (
    MINUS_ONE,
    Form,
    Function,
    Power,
    Product,
    Sum,
    factors_of,
    power_of,
    product_of,
    split_sign,
    sum_of,
    terms_of,
)
from symdyn.graph import Op

OTHER = {Op.SIN: Op.COS, Op.COS: Op.SIN}


def with_added_angles(form: Form) -> Form:
    """Return the same formula with such pairs of terms written as one."""
    if isinstance(form, Sum):
        return _joined([with_added_angles(term) for term in form.terms])
    if isinstance(form, Product):
        return product_of(with_added_angles(factor) for factor in form.factors)
    if isinstance(form, Power):
        return power_of(with_added_angles(form.base), form.exponent)
    return form


def _joined(terms: list[Form]) -> Form:
    for i, first in enumerate(terms):
        for j in range(i + 1, len(terms)):
            one = _one(first, terms[j])
            if one is not None:
                return _joined([*terms[:i], one, *terms[i + 1 : j], *terms[j + 1 :]])
    return sum_of(terms)


def _one(first: Form, second: Form) -> Form | None:
    """Return two terms as one, None if they are no two sides of an addition theorem."""
    (sign, left), (other, right) = split_sign(first), split_sign(second)
    a, b = Counter(factors_of(left)), Counter(factors_of(right))
    mine, yours = list((a - b).elements()), list((b - a).elements())
    if not (len(mine) == len(yours) == len(_circular(mine)) == len(_circular(yours)) == 2):
        return None
    (f, p), (g, q) = _circular(mine)
    if set(_circular(yours)) != {(OTHER[f], p), (OTHER[g], q)} or p == q:
        return None
    same = sign == other
    if f is not g:  # sin p cos q ± cos p sin q, or the other way round
        p, q = (p, q) if f is Op.SIN else (q, p)
        joined = Function(Op.SIN, (_sum(p, q, plus=same),))
    else:  # cos p cos q ± sin p sin q, or the other way round
        sign = sign if f is Op.COS else other
        joined = Function(Op.COS, (_sum(p, q, plus=not same),))
    factor = [MINUS_ONE] if sign < 0 else []
    return product_of([*factor, *(a & b).elements(), joined])


def _sum(p: Form, q: Form, plus: bool) -> Form:
    return sum_of([*terms_of(p), *(one if plus else product_of((MINUS_ONE, one)) for one in terms_of(q))])


def _circular(forms: Iterable[Form]) -> list[tuple[Op, Form]]:
    """Return function and angle of the sines and cosines among forms."""
    return [(one.op, one.args[0]) for one in forms if isinstance(one, Function) and one.op in OTHER]
