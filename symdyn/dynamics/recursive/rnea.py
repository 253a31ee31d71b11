"""Recursive Newton-Euler algorithm: inverse dynamics of a kinematic tree, one frame at a time along factored links.

Reference: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.97); the matrix U
after Balafoutis and Patel, Dynamic Analysis of Robot Manipulators (1991), section 5.4.

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    w, dw, a    angular velocity, angular acceleration, acceleration of the origin of frame i, in frame i
    U           [ω̇]× + [ω]× [ω]×: a + U r is the acceleration of a point r of the body
    m, h, J     moments of body i about the origin of frame i
    f, n        force on body i by its parent and moment about the origin of frame i, in frame i

Gravity is the acceleration -g of the ground, so no body needs a weight. Joint axes are z axes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics.recursive.lean_tree import LeanTree
from symdyn.dynamics.recursive.links import Link
from symdyn.dynamics.recursive.moments import Moments
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, Wrench, add, apply, cross, neg, scale, sub, zero_vector


@dataclass(frozen=True)
class LinkMotion:
    """Motion of one frame, in its own axes; see the module's legend. rad/s, rad/s^2, m/s^2; squares: ωx², ωy², ωz²."""

    w: Vec
    dw: Vec
    a: Vec
    U: Mat
    squares: Vec


def rnea(
    tree: LeanTree,
    qd: Sequence[Expr],
    qdd: Sequence[Expr],
    gravity: bool = True,
    acting: Sequence[Wrench] = (),
) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q) less what acts on the bodies; N m or N; positive accelerates.

    Zeros for q̇ or q̈ leave their terms out of the graph. Wrenches (f, n) from outside act on the ground and every body,
    each in its frame.
    """
    still = zero_vector(tree.graph)
    rate, acceleration = tree.rates(qd), tree.accelerations(qd, qdd)
    ends = tree.ends
    motion = [moving(still, still, neg(tree.gravity) if gravity else still)]
    for i in tree.outward():  # pass 1: motion, ground to tips
        before = motion[tree.parent[i]]
        motion.append(carried(before, tree.link[i], tree.slides[i], rate[i], acceleration[i], ends[i]))
    forces = transmitted(tree, motion, acceleration, acting)
    for ball in tree.balls:
        for k, moment in zip(ball.velocities, ball.forces(qd, qdd), strict=True):
            forces[k] = forces[k] + moment
    return forces


def transmitted(
    tree: LeanTree, motion: Sequence[LinkMotion], acceleration: Sequence[Expr], acting: Sequence[Wrench] = ()
) -> list[Expr]:
    """Return the forces on the velocities, shape (n,), that give all bodies their motions; balls without rotors."""
    wrench = [balance(body, moved) for body, moved in zip(tree.body, motion, strict=True)]
    for i, (f, n) in enumerate(acting):
        wrench[i] = (sub(wrench[i][0], n), sub(wrench[i][1], f))
    tau = [tree.graph.zero] * len(tree.parent)
    for i in tree.inward():  # pass 2: force, tips to ground
        p, (n, f) = tree.parent[i], wrench[i]
        tau[i] = (f[2] if tree.slides[i] else n[2]) + tree.armature[i] * acceleration[i]
        n, f = tree.link[i].wrench_back(n, f)
        wrench[p] = (add(wrench[p][0], n), add(wrench[p][1], f))
    return tree.gather(tau)


def moving(w: Vec, dw: Vec, a: Vec) -> LinkMotion:
    """Return a motion with its U: six products of ω, nine entries."""
    x, y, z = w
    return with_products(w, (x * x, y * y, z * z, x * y, x * z, y * z), dw, a)


def with_products(w: Vec, products: Sequence[Expr], dw: Vec, a: Vec) -> LinkMotion:
    """Return a motion with its U, for ωx², ωy², ωz², ωx ωy, ωx ωz, ωy ωz."""
    (dx, dy, dz), (xx, yy, zz, xy, xz, yz) = dw, products
    U = (
        (-(yy + zz), xy - dz, xz + dy),
        (xy + dz, -(xx + zz), yz - dx),
        (xz - dy, yz + dx, -(xx + yy)),
    )
    return LinkMotion(w, dw, a, U, (xx, yy, zz))


def turning(w: Vec, dz: Expr, a: Vec, column: Vec, ends: bool) -> LinkMotion:
    """Return a motion with its U from U z, the `column`: that gives ωy² and the rest of ω̇ without a multiplication.

    The last entry of ω̇ is dz; `ends` tells that nobody needs the others.
    """
    x, y, z = w

    def twice() -> Iterator[Expr]:
        double = z * 2
        yield x * double
        yield y * double

    return turning_with(w, (x * x, z * z, x * y, x * z, y * z), twice, dz, a, column, ends)


def turning_with(
    w: Vec,
    products: Sequence[Expr],
    twice: Callable[[], Iterable[Expr]],
    dz: Expr,
    a: Vec,
    column: Vec,
    ends: bool,
) -> LinkMotion:
    """Return the same for ωx², ωz², ωx ωy, ωx ωz, ωy ωz; `twice` gives the last two doubled, if they are wanted."""
    xx, zz, xy, xz, yz = products
    yy = -column[2] - xx
    dx, dy = yz - column[1], column[0] - xz
    zx, zy = (a - b for a, b in zip(twice(), column[:2], strict=True)) if ends else (xz - dy, yz + dx)
    U = (
        (-(yy + zz), xy - dz, column[0]),
        (xy + dz, -(xx + zz), column[1]),
        (zx, zy, column[2]),
    )
    return LinkMotion(w, (dx, dy, dz), a, U, (xx, yy, zz))


def carried(parent: LinkMotion, link: Link, slides: bool, qd: Expr, qdd: Expr, ends: bool) -> LinkMotion:
    """Return the motion of the frame at the end of a link, whose joint moves at q̇ and q̈ along its z axis.

    A turn about z leaves U z as it is in space. Where z is an axis of the parent's frame, U z is a column of the
    parent's U, turned for 4 multiplications; elsewhere ω̇ is turned. `ends` tells that all links beyond are parallel.
    """
    w, dw = link.out(parent.w), link.out(parent.dw)
    a = link.out(add(parent.a, apply(parent.U, link.shift)))
    if slides:
        twice = qd * 2
        moved = moving(w, dw, a)
        a = (a[0] + w[1] * twice, a[1] - w[0] * twice, a[2] + qdd)
    elif link.is_right:
        moved = turning((w[0], w[1], w[2] + qd), dw[2] + qdd, a, link.out(apply(parent.U, link.axis)), ends)
    else:
        moved = moving((w[0], w[1], w[2] + qd), (dw[0] + w[1] * qd, dw[1] - w[0] * qd, dw[2] + qdd), a)
    rise = scale(link.rise, (moved.U[0][2], moved.U[1][2], moved.U[2][2]))
    return replace(moved, a=add(a, rise))


def balance(body: Moments, motion: LinkMotion) -> tuple[Vec, Vec]:
    """Return the wrench (n, f) that gives a body its motion: Newton's and Euler's equations about the frame's origin.

    f = m a + U h,    n = h × a + axis of (U J - J Uᵀ), row by row U_y·J_z - U_z·J_y and so on.
    """
    U, J = motion.U, body.J
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = J
    x2, y2, z2 = motion.squares
    turning = (
        U[2][0] * xy - U[1][0] * xz + (z2 - y2) * yz + U[2][1] * yy - U[1][2] * zz,
        U[0][1] * yz - U[2][1] * xy + (x2 - z2) * xz + U[0][2] * zz - U[2][0] * xx,
        U[1][2] * xz - U[0][2] * yz + (y2 - x2) * xy + U[1][0] * xx - U[0][1] * yy,
    )
    f = add(scale(body.m, motion.a), apply(U, body.h))
    return add(turning, cross(body.h, motion.a)), f
