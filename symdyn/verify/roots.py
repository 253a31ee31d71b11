"""Roots of something variable, as formal values: s with s² = a, for any of whose signs an identity must hold.

Over a field a root has no sign, so that what is proved there is proved for both. That is the whole truth as long as no
product of some of the radicands is a square: sqrt(x²) = x would hold half the time. No such product is a square if the
radicands are squares of the field independently of each other: written as 0 (a square) and 1 (none), their values at
points of the field span all of GF(2)^r, up to a shift. A product that is a square times a constant can never do so.

Then E(x, s) has 2^r conjugates, and their product vanishes wherever E does: it is the rational function whose degree
counts. Points are drawn until all roots exist, which is one point of 2^r.

Reference: Lang, Algebra (2002), chapter VI, section 8, Kummer extensions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symdyn.algebra import FiniteField, Redraw
from symdyn.graph import Expr, Op, reachable
from symdyn.verify.degree import Bound

MOST = 7  # roots of one claim: 128 points are drawn for one at which all exist
MOST_SIGNED = 3  # roots of one claim that are looked at with all their signs
SPARE = 40  # points beyond the least number: independent roots are missed with probability 2^-40

Evaluate = Callable[[Sequence[Expr], FiniteField], list[int]]


def radicands(outputs: Sequence[Expr]) -> list[Expr] | None:
    """Return what stands under the variable roots of one graph; None where a root has no formal value.

    So it is under another root, and for the root of a negative number.
    """
    found: list[Expr] = []
    rooted: set[Expr] = set()
    for node in reachable(outputs):
        below = any(arg in rooted for arg in node.args)
        if node.op is Op.SQRT:
            value = node.args[0].value
            if below or (isinstance(value, Fraction) and value < 0):
                return None
            if not isinstance(value, Fraction):
                found.append(node.args[0])
                below = True
        if below:
            rooted.add(node)
    return found


@dataclass(frozen=True)
class Roots:
    """The variable roots of a claim: how many are different, and with how many choices of signs it must hold."""

    count: int
    signs: int


def signed(sides: Sequence[Sequence[Expr]], fields: Iterator[FiniteField], evaluate: Evaluate) -> Roots | None:
    """Return what is known of the radicands of a claim; None if they are too many.

    Args:
        sides: radicands, those of one graph together.
        fields: fields of one prime, each with its own random point.
        evaluate: values at the point of a field.
    """
    if not any(sides):
        return Roots(0, 1)
    rows: list[list[int]] = []
    wanted = sum(map(len, sides)) + SPARE
    for field in fields:
        try:
            row = [value for side in sides for value in evaluate(side, field)]
        except Redraw:
            continue
        if all(row):
            rows.append([*row, field.p])
        if len(rows) == wanted:
            break
    columns = list(dict.fromkeys(zip(*(row[:-1] for row in rows), strict=True)))  # equal functions are one
    if len(rows) < wanted or len(columns) > MOST:
        return None
    p = rows[0][-1]
    patterns = [sum((pow(c[k], (p - 1) // 2, p) != 1) << j for j, c in enumerate(columns)) for k in range(wanted)]
    spanned = _rank([pattern ^ patterns[0] for pattern in patterns])
    if spanned == len(columns):
        return Roots(len(columns), 1)
    return Roots(len(columns), 1 << len(columns)) if len(columns) <= MOST_SIGNED else None


def _rank(vectors: Sequence[int]) -> int:
    """Return the rank over GF(2) of vectors written as bits."""
    basis: list[int] = []
    for vector in vectors:
        rest = vector
        for row in basis:
            rest = min(rest, rest ^ row)
        if rest:
            basis.append(rest)
    return len(basis)


def conjugated(bound: Bound, roots: int) -> Bound:
    """Return the bound of the product of all conjugates, at points that are one of 2^roots."""
    return Bound(bound.degree << (2 * roots), bound.height * 2**roots)
