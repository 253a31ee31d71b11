"""Point on a line: a translation along the axis and any rotation. Class t = 2."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import orientation, slide
from symdyn.scene.joints.constraints import directions, forces, offsets
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (slide(joint.axis), *orientation(joint.orientation))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    x, y, _ = directions(joint.axis, X.p[0].graph)
    return forces(x, y)


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    x, y, _ = directions(joint.axis, X.p[0].graph)
    return offsets(X, x, y)


POINT_ON_LINE = JointKind(("axis", "orientation"), _blocks, _wrenches, _residual)
