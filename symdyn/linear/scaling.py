"""Scales of states and of rows: what A maps to nothing and how slow its modes are, whatever the units of states are."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from symdyn.algebra import Array

PARTED = 1e-6
"""Distance of eigenvalues over their size that rounding makes of one that is multiple."""

ROUNDING = 1e-14
"""Entries over those beside them that rounding leaves where there is nothing."""

SINGULAR, SLOWEST, BLOWN = 1e-12, 1e-6, 5e-8
"""Singular values of the evened A over its largest that are zero; entries, 1/s, and over the largest, that balancing
makes of rounding."""

ROUNDS = 12
"""Times that all states are balanced, or rows and columns evened, at most."""


def nothing(A: Array, least: float, sampled: bool) -> Array:
    """Return what balanced A, of entries above a least, maps to nothing, shape (n, many), modes however slow not."""
    rounding = ROUNDING * (np.abs(A) + np.eye(len(A)) if sampled else _beside(A))
    evened, _, columns = _even(np.where(np.abs(A) > np.maximum(rounding, least), A, 0.0))
    _, sizes, rows = np.linalg.svd(evened)
    return np.asarray(columns[:, None] * rows[sizes <= SINGULAR * sizes[0]].T)


def eigenvalues(A: Array) -> tuple[Any, Any]:
    """Return eigenvalues and vectors, those that are slow beside the fastest as of the inverse of A."""
    values, shapes = (np.asarray(one, dtype=np.complex128) for one in np.linalg.eig(A))
    sizes = np.abs(values)
    if sizes.min() >= PARTED * sizes.max():
        return values, shapes
    evened, rows, columns = _even(A)
    inverses, slower = np.linalg.eig(columns[:, None] * np.linalg.inv(evened) * rows)
    fast = sizes > math.sqrt(sizes.max() / np.abs(inverses).max())
    slow = np.argsort(-np.abs(inverses), kind="stable")[: np.count_nonzero(~fast)]
    return np.append(values[fast], 1 / inverses[slow]), np.hstack([shapes[:, fast], slower[:, slow]])


def _even(A: Array) -> tuple[Array, Array, Array]:
    """Return R A C whose rows and columns have largest entries of one size, and the diagonals of R and C."""
    rows, columns = np.ones(len(A)), np.ones(len(A))
    for _ in range(ROUNDS):
        for one, axis in ((rows, 1), (columns, 0)):
            size = np.abs(rows[:, None] * A * columns).max(axis=axis)
            one[:] = one / np.where(size > 0, size, 1.0)
    return rows[:, None] * A * columns, rows, columns


def _beside(A: Array) -> Array:
    """Return the largest entry of the rows and columns of both states of each entry, shape (n, n)."""
    most = np.maximum(np.abs(A).max(axis=0, initial=0.0), np.abs(A).max(axis=1, initial=0.0))
    return np.asarray(np.maximum(most[:, None], most))


def balance(A: Array) -> Array:
    """Return scales d, powers of two, shape (nx,), that make rows and columns of D⁻¹ A D of one size."""
    whole = np.abs(A) * (1 - np.eye(len(A)))
    small = whole <= ROUNDING * _beside(A)
    found = _balanced(whole)
    if not whole[small].any():
        return found
    rates = whole * found / found[:, None]  # what looks like rounding in these units may be none
    rounding = small & (rates <= max(SLOWEST, BLOWN * rates.max()))
    return _balanced(np.where(rounding, 0.0, whole))  # else that would be blown up


def _balanced(left: Array) -> Array:
    d, left = np.ones(len(left)), left.copy()
    for _ in range(ROUNDS):
        changed = False
        for k in range(len(d)):
            column, row = float(np.linalg.norm(left[:, k])), float(np.linalg.norm(left[k]))
            if not (column > 0 and row > 0 and math.isfinite(column) and math.isfinite(row)):
                continue
            factor = 2.0 ** round(math.log2(row / column) / 2)
            if factor != 1.0:
                changed = True
                d[k] *= factor
                left[:, k] *= factor
                left[k] /= factor
        if not changed:
            break
    return d
