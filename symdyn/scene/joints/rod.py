"""Massless rod of constant length between two points. Class t = 1.

In a tree the rod is along z of the joint frame, turned about its x and then about its y; the child turns about the far
end. Two angles describe no rod that lies along x: there the description is singular, not the mechanism.
"""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import AXES, ORIENTATION, Steps, forces, gimbals, orientation, shift, turn
from symdyn.scene.joints.joint_kind import LINE, Forbids, Gimbal, JointBlock, JointKind, JointMark, MarkPart
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import number
from symdyn.scene.values.quantity import Quantity
from symdyn.spatial import Transform, Wrench, dot, scale

LENGTH = number(
    "length",
    "m",
    example="length = 0.5, the distance of its ends in metres",
    above_zero="is that of no rod; give the distance of its ends, or write a spherical joint",
    letters=("l",),
    text="length of {}",
    positive=True,
    geometry=True,
)


def _blocks(joint: Joint) -> tuple[JointBlock, ...]:
    rod = (turn(AXES["x"]), turn(AXES["y"]), shift(AXES["z"], LENGTH.of(joint)))
    return (*rod, *orientation(joint))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    length = LENGTH.of(joint).express(X.p[0].graph)
    return forces(scale(1 / length, X.p))


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    length = LENGTH.of(joint).express(X.p[0].graph)
    return ((dot(X.p, X.p) / length - length) / 2,)


def _held(joint: Joint, position: Quantity) -> Steps:
    return (("Tz", LENGTH.of(joint)),)


def _gimbals(joint: Joint) -> tuple[Gimbal, ...]:
    lies = "the rod lies along the axis of {0}, so that its angles are singular"
    return (Gimbal(0, "xy", lies, "turn its joint frame by origin"), *gimbals(2)(joint))


ROD = JointKind(
    keys=(LENGTH, ORIENTATION),
    blocks=_blocks,
    forbids=Forbids(_wrenches, _residual),
    words={"en": "rod between two points", "sk": "tyč medzi dvoma bodmi"},
    mark=JointMark((MarkPart("rod", 0.7),), sign=LINE),
    held=_held,
    gimbals=_gimbals,
)
