"""What every graph keeps, in the open: for tests, and for whoever adds an operation."""

from __future__ import annotations

from symdyn.graph.expression import Expr, Graph
from symdyn.graph.ops import ARITY, Op


def check(graph: Graph) -> Graph:
    """Return `graph` after asserting its invariants.

    Nodes know their place; arguments come before the node that uses them and live on the same graph; every operation
    has its number of arguments; only constants and symbols carry a value; no two nodes are the same.
    """
    seen: dict[tuple[object, ...], Expr] = {}
    for place, node in enumerate(graph.nodes):
        assert node.index == place, f"{node!r} does not know its place {place}"
        assert all(arg.graph is graph and arg.index < place for arg in node.args), f"#{place} uses a node after it"
        assert len(node.args) == ARITY[node.op], f"#{place}: {node.op.name} has {len(node.args)} arguments"
        assert (node.value is not None) == (node.op in (Op.CONSTANT, Op.SYMBOL)), f"#{place} has a value it should not"
        key = (node.op, node.value, *node.args)
        assert key not in seen, f"#{place} is #{seen[key].index} again"
        seen[key] = node
    return graph
