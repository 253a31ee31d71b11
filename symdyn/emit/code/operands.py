"""What stands in the text of a line: names of values, and operations that have no name of their own."""

from __future__ import annotations

from collections.abc import Container, Iterable

from symdyn.graph import Expr


def standing(nodes: Iterable[Expr], named: Container[Expr], known: Container[Expr]) -> list[Expr]:
    """Return the nodes that stand in the text of `nodes`, in order, as often as they do; not those that are `known`.

    A `named` node stands for itself, of any other one what it is computed from stands there, too.
    """
    found: list[Expr] = []
    stack = list(nodes)[::-1]
    while stack:
        node = stack.pop()
        if node in named:
            found.append(node)
        elif node not in known:
            found.append(node)
            stack += node.args[::-1]
    return found


def operands(nodes: Iterable[Expr], named: Container[Expr], known: Container[Expr]) -> tuple[Expr, ...]:
    """Return the named nodes that stand in the text of `nodes`, once each, in order."""
    return tuple(dict.fromkeys([node for node in standing(nodes, named, known) if node in named]))
