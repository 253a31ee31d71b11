"""Signs: a negation ends in the difference that it negates.

    -(a - b) = b - a          -(x (a - b)) = x (b - a)          -((a - b) / x) = (b - a) / x

wherever the difference is used nowhere else. All other signs are settled when a node is born: those of operands of a
sum turn + into -, those of factors move out of the product.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from symdyn.graph import Expr, Graph, Op
from symdyn.program.passes.rebuild import use_counts

DIV, MUL, NEG, SUB = Op.DIV, Op.MUL, Op.NEG, Op.SUB  # see `Op`


def signs(entries: Sequence[Expr], graph: Graph, parameters: Collection[str] = ()) -> list[Expr]:
    """Return the entries of one function on `graph`, negations gone that a difference can take.

    Where no difference can take one, the entries stay where they are.
    """
    uses = use_counts(entries)
    turned: set[Expr] = set()
    for node in uses:
        if node.op is NEG:
            turned.update(_path(node.args[0], uses))
    if not turned:
        return list(entries)
    new: dict[Expr, Expr] = {}
    for node in uses:
        args = [new[arg] for arg in node.args]
        if node.op is SUB and node in turned:
            new[node] = graph.sub(args[1], args[0])
        elif node.op is NEG and node.args[0] in turned:
            new[node] = args[0]
        else:
            new[node] = graph.copy(node, args)
    return [new[entry] for entry in entries]


def _path(node: Expr, uses: Mapping[Expr, int]) -> list[Expr]:
    """Return the nodes that change sign when the sign of `node` moves into a difference below it; [] if it cannot."""
    path = []
    while uses[node] == 1:
        path.append(node)
        if node.op is SUB:
            return path
        inner = [arg for arg in node.args if uses[arg] == 1 and arg.op in (SUB, MUL, DIV)]
        if node.op not in (MUL, DIV) or not inner:
            return []
        node = inner[0]
    return []
