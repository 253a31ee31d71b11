"""The bivectors of D'Alembert's method: what acts on a body, its inertia forces, what joints exert on it.

Reference: the textbook, section 5.1.1, eq. (5.1)-(5.17).

    j          a moving body; frame j has its origin O_j in the joint that carries it, axes of the body
    F^A_jj     (5.1) bivector [force; moment about O_j] of weight, loads, and the joints' own elements, axes of frame j
    F^D_jj     (5.17) bivector of its inertia forces
    P_1j       (5.4) direction cosines of frame j in the ground
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from symdyn.dynamics.mechanism.state import vector
from symdyn.dynamics.mechanism.tree import TreeMotion
from symdyn.dynamics.reactions.joint_frames import JointFrames, motions
from symdyn.graph import Expr
from symdyn.spatial import (
    Inertia,
    Mat,
    Transform,
    Vec,
    Wrench,
    add,
    cross,
    neg,
    scale,
    zero_vector,
)

if TYPE_CHECKING:
    from symdyn.dynamics.reactions.free_bodies import FreeBodies


@dataclass(frozen=True)
class Bivectors:
    """The known bivectors of one body, frame j.

    Attributes:
        action: (5.1).
        inertia: (5.17).
        motion: ω_1j, ω̇_1j, acceleration of O_j; axes of frame j.
        body: mass, first moment, and I_jj of (5.15) about O_j.
    """

    action: Wrench
    inertia: Wrench
    motion: TreeMotion
    body: Inertia

    def inertia_for(self, a: Vec) -> Wrench:
        """Return (5.17) for another acceleration of O_j."""
        return inertia_bivector(self.body, self.motion.w, self.motion.dw, a)


def shift(way: Vec) -> tuple[tuple[Expr, ...], ...]:
    """Return R̄ = [[1, 0], [r̃, 1]] of (5.3), which moves a bivector by r = `way`, with r̃ of (5.2)."""
    graph = way[0].graph
    one, r = Mat.identity(graph), Mat.skew(way)
    return (*((*row, *zero_vector(graph)) for row in one), *((*r[k], *one[k]) for k in range(3)))


def turned(P: Transform, bivector: Wrench) -> Wrench:
    """Return F̄_1j = R̄_1j P̄_1j F̄_jj of (5.5): a bivector of frame j in frame 1, for the placement of j in 1."""
    force = P.R @ bivector[0]
    return Wrench(force, add(P.R @ bivector[1], cross(P.p, force)))


def known_bivectors(hanging: FreeBodies, own: Sequence[Sequence[Expr]]) -> tuple[Bivectors, ...]:
    """Return the actions (5.1), what joints do by themselves included, and the inertia bivectors (5.11)-(5.17)."""
    scene, tree, state = hanging.scene, hanging.tree, hanging.state
    graph = hanging.graph
    moved = motions(scene, tree, state.qd, state.qdd, zero_vector(graph))
    gravity, placed, loads = (
        vector(scene.gravity, graph),
        hanging.placements,
        hanging.acting,
    )
    actions, bodies, about_origin = [], [], []
    for hinge, body, motion, T, load in zip(hanging.joints, hanging.inertias, moved, placed, loads, strict=True):
        r = hinge.place_on_child  # O_j in the body's frame
        g = T.R.T @ gravity
        weight = Wrench(scale(body.m, g), cross(body.h, g))
        actions.append((weight + load).about(neg(r)))
        about_origin.append(TreeMotion(motion.w, motion.dw, motion.at(r)))
        bodies.append(body.seen_from(Transform(Mat.identity(graph), neg(r))))
    for hinge, forces in zip(hanging.joints, own, strict=True):
        for force, D in zip(forces, hanging.drives(hinge), strict=True):
            for j, exerted in exerted_on(hanging, hinge, D.scaled(force)).items():
                actions[j] = actions[j] + exerted
    return tuple(
        Bivectors(action, inertia_bivector(body, motion.w, motion.dw, motion.a), motion, body)
        for action, motion, body in zip(actions, about_origin, bodies, strict=True)
    )


def inertia_bivector(body: Inertia, w: Vec, dw: Vec, a: Vec) -> Wrench:
    """Return F̄^D_jj of (5.17) for the acceleration a of O_j; all in frame j, the inertia about O_j.

    F^D = -m (acceleration of the centre of mass) (5.11), M^D = -(I ω̇ + ω̃ I ω) + r̃_jT F*^D (5.14), F*^D = -m a (5.16);
    m r_jT is the first moment.
    """
    force = neg(add(scale(body.m, a), add(cross(dw, body.h), cross(w, cross(w, body.h)))))
    spin = neg(add(body.I @ dw, cross(w, body.I @ w)))
    return Wrench(force, add(spin, neg(cross(body.h, a))))


def exerted_on(hanging: FreeBodies, hinge: JointFrames, wrench: Wrench) -> dict[int, Wrench]:
    """Return what a wrench W in a joint does to the bodies on both sides, frames j: (5.6) and (5.8)-(5.10)."""
    found: dict[int, Wrench] = {}
    if hinge.child >= 0:
        way = add(hinge.place_on_child, neg(hanging.joints[hinge.child].place_on_child))
        found[hinge.child] = hinge.on_child(wrench).about(way)
    if hinge.parent >= 0:
        way = add(hinge.place_on_parent, neg(hanging.joints[hinge.parent].place_on_child))
        exerted = hinge.on_parent(wrench).about(way)
        found[hinge.parent] = found[hinge.parent] + exerted if hinge.parent in found else exerted
    return found
