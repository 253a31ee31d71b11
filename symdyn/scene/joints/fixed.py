"""Fixed joint: a weld. Class t = 6."""

from __future__ import annotations

from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_mark import WELD, JointMark, MarkPart

FIXED = JointKind(
    keys=(),
    blocks=lambda joint: (),
    forbids=forbidding("all", "all"),
    words={"en": "fixed", "sk": "pevné"},
    mark=JointMark((MarkPart("square", 0.6),), sign=WELD),
    turned=lambda joint: joint,
)
