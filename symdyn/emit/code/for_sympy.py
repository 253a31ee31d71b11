"""Graphs as Python for SymPy, which importing takes longer than writing a lesson."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from fractions import Fraction

from symdyn.algebra import NAMES
from symdyn.emit.code.operators import OPERATORS, PRODUCT, SIGN, Printer, Spelling, call
from symdyn.graph import Expr, Op


class _Powers(Printer):
    """Writes a product of equal factors as a power."""

    def _written(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        if node.op is not Op.MUL:
            return super()._written(node, names, constants)
        pieces: list[str] = []
        for factor, count in Counter(_factors(node, names)).items():
            text, binds = self._bound(factor, names, constants)
            bare = binds > SIGN if pieces or count > 1 else binds >= PRODUCT
            pieces.append((text if bare else f"({text})") + (f"**{count}" if count > 1 else ""))
        return "*".join(pieces), PRODUCT


def _factors(node: Expr, names: Mapping[Expr, str]) -> Iterator[Expr]:
    if node.op is Op.MUL and node not in names:
        for arg in node.args:
            yield from _factors(arg, names)
    else:
        yield node


SYMPY = _Powers(
    {
        **OPERATORS,
        **{op: call(name, 2 if op is Op.ATAN2 else 1) for op, name in NAMES.items()},
        Op.PI: Spelling("pi"),
        Op.NEG: Spelling("-{}", SIGN, (PRODUCT,)),
    },
    lambda value: str(value) if value.denominator == 1 else f"Rational({value.numerator}, {value.denominator})",
)
"""A product of equal factors is a power, a fraction a `Rational`."""
