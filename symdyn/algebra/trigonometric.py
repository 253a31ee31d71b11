"""The ring of trigonometric polynomials: where closed forms live and zero is decidable.

An element is a polynomial over the rationals (python-flint's `fmpq_mpoly`) in these generators, kept in normal form:

    s, c       sine and cosine of each unit of each angle atom     s² → 1 - c²
    r          square root of a prime or of a parameter            r² → its radicand
    e          first of a unit quaternion's four                   e² → 1 - the squares of the others
    i          inverse of a parameter-only denominator d           i d → 1
    symbols    bare coordinates, velocities, parameters; π; functions (exp, tanh, …) of parameters, uninterpreted

An angle is read as a linear form; sums go by the addition formulas (`symdyn.algebra.generators` says what has a sine
of its own). Multiples of π/12 are exact. So normal form is zero for what vanishes as a function of coordinates and
parameters, with one exception: relations between constant angles that have a sine of their own (cos 36° = (1 + √5)/4,
sin 2° = 2 sin 1° cos 1°) and relations of high degree between angles in one coordinate (q and 100 q) are not known.
What relies on one of them may stay as a term whose value is zero: longer than need be, and still true.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import compress
from math import prod
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly_ctx
from flint.utils.flint_exceptions import DomainError

from symdyn.algebra.form import Form, Number, in_any_order
from symdyn.algebra.generators import (
    COSINES,
    Atom,
    angle_units,
    choose_generators,
    prime_factors,
    read_angle,
    refuse_variables,
    split_by_units,
    turning,
)
from symdyn.algebra.sums_of_angles import AngleGroup, rounded, total_angles
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Arithmetic, Expr, Op, evaluate, reachable

MOST_PRODUCTS = 3_000_000  # a 7-axis arm with ten symbolic inertial parameters a link takes 16 thousand
TINY = Fraction(1, 10**60)

Polynomial = Any  # flint.fmpq_mpoly, which carries no type hints
Pair = tuple[Polynomial, Polynomial]  # cosine and sine


@dataclass(frozen=True)
class _Relation:
    """`polynomial` = 0 reduces every element whose degree in generator `index` reaches `degree`."""

    index: int
    degree: int
    polynomial: Polynomial


class TrigonometricRing(Arithmetic):
    """A ring wide enough for given outputs, and an `Algebra` that graphs are run over with `ring.values(outputs)`."""

    def __init__(
        self,
        outputs: Sequence[Expr],
        variables: Sequence[Expr] = (),
        parallel: Iterable[AngleGroup] = (),
        units: Iterable[Sequence[Expr]] = (),
    ) -> None:
        """Choose the generators.

        Args:
            outputs: nodes that will be run over the ring.
            variables: coordinates and velocities; functions, roots and denominators must be free of them.
            parallel: angles of joints with parallel axes. Generators of a long chain are the sines and cosines of
                total angles u = sign · q + u(below): cos(q1 + … + qn) is one term then, not 2^(n-1).
            units: symbols whose squares add up to 1, as those of a unit quaternion; all among the variables.

        Raises:
            DerivationError: an output is no trigonometric polynomial in `variables`.
        """
        self.variables = tuple(variables)
        nodes = reachable([*outputs, *variables])
        turned = turning(nodes, self.variables)
        nodes = reachable([*outputs, *variables, *(slope for _, slope in turned.values())])
        refuse_variables(nodes, self.variables, turned)
        self._totals = total_angles(parallel)
        self._units, order = angle_units(nodes, self._totals)
        self.generators = tuple(choose_generators(nodes, self._units, order))
        self._index = {(g.kind, g.node, g.number): i for i, g in enumerate(self.generators)}
        self._circle = {(g.kind, g.node, g.unit): i for i, g in enumerate(self.generators)}
        names = [f"{g.kind}{i}" for i, g in enumerate(self.generators)]
        self.context = fmpq_mpoly_ctx.get(names or ["none"], Ordering.lex)
        self._gens = self.context.gens()
        self.zero, self.one = self.context.constant(0), self.context.constant(1)
        self._relations: list[_Relation] = []
        self._inverses: dict[str, int] = {}
        self._products = 0
        self._constants: dict[Fraction, Polynomial] = {}
        self._pairs: dict[Expr, Pair] = {}
        self._turning: dict[Expr, list[tuple[int, int, Polynomial]]] = {q: [] for q in self.variables}
        for i, g in enumerate(self.generators):
            if g.kind == "sin":
                c = self._circle["cos", g.node, g.unit]
                self._relate(i, 2, self._gens[i] ** 2 + self._gens[c] ** 2 - 1)
                for q, rate in self.angle(i):
                    if q in self._turning:
                        self._turning[q].append((i, c, self.constant(rate)))
            elif g.kind == "root" and g.node is None:
                self._relate(i, 2, self._gens[i] ** 2 - g.number)
        for atom, (q, slope) in turned.items():
            (rate,) = evaluate([slope], self, self.values([slope]))
            for size in self._units[atom]:
                i, c = (self._circle[kind, atom, size] for kind in ("sin", "cos"))
                self._turning[q].append((i, c, self.mul(self.constant(size), rate)))
        for unit in units:
            places = [self._index["symbol", x, 0] for x in unit]
            self._relate(min(places), 2, sum((self._gens[k] ** 2 for k in places), -self.one))

    # The algebra

    def values(self, outputs: Iterable[Expr]) -> dict[Expr, Polynomial]:
        """Return the value of every symbol that `outputs` need, for `evaluate`."""
        return {node: self._gens[self._index["symbol", node, 0]] for node in reachable(outputs) if node.op is Op.SYMBOL}

    def constant(self, value: Fraction) -> Polynomial:
        if value not in self._constants:
            self._constants[value] = self.context.constant(fmpq(value.numerator, value.denominator))
        return self._constants[value]

    def pi(self) -> Polynomial:
        """Return π, a generator: outside angles it is transcendental."""
        return self._gens[self._index["pi", None, 0]]

    def mul(self, a: Polynomial, b: Polynomial) -> Polynomial:
        self.count(len(a) * len(b))
        return self.normal(a * b)

    def dot(self, a: Iterable[Polynomial], b: Iterable[Polynomial]) -> Polynomial:
        """Return Σ a b in normal form, reduced once."""
        total = self.zero
        for x, y in zip(a, b, strict=True):
            if x and y:
                self.count(len(x) * len(y))
                total += x * y
        return self.normal(total)

    def count(self, products: int) -> None:
        """Add to the work that was done; DerivationError where it is more than a closed form of use takes."""
        self._products += products
        if self._products > MOST_PRODUCTS:
            raise DerivationError(
                f"the closed form is too long to be of use: it takes more than {MOST_PRODUCTS} products of terms; "
                "symdyn generate writes NumPy and C code, which grows with the number of joints only"
            )

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
        factor, leading = b.term_content(), b.leading_coefficient()
        rest = b / (factor * (leading / factor.leading_coefficient()))
        powers = factor.degrees() if not factor.is_constant() else ()
        a = a / leading
        for i, power in enumerate(powers):
            for _ in range(int(power)):
                a = self.normal(a * self._inverse(self._gens[i]))
        return a if rest == 1 else self.normal(a * self._inverse(rest))

    def _rationalise(self, b: Polynomial) -> Pair:
        """Return (n, d) with 1/b = n/d and d free of roots."""
        numerator = self.one
        for i, g in enumerate(self.generators):
            if b.degrees()[i] and g.kind == "root":
                conjugate = b.compose(*[-x if k == i else x for k, x in enumerate(self._gens)])
                numerator, b = self.normal(numerator * conjugate), self.normal(b * conjugate)
        return numerator, b

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
            return self._gens[self._index["function", self._announced("function", node)[1], 0]]
        if node.args[0].op is Op.CONSTANT:
            return self._root(node.args[0].value)  # type: ignore[arg-type]
        slot = self._index["root", self._announced("root", node)[1], 0]
        if all(relation.index != slot for relation in self._relations):
            self._relate(slot, 2, self._gens[slot] ** 2 - args[0])
        return self._gens[slot]

    def _root(self, value: Fraction) -> Polynomial:
        if value < 0:
            raise DerivationError(f"sqrt({value}) is not real; only roots of non-negative numbers have a closed form")
        product = self.constant(Fraction(1, value.denominator))
        for prime in prime_factors(value):
            product = self.normal(product * self._gens[self._index["root", None, prime]])
        return product

    def _cosine(self, k: int) -> Polynomial:
        """Return the cosine of k π/12, 0 <= k < 24."""
        k = min(k, 24 - k)
        if k > 6:
            return -self._cosine(12 - k)
        total = self.zero
        for quarters, prime_product in zip(COSINES[Fraction(k, 24)], ((), (2,), (3,), (2, 3)), strict=True):
            if quarters:
                root = self.one
                for p in prime_product:
                    root = root * self._gens[self._index["root", None, p]]
                total += root * quarters / 4
        return total

    def _circular(self, angle: Expr) -> Pair:
        if angle in self._pairs:
            return self._pairs[angle]
        exact, parts = read_angle(angle, self._totals)
        pair = self._cosine(exact % 24), self._cosine((exact - 6) % 24)
        for read, coefficient in parts:
            scale, atom = self._announced("cos", read)
            split = split_by_units(coefficient * scale, self._units[atom])
            assert split is not None, f"{angle} was not announced to this ring"
            for unit, count in split:
                c, s = self._gens[self._circle["cos", atom, unit]], self._gens[self._circle["sin", atom, unit]]
                for _ in range(abs(count)):
                    pair = self.turned(pair, (c, s if count > 0 else -s))
        self._pairs[angle] = pair
        return pair

    def _announced(self, kind: str, node: Atom) -> tuple[Fraction, Atom]:
        """Return number and node of a generator of a kind whose product reads as a node does; 1 and the node if none.

        What was printed and taken back to the graph is built in another order: 2 · (l/r) becomes (1/r) · (2 · l).
        """
        if node is None or any((kind, node) == (g.kind, g.node) for g in self.generators):
            return Fraction(1), node
        factors = Form.of(node).factors
        numbers = [one.value for one in factors if isinstance(one, Number)]
        others = [one for one in factors if not isinstance(one, Number)]
        same = in_any_order(Form.product(others))
        for g in self.generators:
            if g.kind == kind and g.node is not None and in_any_order(Form.of(g.node)) == same:
                return prod(numbers, start=Fraction(1)), g.node
        return Fraction(1), node

    def turned(self, a: Pair, b: Pair) -> Pair:
        """Return cosine and sine of the sum of two angles."""
        return self.normal(a[0] * b[0] - a[1] * b[1]), self.normal(a[1] * b[0] + a[0] * b[1])

    def symbol(self, node: Expr) -> int:
        return self._index["symbol", node, 0]

    def relate_square(self, generator: int, square: Polynomial) -> None:
        """Hold that the square of a generator is an element whose first term is another square: w² = 1 - n²."""
        relation = self.normal(self._gens[generator] ** 2 - square)
        powers = relation.monoms()[0]
        index = next(k for k, power in enumerate(powers) if power)
        if sum(map(int, powers)) == powers[index]:
            self._relate(index, int(powers[index]), relation)

    def square_root(self, p: Polynomial) -> Polynomial | None:
        """Return what p is the square of, of either sign; None where it is no square of an element as it stands."""
        try:
            return p.sqrt()
        except (DomainError, ValueError):
            return None

    def replaced(self, p: Polynomial, generator: int, value: Polynomial) -> Polynomial:
        """Return p with a value for a generator that is no variable, its inverse cancelled where it can be."""
        gens = self._gens
        p = self.normal(p.compose(*[value if k == generator else x for k, x in enumerate(gens)]))
        inverse = self._inverses.get(str(gens[generator]))
        while inverse is not None:
            whole, rest = divmod(p, gens[inverse] * value)
            if not whole:
                return p
            p = self.normal(whole + rest)
        return p

    # Normal form and calculus

    def _relate(self, index: int, degree: int, polynomial: Polynomial) -> None:
        self._relations.append(_Relation(index, degree, polynomial))
        self._relations.sort(key=lambda relation: relation.index)
        self._entangled = any(self.generators[r.index].kind in ("inverse", "root") for r in self._relations)

    def normal(self, p: Polynomial) -> Polynomial:
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
        for s, c, rate in self._turning[variable]:
            turn = self._gens[c] * p.derivative(s) - self._gens[s] * p.derivative(c)
            total += turn if rate == self.one else rate * turn
        return self.normal(total)

    def in_digits(self, p: Polynomial, digits: int) -> Polynomial:
        """Return p with its numbers rounded to so many digits; those below 1e-60 are taken for zero."""
        numbers = [Fraction(int(a.p), int(a.q)) for a in p.coeffs()]
        kept = {powers: rounded(a, digits) for powers, a in zip(p.monoms(), numbers, strict=True) if abs(a) > TINY}
        return self.context.from_dict({powers: fmpq(a.numerator, a.denominator) for powers, a in kept.items()})

    def angle(self, generator: int) -> list[tuple[Expr | None, Fraction]]:
        """Return the angle whose sine or cosine a generator is: Σ coefficient · node (None: 1 rad)."""
        found: list[tuple[Expr | None, Fraction]] = []
        unit = self.generators[generator].unit
        node = self.generators[generator].node
        while node in self._totals:
            sign, below = self._totals[node]
            found.append((node, sign * unit))
            node = below
        return found[::-1] or [(node, unit)]

    def terms(self, p: Polynomial) -> list[tuple[tuple[tuple[int, int], ...], Fraction]]:
        """Return the terms of p: ((generator, power), …) by ascending generator, and the coefficient."""
        every = range(len(self.generators))
        return [
            (tuple((i, int(powers[i])) for i in compress(every, powers)), Fraction(int(a.p), int(a.q)))
            for powers, a in zip(p.monoms(), p.coeffs(), strict=True)
        ]
