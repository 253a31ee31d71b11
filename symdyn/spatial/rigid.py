"""Placements of frames: rotation and translation, generic in the scalar.

T_AB = (R_AB, p_AB)     takes coordinates in B to coordinates in A: x_A = R_AB x_B + p_AB
T_AC = T_AB @ T_BC      inner letters match
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Expr, Graph
from symdyn.spatial.vector import Mat, Vec, add, apply, identity, multiply, neg, rotation, transpose, zero_vector


@dataclass(frozen=True)
class Transform:
    """A rigid placement; R and p as in the module's legend."""

    R: Mat
    p: Vec

    def __matmul__(self, other: Transform) -> Transform:
        """Return the product T_AC = T_AB @ T_BC."""
        R = other.R if self.is_shift else self.R if other.is_shift else multiply(self.R, other.R)
        return Transform(R, self.point(other.p))

    @property
    def is_shift(self) -> bool:
        """Whether nothing is turned; a rotation with ones on its diagonal is none."""
        one = self.p[0].graph.one
        return self.R[0][0] is one and self.R[1][1] is one and self.R[2][2] is one

    def point(self, x: Vec) -> Vec:
        """Return the point x_B in A."""
        return add(x if self.is_shift else apply(self.R, x), self.p)

    def inverse(self) -> Transform:
        """Return T_BA."""
        back = transpose(self.R)
        return Transform(back, neg(apply(back, self.p)))


def unit_transform(graph: Graph) -> Transform:
    """Return the identity."""
    return Transform(identity(graph), zero_vector(graph))


def elementary(kind: str, amount: Expr) -> Transform:
    """Return one of "Tx", "Ty", "Tz" (m) or "Rx", "Ry", "Rz" (rad)."""
    graph = amount.graph
    k = "xyz".index(kind[1])
    direction = tuple(graph.one if i == k else graph.zero for i in range(3))
    if kind[0] == "R":
        return Transform(rotation(direction, amount), zero_vector(graph))  # type: ignore[arg-type]
    shift = tuple(amount if i == k else graph.zero for i in range(3))
    return Transform(identity(graph), shift)  # type: ignore[arg-type]
