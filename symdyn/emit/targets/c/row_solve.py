"""The loop over rows of a function that solves, as its template is given it."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.program import RowLoop

LARGEST = 1 << 16
"""Numbers of tables, which are short ones, are smaller."""

UNDER_WAY = 8
"""Vectors of a row that are computed side by side, at most: their sums stay in registers."""


@dataclass(frozen=True)
class RowSolveText:
    """A loop over rows.

    Attributes:
        size: entries of what lines leave for it.
        table: how many columns of a row it goes over, then of every step row, scale, how many terms, and factor and row
            of each.
        vectors: how many of a row are computed side by side, as long as there are so many; one by one at last.
        copies: (to, from, count) of entries that stand side by side in the result and where it is found.
    """

    size: int
    table: tuple[int, ...]
    vectors: tuple[int, ...]
    copies: tuple[tuple[int, int, int], ...]


def fits(rows: RowLoop) -> bool:
    """Tell whether a table can hold the numbers of a solve."""
    return len(rows.entries) < LARGEST


def row_solve_text(rows: RowLoop) -> RowSolveText:
    """Return the loop over rows."""
    table = [rows.width] + [
        number
        for step in rows.steps
        for number in (step.row, step.scale, len(step.terms), *(one for term in step.terms for one in term))
    ]
    copies: list[list[int]] = []
    for to, place in enumerate(rows.places):
        if copies and place == copies[-1][1] + copies[-1][2]:
            copies[-1][2] += 1
        else:
            copies.append([to, place, 1])
    told = tuple((to, place, count) for to, place, count in copies)
    return RowSolveText(len(rows.entries), tuple(table), _side_by_side(rows.vectors), told)


def _side_by_side(vectors: int) -> tuple[int, ...]:
    """Return into how many vectors rows are cut, shares as equal as may be."""
    shares = -(-vectors // UNDER_WAY)
    largest = -(-vectors // shares)
    return tuple(sorted({largest, vectors - largest * (shares - 1), 1}, reverse=True))
