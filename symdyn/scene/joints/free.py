"""Free joint: six freedoms, no contact. Class t = 0."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import AXES, FLIGHT, orientation, slide
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    if joint.orientation == "quaternion":
        return (FLIGHT,)
    return (*(slide(AXES[letter]) for letter in "xyz"), *orientation(joint.orientation))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    return ()


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    return ()


FREE = JointKind(("orientation",), _blocks, _wrenches, _residual)
