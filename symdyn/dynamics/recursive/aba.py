"""Articulated-body algorithm: forward dynamics of a kinematic tree in O(n).

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 7.1, with the acceleration of the frame's origin
in place of the spatial acceleration, so that no linear velocity is needed; along factored links, joint axes are z axes.

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    A[i]        articulated inertia in blocks: [n; f] = [[J, H], [Hᵀ, M]] [dw; a] + [n0; f0]
    U, D, u     A S, Sᵀ A S and τ - Sᵀ bias of joint i
    c           acceleration of frame i that velocities alone give, seen from the parent's acceleration
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics.mechanism.ldl import Singular
from symdyn.dynamics.recursive.lean_tree import LeanTree
from symdyn.dynamics.recursive.links import Link, Turn
from symdyn.dynamics.recursive.moments import Moments
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
    times,
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

    def without(self, U: Pair, D: Expr, slides: bool) -> Articulated:
        """Return A - U Uᵀ / D: what is left when the joint gives way; the bias stays.

        Written so that rows and columns that vanish along the joint's axis are zero at birth.
        """
        n, f = (tuple(x / D for x in part) for part in U)
        share: Pair = ((n[0], n[1], n[2]), (f[0], f[1], f[2]))
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
            J, H, M = turn.tensor_back(J), _turn(turn, H), turn.tensor_back(M)
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
    graph, still = tree.graph, zero_vector(tree.graph)
    w, c = [still], [(still, still)]
    A = [_rigid(tree.body[0], still)]
    for i in tree.outward():  # velocities, ground to tips
        link, p, rate = tree.link[i], tree.parent[i], qd[i - 1]
        wp = link.out(w[p])
        pulled = link.out(cross(w[p], cross(w[p], link.shift)))
        if tree.slides[i]:
            w.append(wp)
            twice = rate * 2
            turned, slid = still, (wp[1] * twice, -wp[0] * twice, graph.zero)
        else:
            w.append((wp[0], wp[1], wp[2] + rate))
            turned, slid = (wp[1] * rate, -wp[0] * rate, graph.zero), still
        rise = (graph.zero, graph.zero, link.rise)
        lifted = add(cross(w[i], cross(w[i], rise)), cross(turned, rise))
        c.append((turned, add(add(pulled, slid), lifted)))
        A.append(_rigid(tree.body[i], w[i]))
    for i, (f, n) in enumerate(acting):
        A[i] = replace(A[i], bias=(sub(A[i].bias[0], n), sub(A[i].bias[1], f)))
    U: list[Pair] = [(still, still)] * (tree.n + 1)
    D, u = [graph.one] * (tree.n + 1), [graph.zero] * (tree.n + 1)
    for i in tree.inward():  # articulated inertias, tips to ground
        p, slides = tree.parent[i], tree.slides[i]
        U[i] = A[i].times(_along_z(graph.one, slides))
        D[i] = U[i][slides][2] + tree.armature[i]
        if D[i].is_zero:
            raise Singular(tree.A[i][0][0])
        u[i] = tau[i - 1] - A[i].bias[slides][2]
        if p:
            rest = A[i].without(U[i], D[i], slides)
            push = plus(rest.times(c[i]), times(u[i] / D[i], U[i]))
            A[p] = A[p] + replace(rest, bias=plus(rest.bias, push)).seen_from(tree.link[i])
    acceleration: list[Pair] = [(still, neg(tree.gravity))]
    qdd: list[Expr] = []
    for i in tree.outward():  # accelerations, ground to tips
        (dw, a), link = acceleration[tree.parent[i]], tree.link[i]
        turned, moved = link.out(dw), link.out(add(a, cross(dw, link.shift)))
        lifted = cross(turned, (graph.zero, graph.zero, link.rise))
        given = plus((turned, add(moved, lifted)), c[i])
        qdd.append((u[i] - power(U[i], given)) / D[i])
        acceleration.append(plus(given, _along_z(qdd[-1], tree.slides[i])))
    return [a - b for a, b in zip(qdd, tree.bias(qd)[1:], strict=True)]


def _rigid(body: Moments, w: Vec) -> Articulated:
    """Return a body alone: bias [ω × I ω; ω × (ω × h)]."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.J
    I = symmetric(yy + zz, xx + zz, xx + yy, -xy, -xz, -yz)  # noqa: E741  the book's name
    mass = scale_matrix(body.m, identity(body.m.graph))
    return Articulated(I, skew(body.h), mass, (cross(w, apply(I, w)), cross(w, cross(w, body.h))))


def _along_z(amount: Expr, slides: bool) -> Pair:
    """Return a turn or a slide along z."""
    still = zero_vector(amount.graph)
    along = (amount.graph.zero, amount.graph.zero, amount)
    return (still, along) if slides else (along, still)


def _minus(a: Mat, b: Mat) -> Mat:
    return (sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2]))


def _turn(turn: Turn, block: Mat) -> Mat:
    """Return R H Rᵀ for any H."""
    rows = (turn.back(block[0]), turn.back(block[1]), turn.back(block[2]))
    columns = transpose(rows)
    return transpose((turn.back(columns[0]), turn.back(columns[1]), turn.back(columns[2])))
