"""Massless rod of constant length between two points. Class t = 1.

In a tree the rod is along z of the joint frame, turned about its x and then about its y; the child turns about the far
end. Two angles describe no rod that lies along x: there the description is singular, not the mechanism.
"""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import AXES, orientation, shift, turn
from symdyn.scene.joints.constraints import forces
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.model import Joint
from symdyn.scene.quantity import express
from symdyn.spatial import Transform, dot, scale


def _blocks(joint: Joint) -> tuple[Block, ...]:
    rod = (turn(AXES["x"]), turn(AXES["y"]), shift(AXES["z"], joint.length))
    return (*rod, *orientation(joint.orientation))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    length = express(joint.length, X.p[0].graph)
    return forces(scale(1 / length, X.p))


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    length = express(joint.length, X.p[0].graph)
    return ((dot(X.p, X.p) / length - length) / 2,)


ROD = JointKind(("length", "orientation"), _blocks, _wrenches, _residual)
