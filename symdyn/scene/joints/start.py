"""Where a scene starts: position and velocities, zeros where it does not say, no rotation for a quaternion."""

from __future__ import annotations

from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import ONE, ZERO, Quantity


def starting_position(scene: Scene) -> tuple[Quantity, ...]:
    """Return the position at the start, shape (nq,); a guess of it where loops close; rad, m or 1."""
    return tuple(x for joint in scene.joints for x in joint.start or resting(joint))


def starting_velocity(scene: Scene) -> tuple[Quantity, ...]:
    """Return the velocities at the start, shape (nv,); rad/s or m/s."""
    return tuple(x for joint in scene.joints for x in joint.start_rates or (ZERO,) * len(joint.rates))


def resting(joint: Joint) -> tuple[Quantity, ...]:
    """Return the coordinates of a joint that does not say where it starts: zeros, and (1, 0, 0, 0) for a quaternion."""
    values = [ZERO] * len(joint.coordinates)
    first = quaternion(joint)
    if first is not None:
        values[first] = ONE
    return tuple(values)


def quaternion(joint: Joint) -> int | None:
    """Return which of the joint's coordinates is w of a quaternion (w, x, y, z), None if it has none."""
    units = JOINTS[joint.type].coordinates(joint) if joint.coordinates else ()
    return units.index("1") if "1" in units else None
