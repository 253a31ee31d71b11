"""Where every body is: placements in the ground frame, multiplied out from the ground to the tips."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.dynamics.mechanism.state import vector
from symdyn.graph import Graph
from symdyn.scene import Scene
from symdyn.scene.joints import joint_motion
from symdyn.scene.values import Joint, Place
from symdyn.spatial import Transform, Vec, sub


def ends_apart(scene: Scene, ends: Sequence[Place], graph: Graph) -> Vec:
    """Return the way from one place to another, m, in the frame of the last body that carries both."""
    carrier = {joint.child: joint for joint in scene.joints}
    paths = []
    for end in ends:
        path = [end.body]
        while path[-1] != Scene.GROUND:
            path.append(carrier[path[-1]].parent)
        paths.append(path)
    common = next(body for body in paths[0] if body in paths[1])
    points = []
    for end, path in zip(ends, paths, strict=True):
        point = vector(end.at, graph)
        for body in path[: path.index(common)]:
            point = joint_placement(carrier[body], graph).point(point)
        points.append(point)
    return sub(points[1], points[0])


def joint_placement(joint: Joint, graph: Graph) -> Transform:
    """Return the placement of a joint's child in its parent: origin · motion(q) · tip."""
    origin, tip = joint.origin.transform(graph), joint.tip.transform(graph)
    return origin @ joint_motion(joint, graph).placement @ tip


def body_placements(scene: Scene, graph: Graph) -> dict[str, Transform]:
    """Return T_0B for every body B, the ground's included.

    T_0B = T_0P · origin · motion(q) · tip for the joint that carries B on its parent P.
    """
    placed = {Scene.GROUND: Transform.unit(graph)}
    for joint in scene.joints:
        origin, tip = joint.origin.transform(graph), joint.tip.transform(graph)
        placed[joint.child] = placed[joint.parent] @ origin @ joint_motion(joint, graph).placement @ tip
    return placed


def moved_placements(scene: Scene, joint: Joint | None, graph: Graph) -> Iterator[tuple[int, Transform]]:
    """Yield, for every joint that moves the child, the number of its coordinate and the child's placement before it.

    The frame is the joint frame, before the motion: where the joints nearer to the ground stand does not change a
    velocity written in the body. Of joints that share a coordinate the last one counts, nearest to the ground: its
    placement holds the others.
    """
    number = {coordinate: i for i, coordinate in enumerate(scene.coordinates)}
    carrier = {j.child: j for j in scene.joints}
    T = None
    while joint is not None:
        tip = joint.tip.transform(graph)
        T = tip if T is None else tip @ T
        if joint.moves:
            T = joint_motion(joint, graph).placement @ T
            for q in (joint.coupling.coordinate,) if joint.coupling else joint.coordinates:
                yield number[q], T
        T = joint.origin.transform(graph) @ T
        joint = None if joint.parent == Scene.GROUND else carrier[joint.parent]
