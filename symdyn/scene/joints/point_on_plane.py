"""Point on a plane: two translations across the axis, the plane's normal, and any rotation. Class t = 1."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import AXES, along, gimbals, orientation, slide
from symdyn.scene.joints.constraints import directions, forces, offsets
from symdyn.scene.joints.key import AXIS, ORIENTATION
from symdyn.scene.joints.kind import Block, Gimbal, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (*along(joint.axis, slide(AXES["x"]), slide(AXES["y"])), *orientation(ORIENTATION.of(joint)))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    return forces(directions(joint.axis, X.p[0].graph)[2])


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    return offsets(X, directions(joint.axis, X.p[0].graph)[2])


def _gimbals(joint: Joint) -> tuple[Gimbal, ...]:
    return gimbals(ORIENTATION.of(joint), 2)


POINT_ON_PLANE = JointKind(
    keys=(AXIS, ORIENTATION),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "point on a plane", "sk": "bod v rovine"},
    mark=Mark((Part("plate", 3.5), Part("ball", 1)), sign="slide"),
    gimbals=_gimbals,
)
