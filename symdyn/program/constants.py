"""Values of nodes without symbols, such as sqrt(2)/2 or sin(37°), once and to many digits.

Each is computed with a bound of its rounding error, at a precision that doubles until 50 digits stand. One that is
all rounding error even at 3200 digits is zero, which the graph could not see. A value that is a simple fraction to 80
digits is that fraction, so that cos²(40°) + sin²(40°) no longer multiplies anything.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, reachable
from symdyn.graph.ops import CONSTANT, PI

PRECISIONS = (110, 220, 800, 3200)
WANTED = Fraction(1, 10**90)  # relative error of a value that stands
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
        if node.op is CONSTANT:
            assert isinstance(node.value, Fraction), "a constant is a fraction"
            known[node] = node.value
        elif node.op is PI or (node.args and node.args[0] in known and all(arg in known for arg in node.args)):
            known[node] = Fraction(0)  # until it is computed below
            inexact.append(node)
    for digits in PRECISIONS:
        if not inexact:
            break
        inexact = _settle(inexact, known, digits)
    known.update(dict.fromkeys(inexact, Fraction(0)))
    return known


def is_simple(value: Fraction) -> bool:
    """Return whether `value` is a fraction that a person could have written."""
    return value.denominator <= SIMPLE


def _settle(nodes: Sequence[Expr], known: dict[Expr, Fraction], digits: int) -> list[Expr]:
    """Enter the values that stand at one precision into `known`, and return the nodes that need more digits."""
    from symdyn.algebra.big import BigFloats
    from symdyn.algebra.running_error import RunningErrors

    numbers = BigFloats(digits)
    roundoff = numbers.context.mpf(10) ** (1 - digits)
    try:
        values = evaluate(nodes, RunningErrors(numbers, roundoff, roundoff), {})
        found = [(_exact(bounded.value), _exact(numbers.context.mpf(bounded.error))) for bounded in values]
    except ZeroDivisionError as fault:
        if digits < PRECISIONS[-1]:
            return list(nodes)
        raise DerivationError(NOT_REAL) from fault
    except (ArithmeticError, ValueError, AttributeError) as fault:
        raise DerivationError(NOT_REAL) from fault
    rest = []
    for node, (value, error) in zip(nodes, found, strict=True):
        if error <= WANTED * abs(value):
            simple = value.limit_denominator(SIMPLE)
            known[node] = simple if abs(value - simple) <= SAME * abs(value) else value
        else:
            rest.append(node)
    return rest


def _exact(value: object) -> Fraction:
    """Return a big float as the fraction that it is; a complex one has no `_mpf_`, an infinite one no mantissa."""
    negative, mantissa, exponent, _ = value._mpf_  # type: ignore[attr-defined]
    if mantissa == 0 and exponent != 0:
        raise ValueError(f"{value} is not finite")
    size = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return -size if negative else size


NOT_REAL = "a constant of the scene is not a finite real number; look for 1/0, sqrt or log of a negative number"
