"""From the mass matrix to Coriolis and centrifugal coefficients, by the Levi-Civita connection of M.

    k_D[i, j]   = X_j M_ij - ½ X_i M_jj - γ^l_ji M_lj                            multiplies u_j²       shape (n, n)
    k_C[i, jk]  = X_k M_ij + X_j M_ik - X_i M_jk - γ^l_ji M_lk - γ^l_ki M_lj     multiplies u_j u_k    j < k
    C[i, j]     = Σ_k ⟨∇_k X_j, X_i⟩ u_k                                         Ṁ - 2C is skew        shape (n, n)

    2 ⟨∇_k X_j, X_i⟩ = X_k M_ij + X_j M_ik - X_i M_jk + γ^l_kj M_li - γ^l_ji M_lk - γ^l_ki M_lj

For rates of coordinates X_i = ∂/∂q_i and γ = 0: these are Christoffel symbols of the first kind.

Reference: Siciliano et al., Robotics (2009), eq. (7.44)-(7.45), and Koszul's formula for frames that do not commute;
the split into k_C and k_D is the textbook's (5.40).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from symdyn.dynamics.mechanism.directions import Brackets, Directions
from symdyn.graph import Expr

Matrix = list[list[Expr]]


@dataclass(frozen=True)
class Christoffel:
    """The connection of a mass matrix: `slopes[k][i][j]` = X_k M_ij, and the brackets of the velocities."""

    M: Matrix
    slopes: tuple[Matrix, ...]
    brackets: Brackets

    @property
    def n(self) -> int:
        """Number of velocities."""
        return len(self.slopes)

    def twice(self, i: int, j: int, k: int) -> Expr:
        """Return the coefficient of u_j u_k in force i, of j k and k j together: 2 c_ijk for rates of coordinates."""
        d = self.slopes
        return d[k][i][j] + d[j][i][k] - d[i][j][k] - self._turned(j, i, k) - self._turned(k, i, j)

    def centrifugal(self) -> Matrix:
        """Return k_D, shape (n, n)."""
        n = range(self.n)
        return [[self.twice(i, j, j) / 2 for j in n] for i in n]

    def coriolis(self) -> Matrix:
        """Return k_C, shape (n, n(n-1)/2)."""
        return [[self.twice(i, j, k) for j, k in combinations(range(self.n), 2)] for i in range(self.n)]

    def coriolis_matrix(self, qd: Sequence[Expr]) -> Matrix:
        """Return C(q, u), shape (n, n)."""
        n = range(self.n)
        zero = qd[0].graph.zero
        return [
            [sum(((self.twice(i, j, k) + self._turned(k, j, i)) * qd[k] for k in n), zero) / 2 for j in n] for i in n
        ]

    def _turned(self, j: int, i: int, k: int) -> Expr:
        """Return Σ γ^l_ji M_lk."""
        terms = self.brackets.get((j, i), ())
        return sum((self.M[m][k] * value for m, value in terms), self.M[0][0].graph.zero)


def christoffel(M: Matrix, along: Directions) -> Christoffel:
    """Return the connection of a symmetric mass matrix, shape (n, n), for velocities along the given directions."""
    n = len(M)
    upper = [M[i][j] for i in range(n) for j in range(i, n)]
    slopes = []
    for k in range(n):
        flat = iter(along.derivative(upper, k))
        slope: Matrix = [[M[0][0]] * n for _ in range(n)]
        for i in range(n):
            for j in range(i, n):
                slope[i][j] = slope[j][i] = next(flat)
        slopes.append(slope)
    return Christoffel(M, tuple(slopes), along.brackets)
