"""Prismatic joint P: one translation along the axis. Class t = 5."""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXIS, slide
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.held import shifted_by
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_mark import SLIDE, JointMark, MarkPart
from symdyn.scene.joints.reversed import about_opposite

PRISMATIC = JointKind(
    keys=(AXIS,),
    blocks=lambda joint: (slide(joint.axis),),
    forbids=forbidding("across", "all"),
    words={"en": "prismatic (P)", "sk": "posuvné (P)"},
    mark=JointMark(
        (MarkPart("rail"), MarkPart("arrow", 4), MarkPart("box", 1.7)),
        flat=(MarkPart("rail"), MarkPart("slider", 2)),
        sign=SLIDE,
    ),
    turned=about_opposite,
    held=shifted_by,
)
