"""Recursive Newton-Euler algorithm: inverse dynamics of a kinematic tree.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 5.1. As in Khalil and Dombre, Modeling,
Identification and Control of Robots (2002), eq. (9.86)-(9.97), accelerations are those of the frames' origins.

    i, p         body 1..n and its parent, p < i; body 0 is the base
    X[i]         transform across joint i, from frame i to frame p (`links`)
    S_i          axis of joint i: z of frame i, which it turns about or slides along
    motion[i]    velocity and acceleration of body i (`link_motion`)
    f[i]         wrench on body i by its parent: moment about the origin of frame i, then force, in frame i

Gravity is the acceleration -g of the base, so no body needs a weight.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.recursive.link_motion import LinkMotion, at_rest, carried
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.dynamics.recursive.variations import plus
from symdyn.graph import Expr
from symdyn.spatial import Wrench, neg, sub


def rnea(tree: ReducedTree, qd: Sequence[Expr], qdd: Sequence[Expr], acting: Sequence[Wrench] = ()) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q) less what acts on the bodies; N m or N; positive accelerates.

    Zeros for q̇ or q̈ leave their terms out of the graph. Wrenches (force, moment) from outside act on the base and
    every body, each in its frame.
    """
    rate, acceleration = tree.rates(qd), tree.accelerations(qd, qdd)
    motion = [at_rest(neg(tree.gravity))]
    for i in tree.outward():  # pass 1: velocities and accelerations, base to tips
        motion.append(carried(motion[tree.parent[i]], tree.link[i], tree.slides[i], rate[i], acceleration[i]))
    return joint_forces(tree, motion, acceleration, acting, tree.ball_forces(qd, qdd))


def joint_forces(
    tree: ReducedTree,
    motion: Sequence[LinkMotion],
    acceleration: Sequence[Expr],
    acting: Sequence[Wrench],
    balls: Sequence[Expr],
) -> list[Expr]:
    """Return the forces on the velocities, shape (n,), that give all bodies their motions, and rotors of `balls`."""
    X, tau = tree.link, [tree.graph.zero] * len(tree.parent)
    f = [body.wrench(moved.a, moved.U) for body, moved in zip(tree.body, motion, strict=True)]
    for i, (force, moment) in enumerate(acting):
        f[i] = (sub(f[i][0], moment), sub(f[i][1], force))
    for i in tree.inward():  # pass 2: forces, tips to base
        p = tree.parent[i]
        tau[i] = tree.along_axis(i, f[i]) + tree.armature[i] * acceleration[i]
        f[p] = plus(f[p], X[i].wrench_back(*f[i]))
    return [own + rotor for own, rotor in zip(tree.gather(tau), balls, strict=True)]
