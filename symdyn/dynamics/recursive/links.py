"""Joint transforms, inertias and motions as the recursions take them, factored so that nothing is multiplied out.

A joint transform is the placement of the joint's frame in its parent's, motion included:

    T = shift · fixed turns · turn of the joint · offset along z

    shift     origin of the joint in the parent's frame; along x alone where the frames allow it, m
    fixed     constant turns, none or one about x on a chain
    turn      about z, by the joint's angle (revolute) or a constant one (prismatic)
    offset      along z afterwards, by a constant (revolute) or the joint's position (prismatic), m

A turn about a coordinate axis takes a vector for 4 multiplications and 2 additions, and by ±90° for none; a general one
takes 9 and 6. J = Σ m r rᵀ turns about an axis for 8 multiplications, with w = c (J_ii - J_jj) - 2 s J_ij:

    J'_ii = J_jj + c w,    J'_jj = J_ii - c w,    J'_ij = J_ij + s w

H that is not symmetric turns for 12 in place of 24, with w = c (H_ii - H_jj) - s (H_ij + H_ji) and H'_ji = H_ji + s w.

Inertias are second moments: mass m, first moment h = m r and J = Σ m r rᵀ, about the origin of a frame. The inertia
matrix is I = tr(J) 1 - J, and J = ½ tr(I) 1 - I. J moves with fewer operations than I. What exerts no force on a
revolute joint stands in it separately: everything on the joint's axis is m, h_z and J_zz.

    shift by p    h' = h + m p,    J' = J + p (h + ½ m p)ᵀ + (h + ½ m p) pᵀ
    turn by R     h' = R h,        J' = R J Rᵀ

Where points r of the body accelerate by a + U r, Newton's and Euler's equations about the frame's origin are

    f = m a + U h,    n = h × a + axial vector of (U J - J Uᵀ),    its x being U_z·J_y - U_y·J_z

Motions go from the base to the tips (pass 1 of the recursions): motion of body i from that of its parent p, all in axes
of frame i, whose z axis is the joint's:

    w, dw    angular velocity ω and angular acceleration ω̇
    a        acceleration of the frame's origin, in place of Featherstone's spatial one: no linear velocity is needed
    U        [ω̇]× + [ω]× [ω]×: point r of the body has the acceleration a + U r

Across joint i, whose origin lies at r in frame p, Rᵀ leading from frame p to frame i,

    ω = Rᵀ ω_p + z q̇    ω̇ = Rᵀ ω̇_p + Rᵀ ω_p × z q̇ + z q̈    a = Rᵀ (a_p + U_p r)                        a turn
    ω = Rᵀ ω_p           ω̇ = Rᵀ ω̇_p                          a = Rᵀ (a_p + U_p r) + 2 ω × z q̇ + z q̈    a slide

A turn about z does not move the point z of the body, so that U z = Rᵀ U_p z_p. Where z is an axis of frame p, U_p z_p
is a known column. It is turned for 4 multiplications, and gives ωy² and two entries of ω̇ for none.

What that saves, and U itself, of inverse dynamics (operations; ns one state a call, a state of a batch):

                               puma560                arm7                   chain8
    U z from the parent's      -4.7 %; +1 %,  -1 %    -4.7 %;  0,   -5 %     -4.3 %;   0,   -3 %
    both                        -20 %; -8 %, -16 %     -15 %; -7 %, -7 %      -18 %; -11 %, -9 %

References: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), sections 3.2, 3.3 and 9.6, eq.
(9.86)-(9.91); the matrix U after Balafoutis and Patel, Dynamic Analysis of Robot Manipulators (1991), section 5.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op
from symdyn.spatial import Inertia, Mat, Transform, Vec, add, cross, dot, scale, zero_vector

Twist = tuple[Vec, Vec]  # angular and linear part of a velocity or an acceleration
SpatialForce = tuple[Vec, Vec]  # moment about the origin and force; or angular and linear momentum


def six(matrix: Mat) -> tuple[Expr, ...]:
    """Return the entries of a symmetric matrix in the order of `Mat.symmetric`: xx, yy, zz, xy, xz, yz."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
    return xx, yy, zz, xy, xz, yz


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

    def wrench(self, a: Vec, U: Mat) -> SpatialForce:
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


class Turn(Protocol):
    """A rotation R of a frame."""

    def out(self, x: Vec) -> Vec:
        """Return Rᵀ x: a vector of the parent's frame in the turned one."""

    def back(self, x: Vec) -> Vec:
        """Return R x: a vector of the turned frame in the parent's."""

    def tensor_back(self, J: Mat) -> Mat:
        """Return R J Rᵀ for a symmetric J."""

    def block_back(self, H: Mat) -> Mat:
        """Return R H Rᵀ for any H."""


@dataclass(frozen=True)
class PlanarTurn:
    """A turn about a coordinate axis k (0, 1, 2) by the angle with this cosine and sine."""

    k: int
    cos: Expr
    sin: Expr

    def out(self, x: Vec) -> Vec:
        """Return Rᵀ x."""
        return self._turn(x, -self.sin)

    def back(self, x: Vec) -> Vec:
        """Return R x."""
        return self._turn(x, self.sin)

    def _turn(self, x: Vec, s: Expr) -> Vec:
        i, j, c = (self.k + 1) % 3, (self.k + 2) % 3, self.cos
        turned = list(x)
        turned[i], turned[j] = c * x[i] - s * x[j], s * x[i] + c * x[j]
        return (turned[0], turned[1], turned[2])

    def after(self, first: PlanarTurn) -> PlanarTurn:
        """Return both turns in one, about the same axis: the sine and cosine of a sum of angles."""
        c, s = self.cos, self.sin
        return PlanarTurn(self.k, c * first.cos - s * first.sin, s * first.cos + c * first.sin)

    def tensor_back(self, J: Mat) -> Mat:
        """Return R J Rᵀ for a symmetric J."""
        k, i, j, c, s = self.k, (self.k + 1) % 3, (self.k + 2) % 3, self.cos, self.sin
        rows = [list(row) for row in J]
        if c.is_zero:
            rows[i][i], rows[j][j], rows[i][j] = J[j][j], J[i][i], -J[i][j]
        elif not s.is_zero:
            w = c * (J[i][i] - J[j][j]) - s * (J[i][j] * 2)
            rows[i][i], rows[j][j], rows[i][j] = J[j][j] + c * w, J[i][i] - c * w, J[i][j] + s * w
        rows[i][k], rows[j][k] = c * J[k][i] - s * J[k][j], s * J[k][i] + c * J[k][j]
        rows[j][i], rows[k][i], rows[k][j] = rows[i][j], rows[i][k], rows[j][k]
        return Mat.symmetric(rows[0][0], rows[1][1], rows[2][2], rows[0][1], rows[0][2], rows[1][2])

    def block_back(self, H: Mat) -> Mat:
        """Return R H Rᵀ for any H: two by two as J is, the rest by columns and rows."""
        k, i, j, c, s = self.k, (self.k + 1) % 3, (self.k + 2) % 3, self.cos, self.sin
        rows = [list(row) for row in H]
        a, b, d, e = H[i][i], H[i][j], H[j][i], H[j][j]
        if c.is_zero:
            rows[i][i], rows[i][j], rows[j][i], rows[j][j] = e, -d, -b, a
        elif not s.is_zero:
            w = c * (a - e) - s * (b + d)
            rows[i][i], rows[i][j], rows[j][i], rows[j][j] = e + c * w, b + s * w, d + s * w, a - c * w
        rows[i][k], rows[j][k] = c * H[i][k] - s * H[j][k], s * H[i][k] + c * H[j][k]
        rows[k][i], rows[k][j] = c * H[k][i] - s * H[k][j], s * H[k][i] + c * H[k][j]
        return Mat((x, y, z) for x, y, z in rows)

    def moments_back(self, body: Moments) -> Moments:
        """Return the moments of a body that this turns, about z."""
        return TurnedMoments(body.m, self.back(body.h), self.tensor_back(body.J), body)


@dataclass(frozen=True)
class GeneralTurn:
    """Any rotation, by its matrix."""

    R: Mat

    def out(self, x: Vec) -> Vec:
        """Return Rᵀ x."""
        return self.R.T @ x

    def back(self, x: Vec) -> Vec:
        """Return R x."""
        return self.R @ x

    def tensor_back(self, J: Mat) -> Mat:
        """Return R J Rᵀ for a symmetric J."""
        return (self.R @ J @ self.R.T).mirrored()

    def block_back(self, H: Mat) -> Mat:
        """Return R H Rᵀ for any H, row by row, then column by column."""
        return Mat(map(self.back, Mat(map(self.back, H)).T)).T


@dataclass(frozen=True)
class JointTransform:
    """A factored placement of frame i in frame p; see the module's legend."""

    shift: Vec
    fixed: tuple[Turn, ...]
    turn: PlanarTurn
    offset: Expr

    @property
    def turns(self) -> tuple[Turn, ...]:
        """All turns, the parent's side first."""
        return (*self.fixed, self.turn)

    @property
    def axis(self) -> Vec:
        """The joint's axis z in the parent's frame."""
        zero = self.offset.graph.zero
        axis: Vec = (zero, zero, self.offset.graph.one)
        for turn in reversed(self.fixed):
            axis = turn.back(axis)
        return axis

    @property
    def is_right(self) -> bool:
        """Whether the joint's axis is an axis of the parent's frame."""
        return sum(x.is_zero for x in self.axis) == 2

    def out(self, x: Vec) -> Vec:
        """Return a direction of the parent's frame in the joint's own."""
        for turn in self.turns:
            x = turn.out(x)
        return x

    def back(self, x: Vec) -> Vec:
        """Return a direction of the joint's frame in the parent's."""
        for turn in reversed(self.turns):
            x = turn.back(x)
        return x

    def wrench_back(self, n: Vec, f: Vec) -> SpatialForce:
        """Return a wrench (moment about the joint's origin, force) about the parent's origin, in its frame."""
        n = self.back((n[0] - self.offset * f[1], n[1] + self.offset * f[0], n[2]))
        f = self.back(f)
        x, y, z = self.shift
        n = (n[0] + y * f[2] - z * f[1], n[1] + z * f[0] - x * f[2], n[2] + x * f[1] - y * f[0])
        return n, f

    def moments_back(self, body: Moments) -> Moments:
        """Return the moments of a body of the joint's frame in the parent's."""
        zero = self.offset.graph.zero
        body = body.shifted((zero, zero, self.offset))
        h, J = body.h, body.J
        for turn in reversed(self.turns):
            h, J = turn.back(h), turn.tensor_back(J)
        return Moments(body.m, h, J).shifted(self.shift)

    def fixed_part(self, slides: bool) -> JointTransform:
        """Return the transform without the motion of its joint, for what that motion leaves as it is."""
        graph = self.offset.graph
        if slides:
            return JointTransform(self.shift, self.fixed, self.turn, graph.zero)
        return JointTransform(self.shift, self.fixed, PlanarTurn(2, graph.one, graph.zero), self.offset)

    @property
    def transform(self) -> Transform:
        """The placement multiplied out."""
        graph = self.offset.graph
        one, zero = graph.one, graph.zero
        columns = [self.back(e) for e in ((one, zero, zero), (zero, one, zero), (zero, zero, one))]
        R = Mat(columns).T
        offset = self.back((zero, zero, self.offset)) if not self.offset.is_zero else zero_vector(graph)
        p = (self.shift[0] + offset[0], self.shift[1] + offset[1], self.shift[2] + offset[2])
        return Transform(R, p)


@dataclass(frozen=True)
class LinkMotion:
    """Motion of one frame, in its own axes; see the module's legend. rad/s, rad/s^2, m/s^2, 1/s^2."""

    w: Vec
    dw: Vec
    a: Vec
    U: Mat


def base_motion(acceleration: Vec) -> LinkMotion:
    """Return the motion of a base that only accelerates, m/s^2."""
    zeros = zero_vector(acceleration[0].graph)
    return moving(zeros, zeros, acceleration)


def moving(w: Vec, dw: Vec, a: Vec) -> LinkMotion:
    """Return a motion with its U."""
    return with_products(w, products(w), dw, a)


def products(w: Vec) -> tuple[Expr, ...]:
    """Return ωx², ωy², ωz², ωx ωy, ωx ωz, ωy ωz."""
    x, y, z = w
    return x * x, y * y, z * z, x * y, x * z, y * z


def with_products(w: Vec, squares: Sequence[Expr], dw: Vec, a: Vec) -> LinkMotion:
    """Return a motion with its U, for the six `products` of ω."""
    (dx, dy, dz), (xx, yy, zz, xy, xz, yz) = dw, squares
    U = Mat(
        (
            (-(yy + zz), xy - dz, xz + dy),
            (xy + dz, -(xx + zz), yz - dx),
            (xz - dy, yz + dx, -(xx + yy)),
        )
    )
    return LinkMotion(w, dw, a, U)


def with_column(w: Vec, squares: Sequence[Expr], dz: Expr, a: Vec, column: Vec) -> LinkMotion:
    """Return the same where U z is known, the `column`; of ω̇ only the last entry is, dz."""
    xx, _, zz, xy, xz, yz = squares
    dx, dy = yz - column[1], column[0] - xz
    U = Mat(
        (
            (column[2] + (xx - zz), xy - dz, column[0]),
            (xy + dz, -(xx + zz), column[1]),
            (xz - dy, yz + dx, column[2]),
        )
    )
    return LinkMotion(w, (dx, dy, dz), a, U)


def propagate(parent: LinkMotion, X: JointTransform, slides: bool, qd: Expr, qdd: Expr) -> LinkMotion:
    """Return the motion of a joint's frame, the joint moving at q̇ and q̈ along its z axis."""
    w, dw = X.out(parent.w), X.out(parent.dw)
    a = X.out(add(parent.a, parent.U @ X.shift))
    if slides:
        twice = qd * 2
        a = (a[0] + w[1] * twice, a[1] - w[0] * twice, a[2] + qdd)
        moved = moving(w, dw, a)
    else:
        dw = (dw[0] + w[1] * qd, dw[1] - w[0] * qd, dw[2] + qdd)
        w = (w[0], w[1], w[2] + qd)
        column = z_column(parent, X)
        moved = with_column(w, products(w), dw[2], a, column) if column else moving(w, dw, a)
    return at_offset_end(moved, X)


def z_column(parent: LinkMotion, X: JointTransform) -> Vec | None:
    """Return U z of a frame that a joint turns, from the parent's U; None where z is no axis of the parent's frame."""
    return X.out(parent.U @ X.axis) if X.is_right else None


def at_offset_end(motion: LinkMotion, X: JointTransform) -> LinkMotion:
    """Return the motion of the origin at the end of the offset along z."""
    column = (motion.U[0][2], motion.U[1][2], motion.U[2][2])
    return replace(motion, a=add(motion.a, scale(X.offset, column)))


def plus(a: Twist, b: Twist) -> Twist:
    """Return the sum of two twists, or of two spatial forces."""
    return add(a[0], b[0]), add(a[1], b[1])


def power(wrench: SpatialForce, twist: Twist) -> Expr:
    """Return the power of a wrench on a twist."""
    return dot(wrench[0], twist[0]) + dot(wrench[1], twist[1])
