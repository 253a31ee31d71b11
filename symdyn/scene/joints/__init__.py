"""Joint types: one file and one row each."""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXIS, ORIENTATION
from symdyn.scene.joints.custom import CUSTOM
from symdyn.scene.joints.cylindrical import CYLINDRICAL
from symdyn.scene.joints.fixed import FIXED
from symdyn.scene.joints.free import FREE
from symdyn.scene.joints.helical import HELICAL
from symdyn.scene.joints.joint_kind import Block, Forbids, Gimbal, JointKind, JointMotion, Move
from symdyn.scene.joints.joint_mark import JointMark, MarkPart
from symdyn.scene.joints.planar import PLANAR
from symdyn.scene.joints.point_on_line import POINT_ON_LINE
from symdyn.scene.joints.point_on_plane import POINT_ON_PLANE
from symdyn.scene.joints.prismatic import PRISMATIC
from symdyn.scene.joints.revolute import REVOLUTE
from symdyn.scene.joints.rod import ROD
from symdyn.scene.joints.spherical import SPHERICAL
from symdyn.scene.joints.universal import UNIVERSAL

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


__all__ = [
    "AXIS",
    "JOINTS",
    "ORIENTATION",
    "Block",
    "Forbids",
    "Gimbal",
    "JointKind",
    "JointMark",
    "JointMotion",
    "MarkPart",
    "Move",
    "own_keys",
]
