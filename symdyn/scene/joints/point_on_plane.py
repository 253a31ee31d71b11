"""Point on a plane: two translations across the axis, the plane's normal, and any rotation. Class t = 1."""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXES, AXIS, ORIENTATION, along, gimbals, orientation, slide
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.joint_kind import Block, JointKind
from symdyn.scene.joints.joint_mark import SLIDE, JointMark, MarkPart
from symdyn.scene.values.model import Joint


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (*along(joint.axis, slide(AXES["x"]), slide(AXES["y"])), *orientation(joint))


POINT_ON_PLANE = JointKind(
    keys=(AXIS, ORIENTATION),
    blocks=_blocks,
    forbids=forbidding("along"),
    words={"en": "point on a plane", "sk": "bod v rovine"},
    mark=JointMark((MarkPart("plate", 3.5), MarkPart("ball", 1)), sign=SLIDE),
    gimbals=gimbals(2),
)
