"""Reciprocals: many divisions by one divisor become one.

    x / d, y / d, z / d = r x, r y, r z with r = 1/d          from `WORTH` quotients on

This rounds twice where a division rounds once: at most 1.5 units in the last place instead of 0.5. It is not among the
default passes: forward dynamics of 6 and 7 axes took 1 % longer with it for one state, since a division is now followed
by a multiplication on the longest path, and 1 % less in a batch of 512-bit vectors.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from symdyn.graph import Expr, Graph, Op
from symdyn.program.passes.rebuild import copy_node, use_counts

WORTH = 3
"""Divisions by one divisor that are dearer than one division and as many multiplications, by far."""


def reciprocals(entries: Sequence[Expr], graph: Graph, parameters: Collection[str] = ()) -> list[Expr]:
    """Return the entries of one function on `graph`, fewer divisions in them."""
    uses = use_counts(entries)
    divided: dict[Expr, int] = {}
    for node in uses:
        if node.op is Op.DIV:
            divided[node.args[1]] = divided.get(node.args[1], 0) + 1
    new: dict[Expr, Expr] = {}
    for node in uses:
        args = [new[arg] for arg in node.args]
        if node.op is Op.DIV and divided[node.args[1]] >= WORTH:
            new[node] = graph.mul(graph.div(graph.one, args[1]), args[0])
        else:
            new[node] = copy_node(node, args, graph)
    return [new[entry] for entry in entries]
