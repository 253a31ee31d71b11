"""Solving A x = b on the graph: pivots chosen by numbers at one position, short and good there.

Up to three unknowns it is Cramer's rule, whose only singular positions are those of A itself; beyond, Gauss's
elimination, which loses the positions where one of its pivots vanishes too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.dynamics.reactions.samples import Array
from symdyn.graph import Expr

SMALL = 1e-9  # relative to the largest entry of its row: what counts as zero
SHARE = 0.1  # of the largest candidate: what is large enough to be chosen for the sake of sparsity


def pivots(numbers: Array) -> list[tuple[int, int]]:
    """Return the (row, column) of pivots in order, as many as the rank: sparse ones first among those large enough."""
    sizes = np.abs(numbers).max(axis=1, initial=0.0, keepdims=True)
    top = float(sizes.max(initial=0.0))
    A = numbers / np.maximum(sizes, SMALL * top or 1.0)  # a row of rounding errors stays one
    rows, columns = list(range(A.shape[0])), list(range(A.shape[1]))
    chosen = []
    while rows and columns:
        left = np.abs(A[np.ix_(rows, columns)])
        if left.max() < SMALL:
            break
        busy = left > SMALL
        fill = np.outer(busy.sum(axis=1) - 1, busy.sum(axis=0) - 1)
        fill[left < SHARE * left.max()] = left.size + 1
        i, j = divmod(int(fill.argmin()), len(columns))
        r, c = rows.pop(i), columns.pop(j)
        chosen.append((r, c))
        A[rows] -= np.outer(A[rows, c] / A[r, c], A[r])
    return chosen


def eliminate(A: Sequence[Sequence[Expr]], b: Sequence[Expr], order: Sequence[tuple[int, int]]) -> list[Expr]:
    """Return x with A x = b in the rows of the pivots; as many unknowns as pivots."""
    if len(order) <= 3:
        return _cramer(A, b, order)
    rows = {r: (list(A[r]), b[r]) for r, _ in order}
    for k, (r, c) in enumerate(order):
        pivot, right = rows[r]
        for s, _ in order[k + 1 :]:
            line, value = rows[s]
            if not line[c].is_zero:
                share = line[c] / pivot[c]
                reduced = [x if p.is_zero else x - share * p for x, p in zip(line, pivot, strict=True)]
                rows[s] = (reduced, value - share * right)
    x = [b[0].graph.zero] * len(order)
    for k in reversed(range(len(order))):
        r, c = order[k]
        line, right = rows[r]
        for _, d in order[k + 1 :]:
            right = right - line[d] * x[d]
        x[c] = right / line[c]
    return x


def _cramer(A: Sequence[Sequence[Expr]], b: Sequence[Expr], order: Sequence[tuple[int, int]]) -> list[Expr]:
    """Return the solution as determinants over the determinant."""
    if not order:
        return []
    rows = sorted(r for r, _ in order)
    M, right = [list(A[r]) for r in rows], [b[r] for r in rows]
    whole = determinant(M)
    return [
        determinant([[*line[:c], y, *line[c + 1 :]] for line, y in zip(M, right, strict=True)]) / whole
        for c in range(len(order))
    ]


def determinant(M: Sequence[Sequence[Expr]]) -> Expr:
    """Return the determinant, along the first row."""
    if len(M) == 1:
        return M[0][0]
    total = M[0][0].graph.zero
    for c, entry in enumerate(M[0]):
        if not entry.is_zero:
            minor = entry * determinant([[*line[:c], *line[c + 1 :]] for line in M[1:]])
            total = total - minor if c % 2 else total + minor
    return total
