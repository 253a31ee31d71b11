"""Spherical joint S: any rotation about a point. Class t = 3."""

from __future__ import annotations

from symdyn.scene.joints.blocks import gimbals, orientation
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.joint_key import ORIENTATION
from symdyn.scene.joints.joint_mark import JointMark, MarkPart
from symdyn.scene.joints.kind import JointKind

SPHERICAL = JointKind(
    keys=(ORIENTATION,),
    blocks=orientation,
    forbids=forbidding("all"),
    words={"en": "spherical", "sk": "sférické"},
    mark=JointMark((MarkPart("socket"), MarkPart("ball", 1))),
    ball=True,
    gimbals=gimbals(0),
)
