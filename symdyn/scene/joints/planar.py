"""Planar joint E: two translations across the axis and a rotation about it. Class t = 3.

The translations are along the x and y that the shortest rotation of z to the axis gives.
"""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import AXES, along, slide, turn
from symdyn.scene.joints.constraints import directions, forces, leaning, moments, offsets
from symdyn.scene.joints.key import AXIS
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return along(joint.axis, slide(AXES["x"]), slide(AXES["y"]), turn(AXES["z"]))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    x, y, axis = directions(joint.axis, X.p[0].graph)
    return forces(axis) + moments(x, y)


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    x, y, axis = directions(joint.axis, X.p[0].graph)
    return offsets(X, axis) + leaning(X, axis, x, y)


PLANAR = JointKind(
    keys=(AXIS,),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "planar", "sk": "rovinné"},
    mark=Mark((Part("plate", 3.5), Part("cylinder", 0.6)), flat=(Part("plate", 3), Part("ring"))),
)
