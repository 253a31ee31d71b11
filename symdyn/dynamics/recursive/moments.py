"""Inertia by second moments: mass, first moment m r and J = Σ m r rᵀ, about the origin of a frame.

The inertia matrix is I = tr(J) 1 - J, and J = ½ tr(I) 1 - I back again. J moves with fewer operations than I, and what
a revolute joint cannot feel stands in it by itself: everything on the joint's axis is m, h_z and J_zz.

    shift by p    h' = h + m p,    J' = J + p (h + ½ m p)ᵀ + (h + ½ m p) pᵀ
    turn by R     h' = R h,        J' = R J Rᵀ

Where points r of the body accelerate by a + U r, Newton's and Euler's equations about the frame's origin are

    f = m a + U h,    n = h × a + axis of (U J - J Uᵀ),    its x being U_y·J_z - U_z·J_y and so on
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Expr, Op
from symdyn.spatial import Inertia, Mat, Vec, add, cross, scale


@dataclass(frozen=True)
class Moments:
    """Ten inertial parameters in a frame: mass, kg, first moment m r, kg m, J = Σ m r rᵀ about the origin, kg m^2."""

    m: Expr
    h: Vec
    J: Mat

    @property
    def polar(self) -> Expr:
        """The moment of inertia about z, J_xx + J_yy."""
        return self.J[0][0] + self.J[1][1]

    def __add__(self, other: Moments) -> Moments:
        """Return the moments of both together, in one frame."""
        return Moments(self.m + other.m, add(self.h, other.h), self.J + other.J)

    def shifted(self, p: Vec) -> Moments:
        """Return the moments about an origin that lies at -p."""
        u = add(self.h, scale(self.m / 2, p))
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = self.J
        J = Mat.symmetric(
            xx + p[0] * 2 * u[0],
            yy + p[1] * 2 * u[1],
            zz + p[2] * 2 * u[2],
            xy + p[0] * u[1] + p[1] * u[0],
            xz + p[0] * u[2] + p[2] * u[0],
            yz + p[1] * u[2] + p[2] * u[1],
        )
        x, y, z = scale(self.m, p)
        return Moments(self.m, (_plus(self.h[0], x), _plus(self.h[1], y), _plus(self.h[2], z)), J)

    def wrench(self, a: Vec, U: Mat) -> tuple[Vec, Vec]:
        """Return the moment and force (n, f) that give the body its motion; N m and N."""
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = self.J
        plane = U[0][1] is -U[1][0]  # it turns about z alone
        turning = (
            U[2][0] * xy - U[1][0] * xz + (U[2][2] - U[1][1]) * yz + U[2][1] * yy - U[1][2] * zz,
            U[0][1] * yz - U[2][1] * xy + (U[0][0] - U[2][2]) * xz + U[0][2] * zz - U[2][0] * xx,
            U[1][2] * xz
            - U[0][2] * yz
            + (U[1][1] - U[0][0]) * xy
            + (U[1][0] * self.polar if plane else U[1][0] * xx - U[0][1] * yy),
        )
        return add(turning, cross(self.h, a)), add(scale(self.m, a), U @ self.h)


@dataclass(frozen=True)
class TurnedMoments(Moments):
    """Moments that have been turned about z, which leaves the polar moment as it was before."""

    before: Moments

    @property
    def polar(self) -> Expr:
        """The moment of inertia about z, without adding up what has turned."""
        return self.before.polar


def _plus(a: Expr, b: Expr) -> Expr:
    """Return a + b, and x for (x - b) + b: a frame that was moved along its axis is often moved back."""
    return a.args[0] if a.op is Op.SUB and a.args[1] is b else a + b


def moments_of(inertia: Inertia) -> Moments:
    """Return an inertia by its second moments."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia.I
    J = Mat.symmetric((yy + zz - xx) / 2, (xx + zz - yy) / 2, (xx + yy - zz) / 2, -xy, -xz, -yz)
    return Moments(inertia.m, inertia.h, J)
