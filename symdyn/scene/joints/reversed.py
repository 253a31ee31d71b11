"""Motions turned round: what takes the child back to the parent, in the same coordinates and velocities."""

from __future__ import annotations

from symdyn.scene.values.folding import neg
from symdyn.scene.values.model import Joint, Pose
from symdyn.scene.values.quantity import Vector


def inverse(pose: Pose) -> Pose:
    """Return the placement that undoes a placement."""
    return Pose(tuple((kind, neg(amount)) for kind, amount in reversed(pose.steps)))


def about_opposite(joint: Joint) -> Joint:
    """Return a joint about, or along, the opposite axis."""
    return joint.shaped(axis=opposite(joint.axis))


def opposite(axis: Vector) -> Vector:
    """Return the opposite axis."""
    return (neg(axis[0]), neg(axis[1]), neg(axis[2]))
