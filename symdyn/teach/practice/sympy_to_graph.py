"""What a student writes in SymPy, as a node of a graph."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from symdyn.algebra import NAMES
from symdyn.errors import TeachError
from symdyn.graph import Expr, Graph, Op


def sympy_to_graph(expression: Any, graph: Graph, coordinates: Sequence[str]) -> Expr:
    """Return a SymPy expression as a node: symbols by name, q(t) as q, its derivatives as q_dot and q_ddot.

    Args:
        expression: of SymPy, or a number.
        graph: where the node shall live.
        coordinates: the functions of t that it may hold.

    Raises:
        TeachError: something in it has no meaning on a graph; the message says what.
    """
    import sympy

    functions = {getattr(sympy, name): op for op, name in NAMES.items() if op is not Op.SQRT}
    made: dict[Any, Expr] = {}

    def power(base: Expr, exponent: Any) -> Expr:
        if not (exponent.is_Rational and exponent.q in (1, 2)):
            raise TeachError(f"a power of {exponent} has no place here; exponents are whole numbers and halves")
        found = (base if exponent.q == 1 else graph.sqrt(base)) ** abs(int(exponent.p))
        return found if exponent.p > 0 else graph.one / found

    def node(x: Any) -> Expr:
        if x.is_Symbol:
            return graph.symbol(x.name)
        if x.is_Rational or x.is_Float:
            return graph.constant(Fraction(str(x)))
        if x is sympy.pi:
            return graph.pi
        moving = x.expr if x.is_Derivative else x
        if isinstance(moving, sympy.core.function.AppliedUndef) and moving.func.__name__ in coordinates:
            order = x.derivative_count if x.is_Derivative else 0
            if order <= 2:
                return graph.symbol(f"{moving.func.__name__}{('', '_dot', '_ddot')[order]}")
        args = [made[arg] for arg in x.args] if not x.is_Derivative and all(arg in made for arg in x.args) else []
        if x.is_Add:
            return graph.total(args)
        if x.is_Mul:
            product = graph.one
            for arg in args:
                product = product * arg
            return product
        if x.is_Pow:
            return power(args[0], x.exp)
        if x.func is sympy.tan:
            return graph.sin(args[0]) / graph.cos(args[0])
        if x.func in functions and args:
            return graph.function(functions[x.func], *args)
        raise TeachError(f"{x} has no meaning here; write it in the letters of the scene")

    def visit(x: Any) -> None:
        if x in made:
            return
        if not x.is_Derivative and not isinstance(x, sympy.core.function.AppliedUndef):
            for arg in x.args:
                visit(arg)
        made[x] = node(x)

    whole = sympy.sympify(expression)
    visit(whole)
    return made[whole]
