"""Joints at a fixed position, as elementary steps, and motions turned round: what takes the child back to the parent.

Steps are along or about a coordinate axis, between two turns if the axis is oblique. Turned round, a joint has the same
coordinates and velocities.
"""

from __future__ import annotations

from collections.abc import Callable

from symdyn.scene.values import turns
from symdyn.scene.values.body import Pose
from symdyn.scene.values.folding import neg
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.quantity import Quantity, Vector
from symdyn.scene.values.turns import Step, towards

Steps = tuple[Step, ...]


def held(joint: Joint, position: Quantity, motion: Callable[[Quantity], Steps]) -> Steps:
    """Return what a joint does at a position along or about its axis; () at zero.

    Args:
        joint: one with an axis.
        position: rad or m.
        motion: steps "R" about and "T" along the axis, of a position in the sense of the axis.
    """
    if position == Quantity.ZERO:
        return ()
    along = [(k, value) for k, x in enumerate(joint.axis) if (value := x.at({})) != 0]
    there: Steps = ()
    if len(along) == 1:
        ((k, value),) = along
        position = position if value is not None and value > 0 else neg(position)
    else:
        k, there = 2, towards(joint.axis)
    return (*there, *((kind + "xyz"[k], amount) for kind, amount in motion(position)), *turns.inverse(there))


def turned_by(joint: Joint, angle: Quantity) -> Steps:
    """Return a turn about the axis, rad."""
    return held(joint, angle, lambda x: (("R", x),))


def shifted_by(joint: Joint, way: Quantity) -> Steps:
    """Return a shift along the axis, m."""
    return held(joint, way, lambda x: (("T", x),))


def inverse(pose: Pose) -> Pose:
    """Return the placement that undoes a placement."""
    return Pose(turns.inverse(pose.steps))


def about_opposite(joint: Joint) -> Joint:
    """Return a joint about, or along, the opposite axis."""
    return joint.shaped(axis=opposite(joint.axis))


def opposite(axis: Vector) -> Vector:
    """Return the opposite axis."""
    return (neg(axis[0]), neg(axis[1]), neg(axis[2]))
