"""Point on a line: a translation along the axis and any rotation. Class t = 2."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import gimbals, orientation, slide
from symdyn.scene.joints.constraints import directions, forces, offsets
from symdyn.scene.joints.key import AXIS, ORIENTATION
from symdyn.scene.joints.kind import Block, Gimbal, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (slide(joint.axis), *orientation(ORIENTATION.of(joint)))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    x, y, _ = directions(joint.axis, X.p[0].graph)
    return forces(x, y)


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    x, y, _ = directions(joint.axis, X.p[0].graph)
    return offsets(X, x, y)


def _gimbals(joint: Joint) -> tuple[Gimbal, ...]:
    return gimbals(ORIENTATION.of(joint), 1)


POINT_ON_LINE = JointKind(
    keys=(AXIS, ORIENTATION),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "point on a line", "sk": "bod na priamke"},
    mark=Mark((Part("rail"), Part("ball", 1)), sign="slide"),
    gimbals=_gimbals,
)
