"""Joint types: one row each, in a file of its own where it has code."""

from __future__ import annotations

from symdyn.scene.joints.custom import CUSTOM
from symdyn.scene.joints.helical import HELICAL
from symdyn.scene.joints.joint_kind import JointKind
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
