"""From normal form to a form worth reading, inside the ring: milliseconds a coefficient.

    1. split into parameter monomials, each with a trigonometric polynomial;
    2. write that polynomial shortest: sines of sums, s² or c² (`sums_of_angles`);
    3. parameters that multiply the same polynomial share it;
    4. collect common factors, the one that saves most first.

Nothing is approximated and nothing is searched by heuristics that could change the value: `Form.express` takes the
result back to a graph, and over the ring it equals the normal form.

Terms of a sum are written as one, as a book does:

    cos a cos b + sin a sin b = cos(a - b)      addition theorems, where two terms are alike but for it: loops meet in
    angles of two branches, whose sums no generator of the ring stands for
    (a + 2 b) a + b² = (a + b)²                 as an angular velocity's is read, which Horner's scheme has taken apart;
    (a + 2 b + 2 c) a + (b + 2 c) b + c² from the inside out
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from math import gcd, lcm

from symdyn.algebra.form import Form, Function, Number, Pi, Power, Sum, Symbol
from symdyn.algebra.sums_of_angles import (
    SMALL,
    Angle,
    AngleGroup,
    Factor,
    Item,
    Monomial,
    Monomials,
    SumFinder,
    content,
    partition,
    take_out,
)
from symdyn.algebra.trigonometric import Polynomial, TrigonometricRing
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, evaluate

Powers = tuple[tuple[int, int], ...]  # ((generator, power), …), ascending
Key = tuple[tuple[Monomial, Fraction], ...]  # a trigonometric polynomial, scaled, terms in reading order

WORK = 40  # products of terms that take as long as writing a term short does
NESTED = Fraction(4, 3)  # of the parts of quotients in quotients: as many more are read as easily where none is nested
LONG = 4  # a factor common to fewer terms stays in them, as in the textbook's (5.40)


class Compactor:
    """Turns elements of one ring into forms; parts that repeat are rewritten once."""

    def __init__(self, ring: TrigonometricRing, groups: Sequence[AngleGroup] = ()) -> None:
        """Prepare the bases; `groups` are angles whose sums are worth a try."""
        self.ring = ring
        cosine = {(g.node, g.unit): i for i, g in enumerate(ring.generators) if g.kind == "cos"}
        first = {node: i for (node, _), i in reversed(cosine.items())}
        self._angle: dict[int, tuple[str, Angle]] = {}
        for i, g in enumerate(ring.generators):
            if g.kind in ("sin", "cos"):
                self._angle[i] = (g.kind[0], ((cosine[g.node, g.unit], 1),))
        self._finders = []
        alone = dict.fromkeys(cosine.values())
        for group in groups:
            if group.is_long:  # the ring's angles are totals: their differences are what a Fourier series finds
                atoms = tuple(first[q] for q in group.atoms[::-1] if q in first)  # u3 - u2 = q3, not -q3
                self._finders.append(SumFinder(atoms, ()))
                alone = {atom: None for atom in alone if atom not in atoms}
                continue
            places = [k for k, q in enumerate(group.atoms) if (q, Fraction(1)) in cosine]
            atoms = tuple(cosine[group.atoms[k], Fraction(1)] for k in places)
            outside = [k for k in range(len(group.atoms)) if k not in places]
            sums = tuple(tuple(s[k] for k in places) for s in group.sums if not any(s[k] for k in outside))
            self._finders.append(SumFinder(atoms, sums))
            for atom in atoms:
                alone.pop(atom)
        for atom in alone:
            node = ring.generators[atom].node
            self._finders.append(SumFinder((atom,), ((1,),), node is not None and node.op is not Op.PI))
        self._divides = any(g.kind == "inverse" for g in ring.generators)
        self._short: dict[tuple[tuple[Powers, int], ...], tuple[Fraction, Key]] = {}
        self._words = Monomials()
        self._known: dict[object, int] = {}  # generator, factor or polynomial -> its word

    @classmethod
    def of(
        cls,
        nodes: Sequence[Expr],
        letters: Sequence[Expr],
        groups: Sequence[AngleGroup] = (),
        units: Sequence[Sequence[Expr]] = (),
    ) -> Callable[[Expr], Form]:
        """Return what writes nodes over a ring of their own; `letters`, `groups` and `units` as the ring takes them.

        Raises:
            DerivationError: a node is no polynomial in sines.
        """
        every = list(dict.fromkeys(nodes))
        ring = TrigonometricRing(every, letters, groups, units)
        values = dict(zip(every, evaluate(every, ring, ring.values(every)), strict=True))
        compact = cls(ring, groups)
        return lambda node: compact(values[node])

    def __call__(self, p: Polynomial) -> Form:
        """Return a short form of p.

        Raises:
            DerivationError: closed forms of this ring have become too long to be of use.
        """
        self.ring.count(WORK * len(p))
        items = self._grouped(self._by_parameters(p))
        number, common, rest = take_out(items)
        form = Form.sum(map(self._words.term, items))
        if len(items) >= LONG and common:
            form = Form.product([Number(number), *self._words.powers(common), Form.sum(map(self._words.term, rest))])
        return self.in_lowest_terms(with_added_angles(form))

    def in_lowest_terms(self, form: Form) -> Form:
        """Return a form whose parts of letters alone are sums of quotients, if those are no longer: of gears that roll.

        Only what is divided by a sum is looked at.
        """
        if isinstance(form, Function):  # whose angle is one of the ring's
            return form
        parts = list(form.walk()) if self._divides else []
        if not any(isinstance(x, Power) and x.exponent < 0 and isinstance(x.base, Sum) for x in parts):
            return form
        if any(isinstance(x, (Function, Pi)) for x in parts):
            return form.with_parts(map(self.in_lowest_terms, form.parts))
        from symdyn.algebra.ratios import Ratios  # imports NumPy

        graph = next(g.node.graph for g in self.ring.generators if g.node is not None)
        other = Ratios.collected(form.express(graph))
        return other if sum(1 for _ in other.walk()) <= NESTED * len(parts) else form

    def _by_parameters(self, p: Polynomial) -> dict[Powers, tuple[Fraction, Key]]:
        """Return the trigonometric polynomial that each monomial of the other generators multiplies, shortened."""
        split: dict[Powers, list[tuple[Powers, Fraction]]] = {}
        for powers, coefficient in self.ring.terms(p):
            outer = tuple(item for item in powers if item[0] not in self._angle)
            inner = tuple(item for item in powers if item[0] in self._angle)
            split.setdefault(outer, []).append((inner, coefficient))
        return {outer: self._shortest(terms) for outer, terms in split.items()}

    def _shortest(self, terms: Sequence[tuple[Powers, Fraction]]) -> tuple[Fraction, Key]:
        """Return a trigonometric polynomial, given by its terms, as (number, short polynomial in reading order)."""
        scale = lcm(*(a.denominator for _, a in terms))
        wholes = [a.numerator * (scale // a.denominator) for _, a in terms]
        divisor = gcd(*wholes) if wholes[0] > 0 else -gcd(*wholes)
        known = tuple((powers, whole // divisor) for (powers, _), whole in zip(terms, wholes, strict=True))
        if known not in self._short:
            poly = {
                tuple(sorted((self._angle[i], power) for i, power in powers)): Fraction(whole)
                for powers, whole in known
            }
            for finder in self._finders:
                poly = finder.rewrite(poly)
            self._short[known] = _scaled(sorted(poly.items(), key=lambda item: _reading_order(item[0])))
        inner, short = self._short[known]
        number = inner * Fraction(divisor, scale)
        if all(abs(a) <= SMALL and a.denominator == 1 for _, a in short):
            return number, short
        return _scaled([(monomial, number * a) for monomial, a in short])

    def _grouped(self, split: dict[Powers, tuple[Fraction, Key]]) -> list[Item]:
        """Return one term for each different trigonometric polynomial: (Σ parameters) · polynomial."""
        shared: dict[Key, list[Item]] = {}
        for outer, (leading, key) in split.items():
            shared.setdefault(key, []).append((leading, {self._generator(i): power for i, power in outer}))
        result: list[Item] = []
        for key in sorted(shared, key=lambda key: (len(key) > 1, _reading_order(key[0][0]))):  # the shortest first
            parameters = shared[key]
            if list(split) == [()]:  # numbers alone: no bracket around everything
                parts = partition([(parameters[0][0] * a, factors) for a, factors in self._items(key)])
                return [(Fraction(1), {self._words.number(self._words.collect(part)): 1}) for part in parts]
            if len(key) == 1:
                factor, trigonometric = self._items(key)[0]
            else:
                factor, trigonometric = Fraction(1), {self._polynomial(key): 1}
            scaled: list[Item] = [(a * factor, factors) for a, factors in parameters]
            for part in [scaled] if trigonometric else partition(scaled):
                if len(part) == 1:
                    result.append((part[0][0], {**part[0][1], **trigonometric}))
                    continue
                number, common, rest = take_out(part)
                inner = rest[0][1] if len(rest) == 1 else {self._words.number(self._words.collect(rest)): 1}
                result.append((number, {**inner, **common, **trigonometric}))
        return result

    def _items(self, key: Key) -> list[Item]:
        return [(a, {self._factor(f): power for f, power in monomial}) for monomial, a in key]

    def _polynomial(self, key: Key) -> int:
        """Return the word for a trigonometric polynomial of several terms."""
        if key not in self._known:
            self._known[key] = self._words.number(self._words.collect(self._items(key)))
        return self._known[key]

    # What a generator looks like

    def _factor(self, factor: Factor) -> int:
        if factor not in self._known:
            kind, angle = factor
            common = gcd(*(multiple for _, multiple in angle))
            sums: dict[Expr | None, Fraction] = {}
            for index, multiple in angle:
                for node, coefficient in self.ring.angle(index):
                    sums[node] = sums.get(node, Fraction(0)) + multiple // common * coefficient
            if len(sums) == 1:
                ((node, coefficient),) = sums.items()
                argument = _multiple(coefficient * common, node)
            else:
                inner = Form.sum(_multiple(a, q) for q, a in sums.items() if a)
                argument = Form.product((Number(Fraction(common)), inner))
            self._known[factor] = self._words.number(Function(Op.COS if kind == "c" else Op.SIN, (argument,)))
        return self._known[factor]

    def _generator(self, i: int) -> int:
        if i not in self._known:
            self._known[i] = self._words.number(self._describe(i))
        return self._known[i]

    def _describe(self, i: int) -> Form:
        g = self.ring.generators[i]
        if g.kind == "pi":
            return Pi()
        if g.kind == "symbol":
            assert g.node is not None
            return Symbol(str(g.node.value))
        if g.kind == "inverse":
            return Power(self(self.ring.inverse_of(i)), -1)
        if g.node is None:
            return Function(Op.SQRT, (Number(Fraction(g.number)),))
        return Form.of(g.node)


def _multiple(coefficient: Fraction, node: Expr | None) -> Form:
    """Return coefficient · node as it is read in an angle: 2 q, π/180, 0.3."""
    if node is None:
        return Number(coefficient)
    if node.op is not Op.PI:
        return Form.product((Number(coefficient), Form.of(node)))
    p, q = (Number(Fraction(x)) for x in coefficient.as_integer_ratio())
    return Form.product((p, Pi()) if q == Number.ONE else (p, Pi(), q.power(-1)))


def _scaled(terms: Sequence[tuple[Monomial, Fraction]]) -> tuple[Fraction, Key]:
    number = content([a for _, a in terms])
    return number, tuple((monomial, a / number) for monomial, a in terms)


def _reading_order(monomial: Monomial) -> tuple[object, ...]:
    """Sort key: short monomials first, then by angle."""
    return (sum(power for _, power in monomial), [(angle, kind) for (kind, angle), _ in monomial])


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
    if plus:
        p, q = sorted((p, q), key=repr)  # the sum is one angle, whichever comes first
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
    factors = term.factors
    return Form.product(factors[1:]) if len(factors) > 1 and factors[0] == TWO else None


def _is_square(factors: tuple[Form, ...], common: list[Form], b: Form) -> bool:
    """Tell whether factors are those common and b²."""
    left = Counter(factors) - Counter(common)
    if len(factors) != len(common) + 1 or sum(left.values()) != 1:
        return False
    (one,) = left
    return isinstance(one, Power) and one.exponent == 2 and set(one.base.terms) == set(b.terms)
