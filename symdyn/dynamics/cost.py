"""What entries cost at run time, to choose between formulations: operations that depend on the state."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from symdyn.graph import Expr, Op, reachable

PRICE = {Op.ADD: 1, Op.SUB: 1, Op.MUL: 1, Op.DIV: 8, Op.SIN: 10, Op.COS: 10, Op.SQRT: 10}
"""Roughly, in additions; what is not listed is free."""


def cost(entries: Iterable[Expr], state: Collection[Expr]) -> int:
    """Return the price of `entries`; what depends on parameters alone is free."""
    varying = set(state)
    total = 0
    for node in reachable(entries):
        if node not in varying and any(arg in varying for arg in node.args):
            varying.add(node)
            total += PRICE.get(node.op, 0)
    return total
