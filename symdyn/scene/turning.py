"""Joints turned round: from child to parent, with the coordinates and velocities that they had.

pose of parent in child  =  tip⁻¹ · X(q)⁻¹ · origin⁻¹        X(q)⁻¹ is the same motion about the opposite axis
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.scene.folding import neg
from symdyn.scene.model import Joint, Pose
from symdyn.scene.quantity import Vector

TURNED = ("fixed", "revolute", "prismatic", "helical", "cylindrical", "universal", "custom")
"""Types that can be turned round; the velocities of a ball and the like are measured in the child."""


def turned(joint: Joint) -> Joint:
    """Return a joint from its child to its parent, coordinates and velocities unchanged."""
    joint = replace(joint, parent=joint.child, child=joint.parent, origin=inverse(joint.tip), tip=inverse(joint.origin))
    if joint.type == "custom":
        return replace(joint, steps=inverse(joint.steps))
    if joint.type != "universal":
        return replace(joint, axis=_opposite(joint.axis))
    return replace(
        joint,
        axis=_opposite(joint.second_axis),
        second_axis=_opposite(joint.axis),
        coordinates=joint.coordinates[::-1],
        drives=joint.drives[::-1],
        forces=joint.forces[::-1],
        start=joint.start[::-1],
        start_rates=joint.start_rates[::-1],
    )


def inverse(pose: Pose) -> Pose:
    """Return the placement that undoes a placement."""
    return Pose(tuple((kind, neg(amount)) for kind, amount in reversed(pose.steps)))


def _opposite(axis: Vector) -> Vector:
    return (neg(axis[0]), neg(axis[1]), neg(axis[2]))
