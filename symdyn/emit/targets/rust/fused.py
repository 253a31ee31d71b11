"""A printer for languages that never fuse a product with a sum by themselves: sums of products call `fma`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from symdyn.emit.code.operators import ATOM, SIGN, Printer
from symdyn.graph import Expr, Op

FMA = "fma({}, {}, {})"
"""a b + c, which the file defines: rounded once where the machine does that."""


@dataclass(frozen=True)
class FusedPrinter(Printer):
    """Writes a b + c, a b - c and c - a b as a call of `fma`; of two products the right one is fused."""

    def _written(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        """Return the operation of `node` with its operands, and how tightly it binds."""
        if node.op not in (Op.ADD, Op.SUB):
            return super()._written(node, names, constants)
        free = [arg.op is Op.MUL and arg not in names and arg not in constants for arg in node.args]
        if not any(free):
            return super()._written(node, names, constants)
        left, right = node.args
        product, other = (right, left) if free[1] else (left, right)
        a, b = product.args
        bound = {x: self._bound(x, names, constants) for x in (a, b, other)}
        first, last = bound[a][0], bound[other][0]
        if node.op is Op.SUB and free[1]:
            first = _negative(*bound[a])
        elif node.op is Op.SUB:
            last = _negative(*bound[other])
        return FMA.format(first, bound[b][0], last), ATOM


def _negative(text: str, binds: int) -> str:
    """Return the text of the negative: a sign wants an atom, and two signs are none."""
    if binds == SIGN and text.startswith("-"):
        return text[1:]
    return f"-{text}" if binds == ATOM else f"-({text})"
