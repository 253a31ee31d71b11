"""Vectors, rotations, placements and inertias over graph nodes: tuples, unrolled, zeros fall away at birth.

T_AB = (R_AB, p_AB)     takes coordinates in B to coordinates in A: x_A = R_AB x_B + p_AB
T_AC = T_AB @ T_BC      inner letters match
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.graph import Expr, Graph, Scalar

Vec = tuple[Expr, Expr, Expr]
Mat = tuple[Vec, Vec, Vec]  # rows
Wrench = tuple[Vec, Vec]  # force, moment


def zero_vector(graph: Graph) -> Vec:
    """Return 0."""
    return (graph.zero,) * 3


def identity(graph: Graph) -> Mat:
    """Return the unit matrix."""
    one, zero = graph.one, graph.zero
    return ((one, zero, zero), (zero, one, zero), (zero, zero, one))


def add(a: Vec, b: Vec) -> Vec:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Vec, b: Vec) -> Vec:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def neg(a: Vec) -> Vec:
    """Return -a."""
    return (-a[0], -a[1], -a[2])


def scale(factor: Scalar, a: Vec) -> Vec:
    """Return factor a."""
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def dot(a: Vec, b: Vec) -> Expr:
    """Return a · b."""
    mul, add = a[0].graph.mul, a[0].graph.add  # in half the time of the operators
    return add(add(mul(a[0], b[0]), mul(a[1], b[1])), mul(a[2], b[2]))


def cross(a: Vec, b: Vec) -> Vec:
    """Return a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def skew(a: Vec) -> Mat:
    """Return ã with ã b = a × b, eq. (5.2)."""
    zero = a[0].graph.zero
    return ((zero, -a[2], a[1]), (a[2], zero, -a[0]), (-a[1], a[0], zero))


def transpose(m: Mat) -> Mat:
    """Return mᵀ."""
    return (
        (m[0][0], m[1][0], m[2][0]),
        (m[0][1], m[1][1], m[2][1]),
        (m[0][2], m[1][2], m[2][2]),
    )


def apply(m: Mat, a: Vec) -> Vec:
    """Return m a; most matrices of a mechanism are the unit matrix."""
    if m == identity(a[0].graph):
        return a
    return (dot(m[0], a), dot(m[1], a), dot(m[2], a))


def multiply(m: Mat, n: Mat) -> Mat:
    """Return m n; most matrices of a mechanism are the unit matrix."""
    unit = identity(m[0][0].graph)
    if unit in (m, n):
        return n if m == unit else m
    columns = transpose(n)
    return (
        (dot(m[0], columns[0]), dot(m[0], columns[1]), dot(m[0], columns[2])),
        (dot(m[1], columns[0]), dot(m[1], columns[1]), dot(m[1], columns[2])),
        (dot(m[2], columns[0]), dot(m[2], columns[1]), dot(m[2], columns[2])),
    )


def add_matrices(m: Mat, n: Mat) -> Mat:
    """Return m + n."""
    return (add(m[0], n[0]), add(m[1], n[1]), add(m[2], n[2]))


def scale_matrix(factor: Scalar, m: Mat) -> Mat:
    """Return factor m."""
    return (scale(factor, m[0]), scale(factor, m[1]), scale(factor, m[2]))


def outer(a: Vec, b: Vec) -> Mat:
    """Return a bᵀ."""
    return (scale(a[0], b), scale(a[1], b), scale(a[2], b))


def rotation(axis: Vec, angle: Expr) -> Mat:
    """Return the rotation by `angle` (rad) about a unit `axis`: R = c 1 + s ã + (1 - c) a aᵀ (Rodrigues).

    Columns are the rotated axes: R takes rotated coordinates to fixed ones. On a coordinate axis the third term
    is written out, so that no 1 - c + c is left behind.
    """
    graph = angle.graph
    s, c, one, zero = graph.sin(angle), graph.cos(angle), graph.one, graph.zero
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        if axis[i] is zero and axis[j] is zero:
            s = s if axis[k] is one else -s
            rows = [[zero] * 3 for _ in range(3)]
            rows[k][k] = one
            rows[i][i], rows[i][j], rows[j][i], rows[j][j] = c, -s, s, c
            return ((*rows[0],), (*rows[1],), (*rows[2],))  # type: ignore[return-value]
    turned = scale_matrix(c, identity(graph))
    return add_matrices(add_matrices(turned, scale_matrix(s, skew(axis))), scale_matrix(one - c, outer(axis, axis)))


def spin(rates: Sequence[Sequence[Expr]], R: Mat) -> Vec:
    """Return ω in fixed axes from ω̃ = Ṙ Rᵀ, for the rates Ṙ of a rotation R."""
    x, y, z = ((row[0], row[1], row[2]) for row in rates)
    return (dot(z, R[1]), dot(x, R[2]), dot(y, R[0]))


def symmetric(xx: Expr, yy: Expr, zz: Expr, xy: Expr, xz: Expr, yz: Expr) -> Mat:
    """Return the symmetric matrix with these entries."""
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def mirrored(m: Mat) -> Mat:
    """Return m with the lower triangle taken from the upper, so that equal entries are one node."""
    return symmetric(m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])


# Wrenches, and twists (velocity, angular velocity) that they do work on


def nothing(graph: Graph) -> Wrench:
    """Return the wrench of nothing."""
    return zero_vector(graph), zero_vector(graph)


def plus(a: Wrench, b: Wrench) -> Wrench:
    """Return a + b."""
    return add(a[0], b[0]), add(a[1], b[1])


def times(factor: Scalar, wrench: Wrench) -> Wrench:
    """Return factor · wrench."""
    return scale(factor, wrench[0]), scale(factor, wrench[1])


def power(wrench: Wrench, twist: Wrench) -> Expr:
    """Return F·v + M·ω."""
    return dot(wrench[0], twist[0]) + dot(wrench[1], twist[1])


def rotated(R: Mat, wrench: Wrench) -> Wrench:
    """Return a wrench in other axes: R F and R M."""
    return apply(R, wrench[0]), apply(R, wrench[1])


def about(wrench: Wrench, way: Vec) -> Wrench:
    """Return a wrench about a point that lies at -way from where it acts: the shift R̄ of (5.3)."""
    return wrench[0], add(wrench[1], cross(way, wrench[0]))


# Placements of frames


@dataclass(frozen=True)
class Transform:
    """A rigid placement; R and p as in the module's legend."""

    R: Mat
    p: Vec

    @staticmethod
    def unit(graph: Graph) -> Transform:
        """Return the identity."""
        return Transform(identity(graph), zero_vector(graph))

    @staticmethod
    def turn(axis: Vec, angle: Expr) -> Transform:
        """Return the turn by `angle` (rad) about a unit `axis` through the origin."""
        return Transform(rotation(axis, angle), zero_vector(angle.graph))

    @staticmethod
    def elementary(kind: str, amount: Expr) -> Transform:
        """Return one of "Tx", "Ty", "Tz" (m) or "Rx", "Ry", "Rz" (rad)."""
        graph = amount.graph
        k = "xyz".index(kind[1])
        direction = tuple(graph.one if i == k else graph.zero for i in range(3))
        if kind[0] == "R":
            return Transform.turn(direction, amount)  # type: ignore[arg-type]
        shift = tuple(amount if i == k else graph.zero for i in range(3))
        return Transform(identity(graph), shift)  # type: ignore[arg-type]

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


# Inertias


@dataclass(frozen=True)
class Inertia:
    """Mass, kg, first moment h = m r, kg m, and inertia matrix about the origin, kg m^2, products as its entries."""

    m: Expr
    h: Vec
    I: Mat  # noqa: E741  the book's name

    @staticmethod
    def none(graph: Graph) -> Inertia:
        """Return the inertia of nothing."""
        nothing = zero_vector(graph)
        return Inertia(graph.zero, nothing, (nothing, nothing, nothing))

    @staticmethod
    def of_point(mass: Expr, at: Vec) -> Inertia:
        """Return the inertia of a point mass: I = m (r² 1 - r rᵀ)."""
        squares = outer(at, at)
        spread = scale_matrix(dot(at, at), identity(mass.graph))
        about = scale_matrix(mass, add_matrices(spread, scale_matrix(-1, squares)))
        return Inertia(mass, scale(mass, at), about)

    def __add__(self, other: Inertia) -> Inertia:
        """Return the inertia of both together."""
        return Inertia(self.m + other.m, add(self.h, other.h), add_matrices(self.I, other.I))

    def seen_from(self, T: Transform) -> Inertia:
        """Return the inertia in frame B, for T = T_BA.

        With x' = R x + p:  h' = R h + m p,  I' = R I Rᵀ + (2 p·R h + m p²) 1 - p (R h)ᵀ - (R h) pᵀ - m p pᵀ.
        """
        h, turned, p, m = self.h, self.I, T.p, self.m
        if not T.is_shift:
            h, turned = apply(T.R, h), multiply(multiply(T.R, turned), transpose(T.R))
        spread = dot(p, h) * 2 + m * dot(p, p)
        mixed = outer(p, add(h, scale(m, p)))
        off = add_matrices(mixed, outer(h, p))
        shifted = add_matrices(turned, add_matrices(scale_matrix(spread, identity(m.graph)), scale_matrix(-1, off)))
        return Inertia(m, add(h, scale(m, p)), mirrored(shifted))

    def momentum(self, w: Vec, v: Vec) -> tuple[Vec, Vec]:
        """Return (angular, linear) momentum about the origin for angular velocity w and velocity v of the origin."""
        return add(apply(self.I, w), cross(self.h, v)), add(scale(self.m, v), cross(w, self.h))
