"""Cylindrical joint C: a rotation about the axis and a translation along it. Class t = 4."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import slide, turn
from symdyn.scene.joints.constraints import directions, forces, leaning, moments, offsets
from symdyn.scene.joints.key import AXIS
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.joints.turned import about_opposite
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (turn(joint.axis), slide(joint.axis))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    x, y, _ = directions(joint.axis, X.p[0].graph)
    return forces(x, y) + moments(x, y)


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    x, y, axis = directions(joint.axis, X.p[0].graph)
    return offsets(X, x, y) + leaning(X, axis, x, y)


CYLINDRICAL = JointKind(
    keys=(AXIS,),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "cylindrical", "sk": "valcové"},
    mark=Mark((Part("rail"), Part("cylinder", 2))),
    turned=about_opposite,
)
