"""Planar joint E: two translations across the axis and a rotation about it. Class t = 3.

The translations are along the x and y that the shortest rotation of z to the axis gives.
"""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXES, AXIS, along, slide, turn
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_mark import JointMark, MarkPart

PLANAR = JointKind(
    keys=(AXIS,),
    blocks=lambda joint: along(joint.axis, slide(AXES["x"]), slide(AXES["y"]), turn(AXES["z"])),
    forbids=forbidding("along", "across"),
    words={"en": "planar", "sk": "rovinné"},
    mark=JointMark((MarkPart("plate", 3.5), MarkPart("cylinder", 0.6)), flat=(MarkPart("plate", 3), MarkPart("ring"))),
)
