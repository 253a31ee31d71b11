"""The motion of every declared body and what acts on it, in its own axes: (5.11)-(5.17) have it from here.

C           frame of the body as declared, nothing merged or moved
w, dw, a    angular velocity, angular acceleration, acceleration of the origin of C
m, h, I     mass, first moment and inertia about the origin of C, particles included
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.mechanism.loads import joint_resistance, load_vectors, pull
from symdyn.dynamics.mechanism.state import State, vector
from symdyn.dynamics.mechanism.tree import Tree, TreeMotion, ball_rotor, body_inertia
from symdyn.dynamics.reactions.joint_frames import JointFrames
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import joint_motion
from symdyn.scene.values import Place, Strut
from symdyn.spatial import (
    Inertia,
    Transform,
    Vec,
    Wrench,
    add,
    cross,
    dot,
    neg,
    scale,
    sub,
    zero_vector,
)


def motions(scene: Scene, tree: Tree, qd: Sequence[Expr], qdd: Sequence[Expr], ground: Vec) -> list[TreeMotion]:
    """Return the motion of every body of the scene; `ground` is the acceleration of the ground."""
    carried = tree.motion(qd, qdd, ground)
    result = []
    for body in scene.bodies:
        i, home = tree.home[body.name]
        moved = carried[i]
        result.append(TreeMotion(*(home.R.T @ x for x in (moved.w, moved.dw, moved.at(home.p)))))
    return result


def inertias(scene: Scene, tree: Tree) -> list[Inertia]:
    """Return the inertia of every body about the origin of its own frame."""
    return [body_inertia(body, tree.graph) for body in scene.bodies]


def needed(inertia: Inertia, motion: TreeMotion) -> Wrench:
    """Return the wrench about the origin of C that gives a body its motion: Newton's and Euler's equations."""
    m, h, w, dw, a = inertia.m, inertia.h, motion.w, motion.dw, motion.a
    F = add(scale(m, a), add(cross(dw, h), cross(w, cross(w, h))))
    N = add(inertia.I @ dw, add(cross(w, inertia.I @ w), cross(h, a)))
    return Wrench(F, N)


def placements(tree: Sequence[JointFrames]) -> list[Transform]:
    """Return the placement of every body in the ground."""
    result: list[Transform] = []
    for hinge in tree:
        before = result[hinge.parent] if hinge.parent >= 0 else Transform.unit(hinge.graph)
        result.append(before @ hinge.placement)
    return result


def acting(scene: Scene, tree: Sequence[JointFrames], state: State) -> list[Wrench]:
    """Return what loads, and struts between points, do on every body about the origin of C, no weight."""
    number = {Scene.GROUND: -1} | {body.name: k for k, body in enumerate(scene.bodies)}
    apart = [one for one in scene.struts if not one.joint]
    graph = tree[0].graph
    total = [Wrench.none(graph)] * len(tree)
    placed = placements(tree) if scene.loads or apart else []

    def act(k: int, place: Place, wrench: Wrench) -> None:
        """Add a wrench at a place, ground axes, to what acts on body k."""
        if k >= 0:
            here = wrench.rotated(placed[k].R.T)
            total[k] = total[k] + here.about(vector(place.at, graph))

    for load in scene.loads:
        k = number[load.place.body]
        wrench = load_vectors(load, graph)
        act(k, load.place, wrench.rotated(placed[k].R) if load.frame == "body" and k >= 0 else wrench)
    for strut in apart:
        way, square = way_apart(scene, strut, placed, graph)
        if square.is_zero:  # points that never part
            continue
        stores = FORCES[strut.kind].pull.energy is not None
        (rate,) = [graph.zero] if stores else tangents([graph.sqrt(square)], state.velocity)
        force, couple = scale(pull(strut, square, rate), way), zero_vector(graph)
        first, second = strut.ends
        act(number[first.body], first, Wrench(force, couple))
        act(number[second.body], second, Wrench(neg(force), couple))
    return total


def way_apart(scene: Scene, strut: Strut, placed: Sequence[Transform], graph: Graph) -> tuple[Vec, Expr]:
    """Return the way from the first end of a strut between points to the second, ground axes, and its square."""
    number = {body.name: k for k, body in enumerate(scene.bodies)}
    at = [(number.get(end.body, -1), end) for end in strut.ends]
    a, b = (placed[k].point(vector(end.at, graph)) if k >= 0 else vector(end.at, graph) for k, end in at)
    way = sub(b, a)
    return way, dot(way, way)


def own_forces(scene: Scene, hinge: JointFrames, state: State) -> list[Expr]:
    """Return what a joint's own elements do along each of its velocities, N m or N, shape as `hinge.S`.

    Declared forces, struts, friction, and the rotor, which takes armature · (acceleration of its move).
    """
    joint, graph = hinge.joint, hinge.graph
    forces = [force.express(graph) for force in joint.forces] or [graph.zero] * len(hinge.rates)
    forces = [force - joint_resistance(joint, rate) for force, rate in zip(forces, hinge.rates, strict=True)]
    for strut in scene.struts:
        if strut.joint == joint.name:
            law = FORCES[strut.kind].pull
            forces[0] = forces[0] - law.force(strut, joint.position(graph), hinge.rates[0])
    armature = joint.armature.express(graph)
    ball = ball_rotor(joint, hinge.velocities, graph)
    if ball is not None:
        turning = ball.forces(state.qd, state.qdd)
        forces = [force - moment for force, moment in zip(forces, turning, strict=True)]
    elif joint.moves and not armature.is_zero:
        first = joint_motion(joint, graph).moves[0]
        bent = graph.total(x * hinge.rates[j] * hinge.rates[k] for j, k, x in first.bias)
        pulled = graph.total(x * hinge.ratio * state.qdd[hinge.velocities[k]] for k, x in first.rate)
        for k, x in first.rate:
            forces[k] = forces[k] - x * armature * (pulled + bent)
    return forces
