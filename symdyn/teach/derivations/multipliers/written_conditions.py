"""Nodes of conditions in print: in sines and in roots that have letters of their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from symdyn.algebra import Compactor, Form, Polynomial, TrigonometricRing, with_added_angles
from symdyn.dynamics import angle_groups
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, substitute

if TYPE_CHECKING:
    from symdyn.teach.derivations.multipliers.constrained import Constrained


class Writer:
    """What writes nodes of conditions: as polynomials in sines, as they stand where they are none."""

    def __init__(self, lesson: Constrained, nodes: Sequence[Expr]) -> None:
        """Make a ring wide enough for the nodes."""
        self.rooted = {x: lesson.graph.symbol(symbol.name) for x, symbol in lesson.roots.items()}
        parallel, state = angle_groups(lesson.scene, lesson.graph, across=True), (*lesson.state.q, *lesson.state.qd)
        state = tuple(dict.fromkeys((*state, *(x for some in lesson.directions for x in some))))
        self.radicands: dict[Expr, Form] = {}
        units = [*lesson.spheres, *lesson.directions]
        self.ring: TrigonometricRing | None = None
        self.squares: list[tuple[int, Polynomial]] = []
        try:
            ring = TrigonometricRing(self._plain([*nodes, *state]), state, parallel, units)
            self.ring, self.compact = ring, Compactor(ring, parallel)
            self.squares = [(ring.symbol(self.rooted[root]), self.polynomial(p)) for root, p in lesson.squares.items()]
            self.radicands = {root: self.short(self.polynomial(root.args[0])) for root in self.rooted}
            for root, symbol in self.rooted.items():
                if root not in lesson.squares:
                    ring.relate_square(ring.symbol(symbol), self.polynomial(root.args[0]))
            for node in nodes:
                self.polynomial(node)
        except DerivationError:
            self.ring = None

    def polynomial(self, node: Expr) -> Polynomial:
        """Return a node as an element of the ring."""
        assert self.ring is not None, "there is a ring"
        (plain,) = self._plain([node])
        return self.reduced(evaluate([plain], self.ring, self.ring.values([plain]))[0])

    def reduced(self, polynomial: Polynomial) -> Polynomial:
        """Return an element with ±p for √p², and nothing that is divided by what it is multiplied by."""
        assert self.ring is not None, "there is a ring"
        for w, p in self.squares:
            polynomial = self.ring.replaced(polynomial, w, p)
        return polynomial

    def __call__(self, node: Expr) -> Form:
        """Return the form of a node."""
        return Form.of(node) if self.ring is None else self.short(self.polynomial(node))

    def short(self, polynomial: Polynomial) -> Form:
        """Return the form of an element of the ring."""
        return with_added_angles(self.compact(polynomial))

    def _plain(self, nodes: Sequence[Expr]) -> list[Expr]:
        return substitute(nodes, self.rooted)
