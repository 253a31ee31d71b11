"""The ring of trigonometric polynomials: where closed forms live and zero is decidable.

An element is a polynomial over the rationals (python-flint's `fmpq_mpoly`) in these generators, kept in normal form:

    s, c       sine and cosine of each angle atom            s² → 1 - c²
    r          square root of a prime or of a parameter      r² → its radicand
    i          inverse of a parameter-only denominator d     i d → 1
    x          2 cos(2π/m), where an angle has a multiple of π without square roots     minimal polynomial → 0
    symbols    bare coordinates, velocities, parameters; π; functions (exp, tanh, …) of parameters, uninterpreted

An angle is read as a linear form (`symdyn.graph.linear_form`); sums go by the addition formulas, and the atom's unit
is the greatest common divisor of its coefficients, so that q and q/2 share one pair. Multiples of π are exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly_ctx, fmpz_poly

from symdyn.errors import DerivationError
from symdyn.graph import FUNCTIONS, Expr, Op, linear_form, reachable
from symdyn.graph.identities import SMALL_PRIMES

Polynomial = Any  # flint.fmpq_mpoly, which carries no type hints
Pair = tuple[Polynomial, Polynomial]  # cosine and sine


@dataclass(frozen=True)
class Generator:
    """What a generator of the ring stands for.

    Attributes:
        kind: "sin", "cos", "symbol", "pi", "root", "inverse", "function" or "cyclotomic".
        node: the angle's atom (None: 1 rad), the symbol, the root or the function.
        unit: sine and cosine are those of unit · node.
        number: the prime under a root, the order m of a cyclotomic generator, the slot of an inverse; else 0.
    """

    kind: str
    node: Expr | None = None
    unit: Fraction = Fraction(1)
    number: int = 0


@dataclass(frozen=True)
class _Relation:
    """`polynomial` = 0 reduces every element whose degree in generator `index` reaches `degree`."""

    index: int
    degree: int
    polynomial: Polynomial


class TrigonometricRing:
    """A ring wide enough for given outputs, and an `Algebra` that graphs are run over with `ring.values(outputs)`."""

    def __init__(self, outputs: Sequence[Expr], variables: Sequence[Expr] = ()) -> None:
        """Choose the generators.

        Args:
            outputs: nodes that will be run over the ring.
            variables: coordinates and velocities; functions, roots and denominators must be free of them.

        Raises:
            DerivationError: an output is no trigonometric polynomial in `variables`.
        """
        self.variables = tuple(variables)
        nodes = reachable([*outputs, *variables])
        self._refuse_variables(nodes)
        units, turn = _angle_units(nodes)
        self._order = lcm(4, (turn / 2).denominator)  # of the root of unity that all multiples of π are powers of
        self.generators = tuple(_choose(nodes, units, self._order))
        self._index = {(g.kind, g.node, g.number): i for i, g in enumerate(self.generators)}
        names = [f"{g.kind}{i}" for i, g in enumerate(self.generators)]
        self.context = fmpq_mpoly_ctx.get(names or ["none"], Ordering.lex)
        self._gens = self.context.gens()
        self.zero, self.one = self.context.constant(0), self.context.constant(1)
        self._relations: list[_Relation] = []
        self._inverses: dict[str, int] = {}
        self._constants: dict[Fraction, Polynomial] = {}
        self._pairs: dict[Expr, Pair] = {}
        for i, g in enumerate(self.generators):
            if g.kind == "sin":
                c = self._gens[self._index["cos", g.node, 0]]
                self._relate(i, 2, self._gens[i] ** 2 + c**2 - 1)
            elif g.kind == "root" and g.node is None:
                self._relate(i, 2, self._gens[i] ** 2 - g.number)
            elif g.kind == "cyclotomic":
                minimal = fmpz_poly.cos_minpoly(g.number).coeffs()
                self._relate(i, len(minimal) - 1, sum(int(a) * self._gens[i] ** k for k, a in enumerate(minimal)))

    def _refuse_variables(self, nodes: Sequence[Expr]) -> None:
        moving = set(self.variables)
        for node in nodes:
            if node.op is Op.SIN or node.op is Op.COS:
                guilty = [atom for atom, _ in linear_form(node.args[0]).terms if atom.op is not Op.SYMBOL]
            elif node.op is Op.DIV:
                guilty = [node.args[1]]
            else:
                guilty = list(node.args) if node.op in FUNCTIONS else []
            for found in guilty:
                names = [str(n.value) for n in reachable([found]) if n in moving]
                if names:
                    raise DerivationError(
                        f"{node.op.name.lower()} of an expression in {', '.join(names)} is no trigonometric polynomial, "
                        "so it has no closed form; use the graph (lagrange, NumPy, C), which has no such limit"
                    )

    # The algebra

    def values(self, outputs: Iterable[Expr]) -> dict[Expr, Polynomial]:
        """Return the value of every symbol that `outputs` need, for `evaluate`."""
        return {
            node: self._gens[self._index["symbol", node, 0]] for node in reachable(outputs) if node.op is Op.SYMBOL
        }

    def constant(self, value: Fraction) -> Polynomial:
        """Return an exact constant."""
        if value not in self._constants:
            self._constants[value] = self.context.constant(fmpq(value.numerator, value.denominator))
        return self._constants[value]

    def pi(self) -> Polynomial:
        """Return π, a generator: outside angles it is transcendental."""
        return self._gens[self._index["pi", None, 0]]

    def add(self, a: Polynomial, b: Polynomial) -> Polynomial:
        """Return a + b."""
        return a + b

    def sub(self, a: Polynomial, b: Polynomial) -> Polynomial:
        """Return a - b."""
        return a - b

    def neg(self, a: Polynomial) -> Polynomial:
        """Return -a."""
        return -a

    def mul(self, a: Polynomial, b: Polynomial) -> Polynomial:
        """Return a b in normal form."""
        return self.normal(a * b)

    def dot(self, a: Iterable[Polynomial], b: Iterable[Polynomial]) -> Polynomial:
        """Return Σ a b in normal form, reduced once."""
        total = self.zero
        for x, y in zip(a, b, strict=True):
            if x and y:
                total += x * y
        return self.normal(total)

    def div(self, a: Polynomial, b: Polynomial) -> Polynomial:
        """Return a / b: exactly where b divides a, else with an inverse generator; ZeroDivisionError if b = 0."""
        if not b:
            raise ZeroDivisionError("a closed form divides by zero")
        if not b.is_constant():
            quotient, rest = divmod(a, b)
            if not rest:
                return quotient
            numerator, b = self._rationalise(b)
            a = self.normal(a * numerator)
        factor, powers = b.term_content(), ()
        leading = b.leading_coefficient()
        rest = b / (factor * (leading / factor.leading_coefficient()))
        powers = factor.degrees() if not factor.is_constant() else ()
        a = a / leading
        for i, power in enumerate(powers):
            for _ in range(int(power)):
                a = self.normal(a * self._inverse(self._gens[i]))
        return a if rest == 1 else self.normal(a * self._inverse(rest))

    def _rationalise(self, b: Polynomial) -> Pair:
        """Return (n, d) with 1/b = n/d and d free of roots and of x."""
        numerator = self.one
        for i, g in enumerate(self.generators):
            if b.degrees()[i] and g.kind == "root":
                conjugate = b.compose(*[-x if k == i else x for k, x in enumerate(self._gens)])
                numerator, b = self.normal(numerator * conjugate), self.normal(b * conjugate)
            elif b.degrees()[i] and g.kind == "cyclotomic":
                factor = self._field_inverse(b, i)
                numerator, b = self.normal(numerator * factor), self.normal(b * factor)
        return numerator, b

    def _field_inverse(self, b: Polynomial, i: int) -> Polynomial:
        """Return n(x) with b n free of x: the product of the other conjugates cos(2πk/m), gcd(k, m) = 1."""
        m, product = self.generators[i].number, self.one
        for k in range(2, m // 2):
            if gcd(k, m) == 1:
                other = 2 * self._power_of_unity(k)[0]
                product = self.normal(
                    product * self.normal(b.compose(*[other if j == i else x for j, x in enumerate(self._gens)]))
                )
        return product

    def _inverse(self, d: Polynomial) -> Polynomial:
        key = str(d)
        if key not in self._inverses:
            slot = self._index["inverse", None, len(self._inverses) + 1]
            self._inverses[key] = slot
            self._relate(slot, 1, self._gens[slot] * d - 1)
        return self._gens[self._inverses[key]]

    def inverse_of(self, generator: int) -> Polynomial:
        """Return the denominator d that an inverse generator stands for."""
        relation = next(r for r in self._relations if r.index == generator)
        return relation.polynomial.derivative(generator)

    def function(self, node: Expr, args: Sequence[Polynomial]) -> Polynomial:
        """Return the sine or cosine by addition formulas, the root by prime radicals, other functions as generators."""
        if node.op in (Op.SIN, Op.COS):
            return self._circular(node.args[0])[0 if node.op is Op.COS else 1]
        if node.op is not Op.SQRT:
            return self._gens[self._index["function", node, 0]]
        if node.args[0].op is Op.CONSTANT:
            return self._root(node.args[0].value)  # type: ignore[arg-type]
        slot = self._index["root", node, 0]
        if all(relation.index != slot for relation in self._relations):
            self._relate(slot, 2, self._gens[slot] ** 2 - args[0])
        return self._gens[slot]

    def _root(self, value: Fraction) -> Polynomial:
        if value < 0:
            raise DerivationError(f"sqrt({value}) is not real; only roots of non-negative numbers have a closed form")
        product = self.constant(Fraction(1, value.denominator))
        for prime in prime_factors(value.numerator * value.denominator):
            product = self.normal(product * self._radical(prime))
        return product

    def _radical(self, p: int) -> Polynomial:
        """Return sqrt(p): a generator, or where x generates it a Gauss sum."""
        if ("root", None, p) in self._index:
            return self._gens[self._index["root", None, p]]
        if p == 2:
            return 2 * self._power_of_unity(self._order // 8)[0]
        step, part = self._order // p, 0 if p % 4 == 1 else 1
        return sum((self._power_of_unity(step * k * k)[part] for k in range(p)), self.zero)

    def _power_of_unity(self, k: int) -> Pair:
        """Return cosine and sine of 2πk/m."""
        m = self._order
        return self._cosine(k % m), self._cosine((k - m // 4) % m)

    def _cosine(self, k: int) -> Polynomial:
        m = self._order
        k = min(k, m - k)
        if 4 * k > m:
            return -self._cosine(m // 2 - k)
        if ("cyclotomic", None, m) in self._index:  # 2 cos(kt) = x · 2 cos((k-1)t) - 2 cos((k-2)t)
            x = self._gens[self._index["cyclotomic", None, m]]
            before, now = self.constant(Fraction(2)), x
            for _ in range(k):
                before, now = now, self.normal(x * now) - before
            return before / 2
        half = self.constant(Fraction(1, 2))
        roots = {
            Fraction(0): lambda: self.one,
            Fraction(1, 24): lambda: half * half * self._radical(2) * (self._radical(3) + 1),
            Fraction(1, 12): lambda: half * self._radical(3),
            Fraction(1, 8): lambda: half * self._radical(2),
            Fraction(1, 6): lambda: half,
            Fraction(5, 24): lambda: half * half * self._radical(2) * (self._radical(3) - 1),
            Fraction(1, 4): lambda: self.zero,
        }
        return roots[Fraction(k, m)]()

    def _circular(self, angle: Expr) -> Pair:
        """Return cosine and sine of an angle."""
        if angle in self._pairs:
            return self._pairs[angle]
        form = linear_form(angle)
        pair = self._power_of_unity(int(form.turns / 2 * self._order))
        for atom, coefficient in ((None, form.constant), *form.terms):
            if coefficient:
                index = self._index["cos", atom, 0]
                base = (self._gens[index], self._gens[self._index["sin", atom, 0]])
                count = int(coefficient / self.generators[index].unit)
                base = base if count > 0 else (base[0], -base[1])
                for _ in range(abs(count)):
                    pair = self.turned(pair, base)
        self._pairs[angle] = pair
        return pair

    def turned(self, a: Pair, b: Pair) -> Pair:
        """Return cosine and sine of the sum of two angles."""
        return self.normal(a[0] * b[0] - a[1] * b[1]), self.normal(a[1] * b[0] + a[0] * b[1])

    # Normal form and calculus

    def _relate(self, index: int, degree: int, polynomial: Polynomial) -> None:
        self._relations.append(_Relation(index, degree, polynomial))
        self._relations.sort(key=lambda relation: relation.index)
        self._entangled = any(self.generators[r.index].kind in ("inverse", "root") for r in self._relations)

    def normal(self, p: Polynomial) -> Polynomial:
        """Return the normal form of p."""
        while True:
            degrees, reduced = p.degrees(), p
            for relation in self._relations:
                if degrees[relation.index] >= relation.degree:
                    reduced = reduced % relation.polynomial
            if reduced is p or not self._entangled or reduced == p:
                return reduced
            p = reduced

    def is_zero(self, p: Polynomial) -> bool:
        """Return whether p vanishes as a function: normal form with denominators cleared."""
        p = self.normal(p)
        for index in self._inverses.values():
            for _ in range(int(p.degrees()[index])):
                p = self.normal(p * self.inverse_of(index))
        return bool(p.is_zero())

    def derivative(self, p: Polynomial, variable: Expr) -> Polynomial:
        """Return ∂p/∂variable in normal form; ∂c = -unit s, ∂s = unit c."""
        assert variable in self.variables, f"{variable} was not announced as a variable of this ring"
        total = p.derivative(self._index["symbol", variable, 0])
        if ("cos", variable, 0) in self._index:
            c, s = self._index["cos", variable, 0], self._index["sin", variable, 0]
            unit = self.generators[c].unit
            turning = self._gens[c] * p.derivative(s) - self._gens[s] * p.derivative(c)
            total += turning if unit == 1 else self.constant(unit) * turning
        return self.normal(total)

    def terms(self, p: Polynomial) -> list[tuple[tuple[tuple[int, int], ...], Fraction]]:
        """Return the terms of p: ((generator, power), …) by ascending generator, and the coefficient."""
        return [
            (tuple((i, int(e)) for i, e in enumerate(powers) if e), Fraction(int(a.p), int(a.q)))
            for powers, a in zip(p.monoms(), p.coeffs(), strict=True)
        ]


def _angle_units(nodes: Sequence[Expr]) -> tuple[dict[Expr | None, Fraction], Fraction]:
    """Return each angle atom's unit (None: 1 rad), and the unit of the multiples of π."""
    units: dict[Expr | None, Fraction] = {}
    turn = Fraction(1)
    for node in nodes:
        if node.op in (Op.SIN, Op.COS):
            form = linear_form(node.args[0])
            turn = _divisor(turn, form.turns)
            for atom, coefficient in ((None, form.constant), *form.terms):
                if coefficient:
                    units[atom] = _divisor(units.get(atom, Fraction(0)), coefficient)
    return units, turn


def _divisor(a: Fraction, b: Fraction) -> Fraction:
    """Return the greatest fraction of which both are integer multiples."""
    scale = lcm(a.denominator, b.denominator)
    return Fraction(gcd(int(a * scale), int(b * scale)), scale)


def _choose(nodes: Sequence[Expr], units: dict[Expr | None, Fraction], order: int) -> Iterable[Generator]:
    """Yield the generators, those that relations eliminate first (the ordering is lexicographic)."""
    atoms = sorted(units, key=lambda atom: -1 if atom is None else atom.index)
    for atom in atoms:
        yield Generator("sin", atom, units[atom])
    radicands = [node.args[0] for node in nodes if node.op is Op.SQRT]
    for node in reversed(nodes):
        if node.op is Op.SQRT and node.args[0].op is not Op.CONSTANT:
            yield Generator("root", node)
    wanted = {p for x in radicands if x.op is Op.CONSTANT for p in prime_factors(x.value.numerator * x.value.denominator)}  # type: ignore[union-attr]
    below = reachable([node.args[1] for node in nodes if node.op is Op.DIV])
    slots = sum(node.op is Op.DIV for node in nodes) + 2 * len(below)
    for slot in range(slots, 0, -1):
        yield Generator("inverse", number=slot)
    radical = order in (4, 8, 12, 24)
    if radical:
        wanted |= {p for p, m in ((2, 8), (3, 12)) if order % m == 0}
    for p in sorted(wanted):
        if radical or order % (8 if p == 2 else p):
            yield Generator("root", number=p)
    if not radical:
        yield Generator("cyclotomic", number=order)
    for atom in atoms:
        yield Generator("cos", atom, units[atom])
    for node in nodes:
        if node.op in FUNCTIONS and node.op not in (Op.SIN, Op.COS, Op.SQRT):
            yield Generator("function", node)
    if any(node.op is Op.PI for node in nodes):
        yield Generator("pi")
    for node in nodes:
        if node.op is Op.SYMBOL:
            yield Generator("symbol", node)


def prime_factors(n: int) -> list[int]:
    """Return primes, and perhaps one unfactored rest, whose product is n > 0; with multiplicity."""
    found = []
    for prime in SMALL_PRIMES:
        while n % prime == 0:
            n //= prime
            found.append(prime)
    return found + ([n] if n > 1 else [])
