"""Revolute joint R: one rotation about the axis. Class t = 5."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import turn
from symdyn.scene.joints.constraints import directions, everywhere, forces, leaning, moments, offsets
from symdyn.scene.joints.held import turned_by
from symdyn.scene.joints.key import AXIS
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.joints.mark import Mark, Part
from symdyn.scene.joints.turned import about_opposite
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (turn(joint.axis),)


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    x, y, _ = directions(joint.axis, graph)
    return forces(*everywhere(graph)) + moments(x, y)


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    graph = X.p[0].graph
    x, y, axis = directions(joint.axis, graph)
    return offsets(X, *everywhere(graph)) + leaning(X, axis, x, y)


REVOLUTE = JointKind(
    keys=(AXIS,),
    blocks=_blocks,
    wrenches=_wrenches,
    residual=_residual,
    words={"en": "revolute (R)", "sk": "rotačné (R)"},
    mark=Mark((Part("line", 2.4), Part("cylinder", 1.3)), flat=(Part("ring"),)),
    turned=about_opposite,
    held=turned_by,
)
