"""Where a scene starts: position and velocities, zeros where it does not say, no rotation for a quaternion."""

from __future__ import annotations

from typing import NamedTuple

from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity


class Start(NamedTuple):
    """A state at the start.

    Attributes:
        position: shape (nq,), a guess of it where loops close; rad, m or 1.
        velocity: shape (nv,); rad/s or m/s.
    """

    position: tuple[Quantity, ...]
    velocity: tuple[Quantity, ...]


def start_of(scene: Scene) -> Start:
    """Return the state at the start."""
    return Start(
        tuple(x for joint in scene.joints for x in joint.start or resting(joint)),
        tuple(x for joint in scene.joints for x in joint.start_rates or (Quantity.ZERO,) * len(joint.rates)),
    )


def resting(joint: Joint) -> tuple[Quantity, ...]:
    """Return the coordinates of a joint that does not say where it starts: zeros, and (1, 0, 0, 0) for a quaternion."""
    values = [Quantity.ZERO] * len(joint.coordinates)
    first = JOINTS[joint.type].quaternion(joint)
    if first is not None:
        values[first] = Quantity.ONE
    return tuple(values)
