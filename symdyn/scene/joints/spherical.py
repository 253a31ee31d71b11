"""Spherical joint S: any rotation about a point. Class t = 3."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import gimbals, orientation
from symdyn.scene.joints.constraints import everywhere, forces
from symdyn.scene.joints.key import ORIENTATION
from symdyn.scene.joints.kind import Block, Gimbal, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return orientation(ORIENTATION.of(joint))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    return forces(*everywhere(X.p[0].graph))


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    return X.p


def _gimbals(joint: Joint) -> tuple[Gimbal, ...]:
    return gimbals(ORIENTATION.of(joint), 0)


SPHERICAL = JointKind(
    keys=(ORIENTATION,),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "spherical", "sk": "sférické"},
    mark=Mark((Part("socket"), Part("ball", 1))),
    ball=True,
    gimbals=_gimbals,
)
