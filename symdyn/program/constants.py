"""Values of nodes without symbols, such as sqrt(2)/2 or sin(37°), once and to many digits.

Each is computed at two precisions. Where these agree the value stands; where they do not, all digits have cancelled
and the constant is zero, which the graph could not see. A value that is a simple fraction to 80 digits is that
fraction, so that cos²(40°) + sin²(40°) no longer multiplies anything.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, evaluate, reachable

DIGITS = (50, 100)
AGREE = Fraction(1, 10**25)
SIMPLE = 10**6
SAME = Fraction(1, 10**80)


def constants(outputs: Sequence[Expr]) -> dict[Expr, Fraction]:
    """Return the value of every node below `outputs` that has no symbol below it, exact or to at least 50 digits.

    Raises:
        DerivationError: such a node is no finite real number.
    """
    known: dict[Expr, Fraction] = {}
    inexact: list[Expr] = []
    for node in reachable(outputs):
        if node.op is Op.CONSTANT:
            assert isinstance(node.value, Fraction), "a constant is a fraction"
            known[node] = node.value
        elif node.op is Op.PI or (node.args and all(arg in known for arg in node.args)):
            known[node] = Fraction(0)  # until it is computed below
            inexact.append(node)
    if inexact:
        rough, fine = (_values(inexact, digits) for digits in DIGITS)
        known.update({node: _settle(low, high) for node, low, high in zip(inexact, rough, fine, strict=True)})
    return known


def is_simple(value: Fraction) -> bool:
    """Return whether `value` is a fraction that a person could have written."""
    return value.denominator <= SIMPLE


def _settle(low: Fraction, high: Fraction) -> Fraction:
    """Return the value that two precisions tell: zero, a simple fraction, or the finer one."""
    if abs(high - low) > AGREE * abs(high):
        return Fraction(0)
    simple = high.limit_denominator(SIMPLE)
    return simple if abs(high - simple) <= SAME * abs(high) else high


def _values(nodes: Sequence[Expr], digits: int) -> list[Fraction]:
    """Return the nodes' values at one precision."""
    from symdyn.algebra.big import BigFloats

    try:
        return [_exact(value) for value in evaluate(nodes, BigFloats(digits), {})]
    except (ArithmeticError, ValueError, AttributeError) as fault:
        message = "a constant of the scene is not a finite real number; look for 1/0, sqrt or log of a negative number"
        raise DerivationError(message) from fault


def _exact(value: object) -> Fraction:
    """Return a big float as the fraction that it is; a complex one has no `_mpf_`, an infinite one no mantissa."""
    negative, mantissa, exponent, _ = value._mpf_  # type: ignore[attr-defined]
    if mantissa == 0 and exponent != 0:
        raise ValueError(f"{value} is not finite")
    size = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return -size if negative else size
