"""Operation counts, the currency in which formulations are compared.

A sine and a cosine of one angle count as one pair. Negations are free: a sign moves into a neighbouring sum. What has
no symbol below it is a constant and costs nothing at run time.
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics.equations import Function
from symdyn.graph import Expr, Op, reachable

FREE = ""

CATEGORY: dict[Op, str] = {
    Op.CONSTANT: FREE,
    Op.PI: FREE,
    Op.SYMBOL: FREE,
    Op.ADD: "additions",
    Op.SUB: "additions",
    Op.MUL: "multiplications",
    Op.DIV: "divisions",
    Op.NEG: FREE,
    Op.SIN: "sincos",
    Op.COS: "sincos",
    Op.SQRT: "others",
    Op.EXP: "others",
    Op.LOG: "others",
    Op.TANH: "others",
    Op.ABS: "others",
    Op.SIGN: "others",
    Op.ATAN2: "others",
}


@dataclass(frozen=True)
class Counts:
    """Operations of one call; additions include subtractions, sincos counts distinct angles."""

    multiplications: int = 0
    additions: int = 0
    divisions: int = 0
    sincos: int = 0
    others: int = 0

    def __str__(self) -> str:
        words = (
            f"{self.multiplications} mul",
            f"{self.additions} add",
            *(f"{number} {name}" for number, name in ((self.divisions, "div"), (self.sincos, "sincos")) if number),
            *(f"{self.others} other" for _ in range(bool(self.others))),
        )
        return ", ".join(words)


def count(function: Function) -> Counts:
    """Return the operations that one call of `function` takes, every shared subexpression computed once."""
    tally = dict.fromkeys(("multiplications", "additions", "divisions", "sincos", "others"), 0)
    angles: set[Expr] = set()
    varying: set[Expr] = set()
    for node in reachable(function.entries):
        if node.op is not Op.SYMBOL and not any(arg in varying for arg in node.args):
            continue
        varying.add(node)
        category = CATEGORY[node.op]
        if category == "sincos":
            angles.add(node.args[0])
        elif category:
            tally[category] += 1
    return Counts(**{**tally, "sincos": len(angles)})
