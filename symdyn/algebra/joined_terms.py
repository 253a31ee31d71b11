"""Terms of a sum written as one, as a book does.

cos a cos b + sin a sin b = cos(a - b)      addition theorems, where two terms are alike but for it: loops meet in
angles of two branches, whose sums no generator of the ring stands for
(a + 2 b) a + b² = (a + b)²                 as an angular velocity's is read, which Horner's scheme has taken apart;
(a + 2 b + 2 c) a + (b + 2 c) b + c² from the inside out
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from symdyn.algebra.form import Form, Function, Number, Power, Sum
from symdyn.graph import Op

OTHER = {Op.SIN: Op.COS, Op.COS: Op.SIN}
TWO = Number(Fraction(2))
KEPT = 10_000  # forms whose answer is remembered: the formulas of one page share most of their parts


@lru_cache(KEPT)
def with_added_angles(form: Form) -> Form:
    """Return the same formula with pairs of terms that an addition theorem joins written as one."""
    if isinstance(form, Function):
        return form
    parts = [with_added_angles(part) for part in form.parts]
    return _joined(parts) if isinstance(form, Sum) else form.with_parts(parts)


@dataclass(frozen=True)
class _Term:
    """A term of a sum: its sign, its factors, and all that two terms have in common that can be one."""

    form: Form
    sign: int
    factors: Counter[Form]
    kind: tuple[int, frozenset[tuple[Form, int]]]


def _term(form: Form) -> _Term:
    sign, rest = form.split_sign()
    factors = Counter(rest.factors)
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
            return Form.sum(one.form for one in left)
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
    factor = [Number.MINUS_ONE] if sign < 0 else []
    return Form.product([*factor, *(a & b).elements(), joined])


def _sum(p: Form, q: Form, plus: bool) -> Form:
    return Form.sum([*p.terms, *(one if plus else Form.product((Number.MINUS_ONE, one)) for one in q.terms)])


def _circular(forms: Iterable[Form]) -> list[tuple[Op, Form]]:
    """Return function and angle of the sines and cosines among forms."""
    return [(one.op, one.args[0]) for one in forms if isinstance(one, Function) and one.op in OTHER]


@lru_cache(KEPT)
def with_squares(form: Form) -> Form:
    """Return the same formula with squares that stand in it term by term written as such; common factors in front."""
    parts = [with_squares(part) for part in form.parts]
    return _folded(parts) if isinstance(form, Sum) else form.with_parts(parts)


def _folded(terms: list[Form]) -> Form:
    """Return the sum of terms, two of which make a square as often as there are such two."""
    for i, first in enumerate(terms):
        for j, second in enumerate(terms):
            square = _square(first, second) if i != j else None
            if square is not None:
                rest = [term for k, term in enumerate(terms) if k not in (i, j)]
                rest.insert(min(i, len(rest)), square)
                return _folded(rest)
    return Form.sum(terms)


def _square(first: Form, second: Form) -> Form | None:
    """Return r (a + b)² for r (a + 2 b) a and r b², else None."""
    factors = first.factors
    for k, mixed in enumerate(factors):
        if not isinstance(mixed, Sum):
            continue
        for m, a in enumerate(factors):
            others = [term for term in mixed.terms if term != a]
            if m == k or len(others) != len(mixed.terms) - 1:
                continue
            halves = [_half(term) for term in others]
            b = Form.sum(half for half in halves if half is not None)
            common = [factor for n, factor in enumerate(factors) if n not in (k, m)]
            if None not in halves and _is_square(second.factors, common, b):
                return Form.product([*common, Form.sum([a, *b.terms]).power(2)])
    return None


def _half(term: Form) -> Form | None:
    """Return b for 2 b."""
    factors = term.factors
    return Form.product(factors[1:]) if len(factors) > 1 and factors[0] == TWO else None


def _is_square(factors: tuple[Form, ...], common: list[Form], b: Form) -> bool:
    """Tell whether factors are those common and b²."""
    left = Counter(factors) - Counter(common)
    if len(factors) != len(common) + 1 or sum(left.values()) != 1:
        return False
    (one,) = left
    return isinstance(one, Power) and one.exponent == 2 and set(one.base.terms) == set(b.terms)
