"""From the mass matrix to Coriolis and centrifugal coefficients, by Christoffel symbols of the first kind.

    c_ijk  = ½ (∂M_ij/∂q_k + ∂M_ik/∂q_j - ∂M_jk/∂q_i)
    k_D    [i, j]  = c_ijj                     multiplies q̇_j²          shape (n, n)
    k_C    [i, jk] = 2 c_ijk, j < k            multiplies q̇_j q̇_k       shape (n, n(n-1)/2), pairs lexicographic
    C      [i, j]  = Σ_k c_ijk q̇_k            Ṁ - 2C is skew           shape (n, n)

Reference: Siciliano et al., Robotics (2009), eq. (7.44)-(7.45); the split into k_C and k_D is the textbook's (5.40).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from symdyn.graph import Expr, tangents

Matrix = list[list[Expr]]


@dataclass(frozen=True)
class Christoffel:
    """Christoffel symbols: `slopes[k][i][j]` = ∂M_ij/∂q_k."""

    slopes: tuple[Matrix, ...]

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.slopes)

    def twice(self, i: int, j: int, k: int) -> Expr:
        """Return 2 c_ijk."""
        d = self.slopes
        return d[k][i][j] + d[j][i][k] - d[i][j][k]

    def centrifugal(self) -> Matrix:
        """Return k_D, shape (n, n)."""
        n = range(self.n)
        return [[self.twice(i, j, j) / 2 for j in n] for i in n]

    def coriolis(self) -> Matrix:
        """Return k_C, shape (n, n(n-1)/2)."""
        return [[self.twice(i, j, k) for j, k in combinations(range(self.n), 2)] for i in range(self.n)]

    def coriolis_matrix(self, qd: Sequence[Expr]) -> Matrix:
        """Return C(q, q̇), shape (n, n)."""
        n = range(self.n)
        zero = qd[0].graph.zero
        return [[sum((self.twice(i, j, k) * qd[k] for k in n), zero) / 2 for j in n] for i in n]


def christoffel(M: Matrix, q: Sequence[Expr]) -> Christoffel:
    """Return the Christoffel symbols of a symmetric mass matrix, shape (n, n), in the coordinates q."""
    n = len(q)
    upper = [M[i][j] for i in range(n) for j in range(i, n)]
    slopes = []
    for coordinate in q:
        flat = iter(tangents(upper, {coordinate: coordinate.graph.one}))
        slope: Matrix = [[coordinate.graph.zero] * n for _ in range(n)]
        for i in range(n):
            for j in range(i, n):
                slope[i][j] = slope[j][i] = next(flat)
        slopes.append(slope)
    return Christoffel(tuple(slopes))
