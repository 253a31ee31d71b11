"""Expressions as they stand in a file: a graph without identities, since numbers of a computer have few.

x / x is not 1 where x is zero, and (a + b) - b is not a: whatever a file says is an operation, though algebra has none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.graph import Expr, Graph, Op, Scalar, reachable


class Verbatim(Graph):
    """A graph that keeps every operation; minus a constant alone is a constant."""

    def add(self, a: Expr, b: Expr) -> Expr:
        """Return a + b."""
        return self.node(Op.ADD, a, b)

    def sub(self, a: Expr, b: Expr) -> Expr:
        """Return a - b."""
        return self.node(Op.SUB, a, b)

    def mul(self, a: Expr, b: Expr) -> Expr:
        """Return a b."""
        return self.node(Op.MUL, a, b)

    def div(self, a: Expr, b: Expr) -> Expr:
        """Return a / b; a zero below is found where values are taken."""
        return self.node(Op.DIV, a, b)

    def neg(self, a: Expr) -> Expr:
        """Return -a."""
        return super().neg(a) if a.op is Op.CONSTANT else self.node(Op.NEG, a)

    def function(self, op: Op, *args: Scalar) -> Expr:
        """Return op(args)."""
        return self.node(op, *map(self.lift, args))


def verbatim(outputs: Sequence[Expr], replaced: Mapping[Expr, Expr], graph: Verbatim) -> list[Expr]:
    """Return nodes of another graph with all their operations, leaves `replaced` or as they are."""
    found = dict(replaced)
    for node in reachable(outputs, found):
        if node in found:
            continue
        if node.op is Op.SYMBOL:
            found[node] = graph.symbol(str(node.value))
        elif node.op is Op.CONSTANT:
            found[node] = graph.lift(node.value)  # type: ignore[arg-type]  # a fraction
        else:
            found[node] = graph.node(node.op, *(found[one] for one in node.args))
    return [found[node] for node in outputs]
