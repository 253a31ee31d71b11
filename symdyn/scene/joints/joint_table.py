"""Joint types: one row each, in a file of its own where it has code."""

from __future__ import annotations

from symdyn.graph import Graph
from symdyn.scene.joints.custom import CUSTOM
from symdyn.scene.joints.helical import HELICAL
from symdyn.scene.joints.joint_kind import JointKind, JointMotion
from symdyn.scene.joints.plain_types import (
    CYLINDRICAL,
    FIXED,
    FREE,
    PLANAR,
    POINT_ON_LINE,
    POINT_ON_PLANE,
    PRISMATIC,
    REVOLUTE,
    SPHERICAL,
)
from symdyn.scene.joints.rod import ROD
from symdyn.scene.joints.universal import UNIVERSAL
from symdyn.scene.values.joint import Joint, velocity_name

JOINTS: dict[str, JointKind] = {
    "revolute": REVOLUTE,
    "prismatic": PRISMATIC,
    "fixed": FIXED,
    "helical": HELICAL,
    "cylindrical": CYLINDRICAL,
    "universal": UNIVERSAL,
    "spherical": SPHERICAL,
    "planar": PLANAR,
    "point_on_line": POINT_ON_LINE,
    "point_on_plane": POINT_ON_PLANE,
    "rod": ROD,
    "free": FREE,
    "custom": CUSTOM,
}


def own_keys() -> tuple[str, ...]:
    """Return the keys that some joint type takes, each once."""
    return tuple(dict.fromkeys(key.name for kind in JOINTS.values() for key in kind.keys))


def joint_motion(joint: Joint, graph: Graph) -> JointMotion:
    """Return the motion of the moved joint frame in the joint frame; velocities count from the joint's first."""
    if joint.coupling is not None:
        ratio = joint.coupling.ratio.express(graph)
        leader = graph.symbol(velocity_name(joint.coupling.coordinate))
        position = joint.position(graph)
        return JOINTS[joint.type].motion(joint, graph, (position,), (ratio * leader,))
    q = tuple(graph.symbol(name) for name in joint.coordinates)
    return JOINTS[joint.type].motion(joint, graph, q, tuple(graph.symbol(name) for name in joint.rates))
