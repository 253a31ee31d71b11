"""Velocities and accelerations of a kinematic tree, from the ground to the tips.

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    E, r        rotation and translation of T[i]: x_p = E x_i + r
    S = z, s    motion subspace of joint i, angular and linear part, constant in frame i
    w, dw, a    angular velocity, angular acceleration, acceleration of the origin of frame i, all in frame i

Reference: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.90).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.dynamics.mechanism.tree import Tree
from symdyn.graph import Expr
from symdyn.spatial import Vec, add, apply_transposed, cross, scale, zero_vector


@dataclass(frozen=True)
class TreeMotion:
    """Motion of one frame, in its own axes; see the module's legend. rad/s, rad/s^2, m/s^2."""

    w: Vec
    dw: Vec
    a: Vec


def body_motion(tree: Tree, qd: Sequence[Expr], qdd: Sequence[Expr], ground: Vec) -> list[TreeMotion]:
    """Return the motion of every frame, the ground first.

    Args:
        tree: the mechanism.
        qd: rates of the coordinates, shape (n,).
        qdd: their accelerations, shape (n,).
        ground: acceleration of the ground, m/s^2; -g puts gravity into every body at once.
    """
    still = zero_vector(tree.graph)
    rate, acceleration = tree.rates(qd), tree.accelerations(qd, qdd)
    motion = [TreeMotion(still, still, ground)]
    for i in tree.outward():
        (z, s), E, r = tree.S[i], tree.T[i].R, tree.T[i].p
        parent = motion[tree.parent[i]]
        wp = apply_transposed(E, parent.w)
        spin, slide = scale(rate[i], z), scale(rate[i], s)
        w = add(wp, spin)
        dw = add(add(apply_transposed(E, parent.dw), cross(wp, spin)), scale(acceleration[i], z))
        carried = add(parent.a, add(cross(parent.dw, r), cross(parent.w, cross(parent.w, r))))
        a = add(add(apply_transposed(E, carried), scale(2, cross(wp, slide))), scale(acceleration[i], s))
        motion.append(TreeMotion(w, dw, a))
    return motion
