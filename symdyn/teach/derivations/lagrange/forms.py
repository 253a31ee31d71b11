"""Calculus on forms as a student does it on paper: the chain rule term by term, brackets multiplied out.

The graph has its own derivatives; tests hold these against them by value.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Power, Product, Sum, Symbol
from symdyn.graph import Op

Monomial = tuple[tuple[Form, int], ...]  # (atom, exponent), in order of appearance


def rate_of(form: Form, rates: Mapping[str, Form]) -> Form:
    """Return d/dt of a polynomial in sines by the product and chain rules; symbols without a rate are constant.

    sin(q1 + q2) gives cos(q1 + q2) (q̇1 + q̇2), the angle's rate last.
    """
    if isinstance(form, Symbol):
        return rates.get(form.name, Number.ZERO)
    if isinstance(form, Sum):
        return Form.sum(rate_of(term, rates) for term in form.terms)
    if isinstance(form, Power):
        inner = rate_of(form.base, rates)
        if inner == Number.ZERO:
            return Number.ZERO
        outer = Form.product((Number(Fraction(form.exponent)), form.base.power(form.exponent - 1)))
        return _spread(outer, inner)
    if isinstance(form, Product):
        terms = []
        for k, factor in enumerate(form.factors):
            inner = rate_of(factor, rates)
            if inner != Number.ZERO:
                others = Form.product((*form.factors[:k], *form.factors[k + 1 :]))
                terms.append(_spread(others, inner))
        return Form.sum(terms)
    if isinstance(form, Function) and form.op in (Op.SIN, Op.COS):
        inner = rate_of(form.args[0], rates)
        if inner == Number.ZERO:
            return Number.ZERO
        sign, op = (Number.ONE, Op.COS) if form.op is Op.SIN else (Number.MINUS_ONE, Op.SIN)
        return Form.product((sign, Function(op, form.args), inner))
    return Number.ZERO


def _spread(outer: Form, inner: Form) -> Form:
    """Return outer · inner, term by term where inner has sines to differentiate by more than one coordinate."""
    if isinstance(inner, Sum) and not all(isinstance(term, Symbol) for term in inner.terms):
        return Form.sum(Form.product((outer, term)) for term in inner.terms)
    return Form.product((outer, inner))


def has_sine(form: Form) -> bool:
    """Tell whether a sine or cosine stands in a form."""
    return any(isinstance(one, Function) and one.op in (Op.SIN, Op.COS) for one in form.walk())


MOST_PRODUCTS = 20_000
"""Products of two terms up to which squares are multiplied out."""


@dataclass(frozen=True)
class Group:
    """Terms of a square that have everything in common but sines: outer · (Σ sines).

    Attributes:
        outer: number, parameters and rates.
        sines: what remains, one term each; (ONE,) where there are no sines.
    """

    outer: Form
    sines: tuple[Form, ...]

    @property
    def form(self) -> Form:
        """The product."""
        return Form.product((self.outer, Form.sum(self.sines)))


def expanded_squares(forms: Iterable[Form]) -> list[Group] | None:
    """Return Σ form², multiplied out; what differs in sines only stands in one bracket; None where it fills pages."""
    total: dict[Monomial, Fraction] = {}
    every = [list(_expand(form).items()) for form in forms]
    if sum(len(terms) ** 2 for terms in every) > MOST_PRODUCTS:
        return None
    for terms in every:
        for k, (a, x) in enumerate(terms):
            for m, (b, y) in enumerate(terms[k:]):
                key = _times(a, b)
                total[key] = total.get(key, Fraction(0)) + x * y * (2 if m else 1)
    groups: dict[Monomial, list[tuple[Fraction, Monomial]]] = {}
    for monomial, number in total.items():
        if number:
            outer = tuple(item for item in monomial if not has_sine(item[0]))
            groups.setdefault(outer, []).append((number, tuple(item for item in monomial if has_sine(item[0]))))
    result = []
    for outer, members in groups.items():
        shared = members[0][0] if all(abs(a) == abs(members[0][0]) for a, _ in members) else Fraction(1)
        sines = tuple(Form.product((Number(a / shared), _product(m))) for a, m in members)
        result.append(Group(Form.product((Number(shared), _product(outer))), sines))
    return result


def _expand(form: Form) -> dict[Monomial, Fraction]:
    """Return a form as Σ number · monomial; sums without sines are atoms."""
    total: dict[Monomial, Fraction] = {}
    for term in form.terms:
        for monomial, number in _expand_term(term).items():
            total[monomial] = total.get(monomial, Fraction(0)) + number
    return total


def _expand_term(term: Form) -> dict[Monomial, Fraction]:
    product: dict[Monomial, Fraction] = {(): Fraction(1)}
    for factor in term.factors:
        if isinstance(factor, Number):
            parts: dict[Monomial, Fraction] = {(): factor.value}
        elif isinstance(factor, Sum) and has_sine(factor):
            parts = _expand(factor)
        else:
            base, exponent = (factor.base, factor.exponent) if isinstance(factor, Power) else (factor, 1)
            if isinstance(base, Sum) and has_sine(base):
                parts = {(): Fraction(1)}
                for _ in range(exponent):
                    parts = _multiplied(parts, _expand(base))
            else:
                parts = {((base, exponent),): Fraction(1)}
        product = _multiplied(product, parts)
    return product


def _multiplied(a: Mapping[Monomial, Fraction], b: Mapping[Monomial, Fraction]) -> dict[Monomial, Fraction]:
    total: dict[Monomial, Fraction] = {}
    for x, p in a.items():
        for y, q in b.items():
            key = _times(x, y)
            total[key] = total.get(key, Fraction(0)) + p * q
    return total


def _times(a: Monomial, b: Monomial) -> Monomial:
    exponents = dict(a)
    for atom, exponent in b:
        exponents[atom] = exponents.get(atom, 0) + exponent
    return tuple(sorted(((x, e) for x, e in exponents.items() if e), key=_place))


def _place(item: tuple[Form, int]) -> tuple[int, str]:
    """Sort key: parameters, sines, rates and their sums, each by its text."""
    kind = 1 if has_sine(item[0]) else 2 if is_rate(item[0]) else 0
    return kind, repr(item[0])


def is_rate(form: Form) -> bool:
    """Tell whether a form is a velocity, or a power, a product or a sum of such."""
    if isinstance(form, (Sum, Power)):
        return all(map(is_rate, form.parts))
    if isinstance(form, Product):
        return any(map(is_rate, form.factors))
    return isinstance(form, Symbol) and form.name.endswith("_dot")


def _product(monomial: Monomial) -> Form:
    return Form.product(atom.power(exponent) for atom, exponent in monomial)
