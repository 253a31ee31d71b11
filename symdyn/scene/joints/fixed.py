"""Fixed joint: a weld. Class t = 6."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.constraints import everywhere, forces, moments, turned
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return ()


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    axes = everywhere(X.p[0].graph)
    return forces(*axes) + moments(*axes)


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    return X.p + turned(X)


FIXED = JointKind(
    keys=(),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "fixed", "sk": "pevné"},
    mark=Mark((Part("square", 0.6),), sign="weld"),
    turned=lambda joint: joint,
)
