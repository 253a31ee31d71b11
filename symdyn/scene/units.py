"""The units of a scene's coordinates and velocities, "rad", "m" or "1" as the joints have them."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.scene.joints import JOINTS
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.model import Scene


def coordinate_units(scene: Scene) -> tuple[str, ...]:
    """Return the unit of every coordinate, shape (nq,)."""
    return tuple(unit for joint in scene.moving for unit in JOINTS[joint.type].coordinates(joint))


def velocity_units(scene: Scene) -> tuple[str, ...]:
    """Return the unit of every velocity but for its second, shape (nv,): "rad" of rad/s."""
    return tuple(unit for joint in scene.moving for unit in JOINTS[joint.type].velocities(joint))


def coordinates_with_units(scene: Scene) -> Iterator[tuple[Joint, str, str]]:
    """Yield every coordinate, in order, with its joint and its unit."""
    for joint in scene.moving:
        yield from (
            (joint, q, unit) for q, unit in zip(joint.coordinates, JOINTS[joint.type].coordinates(joint), strict=True)
        )


def drives_with_units(scene: Scene) -> Iterator[tuple[Joint, str, str]]:
    """Yield every drive, in order, with its joint and its unit, "N m" or "N"."""
    for joint in scene.moving:
        for drive, unit in zip(joint.drives, JOINTS[joint.type].velocities(joint), strict=False):
            if drive:
                yield joint, drive, "N m" if unit == "rad" else "N"
