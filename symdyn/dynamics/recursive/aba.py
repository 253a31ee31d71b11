"""Articulated-body algorithm: forward dynamics of a kinematic tree in O(n).

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 7.1; as in `rnea`, accelerations are those of the
frames' origins, so that no linear velocity is needed.

    i, p        body 1..n and its parent, p < i; body 0 is the base
    X[i]        transform across joint i, from frame i to frame p (`links`)
    S_i         axis of joint i: z of frame i
    motion[i]   what velocities alone give: no gravity, q̈ = 0 (`link_motion`)
    A[i]        articulated inertia and its bias force, for accelerations beside those (`articulated`)
    U, D, u     A S, Sᵀ A S and τ - Sᵀ bias of joint i
    a[i]        accelerations beside those, (angular, linear) of frame i

With c = Ṡ q̇ in the motions of pass 1, no inertia but a body's own is multiplied by it, which saves a sixth of the
operations of table 7.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.dynamics.mechanism.ldl import Singular
from symdyn.dynamics.mechanism.vanishing import vanishes
from symdyn.dynamics.recursive.articulated import across, along_z, articulated, given_way
from symdyn.dynamics.recursive.link_motion import at_rest, carried
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.dynamics.recursive.variations import Twist, plus, work
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.spatial import Wrench, neg, sub, zero_vector


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
