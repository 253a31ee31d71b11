"""Point on a line: a translation along the axis and any rotation. Class t = 2."""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXIS, ORIENTATION, gimbals, orientation, slide
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_mark import SLIDE, JointMark, MarkPart

POINT_ON_LINE = JointKind(
    keys=(AXIS, ORIENTATION),
    blocks=lambda joint: (slide(joint.axis), *orientation(joint)),
    forbids=forbidding("across"),
    words={"en": "point on a line", "sk": "bod na priamke"},
    mark=JointMark((MarkPart("rail"), MarkPart("ball", 1)), sign=SLIDE),
    gimbals=gimbals(1),
)
