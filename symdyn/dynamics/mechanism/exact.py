"""Constants brought into the open: what is zero or a simple fraction after all, though the graph could not see it.

cos²(40°) + sin²(40°) is built as a sum of products; whether two axes are parallel must not depend on that. A constant
is computed at two precisions, as a program's constants are. What is taken for a fraction here enters one derivation
only, and the proof against the other one stands over it.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING

from symdyn.algebra import rounded
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, evaluate, reachable, substitute

if TYPE_CHECKING:
    from symdyn.algebra import BigFloats

DIGITS = 100
SIMPLE = 10**9
WHOLE_TURN = 1_296_000  # arc seconds
SAME = Fraction(1, 10**60)


def settle(nodes: Sequence[Expr]) -> list[Expr]:
    """Return the nodes, hidden fractions replaced by what they are."""
    hidden = [node for node in nodes if node.args and not has_symbols(node)]
    if not hidden:
        return list(nodes)
    settled = hidden[0].graph.found.setdefault("settled", {})
    fresh = [node for node in hidden if node not in settled]
    settled.update((node, _settled(node, value)) for node, value in zip(fresh, values_of(fresh), strict=True))
    return [settled.get(node, node) for node in nodes]


def values_of(nodes: Sequence[Expr]) -> list[Fraction]:
    """Return the values of nodes without symbols, to 100 digits where they are no fractions.

    Raises:
        DerivationError: a constant is no finite real number; so of all in this file.
    """
    known = [rational(node) for node in nodes]
    if None not in known:
        return [value for value in known if value is not None]
    seen = nodes[0].graph.found.setdefault("constants", {})
    try:
        fresh = reachable(nodes, seen)
        seen.update(zip(fresh, evaluate(fresh, _numbers(), seen), strict=True))
        return [_fraction(seen[node]) for node in nodes]
    except (ArithmeticError, ValueError, AttributeError) as fault:
        raise DerivationError("a constant of the scene's placements is no finite real number") from fault


def in_fractions(nodes: Sequence[Expr]) -> list[Expr]:
    """Return the nodes with every constant as a fraction: those that are none are rounded."""
    every = reachable(nodes)
    varying: set[Expr] = set()
    for node in every:
        if node.op is Op.SYMBOL or not varying.isdisjoint(node.args):
            varying.add(node)
    outermost = [*nodes, *(arg for node in every if node in varying for arg in node.args)]
    inexact = [x for x in dict.fromkeys(outermost) if x not in varying and rational(x) is None]
    if not inexact:
        return list(nodes)
    values = (x.graph.constant(rounded(value, DIGITS)) for x, value in zip(inexact, values_of(inexact), strict=True))
    return substitute(nodes, dict(zip(inexact, values, strict=True)))


def turns_of(cosine: Expr, sine: Expr) -> Fraction | None:
    """Return the angle with this cosine and sine, both numbers, in turns within ±1/2; None if it is no simple part."""
    context = _numbers().context
    c, s = (context.mpf(x.numerator) / x.denominator for x in values_of([cosine, sine]))
    turns = _fraction(context.atan2(s, c) / (2 * context.pi))
    simple = turns.limit_denominator(WHOLE_TURN)
    return simple if abs(simple - turns) <= SAME else None


@cache
def _numbers() -> BigFloats:
    """Return the one context of 100 digits; making one takes longer than using it."""
    from symdyn.algebra import BigFloats

    return BigFloats(DIGITS)


def rational(node: Expr) -> Fraction | None:
    """Return the value of a constant fraction, None for anything else."""
    return node.value if isinstance(node.value, Fraction) else None


def has_symbols(node: Expr) -> bool:
    """Return whether a node depends on anything."""
    seen = node.graph.found.setdefault("symbols", {})
    for inner in reachable([node], seen):
        seen[inner] = inner.op is Op.SYMBOL or any(seen[arg] for arg in inner.args)
    return bool(seen[node])


def _settled(node: Expr, value: Fraction) -> Expr:
    simple = value.limit_denominator(SIMPLE)
    return node.graph.constant(simple) if abs(simple - value) <= SAME else node


def _fraction(value: object) -> Fraction:
    """Return a big float as the fraction that it is; a complex one has no `_mpf_`, an infinite one no mantissa."""
    negative, mantissa, exponent, _ = value._mpf_  # type: ignore[attr-defined]
    if mantissa == 0 and exponent != 0:
        raise ValueError(f"{value} is not finite")
    size = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return -size if negative else size
