"""What tests ask of graphs: their leaves, what every one of them keeps, and exact rationals to run one over."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import ClassVar

from symdyn.graph import Arithmetic, Expr, Graph, Op
from symdyn.graph.ops import ARITY

LEAVES = frozenset({Op.CONSTANT, Op.PI, Op.SYMBOL})


class Fractions(Arithmetic):
    """Exact rationals; a graph with a sine, a root or π has no value here."""

    functions: ClassVar[dict[Op, Callable[[Fraction], Fraction]]] = {
        Op.ABS: abs,
        Op.SIGN: lambda x: Fraction((x > 0) - (x < 0)),
    }

    def constant(self, value: Fraction) -> Fraction:
        """Return the value itself."""
        return value

    def pi(self) -> Fraction:
        """Raise ArithmeticError: π is not rational."""
        raise ArithmeticError("pi is not rational; run the graph over mpmath or floats")

    def function(self, node: Expr, args: Sequence[Fraction]) -> Fraction:
        """Return |x| or sign x; raise ArithmeticError for any other function."""
        if node.op not in self.functions:
            raise ArithmeticError(f"{node.op.name.lower()} is not rational; run the graph over mpmath or floats")
        return self.functions[node.op](args[0])


def check_graph(graph: Graph) -> Graph:
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
