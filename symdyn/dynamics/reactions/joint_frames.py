"""Joints of a scene with their frames, what they can transmit, and the motion and loads of every declared body.

Bodies are as declared: none is merged, no frame is moved. Equations (5.11)-(5.17) take their terms from here.

    J        joint frame, on the parent               B, C     frames of parent and child as declared
    P        origin of the moved joint frame, on the child: where reactions act
    X        placement of the moved joint frame in J
    S        twist (velocity of P; angular velocity) of the child relative to the parent for a unit rate, axes of J
    W        a wrench (force; moment about P) on the child, axes of J: force first, as the textbook stacks bivectors

A body has the number of its joint, the ground is -1. Joints that close loops come after those of the tree.

The wrenches of a joint are split into those without power and one for every freedom:

    W    reactions: t wrenches without power, Sᵀ W = 0
    D    drives: one a velocity, Sᵀ D = 1: the free places of (5.7), which the unknown drives take

D is a moment where the freedoms turn (a screw is turned, not pushed); elsewhere it is what has no part along W.

Every declared body has, in its own axes:

    C           frame of the body
    w, dw, a    angular velocity, angular acceleration, acceleration of the origin of C
    m, h, I     mass, first moment and inertia about the origin of C, particles included
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from symdyn.dynamics.loops.constraint_rows import Cut, cuts
from symdyn.dynamics.loops.loop_decisions import pivots
from symdyn.dynamics.mechanism.linear_solve import solve, vanishes
from symdyn.dynamics.mechanism.ropes import Taut
from symdyn.dynamics.mechanism.state import State, carried, joint_resistance, load_vectors, pull, vector
from symdyn.dynamics.mechanism.tree import Tree, TreeMotion, body_inertia, spherical_rotor
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import Joint, Place, Strut
from symdyn.spatial import Inertia, Transform, Vec, Wrench, add, cross, dot, neg, scale, sub, zero_vector

if TYPE_CHECKING:
    from symdyn.dynamics.reactions.free_bodies import Samples


CONTACT = "contact"
"""Type of the joint that stands for a wheel, a ball or a blade on its plane."""

Twist = Wrench  # velocity and angular velocity, in the order of the force and the moment that do work on them

TINY = 1e-9

PLACES = (2, 3)
"""Seeds of the generic positions."""


@dataclass(frozen=True)
class JointFrames:
    """One joint, of the tree or closing a loop; see the module's legend.

    Attributes:
        parent, child: numbers of bodies, -1 the ground.
        origin: placement of J in B. tip: placement of C in the moved joint frame.
        wrenches: what it can exert without working, W; () for a custom joint, which `reactions_of` knows.
        moved_by: the velocities that move it: the number, which of its own rates, and that rate per unit of it (1 but
            where it follows others); () where it closes a loop.
        S: one a rate of its own.
        rates: the joint's own rates, Σ ratio · velocity.
        paths: of a joint that closes a loop: bodies from its parent, and from its child, inwards to where both meet.
    """

    joint: Joint
    parent: int
    child: int
    origin: Transform
    X: Transform
    tip: Transform
    wrenches: tuple[Wrench, ...]
    moved_by: tuple[tuple[int, int, Expr], ...] = ()
    S: tuple[Twist, ...] = ()
    rates: tuple[Expr, ...] = ()
    paths: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())

    @property
    def graph(self) -> Graph:
        return self.X.p[0].graph

    @property
    def velocities(self) -> tuple[int, ...]:
        return tuple(k for k, _, _ in self.moved_by)

    @property
    def placement(self) -> Transform:
        """Placement of C in B."""
        return self.origin @ self.X @ self.tip

    def on_child(self, wrench: Wrench) -> Wrench:
        """Return W in the axes of C, about P."""
        return wrench.rotated((self.X @ self.tip).R.T)

    def in_joint_axes(self, wrench: Wrench) -> Wrench:
        """Return a wrench about P from the axes of C in those of J."""
        return wrench.rotated((self.X @ self.tip).R)

    def on_parent(self, wrench: Wrench) -> Wrench:
        """Return what the child exerts on the parent, -W, in the axes of B, about P: action = reaction."""
        return -wrench.rotated(self.origin.R)

    @property
    def place_on_child(self) -> Vec:
        """P in C."""
        return self.tip.inverse().p

    @property
    def place_on_parent(self) -> Vec:
        """P in B."""
        return (self.origin @ self.X).p


def hinges(scene: Scene, graph: Graph) -> tuple[JointFrames, ...]:
    """Return the joints of the tree, then those that close loops, then contacts (as joints of type "contact")."""
    number = {Scene.GROUND: -1} | {body.name: k for k, body in enumerate(scene.bodies)}
    velocities = {name: k for k, name in enumerate(scene.velocities)}
    tree = [_of_tree(joint, number, velocities, graph) for joint in scene.joints]
    closing = [(cut, cut.joint or Joint(cut.owner, CONTACT, cut.parent, cut.child)) for cut in cuts(scene, graph)]
    return (*tree, *(_of_cut(cut, joint, number, tree, graph) for cut, joint in closing))


def _of_tree(joint: Joint, number: dict[str, int], velocities: dict[str, int], graph: Graph) -> JointFrames:
    motion = joint_motion(joint, graph)
    X, still = motion.placement, zero_vector(graph)
    moved_by = tuple((velocities[name], k, ratio) for name, k, ratio in joint.moved_by(graph))
    rates = tuple(joint.speeds(graph))
    S = [Twist(still, still)] * len(rates)
    place = Transform.unit(graph)
    for part in motion.joints:
        here = place @ part.before
        axis = here.R @ part.axis
        twist = Twist(axis, still) if part.slides else Twist(cross(axis, sub(X.p, here.p)), axis)
        for k, x in part.rate:
            S[k] = S[k] + twist.scaled(x)
        place = here @ part.placement
    origin, tip = joint.origin.transform(graph), joint.tip.transform(graph)
    forbids = JOINTS[joint.type].forbids
    wrenches = forbids.wrenches(joint, X) if forbids else ()
    ends = (number[joint.parent], number[joint.child])
    return JointFrames(joint, *ends, origin, X, tip, wrenches, moved_by, tuple(S), rates)


def _of_cut(cut: Cut, joint: Joint, number: dict[str, int], tree: Sequence[JointFrames], graph: Graph) -> JointFrames:
    origin, tip = cut.on_parent, cut.on_child.inverse()
    i, j = number[cut.parent], number[cut.child]
    near, far = _path(i, tree), _path(j, tree)
    while near and far and near[-1] == far[-1]:  # nothing beyond the nearest common carrier enters
        near.pop()
        far.pop()
    J, moved = (_walked(path, tree, graph) for path in (near, far))
    X = (J @ origin).inverse() @ moved @ cut.on_child
    return JointFrames(joint, i, j, origin, X, tip, cut.wrenches(X), paths=(tuple(near), tuple(far)))


def relative_twists(loop: JointFrames, tree: Sequence[JointFrames]) -> dict[int, Twist]:
    """Return the twist of the child relative to J at P, axes of J, for every velocity that moves it, at unit size."""
    graph = loop.graph
    near, far = loop.paths
    back = (_walked(near, tree, graph) @ loop.origin).inverse()
    total: dict[int, Twist] = {}
    for path, sign in ((near, -graph.one), (far, graph.one)):
        here = back
        for body in reversed(path):
            hinge = tree[body]
            J = here @ hinge.origin
            way = sub(loop.X.p, J.point(hinge.X.p))
            for k, own, ratio in hinge.moved_by:
                v, omega = hinge.S[own]
                spin = J.R @ omega
                twist = Twist(add(J.R @ v, cross(spin, way)), spin).scaled(sign * ratio)
                total[k] = total[k] + twist if k in total else twist
            here = here @ hinge.placement
    return dict(sorted(total.items()))


def _path(body: int, tree: Sequence[JointFrames]) -> list[int]:
    """Return a body and all that carry it but the ground."""
    path = []
    while body >= 0:
        path.append(body)
        body = tree[body].parent
    return path


def _walked(path: Sequence[int], tree: Sequence[JointFrames], graph: Graph) -> Transform:
    """Return the placement of the first body of a path in what carries the last; the path leads inwards."""
    T = Transform.unit(graph)
    for k in reversed(path):
        T = T @ tree[k].placement
    return T


def drives(hinge: JointFrames, samples: Samples) -> tuple[Wrench, ...]:
    """Return D, axes of J, about P; one for every velocity of the joint."""
    if not hinge.S:
        return ()
    zero = hinge.graph.zero
    n = len(hinge.S)
    still = (zero, zero, zero)
    turning = [Wrench(still, omega) for _, omega in hinge.S]
    turns = [samples.at([x for _, omega in turning for x in omega], seed).reshape(n, 3) for seed in PLACES]
    S = turning if any(np.linalg.matrix_rank(at, tol=TINY) == n for at in turns) else list(hinge.S)
    gram = [[a.power(b) for b in S] for a in S]
    one = hinge.graph.one
    if all(vanishes(gram[i][j] - one if i == j else gram[i][j]) for i in range(n) for j in range(i + 1)):
        return tuple(S)  # also where loops are open, where angles that they hold may have any value
    columns = [solve(range(-1, n), gram, [one if i == k else zero for i in range(n)]) for k in range(n)]
    return tuple(reduce(Wrench.__add__, map(Wrench.scaled, S, column)) for column in columns)


def reactions_of(hinge: JointFrames, samples: Samples) -> tuple[Wrench, ...]:
    """Return W, axes of J, about P; t of them.

    Those of a joint that has no formula for them are units less what the drives take of them. The units that are left
    out are those that the drives themselves have large, else a combination of the others would be a drive.
    """
    kind = JOINTS.get(hinge.joint.type)  # a contact has none
    if kind is None or kind.forbids:
        return hinge.wrenches
    units, D = Wrench.units(hinge.graph), drives(hinge, samples)
    numbers = samples.at([x for force, moment in D for x in (*force, *moment)], PLACES[0]).reshape(len(D), 6)
    taken, _ = pivots(numbers.T, [range(6)], len(D))
    left = [e for k, e in enumerate(units) if k not in taken]
    for twist, drive in zip(hinge.S, D, strict=True):  # e - D Sᵀ e
        left = [e + drive.scaled(-e.power(twist)) for e in left]
    return tuple(left)


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
        wrench = load_vectors(load, scene, graph)
        wrench = wrench.rotated(placed[k].R) if load.frame == "body" and k >= 0 else wrench
        act(k, scene.seated(load).place, wrench + carried(load, scene, placed[k]))
    for strut in apart:
        if strut.is_rope:
            taut, bodies = Taut(scene, graph), {Scene.GROUND: Transform.unit(graph)}
            bodies |= {body.name: T for body, T in zip(scene.bodies, placed, strict=True)}
            length = taut.placed(strut.ends, bodies)
            (rate,) = tangents([length], state.velocity)
            tension = FORCES[strut.kind].pull.force(strut, length, rate)
            for place, wrench in taut.pulls(strut.ends, bodies):
                act(number[place.body], place, wrench.scaled(tension))
            continue
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
    """Return what a joint's own elements do along each of its rates, N m or N, shape as `hinge.S`.

    Declared forces, struts, friction, and the rotor, which takes armature · (acceleration of its elementary joint).
    """
    joint, graph = hinge.joint, hinge.graph
    forces = [force.express(graph) for force in joint.forces] or [graph.zero] * len(hinge.rates)
    forces = [force - joint_resistance(joint, rate) for force, rate in zip(forces, hinge.rates, strict=True)]
    for strut in scene.struts:
        if strut.joint == joint.name:
            law = FORCES[strut.kind].pull
            forces[0] = forces[0] - law.force(strut, joint.position(graph), hinge.rates[0])
    armature = joint.armature.express(graph)
    ball = spherical_rotor(joint, hinge.velocities, graph)
    if ball is not None:
        turning = ball.forces(state.qd, state.qdd)
        forces = [force - moment for force, moment in zip(forces, turning, strict=True)]
    elif joint.moves and not armature.is_zero:
        first = joint_motion(joint, graph).joints[0]
        bent = graph.total(x * hinge.rates[j] * hinge.rates[k] for j, k, x in first.bias)
        slopes = dict(first.rate)
        pulled = graph.total(slopes[own] * ratio * state.qdd[k] for k, own, ratio in hinge.moved_by if own in slopes)
        for k, x in first.rate:
            forces[k] = forces[k] - x * armature * (pulled + bent)
    return forces
