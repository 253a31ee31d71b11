"""Helical joint H: a rotation about the axis with an advance along it of a pitch a turn. Class t = 5.

What a nut exerts on its screw without working: a force f along the axis goes with the moment -(pitch / 2π) f.
"""

from __future__ import annotations

from symdyn.graph import Expr, Graph, Op
from symdyn.scene.joints.blocks import (
    AXIS,
    Steps,
    about_opposite,
    directions,
    forces,
    held,
    leaning,
    moments,
    offsets,
    screw,
)
from symdyn.scene.joints.joint_kind import Forbids, JointBlock, JointKind, JointMark, MarkPart
from symdyn.scene.values import folding
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import number
from symdyn.scene.values.quantity import Quantity
from symdyn.spatial import Transform, Wrench, dot, scale

PITCH = number(
    "pitch",
    "m",
    example="pitch = 0.01, the advance a turn in metres",
    letters=("h",),
    text="advance a turn of {}",
    positive=True,
    geometry=True,
)


def _blocks(joint: Joint) -> tuple[JointBlock, ...]:
    return (screw(joint.axis, PITCH.of(joint)),)


def _rise(joint: Joint, graph: Graph) -> Expr:
    """Return the advance per radian, m."""
    return PITCH.of(joint).express(graph) / (2 * graph.pi)


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    x, y, axis = directions(joint.axis, graph)
    return forces(x, y) + moments(x, y) + (Wrench(axis, scale(-_rise(joint, graph), axis)),)


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    graph = X.p[0].graph
    x, y, axis = directions(joint.axis, graph)
    turned = X.R @ x
    angle = graph.function(Op.ATAN2, dot(y, turned), dot(x, turned))
    return (*offsets(X, x, y), *leaning(X, axis, x, y), dot(axis, X.p) - _rise(joint, graph) * angle)


def _held(joint: Joint, angle: Quantity) -> Steps:
    turn = folding.mul(Quantity.number(2), Quantity.PI)
    return held(joint, angle, lambda x: (("R", x), ("T", folding.mul(PITCH.of(joint), folding.div(x, turn)))))


HELICAL = JointKind(
    keys=(AXIS, PITCH),
    blocks=_blocks,
    forbids=Forbids(_wrenches, _residual),
    words={"en": "helical", "sk": "skrutkové"},
    mark=JointMark((MarkPart("rail"), MarkPart("cylinder", 2), MarkPart("thread"))),
    turned=about_opposite,
    held=_held,
)
