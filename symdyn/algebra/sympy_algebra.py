"""Expressions as SymPy's, numbers exact; SymPy is imported when one is asked for."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from symdyn.graph import ELEMENTARY, Arithmetic, Expr, Op, Piecewise, evaluate, reachable

NAMES: Mapping[Op, str] = {
    **{op: op.name.lower() for op in (*ELEMENTARY, Op.SIGN, Op.ATAN2)},
    Op.ABS: "Abs",
    Op.POW: "Pow",
}


class SympyAlgebra(Arithmetic):
    """SymPy expressions as an algebra; numbers stay exact."""

    def __init__(self) -> None:
        import sympy

        self.sympy = sympy

    def constant(self, value: Fraction) -> Any:
        return self.sympy.Rational(value.numerator, value.denominator)

    def pi(self) -> Any:
        return self.sympy.pi

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])
        if node.op is not Op.SELECT:
            return getattr(self.sympy, NAMES[node.op])(*args)
        guard, a, b = args
        if guard in (a - b, b - a):
            return (self.sympy.Max if guard == a - b else self.sympy.Min)(a, b)
        return self.sympy.Piecewise((a, guard > 0), (b, True))

    def symbol(self, name: str, assumptions: Mapping[str, bool]) -> Any:
        """Return a real symbol, with what else is known of it."""
        return sympy_symbol(name, {"real": True, **assumptions})


def sympy_symbol(name: str, assumptions: Mapping[str, bool]) -> Any:
    r"""Return a symbol; a rate, such as x_dot, equals that of SymPy and is printed with its dots: \dot{x}."""
    import sympy

    return (_rate_symbol() if RATE.fullmatch(name) else sympy.Symbol)(name, **assumptions)


RATE = re.compile(r"(?P<of>[^\W_]+?)(?P<index>(_?\d+)?(_\w+)?)_(?P<dots>d?dot)")
"""A rate, x_dot or q1_ddot, to which SymPy writes dots where they end its letter: xdot, qddot_1."""


@cache
def _rate_symbol() -> Any:
    """Return a class that equals SymPy's Symbol, as SymPy compares classes and their names, but for how it is shown."""
    import sympy

    of_sympy = sympy.Symbol
    same = {"__eq__": lambda one, other: other is one or other is of_sympy, "__hash__": lambda one: hash(of_sympy)}

    def shown(self: Any, printer: Any, **style: str) -> Any:
        letter, index, dots = RATE.fullmatch(self.name).group("of", "index", "dots")  # type: ignore[union-attr]
        told = of_sympy(f"{letter}{dots}{index and '_'}{index.removeprefix('_')}")
        return (printer._settings.get("symbol_names") or {}).get(self) or printer._print_Symbol(told, **style)

    def pickled(self: Any) -> Any:
        return sympy_symbol, (self.name, dict(self._assumptions_orig))

    own = {"__slots__": (), "__reduce__": pickled, "_latex": shown, "_pretty": shown}
    return type("Rate", (type(of_sympy),), same)("Symbol", (of_sympy,), own)


def graph_to_sympy(outputs: Sequence[Expr], positive: Sequence[str] = ()) -> list[Any]:
    """Return nodes of one graph as SymPy expressions in real symbols, those that are called so positive."""
    algebra = SympyAlgebra()
    return evaluate(outputs, algebra, _symbols(reachable(outputs), algebra, positive))


def _symbols(nodes: Iterable[Expr], algebra: SympyAlgebra, positive: Sequence[str]) -> dict[Expr, Any]:
    names = {node: str(node.value) for node in nodes if node.op is Op.SYMBOL}
    return {x: algebra.symbol(name, {"positive": True} if name in positive else {}) for x, name in names.items()}


def shared_to_sympy(
    outputs: Sequence[Expr], positive: Sequence[str], names: Iterator[str], longest: int
) -> tuple[list[tuple[Any, Any]], list[Any]]:
    """Return what nodes share, each by a symbol of its own, and the nodes in SymPy, as `sympy.cse` does.

    Args:
        outputs: nodes of one graph.
        positive: as of `graph_to_sympy`.
        names: of what is shared, in the order in which it is defined.
        longest: operations, all written out, up to which nothing is shared.
    """
    algebra, order = SympyAlgebra(), reachable(outputs)
    length, uses = dict[Expr, int](), Counter(outputs)
    for node in order:
        length[node] = 1 + sum(length[one] for one in node.args)
        uses.update(node.args)
    shares = sum(length[one] for one in outputs) > longest
    values, defined = _symbols(order, algebra, positive), list[tuple[Any, Any]]()
    for node in order:
        (found,) = evaluate([node], algebra, values, [node], known=values)
        if shares and uses[node] > 1 and length[node] > SHORT:
            values[node] = algebra.symbol(next(names), {})
            defined.append((values[node], found))
    return defined, [values[node] for node in outputs]


SHORT = 3
"""Nodes of what gets no name of its own: a product of two, a sine."""
