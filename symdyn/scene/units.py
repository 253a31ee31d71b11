"""The units of a scene's coordinates and velocities, "rad", "m" or "1" as the joints have them."""

from __future__ import annotations

from symdyn.scene.joints import JOINTS
from symdyn.scene.model import Scene


def coordinate_units(scene: Scene) -> tuple[str, ...]:
    """Return the unit of every coordinate, shape (nq,)."""
    return tuple(unit for joint in scene.moving for unit in JOINTS[joint.type].coordinates(joint))


def velocity_units(scene: Scene) -> tuple[str, ...]:
    """Return the unit of every velocity but for its second, shape (nv,): "rad" of rad/s."""
    return tuple(unit for joint in scene.moving for unit in JOINTS[joint.type].velocities(joint))
