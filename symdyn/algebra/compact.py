"""From normal form to a form worth reading, inside the ring: milliseconds a coefficient.

    1. split into parameter monomials, each with a trigonometric polynomial;
    2. write that polynomial shortest: sines of sums, s² or c² (`sums_of_angles`);
    3. parameters that multiply the same polynomial share it;
    4. collect common factors, the one that saves most first.

Nothing is approximated and nothing is searched by heuristics that could change the value: `express_form` takes the
result back to a graph, and over the ring it equals the normal form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import gcd, lcm

from symdyn.algebra.form import (
    Form,
    Function,
    Number,
    Pi,
    Power,
    Symbol,
    form_of,
    power_of,
    product_of,
    split_sign,
    sum_of,
)
from symdyn.algebra.sums_of_angles import Angle, AngleGroup, Factor, Monomial, Poly, SumFinder
from symdyn.algebra.trigonometric import Polynomial, TrigonometricRing
from symdyn.graph import Op

Item = tuple[Fraction, Mapping[Form, int]]  # one term: a number times powers of forms

LONG = 4  # a factor common to fewer terms stays in them, as in the textbook's (5.40)
SMALL = 12  # integers up to this size may stay behind when a common number is taken out


class Compactor:
    """Turns elements of one ring into forms; parts that repeat are rewritten once."""

    def __init__(self, ring: TrigonometricRing, groups: Sequence[AngleGroup] = ()) -> None:
        """Prepare the bases.

        Args:
            ring: where the elements live.
            groups: angles whose sums are worth a try.
        """
        self.ring = ring
        cosine = {g.node: i for i, g in enumerate(ring.generators) if g.kind == "cos"}
        self._angle: dict[int, tuple[str, Angle]] = {}
        for i, g in enumerate(ring.generators):
            if g.kind in ("sin", "cos"):
                self._angle[i] = (g.kind[0], ((cosine[g.node], 1),))
        self._finders = []
        alone = dict.fromkeys(cosine.values())
        for group in groups:
            places = [k for k, q in enumerate(group.atoms) if q in cosine and ring.generators[cosine[q]].unit == 1]
            atoms = tuple(cosine[group.atoms[k]] for k in places)
            outside = [k for k in range(len(group.atoms)) if k not in places]
            sums = tuple(tuple(s[k] for k in places) for s in group.sums if not any(s[k] for k in outside))
            self._finders.append(SumFinder(atoms, sums))
            for atom in atoms:
                alone.pop(atom)
        self._finders += [SumFinder((atom,), ((1,),)) for atom in alone]
        self._forms: dict[object, Form] = {}

    def __call__(self, p: Polynomial) -> Form:
        """Return a short form of p."""
        items = self._grouped(self._by_parameters(p))
        number, common, rest = _take_out(items)
        if len(items) < LONG or not common:
            return sum_of(term_form(item) for item in items)
        return product_of([Number(number), *_powers(common), sum_of(map(term_form, rest))])

    def _by_parameters(self, p: Polynomial) -> dict[tuple[tuple[int, int], ...], Poly]:
        """Return the trigonometric polynomial that each monomial of the other generators multiplies, shortened."""
        split: dict[tuple[tuple[int, int], ...], Poly] = {}
        for powers, coefficient in self.ring.terms(p):
            outer = tuple(item for item in powers if item[0] not in self._angle)
            inner = tuple(sorted((self._angle[i], power) for i, power in powers if i in self._angle))
            split.setdefault(outer, {})[inner] = coefficient
        for outer, poly in split.items():
            for finder in self._finders:
                poly = finder.rewrite(poly)
            split[outer] = poly
        return split

    def _grouped(self, split: dict[tuple[tuple[int, int], ...], Poly]) -> list[Item]:
        """Return one term for each different trigonometric polynomial: (Σ parameters) · polynomial."""
        shared: dict[tuple[tuple[Monomial, Fraction], ...], list[Item]] = {}
        for outer, poly in split.items():
            items = sorted(poly.items(), key=lambda item: _reading_order(item[0]))
            leading = _content([coefficient for _, coefficient in items])
            key = tuple((monomial, coefficient / leading) for monomial, coefficient in items)
            factors = {self._generator(i): power for i, power in outer}
            shared.setdefault(key, []).append((leading, factors))
        result: list[Item] = []
        for key, parameters in sorted(shared.items(), key=lambda entry: _shortest_first(entry[0])):
            if len(key) == 1:
                trigonometric: dict[Form, int] = {self._factor(f): power for f, power in key[0][0]}
                scale = key[0][1]
            else:
                trigonometric = {self._trigonometric(key): 1}
                scale = Fraction(1)
            scaled = [(a * scale, factors) for a, factors in parameters]
            for part in _partition(scaled) if not trigonometric else [scaled]:
                number, common, rest = _take_out(part)
                inner = {} if len(rest) == 1 else {collect(rest): 1}
                last = rest[0][1] if len(rest) == 1 else {}
                result.append((number * (rest[0][0] if last or len(rest) == 1 else 1), {**inner, **common, **last, **trigonometric}))
        return result

    def _trigonometric(self, key: tuple[tuple[Monomial, Fraction], ...]) -> Form:
        if key not in self._forms:
            items = [(a, {self._factor(f): power for f, power in monomial}) for monomial, a in key]
            self._forms[key] = collect(items)
        return self._forms[key]

    # What a generator looks like

    def _factor(self, factor: Factor) -> Form:
        if factor not in self._forms:
            kind, angle = factor
            terms = []
            for index, multiple in angle:
                generator = self.ring.generators[index]
                atom = Number(Fraction(1)) if generator.node is None else form_of(generator.node)
                terms.append(product_of((Number(multiple * generator.unit), atom)))
            self._forms[factor] = Function(Op.COS if kind == "c" else Op.SIN, (sum_of(terms),))
        return self._forms[factor]

    def _generator(self, i: int) -> Form:
        if i not in self._forms:
            self._forms[i] = self._describe(i)
        return self._forms[i]

    def _describe(self, i: int) -> Form:
        g = self.ring.generators[i]
        if g.kind == "pi":
            return Pi()
        if g.kind == "symbol":
            assert g.node is not None
            return Symbol(str(g.node.value))
        if g.kind == "inverse":
            return Power(self(self.ring.inverse_of(i)), -1)
        if g.kind == "cyclotomic":
            angle = product_of((Number(Fraction(2, g.number)), Pi()))
            return product_of((Number(Fraction(2)), Function(Op.COS, (angle,))))
        if g.node is None:
            return Function(Op.SQRT, (Number(Fraction(g.number)),))
        return form_of(g.node)


def _reading_order(monomial: Monomial) -> tuple[object, ...]:
    """Sort key: short monomials first, then by angle."""
    return (sum(power for _, power in monomial), [(angle, kind) for (kind, angle), _ in monomial])


def _shortest_first(key: tuple[tuple[Monomial, Fraction], ...]) -> tuple[object, ...]:
    """Sort key of trigonometric polynomials: constants, single terms, then the others."""
    return (len(key) > 1, _reading_order(key[0][0]))


def term_form(item: Item) -> Form:
    """Return number · Π form^power."""
    return product_of([Number(item[0]), *_powers(item[1])])


def _powers(factors: Mapping[Form, int]) -> list[Form]:
    return [power_of(form, power) for form, power in factors.items()]


def collect(items: Sequence[Item]) -> Form:
    """Return Σ number · Π form^power with common factors taken out, the one that saves most first."""
    number, common, rest = _take_out(items)
    if len(rest) == 1:
        return term_form(items[0])
    inner = sum_of(positive_first([collect(part) for part in _partition(rest)]))
    return product_of([Number(number), inner, *_powers(common)])


def positive_first(terms: Sequence[Form]) -> list[Form]:
    """Return the terms with one that has no minus sign in front, if there is one."""
    first = next((i for i, term in enumerate(terms) if split_sign(term)[0] > 0), 0)
    return [terms[first], *terms[:first], *terms[first + 1 :]]


def _partition(items: Sequence[Item]) -> list[list[Item]]:
    """Return the terms in parts that share a factor: the factor that saves most first, the rest alone."""
    best, saving = None, 0
    counts: dict[tuple[Form, int], int] = {}
    for _, factors in items:
        for form, power in factors.items():
            for k in range(1, power + 1):
                counts[form, k] = counts.get((form, k), 0) + 1
    for (form, power), count in counts.items():
        if (count - 1) * power > saving:
            best, saving = (form, power), (count - 1) * power
    if best is None:
        return [[item] for item in items]
    form, power = best
    chosen = [item for item in items if item[1].get(form, 0) >= power]
    return [chosen, *_partition([item for item in items if item[1].get(form, 0) < power])]


def _take_out(items: Sequence[Item]) -> tuple[Fraction, dict[Form, int], list[Item]]:
    """Return (number, common factors, what is left of the terms)."""
    number = _content([a for a, _ in items])
    common = {
        form: power
        for form in items[0][1]
        if (power := min(factors.get(form, 0) for _, factors in items)) > 0
    } if items else {}
    rest = []
    for a, factors in items:
        left = {form: power - common.get(form, 0) for form, power in factors.items()}
        rest.append((a / number, {form: power for form, power in left.items() if power}))
    return number, common, rest


def _content(numbers: Sequence[Fraction]) -> Fraction:
    """Return a number worth taking out of a sum: what leaves small integers, else the sign of the first."""
    if not numbers:
        return Fraction(1)
    negative = sum(a < 0 for a in numbers)
    sign = -1 if 2 * negative > len(numbers) or (2 * negative == len(numbers) and numbers[0] < 0) else 1
    scale = lcm(*(a.denominator for a in numbers))
    divisor = Fraction(gcd(*(int(a * scale) for a in numbers)), scale)
    if max(abs(a / divisor) for a in numbers) <= SMALL:
        return sign * divisor
    return Fraction(sign)
