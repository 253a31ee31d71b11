"""What an exciting motion is to make small, as functions of the singular values of the stacked base regressor.

    condition            σ_max / σ_min of the rows as they are, over the noise of each drive
    scaled_condition     the same of columns of length 1: no unit of a parameter weighs
    determinant          -ln det(AᵀA), A the rows over √N: the volume of the ellipsoid of errors

A condition number has no slope where two singular values meet, which is where its minimum is. What is minimised in its
place is |A|_16 |A⁺|_16 in the norm (Σ σ^16)^(1/16), which is larger by p^(1/8) at most.

References: Gautier and Khalil, Exciting trajectories for the identification of base inertial parameters (1992); Swevers
et al. (1997), for the determinant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array

NORM = 16
"""Exponent of the norms that stand for the largest of singular values."""

LEAST = 1e-13
"""Eigenvalue of AᵀA, over the largest, below which its digits mean nothing."""


@dataclass(frozen=True)
class Criterion:
    """What is made small.

    Attributes:
        text: what it is, one line.
        scaled: whether columns are divided by their lengths before.
        smooth: from singular values, shape (p,), to a number and its slopes, shape (p,).
        displayed: from singular values to the number that a user is shown.
    """

    text: str
    scaled: bool
    smooth: Callable[[Array], tuple[float, Array]]
    displayed: Callable[[Array], float]

    def value(self, A: Array) -> float:
        """Return what a user is shown of rows A, shape (N, n, p)."""
        rows = A.reshape(-1, A.shape[-1])
        sizes = np.linalg.svd(rows / _lengths(A) if self.scaled else rows, compute_uv=False)
        return self.displayed(np.asarray(sizes, dtype=np.float64))

    def slope(self, A: Array) -> tuple[float, Array]:
        """Return the smooth number of rows A, shape (N, n, p), and its slope by every entry, of the same shape.

        Products go instant by instant: on matrices of a few hundred rows, threads of BLAS wait longer than they work.
        """
        length = _lengths(A) if self.scaled else np.ones(A.shape[-1])
        B = A / length
        squares, V = np.linalg.eigh(np.matmul(B.transpose(0, 2, 1), B).sum(axis=0))
        sizes = np.sqrt(np.maximum(squares, LEAST * squares[-1]))
        value, slopes = self.smooth(sizes)
        found = np.matmul(B, (V * (slopes / sizes)) @ V.T)
        if self.scaled:
            found = (found - B * (found * B).sum(axis=(0, 1))) / length
        return value, found


def _lengths(A: Array) -> Array:
    """Return the lengths of columns, 1 of those that are zero."""
    length = np.sqrt((A**2).sum(axis=(0, 1)))
    return np.where(length > 0, length, 1.0)


def _condition(sizes: Array) -> tuple[float, Array]:
    large, small = (sizes / sizes.max()) ** NORM, (sizes.min() / sizes) ** NORM
    value = np.log(sizes.max() / sizes.min()) + (np.log(large.sum()) + np.log(small.sum())) / NORM
    return float(value), (large / large.sum() - small / small.sum()) / sizes


def _determinant(sizes: Array) -> tuple[float, Array]:
    return float(-2 * np.log(sizes).mean()), -2 / len(sizes) / sizes


def _ratio(sizes: Array) -> float:
    return float(sizes[0] / sizes[-1]) if sizes[-1] > 0 else float("inf")


def _volume(sizes: Array) -> float:
    return float(-2 * np.log(sizes).sum()) if sizes[-1] > 0 else float("inf")


CRITERIA: Mapping[str, Criterion] = {
    "condition": Criterion("condition number of the base regressor", False, _condition, _ratio),
    "scaled_condition": Criterion("condition number of its columns, each of length 1", True, _condition, _ratio),
    "determinant": Criterion("-ln det of the information matrix a sample", False, _determinant, _volume),
}
