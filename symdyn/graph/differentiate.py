"""A graph run over an algebra, and its automatic differentiation, forward and reverse, and substitution.

One loop serves floats, batches, big floats, fields, polynomials and text. Derivatives are exact nodes.

Forward: ẏ = Σ ∂y/∂x ẋ, one sweep for one direction of all inputs (a time derivative, a column of a Jacobian).

Reverse: x̄ = Σ ∂y/∂x ȳ, one sweep for all partial derivatives of one output (a gradient).

∂y/∂x are a node's derivatives by its operands, or by what `turns` reads in it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from fractions import Fraction
from operator import attrgetter
from types import MappingProxyType
from typing import Any, Protocol, TypeVar, Union

from symdyn.graph.expression import Expr, Graph
from symdyn.graph.ops import Op

T = TypeVar("T")


class Algebra(Protocol[T]):
    """What a set of values must offer so that a graph can be run over it."""

    def constant(self, value: Fraction) -> T:
        """Return the value of an exact constant."""

    def pi(self) -> T:
        """Return the value of π."""

    def add(self, a: T, b: T) -> T:
        """Return a + b."""

    def sub(self, a: T, b: T) -> T:
        """Return a - b."""

    def mul(self, a: T, b: T) -> T:
        """Return a b."""

    def div(self, a: T, b: T) -> T:
        """Return a / b."""

    def neg(self, a: T) -> T:
        """Return -a."""

    def function(self, node: Expr, args: Sequence[T]) -> T:
        """Return node.op(args) for an operation of `FUNCTIONS`; the node itself tells an exact algebra its angle."""


class Arithmetic:
    """Field arithmetic by Python's operators; the numeric algebras share it."""

    def add(self, a: Any, b: Any) -> Any:
        return a + b

    def sub(self, a: Any, b: Any) -> Any:
        return a - b

    def mul(self, a: Any, b: Any) -> Any:
        return a * b

    def div(self, a: Any, b: Any) -> Any:
        return a / b

    def neg(self, a: Any) -> Any:
        return -a


def reachable(outputs: Iterable[Expr], known: Container[Expr] = ()) -> tuple[Expr, ...]:
    """Return every node that `outputs` need, arguments first; nothing below those that are `known`.

    What was asked last of a graph is kept with it: counts, passes and constants of one function ask the same in turn,
    and a graph that only grows has one answer for ever.
    """
    outputs = tuple(outputs)
    if known != () or not outputs:
        return _below(outputs, known)
    graph = outputs[0].graph
    last = graph.reached
    if last[0] != outputs:
        last = graph.reached = outputs, _below(outputs, known)
    return last[1]


def _below(outputs: tuple[Expr, ...], known: Container[Expr]) -> tuple[Expr, ...]:
    seen = set(outputs)
    stack = [node for node in seen if node not in known]
    while stack:
        for arg in stack.pop().args:
            if arg not in seen:
                seen.add(arg)
                if arg not in known:
                    stack.append(arg)
    return tuple(sorted(seen, key=attrgetter("index")))


def arithmetic(algebra: Any) -> dict[Op, Callable[..., Any]]:
    """Return the five operations of a field by name; `algebra` is whatever has `add`, `sub`, `mul`, `div`, `neg`."""
    return {
        Op.ADD: algebra.add,
        Op.SUB: algebra.sub,
        Op.MUL: algebra.mul,
        Op.DIV: algebra.div,
        Op.NEG: algebra.neg,
    }


def evaluate(
    outputs: Sequence[Expr],
    algebra: Algebra[T],
    values: Mapping[Expr, T],
    order: Sequence[Expr] | None = None,
    known: dict[Expr, T] | None = None,
) -> list[T]:
    """Return the values of `outputs` over `algebra`.

    Args:
        outputs: nodes of one graph.
        algebra: what to compute with.
        values: value of every symbol that is needed; a node given here is not computed.
        order: what `reachable` has given for these outputs, for those that evaluate them often; None asks it.
        known: where to keep the value of every node that is computed, those of `values` included; may be `values`.

    Raises:
        KeyError: a needed symbol has no value.
    """
    apply = arithmetic(algebra)
    known = dict(values) if known is None else known
    for node in reachable(outputs, values) if order is None else order:
        if node in known:
            continue
        op, args = node.op, node.args
        if op in apply:
            known[node] = apply[op](*[known[arg] for arg in args])
        elif op is Op.CONSTANT:
            known[node] = algebra.constant(node.value)  # type: ignore[arg-type]
        elif op is Op.PI:
            known[node] = algebra.pi()
        elif op is Op.SYMBOL:
            raise KeyError(f"symbol {node.value} has no value")
        else:
            known[node] = algebra.function(node, [known[arg] for arg in args])
    return [known[node] for node in outputs]


def repeated(
    outputs: Sequence[Expr],
    algebra: Algebra[T],
    key: Callable[[Expr], Any] = lambda symbol: symbol,
    fixed: Mapping[Expr, T] = MappingProxyType({}),
) -> Callable[[Mapping[Any, T]], list[T]]:
    """Return what gives the values of `outputs` over `algebra`, for those of symbols, as often as it is called.

    Constants and what depends on `fixed` alone are worked out here, and no node is looked up again. `key` tells what
    the other values are given by.
    """
    order, apply = reachable(outputs, fixed or ()), arithmetic(algebra)
    place = {node: k for k, node in enumerate(order)}
    start: list[Any] = [fixed.get(node) for node in order]
    symbols: list[tuple[int, Any]] = []
    steps: list[tuple[int, Callable[..., T], int, int]] = []
    more: dict[int, list[int]] = {}
    moving = set[Expr]()
    for k, node in enumerate(order):
        if node in fixed:
            continue
        if node.op is Op.CONSTANT:
            start[k] = algebra.constant(node.value)  # type: ignore[arg-type]
        elif node.op is Op.PI:
            start[k] = algebra.pi()
        elif node.op is Op.SYMBOL:
            moving.add(node)
            symbols.append((k, key(node)))
        else:
            step = apply.get(node.op) or functools.partial(_function, algebra, node)
            places = [place[arg] for arg in node.args]
            if moving.isdisjoint(node.args):
                start[k] = step(*[start[j] for j in places])
                continue
            moving.add(node)
            steps.append((k, step, places[0], places[1] if len(places) > 1 else -1))
            if len(places) > 2:
                steps[-1], more[k] = (k, step, 0, -2), places
    ends = [place[node] for node in outputs]

    def values_at(values: Mapping[Any, T]) -> list[T]:
        held = start.copy()
        for k, symbol in symbols:
            held[k] = values[symbol]
        for k, step, i, j in steps:
            if j >= -1:
                held[k] = step(held[i], held[j]) if j >= 0 else step(held[i])
            else:
                held[k] = step(*[held[place] for place in more[k]])
        return [held[k] for k in ends]

    return values_at


def _function(algebra: Algebra[T], node: Expr, *args: T) -> T:
    return algebra.function(node, args)


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
    Op.POW: lambda z, x, y: (y * z.graph.function(Op.POW, x, y - 1), z * z.graph.function(Op.LOG, x)),
    Op.TABLE: lambda z, x: (z.graph.lookup(z.value.derivative, x),),
    Op.SELECT: lambda z, c, a, b: (z.graph.zero, *(z.graph.function(Op.SELECT, c, k, 1 - k) for k in (1, 0))),
}

LocalPartials = Callable[[Expr], Iterable[tuple[Expr, Expr]]]
"""Gives pairs of a node that another one is made of, and the derivative by that."""


def operands(node: Expr) -> Iterable[tuple[Expr, Expr]]:
    """Return the operands of a node, and its derivatives by them."""
    return zip(node.args, PARTIALS[node.op](node, *node.args), strict=True)


Kept = Union[dict[Expr, Any], None]
"""What a call finds of every node, for the next one with the same values."""


def tangents(
    outputs: Sequence[Expr], seeds: Mapping[Expr, Expr], slopes: LocalPartials = operands, known: Kept = None
) -> list[Expr]:
    """Return ẏ of every output y along one direction: `seeds` are ẋ of the inputs that move, all others rest."""
    if not outputs:
        return []
    zero = outputs[0].graph.zero
    moving = {} if known is None else known
    for node in reachable(outputs, known or ()):
        if node in moving:
            continue
        rate = seeds.get(node)
        if rate is None and any(moving[arg] for arg in node.args):
            rate = zero
            for arg, partial in slopes(node):
                if (by := moving[arg]) is not None:
                    rate = rate + partial * by
        moving[node] = None if rate is zero and node not in seeds else rate
    return [moving[node] or zero for node in outputs]


def gradient(output: Expr, inputs: Sequence[Expr], slopes: LocalPartials = operands) -> list[Expr]:
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


def substitute(
    outputs: Sequence[Expr], values: Mapping[Expr, Expr], graph: Graph | None = None, known: Kept = None
) -> list[Expr]:
    """Return `outputs` with other nodes for some, rebuilt (and simplified at birth) in `graph`, else their own."""
    if not outputs:
        return []
    target = graph or outputs[0].graph
    before, known = known or (), {} if known is None else known
    for node in reachable(outputs, before):
        if node in known:
            continue
        args = tuple([known[arg] for arg in node.args])
        if node in values:
            known[node] = values[node]
        elif target is node.graph and args == node.args:
            known[node] = node
        else:
            known[node] = target.copy(node, args)
    for node, (name, given) in [*outputs[0].graph.found.get("tables", {}).items()]:
        if node in known and all(arg in known for arg in given):
            target.table(name, known[node], tuple(known[arg] for arg in given))
    return [known[node] for node in outputs]
