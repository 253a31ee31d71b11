"""Custom joint: elementary motions whose amounts are formulas in its own coordinates. Class t = 6 - coordinates.

A cam, a screw with a varying pitch, a knee: the motion subspace is what the formulas' derivatives make it. It carries a
body of the tree; it closes no loop, since what it forbids has no closed form.
"""

from __future__ import annotations

from symdyn.scene.joints.blocks import path
from symdyn.scene.joints.held_or_reversed import inverse
from symdyn.scene.joints.joint_kind import JointBlock, JointKind
from symdyn.scene.joints.joint_mark import JointMark, MarkPart
from symdyn.scene.values.body import Pose
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key
from symdyn.scene.values.shapes import PLACEMENT, choice_of, several
from symdyn.scene.values.table import Table, as_list, plain, show


def _units(table: Table, name: str, default: tuple[str, ...]) -> tuple[str, ...]:
    if name in table:
        raw = plain(table.raw[name])
        if isinstance(raw, (list, tuple)) and 1 <= len(raw) <= 6 and all(unit in ("rad", "m") for unit in raw):
            return tuple(raw)
        table.fault(f'{name} = {show(raw)} is not a list of one to six "rad" and "m"; write one for each coordinate')
    return default * (len(as_list(table.raw.get("coordinates"))) or 1)


STEPS = Key(
    "steps",
    lambda table, name, default: table.pose(name),
    Pose(),
    example='the motion as steps such as [["Rz", "u"], ["Tx", "0.1*u"]]',
    shape=PLACEMENT,
)

UNITS: Key[tuple[str, ...]] = Key(
    "units",
    _units,
    ("rad",),
    example='"rad" or "m" for each coordinate, such as units = ["rad"]',
    shape=several(choice_of("rad", "m"), 1, 6),
)


def _blocks(joint: Joint) -> tuple[JointBlock, ...]:
    return (path(STEPS.of(joint), joint.coordinates, UNITS.of(joint)),)


def _turned(joint: Joint) -> Joint:
    return joint.shaped(steps=inverse(STEPS.of(joint)))


CUSTOM = JointKind(
    keys=(STEPS, UNITS),
    blocks=_blocks,
    forbids=None,
    words={"en": "given by formulas", "sk": "dané vzorcami"},
    mark=JointMark((MarkPart("flight"), MarkPart("diamond", 1.35))),
    turned=_turned,
    held=lambda joint, position: STEPS.of(joint).steps,
)
