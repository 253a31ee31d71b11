"""Nodes without coordinates in functions, as formulas to read: collected over the ring of closed forms."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra.form import ZERO, Form
from symdyn.dynamics.mechanism.exact import has_symbols, in_fractions
from symdyn.graph import FUNCTIONS, Expr, Op, evaluate, reachable


def formulas(values: Sequence[Expr], digits: int) -> list[Form]:
    """Return the values as formulas; zero is `Number(0)`.

    Numbers are exact, unless an angle among them has no exact sine (0.3 rad): then all are rounded to so many digits.

    Raises:
        DerivationError: a root has no place in that ring.
    """
    from symdyn.algebra.compact import Compactor
    from symdyn.algebra.trigonometric import TrigonometricRing

    odd = any(node.op in FUNCTIONS - {Op.SQRT} and not has_symbols(node) for node in reachable(values))
    values = in_fractions(values) if odd else values
    ring = TrigonometricRing(values)
    short, found = Compactor(ring), evaluate(values, ring, ring.values(values))
    if odd:
        found = [ring.in_digits(p, digits) for p in found]
    return [ZERO if ring.is_zero(p) else short(p) for p in found]


def vanishes(value: Expr) -> bool:
    """Tell whether a value is zero, though its node may not show it."""
    return value.is_zero or (value.op not in (Op.CONSTANT, Op.SYMBOL) and formulas([value], 1) == [ZERO])
