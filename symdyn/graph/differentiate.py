"""Automatic differentiation on the graph, forward and reverse, and substitution. The results are exact nodes.

Forward: ẏ = Σ ∂y/∂x ẋ, one sweep for one direction of all inputs (a time derivative, a column of a Jacobian).
Reverse: x̄ = Σ ∂y/∂x ȳ, one sweep for all partial derivatives of one output (a gradient).

∂y/∂x are a node's derivatives by its operands, or by what `turns` reads in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from symdyn.graph.evaluate import reachable
from symdyn.graph.expression import Expr, Graph
from symdyn.graph.ops import Op

Partials = Callable[..., tuple[Expr, ...]]

PARTIALS: dict[Op, Partials] = {  # z = op(x, y)  ->  (dz/dx, dz/dy)
    Op.ADD: lambda z, x, y: (z.graph.one, z.graph.one),
    Op.SUB: lambda z, x, y: (z.graph.one, -z.graph.one),
    Op.MUL: lambda z, x, y: (y, x),
    Op.DIV: lambda z, x, y: (1 / y, -z / y),
    Op.NEG: lambda z, x: (-z.graph.one,),
    Op.SIN: lambda z, x: (z.graph.cos(x),),
    Op.COS: lambda z, x: (-z.graph.sin(x),),
    Op.SQRT: lambda z, x: (1 / (2 * z),),
    Op.EXP: lambda z, x: (z,),
    Op.LOG: lambda z, x: (1 / x,),
    Op.TANH: lambda z, x: (1 - z * z,),
    Op.ABS: lambda z, x: (z.graph.function(Op.SIGN, x),),
    Op.SIGN: lambda z, x: (z.graph.zero,),  # away from the jump
    Op.ATAN2: lambda z, y, x: (x / (x * x + y * y), -y / (x * x + y * y)),
}

Slopes = Callable[[Expr], Iterable[tuple[Expr, Expr]]]
"""Gives pairs of a node that another one is made of, and the derivative by that."""


def operands(node: Expr) -> Iterable[tuple[Expr, Expr]]:
    """Return the operands of a node, and its derivatives by them."""
    return zip(node.args, PARTIALS[node.op](node, *node.args), strict=True)


def tangents(outputs: Sequence[Expr], seeds: Mapping[Expr, Expr], slopes: Slopes = operands) -> list[Expr]:
    """Return ẏ of every output y along one direction: `seeds` are ẋ of the inputs that move, all others rest."""
    if not outputs:
        return []
    zero = outputs[0].graph.zero
    moving: dict[Expr, Expr] = {}
    for node in reachable(outputs):
        if node in seeds:
            moving[node] = seeds[node]
        elif any(arg in moving for arg in node.args):
            rate = zero
            for arg, partial in slopes(node):
                if arg in moving:
                    rate = rate + partial * moving[arg]
            if rate is not zero:
                moving[node] = rate
    return [moving.get(node, zero) for node in outputs]


def gradient(output: Expr, inputs: Sequence[Expr], slopes: Slopes = operands) -> list[Expr]:
    """Return the partial derivatives of one output with respect to `inputs`, shape (len(inputs),).

    >>> graph = Graph()
    >>> x, y = graph.symbol("x"), graph.symbol("y")
    >>> gradient(x * y, [x, y])
    [y, x]
    """
    graph = output.graph
    adjoint: dict[Expr, Expr] = {output: graph.one}
    wanted = set(inputs)
    nodes = reachable([output])
    moving: set[Expr] = set()
    for node in nodes:
        if node in wanted or any(arg in moving for arg in node.args):
            moving.add(node)
    for node in reversed(nodes):
        if node not in moving or node not in adjoint or node in wanted:
            continue
        for arg, partial in slopes(node):
            if arg in moving:
                adjoint[arg] = adjoint.get(arg, graph.zero) + adjoint[node] * partial
    return [adjoint.get(node, graph.zero) for node in inputs]


def substitute(outputs: Sequence[Expr], values: Mapping[Expr, Expr], graph: Graph | None = None) -> list[Expr]:
    """Return `outputs` with other nodes for some, rebuilt (and simplified at birth) in `graph`, else their own."""
    if not outputs:
        return []
    target = graph or outputs[0].graph
    known: dict[Expr, Expr] = {}
    for node in reachable(outputs):
        args = [known[arg] for arg in node.args]
        if node in values:
            known[node] = values[node]
        elif target is node.graph and all(new is old for new, old in zip(args, node.args, strict=True)):
            known[node] = node
        else:
            known[node] = target.copy(node, args)
    return [known[node] for node in outputs]
