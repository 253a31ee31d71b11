"""Solving M q̈ = b by M = Lᵀ D L, without square roots and without fill-in between branches.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 6.5, tables 6.3 and 6.4.

Elimination starts at the tips, so that L keeps the zeros of M: row i has entries for the ancestors of joint i only.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.scene import Scene


def solve(parent: Sequence[int], M: list[list[Expr]], b: Sequence[Expr]) -> list[Expr]:
    """Return M⁻¹ b, shape (n,), of a symmetric M, shape (n, n); Singular where a massless body ends a branch.

    Of the moving bodies 1..n parent[i] < i, entry 0 unused: M[i-1][j-1] is zero unless one of i, j is an ancestor of
    the other. A chain (0, 0, 1, 2, …) promises nothing.
    """
    n = len(b)
    H = [list(row) for row in M]
    for k in range(n, 0, -1):
        pivot = H[k - 1][k - 1]
        if pivot.is_zero:
            raise Singular(k - 1)
        for i in _path(parent, parent[k]):
            if H[k - 1][i - 1].is_zero:
                continue
            a = H[k - 1][i - 1] / pivot
            for j in _path(parent, i):
                H[i - 1][j - 1] = H[i - 1][j - 1] - a * H[k - 1][j - 1]
            H[k - 1][i - 1] = a
    x = list(b)
    for i in range(n, 0, -1):  # Lᵀ y = b
        for j in _path(parent, parent[i]):
            x[j - 1] = x[j - 1] - H[i - 1][j - 1] * x[i - 1]
    x = [x[i] / H[i][i] for i in range(n)]  # D z = y
    for i in range(1, n + 1):  # L x = z
        for j in _path(parent, parent[i]):
            x[i - 1] = x[i - 1] - H[i - 1][j - 1] * x[j - 1]
    return x


def _path(parent: Sequence[int], i: int) -> list[int]:
    """Return i and its ancestors, down to the last moving body."""
    bodies = []
    while i > 0:
        bodies.append(i)
        i = parent[i]
    return bodies


class Singular(DerivationError):  # noqa: N818  what the matrix is
    """A mass matrix that is singular.

    Attributes:
        velocity: index of the row where elimination ends; of a tree's mass matrix, a velocity that moves no mass.
    """

    def __init__(self, velocity: int) -> None:
        """Store the velocity; `moves_no_mass` says it in words of the scene."""
        self.velocity = velocity
        super().__init__(
            "forward dynamics does not exist: the mass matrix is singular; give every body that ends a branch a mass "
            "or an inertia"
        )


def moves_no_mass(scene: Scene, velocity: int, of: str = "") -> str:
    """Return the message for a singular mass matrix `of` something: which joint and body to look at."""
    joint = next(joint for joint in scene.joints if scene.velocities[velocity] in joint.rates)
    return (
        f"{scene.name}: forward dynamics does not exist: a motion of the joint {joint.name}, which carries "
        f"{joint.child}, moves no mass, so that the mass matrix{of} is singular; give {joint.child} a mass or an "
        "inertia, or fix the joint"
    )
