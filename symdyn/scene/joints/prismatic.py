"""Prismatic joint P: one translation along the axis. Class t = 5."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import slide
from symdyn.scene.joints.constraints import directions, everywhere, forces, moments, offsets, turned
from symdyn.scene.joints.held import shifted_by
from symdyn.scene.joints.key import AXIS
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.joints.turned import about_opposite
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (slide(joint.axis),)


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    x, y, _ = directions(joint.axis, graph)
    return forces(x, y) + moments(*everywhere(graph))


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    x, y, _ = directions(joint.axis, X.p[0].graph)
    return offsets(X, x, y) + turned(X)


PRISMATIC = JointKind(
    keys=(AXIS,),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "prismatic (P)", "sk": "posuvné (P)"},
    mark=Mark((Part("rail"), Part("arrow", 4), Part("box", 1.7)), flat=(Part("rail"), Part("slider", 2)), sign="slide"),
    turned=about_opposite,
    held=shifted_by,
)
