"""Whether a function is zero everywhere, by its values over a finite field.

A value that is not zero proves that the function is not: where it vanishes at random points of a field of more than
2^126 elements, it vanishes identically, but for a chance of about degree / 2^126 a point (see
`symdyn.algebra.finite_field`). So a pivot that is x - x in disguise is told from one that only looks complicated, which
neither its shape nor doubles can do.
"""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from symdyn.algebra import FiniteField, Needs, Redraw
from symdyn.graph import Expr, Graph, Op, reachable

POINTS = 2
"""Points at which a function that is zero everywhere is seen to be."""

DRAWS = 40
"""Points that are tried until every root under the function exists in the field."""

_TOPIC = "zero everywhere"


def vanishes(node: Expr) -> bool:
    """Tell whether a node is zero for all values of its symbols, wherever it has one.

    What has no value at any point that is tried (a root that exists nowhere in the field) is not called zero.
    """
    if node.is_zero or node.op in (Op.CONSTANT, Op.PI, Op.SYMBOL):
        return node.is_zero
    known = node.graph.found.setdefault(_TOPIC, {})
    if node not in known:
        values = _points(node.graph).values(node)
        known[node] = next(values, 1) == 0 and next(values, 1) == 0
    return bool(known[node])


def _points(graph: Graph) -> _Points:
    """Return the points of a graph, which keep the values that are known there."""
    kept: dict[Expr, _Points] = graph.found.setdefault("points of a field", {})
    if graph.zero not in kept:
        kept[graph.zero] = _Points()
    return kept[graph.zero]


class _Points:
    """Points of one field, with the values of nodes there; begun anew where nodes need more of the field."""

    def __init__(self) -> None:
        """Start without values."""
        self._needs = Needs.of(())
        self._begin()

    def _begin(self) -> None:
        self._prime = self._needs.prime(1)
        self._at: list[tuple[FiniteField, dict[Expr, int]]] = []

    def values(self, node: Expr) -> Iterator[int]:
        """Yield the values of a node at up to POINTS points where it has one."""
        self._meet(node)
        seen = 0
        for k in range(DRAWS):
            if k == len(self._at):
                self._at.append((FiniteField(self._prime, k, self._needs), {}))
            try:
                yield self._value(node, *self._at[k])
            except Redraw:
                continue
            seen += 1
            if seen == POINTS:
                return

    def _meet(self, node: Expr) -> None:
        """Take a field that offers what the node needs."""
        known = self._at[0][1] if self._at else {}
        if not _offers(self._needs, Needs.of(reachable([node], known))):
            self._needs = Needs.of(reachable([node, *known]))
            self._begin()

    @staticmethod
    def _value(node: Expr, field: FiniteField, known: dict[Expr, int]) -> int:
        rng, order = Random(), reachable([node], known)
        for one in order:
            if one.op is Op.SYMBOL and one not in known:
                rng.seed(f"{field.seed}:{one.value}")
                known[one] = rng.randrange(field.p)
        return field.evaluate([node], known, order)[0]


def _offers(have: Needs, want: Needs) -> bool:
    """Tell whether a field for some needs will do for others."""
    divides = have.turn % want.turn == 0 and have.radian % want.radian == 0 and have.atom % want.atom == 0
    return divides and set(want.radicands) <= set(have.radicands)
