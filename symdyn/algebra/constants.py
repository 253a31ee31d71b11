"""Values of nodes without symbols, such as sqrt(2)/2 or sin(37°), once and to many digits.

Each is a ball that holds the true value, at a precision that grows until 90 digits stand. A ball below every double
even at 3200 digits is zero, which the graph could not see; what depends on it, such as its sign, is computed again with
that zero. A value that is a simple fraction to 80 digits is that fraction, so that cos²(40°) + sin²(40°) no longer
multiplies anything.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, evaluate, reachable

PRECISIONS = (110, 220, 800, 3200)  # decimal digits
BITS_OF_A_DIGIT = 3.33
WANTED = 299  # bits that stand, 90 digits
LARGEST_EXPONENT = 1_000_000  # of two
SMALLEST_DOUBLE = 5e-324
SIMPLE = 10**6
SAME = 10**80


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
        elif node.op is Op.PI or (node.args and node.args[0] in known and all(arg in known for arg in node.args)):
            known[node] = Fraction(0)  # until it is computed below
            inexact.append(node)
    nothing: list[Expr] = []
    for digits in PRECISIONS:
        if inexact:
            inexact, nothing = _settle(inexact, known, digits, ())
    zeros: dict[Expr, None] = {}
    while inexact:
        if not nothing:
            raise DerivationError(NOT_REAL)
        zeros.update(dict.fromkeys(nothing))
        inexact, nothing = _settle([node for node in inexact if node not in zeros], known, PRECISIONS[-1], zeros)
    return known


def is_simple(value: Fraction) -> bool:
    """Return whether `value` is a fraction that a person could have written."""
    return value.denominator <= SIMPLE


def _settle(
    nodes: Sequence[Expr], known: dict[Expr, Fraction], digits: int, zeros: Iterable[Expr]
) -> tuple[list[Expr], list[Expr]]:
    """Enter the values that stand at one precision into `known`; return the other nodes, and those below any double.

    `zeros` are nodes that are known to be zero.
    """
    from symdyn.algebra.big import Balls

    rest, nothing = [], []
    with Balls(int(digits * BITS_OF_A_DIGIT)) as balls:
        balls_of_nodes = evaluate(nodes, balls, dict.fromkeys(zeros, balls.number(0.0)))
        for node, ball in zip(nodes, balls_of_nodes, strict=True):
            if ball.is_finite() and ball.rel_accuracy_bits() >= WANTED:
                mantissa, exponent = (int(part) for part in ball.mid().man_exp())
                if abs(exponent) > LARGEST_EXPONENT:
                    raise DerivationError(NOT_REAL)
                value = mantissa * Fraction(2) ** exponent
                near = value.limit_denominator(SIMPLE)
                known[node] = near if abs(near - value) * SAME <= abs(value) else value
                continue
            rest.append(node)
            if abs(ball) < SMALLEST_DOUBLE:
                nothing.append(node)
    return rest, nothing


NOT_REAL = "a constant of the scene is not a finite real number; look for 1/0, sqrt or log of a negative number"
