"""Joints of several steps with a dimension of their own: screws, universal joints, massless rods.

Helical joint H: a rotation about the axis with an advance along it of a pitch a turn. Class t = 5. What a nut exerts on
its screw without working: a force f along the axis goes with the moment -(pitch / 2π) f.

Universal (Cardan) joint U: a rotation about the axis, then one about a second axis that it turns. Class t = 4.

Massless rod of constant length between two points. Class t = 1. In a tree the rod is along z of the joint frame, turned
about its x and then about its y; the child turns about the far end. Two angles describe no rod that lies along x: there
the description is singular, not the mechanism.
"""

from __future__ import annotations

import math
from dataclasses import replace

from symdyn.graph import Expr, Graph, Op
from symdyn.scene.joints.blocks import (
    AXES,
    AXIS,
    ORIENTATION,
    Steps,
    about_opposite,
    directions,
    forces,
    gimbals,
    held,
    leaning,
    moments,
    offsets,
    opposite,
    orientation,
    screw,
    shift,
    turn,
    unit,
)
from symdyn.scene.joints.joint_kind import LINE, Forbids, Gimbal, JointBlock, JointKind, JointMark, MarkPart
from symdyn.scene.values import folding
from symdyn.scene.values.entry import EntryReader, shorten
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key, number
from symdyn.scene.values.quantity import FormulaError, Quantity, Vector, spell
from symdyn.spatial import Mat, Transform, Wrench, cross, dot, scale

PITCH = number(
    "pitch",
    "m",
    example="pitch = 0.01, the advance a turn in metres",
    letters=("h",),
    text="advance a turn of {}",
    positive=True,
    geometry=True,
)


def _rise(joint: Joint, graph: Graph) -> Expr:
    """Return the advance per radian, m."""
    return PITCH.of(joint).express(graph) / (2 * graph.pi)


def _screw_wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    x, y, axis = directions(joint.axis, graph)
    return forces(x, y) + moments(x, y) + (Wrench(axis, scale(-_rise(joint, graph), axis)),)


def _screw_residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    graph = X.p[0].graph
    x, y, axis = directions(joint.axis, graph)
    turned = X.R @ x
    angle = graph.function(Op.ATAN2, dot(y, turned), dot(x, turned))
    return (*offsets(X, x, y), *leaning(X, axis, x, y), dot(axis, X.p) - _rise(joint, graph) * angle)


def _screw_held(joint: Joint, angle: Quantity) -> Steps:
    turn = folding.mul(Quantity.number(2), Quantity.PI)
    return held(joint, angle, lambda x: (("R", x), ("T", folding.mul(PITCH.of(joint), folding.div(x, turn)))))


HELICAL = JointKind(
    keys=(AXIS, PITCH),
    blocks=lambda joint: (screw(joint.axis, PITCH.of(joint)),),
    forbids=Forbids(_screw_wrenches, _screw_residual),
    words={"en": "helical", "sk": "skrutkové"},
    mark=JointMark((MarkPart("rail"), MarkPart("cylinder", 2), MarkPart("thread"))),
    turned=about_opposite,
    held=_screw_held,
)


SECOND: Key[Vector] = Key(
    "second_axis",
    EntryReader.vector,
    (Quantity.ONE, Quantity.ZERO, Quantity.ZERO),
    names=None,
    turned=True,
    holds="in the frame that the first rotation has turned",
)

ROUNDING = 1e-12
"""Sine of an angle between directions that are parallel."""


def _cardan_wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    first, second = unit(joint.axis, graph), X.R @ unit(SECOND.of(joint), graph)
    return forces(*Mat.identity(graph)) + moments(cross(second, first))


def _cardan_residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    graph = X.p[0].graph
    first, second = unit(joint.axis, graph), unit(SECOND.of(joint), graph)
    return (*X.p, dot(first, X.R @ second) - dot(first, second))


def _cardan_turned(joint: Joint) -> Joint:
    return replace(
        joint.shaped(axis=opposite(SECOND.of(joint)), second_axis=opposite(joint.axis)),
        coordinates=joint.coordinates[::-1],
        drives=joint.drives[::-1],
        forces=joint.forces[::-1],
        start=joint.start[::-1],
        start_rates=joint.start_rates[::-1],
    )


def _cardan_amiss(joint: Joint) -> str:
    try:
        a, b = ([float(x.at({}) or 0) for x in key.of(joint)] for key in (AXIS, SECOND))
    except FormulaError:
        return ""  # reported as a formula without a value
    across = [a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))]
    if math.hypot(*across) > ROUNDING * math.hypot(*a) * math.hypot(*b):
        return ""
    text = f"second_axis = [{', '.join(shorten(spell(x)) for x in SECOND.of(joint))}]"
    return f"{text} is parallel to axis; give one across it, such as [1, 0, 0] for axis = [0, 0, 1]"


UNIVERSAL = JointKind(
    keys=(AXIS, SECOND),
    blocks=lambda joint: (turn(joint.axis), turn(SECOND.of(joint))),
    forbids=Forbids(_cardan_wrenches, _cardan_residual),
    words={"en": "universal", "sk": "kardanové"},
    mark=JointMark((MarkPart("arm", 1.7), MarkPart("arm", 1.7, SECOND.name))),
    turned=_cardan_turned,
    fault=_cardan_amiss,
)


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


def _rod(joint: Joint) -> tuple[JointBlock, ...]:
    rod = (turn(AXES["x"]), turn(AXES["y"]), shift(AXES["z"], LENGTH.of(joint)))
    return (*rod, *orientation(joint))


def _rod_wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    length = LENGTH.of(joint).express(X.p[0].graph)
    return forces(scale(1 / length, X.p))


def _rod_residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    length = LENGTH.of(joint).express(X.p[0].graph)
    return ((dot(X.p, X.p) / length - length) / 2,)


def _rod_gimbals(joint: Joint) -> tuple[Gimbal, ...]:
    lies = "the rod lies along the axis of {0}, so that its angles are singular"
    return (Gimbal(0, "xy", lies, "turn its joint frame by origin"), *gimbals(2)(joint))


ROD = JointKind(
    keys=(LENGTH, ORIENTATION),
    blocks=_rod,
    forbids=Forbids(_rod_wrenches, _rod_residual),
    words={"en": "rod between two points", "sk": "tyč medzi dvoma bodmi"},
    mark=JointMark((MarkPart("rod", 0.7),), sign=LINE),
    held=lambda joint, position: (("Tz", LENGTH.of(joint)),),
    gimbals=_rod_gimbals,
)
