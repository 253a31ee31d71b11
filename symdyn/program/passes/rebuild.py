"""What a pass needs: how often a node is used, and what is known early."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from symdyn.graph import Expr, Graph, Op, reachable

NEG, SYMBOL = Op.NEG, Op.SYMBOL  # see `Op`


def use_counts(entries: Sequence[Expr]) -> dict[Expr, int]:
    """Return how many operations and entries use each node; a sign is no operation, its operand is used in its place.

    The nodes come arguments first.
    """
    needed = reachable(entries)
    uses = dict.fromkeys(needed, 0)
    for entry in entries:
        uses[entry] += 1
    for node in reversed(needed):
        more = uses[node] if node.op is NEG else 1
        for arg in node.args:
            uses[arg] += more
    return uses


class Early:
    """Tells which nodes of a growing graph are known early: constants and what depends on early symbols alone."""

    def __init__(self, graph: Graph, symbols: Collection[str]) -> None:
        """Start with an empty graph or a full one; `symbols` are names."""
        self._nodes = graph.nodes
        self._symbols = frozenset(symbols)
        self._known: list[bool] = []

    def __contains__(self, node: Expr) -> bool:
        """Tell whether a node of the graph is known early."""
        known = self._known
        while len(known) <= node.index:
            new = self._nodes[len(known)]
            known.append(new.value in self._symbols if new.op is SYMBOL else all(known[a.index] for a in new.args))
        return known[node.index]
