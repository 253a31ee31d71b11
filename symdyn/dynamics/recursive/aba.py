"""Articulated-body algorithm: forward dynamics of a kinematic tree in O(n).

    i, p        body 1..n and its parent, p < i; body 0 is the base
    X[i]        transform across joint i, from frame i to frame p (`links`)
    S_i         axis of joint i: z of frame i, a unit turn about it or a unit slide along it
    motion[i]   what velocities alone give: no gravity, q̈ = 0 (`links`)
    A[i]        articulated inertia and bias: [n; f] = [[J, H], [Hᵀ, M]] [dw; a] + bias (`articulated`)
    U, D, u     A S, Sᵀ A S and τ - Sᵀ bias of joint i
    share       U / D
    dw, a       accelerations beside those of motion[i], angular and linear, in frame i

As in `rnea`, accelerations are those of the frames' origins, so that no linear velocity is needed. With c = Ṡ q̇ in the
motions of pass 1, c is multiplied by the body's own inertia only. This saves a sixth of the operations of table 7.1.
Inertias and accelerations cross a joint along its factored link.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 7.2 and table 7.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics.mechanism.linear_solve import Singular, vanishes
from symdyn.dynamics.recursive.links import Link, LinkMotion, Moments, at_rest, carried
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.dynamics.recursive.rnea_derivatives import Twist, plus, work
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, Wrench, add, cross, neg, sub, zero_vector


@dataclass(frozen=True)
class Articulated:
    """An articulated inertia and its bias, as in the module's legend; J and M are symmetric."""

    J: Mat
    H: Mat
    M: Mat
    bias: Twist

    def __add__(self, other: Articulated) -> Articulated:
        """Return the sum, both in one frame."""
        return Articulated(
            self.J + other.J,
            self.H + other.H,
            self.M + other.M,
            plus(self.bias, other.bias),
        )

    def along_z(self, slides: bool) -> Twist:
        """Return [[J, H], [Hᵀ, M]] times a unit turn about z, or a unit slide along it."""
        n, f = (self.H, self.M) if slides else (self.J, self.H.T)
        return (n[0][2], n[1][2], n[2][2]), (f[0][2], f[1][2], f[2][2])

    def without(self, U: Twist, share: Twist, slides: bool) -> Articulated:
        """Return A - U Uᵀ / D, `share` being U / D: what is left when the joint gives way; the bias stays.

        Written so that rows and columns that vanish along the joint's axis are zero at birth.
        """
        coupled = Mat.outer(U[0], share[1]) if slides else Mat.outer(share[0], U[1])
        return Articulated(
            _minus(self.J, Mat.outer(U[0], share[0])).mirrored(),
            _minus(self.H, coupled),
            _minus(self.M, Mat.outer(U[1], share[1])).mirrored(),
            self.bias,
        )

    def shifted(self, p: Vec) -> Articulated:
        """Return it about an origin that lies at -p: f keeps, n gains p × f, a becomes a - p × dw."""
        (x, y, z), H = p, self.H
        K = H + Mat.skew(p) @ self.M
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = self.J
        J = Mat.symmetric(  # J - H [p]x - (...)^T - [p]x M [p]x, from H before and K after
            xx - (z * (H[0][1] + K[0][1]) - y * (H[0][2] + K[0][2])),
            yy - (x * (H[1][2] + K[1][2]) - z * (H[1][0] + K[1][0])),
            zz - (y * (H[2][0] + K[2][0]) - x * (H[2][1] + K[2][1])),
            xy - (z * (H[1][1] - K[0][0]) + x * K[0][2] - y * H[1][2]),
            xz - (y * (K[0][0] - H[2][2]) + z * H[2][1] - x * K[0][1]),
            yz - (x * (H[2][2] - K[1][1]) + y * K[1][0] - z * H[2][0]),
        )
        n, f = self.bias
        return Articulated(J, K, self.M, (add(n, cross(p, f)), f))

    def seen_from(self, link: Link) -> Articulated:
        """Return it in the parent's frame."""
        zero = link.rise.graph.zero
        here = self.shifted((zero, zero, link.rise))
        J, H, M = here.J, here.H, here.M
        for turn in reversed(link.turns):
            J, H, M = turn.tensor_back(J), turn.block_back(H), turn.tensor_back(M)
        bias = (link.back(here.bias[0]), link.back(here.bias[1]))
        return Articulated(J, H, M, bias).shifted(link.shift)


def articulated(body: Moments, motion: LinkMotion) -> Articulated:
    """Return a body alone: what it takes for its motion is its bias."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.J
    I = Mat.symmetric(yy + zz, xx + zz, xx + yy, -xy, -xz, -yz)  # noqa: E741  the book's name
    mass = Mat.identity(body.m.graph).scaled(body.m)
    return Articulated(I, Mat.skew(body.h), mass, body.wrench(motion.a, motion.U))


def given_way(A: Articulated, slides: bool, D: Expr, tau: Expr) -> tuple[Twist, Expr, Articulated]:
    """Return U / D, u / D and what is left of A, in its frame, when its joint gives way.

    Where no rotor takes of it, U / D is one along the axis, and what is handed on there is τ.
    """
    U = A.along_z(slides)
    u = tau - A.bias[slides][2]
    pivot = 1 / D
    share = _over(U[0], D, pivot), _over(U[1], D, pivot)
    one = D.graph.one

    def handed(b: Vec, s: Vec, along: bool) -> Vec:
        last = tau if along and s[2] is one else b[2] + u * s[2]  # a share across may be 1 by chance
        return b[0] + u * s[0], b[1] + u * s[1], last

    bias = handed(A.bias[0], share[0], not slides), handed(A.bias[1], share[1], slides)
    return share, u * pivot, replace(A.without(U, share, slides), bias=bias)


def across(before: Twist, link: Link) -> Twist:
    """Return the accelerations beyond a joint that does not move, from those before it."""
    (dw, a), zero = before, link.rise.graph.zero
    turned, moved = link.out(dw), link.out(add(a, cross(dw, link.shift)))
    return turned, add(moved, cross(turned, (zero, zero, link.rise)))


def _over(a: Vec, D: Expr, pivot: Expr) -> Vec:
    x, y, z = (D.graph.one if entry is D else entry * pivot for entry in a)
    return x, y, z


def along_z(amount: Expr, slides: bool) -> Twist:
    """Return a turn or a slide along z."""
    still = zero_vector(amount.graph)
    along = (amount.graph.zero, amount.graph.zero, amount)
    return (still, along) if slides else (along, still)


def _minus(a: Mat, b: Mat) -> Mat:
    return Mat((sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2])))


def aba(tree: ReducedTree, qd: Sequence[Expr], tau: Sequence[Expr], acting: Sequence[Wrench] = ()) -> list[Expr]:
    """Return q̈ for the joint forces τ, shape (n,); rad/s^2 or m/s^2.

    Wrenches (force, moment) from outside act on the base and every body, each in its frame.

    Raises:
        Singular: a joint has no inertia beyond it.
        DerivationError: a joint follows another one.
    """
    if tree.coupled:
        raise DerivationError(
            "the articulated-body algorithm knows no joints that share a velocity; use the formulation crba"
        )
    if tree.balls:
        raise DerivationError(
            "the articulated-body algorithm knows no rotor about three axes; use the formulation crba"
        )
    graph, still, X = tree.graph, zero_vector(tree.graph), tree.link
    motion = [at_rest(still)]
    A = [articulated(tree.body[0], motion[0])]
    for i in tree.outward():  # pass 1: motions that velocities alone give, base to tips
        motion.append(carried(motion[tree.parent[i]], X[i], tree.slides[i], qd[i - 1], graph.zero))
        A.append(articulated(tree.body[i], motion[i]))
    for i, (force, moment) in enumerate(acting):
        A[i] = replace(A[i], bias=(sub(A[i].bias[0], moment), sub(A[i].bias[1], force)))
    U_D: list[Twist] = [(still, still)] * (tree.n + 1)
    u_D = [graph.zero] * (tree.n + 1)
    for i in tree.inward():  # pass 2: articulated inertias, tips to base
        p, slides = tree.parent[i], tree.slides[i]
        if vanishes(D := tree.along_axis(i, A[i].along_z(slides)) + tree.armature[i]):
            raise Singular(tree.A[i][0][0])
        U_D[i], u_D[i], rest = given_way(A[i], slides, D, tau[i - 1])
        if p:
            A[p] = A[p] + rest.seen_from(X[i])
    a: list[Twist] = [(still, neg(tree.gravity))]
    qdd: list[Expr] = []
    for i in tree.outward():  # pass 3: accelerations beside those, base to tips
        before = across(a[tree.parent[i]], X[i])
        qdd.append(u_D[i] - work(U_D[i], before))
        a.append(plus(before, along_z(qdd[-1], tree.slides[i])))
    return [x - bias for x, bias in zip(qdd, tree.bias(qd)[1:], strict=True)]
