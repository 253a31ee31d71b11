"""The motion of every declared body and what acts on it, in its own axes: (5.11)-(5.17) have it from here.

C           frame of the body as declared, nothing merged or moved
w, dw, a    angular velocity, angular acceleration, acceleration of the origin of C
m, h, I     mass, first moment and inertia about the origin of C, particles included
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.hinges import Hinge, about, nothing, plus
from symdyn.dynamics.motion import Motion, body_motion
from symdyn.dynamics.state import State, joint_motion, vector
from symdyn.dynamics.tree import Tree, body_inertia
from symdyn.graph import Expr
from symdyn.scene import Scene, express
from symdyn.scene.joints import Wrench
from symdyn.spatial import Inertia, Transform, Vec, add, apply, apply_transposed, cross, scale, unit_transform


def motions(scene: Scene, tree: Tree, qd: Sequence[Expr], qdd: Sequence[Expr], ground: Vec) -> list[Motion]:
    """Return the motion of every body of the scene; `ground` is the acceleration of the ground."""
    carried = body_motion(tree, qd, qdd, ground)
    result = []
    for body in scene.bodies:
        i, home = tree.home[body.name]
        moved, R = carried[i], home.R
        a = add(moved.a, add(cross(moved.dw, home.p), cross(moved.w, cross(moved.w, home.p))))
        result.append(Motion(apply_transposed(R, moved.w), apply_transposed(R, moved.dw), apply_transposed(R, a)))
    return result


def inertias(scene: Scene, tree: Tree) -> list[Inertia]:
    """Return the inertia of every body about the origin of its own frame."""
    return [body_inertia(body, tree.graph) for body in scene.bodies]


def needed(inertia: Inertia, motion: Motion) -> Wrench:
    """Return the wrench about the origin of C that gives a body its motion: Newton's and Euler's equations."""
    m, h, w, dw, a = inertia.m, inertia.h, motion.w, motion.dw, motion.a
    F = add(scale(m, a), add(cross(dw, h), cross(w, cross(w, h))))
    N = add(apply(inertia.I, dw), add(cross(w, apply(inertia.I, w)), cross(h, a)))
    return F, N


def placements(tree: Sequence[Hinge]) -> list[Transform]:
    """Return the placement of every body in the ground."""
    result: list[Transform] = []
    for hinge in tree:
        before = result[hinge.parent] if hinge.parent >= 0 else unit_transform(hinge.graph)
        result.append(before @ hinge.placement)
    return result


def acting(scene: Scene, tree: Sequence[Hinge]) -> list[Wrench]:
    """Return what loads do on every body, about the origin of C, without weight."""
    graph = tree[0].graph
    total = [nothing(graph)] * len(tree)
    number = {body.name: k for k, body in enumerate(scene.bodies)}
    placed = placements(tree) if scene.loads else []
    for load in scene.loads:
        if load.place.body not in number:
            continue  # the ground takes it
        k = number[load.place.body]
        force, couple = vector(load.force, graph), vector(load.couple, graph)
        if load.frame == "ground":
            force, couple = apply_transposed(placed[k].R, force), apply_transposed(placed[k].R, couple)
        total[k] = plus(total[k], about((force, couple), vector(load.place.at, graph)))
    return total


def own_forces(scene: Scene, hinge: Hinge, state: State) -> list[Expr]:
    """Return what a joint's own elements do along each of its velocities, N m or N, shape as `hinge.S`.

    Declared forces and dampers, and the rotor, which takes armature · (acceleration of its move) for itself.
    """
    joint, graph = hinge.joint, hinge.graph
    damping, armature = express(joint.damping, graph), express(joint.armature, graph)
    forces = [express(force, graph) for force in joint.forces] or [graph.zero] * len(hinge.rates)
    forces = [force - damping * rate for force, rate in zip(forces, hinge.rates, strict=True)]
    if joint.moves and not armature.is_zero:
        first = joint_motion(joint, graph).moves[0]
        bent = graph.total(x * hinge.rates[j] * hinge.rates[k] for j, k, x in first.bias)
        pulled = graph.total(x * hinge.ratio * state.qdd[hinge.velocities[k]] for k, x in first.rate)
        for k, x in first.rate:
            forces[k] = forces[k] - x * armature * (pulled + bent)
    return forces
