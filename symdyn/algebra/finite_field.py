"""GF(p): where two graphs are proved equal as functions.

Two rational functions that agree at random points of a large field are equal, up to a probability of about
degree / p a point (Schwartz 1980, Zippel 1979). What is not rational is made so:

    angle x      a random unit e of the field stands for exp(i x): sums of angles are products of units, a multiple of
                 π is a root of unity, and cos x = (e + 1/e)/2, sin x = (e - 1/e)/(2i) with i = sqrt(-1) in GF(p).
                 The unit of an atom is drawn from a hash of the atom's value, so it is independent of the value (q and
                 sin q may stand in one formula) and the same in every graph; that of atan2(y, x) is x + i y where
                 x² + y² = 1.
    sqrt n       for a constant n: a product of roots of coprime factors of all such n. Roots of primes that divide the
                 order of the root of unity are Gauss sums of it, so that 2 sin(π/4) = sqrt(2) holds here too. The sign
                 of any other root is free: changing it is an automorphism, which no identity notices.
    sqrt x       otherwise: has no sign to choose by here; `verify` says which are looked at.
    x^y          xⁿ times what is uninterpreted of x and the rest of a constant exponent y, 0 ≤ y - n < 1.
    select       t a + (1 - t) b, where t is uninterpreted of c, and 1 - t of -c: what differs at c = 0 alone is equal.
    exp, tanh, … uninterpreted: a random value that depends on the function and on its argument's value.

Primes are p ≡ 1 modulo a multiple of 5040 and of the denominators of the scene's multiples of π, so that all those
roots exist; they have 127 bits, and more where angles are divided finely.

Several points of several fields take one walk through a graph. By the Chinese remainder theorem a number mod p₁ p₂ … is
one of each field, and +, -, × and ÷ of such numbers are those of all fields: point j of all primes is one number, a
node's value one for each j. What is no field operation (sines, roots, what is uninterpreted) is asked of each field.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from math import floor, isqrt, lcm, prod
from random import Random

from flint import fmpz

from symdyn.algebra.generators import coprime_base
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import SMALL_PRIMES, Expr, Op, Piecewise, evaluate, reachable

BITS = 127  # enough that few of the primes drawn from divide the coefficients of any scene
SPARE_BITS = 24  # so that the primes drawn are random ones
FACTORED_BITS = 128  # 0.02 s
ROOT_ORDER = 5040  # 2^4 3^2 5 7: i, sqrt(2), sqrt(3), sqrt(5), sqrt(7) and the usual sines


class Redraw(Exception):  # noqa: N818  a signal, not an error
    """The point is unlucky (a zero divisor, a root that does not exist); draw another one."""


@dataclass(frozen=True)
class Needs:
    """What a field must offer for a set of graphs.

    Attributes:
        turn: common denominator of the multiples of π in angles.
        radian: common denominator of the rational constants in angles.
        atom: common denominator of the coefficients of everything else in angles.
        radicands: pairwise coprime numbers, no squares, of which all constants under roots are products, ascending.
        denominator: common denominator of the constants; a prime must not divide it.
    """

    turn: int
    radian: int
    atom: int
    radicands: tuple[int, ...]
    denominator: int

    @property
    def order(self) -> int:
        """Order of the root of unity that gives i, the sines of multiples of π, and the roots of small primes."""
        return lcm(ROOT_ORDER, 2 * self.turn)

    @staticmethod
    def of(nodes: Iterable[Expr]) -> Needs:
        """Return what a finite field must offer so that all of `nodes` can be run over it; `reachable` gives them.

        Raises:
            DerivationError: there is an angle π/n whose n cannot be factored in reasonable time.
        """
        turn = radian = atom = 1
        radicands: dict[int, None] = {}
        denominator = 1
        for node in nodes:
            if node.op is Op.CONSTANT:
                denominator = lcm(denominator, node.value.denominator)  # type: ignore[union-attr]
            if isinstance(node.value, Piecewise):
                denominator = lcm(denominator, node.value.denominator)
            if node.op in (Op.SIN, Op.COS):
                form = node.args[0].linear_form()
                turn = lcm(turn, form.turns.denominator)
                radian = lcm(radian, form.constant.denominator)
                atom = lcm(atom, *(coefficient.denominator for _, coefficient in form.terms))
            if node.op is Op.SQRT and node.args[0].op is Op.CONSTANT:
                radicands[_radicand(node.args[0])] = None
        order = lcm(ROOT_ORDER, 2 * turn)
        _check_order(order)
        return Needs(turn, radian, atom, coprime_base(radicands, order), denominator)

    @property
    def lowest_bit(self) -> int:
        """K such that primes are drawn from 2^k … 2^(k+1): of 127 bits, of more where angles are divided finely."""
        fineness = self.radian.bit_length() + self.atom.bit_length() - 2
        return max(BITS - 1 + fineness, self.order.bit_length() + SPARE_BITS)

    def prime(self, seed: int) -> int:
        """Return a random prime over which every root that is needed exists; the same seed, the same prime."""
        floor, step = 1 << self.lowest_bit, self.order
        candidate = floor - floor % step + 1 + step * (_hash(seed, "prime") % (floor // step))
        while not self.denominator % (found := _next_prime(candidate, step, self.radicands)):
            candidate = found + step
        return found


@lru_cache(maxsize=4096)  # every proof about one scene asks for the same
def _next_prime(candidate: int, step: int, radicands: tuple[int, ...]) -> int:
    """Return the first prime in steps from a candidate on over which the radicands have roots."""
    while not (fmpz(candidate).is_prime() and all(_is_square(n, candidate) for n in radicands)):
        candidate += step
    return candidate


class FiniteField:
    """The field of p elements as an algebra; values are ints in 0 .. p - 1."""

    def __init__(self, prime: int, seed: int, needs: Needs, signs: int = 0) -> None:
        """Prepare the field.

        Args:
            prime: from `wanted.prime`.
            seed: of the uninterpreted functions and of the units that stand for angles.
            needs: needs of all graphs that will be compared.
            signs: bit j turns the sign of the root of the j-th value of which one is taken, constants left out.
        """
        self.p, self.seed, self.needs = prime, seed, needs
        self._order = needs.order
        self._root = _root_of_unity(prime, self._order)
        self._i = pow(self._root, self._order // 4, prime)
        self._half = (prime + 1) // 2
        self._signs = signs
        self._rooted: dict[int, int] = {}
        self._radicals = {n: self._radical(n) for n in needs.radicands}

    def constant(self, value: Fraction) -> int:
        """Return numerator / denominator mod p."""
        return value.numerator * pow(value.denominator, -1, self.p) % self.p

    def pi(self) -> int:
        """Return a random element: outside angles, π is an independent transcendental."""
        return _hash(self.seed, "pi") % self.p

    def add(self, a: int, b: int) -> int:
        return (a + b) % self.p

    def sub(self, a: int, b: int) -> int:
        return (a - b) % self.p

    def mul(self, a: int, b: int) -> int:
        return a * b % self.p

    def div(self, a: int, b: int) -> int:
        """Return a / b; raise Redraw if b is zero."""
        if not b:
            raise Redraw
        return a * pow(b, -1, self.p) % self.p

    def neg(self, a: int) -> int:
        return -a % self.p

    def function(self, node: Expr, args: Sequence[int]) -> int:
        """Return node.op(args); raise Redraw if a root does not exist at this point."""
        if node.op in (Op.SIN, Op.COS):
            raise TypeError("angles need the values of their atoms; use evaluate")
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])
        if node.op is Op.SQRT:
            return self._square_root(node.args[0], args[0])
        if node.op is Op.POW and node.args[1].op is Op.CONSTANT:
            return self._power(args[0], node.args[1].value)  # type: ignore[arg-type]
        if node.op is Op.SELECT:
            guard, a, b = args if 2 * args[0] <= self.p else (self.p - args[0], args[2], args[1])
            return (b + self._opaque(node.op, guard) * (a - b)) % self.p
        return self._opaque(node.op, *args)

    def _opaque(self, op: Op, *args: object) -> int:
        return _hash(self.seed, op.name, *args) % self.p

    def _power(self, x: int, exponent: Fraction) -> int:
        whole = floor(exponent)
        if not x and whole < 0:
            raise Redraw
        rest = self._opaque(Op.POW, x, exponent - whole) if whole != exponent else 1
        return pow(x, whole, self.p) * rest % self.p

    def circular(self, op: Op, unit: int) -> int:
        """Return the sine or cosine of the angle that `unit` stands for."""
        inverse = pow(unit, -1, self.p)
        if op is Op.COS:
            return (unit + inverse) * self._half % self.p
        return (inverse - unit) * self._half * self._i % self.p  # 1/i = -i

    def unit(self, angle: Expr, values: Mapping[Expr, int]) -> int:
        """Return the unit that stands for exp(i angle), given the values of the nodes before it."""
        form = angle.linear_form()
        unit = pow(self._root, int(form.turns * (self._order // 2)), self.p)
        if form.constant:
            base = self._draw_unit("radian")
            unit = unit * pow(base, int(form.constant * self.needs.radian), self.p) % self.p
        for node, coefficient in form.terms:
            if node.op is Op.ATAN2 and coefficient.denominator == 1:
                y, x = (values[arg] for arg in node.args)
                if (x * x + y * y) % self.p == 1:
                    unit = unit * pow(x + self._i * y, int(coefficient), self.p) % self.p
                    continue
            base = self._draw_unit("atom", values[node])
            unit = unit * pow(base, int(coefficient * self.needs.atom), self.p) % self.p
        return unit

    def evaluate(
        self, outputs: Sequence[Expr], values: dict[Expr, int], order: Sequence[Expr] | None = None
    ) -> list[int]:
        """Return the values of `outputs` at a point: `symdyn.graph.differentiate`, with sines from their angles' atoms.

        Every node that is computed is added to `values`, and none computed again.

        Raises:
            Redraw: the point is unlucky.
        """
        return evaluate(outputs, _AtPoint(self, values), values, order, values)

    def function_at(self, node: Expr, args: Sequence[int], values: Mapping[Expr, int]) -> int:
        """Return the value of a function, a sine from its angle's atoms, whose `values` are known.

        Raises:
            Redraw: the point is unlucky.
        """
        if node.op in (Op.SIN, Op.COS):
            return self.circular(node.op, self.unit(node.args[0], values))
        return self.function(node, args)

    def _draw_unit(self, *key: object) -> int:
        return _hash(self.seed, "unit", *key) % (self.p - 1) + 1

    def _square_root(self, radicand: Expr, value: int) -> int:
        if radicand.op is Op.CONSTANT:
            assert isinstance(radicand.value, Fraction)
            root, rest = pow(radicand.value.denominator, -1, self.p), _radicand(radicand)
            for factor, radical in self._radicals.items():
                while rest % factor == 0:
                    rest //= factor
                    root = root * radical % self.p
            square = isqrt(rest)
            assert square * square == rest, "the coprime base misses a radicand"
            return root * square % self.p
        if not _is_square(value, self.p):
            raise Redraw
        root = int(fmpz(value).sqrtmod(fmpz(self.p))) if value else 0
        turned = self._signs >> self._rooted.setdefault(value, len(self._rooted)) & 1
        return -root % self.p if turned else root

    def _radical(self, n: int) -> int:
        """Return a square root of n: a Gauss sum where n is a prime that divides the order of the root of unity."""
        if n == 2:
            eighth = pow(self._root, self._order // 8, self.p)
            return 2 * self.circular(Op.COS, eighth) % self.p
        if self._order % n:
            return int(fmpz(n).sqrtmod(fmpz(self.p)))
        zeta = pow(self._root, self._order // n, self.p)  # Σ ζ^(k²) = sqrt(n), or i sqrt(n) for n ≡ 3 (mod 4)
        gauss = sum(pow(zeta, k * k % n, self.p) for k in range(n))
        return (gauss if n % 4 == 1 else -self._i * gauss) % self.p


class _AtPoint:
    """A field in which angles are known: sines and cosines are those of the units that stand for them."""

    def __init__(self, field: FiniteField, values: dict[Expr, int]) -> None:
        self._field, self._values = field, values
        self._units: dict[Expr, int] = {}
        self.constant, self.pi, self.add, self.sub = field.constant, field.pi, field.add, field.sub
        self.mul, self.div, self.neg = field.mul, field.div, field.neg

    def function(self, node: Expr, args: Sequence[int]) -> int:
        if node.op not in (Op.SIN, Op.COS):
            return self._field.function(node, args)
        angle = node.args[0]
        if angle not in self._units:
            self._units[angle] = self._field.unit(angle, self._values)
        return self._field.circular(node.op, self._units[angle])


def _hash(*key: object) -> int:
    return Random(repr(key)).getrandbits(256)  # the same in every process; hashlib would load OpenSSL


def _is_square(n: int, p: int) -> bool:
    return n % p == 0 or pow(n, (p - 1) // 2, p) == 1


@lru_cache(64)
def _root_of_unity(p: int, order: int) -> int:
    """Return an element of exact multiplicative order `order`, which divides p - 1."""
    factors = [prime for prime, _ in fmpz(order).factor()]
    base = 2
    while True:
        root = pow(base, (p - 1) // order, p)
        if all(pow(root, order // int(prime), p) != 1 for prime in factors):
            return root
        base += 1


def _check_order(order: int) -> None:
    """Raise DerivationError for an order of which too much is left after division by small primes."""
    rest = order
    for prime in SMALL_PRIMES:
        while rest % prime == 0:
            rest //= prime
    if rest.bit_length() > FACTORED_BITS:
        raise DerivationError(
            f"the angles are multiples of pi/n, and n has a factor of {rest.bit_length()} bits that no small prime "
            f"divides; at most {FACTORED_BITS} bits are factored, without which no zero is told from what is small: "
            "write such an angle as a decimal"
        )


def _radicand(node: Expr) -> int:
    """Return numerator · denominator of a constant, whose root times 1/denominator is the constant's root."""
    value = node.value
    assert isinstance(value, Fraction)
    assert value >= 0, "the root of a negative constant is no number of any scene"
    return value.numerator * value.denominator


Residues = tuple[int, ...]
"""A value at all points: number j is that of point j of every prime."""


class ManyPoints:
    """Values of nodes at points (prime, j); what is computed once is kept."""

    def __init__(
        self,
        fields: Sequence[Sequence[FiniteField]],
        symbol: Callable[[FiniteField, str], int],
        function: Callable[[FiniteField, Expr, Sequence[int], Mapping[Expr, int]], int],
    ) -> None:
        """Start without values.

        Args:
            fields: those of point j of every prime, in the order of the primes, for each j.
            symbol: value of a symbol of this name in a field.
            function: value of a node that is no field operation, for those of its arguments and of the nodes before it.
        """
        self.fields = fields
        self.known: dict[Expr, Residues] = {}
        self._symbol, self._function = symbol, function
        primes = [field.p for field in fields[0]]
        self.modulus = prod(primes)
        rests = [self.modulus // p for p in primes]
        self._units = [rest * pow(rest, -1, p) for rest, p in zip(rests, primes, strict=True)]

    def at(self, value: Residues, j: int, k: int) -> int:
        return value[j] % self.fields[j][k].p

    def values(self, outputs: Sequence[Expr]) -> list[Residues]:
        """Return the values of nodes of one graph; Redraw where a point is unlucky."""
        self.evaluate(reachable(outputs, self.known))
        return [self.known[node] for node in outputs]

    def evaluate(self, order: Sequence[Expr]) -> None:
        """Add the values of nodes, each behind its arguments; Redraw where a point is unlucky."""
        known, m = self.known, self.modulus
        for node in order:
            if node in known:
                continue
            op, args = node.op, node.args
            if op is Op.MUL:
                known[node] = tuple([x * y % m for x, y in zip(known[args[0]], known[args[1]], strict=True)])
            elif op is Op.ADD:
                known[node] = tuple([(x + y) % m for x, y in zip(known[args[0]], known[args[1]], strict=True)])
            elif op is Op.SUB:
                known[node] = tuple([(x - y) % m for x, y in zip(known[args[0]], known[args[1]], strict=True)])
            elif op is Op.NEG:
                known[node] = tuple([-x % m for x in known[args[0]]])
            elif op is Op.DIV:
                known[node] = tuple([self._quotient(*both) for both in zip(*map(known.get, args), strict=True)])
            else:
                known[node] = self._each(node)

    def _quotient(self, a: int, b: int) -> int:
        try:
            return a * pow(b, -1, self.modulus) % self.modulus
        except ValueError:  # zero in one of the fields
            raise Redraw from None

    def _each(self, node: Expr) -> Residues:
        """Return the value of a leaf or of a function, asked of every field."""
        return tuple(
            sum(unit * self._one(node, j, k) for k, unit in enumerate(self._units)) % self.modulus
            for j in range(len(self.fields))
        )

    def _one(self, node: Expr, j: int, k: int) -> int:
        field = self.fields[j][k]
        if node.op is Op.CONSTANT:
            return field.constant(node.value)  # type: ignore[arg-type]
        if node.op is Op.PI:
            return field.pi()
        if node.op is Op.SYMBOL:
            return self._symbol(field, str(node.value))
        there = _There(self, j, k)
        return self._function(field, node, [there[arg] for arg in node.args], there)


class _There(Mapping[Expr, int]):
    """The values of all nodes at one point."""

    def __init__(self, points: ManyPoints, j: int, k: int) -> None:
        self._points, self._j, self._k = points, j, k

    def __getitem__(self, node: Expr) -> int:
        return self._points.at(self._points.known[node], self._j, self._k)

    def __iter__(self) -> Iterator[Expr]:
        return iter(self._points.known)

    def __len__(self) -> int:
        return len(self._points.known)
