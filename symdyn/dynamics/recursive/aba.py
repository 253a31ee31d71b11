"""Articulated-body algorithm: forward dynamics of a kinematic tree in O(n).

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 7.1, with the acceleration of the frame's origin
in place of the spatial acceleration, so that no linear velocity is needed; along factored links, joint axes are z axes.

What velocities alone give, without gravity and at q̈ = 0, is taken from the recursion of inverse dynamics; articulated
inertias then find what comes besides. So no inertia but a body's own is multiplied by c = Ṡ q̇, which saves a sixth.

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    A[i]        articulated inertia in blocks: [n; f] = [[J, H], [Hᵀ, M]] [dw; a] + bias, accelerations beside those
    U, D, u     A S, Sᵀ A S and τ - Sᵀ bias of joint i
    share       U / D
    alone       u / D: acceleration of joint i if its parent has none besides
    more        accelerations besides, [dw; a] of frame i
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics.mechanism.ldl import Singular
from symdyn.dynamics.recursive.lean_tree import LeanTree
from symdyn.dynamics.recursive.link_motion import LinkMotion, carried, moving
from symdyn.dynamics.recursive.links import Link
from symdyn.dynamics.recursive.moments import Moments
from symdyn.dynamics.recursive.rnea import balance, held_tips
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.spatial import (
    Mat,
    Vec,
    Wrench,
    add,
    add_matrices,
    apply,
    apply_transposed,
    cross,
    identity,
    mirrored,
    multiply,
    neg,
    outer,
    plus,
    power,
    scale_matrix,
    skew,
    sub,
    symmetric,
    transpose,
    zero_vector,
)

Pair = tuple[Vec, Vec]  # angular part first


@dataclass(frozen=True)
class Articulated:
    """An articulated inertia and its bias, as in the module's legend; J and M are symmetric."""

    J: Mat
    H: Mat
    M: Mat
    bias: Pair

    def __add__(self, other: Articulated) -> Articulated:
        """Return the sum, both in one frame."""
        return Articulated(
            add_matrices(self.J, other.J),
            add_matrices(self.H, other.H),
            add_matrices(self.M, other.M),
            plus(self.bias, other.bias),
        )

    def times(self, motion: Pair) -> Pair:
        """Return [[J, H], [Hᵀ, M]] motion."""
        w, v = motion
        return add(apply(self.J, w), apply(self.H, v)), add(apply_transposed(self.H, w), apply(self.M, v))

    def without(self, U: Pair, share: Pair, slides: bool) -> Articulated:
        """Return A - U Uᵀ / D, `share` being U / D: what is left when the joint gives way; the bias stays.

        Written so that rows and columns that vanish along the joint's axis are zero at birth.
        """
        coupled = outer(U[0], share[1]) if slides else outer(share[0], U[1])
        return Articulated(
            mirrored(_minus(self.J, outer(U[0], share[0]))),
            _minus(self.H, coupled),
            mirrored(_minus(self.M, outer(U[1], share[1]))),
            self.bias,
        )

    def shifted(self, p: Vec) -> Articulated:
        """Return it about an origin that lies at -p: f keeps, n gains p × f, a becomes a - p × dw."""
        r = skew(p)
        rM, Hr = multiply(r, self.M), multiply(self.H, r)
        J = _minus(_minus(self.J, add_matrices(Hr, transpose(Hr))), multiply(rM, r))
        n, f = self.bias
        return Articulated(mirrored(J), add_matrices(self.H, rM), self.M, (add(n, cross(p, f)), f))

    def seen_from(self, link: Link) -> Articulated:
        """Return it in the parent's frame."""
        zero = link.rise.graph.zero
        here = self.shifted((zero, zero, link.rise))
        J, H, M = here.J, here.H, here.M
        for turn in reversed(link.turns):
            J, H, M = turn.tensor_back(J), turn.block_back(H), turn.tensor_back(M)
        bias = (link.back(here.bias[0]), link.back(here.bias[1]))
        return Articulated(J, H, M, bias).shifted(link.shift)


def aba(tree: LeanTree, qd: Sequence[Expr], tau: Sequence[Expr], acting: Sequence[Wrench] = ()) -> list[Expr]:
    """Return q̈ for the joint forces τ, shape (n,); rad/s^2 or m/s^2.

    Outside wrenches (f, n) act on the ground and every body, each in its frame.

    Raises:
        Singular: a joint has no inertia beyond it.
        DerivationError: a joint follows another one.
    """
    if tree.coupled:
        raise DerivationError("the articulated-body algorithm knows no joints that share a velocity; use the road crba")
    if tree.balls:
        raise DerivationError("the articulated-body algorithm knows no rotor about three axes; use the road crba")
    tree, acting = held_tips(tree, acting)
    graph, still, ends = tree.graph, zero_vector(tree.graph), tree.ends
    motion = [moving(still, still, still)]
    A = [_articulated(tree.body[0], motion[0])]
    for i in tree.outward():  # motions that velocities alone give, ground to tips
        before, rate = motion[tree.parent[i]], qd[i - 1]
        motion.append(carried(before, tree.link[i], tree.slides[i], rate, graph.zero, ends[i], summing=True))
        A.append(_articulated(tree.body[i], motion[i]))
    for i, (f, n) in enumerate(acting):
        A[i] = replace(A[i], bias=(sub(A[i].bias[0], n), sub(A[i].bias[1], f)))
    share: list[Pair] = [(still, still)] * (tree.n + 1)
    alone = [graph.zero] * (tree.n + 1)
    for i in tree.inward():  # articulated inertias, tips to ground
        p, slides = tree.parent[i], tree.slides[i]
        U = A[i].times(_along_z(graph.one, slides))
        D = U[slides][2] + tree.armature[i]
        if D.is_zero:
            raise Singular(tree.A[i][0][0])
        u = tau[i - 1] - A[i].bias[slides][2]
        (n, f), alone[i] = (_over(part, D) for part in U), u / D
        share[i] = n, f
        if p:
            rest = A[i].without(U, share[i], slides)
            bias = _handed_on(rest.bias, u, share[i], tau[i - 1], slides)
            A[p] = A[p] + replace(rest, bias=bias).seen_from(tree.link[i])
    more: list[Pair] = [(still, neg(tree.gravity))]
    qdd: list[Expr] = []
    for i in tree.outward():  # accelerations besides, ground to tips
        (dw, a), link = more[tree.parent[i]], tree.link[i]
        turned, moved = link.out(dw), link.out(add(a, cross(dw, link.shift)))
        given = turned, add(moved, cross(turned, (graph.zero, graph.zero, link.rise)))
        qdd.append(alone[i] - power(share[i], given))
        more.append(plus(given, _along_z(qdd[-1], tree.slides[i])))
    return [a - b for a, b in zip(qdd, tree.bias(qd)[1:], strict=True)]


def _articulated(body: Moments, motion: LinkMotion) -> Articulated:
    """Return a body alone: what it takes for its motion is its bias."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.J
    I = symmetric(yy + zz, xx + zz, xx + yy, -xy, -xz, -yz)  # noqa: E741  the book's name
    mass = scale_matrix(body.m, identity(body.m.graph))
    return Articulated(I, skew(body.h), mass, balance(body, motion))


def _handed_on(bias: Pair, u: Expr, share: Pair, tau: Expr, slides: bool) -> Pair:
    """Return bias + u share; where no rotor takes of it, what is handed on along the axis is τ."""
    one = tau.graph.one

    def handed(b: Vec, s: Vec, along: bool) -> Vec:
        last = tau if along and s[2] is one else b[2] + u * s[2]  # a share across may be 1 by chance
        return b[0] + u * s[0], b[1] + u * s[1], last

    return handed(bias[0], share[0], not slides), handed(bias[1], share[1], slides)


def _over(a: Vec, D: Expr) -> Vec:
    return (a[0] / D, a[1] / D, a[2] / D)


def _along_z(amount: Expr, slides: bool) -> Pair:
    """Return a turn or a slide along z."""
    still = zero_vector(amount.graph)
    along = (amount.graph.zero, amount.graph.zero, amount)
    return (still, along) if slides else (along, still)


def _minus(a: Mat, b: Mat) -> Mat:
    return (sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2]))
