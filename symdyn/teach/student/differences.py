"""Where two formulas differ, term by term, in the ring of trigonometric polynomials.

Both are multiplied out and sorted by what stands beside the sines and cosines (parameters, rates, bare coordinates):

    Σ monomial · polynomial in sines and cosines          a: as found, b: as it should be

The ring decides exactly which polynomials are equal. What is left is told in the order of the fewest words:

    moved     b's polynomial stands with a monomial that is off by one symbol:  m1 h2 g sin q1 for m2 h2 g sin q1
    sign      a = -b          factor    a = r b, r a number
    rounded   every number of a is b's, rounded to the decimals of a: 1.33 for 4/3, two digits or more
    other     both are there, with other sines and cosines
    missing   only b          extra     only a
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import comb
from typing import Any

from symdyn.algebra import (
    AngleGroup,
    Compactor,
    Form,
    Function,
    Number,
    Polynomial,
    Power,
    Product,
    Sum,
    TrigonometricRing,
    refused,
)
from symdyn.dynamics import angle_groups
from symdyn.dynamics.mechanism import State
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op, evaluate, reachable, substitute
from symdyn.scene import Scene

KINDS = ("moved", "power", "sign", "factor", "rounded", "function", "angle", "other", "missing", "extra")

PLACES = 20
"""Decimals that a student may write."""

MOST_TERMS, HIGHEST = 20_000, 64
"""Terms, and the degree, of what is multiplied out."""

MOST_PARTS = 160
"""Terms of a formula that is taken apart."""

Monomial = tuple[tuple[int, int], ...]  # ((generator, power), …) without sines and cosines
Buckets = dict[Monomial, Polynomial]


@dataclass(frozen=True)
class Difference:
    """One difference."""

    kind: str  # one of `KINDS`; "moved" is a wrong symbol, "power" a wrong exponent, "function" sine for cosine
    found: Form | None = None  # what stands there, None if nothing
    right: Form | None = None  # what should, None if nothing
    symbols: tuple[str, ...] = ()  # found and right symbol of "moved" ("" for none), the symbol of "power"
    factor: Fraction = Fraction(1)  # found = factor · right, for "factor"


def differences(form: Form, right: Form, scene: Scene) -> list[Difference]:
    """Return how `form` differs from `right`; none if they are equal in the ring.

    Raises:
        DerivationError: one of them is no trigonometric polynomial, such as 1/cos q, or too large to be multiplied out.
    """
    if any(terms > MOST_TERMS or degree > HIGHEST for terms, degree in map(_expanded, (form, right))):
        raise DerivationError(f"{scene.name}: the formula has too many terms to be compared one by one")
    return _Comparison(form, right, scene).run()


class Splitter:
    """Takes formulas of a graph apart, by one ring or others; what is no trigonometric polynomial is one symbol."""

    def __init__(self, nodes: Sequence[Expr], scene: Scene, state: State) -> None:
        self.state, self.groups = state, angle_groups(scene, nodes[0].graph)
        self.closed: dict[Expr, Expr] = {}
        self.meant: dict[str, Form] = {}
        self.over, self.known = self._over(list(map(self._closed, nodes)))

    def __call__(self, node: Expr) -> list[Form]:
        """Return the terms of a formula that is multiplied out: one for each product of what is no sine or cosine.

        Raises:
            DerivationError: it is too large to be multiplied out.
        """
        over, known, node = self.over, self.known, self._closed(node)
        try:
            (value,) = evaluate([node], over.ring, known, known=known)
        except KeyError:  # it has a symbol or a function that the others have not
            over, known = self._over([node])
            (value,) = evaluate([node], over.ring, known)
        found = over.split(value)
        if len(found) > MOST_PARTS:
            raise DerivationError(f"the formula has {len(found)} terms, too many to be told apart")
        return [over.form([item]).substitute(self.meant) for item in found.items()]

    def _closed(self, node: Expr) -> Expr:
        """Return a node with a symbol for each function, root or denominator of the motion, inner ones first."""
        variables = (*self.state.q, *self.state.qd, *self.state.qdd)
        while True:
            node = substitute([node], self.closed)[0]
            one = next((x for x, _ in refused(reachable([node]), variables)), None)
            if one is None:
                return node
            symbol = node.graph.symbol(f"function {len(self.meant)}")
            above, of = (one.args[0], one.args[1]) if one.op is Op.DIV else (None, one)
            self.meant[str(symbol.value)] = Form.of(of).substitute(self.meant)
            self.closed[one] = above / symbol if above is not None else symbol

    def _over(self, nodes: Sequence[Expr]) -> tuple[_Buckets, dict[Expr, Polynomial]]:
        found = _Buckets(nodes, self.state, self.groups)
        return found, found.ring.values(nodes)


def _expanded(form: Form, known: dict[int, tuple[int, int]] | None = None) -> tuple[int, int]:
    """Return upper bounds for the number of terms, and for the degree, of a form that is multiplied out.

    Parts that a form has in several places are looked at once: `known` holds what is found of each, by its id.
    """
    known = {} if known is None else known
    if id(form) not in known:
        known[id(form)] = _bounds(form, known)
    return known[id(form)]


def _bounds(form: Form, known: dict[int, tuple[int, int]]) -> tuple[int, int]:
    if isinstance(form, Sum):
        found = [_expanded(term, known) for term in form.terms]
        return sum(n for n, _ in found), max((d for _, d in found), default=0)
    if isinstance(form, Product):
        terms, degree = 1, 0
        for n, d in (_expanded(factor, known) for factor in form.factors):
            terms, degree = min(terms * n, MOST_TERMS + 1), degree + d
        return terms, degree
    if isinstance(form, Power):
        (terms, degree), exponent = _expanded(form.base, known), abs(form.exponent)
        return min(comb(terms + exponent - 1, exponent), MOST_TERMS + 1), degree * exponent
    if isinstance(form, Function):  # the cosine of a sum is a sum of products
        inner = max((_expanded(x, known)[0] for x in form.args), default=1)
        return 2 ** min(inner - 1, 20), inner
    return 1, 0 if isinstance(form, Number) else 1


class _Buckets:
    """A ring of some formulas, whose polynomials are sorted by what is no sine or cosine."""

    def __init__(self, nodes: Sequence[Expr], state: State, groups: Sequence[AngleGroup]) -> None:
        self.ring = TrigonometricRing(nodes, (*state.q, *state.qd, *state.qdd), groups)
        self.compact = Compactor(self.ring, groups)

    def split(self, p: Polynomial) -> Buckets:
        """Return a polynomial by its products of what is no sine or cosine."""
        split: dict[Monomial, dict[tuple[int, ...], Any]] = {}
        circular = [g.kind in ("sin", "cos") for g in self.ring.generators]
        for powers, coefficient in zip(p.monoms(), p.coeffs(), strict=True):
            outer = tuple((i, int(e)) for i, e in enumerate(powers) if e and not circular[i])
            inner = tuple(int(e) if circular[i] else 0 for i, e in enumerate(powers))
            split.setdefault(outer, {})[inner] = coefficient
        return {outer: self.ring.context.from_dict(inner) for outer, inner in split.items()}

    def times(self, monomial: Monomial, p: Polynomial) -> Polynomial:
        """Return a polynomial times a product."""
        powers = dict(monomial)
        unit = tuple(powers.get(i, 0) for i in range(len(self.ring.generators)))
        return self.ring.context.from_dict({unit: 1}) * p

    def form(self, terms: Iterable[tuple[Monomial, Polynomial]], factor: Fraction | int = 1) -> Form:
        """Return a sum of terms times a number, as it is written."""
        total = sum((self.times(monomial, p) for monomial, p in terms), self.ring.zero)
        return self.compact(total * self.ring.constant(Fraction(factor)))


class _Comparison(_Buckets):
    def __init__(self, result: Form, right: Form, scene: Scene) -> None:
        graph = Graph()
        for parameter in scene.parameters:
            graph.symbol(parameter.name)  # first, so that forms print them in declared order
        nodes = [form.express(graph) for form in (right, result)]
        super().__init__(nodes, State.of(scene, graph), angle_groups(scene, graph))
        b, a = evaluate(nodes, self.ring, self.ring.values(nodes))
        self.a, self.b = self.split(a), self.split(b)
        self.done: set[Monomial] = set()

    def run(self) -> list[Difference]:
        result = self._moved()
        signs: list[tuple[Monomial, Polynomial]] = []
        factors: dict[Fraction, list[tuple[Monomial, Polynomial]]] = {}
        rounded: list[Monomial] = []
        others: list[Difference] = []
        missing: list[tuple[Monomial, Polynomial]] = []
        extra: list[tuple[Monomial, Polynomial]] = []
        for monomial in self._open():
            a, b = self.a.get(monomial), self.b.get(monomial)
            if a is None and b is not None:
                missing.append((monomial, b))
            elif b is None and a is not None:
                extra.append((monomial, a))
            elif a is not None and b is not None:
                ratio = _ratio(a, b)
                if ratio != 1 and self._is_rounded(a, b):
                    rounded.append(monomial)
                elif ratio == -1:
                    signs.append((monomial, b))
                elif ratio is not None:
                    factors.setdefault(ratio, []).append((monomial, b))
                else:
                    others += self._other(monomial, a, b)
        if signs:
            result.append(Difference("sign", self.form(signs, -1), self.form(signs)))
        if rounded:
            found, right = (self.form((m, x[m]) for m in rounded) for x in (self.a, self.b))
            result.append(Difference("rounded", found, right))
        for ratio, terms in factors.items():
            result.append(Difference("factor", self.form(terms, ratio), self.form(terms), factor=ratio))
        result += others
        result += [Difference("missing", right=term) for term in self._terms(missing)]
        result += [Difference("extra", term) for term in self._terms(extra)]
        return result

    def _is_rounded(self, a: Polynomial, b: Polynomial) -> bool:
        found, right = self.ring.terms(a), self.ring.terms(b)
        if [powers for powers, _ in found] != [powers for powers, _ in right]:
            return False
        return all(abs(x - y) <= half_unit(x) for (_, x), (_, y) in zip(found, right, strict=True))

    # Monomials

    def _open(self) -> list[Monomial]:
        """Return the monomials at which a and b still differ, those of b first."""
        every = dict.fromkeys((*self.b, *self.a))
        return [m for m in every if m not in self.done and self.a.get(m) != self.b.get(m)]

    def _terms(self, terms: Sequence[tuple[Monomial, Polynomial]]) -> list[Form]:
        return list(self.form(terms).terms) if terms else []

    # One symbol off

    def _moved(self) -> list[Difference]:
        """Return the terms that stand with a wrong symbol or a wrong power: b alone here, a too much there."""
        moved: dict[tuple[str, tuple[str, ...]], list[tuple[Monomial, Monomial, Polynomial, int]]] = {}
        for here in [m for m in self._open() if m not in self.a]:
            for there in [m for m in self._open() if m in self.a]:
                change = self._change(there, here)
                if change is None:
                    continue
                surplus = self.a[there] - self.b.get(there, self.ring.zero)
                sign = 1 if surplus == self.b[here] else -1 if -surplus == self.b[here] and there not in self.b else 0
                if sign:
                    moved.setdefault(change, []).append((there, here, self.b[here], sign))
                    self.done |= {here, there}
                    break
        result = []
        for (kind, symbols), terms in moved.items():
            found = sum((self.times(there, p) * sign for there, _, p, sign in terms), self.ring.zero)
            right = [(here, p) for _, here, p, _ in terms]
            result.append(Difference(kind, self.compact(found), self.form(right), symbols))
        return result

    def _change(self, there: Monomial, here: Monomial) -> tuple[str, tuple[str, ...]] | None:
        """Return what turns one monomial into another by one symbol."""
        a, b = dict(there), dict(here)
        off = {i: a.get(i, 0) - b.get(i, 0) for i in sorted({*a, *b}) if a.get(i, 0) != b.get(i, 0)}
        names = {i: str(node.value) for i in off if (node := self.ring.generators[i].node) and node.op is Op.SYMBOL}
        if len(names) != len(off):
            return None
        if len(off) == 1:
            return "power", tuple(names.values())
        if len(off) == 2 and sum(off.values()) == 0:
            more, less = (i for i, _ in sorted(off.items(), key=lambda item: -item[1]))
            return "moved", (names[more], names[less])
        return None

    # Other sines and cosines

    def _other(self, monomial: Monomial, a: Polynomial, b: Polynomial) -> list[Difference]:
        mine, right = self._terms([(monomial, a)]), self._terms([(monomial, b)])
        mine, right = [x for x in mine if x not in right], [x for x in right if x not in mine]
        lacking = self.form([(monomial, b - a)])
        if not mine or (len(lacking.terms) < len(right) and len(mine) > len(right)):
            return [Difference("missing", right=term) for term in lacking.terms]
        if not right:
            return [Difference("extra", term) for term in mine]
        if len(mine) == len(right) == 1:
            x, y = _functions(mine[0]), _functions(right[0])
            if len(x) == len(y) == 1:
                kind = "function" if x[0].args == y[0].args else "angle" if x[0].op is y[0].op else "other"
                return [Difference(kind, mine[0], right[0])]
            return [Difference("other", mine[0], right[0])]
        return [Difference("other", self.form([(monomial, a)]), self.form([(monomial, b)]))]


def _ratio(a: Polynomial, b: Polynomial) -> Fraction | None:
    """Return r with a = r b, if it is a number."""
    x, y = a.leading_coefficient(), b.leading_coefficient()
    r = x / y
    return Fraction(int(r.p), int(r.q)) if a == b * r else None


def half_unit(value: Fraction) -> Fraction:
    """Return half a unit of the last digit of a decimal of two digits or more, 0 for what is exact.

    The zeros at the end of a large number, three digits or more before them, are places that were not written.
    """
    places = next((k for k in range(PLACES) if (value * 10**k).denominator == 1), PLACES)
    if places == PLACES or not value:
        return Fraction(0)
    while places <= 0 and (value * Fraction(10) ** (places - 1)).denominator == 1:
        places -= 1
    unit = Fraction(1, 10) ** places
    return unit / 2 if places and abs(value) >= (10 if places > 0 else 100) * unit else Fraction(0)


def _functions(form: Form) -> list[Function]:
    """Return the sines and cosines of a term."""
    bases = [factor.base if isinstance(factor, Power) else factor for factor in form.factors]
    return [x for x in bases if isinstance(x, Function) and x.op in (Op.SIN, Op.COS)]
