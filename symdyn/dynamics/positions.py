"""Where every body is: placements in the ground frame, multiplied out from the ground to the tips."""

from __future__ import annotations

from symdyn.dynamics.state import joint_motion, placement
from symdyn.graph import Graph
from symdyn.scene import GROUND, Scene
from symdyn.spatial import Transform, unit_transform


def body_placements(scene: Scene, graph: Graph) -> dict[str, Transform]:
    """Return T_0B for every body B, the ground's included.

    T_0B = T_0P · origin · motion(q) · tip for the joint that carries B on its parent P.
    """
    placed = {GROUND: unit_transform(graph)}
    for joint in scene.joints:
        origin, tip = placement(joint.origin, graph), placement(joint.tip, graph)
        placed[joint.child] = placed[joint.parent] @ origin @ joint_motion(joint, graph).placement @ tip
    return placed
