"""Revolute joint R: one rotation about the axis. Class t = 5."""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXIS, turn
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.held import turned_by
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_mark import JointMark, MarkPart
from symdyn.scene.joints.reversed import about_opposite

REVOLUTE = JointKind(
    keys=(AXIS,),
    blocks=lambda joint: (turn(joint.axis),),
    forbids=forbidding("all", "across"),
    words={"en": "revolute (R)", "sk": "rotačné (R)"},
    mark=JointMark((MarkPart("line", 2.4), MarkPart("cylinder", 1.3)), flat=(MarkPart("ring"),)),
    turned=about_opposite,
    held=turned_by,
)
