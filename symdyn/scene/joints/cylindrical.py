"""Cylindrical joint C: a rotation about the axis and a translation along it. Class t = 4."""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXIS, slide, turn
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_mark import JointMark, MarkPart
from symdyn.scene.joints.reversed import about_opposite

CYLINDRICAL = JointKind(
    keys=(AXIS,),
    blocks=lambda joint: (turn(joint.axis), slide(joint.axis)),
    forbids=forbidding("across", "across"),
    words={"en": "cylindrical", "sk": "valcové"},
    mark=JointMark((MarkPart("rail"), MarkPart("cylinder", 2))),
    turned=about_opposite,
)
