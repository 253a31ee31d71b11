"""Inertias as cones: pseudo-inertias whose eigenvalues stay above a bound, and what the cones hold nearest to a point.

P_k     pseudo-inertia of body k, [[J/rho^2, h/rho], [h/rho, m]], kg; linear in its ten parameters
y       R (pi - best): variables in which the distance is |y|
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import IdentifyError
from symdyn.extras import install
from symdyn.identification.unknowns import TEN

TOLERANCES = (1e-10, 1e-8, 1e-6)
"""Of the solver, one after the other where it does not get as far."""

UPPER = tuple((i, j) for j in range(4) for i in range(j + 1))
"""Entries of a symmetric 4 by 4 matrix, column by column, as clarabel wants its triangle."""


def pseudo_rows(k: int, p: int, length: float) -> Array:
    """Return the triangle of the pseudo-inertia of body k as rows, shape (10, p); lengths in rho."""
    m, x, y, z, xx, yy, zz, xy, xz, yz = range(TEN * k, TEN * (k + 1))
    rows = np.zeros((TEN, p))
    square = length**2
    for at, (i, j) in enumerate(UPPER):
        if i == j == 3:
            rows[at, m] = 1
        elif j == 3:
            rows[at, (x, y, z)[i]] = 1 / length
        elif i == j:
            for other in (xx, yy, zz):
                rows[at, other] = (-0.5 if other == (xx, yy, zz)[i] else 0.5) / square
        else:
            rows[at, {(0, 1): xy, (0, 2): xz, (1, 2): yz}[i, j]] = -1 / square
    return rows


def matrix(upper: Array) -> Array:
    """Return a symmetric 4 by 4 matrix from its upper triangle."""
    found = np.zeros((4, 4))
    for (i, j), x in zip(UPPER, upper, strict=True):
        found[i, j] = found[j, i] = x
    return found


def triangle(full: Array) -> Array:
    """Return the upper triangle with the length that the matrix has: off the diagonal times the root of two."""
    return np.array([full[i, j] * (1 if i == j else sqrt(2)) for i, j in UPPER])


class Cones:
    """What values must satisfy: rows G pi + c in a product of cones."""

    def __init__(self, count: int) -> None:
        self.zero: list[tuple[Array, float]] = []
        self.above: list[tuple[Array, float]] = []
        self.definite: list[tuple[Array, float]] = []
        self.count = count

    def equal(self, row: Array, value: float) -> None:
        """Take a row whose product is to be a value."""
        self.zero.append((row, value))

    def not_negative(self, row: Array, least: float) -> None:
        """Take a row whose product is to be no less."""
        self.above.append((row, least))

    def positive_definite(self, rows: Array, least: float) -> None:
        """Take the triangle of a matrix, none of whose eigenvalues is to be below `least`."""
        self.definite.append((rows, least))

    def hold(self, values: Array) -> bool:
        """Tell whether values satisfy all of it."""
        return (
            all(abs(row @ values - value) <= 1e-9 * abs(value) for row, value in self.zero)
            and all(row @ values >= least for row, least in self.above)
            and all(np.linalg.eigvalsh(matrix(rows @ values))[0] >= least for rows, least in self.definite)
        )

    def stacked(self) -> tuple[Array, Array]:
        """Return G and c."""
        every = [*self.zero, *self.above]
        rows = [row[None, :] for row, _ in every]
        more = [np.array([-value]) for _, value in every]
        scale = triangle(np.ones((4, 4)))
        for upper, least in self.definite:
            rows.append(scale[:, None] * upper)
            more.append(-least * triangle(np.eye(4)))
        return np.vstack(rows), np.concatenate(more)


def projected(cones: Cones, best: Array, R: Array) -> Array:
    """Return what the cones hold nearest to `best`, by |R (pi - best)|."""
    try:
        import clarabel
    except ImportError:
        raise IdentifyError(
            f"these estimates are those of no body; finding ones near them needs clarabel: {install('identify')}"
        ) from None
    from scipy.sparse import csc_matrix, identity

    G, c = cones.stacked()
    back = np.linalg.solve(R, np.eye(cones.count))
    kinds = [(clarabel.ZeroConeT, len(cones.zero)), (clarabel.NonnegativeConeT, len(cones.above))]
    shapes = [kind(n) for kind, n in kinds if n] + [clarabel.PSDTriangleConeT(4) for _ in cones.definite]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    for tolerance in TOLERANCES:
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        problem = (identity(cones.count, format="csc"), np.zeros(cones.count), csc_matrix(-G @ back), G @ best + c)
        solution = clarabel.DefaultSolver(*problem, shapes, settings).solve()
        status = str(solution.status)
        if status in ("Solved", "AlmostSolved"):
            break
    else:
        if "Infeasible" in status:
            advice = "no bodies have what is asked of them; ask less of masses and ellipsoids"
        else:
            advice = (
                "the solver of cones does not get through: standard errors of these estimates lie too far apart, as "
                "those of a log with hardly any noise, or of units that are off; look at both, and at outliers"
            )
        raise IdentifyError(f"{advice} (clarabel ends with {status})")
    found: Array = best + back @ np.array(solution.x)
    return found
