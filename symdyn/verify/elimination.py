"""Gauss's elimination over any algebra, every pivot chosen by what the numbers are at the place at hand.

Rows are sparse. The next pivot is the largest entry of the row that has fewest, so that a chain of bodies is eliminated
from its tips without fill; what is too small to be told from zero is none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symdyn.graph import Algebra


@dataclass(frozen=True)
class Eliminated:
    """What became of A x = b.

    Attributes:
        x: a solution, shape (unknowns,): zero where the equations leave it open.
        free: the unknowns that they leave open.
        left: b by row, of the rows that became empty on its left: A x = b has a solution if all of it is zero.
    """

    x: list[Any]
    free: tuple[int, ...]
    left: dict[int, Any]


def eliminate(
    rows: Sequence[Mapping[int, Any]], unknowns: int, field: Algebra[Any], zero: Any, weigh: Callable[[Any], Any]
) -> Eliminated:
    """Return what becomes of A x = b in numbers of a field, `zero` its zero.

    Rows are those of A with b beside them, entries by column, b's being `unknowns`; what is missing is zero. What
    weighs 0 cannot be told from zero.
    """
    b = [row.get(unknowns, zero) for row in rows]
    A = [{c: value for c, value in row.items() if c != unknowns and weigh(value)} for row in rows]
    users: list[set[int]] = [set() for _ in range(unknowns)]
    for r, row in enumerate(A):
        for c in row:
            users[c].add(r)

    def reduce(s: int, r: int, c: int) -> None:
        """Take from row s the share of row r that leaves nothing in column c."""
        share = field.div(A[s].pop(c), A[r][c])
        b[s] = field.sub(b[s], field.mul(share, b[r]))
        for k, value in A[r].items():
            if k == c:
                continue
            rest = field.sub(A[s].pop(k, zero), field.mul(share, value))
            if weigh(rest):
                A[s][k] = rest
                users[k].add(s)
            else:
                users[k].discard(s)

    waiting = {r for r, row in enumerate(A) if row}
    order: list[tuple[int, int]] = []
    while waiting:
        r = min(waiting, key=lambda row: (len(A[row]), row))
        waiting.remove(r)
        if not A[r]:
            continue
        c = max(A[r], key=lambda k: (weigh(A[r][k]), -k))
        order.append((r, c))
        for k in A[r]:
            users[k].discard(r)
        for s in sorted(users[c]):
            reduce(s, r, c)
        users[c].clear()
    x = [zero] * unknowns
    for r, c in reversed(order):
        total = b[r]
        for k, value in A[r].items():
            if k != c:
                total = field.sub(total, field.mul(value, x[k]))
        x[c] = field.div(total, A[r][c])
    ends, bound = {r for r, _ in order}, {c for _, c in order}
    free = tuple(k for k in range(unknowns) if k not in bound)
    return Eliminated(x, free, {r: b[r] for r in range(len(A)) if r not in ends})
