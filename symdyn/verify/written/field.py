"""Fields in which every function is uninterpreted: a random value of its own for whatever it is taken of.

What is equal there is equal whatever the functions are. The certificate's own fields know sines and roots, since two
derivations may write them differently; a file writes the functions of its program as they are. The primes are those of
a certificate without divided angles.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from hashlib import blake2b
from math import lcm

from symdyn.algebra import FiniteField, ManyPoints, Needs, Redraw
from symdyn.graph import Expr, Op, Piecewise, evaluate, reachable

PRIMES = POINTS = 2
MAX_DRAWS = 200

Operation = tuple[int, ...]
"""Which operation, and of what."""


def symbol_value(field: FiniteField, name: str) -> int:
    """Return a random value, the same for all symbols of a name."""
    return random.Random(f"{field.seed}:{name}").randrange(field.p)


class Uninterpreted(FiniteField):
    """A field at one point; the seed draws symbols and functions."""

    def function(self, node: Expr, args: Sequence[int]) -> int:
        table = (node.value.numbers,) if isinstance(node.value, Piecewise) else ()
        key = repr((self.seed, int(node.op), *args, *table)).encode()
        return int.from_bytes(blake2b(key, digest_size=32).digest(), "big") % self.p

    def values(self, outputs: Sequence[Expr]) -> tuple[int, ...]:
        """Return the values of nodes of one graph; Redraw where one is not defined at this point."""
        order = reachable(outputs)
        symbols = {node: symbol_value(self, str(node.value)) for node in order if node.op is Op.SYMBOL}
        return tuple(evaluate(outputs, self, symbols, order))

    def operation(self, op: Op, values: Sequence[int]) -> Operation:
        """Return an operation as rounding knows it: a + b is b + a, and -(-a - b); a b is (-b) a."""
        if op in (Op.ADD, Op.SUB):
            a, b = values[0], values[1] if op is Op.ADD else -values[1] % self.p
            return Op.ADD, *min(sorted((a, b)), sorted((-a % self.p, -b % self.p)))
        if op in (Op.MUL, Op.DIV):
            sizes = [min(one, self.p - one) for one in values]
            return op, *(sorted(sizes) if op is Op.MUL else sizes)
        return op, *values


def denominator(outputs: Iterable[Expr]) -> int:
    """Return the common denominator of the constants below some nodes."""
    return lcm(1, *(node.value.denominator for node in reachable(outputs) if isinstance(node.value, Fraction)))


class Everywhere:
    """Nodes at two points over each of two primes: their values, and their operations, each looked at once."""

    def __init__(self, fields: Sequence[Sequence[Uninterpreted]]) -> None:
        """Start without values; `fields` are those of point j of every prime, for each j."""
        self._first = fields[0][0]
        self._points = ManyPoints(fields, symbol_value, lambda field, node, args, _: field.function(node, args))
        self._operations: dict[Expr, Operation] = {}

    def values(self, outputs: Sequence[Expr]) -> list[tuple[int, ...]]:
        """Return the values of nodes of one graph; Redraw where one is not defined at one of the points."""
        return self._points.values(outputs)

    def operations(self, outputs: Sequence[Expr]) -> frozenset[Operation]:
        """Return all operations below nodes of one graph, by the values they are of at the first point.

        Whatever the sign of the result. The nodes have values.
        """
        found = self._operations
        below = [node for node in reachable(outputs) if node.args and node.op is not Op.NEG]
        for node in below:
            if node not in found:
                values = [self._points.at(self._points.known[one], 0, 0) for one in node.args]
                found[node] = self._first.operation(node.op, values)
        return frozenset([found[node] for node in below])


def everywhere(outputs: Sequence[Expr], seed: int) -> Everywhere:
    """Return fields at points where all `outputs` are defined, two points over each of two primes.

    Raises:
        Redraw: there are no such points.
    """
    wanted = Needs(1, 1, 1, (), denominator(outputs))
    primes = [wanted.prime(seed + k) for k in range(PRIMES)]

    def drawn(prime: int, draws: int) -> Iterator[Uninterpreted]:
        return (Uninterpreted(prime, seed * MAX_DRAWS + draw, wanted) for draw in range(draws))

    first = Everywhere(list(zip(*(drawn(prime, POINTS) for prime in primes), strict=True)))
    try:
        first.values(outputs)
    except Redraw:
        defined = [_defined(outputs, drawn(prime, MAX_DRAWS)) for prime in primes]
        return Everywhere(list(zip(*defined, strict=True)))
    return first


def _defined(outputs: Sequence[Expr], fields: Iterable[Uninterpreted]) -> list[Uninterpreted]:
    """Return the first fields at whose points nodes are defined."""
    found = []
    for field in fields:
        try:
            field.values(outputs)
        except Redraw:
            continue
        found.append(field)
        if len(found) == POINTS:
            return found
    raise Redraw
