"""Spherical joint S: any rotation about a point. Class t = 3."""

from __future__ import annotations

from symdyn.scene.joints.blocks import ORIENTATION, gimbals, orientation
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_mark import JointMark, MarkPart

SPHERICAL = JointKind(
    keys=(ORIENTATION,),
    blocks=orientation,
    forbids=forbidding("all"),
    words={"en": "spherical", "sk": "sférické"},
    mark=JointMark((MarkPart("socket"), MarkPart("ball", 1))),
    gimbals=gimbals(0),
)
