"""Recursive Newton-Euler algorithm: inverse dynamics of a kinematic tree.

Reference: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.97).

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    w, dw, a    motion of frame i, from `body_motion`
    m, h, I     inertia of body i about the origin of frame i
    f, n        force on body i by its parent and moment about the origin of frame i, in frame i
    S = z, s    motion subspace of joint i, angular and linear part

Gravity is the acceleration -g of the ground, so no body needs a weight.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.motion import Motion, body_motion
from symdyn.dynamics.tree import Tree
from symdyn.graph import Expr
from symdyn.spatial import Inertia, Vec, add, apply, cross, dot, neg, scale, zero_vector


def rnea(tree: Tree, qd: Sequence[Expr], qdd: Sequence[Expr], gravity: bool = True) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q).

    Args:
        tree: the mechanism; q enters through its placements.
        qd: joint velocities, shape (n,); pass zeros for what is not wanted, and its terms vanish from the graph.
        qdd: joint accelerations, shape (n,).
        gravity: whether g(q) is included.

    Returns:
        Driving torques (N m) and forces (N), shape (n,); positive accelerates the joint.
    """
    ground = neg(tree.gravity) if gravity else zero_vector(tree.graph)
    motion = body_motion(tree, qd, qdd, ground)  # pass 1: motion, ground to tips
    wrench = [balance(inertia, moved) for inertia, moved in zip(tree.inertia, motion, strict=True)]
    acceleration = tree.rates(qdd)
    tau = [tree.graph.zero] * len(tree.parent)
    for i in tree.inward():  # pass 2: force, tips to ground
        p, (z, s), T = tree.parent[i], tree.S[i], tree.T[i]
        n, f = wrench[i]
        tau[i] = dot(z, n) + dot(s, f) + tree.armature[i] * acceleration[i]
        force = apply(T.R, f)
        moment = add(apply(T.R, n), cross(T.p, force))
        wrench[p] = (add(wrench[p][0], moment), add(wrench[p][1], force))
    return tree.gather(tau)


def balance(inertia: Inertia, motion: Motion) -> tuple[Vec, Vec]:
    """Return the wrench (n, f) that gives a body its motion: Newton's and Euler's equations about the frame's origin.

    f = m a + ω̇ × h + ω × (ω × h),    n = I ω̇ + ω × (I ω) + h × a.
    """
    w, dw, a = motion.w, motion.dw, motion.a
    f = add(scale(inertia.m, a), add(cross(dw, inertia.h), cross(w, cross(w, inertia.h))))
    n = add(apply(inertia.I, dw), cross(w, apply(inertia.I, w)))
    return add(n, cross(inertia.h, a)), f
