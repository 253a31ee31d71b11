"""Universal (Cardan) joint U: a rotation about the axis, then one about a second axis that it turns. Class t = 4."""

from __future__ import annotations

from dataclasses import replace

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import turn, unit
from symdyn.scene.joints.constraints import everywhere, forces, moments
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.joints.turned import opposite
from symdyn.scene.model import Joint
from symdyn.spatial import Transform, apply, cross, dot


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (turn(joint.axis), turn(joint.second_axis))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    first, second = unit(joint.axis, graph), apply(X.R, unit(joint.second_axis, graph))
    return forces(*everywhere(graph)) + moments(cross(second, first))


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    graph = X.p[0].graph
    first, second = unit(joint.axis, graph), unit(joint.second_axis, graph)
    return (*X.p, dot(first, apply(X.R, second)) - dot(first, second))


def _turned(joint: Joint) -> Joint:
    return replace(
        joint,
        axis=opposite(joint.second_axis),
        second_axis=opposite(joint.axis),
        coordinates=joint.coordinates[::-1],
        drives=joint.drives[::-1],
        forces=joint.forces[::-1],
        start=joint.start[::-1],
        start_rates=joint.start_rates[::-1],
    )


UNIVERSAL = JointKind(("axis", "second_axis"), _blocks, _wrenches, _residual, _turned)
