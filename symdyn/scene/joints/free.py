"""Free joint: six freedoms, no contact. Class t = 0."""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXES, FLIGHT, ORIENTATION, gimbals, orientation, slide
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.joint_kind import Block, JointKind
from symdyn.scene.joints.joint_mark import JointMark, MarkPart, PageSign
from symdyn.scene.values.model import Joint


def _blocks(joint: Joint) -> tuple[Block, ...]:
    if ORIENTATION.of(joint) == "quaternion":
        return (FLIGHT,)
    return (*(slide(AXES[letter]) for letter in "xyz"), *orientation(joint))


FREE = JointKind(
    keys=(ORIENTATION,),
    blocks=_blocks,
    forbids=forbidding("none"),
    words={"en": "free", "sk": "voľné"},
    mark=JointMark((MarkPart("flight"), MarkPart("frames", 3)), sign=PageSign()),
    gimbals=gimbals(3),
)
