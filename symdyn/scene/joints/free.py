"""Free joint: six freedoms, no contact. Class t = 0."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import AXES, FLIGHT, gimbals, orientation, slide
from symdyn.scene.joints.key import ORIENTATION
from symdyn.scene.joints.kind import Block, Gimbal, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    if ORIENTATION.of(joint) == "quaternion":
        return (FLIGHT,)
    return (*(slide(AXES[letter]) for letter in "xyz"), *orientation(ORIENTATION.of(joint)))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    return ()


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    return ()


def _gimbals(joint: Joint) -> tuple[Gimbal, ...]:
    return gimbals(ORIENTATION.of(joint), 3)


FREE = JointKind(
    keys=(ORIENTATION,),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "free", "sk": "voľné"},
    mark=Mark((Part("flight"), Part("frames", 3)), sign=""),
    gimbals=_gimbals,
)
