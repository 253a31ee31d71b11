"""What entries cost at run time, in multiplications: the table by which formulations and passes are compared.

A sine and a cosine of one angle count as one pair. Negations are free: a sign moves into a neighbouring sum.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from symdyn.graph import Expr, Op, reachable

FREE = ""

CATEGORY: dict[Op, str] = {
    **dict.fromkeys((Op.CONSTANT, Op.PI, Op.SYMBOL, Op.NEG), FREE),
    **dict.fromkeys((Op.ADD, Op.SUB), "additions"),
    Op.MUL: "multiplications",
    Op.DIV: "divisions",
    **dict.fromkeys((Op.SIN, Op.COS), "sincos"),
    **dict.fromkeys((Op.SQRT, Op.EXP, Op.LOG, Op.TANH, Op.ABS, Op.SIGN), "others"),
    **dict.fromkeys((Op.ATAN2, Op.POW, Op.SELECT, Op.TABLE), "others"),
}

WEIGHTS = {"multiplications": 1, "additions": 1, "divisions": 4, "sincos": 20, "others": 20}
"""Cost of an operation in multiplications."""


def cost(entries: Iterable[Expr], state: Collection[Expr]) -> int:
    """Return the price of `entries`; what depends on parameters alone is free."""
    return sum(WEIGHTS[category] for category in operations(entries, state))


def operations(entries: Iterable[Expr], state: Collection[Expr]) -> Iterator[str]:
    """Yield the category of every operation that depends on the state; twice a number is an addition."""
    varying, angles = set(state), set[Expr]()
    for node in reachable(entries):
        if node in varying or varying.isdisjoint(node.args):
            continue
        varying.add(node)
        category = CATEGORY[node.op]
        if category == "sincos":
            if node.args[0] in angles:
                continue
            angles.add(node.args[0])
        elif node.op is Op.MUL and node.args[0].value == 2:
            category = "additions"
        if category:
            yield category
