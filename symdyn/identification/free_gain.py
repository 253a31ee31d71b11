"""One gain more left free, seen from a fit without it: what it would be about, and how well forces could fit at best.

    δ = c·r / c·c           one step of Gauss-Newton: r, weighted residuals of the fit; c, the column of that gain
                            without what the other columns do, so that no other has to be solved for again

    least(u) = min |A β - b|² + |i - u (Y β + F)|²        u = 1/k; Y, F, i: rows of that drive; A, b: of all others
             = |b'|² + |i' - u F'|² + Σ (u s b* - c (i* - u F*))² / (c² + u² s²)
                                                          c, s: singular values of A and Y in one orthonormal basis of
                                                          both; *: along their left vectors; ': outside of these

With each drive weighted by the size of what it shows, the least of it is a bound: of no fit is the sum of squares of
errors, in parts of what drives show, below it.

Reference: Golub and Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems whose
variables separate (1973); Golub and Van Loan, Matrix Computations, section 6.1 (generalised singular values).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.identification.regression import Regression, Rows

LEAST = 1e-9
"""Part of the largest singular value, and of a column, below which nothing is told."""

WIDE, FINE = 6, 20
"""Decades on both sides of what was said, and how many gains of each are looked at."""

ROUNDED = 1e-10
"""Part of the squares of what a drive shows that rounding may make."""


@dataclass(frozen=True)
class GainStep:
    """One step of Gauss-Newton of one gain.

    Attributes:
        size: by which the gain would change, in parts of it.
        error: standard error of that; infinite where the rows do not tell it.
    """

    size: float
    error: float


def steps(rows: Rows, regression: Regression, drives: Collection[int]) -> dict[int, GainStep]:
    """Return the step that each gain would take if it alone were left free, weights as they are.

    Args:
        rows: that were fitted, what drives show taken for forces.
        regression: of these rows.
        drives: numbers of the velocities.
    """
    w = regression.weights
    columns = regression.Y * w[:, None] / regression.scale
    if len(regression.untold):
        columns = columns @ np.linalg.svd(regression.untold)[2][len(regression.untold) :].T
    basis = np.linalg.qr(columns)[0]
    left = regression.residuals * w
    force = rows.tau - regression.residuals
    return {j: _step(basis, left, np.where(rows.joint == j, -force * w, 0.0)) for j in drives}


def _step(basis: Array, left: Array, column: Array) -> GainStep:
    own = column - basis @ (basis.T @ column)
    size = float(own @ own)
    if size <= LEAST**2 * float(column @ column):
        return GainStep(0.0, np.inf)
    return GainStep(float(own @ left) / size, size**-0.5)


def bounds(rows: Rows, drives: Collection[int], shown: Collection[int]) -> dict[int, float]:
    """Return below what no sum of squares of errors is, in parts of what each drive shows, by the gain that is free.

    Args:
        rows: that were fitted, what drives show taken for forces.
        drives: numbers of the velocities.
        shown: drives whose gains are free in any case; what they show may be fitted exactly.
    """
    pressed: dict[int, Array] = {}
    for j in np.unique(rows.joint):
        of = rows.joint == j
        if (size := float(np.linalg.norm(rows.tau[of]))) and int(j) not in shown:
            pressed[int(j)] = np.asarray(np.linalg.qr(np.column_stack([rows.Y[of], rows.tau[of]]), mode="r")) / size
    return {j: _bound(pressed, j) if j in pressed else 0.0 for j in drives}


def _bound(pressed: Mapping[int, Array], free: int) -> float:
    """Return the least of all gains, of rows of each drive: columns, then what is known, then what it shows."""
    from scipy.optimize import minimize_scalar

    few = pressed[free]
    own = np.vstack([few, np.zeros((max(0, few.shape[1] - len(few)), few.shape[1]))])  # for all singular values
    others = np.vstack([np.zeros((1, own.shape[1])), *(one for j, one in pressed.items() if j != free)])
    both = np.vstack([others, own])[:, :-2]
    scale = np.linalg.norm(both, axis=0)
    U, s, _ = np.linalg.svd(both / np.where(scale > 0, scale, 1.0), full_matrices=False)
    U = U[:, s > LEAST * s[0]]
    left, s, Wt = np.linalg.svd(U[len(others) :])
    s = np.append(s, np.zeros(len(Wt) - len(s)))
    along = U[: len(others)] @ Wt.T
    c = np.linalg.norm(along, axis=0)
    c = np.where(c > LEAST, c, 0.0)
    along = along / np.where(c > 0, c, 1.0) * (c > 0)
    left = left[:, : len(s)] * (s > LEAST)
    b = others[:, -1] - others[:, -2]
    F, i = own[:, -2], own[:, -1]
    b_along, F_along, i_along = along.T @ b, left.T @ F, left.T @ i
    b_out, F_out, i_out = b - along @ b_along, F - left @ F_along, i - left @ i_along

    def least(u: Array) -> Array:
        u = np.asarray(u)[..., None]
        off = u * s * b_along - c * (i_along - u * F_along)
        inside = np.sum(off**2 / (c**2 + (u * s) ** 2), axis=-1)
        found: Array = inside + b_out @ b_out + np.sum((i_out - u * F_out) ** 2, axis=-1)
        return found

    at = np.linspace(-WIDE, WIDE, 2 * WIDE * FINE + 1)
    found = np.inf
    for sign in (1.0, -1.0):
        seen = least(sign * 10.0**at)
        for k in np.flatnonzero((seen[1:-1] <= seen[:-2]) & (seen[1:-1] <= seen[2:])) + 1:
            ends = (at[k - 1], at[k + 1])
            best = minimize_scalar(lambda x: float(least(sign * 10.0**x)), bounds=ends, method="bounded")  # noqa: B023
            found = min(found, float(best.fun), float(seen[k]))
        found = min(found, float(seen[0]), float(seen[-1]))
    return max(0.0, found - ROUNDED * len(pressed))
