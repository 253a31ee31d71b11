"""The kinematic tree that the recursions run over: only moving bodies, frames on the joints.

The scene says `pose of child in parent = origin · motion · tip`, with frames wherever the user put them. Here body i
carries its frame in the moved joint frame, so that the axis is constant and as simple as declared, and whatever hangs
on it by fixed joints is part of it.

    i, p      a moving body 1..n and its parent, p < i; body 0 is the ground
    T[i]      placement of frame i in frame p
    S[i]      motion subspace of joint i in frame i: (angular, linear)
    inertia   of body i about the origin of frame i, everything welded to it included
    k, ratio  coordinate that moves joint i, and its rate per unit rate of that coordinate: 1, unless joint i follows
              another joint's coordinate, so that two bodies share one k
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.dynamics.state import first_moment, joint_motion, joint_position, placement, unit_axis, vector
from symdyn.graph import Expr, Graph
from symdyn.scene import GROUND, JOINTS, Body, Scene, express
from symdyn.spatial import (
    Inertia,
    Transform,
    Vec,
    add_matrices,
    no_inertia,
    point_inertia,
    symmetric,
    unit_transform,
    zero_vector,
)


@dataclass(frozen=True)
class Topology:
    """How moving bodies 1..N hang together in n coordinates; tuples have N + 1 entries, entry 0 is the ground.

    Attributes:
        graph: where the entries live.
        gravity: acceleration of free fall, ground frame, m/s^2.
        parent: parent[i] < i; parent[0] is -1.
        column: column[i] is the coordinate k of joint i, from 0; -1 for the ground.
        ratio: as in the module's legend.
        armature: inertia of the rotor of joint i, seen at the joint, kg m^2 or kg.
        n: number of coordinates.
    """

    graph: Graph
    gravity: Vec
    parent: tuple[int, ...]
    column: tuple[int, ...]
    ratio: tuple[Expr, ...]
    armature: tuple[Expr, ...]
    n: int

    @property
    def coupled(self) -> bool:
        """Whether some joint follows another joint's coordinate."""
        return len(self.parent) - 1 > self.n

    def outward(self) -> range:
        """Return the moving bodies from the ground to the tips."""
        return range(1, len(self.parent))

    def inward(self) -> range:
        """Return the moving bodies from the tips to the ground."""
        return range(len(self.parent) - 1, 0, -1)

    def rates(self, qd: Sequence[Expr]) -> list[Expr]:
        """Return the rate of every joint, entry 0 the ground's, for the rates of the coordinates, shape (n,)."""
        return [self.graph.zero] + [self.ratio[i] * qd[self.column[i]] for i in self.outward()]

    def gather(self, forces: Sequence[Expr]) -> list[Expr]:
        """Return the forces on the coordinates, shape (n,), for the forces on the joints, entry 0 unused."""
        total = [self.graph.zero] * self.n
        for i in self.outward():
            total[self.column[i]] = total[self.column[i]] + self.ratio[i] * forces[i]
        return total

    def coordinate_parents(self) -> list[int]:
        """Return the tree of coordinates 1..n for `ldl.solve`: that of the bodies, or a chain where joints follow."""
        return list(range(-1, self.n)) if self.coupled else list(self.parent)


@dataclass(frozen=True)
class Tree(Topology):
    """A tree of moving bodies with the frames that the scene declares.

    Attributes:
        base: base[i] is the constant placement of joint frame i in frame p.
        T, S, inertia: as in the module's legend; T[i] is base[i] and then the motion of the joint.
        position: position of joint i in terms of the coordinates, rad or m.
        home: for every body of the scene the moving body that carries it, and its placement there.
    """

    base: tuple[Transform, ...]
    T: tuple[Transform, ...]
    S: tuple[tuple[Vec, Vec], ...]
    inertia: tuple[Inertia, ...]
    position: tuple[Expr, ...]
    home: dict[str, tuple[int, Transform]]


def build_tree(scene: Scene, graph: Graph) -> Tree:
    """Return the scene's kinematic tree."""
    still = unit_transform(graph)
    nothing = (zero_vector(graph), zero_vector(graph))
    parent, base, T, S, inertia = [-1], [still], [still], [nothing], [no_inertia(graph)]
    column, ratio, armature, position = [-1], [graph.zero], [graph.zero], [graph.zero]
    coordinates = {name: k for k, name in enumerate(scene.coordinates)}
    home: dict[str, tuple[int, Transform]] = {GROUND: (0, still)}
    for joint, body in zip(scene.joints, scene.bodies, strict=True):
        carrier, place = home[joint.parent]
        place = place @ placement(joint.origin, graph)
        if joint.moves:
            assert JOINTS[joint.type].nv == 1, f"{joint.type}: the tree carries one velocity a joint so far"
            leader = joint.coupling.coordinate if joint.coupling else joint.coordinate
            column.append(coordinates[leader])
            ratio.append(express(joint.coupling.ratio, graph) if joint.coupling else graph.one)
            armature.append(express(joint.armature, graph))
            parent.append(carrier)
            base.append(place)
            T.append(place @ joint_motion(joint, graph))
            position.append(joint_position(joint, graph))
            S.append(JOINTS[joint.type].subspace(unit_axis(joint, graph))[0])
            inertia.append(no_inertia(graph))
            carrier, place = len(parent) - 1, still
        place = place @ placement(joint.tip, graph)
        home[body.name] = (carrier, place)
        inertia[carrier] = inertia[carrier] + body_inertia(body, graph).seen_from(place)
    gravity = vector(scene.gravity, graph)
    return Tree(
        graph=graph,
        gravity=gravity,
        parent=tuple(parent),
        column=tuple(column),
        ratio=tuple(ratio),
        armature=tuple(armature),
        n=len(coordinates),
        base=tuple(base),
        T=tuple(T),
        S=tuple(S),
        inertia=tuple(inertia),
        position=tuple(position),
        home=home,
    )


def body_inertia(body: Body, graph: Graph) -> Inertia:
    """Return the inertia of a declared body about the origin of its own frame."""
    total = no_inertia(graph)
    for particle in body.particles:
        total = total + point_inertia(express(particle.mass, graph), vector(particle.at, graph))
    m = express(body.mass, graph)
    matrix = symmetric(*(express(entry, graph) for entry in body.inertia))
    if body.about == "frame":
        return total + Inertia(m, first_moment(body, graph), matrix)
    assert body.com is not None
    steiner = point_inertia(m, vector(body.com, graph))
    return total + Inertia(m, steiner.h, add_matrices(matrix, steiner.I))
