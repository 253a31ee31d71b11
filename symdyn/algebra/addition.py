"""Addition theorems, backwards: cos a cos b + sin a sin b is cos(a - b), where two terms of a sum are alike but for it.

Loops meet in angles of two branches, whose sums no generator of the ring stands for.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

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
KEPT = 10_000  # forms whose answer is remembered: the formulas of one page share most of their parts


@lru_cache(KEPT)
def with_added_angles(form: Form) -> Form:
    """Return the same formula with such pairs of terms written as one."""
    if isinstance(form, Sum):
        return _joined([with_added_angles(term) for term in form.terms])
    if isinstance(form, Product):
        return product_of(with_added_angles(factor) for factor in form.factors)
    if isinstance(form, Power):
        return power_of(with_added_angles(form.base), form.exponent)
    return form


@dataclass(frozen=True)
class _Term:
    """A term of a sum: its sign, its factors, and all that two terms have in common that can be one."""

    form: Form
    sign: int
    factors: Counter[Form]
    kind: tuple[int, frozenset[tuple[Form, int]]]


def _term(form: Form) -> _Term:
    sign, rest = split_sign(form)
    factors = Counter(factors_of(rest))
    others = frozenset((one, n) for one, n in factors.items() if not _circular([one]))
    return _Term(form, sign, factors, (factors.total(), others))


def _joined(terms: list[Form]) -> Form:
    left = [_term(one) for one in terms]
    while True:
        kinds: dict[tuple[int, frozenset[tuple[Form, int]]], int] = {}
        numbers = [kinds.setdefault(one.kind, len(kinds)) for one in left]  # compared at once, whatever is in them
        pairs = ((i, j) for i, one in enumerate(numbers) for j in range(i + 1, len(left)) if numbers[j] == one)
        found = next(((i, j, one) for i, j in pairs if (one := _one(left[i], left[j])) is not None), None)
        if found is None:
            return sum_of(one.form for one in left)
        i, j, one = found
        left = [*left[:i], _term(one), *left[i + 1 : j], *left[j + 1 :]]


def _one(first: _Term, second: _Term) -> Form | None:
    """Return two terms as one, None if they are no two sides of an addition theorem."""
    sign, other, a, b = first.sign, second.sign, first.factors, second.factors
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
