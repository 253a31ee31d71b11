"""Graphs as SymPy expressions, for users; SymPy is imported when one is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from symdyn.graph import Arithmetic, Expr, Op, evaluate, reachable

NAMES: Mapping[Op, str] = {
    Op.SIN: "sin",
    Op.COS: "cos",
    Op.SQRT: "sqrt",
    Op.EXP: "exp",
    Op.LOG: "log",
    Op.TANH: "tanh",
    Op.ABS: "Abs",
    Op.SIGN: "sign",
    Op.ATAN2: "atan2",
}


class SympyAlgebra(Arithmetic):
    """SymPy expressions as an algebra; numbers stay exact."""

    def __init__(self) -> None:
        """Import SymPy."""
        import sympy

        self.sympy = sympy

    def constant(self, value: Fraction) -> Any:
        """Return a Rational."""
        return self.sympy.Rational(value.numerator, value.denominator)

    def pi(self) -> Any:
        """Return pi."""
        return self.sympy.pi

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args)."""
        return getattr(self.sympy, NAMES[node.op])(*args)

    def symbol(self, name: str, assumptions: Mapping[str, bool]) -> Any:
        """Return a real symbol, with what else is known of it."""
        return self.sympy.Symbol(name, real=True, **assumptions)


def graph_to_sympy(outputs: Sequence[Expr], positive: Sequence[str] = ()) -> list[Any]:
    """Return nodes of one graph as SymPy expressions in real symbols, those that are called so positive."""
    algebra = SympyAlgebra()
    symbols = {}
    for node in reachable(outputs):
        if node.op is Op.SYMBOL:
            name = str(node.value)
            symbols[node] = algebra.symbol(name, {"positive": True} if name in positive else {})
    return evaluate(outputs, algebra, symbols)
