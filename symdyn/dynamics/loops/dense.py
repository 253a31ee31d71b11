"""Dense systems of expressions: blocks of the rows of loops, and what else has no pattern.

Blocks of G_d up to six rows are solved by Cramer's rule with shared minors: a block is singular where the dependent
velocities are undetermined and nowhere else, which pivots chosen beforehand could not promise. Larger ones, and those
with more equations than unknowns, are solved by their normal equations, which are singular nowhere else either.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.mechanism.ldl import Factored, factored
from symdyn.graph import Expr

Matrix = Sequence[Sequence[Expr]]

CRAMER = 6
"""Rows of the largest block that is solved by Cramer's rule."""


def solve_square(B: Matrix, b: Sequence[Expr]) -> list[Expr]:
    """Return B⁻¹ b: by Cramer's rule, beyond six rows by normal equations."""
    size = len(B)
    if all(one.is_zero for one in b):
        return list(b)
    if size > CRAMER:
        return solve_normal(B, b)
    minors = _Minors(B)
    every = tuple(range(size))
    det = minors.value(every, every)
    if size == 1:
        return [b[0] / det]
    inverse = 1 / det
    found = []
    for j in every:
        columns = every[:j] + every[j + 1 :]
        total = det.graph.zero
        for i in every:
            if not b[i].is_zero:
                minor = minors.value(every[:i] + every[i + 1 :], columns)
                total = total + minor * b[i] if (i + j) % 2 == 0 else total - minor * b[i]
        found.append(total * inverse)
    return found


def inverse(B: Matrix) -> list[list[Expr]]:
    """Return B⁻¹ of at most six rows, by its minors and one reciprocal."""
    minors, every = _Minors(B), tuple(range(len(B)))
    plus = 1 / minors.value(every, every)

    def entry(j: int, i: int) -> Expr:
        found = minors.value(every[:i] + every[i + 1 :], every[:j] + every[j + 1 :]) * plus
        return found if (i + j) % 2 == 0 else -found

    return [[entry(j, i) for i in every] for j in every]


class _Minors:
    """Minors of a matrix by expansion along their first rows, each computed once."""

    def __init__(self, B: Matrix) -> None:
        """Begin with a square matrix."""
        self.B = B
        self.known: dict[tuple[tuple[int, ...], tuple[int, ...]], Expr] = {}

    def value(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> Expr:
        """Return the determinant of the part."""
        graph = self.B[0][0].graph
        if not rows:
            return graph.one
        key = (rows, columns)
        if key not in self.known:
            total = graph.zero
            for place, c in enumerate(columns):
                entry = self.B[rows[0]][c]
                if not entry.is_zero:
                    term = entry * self.value(rows[1:], columns[:place] + columns[place + 1 :])
                    total = total + term if place % 2 == 0 else total - term
            self.known[key] = total
        return self.known[key]


def solve_normal(B: Matrix, b: Sequence[Expr]) -> list[Expr]:
    """Return x with Bᵀ B x = Bᵀ b by Lᵀ D L: B⁻¹ b, or the least squares of more equations than unknowns."""
    graph, columns = B[0][0].graph, zip(*B, strict=True)
    right = [[graph.total(x * y for x, y in zip(column, b, strict=True))] for column in columns]
    return [row[0] for row in squared(B).solve(right)]


def squared(B: Matrix) -> Factored:
    """Return Bᵀ B factored."""
    graph, columns = B[0][0].graph, list(zip(*B, strict=True))
    square = [[graph.total(x * y for x, y in zip(one, other, strict=True)) for other in columns] for one in columns]
    return factored(graph, range(-1, len(columns)), square)
