"""Articulated-body algorithm: forward dynamics of a kinematic tree in O(n).

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 7.1, with the acceleration of the frame's origin
in place of the spatial acceleration, so that no linear velocity is needed.

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    A[i]        articulated inertia in blocks: [n; f] = [[J, H], [Hᵀ, M]] [dw; a] + [n0; f0]
    U, D, u     A S, Sᵀ A S and τ - Sᵀ bias of joint i
    c           acceleration of frame i that velocities alone give, seen from the parent's acceleration
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics.ldl import singular
from symdyn.dynamics.tree import Tree
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.spatial import (
    Mat,
    Transform,
    Vec,
    add,
    add_matrices,
    apply,
    apply_transposed,
    cross,
    dot,
    identity,
    multiply,
    neg,
    outer,
    scale,
    scale_matrix,
    skew,
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
            _add(self.bias, other.bias),
        )

    def times(self, motion: Pair) -> Pair:
        """Return [[J, H], [Hᵀ, M]] motion."""
        w, v = motion
        return add(apply(self.J, w), apply(self.H, v)), add(apply_transposed(self.H, w), apply(self.M, v))

    def without(self, U: Pair, D: Expr) -> Articulated:
        """Return A - U Uᵀ / D: what is left when the joint gives way; the bias stays."""
        share = (scale(1 / D, U[0]), scale(1 / D, U[1]))
        return Articulated(
            _symmetric(add_matrices(self.J, scale_matrix(-1, outer(share[0], U[0])))),
            add_matrices(self.H, scale_matrix(-1, outer(share[0], U[1]))),
            _symmetric(add_matrices(self.M, scale_matrix(-1, outer(share[1], U[1])))),
            self.bias,
        )

    def seen_from(self, T: Transform) -> Articulated:
        """Return it in the parent's frame: rotate, then shift by r: f keeps, n gains r × f, a becomes a - r × dw."""
        E, r = T.R, skew(T.p)
        J, H, M = _turn(E, self.J), _turn(E, self.H), _turn(E, self.M)
        J, M = _symmetric(J), _symmetric(M)
        rM = multiply(r, M)
        cross_block = add_matrices(H, rM)
        Hr = multiply(H, r)
        J = add_matrices(J, scale_matrix(-1, add_matrices(Hr, transpose(Hr))))
        J = add_matrices(J, scale_matrix(-1, multiply(rM, r)))
        force = apply(E, self.bias[1])
        moment = add(apply(E, self.bias[0]), cross(T.p, force))
        return Articulated(_symmetric(J), cross_block, M, (moment, force))


def aba(tree: Tree, qd: Sequence[Expr], tau: Sequence[Expr]) -> list[Expr]:
    """Return q̈ for the joint forces τ, shape (n,); rad/s^2 or m/s^2.

    Raises:
        DerivationError: a joint has no inertia beyond it, or follows another one.
    """
    if tree.coupled:
        raise DerivationError("the articulated-body algorithm knows no coupled joints; use the road crba")
    still = zero_vector(tree.graph)
    w, c = [still], [(still, still)]
    A = [_rigid(tree, 0, still)]
    for i in tree.outward():  # velocities, ground to tips
        p, (z, s) = tree.parent[i], tree.S[i]
        E, r = tree.T[i].R, tree.T[i].p
        wp = apply_transposed(E, w[p])
        spin, slide = scale(qd[i - 1], z), scale(qd[i - 1], s)
        w.append(add(wp, spin))
        carried = apply_transposed(E, cross(w[p], cross(w[p], r)))
        c.append((cross(wp, spin), add(carried, scale(2, cross(wp, slide)))))
        A.append(_rigid(tree, i, w[i]))
    U: list[Pair] = [(still, still)] * (tree.n + 1)
    D, u = [tree.graph.one] * (tree.n + 1), [tree.graph.zero] * (tree.n + 1)
    for i in tree.inward():  # articulated inertias, tips to ground
        p, S = tree.parent[i], tree.S[i]
        U[i] = A[i].times(S)
        D[i] = _dot(S, U[i]) + tree.armature[i]
        if D[i].is_zero:
            raise DerivationError(singular(i))
        u[i] = tau[i - 1] - _dot(S, A[i].bias)
        if p:
            rest = A[i].without(U[i], D[i])
            push = _add(rest.times(c[i]), (scale(u[i] / D[i], U[i][0]), scale(u[i] / D[i], U[i][1])))
            A[p] = A[p] + replace(rest, bias=_add(rest.bias, push)).seen_from(tree.T[i])
    acceleration: list[Pair] = [(still, neg(tree.gravity))]
    qdd: list[Expr] = []
    for i in tree.outward():  # accelerations, ground to tips
        dw, a = acceleration[tree.parent[i]]
        E, r = tree.T[i].R, tree.T[i].p
        given = _add((apply_transposed(E, dw), apply_transposed(E, add(a, cross(dw, r)))), c[i])
        qdd.append((u[i] - _dot(U[i], given)) / D[i])
        z, s = tree.S[i]
        acceleration.append(_add(given, (scale(qdd[-1], z), scale(qdd[-1], s))))
    return qdd


def _rigid(tree: Tree, i: int, w: Vec) -> Articulated:
    """Return body i alone: bias [ω × I ω; ω × (ω × h)]."""
    inertia, graph = tree.inertia[i], tree.graph
    turning = cross(w, apply(inertia.I, w))
    pulling = cross(w, cross(w, inertia.h))
    mass = scale_matrix(inertia.m, identity(graph))
    return Articulated(inertia.I, skew(inertia.h), mass, (turning, pulling))


def _add(x: Pair, y: Pair) -> Pair:
    return add(x[0], y[0]), add(x[1], y[1])


def _dot(x: Pair, y: Pair) -> Expr:
    return dot(x[0], y[0]) + dot(x[1], y[1])


def _turn(E: Mat, block: Mat) -> Mat:
    return multiply(multiply(E, block), transpose(E))


def _symmetric(m: Mat) -> Mat:
    """Return m with the lower triangle taken from the upper, so that equal entries are one node."""
    return symmetric(m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])
