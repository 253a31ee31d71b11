"""Automatic differentiation on the graph, forward and reverse, and substitution. The results are exact nodes.

Forward: ẏ = Σ ∂y/∂x ẋ, one sweep for one direction of all inputs (a time derivative, a column of a Jacobian).
Reverse: x̄ = Σ ∂y/∂x ȳ, one sweep for all partial derivatives of one output (a gradient).

∂y/∂x are a node's derivatives by its operands, or by what `turns` reads in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from symdyn.graph.evaluate import reachable
from symdyn.graph.expression import Expr, Graph
from symdyn.graph.ops import ADD, CONSTANT, DIV, MUL, NEG, PI, SUB, SYMBOL, Op

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


def jacobian(
    outputs: Sequence[Expr], directions: Sequence[Mapping[Expr, Expr]], slopes: Slopes = operands
) -> list[dict[int, Expr]]:
    """Return what is not zero of ẏ of every output, by direction: `tangents` along many, of which few move a node.

    Directions are those of symbols.

    >>> graph = Graph()
    >>> x, y = graph.symbol("x"), graph.symbol("y")
    >>> jacobian([x * y, x], [{x: graph.one}, {y: graph.one}])
    [{0: y, 1: x}, {0: 1}]
    """
    moving: dict[Expr, dict[int, Expr]] = {}
    for k, seeds in enumerate(directions):
        for node, rate in seeds.items():
            moving.setdefault(node, {})[k] = rate
    inputs = set(moving)
    for node in reachable(outputs):
        if node in inputs or not any(arg in moving for arg in node.args):
            continue
        rates: dict[int, Expr] = {}
        for arg, partial in slopes(node):
            for k, rate in moving.get(arg, {}).items():
                rates[k] = rates[k] + partial * rate if k in rates else partial * rate
        rates = {k: rate for k, rate in rates.items() if not rate.is_zero}
        if rates:
            moving[node] = rates
    return [moving.get(node, {}) for node in outputs]


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


def copy_node(node: Expr, args: Sequence[Expr], graph: Graph) -> Expr:
    """Return the operation of `node` on `graph`, with other operands; it simplifies as at birth."""
    op = node.op
    if op is MUL:
        return graph.mul(*args)
    if op is ADD:
        return graph.add(*args)
    if op is SUB:
        return graph.sub(*args)
    if op is NEG:
        return graph.neg(*args)
    if op is DIV:
        return graph.div(*args)
    if op is CONSTANT:
        return graph.constant(node.value)  # type: ignore[arg-type]
    if op is SYMBOL:
        return graph.symbol(str(node.value))
    return graph.pi if op is PI else graph.function(op, *args)


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
            known[node] = copy_node(node, args, target)
    return [known[node] for node in outputs]
