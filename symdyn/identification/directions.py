"""Directions of parameters that rows do not tell, since what they feel of them is noise of the motion.

    λ = |N v|² / |Y v|²     largest first: Y are the rows, N one draw of what noise of the motion makes of them
    v = e_k - Σ c_i e_i     for each direction that is mostly noise, of a column k of its own; c is the regression of
                            that column on the others, and of it only what is sure

Reference: White, A heteroskedasticity-consistent covariance matrix estimator (1980).
"""

from __future__ import annotations

import numpy as np

from symdyn.algebra import Array
from symdyn.identification.filtered import Indices

BURIED = 0.25
"""Part of the information of a direction that noise of the motion may make, and it still counts as told."""

SURE = 3.0
"""Standard errors from which a column is part of another."""

LEAST = 1e-9
"""Part of the largest singular value below which columns depend on each other."""


def hidden(felt: Array, columns: Array, noise: Array) -> Array:
    """Return directions that noise of the motion buries, shape (u, p).

    Args:
        felt: orthogonal directions of which the rows tell equally much, shape (n, p): |columns @ one| = 1.
        columns: of the rows, shape (M, p).
        noise: one draw of what noise makes of them, shape (M, p).
    """
    part = noise @ felt.T
    if np.sum(part**2) < BURIED:
        return np.zeros((0, felt.shape[1]))
    share, turned = np.linalg.eigh(part.T @ part)
    return cleared(turned.T[share >= BURIED] @ felt, columns)


def echelon(rows: Array) -> Array:
    """Return rows of the same space, each with one column that the others lack; by QR with pivoting."""
    return _echelon(rows)[0]


def _echelon(rows: Array) -> tuple[Array, Indices]:
    """Return rows of the same space, and the column that each has for itself."""
    from scipy.linalg import qr

    if not len(rows):
        return rows, np.zeros(0, np.int64)
    pivots = np.sort(qr(rows, mode="economic", pivoting=True)[2][: len(rows)])
    return np.asarray(np.linalg.solve(rows[:, pivots], rows)), np.asarray(pivots, dtype=np.int64)


def cleared(rows: Array, columns: Array) -> Array:
    """Return directions that noise buries, without what chance mixes into them.

    A column that is noise is, by chance, a little like every other one. What it truly shares with others is its
    regression on them; of that stays what is sure against its standard error (White 1980).
    """
    if not len(rows):
        return rows
    rows = np.linalg.svd(rows, full_matrices=False)[2]
    rows, pivots = _echelon(rows)
    found = np.zeros_like(rows)
    for row, pivot in zip(found, pivots, strict=True):
        row[pivot] = 1.0
        others = np.setdiff1d(np.arange(rows.shape[1]), pivots)
        while len(others):
            inverse = np.linalg.pinv(columns[:, others], rcond=LEAST)
            shared = inverse @ columns[:, pivot]
            off = columns[:, pivot] - columns[:, others] @ shared
            sure = np.abs(shared) > SURE * np.linalg.norm(inverse * off, axis=1)
            if sure.all():
                row[others] = -shared
                break
            others = others[sure]
    return found
