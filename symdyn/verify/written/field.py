"""Fields in which every function is uninterpreted: a random value of its own for whatever it is taken of.

What is equal there is equal whatever the functions are. The certificate's own fields know sines and roots, since two
derivations may write them differently; a file writes the functions of its program as they are. The primes are those of
a certificate without divided angles.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from fractions import Fraction
from hashlib import blake2b
from math import lcm

from symdyn.algebra.finite_field import FiniteField, Needs, Redraw, draw_prime
from symdyn.graph import Expr, Op, evaluate, reachable

PRIMES = POINTS = 2
MAX_DRAWS = 200

Operation = tuple[int, ...]
"""Which operation, and of what."""

Values = tuple[tuple[int, ...], ...]
"""What entries are at every point of every field, a tuple a point."""


class Uninterpreted(FiniteField):
    """A field at one point; the seed draws symbols and functions."""

    def function(self, node: Expr, args: Sequence[int]) -> int:
        """Return a random value."""
        key = repr((self.seed, int(node.op), *args)).encode()
        return int.from_bytes(blake2b(key, digest_size=32).digest(), "big") % self.p

    def symbol(self, name: str) -> int:
        """Return a random value, the same for all symbols of a name."""
        return random.Random(f"{self.seed}:{name}").randrange(self.p)

    def values(self, outputs: Sequence[Expr]) -> tuple[int, ...]:
        """Return the values of nodes of one graph.

        Raises:
            Redraw: one is not defined at this point.
        """
        return tuple(evaluate(outputs, self, *self._known(outputs)))

    def operations(self, outputs: Sequence[Expr]) -> frozenset[Operation]:
        """Return all operations below nodes of one graph, by the values they are of, whatever the sign of the result.

        Raises:
            Redraw: one is not defined at this point.
        """
        known, order = self._known(outputs)
        evaluate(outputs, self, known, order, known)
        return frozenset(
            self._operation(node.op, [known[one] for one in node.args])
            for node in order
            if node.args and node.op is not Op.NEG
        )

    def _operation(self, op: Op, values: Sequence[int]) -> Operation:
        """Return an operation as rounding knows it: a + b is b + a, and -(-a - b); a b is (-b) a."""
        if op in (Op.ADD, Op.SUB):
            a, b = values[0], values[1] if op is Op.ADD else -values[1] % self.p
            return Op.ADD, *min(sorted((a, b)), sorted((-a % self.p, -b % self.p)))
        if op in (Op.MUL, Op.DIV):
            sizes = [min(one, self.p - one) for one in values]
            return op, *(sorted(sizes) if op is Op.MUL else sizes)
        return op, *values

    def _known(self, outputs: Sequence[Expr]) -> tuple[dict[Expr, int], list[Expr]]:
        """Return the values of the symbols below, and the order of evaluation."""
        order = reachable(outputs)
        return {node: self.symbol(str(node.value)) for node in order if node.op is Op.SYMBOL}, order


def denominator(outputs: Iterable[Expr]) -> int:
    """Return the common denominator of the constants below some nodes."""
    return lcm(1, *(node.value.denominator for node in reachable(outputs) if isinstance(node.value, Fraction)))


def points(outputs: Sequence[Expr], seed: int) -> tuple[tuple[Uninterpreted, ...], Values]:
    """Return fields at points where all `outputs` are defined, two points over each of two primes, and their values.

    Raises:
        Redraw: there are no such points.
    """
    wanted = Needs(1, 1, 1, (), denominator(outputs))
    found = []
    for k in range(PRIMES):
        prime = draw_prime(seed + k, wanted)
        fields = (Uninterpreted(prime, seed * MAX_DRAWS + draw, wanted) for draw in range(MAX_DRAWS))
        for _ in range(POINTS):
            found.append(_next(outputs, fields))
    return tuple(field for field, _ in found), tuple(values for _, values in found)


def _next(outputs: Sequence[Expr], fields: Iterable[Uninterpreted]) -> tuple[Uninterpreted, tuple[int, ...]]:
    for field in fields:
        try:
            return field, field.values(outputs)
        except Redraw:
            continue
    raise Redraw
