"""Rows that are solved in a loop, which is fixed text, over a table that is read.

<function>_solved(r);                      goes over <function>_steps: how many columns, then of every step the row, its
                                           scale, how many terms it has, and factor and row of each, all by places of r
memcpy(out + 3, r + 8, 2 * sizeof *r);     entries from where they are found to where they go
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from symdyn.dynamics.mechanism import RowSolve
from symdyn.verify.written.memory import Index, Pointer, Work
from symdyn.verify.written.straight_line import Value
from symdyn.verify.written.syntax import line_of, unread

if TYPE_CHECKING:
    from tree_sitter import Node

COLUMNS = 8
"""Rows are whole vectors of so many columns, and begin where a vector may."""


def run_steps(node: Node, table: Sequence[int], r: Value) -> None:
    """Run the steps of a table over the rows of a local array."""
    if not (isinstance(r, Pointer) and isinstance(r.memory, Work) and r.index == Index(0)):
        raise unread(node, "is no loop over rows")
    (width, *rest), at = table, 0
    while at < len(rest):
        step = rest[at : at + 3]
        at += 3 + 2 * rest[at + 2] if len(step) == 3 else len(rest)
        terms = rest[at - 2 * step[2] : at] if at <= len(rest) else ()
        if len(terms) != 2 * step[-1]:
            raise unread(node, "has a table that ends within a step")
        rows, factors = [step[0], *terms[1::2]], [r.load(Index(place)) for place in (step[1], *terms[::2])]
        if any(place % COLUMNS for place in (width, *rows)) or step[0] in rows[1:]:
            raise unread(node, "has rows that are no whole vectors, or takes a row from itself")
        for column in range(width):
            x, *others = (r.load(Index(place + column)) for place in rows)
            found = RowSolve.stepped(x, factors[0], zip(factors[1:], others, strict=True))
            r.store(Index(step[0] + column), found, line_of(node))


def copy_part(node: Node, to: Value, source: Value, count: int, array: Value | None) -> None:
    """Copy some entries of a local array."""
    if not (isinstance(to, Pointer) and isinstance(source, Pointer) and isinstance(source.memory, Work)):
        raise unread(node, "is no copy of a local array")
    if not (isinstance(array, Pointer) and array.memory is source.memory):
        raise unread(node, "is measured by another array")
    for place in range(count):
        to.store(Index(place), source.load(Index(place)), line_of(node))
