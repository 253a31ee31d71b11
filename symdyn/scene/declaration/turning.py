"""Joints turned round: from child to parent, with the coordinates and velocities that they had.

pose of parent in child  =  tip⁻¹ · X(q)⁻¹ · origin⁻¹        X(q)⁻¹ is the same motion about the opposite axis
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.held_or_reversed import inverse
from symdyn.scene.values.model import Joint


def turnable(kind: str) -> bool:
    """Tell whether joints of a type can be turned round; a type that is none stands for a revolute joint."""
    return kind not in JOINTS or JOINTS[kind].turned is not None


def turned(joint: Joint) -> Joint:
    """Return a joint from its child to its parent, coordinates and velocities unchanged; its type must be turnable.

    Of one that is not, a fault of the scene by then, only the frames are swapped.
    """
    frames = replace(
        joint, parent=joint.child, child=joint.parent, origin=inverse(joint.tip), tip=inverse(joint.origin)
    )
    turn = JOINTS[joint.type].turned
    return turn(frames) if turn else frames
