"""Which joints turn about parallel axes: their angles add up, and sines of the sums make short closed forms."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.algebra import AngleGroup, TrigonometricRing
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, unit
from symdyn.scene.values import Joint
from symdyn.spatial import Vec, dot


@dataclass(frozen=True)
class Neighbours:
    """A joint that only turns and the next one below it.

    Attributes:
        q: the joint's coordinate.
        below: the coordinate of the next revolute joint towards the ground; None if there is none.
        alignment: cosine of the angle between the two axes, which is ±1 for parallel ones.
        stand: name of the body that carries the axis, with joints between that do not turn it.
        axis: the axis as that body sees it.
    """

    q: Expr
    below: Expr | None
    alignment: Expr
    stand: str
    axis: Vec


def _axis(joint: Joint, graph: Graph) -> Vec | None:
    """Return the axis of a joint that turns about it and does nothing else; None of others."""
    kind = JOINTS[joint.type]
    axis = None if kind.slides(joint) else kind.axis(joint)
    return axis and unit(axis, graph)


def _neighbours(joint: Joint, carrier: dict[str, Joint], graph: Graph) -> Neighbours:
    q, axis, below = graph.symbol(joint.coordinate), _axis(joint, graph), joint
    assert axis, "only joints that turn have neighbours"
    while below.parent != Scene.GROUND:
        axis = below.origin.transform(graph).R @ axis
        below = carrier[below.parent]
        axis = below.tip.transform(graph).R @ axis
        kind, other = JOINTS[below.type], _axis(below, graph)
        if (kind.axis(below) is None and kind.velocities(below)) or (other and below.coupling):
            return Neighbours(q, None, graph.zero, below.child, axis)  # no angle of the ring
        if other:
            return Neighbours(q, graph.symbol(below.coordinate), dot(axis, other), below.child, axis)
    return Neighbours(q, None, graph.zero, Scene.GROUND, below.origin.transform(graph).R @ axis)


def angle_groups(scene: Scene, graph: Graph, across: bool = False) -> tuple[AngleGroup, ...]:
    """Return the groups of two and more joints with parallel axes, with every sum of angles along a path.

    `across` makes chains that stand side by side on one body, or on the ground, one group, as loops between them need;
    the differences of their total angles are then among the sums.
    """
    carrier = {joint.child: joint for joint in scene.joints}
    turning = [joint for joint in scene.joints if _axis(joint, graph) and not joint.coupling]
    neighbours = [_neighbours(joint, carrier, graph) for joint in turning]
    beside = {
        (one.q, pair.q): dot(one.axis, pair.axis)
        for k, pair in enumerate(neighbours)
        for one in neighbours[:k]
        if across and one.stand == pair.stand
    }
    nodes = [*(pair.alignment for pair in neighbours), *beside.values()]
    ring = TrigonometricRing(nodes)  # where "equal to ±1" is decided, exactly
    found = dict(zip(nodes, evaluate(nodes, ring, ring.values(nodes)), strict=True))
    members: list[list[Expr]] = []
    signs: dict[Expr, int] = {}
    previous: dict[Expr, Expr] = {}
    group: dict[Expr, int] = {}

    def parallel(cosine: Expr) -> int:
        return next((sign for sign in (1, -1) if ring.is_zero(found[cosine] - sign)), 0)

    for pair in neighbours:
        relative = parallel(pair.alignment)
        twin = next((a for (a, b), cosine in beside.items() if b is pair.q and parallel(cosine)), None)
        if pair.below is not None and relative:
            group[pair.q], signs[pair.q] = group[pair.below], signs[pair.below] * relative
            previous[pair.q] = pair.below
        elif twin is not None:
            group[pair.q], signs[pair.q] = group[twin], signs[twin] * parallel(beside[twin, pair.q])
        else:
            group[pair.q], signs[pair.q] = len(members), 1
            members.append([])
        members[group[pair.q]].append(pair.q)
    return tuple(_group(atoms, signs, previous) for atoms in members if len(atoms) > 1)


def _group(atoms: list[Expr], signs: dict[Expr, int], previous: dict[Expr, Expr]) -> AngleGroup:
    """Return the group with the sums q_a ± … ± q_b over every stretch of every path, the first sign positive.

    Where paths stand side by side, the differences of their total angles follow.
    """
    sums, totals = [], []
    for end in atoms:
        path: list[Expr] = []
        joint: Expr | None = end
        while joint is not None:
            path.append(joint)
            first = signs[joint]
            sums.append(tuple(first * signs[atom] if atom in path else 0 for atom in atoms))
            joint = previous.get(joint)
        totals.append((path[-1], tuple(signs[atom] * (atom in path) for atom in atoms)))
    for k, (root, b) in enumerate(totals):
        for other, a in totals[:k]:
            if other is not root:
                difference = [x - y for x, y in zip(a, b, strict=True)]
                first = next(x for x in difference if x)
                sums.append(tuple(first * x for x in difference))
    return AngleGroup(tuple(atoms), tuple(sums), tuple((signs[atom], previous.get(atom)) for atom in atoms))
