"""Vectors, rotations, placements and inertias over graph nodes: tuples, unrolled, zeros fall away at birth.

T_AB = (R_AB, p_AB)     takes coordinates in B to coordinates in A: x_A = R_AB x_B + p_AB
T_AC = T_AB @ T_BC      inner letters match
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, overload

from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Scalar

Vec = tuple[Expr, Expr, Expr]


def zero_vector(graph: Graph) -> Vec:
    """Return 0."""
    return (graph.zero,) * 3


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


class Mat(tuple[Vec, Vec, Vec]):
    """A matrix of 3 rows: R @ x and R @ S are products, R.T is the transpose."""

    __slots__ = ()

    @staticmethod
    def identity(graph: Graph) -> Mat:
        one, zero = graph.one, graph.zero
        return Mat(((one, zero, zero), (zero, one, zero), (zero, zero, one)))

    @staticmethod
    def skew(a: Vec) -> Mat:
        """Return ã with ã b = a × b, eq. (5.2)."""
        zero = a[0].graph.zero
        return Mat(((zero, -a[2], a[1]), (a[2], zero, -a[0]), (-a[1], a[0], zero)))

    @staticmethod
    def outer(a: Vec, b: Vec) -> Mat:
        """Return a bᵀ."""
        return Mat((scale(a[0], b), scale(a[1], b), scale(a[2], b)))

    @staticmethod
    def symmetric(xx: Expr, yy: Expr, zz: Expr, xy: Expr, xz: Expr, yz: Expr) -> Mat:
        return Mat(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))

    @staticmethod
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
                return Mat((x, y, z) for x, y, z in rows)
        turned = Mat.identity(graph).scaled(c) + Mat.skew(axis).scaled(s)
        rest = one - c
        return turned + Mat.outer(axis, axis).scaled(rest)

    @staticmethod
    def towards(u: Vec) -> Mat:
        """Return the shortest rotation from z to the unit vector u: 1 + ṽ + ṽ² / (1 + u_z), v = z × u.

        It needs no root beyond those of u; for u = -z it is a half turn about x.
        """
        graph = u[0].graph
        one, zero = graph.one, graph.zero
        if u[2] is graph.constant(-1):
            return Mat(((one, zero, zero), (zero, -one, zero), (zero, zero, -one)))
        v = Mat.skew(cross((zero, zero, one), u))
        sides, share = Mat.identity(graph) + v, 1 / (1 + u[2])
        return sides + (v @ v).scaled(share)

    @staticmethod
    def of_quaternion(e: tuple[Expr, ...]) -> Mat:
        """Return the rotation of a unit quaternion (w, x, y, z): columns are the rotated axes."""
        w, x, y, z = e
        one = w.graph.one
        return Mat(
            (
                (one - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
                (2 * (x * y + w * z), one - 2 * (x * x + z * z), 2 * (y * z - w * x)),
                (2 * (x * z - w * y), 2 * (y * z + w * x), one - 2 * (x * x + y * y)),
            )
        )

    @property
    def T(self) -> Mat:
        a, b, c = self
        return Mat(((a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2])))

    @property
    def is_unit(self) -> bool:
        """Whether it is the unit matrix, as most of a mechanism are."""
        graph = self[0][0].graph
        return self[0][0] is graph.one and self == Mat.identity(graph)

    @overload
    def __matmul__(self, other: Mat) -> Mat: ...

    @overload
    def __matmul__(self, other: Vec) -> Vec: ...

    def __matmul__(self, other: Mat | Vec) -> Mat | Vec:
        if self.is_unit:
            return other
        a, b, c = self
        if not isinstance(other, Mat):
            return (dot(a, other), dot(b, other), dot(c, other))
        if other.is_unit:
            return self
        x, y, z = other.T
        return Mat(
            (
                (dot(a, x), dot(a, y), dot(a, z)),
                (dot(b, x), dot(b, y), dot(b, z)),
                (dot(c, x), dot(c, y), dot(c, z)),
            )
        )

    def __add__(self, other: Mat) -> Mat:  # type: ignore[override]
        return Mat((add(self[0], other[0]), add(self[1], other[1]), add(self[2], other[2])))

    def scaled(self, factor: Scalar) -> Mat:
        return Mat((scale(factor, self[0]), scale(factor, self[1]), scale(factor, self[2])))

    def mirrored(self) -> Mat:
        """Return it with the lower triangle taken from the upper, so that equal entries are one node."""
        x, y, z = self
        return Mat.symmetric(x[0], y[1], z[2], x[1], x[2], y[2])

    def spin(self, rates: Sequence[Sequence[Expr]]) -> Vec:
        """Return ω in fixed axes from ω̃ = Ṙ Rᵀ, for the rates Ṙ of this rotation R."""
        x, y, z = ((row[0], row[1], row[2]) for row in rates)
        return (dot(z, self[1]), dot(x, self[2]), dot(y, self[0]))


class Wrench(NamedTuple):
    """Force and moment, in this order."""

    force: Vec
    moment: Vec

    @staticmethod
    def none(graph: Graph) -> Wrench:
        return Wrench(zero_vector(graph), zero_vector(graph))

    @staticmethod
    def units(graph: Graph) -> tuple[Wrench, ...]:
        """Return unit forces and moments along the axes, six."""
        nothing, axes = zero_vector(graph), Mat.identity(graph)
        return (*(Wrench(x, nothing) for x in axes), *(Wrench(nothing, x) for x in axes))

    def __add__(self, other: Wrench) -> Wrench:  # type: ignore[override]
        return Wrench(add(self[0], other[0]), add(self[1], other[1]))

    def __neg__(self) -> Wrench:
        """Return the wrench that holds it in balance."""
        return Wrench(neg(self[0]), neg(self[1]))

    def scaled(self, factor: Scalar) -> Wrench:
        """Return factor times the wrench."""
        return Wrench(scale(factor, self[0]), scale(factor, self[1]))

    def power(self, twist: tuple[Vec, Vec]) -> Expr:
        """Return F·v + M·ω."""
        return dot(self[0], twist[0]) + dot(self[1], twist[1])

    def rotated(self, R: Mat) -> Wrench:
        """Return it in other axes: R F and R M."""
        return Wrench(R @ self[0], R @ self[1])

    def about(self, way: Vec) -> Wrench:
        """Return it about a point that lies at -way from where it acts: the shift R̄ of (5.3)."""
        return Wrench(self[0], add(self[1], cross(way, self[0])))


@dataclass(frozen=True)
class Transform:
    """A rigid placement; R and p as in the module's legend."""

    R: Mat
    p: Vec

    @staticmethod
    def unit(graph: Graph) -> Transform:
        return Transform(Mat.identity(graph), zero_vector(graph))

    @staticmethod
    def turn(axis: Vec, angle: Expr) -> Transform:
        """Return the turn by `angle` (rad) about a unit `axis` through the origin."""
        return Transform(Mat.rotation(axis, angle), zero_vector(angle.graph))

    @staticmethod
    def elementary(kind: str, amount: Expr) -> Transform:
        """Return one of "Tx", "Ty", "Tz" (m) or "Rx", "Ry", "Rz" (rad)."""
        graph = amount.graph
        k = "xyz".index(kind[1])
        direction = tuple(graph.one if i == k else graph.zero for i in range(3))
        if kind[0] == "R":
            return Transform.turn(direction, amount)  # type: ignore[arg-type]
        shift = tuple(amount if i == k else graph.zero for i in range(3))
        return Transform(Mat.identity(graph), shift)  # type: ignore[arg-type]

    def __matmul__(self, other: Transform) -> Transform:
        """Return the product T_AC = T_AB @ T_BC."""
        R = other.R if self.is_shift else self.R if other.is_shift else self.R @ other.R
        return Transform(R, self.point(other.p))

    @property
    def is_shift(self) -> bool:
        """Whether nothing is turned; a rotation with ones on its diagonal is none."""
        one = self.p[0].graph.one
        return self.R[0][0] is one and self.R[1][1] is one and self.R[2][2] is one

    def point(self, x: Vec) -> Vec:
        """Return the point x_B in A."""
        return add(x if self.is_shift else self.R @ x, self.p)

    def inverse(self) -> Transform:
        back = self.R.T
        return Transform(back, neg(back @ self.p))


@dataclass(frozen=True)
class Inertia:
    """Mass, kg, first moment h = m r, kg m, and inertia matrix about the origin, kg m^2, products as its entries."""

    m: Expr
    h: Vec
    I: Mat  # noqa: E741  the book's name

    @staticmethod
    def none(graph: Graph) -> Inertia:
        nothing = zero_vector(graph)
        return Inertia(graph.zero, nothing, Mat((nothing, nothing, nothing)))

    @staticmethod
    def of_point(mass: Expr, at: Vec) -> Inertia:
        """Return the inertia of a point mass: I = m (r² 1 - r rᵀ)."""
        squares = Mat.outer(at, at)
        spread = Mat.identity(mass.graph).scaled(dot(at, at))
        about = (spread + squares.scaled(-1)).scaled(mass)
        return Inertia(mass, scale(mass, at), about)

    def __add__(self, other: Inertia) -> Inertia:
        return Inertia(self.m + other.m, add(self.h, other.h), self.I + other.I)

    def seen_from(self, T: Transform) -> Inertia:
        """Return the inertia in frame B, for T = T_BA.

        With x' = R x + p:  h' = R h + m p,  I' = R I Rᵀ + (2 p·R h + m p²) 1 - p (R h)ᵀ - (R h) pᵀ - m p pᵀ.
        """
        h, turned, p, m = self.h, self.I, T.p, self.m
        if not T.is_shift:
            h, turned = T.R @ h, T.R @ turned @ T.R.T
        spread = dot(p, h) * 2 + m * dot(p, p)
        mixed = Mat.outer(p, add(h, scale(m, p)))
        off = mixed + Mat.outer(h, p)
        shifted = turned + (Mat.identity(m.graph).scaled(spread) + off.scaled(-1))
        return Inertia(m, add(h, scale(m, p)), shifted.mirrored())

    def momentum(self, w: Vec, v: Vec) -> tuple[Vec, Vec]:
        """Return (angular, linear) momentum about the origin for angular velocity w and velocity v of the origin."""
        return add(self.I @ w, cross(self.h, v)), add(scale(self.m, v), cross(w, self.h))
