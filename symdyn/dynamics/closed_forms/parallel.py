"""Which joints turn about parallel axes: their angles add up, and sines of the sums make short closed forms."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.algebra.sums_of_angles import AngleGroup
from symdyn.algebra.trigonometric import TrigonometricRing
from symdyn.dynamics.state import placement
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import GROUND, Joint, Scene
from symdyn.scene.joints.blocks import unit
from symdyn.spatial import apply, dot


@dataclass(frozen=True)
class Neighbours:
    """A revolute joint and the next one below it.

    Attributes:
        q: the joint's coordinate.
        below: the coordinate of the next revolute joint towards the ground; None if there is none.
        alignment: cosine of the angle between the two axes, which is ±1 for parallel ones.
    """

    q: Expr
    below: Expr | None
    alignment: Expr


def _candidates(scene: Scene, graph: Graph) -> list[Neighbours]:
    """Return every revolute joint with the one below it, ground first."""
    carrier = {joint.child: joint for joint in scene.joints}
    return [_neighbours(joint, carrier, graph) for joint in scene.joints if _turns(joint)]


def _turns(joint: Joint) -> bool:
    """Whether the joint turns by a coordinate of its own; the angle of one that follows is no unit of the ring."""
    return joint.type == "revolute" and joint.coupling is None


def _neighbours(joint: Joint, carrier: dict[str, Joint], graph: Graph) -> Neighbours:
    q, axis, below = graph.symbol(joint.coordinate), unit(joint.axis, graph), joint
    while below.parent != GROUND:
        axis = apply(placement(below.origin, graph).R, axis)
        below = carrier[below.parent]
        axis = apply(placement(below.tip, graph).R, axis)
        if below.type not in ("revolute", "prismatic", "fixed") or (below.type == "revolute" and below.coupling):
            break  # its turn takes the axis out of line
        if _turns(below):
            return Neighbours(q, graph.symbol(below.coordinate), dot(axis, unit(below.axis, graph)))
    return Neighbours(q, None, graph.zero)


def angle_groups(scene: Scene, graph: Graph) -> tuple[AngleGroup, ...]:
    """Return the groups of two and more joints with parallel axes, with every sum of angles along a path."""
    neighbours = _candidates(scene, graph)
    nodes = [pair.alignment for pair in neighbours]
    ring = TrigonometricRing(nodes)  # where "equal to ±1" is decided, exactly
    alignments = evaluate(nodes, ring, ring.values(nodes))
    members: list[list[Expr]] = []
    signs: dict[Expr, int] = {}
    previous: dict[Expr, Expr] = {}
    group: dict[Expr, int] = {}
    for pair, alignment in zip(neighbours, alignments, strict=True):
        relative = next((sign for sign in (1, -1) if ring.is_zero(alignment - sign)), 0)
        if pair.below is not None and relative:
            group[pair.q], signs[pair.q] = group[pair.below], signs[pair.below] * relative
            previous[pair.q] = pair.below
        else:
            group[pair.q], signs[pair.q] = len(members), 1
            members.append([])
        members[group[pair.q]].append(pair.q)
    return tuple(_group(atoms, signs, previous) for atoms in members if len(atoms) > 1)


def _group(atoms: list[Expr], signs: dict[Expr, int], previous: dict[Expr, Expr]) -> AngleGroup:
    """Return the group with the sums q_a ± … ± q_b over every stretch of every path, the first sign positive."""
    sums = []
    for end in atoms:
        path: list[Expr] = []
        joint: Expr | None = end
        while joint is not None:
            path.append(joint)
            first = signs[joint]
            sums.append(tuple(first * signs[atom] if atom in path else 0 for atom in atoms))
            joint = previous.get(joint)
    return AngleGroup(tuple(atoms), tuple(sums), tuple((signs[atom], previous.get(atom)) for atom in atoms))
