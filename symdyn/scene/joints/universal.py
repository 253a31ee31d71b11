"""Universal (Cardan) joint U: a rotation about the axis, then one about a second axis that it turns. Class t = 4."""

from __future__ import annotations

import math
from dataclasses import replace

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import AXIS, forces, moments, opposite, turn, unit
from symdyn.scene.joints.joint_kind import Forbids, JointBlock, JointKind, JointMark, MarkPart
from symdyn.scene.values.entry import EntryReader, shorten
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key
from symdyn.scene.values.quantity import FormulaError, Quantity, Vector, spell
from symdyn.spatial import Mat, Transform, Wrench, cross, dot

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


def _blocks(joint: Joint) -> tuple[JointBlock, ...]:
    return (turn(joint.axis), turn(SECOND.of(joint)))


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    first, second = unit(joint.axis, graph), X.R @ unit(SECOND.of(joint), graph)
    return forces(*Mat.identity(graph)) + moments(cross(second, first))


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    graph = X.p[0].graph
    first, second = unit(joint.axis, graph), unit(SECOND.of(joint), graph)
    return (*X.p, dot(first, X.R @ second) - dot(first, second))


def _turned(joint: Joint) -> Joint:
    return replace(
        joint.shaped(axis=opposite(SECOND.of(joint)), second_axis=opposite(joint.axis)),
        coordinates=joint.coordinates[::-1],
        drives=joint.drives[::-1],
        forces=joint.forces[::-1],
        start=joint.start[::-1],
        start_rates=joint.start_rates[::-1],
    )


def _amiss(joint: Joint) -> str:
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
    blocks=_blocks,
    forbids=Forbids(_wrenches, _residual),
    words={"en": "universal", "sk": "kardanové"},
    mark=JointMark((MarkPart("arm", 1.7), MarkPart("arm", 1.7, SECOND.name))),
    turned=_turned,
    fault=_amiss,
)
