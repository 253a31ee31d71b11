"""Pass 1 of the recursions, base to tips: how body i moves, given the motion of its parent p.

    w, dw    angular velocity ω and angular acceleration ω̇
    a        acceleration of the frame's origin, in place of Featherstone's spatial one: no linear velocity is needed
    U        [ω̇]× + [ω]× [ω]×: point r of the body has the acceleration a + U r

all in axes of frame i, whose z axis is the joint's. Across link i, whose origin lies at r in frame p,

    ω = R ω_p + z q̇    ω̇ = R ω̇_p + R ω_p × z q̇ + z q̈    a = R (a_p + U_p r)            a turn
    ω = R ω_p           ω̇ = R ω̇_p                          a = R (a_p + U_p r) + 2 ω × z q̇ + z q̈    a slide

A turn about z leaves the point z of the body as it is in space, so that U z = R U_p z_p. Where z is an axis of frame p,
U_p z_p is a column that is there, turned for 4 multiplications, and gives ωy² and two entries of ω̇ without one.

What that saves, and U itself, of inverse dynamics (operations; ns one state a call, a state of a batch):

                               puma560                arm7                   chain8
    U z from the parent's      -4.7 %; +1 %,  -1 %    -4.7 %;  0,   -5 %     -4.3 %;   0,   -3 %
    both                        -20 %; -8 %, -16 %     -15 %; -7 %, -7 %      -18 %; -11 %, -9 %

Reference: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.91); the matrix U
after Balafoutis and Patel, Dynamic Analysis of Robot Manipulators (1991), section 5.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics.recursive.links import Link
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, add, scale, zero_vector


@dataclass(frozen=True)
class LinkMotion:
    """Motion of one frame, in its own axes; see the module's legend. rad/s, rad/s^2, m/s^2, 1/s^2."""

    w: Vec
    dw: Vec
    a: Vec
    U: Mat


def at_rest(acceleration: Vec) -> LinkMotion:
    """Return the motion of a base that only accelerates, m/s^2."""
    still = zero_vector(acceleration[0].graph)
    return moving(still, still, acceleration)


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


def carried(parent: LinkMotion, link: Link, slides: bool, qd: Expr, qdd: Expr) -> LinkMotion:
    """Return the motion of the frame at the end of a link, whose joint moves at q̇ and q̈ along its z axis."""
    w, dw = link.out(parent.w), link.out(parent.dw)
    a = link.out(add(parent.a, parent.U @ link.shift))
    if slides:
        twice = qd * 2
        a = (a[0] + w[1] * twice, a[1] - w[0] * twice, a[2] + qdd)
        moved = moving(w, dw, a)
    else:
        dw = (dw[0] + w[1] * qd, dw[1] - w[0] * qd, dw[2] + qdd)
        w = (w[0], w[1], w[2] + qd)
        column = z_column(parent, link)
        moved = with_column(w, products(w), dw[2], a, column) if column else moving(w, dw, a)
    return raised(moved, link)


def z_column(parent: LinkMotion, link: Link) -> Vec | None:
    """Return U z of a frame that a joint turns, from the parent's U; None where z is no axis of the parent's frame."""
    return link.out(parent.U @ link.axis) if link.is_right else None


def raised(motion: LinkMotion, link: Link) -> LinkMotion:
    """Return the motion as seen from the end of the link's rise along z."""
    column = (motion.U[0][2], motion.U[1][2], motion.U[2][2])
    return replace(motion, a=add(motion.a, scale(link.rise, column)))
