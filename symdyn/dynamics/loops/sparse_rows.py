"""Rows of large mechanisms in numbers: pivots, rank, least squares, singular values, by their entries alone.

    A = L Qᵀ     by reflections: each turns one row onto a column of its own, which takes no part in what follows

Pivots are rows, of those with large remainders the one with the fewest entries; a reflection mixes only the columns
that its row uses, and the rows that use these. Rows whose remainder is nothing depend on those before them. Where there
are such rows, L is taller than wide, and its own transpose is factored likewise: A = Q₂ L₂ᵀ Qᵀ.

Reference: Davis, Algorithm 915, SuiteSparseQR: multifrontal multithreaded rank-revealing sparse QR, ACM Transactions on
Mathematical Software 38 (2011); Golub and Van Loan, Matrix Computations (2013), section 5.5.7.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.frozen import dataclass
from symdyn.unlocked import cached_property

Indices = npt.NDArray[np.intp]

LARGE, BUSY = 150, 40
"""Rows from which on this pays, and entries of a column beyond which it does not: reflections would fill all."""

GOOD = 0.1
"""Remainders this close to the largest will do as pivots: of them the row with the fewest entries fills in least."""

FINE = 1e-6
"""Relative tolerance of singular values, which are told to three digits."""


def is_large(A: Array) -> bool:
    """Tell whether a matrix is large, and each column has few entries."""
    return min(A.shape) >= LARGE and int(np.count_nonzero(A, axis=0).max()) <= BUSY


class Remainders:
    """Rows that are turned step by step; what is left of each stands in the columns that are still open."""

    def __init__(self, A: Array) -> None:
        self.rows: list[dict[int, float]] = [{} for _ in A]
        self.users: list[set[int]] = [set() for _ in range(A.shape[1])]
        for i, k in zip(*(part.tolist() for part in np.nonzero(A)), strict=True):
            self.rows[i][k] = float(A[i, k])
            self.users[k].add(i)
        self.lengths = np.linalg.norm(A, axis=1)
        self.counts = np.count_nonzero(A, axis=1)

    def turn(self, pivot: int) -> tuple[Array, Array, int, dict[int, float]]:
        """Turn a row onto one column, which is closed: columns and reflection, that column, its entries by row."""
        own = self.rows[pivot]
        columns = list(own)
        v = np.array([own[k] for k in columns])
        length = float(np.linalg.norm(v))
        length = length if v[-1] < 0 else -length  # what the row becomes, its sign such that nothing cancels
        w = v.copy()
        w[-1] -= length
        w *= np.sqrt(2.0) / np.linalg.norm(w)
        last, others = columns[-1], columns[:-1]
        touched = sorted(set().union(*(self.users[k] for k in columns)) - {pivot})
        entries = {pivot: length}
        if touched:
            block = np.array([[self.rows[i].get(k, 0.0) for k in columns] for i in touched])
            block -= np.outer(block @ w, w)
            for i, row in zip(touched, block.tolist(), strict=True):
                entries[i] = row.pop()
                self.rows[i].pop(last, None)
                self.rows[i].update(zip(others, row, strict=True))
            for k in others:
                self.users[k].update(touched)
            self.counts[touched] = [len(self.rows[i]) for i in touched]
            self.lengths[touched] = [math.hypot(*self.rows[i].values()) for i in touched]
        for k in columns:
            self.users[k].discard(pivot)
        self.users[last].clear()
        self.rows[pivot], self.lengths[pivot] = {}, 0.0
        return np.array(columns), w, last, entries

    def next(self, among: Indices) -> tuple[int, float]:
        """Return the row with the fewest entries whose remainder is large, and the largest remainder."""
        lengths = self.lengths[among]
        best = float(lengths.max(initial=0.0))
        counts = np.where(lengths >= GOOD * best, self.counts[among], len(self.users) + 1)
        return int(among[int(np.argmin(counts))]), best


@dataclass(frozen=True)
class Triangular:
    """A = L Qᵀ.

    Attributes:
        independent: independent rows, in the order of the pivots.
        dependent: the other ones, ascending.
        sizes: remainders of the independent rows when they were chosen.
        L: shape (rows, independent), in SciPy's compressed columns; triangular in the independent rows, in their order.
        width: number of columns of A.
        reflections: columns and vector of each reflection, and the column that it closed.
    """

    independent: tuple[int, ...]
    dependent: tuple[int, ...]
    sizes: tuple[float, ...]
    L: Any
    width: int
    reflections: tuple[tuple[Array, Array, int], ...]

    def expand(self, y: Array) -> Array:
        """Return Q y, shape (width,)."""
        x = np.zeros(self.width)
        x[[column for _, _, column in self.reflections]] = y
        for columns, w, _ in reversed(self.reflections):
            x[columns] -= (w @ x[columns]) * w
        return x

    def project(self, x: Array) -> Array:
        """Return Qᵀ x, shape (independent,)."""
        x = x.copy()
        for columns, w, _ in self.reflections:
            x[columns] -= (w @ x[columns]) * w
        return np.asarray(x[[column for _, _, column in self.reflections]])

    @cached_property
    def square(self) -> Any:
        """The independent rows of L, factored by SuperLU; as triangular as they are."""
        from scipy.sparse.linalg import splu

        return splu(self.L[list(self.independent)].tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0)

    @cached_property
    def tall(self) -> Triangular:
        """Lᵀ = L₂ Q₂ᵀ, where rows depend on others."""
        return triangular(self.L.T.toarray(), 0.0)

    def shortest(self, b: Array) -> Array:
        """Return the shortest x for which A x misses b least."""
        if not self.dependent:
            return self.expand(self.square.solve(b[list(self.independent)]))
        y = self.tall.square.solve(self.tall.project(b), trans="T")
        found = np.empty(len(y))
        found[list(self.tall.independent)] = y
        return self.expand(found)

    def ends(self) -> tuple[float, float]:
        """Return the largest singular value and the smallest that is not zero."""
        last = self.tall if self.dependent else self
        rows = last.L[list(last.independent)]
        largest = _largest(lambda x: rows.T @ (rows @ x), len(self.independent))
        smallest = _largest(lambda x: last.square.solve(last.square.solve(x, trans="T")), len(self.independent))
        return float(np.sqrt(largest)), float(1.0 / np.sqrt(smallest))

    def relations(self) -> Array:
        """Return dependent rows in terms of independent ones, shape (dependent, independent); zeros for zero rows."""
        right = self.L[list(self.dependent)].toarray()
        return np.asarray(self.square.solve(right.T, trans="T").T if right.size else right)


def triangular(A: Array, negligible: float) -> Triangular:
    """Return A = L Qᵀ; rows whose remainder is negligible, beside the longest row, depend on those before."""
    from scipy.sparse import csc_matrix

    left, every = Remainders(A), np.arange(len(A))
    independent: list[int] = []
    sizes: list[float] = []
    reflections: list[tuple[Array, Array, int]] = []
    positions: list[tuple[int, int, float]] = []
    top = float(left.lengths.max(initial=0.0))
    while len(independent) < min(A.shape):
        pivot, best = left.next(every)
        if best <= negligible * top or best == 0.0:
            break
        columns, w, closed, entries = left.turn(pivot)
        positions += [(i, len(independent), x) for i, x in entries.items() if x]
        reflections.append((columns, w, closed))
        independent.append(pivot)
        sizes.append(best)
    i, k, x = zip(*positions, strict=True) if positions else ((), (), ())
    L = csc_matrix((x, (i, k)), shape=(len(A), len(independent)))
    dependent = tuple(sorted(set(range(len(A))) - set(independent)))
    return Triangular(tuple(independent), dependent, tuple(sizes), L, A.shape[1], tuple(reflections))


def _largest(product: Callable[[Array], Array], size: int) -> float:
    """Return the largest eigenvalue of a symmetric matrix by its products."""
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

    if size <= 2:  # too few for Lanczos' method
        return float(np.linalg.eigvalsh(np.column_stack([product(one) for one in np.eye(size)]))[-1])
    operator = LinearOperator((size, size), matvec=product, dtype=np.float64)
    start = np.random.default_rng(0).uniform(0.5, 1.5, size)
    try:
        return float(eigsh(operator, 1, which="LA", v0=start, tol=FINE, return_eigenvectors=False)[0])
    except ArpackNoConvergence as fault:  # values so close to each other that any of them will do
        found = fault.eigenvalues
        if len(found):
            return float(found[0])
        x = start
        for _ in range(200):
            x = product(x / np.linalg.norm(x))
        return float(np.linalg.norm(x))


def pivots(rows: Array, stages: Sequence[Sequence[int]], count: int, weak: float) -> tuple[list[int], list[float]]:
    """Return the rows that are chosen, and the largest remainder at each choice: `loop_decisions.pivots`."""
    left = Remainders(rows)
    top = float(left.lengths.max(initial=0.0))
    chosen: list[int] = []
    sizes: list[float] = []
    for place, stage in enumerate(stages):
        weakest, among = weak * top if place + 1 < len(stages) else 0.0, np.array(list(stage), dtype=np.intp)
        while len(chosen) < count and len(among):
            pivot, best = left.next(among)
            if best <= weakest:
                break
            left.turn(pivot)
            chosen.append(pivot)
            sizes.append(best)
    return chosen, sizes
