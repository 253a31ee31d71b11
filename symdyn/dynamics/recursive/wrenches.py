"""What acts beside gravity and drives, along the tree: the recursive formulation of the forces of `loads`.

A load is a wrench on one body, which the recursions take with them. What pulls two points A and B together acts on the
joints between their bodies alone. Seen in the frame of elementary joint k, which carries B and not A,

    h_k     ∂(s²/2)/∂(joint k) = (a × b)_z for a turn, (b - a)_z for a slide    s: distance, a and b: the two points

so that points are transformed along the chain, and no force is. Its force is -F h_k / s, and ṡ = Σ h_k (rate of k) / s.
Joint axes are z axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import pairwise

from symdyn.dynamics.mechanism.kinematics import relative_motion
from symdyn.dynamics.mechanism.ropes import Taut
from symdyn.dynamics.mechanism.state import (
    State,
    declared_forces,
    joint_of,
    joint_resistance,
    load_vectors,
    pull,
    resisting,
    stored,
    stored_between,
    vector,
)
from symdyn.dynamics.mechanism.tree import Tree, settle
from symdyn.dynamics.recursive.links import JointTransform
from symdyn.dynamics.recursive.reduced_tree import ReducedTree, settled
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES, elastic as struts
from symdyn.scene.values import Joint, Load, Place, Strut
from symdyn.spatial import Transform, Vec, Wrench, add, dot, sub


@dataclass(frozen=True)
class Elastic:
    """Energy E(q), J, of struts that store it, and k_E: its derivatives along the velocities, shape (n,), N m or N."""

    energy: Expr
    forces: list[Expr]


@dataclass(frozen=True)
class Distance:
    """The squared distance s² of two points and h_k of the elementary joints between them; see the module's legend."""

    square: Expr
    slopes: list[tuple[int, Expr]]


def elastic(scene: Scene, tree: Tree, reduced: ReducedTree) -> Elastic:
    """Return the energy and the forces of all struts that store energy."""
    graph = tree.graph
    energy, forces = graph.zero, [graph.zero] * tree.n
    for strut in struts(scene):
        if strut.joint:
            joint = joint_of(scene, strut)
            position, (moved,) = joint.position(graph), _moved_by(scene, joint, graph)
            force = FORCES[strut.kind].pull.force(strut, position, graph.zero)
            for k, ratio in moved:
                forces[k] = forces[k] + force * ratio
            energy = energy + stored(strut, position)
        elif strut.is_rope:
            length, rates = along(strut, scene, tree)
            pulled = FORCES[strut.kind].pull.force(strut, length, graph.zero)
            forces = [a + pulled * b for a, b in zip(forces, rates, strict=True)]
            energy = energy + stored(strut, length)
        else:
            apart = distance(strut, tree, reduced)
            share = pull(strut, apart.square, graph.zero)
            forces = [a + b for a, b in zip(forces, _gathered(reduced, apart, share), strict=True)]
            energy = energy + stored_between(strut, apart.square)
    return Elastic(energy, forces)


def joint_forces(scene: Scene, tree: Tree, reduced: ReducedTree) -> list[Expr]:
    """Return what struts without energy, friction and declared forces exert on the velocities, shape (n,); N m or N."""
    graph, state = tree.graph, State.of(scene, tree.graph)
    forces = declared_forces(scene, graph)
    for joint in scene.joints:
        for moved in _moved_by(scene, joint, graph):
            force = joint_resistance(joint, graph.total(ratio * state.qd[k] for k, ratio in moved))
            for k, ratio in moved:
                forces[k] = forces[k] - force * ratio
    for strut in resisting(scene):
        if strut.joint:
            joint = joint_of(scene, strut)
            position, (moved,) = joint.position(graph), _moved_by(scene, joint, graph)
            rate = graph.total(ratio * state.qd[k] for k, ratio in moved)
            force = FORCES[strut.kind].pull.force(strut, position, rate)
            for k, ratio in moved:
                forces[k] = forces[k] - force * ratio
            continue
        if strut.is_rope:
            length, slopes = along(strut, scene, tree)
            speed = graph.dot(slopes, state.qd)
            pulled = FORCES[strut.kind].pull.force(strut, length, speed)
            forces = [a - pulled * b for a, b in zip(forces, slopes, strict=True)]
            continue
        apart, rates = distance(strut, tree, reduced), reduced.rates(state.qd)
        if apart.square.is_zero:  # points that never part
            continue
        s = graph.sqrt(apart.square)
        (told,) = tangents([apart.square / 2], state.clock) if state.clock else (graph.zero,)
        rate = (graph.total(h * rates[i] for i, h in apart.slopes) + told) / s
        share = FORCES[strut.kind].pull.force(strut, s, rate) / s
        forces = [a - b for a, b in zip(forces, _gathered(reduced, apart, share), strict=True)]
    return forces


def along(strut: Strut, scene: Scene, tree: Tree) -> tuple[Expr, list[Expr]]:
    """Return the length of a strut that is a rope, m, and its rate for a unit of every velocity, shape (n,)."""
    taut, state = Taut(scene, tree.graph), State.of(scene, tree.graph)
    poses, rates = [], [tree.graph.zero] * tree.n
    speeds = cache(lambda: (tree.rates(state.qd), tree.bias(state.qd)))
    for near, far in pairwise(strut.ends):
        relative = relative_motion(tree, taut.seat(near), taut.seat(far), speeds)
        poses.append(relative.X)
        force, moment = taut.straight(near, far, relative.X).wrench
        for k, (turn, way) in relative.columns.items():
            rates[k] = rates[k] - dot(force, way) - dot(moment, turn)
    return taut.length(strut.ends, poses), rates


def body_wrenches(scene: Scene, tree: Tree, reduced: ReducedTree) -> list[Wrench]:
    """Return the wrench of the loads on the ground and every body, each in its frame."""
    wrench = [Wrench.none(tree.graph)] * len(reduced.parent)
    for load in scene.loads:
        i, (f, n) = _on_body(load, scene, tree, reduced)
        moment = add(wrench[i][1], n)  # before the force: programs are written in the order of birth
        wrench[i] = Wrench(add(wrench[i][0], f), moment)
    return wrench


def _moved_by(scene: Scene, joint: Joint, graph: Graph) -> list[list[tuple[int, Expr]]]:
    """Return, for each rate of a joint, the velocities that it follows, and the rate per unit of each."""
    moved: dict[int, list[tuple[int, Expr]]] = {}
    for name, k, ratio in joint.moved_by(graph):
        moved.setdefault(k, []).append((scene.velocities.index(name), ratio))
    return list(moved.values())


def _gathered(reduced: ReducedTree, apart: Distance, share: Expr) -> list[Expr]:
    """Return share · h on the velocities."""
    forces = [reduced.graph.zero] * len(reduced.parent)
    for i, h in apart.slopes:
        forces[i] = share * h
    return reduced.generalized_forces(forces)


def distance(strut: Strut, tree: Tree, reduced: ReducedTree) -> Distance:
    """Return the distance of the two ends, and how the elementary joints between them change it."""
    (i, a), (j, b) = (_seated(end, tree, reduced) for end in strut.ends)
    near, outwards = reduced.paths(i, j)
    far = outwards[::-1]
    if not far:  # the end that moves against the common body comes second
        (a, b), (near, far) = (b, a), (far, near)
    trail_a, trail_b = _points_inward(reduced, near, a), _points_inward(reduced, far, b)
    slopes = []
    seen = trail_a[-1]  # A from the common body, then outwards
    for k, point in zip(reversed(far), trail_b[-2::-1], strict=True):
        seen = _out(reduced.X[k], seen)
        slopes.append((k, _slope(reduced.slides[k], seen, point)))
    outermost = sub(trail_b[0], seen)
    seen = trail_b[-1]
    for k, point in zip(reversed(near), trail_a[-2::-1], strict=True):
        seen = _out(reduced.X[k], seen)
        slopes.append((k, _slope(reduced.slides[k], seen, point)))
    return Distance(dot(outermost, outermost), slopes)


def _slope(slides: bool, a: Vec, b: Vec) -> Expr:
    """Return ∂(s²/2)/∂(joint) in the frame of an elementary joint that carries point b and not a."""
    if slides:
        return b[2] - a[2]
    return a[0] * b[1] - a[1] * b[0]


def _seated(place: Place, tree: Tree, reduced: ReducedTree) -> tuple[int, Vec]:
    """Return the moving body that carries a place, and the place in its frame."""
    i, home = _home(place.body, tree, reduced)
    x, y, z = settle(home.point(vector(place.at, tree.graph)))
    return i, (x, y, z)


def _home(body: str, tree: Tree, reduced: ReducedTree) -> tuple[int, Transform]:
    """Return the moving body that carries a declared body, and that body's placement in its frame."""
    i, home = tree.home[body]
    return i, settled(reduced.moved[i].inverse() @ home)


def _points_inward(reduced: ReducedTree, path: Sequence[int], point: Vec) -> list[Vec]:
    """Return a point in the frames of a path, from the first body to the one that carries the last."""
    trail = [point]
    for k in path:
        X, (x, y, z) = reduced.X[k], trail[-1]
        trail.append(add(X.back((x, y, z + X.offset)), X.shift))
    return trail


def _out(X: JointTransform, point: Vec) -> Vec:
    """Return a point of the parent's frame in the joint's own."""
    x, y, z = X.out(sub(point, X.shift))
    return (x, y, z - X.offset)


def _on_body(load: Load, scene: Scene, tree: Tree, reduced: ReducedTree) -> tuple[int, Wrench]:
    """Return the moving body that a load acts on, and its wrench about the origin of that body's frame."""
    i, home = _home(load.place.body, tree, reduced)
    place = scene.seated(load).place
    _, point = _seated(place, tree, reduced)
    wrench = load_vectors(load, scene, tree.graph)
    if load.frame == "body":
        wrench = wrench.rotated(home.R)
    else:
        wrench = wrench.rotated(reduced.moved[0].R.T)
        for k in reduced.paths(0, i)[1]:
            wrench = Wrench(reduced.X[k].out(wrench[0]), reduced.X[k].out(wrench[1]))
    if law := FORCES[load.kind].push.carried:
        unit, qd = Transform.unit(tree.graph), State.of(scene, tree.graph).qd
        here = Transform(unit.R, vector(place.at, tree.graph))
        seats, speeds = ((Scene.GROUND, unit), (place.body, here)), (tree.rates(qd), tree.bias(qd))
        motion = relative_motion(tree, *seats, lambda: speeds)
        turning, v = motion.twist(qd)
        wrench = wrench + law(load, scene, motion.X.R.T @ v, motion.X.R.T @ turning).rotated(home.R)
    return i, wrench.about(point)
