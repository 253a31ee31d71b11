"""How a joint moves in the symbols of its coordinates and velocities, a coupled one in those of its leader."""

from __future__ import annotations

from symdyn.graph import Graph
from symdyn.scene.joints.joint_kind import JointMotion
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.joint import Joint, velocity_name


def joint_motion(joint: Joint, graph: Graph) -> JointMotion:
    """Return the motion of the moved joint frame in the joint frame; velocities count from the joint's first."""
    if joint.coupling is not None:
        ratio = joint.coupling.ratio.express(graph)
        leader = graph.symbol(velocity_name(joint.coupling.coordinate))
        position = joint.position(graph)
        return JOINTS[joint.type].motion(joint, graph, (position,), (ratio * leader,))
    q = tuple(graph.symbol(name) for name in joint.coordinates)
    return JOINTS[joint.type].motion(joint, graph, q, tuple(graph.symbol(name) for name in joint.rates))
