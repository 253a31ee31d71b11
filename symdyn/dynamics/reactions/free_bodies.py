"""Bodies cut free: what acts on each, and the reactions of joints from the tips to the ground.

    j          a moving body; frame j has its origin O_j in the joint that carries it, axes of the body
    F^A_jj     (5.1) bivector [force; moment about O_j] of weight, loads, and the joints' own elements, axes of frame j
    F^D_jj     (5.17) bivector of its inertia forces
    P_1j       (5.4) direction cosines of frame j in the ground

The equilibrium of what hangs on a joint gives its wrench:

    f        wrench that the parent exerts on body j through its joint, about the origin of the body's frame, its axes
    W        wrench of a joint that closes a loop, on its child, axes of its joint frame, about the moved origin P
    τ_k      Σ over the elementary joints of velocity k of S·f, and the rotors: what drives and joint elements do
    λ        sizes of W, and of the wrenches of contacts: the multipliers of forward dynamics, or from `ties` where a
             motion is given

A reaction is the whole wrench through the joint: what the bearing forbids, the drive, and the joint's own springs,
dampers and friction; only what turns the rotor itself (armature) stays in the drive. It acts at the origin of the moved
joint frame. No body is merged or regrouped: a fixed joint has its reaction, and so a body is cut by declaring it in two
parts, a fixed joint between them.

Reference: the textbook, section 5.1.1, eq. (5.1)-(5.18); Khalil and Dombre, Modeling, Identification and Control of
Robots (2002), section 9.5.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics.mechanism.state import State, quaternions, vector
from symdyn.dynamics.mechanism.tree import Tree, TreeMotion
from symdyn.dynamics.reactions.closure_equations import ClosureEquation, refuse_without_place, sizes, ties
from symdyn.dynamics.reactions.joint_frames import (
    PLACES,
    TINY,
    JointFrames,
    Twist,
    acting,
    drives,
    hinges,
    inertias,
    motions,
    needed,
    own_forces,
    placements,
    relative_twists,
    way_apart,
)
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, evaluate, reachable, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Strut
from symdyn.spatial import Inertia, Mat, Transform, Vec, Wrench, add, cross, neg, scale, zero_vector
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_decisions import LoopDecisions


@dataclass(frozen=True)
class Bivectors:
    """The known bivectors of one body, frame j."""

    action: Wrench  # (5.1)
    inertia: Wrench  # (5.17)
    motion: TreeMotion  # ω_1j, ω̇_1j, acceleration of O_j; axes of frame j
    body: Inertia  # mass, first moment, and I_jj of (5.15) about O_j

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
    gravity, placed, loads = vector(scene.gravity, graph), hanging.placements, hanging.acting
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


@dataclass(frozen=True)
class FreeBodies:
    """A scene's bodies and joints on its graph, for recursions over wrenches.

    Attributes:
        decisions: what is decided about loops and rows; None for a tree without, or where nothing is decided.
    """

    scene: Scene
    tree: Tree
    state: State
    decisions: LoopDecisions | None = None

    @property
    def graph(self) -> Graph:
        return self.tree.graph

    @cached_property
    def hinges(self) -> tuple[JointFrames, ...]:
        """The joints of the tree, then those of the loops, contacts, and straight parts of ropes."""
        return hinges(self.scene, self.graph)

    @cached_property
    def samples(self) -> Samples:
        """Numbers for what is decided by numbers: which entries vanish, which pivots are large."""
        if self.decisions is None:
            return Samples(self.scene, self.graph)
        assembly = self.decisions.assembly
        positions = (assembly.regular, *assembly.configurations)
        places = (dict(assembly.parameters) | dict(zip(self.scene.coordinates, q, strict=True)) for q in positions)
        return Samples(self.scene, self.graph, tuple(places))

    @property
    def joints(self) -> tuple[JointFrames, ...]:
        return self.hinges[: len(self.scene.joints)]

    @property
    def loops(self) -> tuple[JointFrames, ...]:
        return self.hinges[len(self.scene.joints) : len(self.scene.joints) + len(self.scene.loops)]

    @property
    def cuts(self) -> tuple[JointFrames, ...]:
        """The joints that close loops, and contacts."""
        return self.hinges[len(self.scene.joints) :]

    def of_rope(self, cut: JointFrames) -> bool:
        """Tell whether a cut is a straight part of a rope."""
        return cut in self.cuts[len(self.loops) :] and any(
            one.name == cut.joint.name for one in self.scene.lasting_ropes
        )

    @cached_property
    def placements(self) -> list[Transform]:
        return placements(self.joints)

    @property
    def frames(self) -> list[Transform]:
        """Placements in the ground of frames with axes of the bodies, their origins in the joints that carry them."""
        ways = (hinge.place_on_child for hinge in self.joints)
        return [T @ Transform(Mat.identity(self.graph), way) for T, way in zip(self.placements, ways, strict=True)]

    @property
    def inertias(self) -> list[Inertia]:
        """Inertia of every body about the origin of its own frame."""
        return inertias(self.scene, self.tree)

    @property
    def acting(self) -> list[Wrench]:
        """What loads, and struts between points, do on every body about the origin of its frame, no weight."""
        return acting(self.scene, self.joints, self.state)

    def own_forces(self, hinge: JointFrames) -> list[Expr]:
        """Return what a joint's own elements do along each of its velocities, N m or N."""
        return own_forces(self.scene, hinge, self.state)

    def drives(self, hinge: JointFrames) -> tuple[Wrench, ...]:
        """Return D of a joint, axes of J, about P; one for every velocity of the joint."""
        return drives(hinge, self.samples)

    def relative_twists(self, loop: JointFrames) -> dict[int, Twist]:
        """Return the twist of the child relative to J at P, axes of J, for every velocity, of what closes a loop."""
        return relative_twists(loop, self.joints)

    def squared_length(self, strut: Strut) -> Expr:
        """Return the squared distance of the ends of a strut between points, m²."""
        return way_apart(self.scene, strut, self.placements, self.graph)[1]

    def bivectors(self, own: Sequence[Sequence[Expr]]) -> tuple[Bivectors, ...]:
        """Return actions, what joints do by themselves (`own`) included, and inertia bivectors of every body."""
        return known_bivectors(self, own)

    @property
    def closing(self) -> list[Expr]:
        """Entries of the wrenches at unit size that close loops and keep contacts, of the rows that are kept."""
        return [x for one in ties(self) for _, wrench in one.acts for part in wrench for x in part]

    def carried(self) -> list[tuple[ClosureEquation, Expr]]:
        """Return what closes loops, contacts and rows of a closed mechanism, each with its size in `reactions`."""
        unknown = ties(self)
        return list(zip(unknown, sizes(self, unknown, self.needed_forces(self.transmitted(self.loads))), strict=True))

    def closed_by(self, cuts: Sequence[JointFrames]) -> FreeBodies:
        """Return the mechanism with other hinges where it is cut."""
        found = replace(self)
        found.__dict__["hinges"] = (*self.joints, *cuts)
        return found

    @cached_property
    def loads(self) -> list[Wrench]:
        """What every body needs for its motion beyond weight and loads, about the origin of its frame."""
        moved = motions(self.scene, self.tree, self.state.qd, self.state.qdd, neg(self.tree.gravity))
        wanted = [needed(body, motion) for body, motion in zip(self.inertias, moved, strict=True)]
        given = self.acting
        return [a + b.scaled(self.graph.constant(-1)) for a, b in zip(wanted, given, strict=True)]

    def transmitted(self, loads: Sequence[Wrench]) -> list[Wrench]:
        """Return f of every joint of the tree for what each body needs."""
        f = list(loads)
        for k in reversed(range(len(self.joints))):
            hinge = self.joints[k]
            if hinge.parent >= 0:
                T = hinge.placement
                f[hinge.parent] = f[hinge.parent] + f[k].rotated(T.R).about(T.p)
        return f

    def carry(self, f: list[Wrench], loop: JointFrames, wrench: Wrench) -> None:
        """Add to f what joints of the tree transmit when a joint that closes a loop exerts W."""
        ends = (loop.on_parent(wrench).about(loop.place_on_parent), loop.on_child(wrench).about(loop.place_on_child))
        for path, exerted in zip(loop.paths, ends, strict=True):
            need = -exerted
            for k in path:
                f[k] = f[k] + need
                T = self.joints[k].placement
                need = need.rotated(T.R).about(T.p)

    def at_joints(self, f: Sequence[Wrench]) -> list[Wrench]:
        """Return f of every joint of the tree about the origin of its moved joint frame, axes of the body."""
        return [one.about(neg(hinge.place_on_child)) for hinge, one in zip(self.joints, f, strict=True)]

    def felt(self, wrenches: Sequence[Wrench]) -> list[Expr]:
        """Return Σ S·wrench on every velocity, shape (nv,), for wrenches from `at_joints`; N m or N."""
        total = [self.graph.zero] * self.state.n
        for hinge, wrench in zip(self.joints, wrenches, strict=True):
            if hinge.velocities:
                here = hinge.in_joint_axes(wrench)
                for k, own, ratio in hinge.moved_by:
                    total[k] = total[k] + ratio * here.power(hinge.S[own])
        return total

    def needed_forces(self, f: Sequence[Wrench]) -> list[Expr]:
        """Return M u̇ + h of the tree, shape (nv,): what drives and loops exert together, for f from `transmitted`."""
        return self.driving(self.felt(self.at_joints(f)))

    def driving(self, felt: Sequence[Expr]) -> list[Expr]:
        """Return the driving forces, shape (nv,): what the velocities feel less what the joints' own elements do."""
        total = list(felt)
        for hinge in self.joints:
            forces = self.own_forces(hinge)
            for k, own, ratio in hinge.moved_by:
                total[k] = total[k] - ratio * forces[own]
        return total


@dataclass(frozen=True)
class Samples:
    """Values of a scene's symbols; the same seed, the same values.

    Attributes:
        places: values by name that stand above all others at seeds 1, 2, …: of closed loops, an assembled position and
            then generic ones, since a position at which loops are open says nothing about a mechanism that closes them.
    """

    scene: Scene
    graph: Graph
    places: tuple[Mapping[str, float], ...] = ()

    def at(self, entries: Sequence[Expr], seed: int = 1) -> Array:
        """Return entries at seed 1, where the scene says that it starts, or at other positions, seeds from 2 on.

        What has no value there is drawn from 0.3 … 1.7; parameters have their values, quaternions the length 1.
        """
        values = {node: self._drawn(node, seed) for node in _symbols(entries)}
        known: dict[str, Quantity] = {p.name: p.value for p in self.scene.parameters if p.value is not None}
        if seed == 1:
            for joint in self.scene.moving:
                known |= dict(zip(joint.coordinates, joint.start, strict=False))
        for name, quantity in known.items():
            node = quantity.express(self.graph)
            inner = {x: values.get(x, self._drawn(x, seed)) for x in _symbols([node])}
            values[self.graph.symbol(name)] = evaluate([node], Floats(), inner)[0]
        if seed <= len(self.places):
            values |= {self.graph.symbol(name): value for name, value in self.places[seed - 1].items()}
        for group in quaternions(self.scene):
            nodes = [self.graph.symbol(name) for name in group]
            values |= {node: values.get(node, self._drawn(node, seed)) for node in nodes}
            length = sum(values[node] ** 2 for node in nodes) ** 0.5
            values |= {node: values[node] / length for node in nodes if length}
        return np.array(evaluate(list(entries), Floats(), values), dtype=np.float64)

    def vanish(self, entries: Sequence[Expr]) -> bool:
        """Whether entries are zero at a generic position."""
        return bool(np.abs(self.at(entries, PLACES[0])).max() < TINY)

    def _drawn(self, node: Expr, seed: int) -> float:
        return random.Random(f"{seed}:{node.value}").uniform(0.3, 1.7)


def _symbols(entries: Sequence[Expr]) -> list[Expr]:
    return [node for node in reachable(entries) if node.op is Op.SYMBOL]


def reactions(hanging: FreeBodies, axes: str = "body", multipliers: Sequence[Expr] | None = None) -> list[Expr]:
    """Return every joint's reaction, row by row, shape (joints + loops, 6): [force; moment], N and N m.

    Args:
        hanging: the mechanism.
        axes: "body" (of the child as declared), "joint" (of the joint frame on the parent's side, for every type of
            joint) or "ground".
        multipliers: λ, shape (m,), where forces give the motion; None where the motion is given, and the drives of
            passive joints are zero.

    Raises:
        DerivationError: motion and drives do not determine what the loops transmit, or a row does not say where its
            force acts.
    """
    refuse_without_place(hanging.scene)
    f = hanging.transmitted(hanging.loads)
    if not hanging.cuts:
        return as_rows(hanging, hanging.at_joints(f), axes)
    unknown = ties(hanging)
    if multipliers is None:
        multipliers = sizes(hanging, unknown, hanging.needed_forces(f))
    return with_loops(hanging, f, unknown, multipliers, axes)


def with_loops(
    hanging: FreeBodies, f: Sequence[Wrench], unknown: Sequence[ClosureEquation], multipliers: Sequence[Expr], axes: str
) -> list[Expr]:
    """Return every reaction for f of the tree alone and given λ of what closes the loops; see `reactions`."""
    f = list(f)
    closing = [Wrench.none(hanging.graph)] * len(hanging.cuts)
    for one, size in zip(unknown, multipliers, strict=True):
        for number, wrench in one.acts:
            closing[number] = closing[number] + wrench.scaled(size)
    for loop, wrench in zip(hanging.cuts, closing, strict=True):
        hanging.carry(f, loop, wrench)
    ends = [loop.on_child(wrench) for loop, wrench in zip(hanging.loops, closing, strict=False)]
    return as_rows(hanging, [*hanging.at_joints(f), *ends], axes)


def carried(hanging: FreeBodies, axes: str) -> dict[str, list[list[Expr]]]:
    """Return every joint's reaction to each wrench of unit size of a contact or a rope, by its name, and to no more."""
    none, one = [Wrench.none(hanging.graph)] * len(hanging.joints), hanging.graph.one
    found: dict[str, list[ClosureEquation]] = {}
    for k, cut in enumerate(hanging.cuts):
        each, name = [ClosureEquation("", ((k, W),), ()) for W in cut.wrenches], cut.joint.name
        found[name] = [found[name][0] + each[0]] if name in found else each  # of a rope
    return {name: [with_loops(hanging, none, [unit], [one], axes) for unit in each] for name, each in found.items()}


def percussions(hanging: FreeBodies, sizes: Sequence[Expr]) -> list[Expr]:
    """Return every joint's reaction percussion at an impact, shape (joints, 6): [force; moment], N s and N m s.

    These are reactions (5.18) with the changes of the velocities in place of q̈, at rest; axes of the ground.

    Args:
        hanging: the mechanism without weights, loads and elements, and what strikes, if anything does, as a contact.
        sizes: percussions of this contact along its components.
    """
    f = hanging.transmitted(hanging.loads)
    for struck in hanging.cuts:
        for wrench, size in zip(struck.wrenches, sizes, strict=True):
            hanging.carry(f, struck, wrench.scaled(size))
    still = dict.fromkeys(hanging.state.qd, hanging.graph.zero)
    return substitute(as_rows(hanging, hanging.at_joints(f), "ground"), still)


def as_rows(hanging: FreeBodies, wrenches: Sequence[Wrench], axes: str) -> list[Expr]:
    """Return the wrenches of all joints, axes of their children, in the axes that are asked for; see `reactions`."""
    placed = hanging.placements if axes == "ground" else []
    entries: list[Expr] = []
    for hinge, wrench in zip((*hanging.joints, *hanging.loops), wrenches, strict=True):
        force, moment = hinge.in_joint_axes(wrench) if axes == "joint" else wrench
        if axes == "ground" and hinge.child >= 0:
            force, moment = wrench.rotated(placed[hinge.child].R)
        entries += [*force, *moment]
    return entries
