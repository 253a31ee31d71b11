"""Random points for proofs: bounds on how often two different graphs agree there, values of nodes, and roots.

Every node is read as N / (D^scale Π g_k^e_k), where N is a Laurent polynomial with integer coefficients in the symbols
and in the units of the angles, D the common denominator of all constants, and g_k the numerators of the divisors met so
far. Keeping the divisors apart, instead of multiplying denominators out at every sum, keeps the bounds small: a
division by g cancels an earlier multiplication by g. Of N the degree is bounded, and the sum of the absolute values of
its coefficients (which multiply, and add): a prime at which N vanishes identically divides them.

Values of nodes at random points, over finite fields and in numbers, are kept from claim to claim: the claims of one
scene share most of their nodes.

Roots of something variable are formal values: s with s² = a, for any of whose signs an identity must hold. Over a field
a root has no sign, so that what is proved there is proved for both. That is the whole truth as long as no product of
some of the radicands is a square: sqrt(x²) = x would hold half the time. No such product is a square if the radicands
are squares of the field independently of each other: written as 0 (a square) and 1 (none), their values at points of
the field span all of GF(2)^r, up to a shift. A product that is a square times a constant can never do so.

Then E(x, s) has 2^r conjugates, and their product vanishes wherever E does: it is the rational function whose degree
counts. Points are drawn until all roots exist, which is one point of 2^r. Where roots stand within others, and where
products may be squares, E must vanish with every sign; roots within roots have 2^r - 1 radicands together, which must
be squares.

Reference: Lang, Algebra (2002), chapter VI, section 8, Kummer extensions.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from math import log, log10
from typing import Any, NamedTuple

from symdyn.algebra import FiniteField, ManyPoints, Needs, RealBalls, Redraw
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, Piecewise, arithmetic, evaluate, reachable
from symdyn.verify.written.field import symbol_value

UNEVENNESS = 64  # a prime after a long gap is drawn more often than the average one; no gap there is this much longer


UNDIVIDED: dict[int, int] = {}


class Degree(NamedTuple):
    """Bounds of one node."""

    numerator: int  # degree of N
    bits: float = 0.0  # log2 of the sum of the absolute coefficients of N
    scale: int = 0  # exponent of D below
    below: dict[int, int] = UNDIVIDED  # exponents of the divisors below (negative: above)


class Degrees:
    """The algebra of these bounds."""

    def __init__(self, needs: Needs) -> None:
        """Start without divisors; `needs` tells D and how finely angles are divided."""
        self.needs = needs
        self.denominator_bits = float((2 * needs.denominator).bit_length())  # 2 is below every sine
        self.divisors: list[Degree] = []  # N of g_k
        self.hashed: list[int] = []  # degree of whatever stands below a function or an angle

    def constant(self, value: Fraction) -> Degree:
        if value.denominator == 1:
            return Degree(0, float(value.numerator.bit_length()))
        return Degree(0, value.numerator.bit_length() + self.denominator_bits, 1)

    def pi(self) -> Degree:
        """Return degree 1: π is an independent value."""
        return Degree(1)

    def add(self, a: Degree, b: Degree) -> Degree:
        """Return the bounds of a sum over the common denominator."""
        below, scale = a.below, max(a.scale, b.scale)
        if b.below is not below and b.below != below:
            below = {k: max(a.below.get(k, 0), b.below.get(k, 0)) for k in {**a.below, **b.below}}
        (one, bits), (other, more) = self._lifted(a, below, scale), self._lifted(b, below, scale)
        return Degree(max(one, other), max(bits, more) + 1, scale, below)

    sub = add

    def mul(self, a: Degree, b: Degree) -> Degree:
        if not a.below or not b.below:
            below = a.below or b.below
        else:
            keys = {**a.below, **b.below}
            below = {k: e for k in keys if (e := a.below.get(k, 0) + b.below.get(k, 0))}
        return Degree(a.numerator + b.numerator, a.bits + b.bits, a.scale + b.scale, below)

    def div(self, a: Degree, b: Degree) -> Degree:
        """Return the bounds of a quotient; the numerator of b becomes a divisor of its own."""
        self.divisors.append(Degree(b.numerator, b.bits))
        inverse = {k: -e for k, e in b.below.items()}
        inverse[len(self.divisors) - 1] = 1
        return self.mul(a, Degree(0, b.scale * self.denominator_bits, 0, inverse))

    def neg(self, a: Degree) -> Degree:
        return a

    def function(self, node: Expr, args: Sequence[Degree]) -> Degree:
        """Return the degree in units of a sine or a root, and 1 for an uninterpreted function: an independent value."""
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])
        if node.op is Op.SQRT and node.args[0].op is Op.CONSTANT:
            return Degree(0, float(self.needs.denominator.bit_length()) + 64, 1)
        if node.op is Op.SQRT:  # a formal root: weighed like its radicand, it stays above all its conjugates
            radicand = self.total(args[0])
            return Degree(radicand.numerator, radicand.bits)
        self.hashed += [self.total(arg).numerator for arg in args]
        if node.op in (Op.SIN, Op.COS):
            form = node.args[0].linear_form()
            degree = abs(form.constant) * self.needs.radian
            degree += sum(abs(coefficient) for _, coefficient in form.terms) * self.needs.atom
            turned = any(atom.op is Op.ATAN2 for atom, _ in form.terms)  # x + i y may stand for it
            whole = self.total(args[0]) if turned else Degree(1)
            return Degree(int(degree * whole.numerator), self.denominator_bits + degree * whole.bits, 1)
        if node.op is Op.ATAN2:
            y, x = map(self.total, args)
            return Degree(max(1, y.numerator, x.numerator), max(y.bits, x.bits) + 1)
        return Degree(1)

    def total(self, a: Degree) -> Degree:
        """Return the bounds with everything multiplied out; degrees count twice, as exponents have either sign."""
        degree, bits = self._lifted(a, UNDIVIDED, a.scale)
        for k, e in a.below.items():
            degree += abs(e) * self.divisors[k].numerator
            bits += abs(e) * self.divisors[k].bits
        return Degree(2 * degree, bits)

    def _lifted(self, a: Degree, below: dict[int, int], scale: int) -> tuple[int, float]:
        """Return degree and bits of the numerator when the denominator is raised to `below` and D^scale."""
        degree, bits = a.numerator, a.bits + (scale - a.scale) * self.denominator_bits
        if below is a.below:
            return degree, bits
        for k, e in below.items():
            spare = e - a.below.get(k, 0)
            degree += spare * self.divisors[k].numerator
            bits += spare * self.divisors[k].bits
        return degree, bits


@dataclass(frozen=True)
class Bound:
    """How sure agreement makes us."""

    degree: int  # of a difference of two sides, multiplied out, and of all that a function or an angle hashes
    height: float  # log2 of the norm of its coefficients

    def error_log10(self, needs: Needs, primes: int, points: int) -> float:
        """Return log10 of the probability that two different functions agree everywhere.

        Over each prime: it divides all coefficients (there are at most height / log2(p) such primes, among all that
        could have been drawn), or all points are zeros of the difference (degree / p each, Schwartz 1980, Zippel 1979).
        """
        low = needs.lowest_bit
        candidates = low * log10(2) - log10(low * log(2)) - log10(needs.order) - len(needs.radicands) * log10(2)
        unlucky = log10(max(self.height, 1.0) / low * UNEVENNESS) - candidates
        zeros = points * (log10(max(self.degree, 1)) - low * log10(2))
        return primes * min(0.0, log10(10**unlucky + 10**zeros))


def bound(left: Sequence[Expr], right: Sequence[Expr], needs: Needs) -> Bound:
    """Return the bound for the differences left[i] - right[i]."""
    return Bounds(needs).of(left, right)


class Bounds:
    """Bounds of many differences: what was found of a node is kept, and a divisor of several of them is one."""

    def __init__(self, needs: Needs) -> None:
        self._algebra = Degrees(needs)
        self._known: dict[Expr, Degree] = {}
        self._below: dict[Expr, int] = {}  # bit k: list k of `_hashed` is of a node below
        self._hashed: list[list[int]] = []

    def of(self, left: Sequence[Expr], right: Sequence[Expr]) -> Bound:
        """Return the bound for the differences left[i] - right[i]."""
        algebra, wanted = self._algebra, self._algebra.needs
        both = zip(self._evaluated(left), self._evaluated(right), strict=True)
        totals = [algebra.total(algebra.sub(a, b)) for a, b in both]
        hashed = [degree for side in (left, right) for degree in self._hashed_below(side)]
        collisions = len(hashed) ** 2 * max(hashed, default=0)
        degree = max((total.numerator for total in totals), default=0) + collisions
        height = max((total.bits for total in totals), default=0.0) * wanted.order  # the norm to the rationals
        return Bound(degree, height)

    def _evaluated(self, outputs: Sequence[Expr]) -> list[Degree]:
        self.look(reachable(outputs, self._known))
        return [self._known[node] for node in outputs]

    def look(self, order: Sequence[Expr]) -> None:
        """Find the bounds of nodes, each behind its arguments."""
        algebra, known, below = self._algebra, self._known, self._below
        apply = arithmetic(algebra)
        for node in order:
            if node in known:
                continue
            op, args = node.op, [known[arg] for arg in node.args]
            under = 0
            for arg in node.args:
                under |= below[arg]
            if op in apply:
                known[node] = apply[op](*args)
            elif op is Op.SYMBOL:
                known[node] = Degree(1)
            elif op is Op.CONSTANT:
                known[node] = algebra.constant(node.value)  # type: ignore[arg-type]
            elif op is Op.PI:
                known[node] = algebra.pi()
            else:
                algebra.hashed = []
                known[node] = algebra.function(node, args)
                if algebra.hashed:
                    under |= 1 << len(self._hashed)
                    self._hashed.append(algebra.hashed)
            below[node] = under

    def _hashed_below(self, outputs: Sequence[Expr]) -> list[int]:
        under = 0
        for node in outputs:
            under |= self._below[node]
        return [degree for k, degrees in enumerate(self._hashed) if under >> k & 1 for degree in degrees]


MAX_DRAWS = 200
SPREAD = (2.0, 8.0, 64.0, 1024.0)  # widths of the ranges that numerical points are drawn from, one after the other
KEPT = 40  # points that are kept, of fields and of numbers; claims with few roots are looked at fewer
HELD = 300_000  # values that are kept at all points together; with more all are forgotten, for the sake of memory


class FirstPoints:
    """The first points that are drawn over all fields, which hardly ever are unlucky: looked at together."""

    def __init__(self, needs: Needs, primes: Sequence[int], seeds: Sequence[Sequence[int]]) -> None:
        """Start without values; `seeds` are those of point j of every prime, for each j."""
        fields = [[FiniteField(p, seed, needs) for p, seed in zip(primes, row, strict=True)] for row in seeds]
        self._points = ManyPoints(fields, symbol_value, FiniteField.function_at)
        self._most = HELD // (len(primes) * len(seeds))

    @property
    def places(self) -> list[tuple[FiniteField, int, int]]:
        """Every field with the numbers of its point and of its prime, prime by prime."""
        fields = self._points.fields
        return [(fields[j][k], j, k) for k in range(len(fields[0])) for j in range(len(fields))]

    def values(self, outputs: Sequence[Expr]) -> list[tuple[int, ...]]:
        """Return the values of nodes of one graph; Redraw where a point is unlucky."""
        if len(self._points.known) > self._most:
            self._points.known.clear()
        return self._points.values(outputs)

    def look(self, order: Sequence[Expr]) -> None:
        """Find the values of nodes, each behind its arguments, up to where a point is unlucky."""
        if len(order) <= self._most:
            with suppress(Redraw):
                self._points.evaluate(order)

    def at(self, values: Sequence[tuple[int, ...]], j: int, k: int) -> list[int]:
        return [self._points.at(value, j, k) for value in values]


class FieldPoints:
    """Points over finite fields."""

    def __init__(self, needs: Needs) -> None:
        """Start without points; `needs` is what all claims need."""
        self._wanted = needs
        self._known: dict[tuple[int, int], tuple[FiniteField, dict[Expr, int]]] = {}

    def values(
        self, sides: Sequence[Sequence[Expr]], prime: int, seed: int, signs: int = 0
    ) -> tuple[FiniteField, list[list[int]]]:
        """Return the field of a prime with the point of a seed, and the values there of each of `sides`.

        Bit j of `signs` turns the sign of the j-th variable root; what is not usual is not kept.

        Raises:
            Redraw: the point is unlucky.
        """
        if signs:
            other, fresh = FiniteField(prime, seed, self._wanted, signs), dict[Expr, int]()
            return other, [field_values(side, other, fresh) for side in sides]
        field, known = self._known.get((prime, seed)) or (FiniteField(prime, seed, self._wanted), {})
        if len(self._known) < KEPT:
            self._known[prime, seed] = field, known
        _forget([values for _, values in self._known.values()])
        return field, [field_values(side, field, known) for side in sides]


def _forget(known: Collection[dict[Expr, Any]]) -> None:
    if sum(map(len, known)) > HELD:
        for values in known:
            values.clear()


def field_values(outputs: Sequence[Expr], field: FiniteField, known: dict[Expr, int] | None = None) -> list[int]:
    """Return the values of nodes of one graph at the point of a field; `known` ones are added to.

    Raises:
        Redraw: the point is unlucky.
    """
    known = {} if known is None else known
    rng, order = random.Random(), reachable(outputs, known)
    for node in order:
        if node.op is Op.SYMBOL and node not in known:
            rng.seed(f"{field.seed}:{node.value}")
            known[node] = rng.randrange(field.p)
    return field.evaluate(outputs, known, order)


class NumberPoints:
    """Points in numbers: they come as pairs x and -x, in ever wider ranges, at last all positive."""

    def __init__(self, algebra: RealBalls, positive: Collection[str]) -> None:
        """Start without points; symbols named in `positive` are never drawn negative."""
        self.algebra = algebra
        self._positive = positive
        self._known: dict[int, dict[Expr, Any]] = {}

    def values(self, outputs: Sequence[Expr], draw: int) -> list[Any]:
        """Return the values of nodes of one graph at a point.

        Raises:
            ValueError, ZeroDivisionError, OverflowError: they are not real there.
        """
        known = self._known.setdefault(draw, {}) if draw < KEPT else {}
        _forget(self._known.values())
        order = reachable(outputs, known)
        known |= {node: self._drawn(node, draw) for node in order if node.op is Op.SYMBOL and node not in known}
        return evaluate(outputs, self.algebra, known, order, known)

    def _drawn(self, symbol: Expr, draw: int) -> Any:
        rng = random.Random(f"{draw // 2}:{symbol.value}")
        signed = draw < MAX_DRAWS // 2 and symbol.value not in self._positive
        sign = rng.choice((-1, 1)) * (-1) ** draw if signed else 1
        width = SPREAD[draw // 8 % len(SPREAD)]
        return self.algebra.number(sign * rng.uniform(0.25, width))


MOST = 7  # roots of one claim: 128 points are drawn for one at which all exist
MOST_SIGNED = 3  # roots of one claim that are looked at with all their signs
SPARE = 40  # points beyond the least number: independent roots are missed with probability 2^-40

Evaluate = Callable[[Sequence[Expr], FiniteField], list[int]]


def radicands(outputs: Sequence[Expr]) -> list[Expr] | None:
    """Return what stands under the variable roots of one graph; None for the root of a negative number."""
    under = [node.args[0] for node in reachable(outputs) if node.op is Op.SQRT]
    if any(isinstance(one.value, Fraction) and one.value < 0 for one in under):
        return None
    return [one for one in under if not isinstance(one.value, Fraction)]


@dataclass(frozen=True)
class Roots:
    """The variable roots of a claim: how many are different, and with how many choices of signs it must hold."""

    count: int
    signs: int


def signed(sides: Sequence[Sequence[Expr]], fields: Iterator[FiniteField], evaluate: Evaluate) -> Roots | None:
    """Return what is known of the radicands of a claim; None if they are too many.

    Args:
        sides: radicands, those of one graph together.
        fields: fields of one prime, each with its own random point.
        evaluate: values at the point of a field.
    """
    if not any(sides):
        return Roots(0, 1)
    rows: list[list[int]] = []
    wanted = sum(map(len, sides)) + SPARE
    for field in fields:
        try:
            row = [value for side in sides for value in evaluate(side, field)]
        except Redraw:
            continue
        if all(row):
            rows.append([*row, field.p])
        if len(rows) == wanted:
            break
    columns = list(dict.fromkeys(zip(*(row[:-1] for row in rows), strict=True)))  # equal functions are one
    if len(rows) < wanted or len(columns) > MOST:
        return None
    p = rows[0][-1]
    patterns = [sum((pow(c[k], (p - 1) // 2, p) != 1) << j for j, c in enumerate(columns)) for k in range(wanted)]
    spanned = _rank([pattern ^ patterns[0] for pattern in patterns])
    signs, within = 1 << len(columns), any(radicands(side) for side in sides if side)
    if spanned == len(columns) and not within:
        return Roots(len(columns), 1)
    return Roots(signs - 1 if within else len(columns), signs) if len(columns) <= MOST_SIGNED else None


def _rank(vectors: Sequence[int]) -> int:
    """Return the rank over GF(2) of vectors written as bits."""
    basis: list[int] = []
    for vector in vectors:
        rest = vector
        for row in basis:
            rest = min(rest, rest ^ row)
        if rest:
            basis.append(rest)
    return len(basis)


def conjugated(bound: Bound, roots: int) -> Bound:
    """Return the bound of the product of all conjugates, at points that are one of 2^roots."""
    return Bound(bound.degree << (2 * roots), bound.height * 2**roots)
