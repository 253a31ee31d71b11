"""Joint types that are parts put together and forbid by words: lower pairs, points on lines and planes, no contact."""

from __future__ import annotations

from symdyn.scene.joints.blocks import AXES, AXIS, FLIGHT, ORIENTATION, along, gimbals, orientation, slide, turn
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.held_or_reversed import about_opposite, shifted_by, turned_by
from symdyn.scene.joints.joint_kind import JointBlock, JointKind
from symdyn.scene.joints.joint_mark import SLIDE, WELD, JointMark, MarkPart, PageSign
from symdyn.scene.values.joint import Joint

REVOLUTE = JointKind(
    keys=(AXIS,),
    blocks=lambda joint: (turn(joint.axis),),
    forbids=forbidding("all", "across"),
    words={"en": "revolute (R)", "sk": "rotačné (R)"},
    mark=JointMark((MarkPart("line", 2.4), MarkPart("cylinder", 1.3)), flat=(MarkPart("ring"),)),
    turned=about_opposite,
    held=turned_by,
)
"""Revolute joint R: one rotation about the axis. Class t = 5."""

PRISMATIC = JointKind(
    keys=(AXIS,),
    blocks=lambda joint: (slide(joint.axis),),
    forbids=forbidding("across", "all"),
    words={"en": "prismatic (P)", "sk": "posuvné (P)"},
    mark=JointMark(
        (MarkPart("rail"), MarkPart("arrow", 4), MarkPart("box", 1.7)),
        flat=(MarkPart("rail"), MarkPart("slider", 2)),
        sign=SLIDE,
    ),
    turned=about_opposite,
    held=shifted_by,
)
"""Prismatic joint P: one translation along the axis. Class t = 5."""

FIXED = JointKind(
    keys=(),
    blocks=lambda joint: (),
    forbids=forbidding("all", "all"),
    words={"en": "fixed", "sk": "pevné"},
    mark=JointMark((MarkPart("square", 0.6),), sign=WELD),
    turned=lambda joint: joint,
)
"""Fixed joint: a weld. Class t = 6."""

CYLINDRICAL = JointKind(
    keys=(AXIS,),
    blocks=lambda joint: (turn(joint.axis), slide(joint.axis)),
    forbids=forbidding("across", "across"),
    words={"en": "cylindrical", "sk": "valcové"},
    mark=JointMark((MarkPart("rail"), MarkPart("cylinder", 2))),
    turned=about_opposite,
)
"""Cylindrical joint C: a rotation about the axis and a translation along it. Class t = 4."""

SPHERICAL = JointKind(
    keys=(ORIENTATION,),
    blocks=orientation,
    forbids=forbidding("all"),
    words={"en": "spherical", "sk": "sférické"},
    mark=JointMark((MarkPart("socket"), MarkPart("ball", 1))),
    gimbals=gimbals(0),
)
"""Spherical joint S: any rotation about a point. Class t = 3."""

PLANAR = JointKind(
    keys=(AXIS,),
    blocks=lambda joint: along(joint.axis, slide(AXES["x"]), slide(AXES["y"]), turn(AXES["z"])),
    forbids=forbidding("along", "across"),
    words={"en": "planar", "sk": "rovinné"},
    mark=JointMark((MarkPart("plate", 3.5), MarkPart("cylinder", 0.6)), flat=(MarkPart("plate", 3), MarkPart("ring"))),
)
"""Planar joint E: two translations across the axis and a rotation about it. Class t = 3.

The translations are along the x and y that the shortest rotation of z to the axis gives."""

POINT_ON_LINE = JointKind(
    keys=(AXIS, ORIENTATION),
    blocks=lambda joint: (slide(joint.axis), *orientation(joint)),
    forbids=forbidding("across"),
    words={"en": "point on a line", "sk": "bod na priamke"},
    mark=JointMark((MarkPart("rail"), MarkPart("ball", 1)), sign=SLIDE),
    gimbals=gimbals(1),
)
"""Point on a line: a translation along the axis and any rotation. Class t = 2."""


def _point_on_plane_parts(joint: Joint) -> tuple[JointBlock, ...]:
    return (*along(joint.axis, slide(AXES["x"]), slide(AXES["y"])), *orientation(joint))


POINT_ON_PLANE = JointKind(
    keys=(AXIS, ORIENTATION),
    blocks=_point_on_plane_parts,
    forbids=forbidding("along"),
    words={"en": "point on a plane", "sk": "bod v rovine"},
    mark=JointMark((MarkPart("plate", 3.5), MarkPart("ball", 1)), sign=SLIDE),
    gimbals=gimbals(2),
)
"""Point on a plane: two translations across the axis, the plane's normal, and any rotation. Class t = 1."""


def _free_parts(joint: Joint) -> tuple[JointBlock, ...]:
    if ORIENTATION.of(joint) == "quaternion":
        return (FLIGHT,)
    return (*(slide(AXES[letter]) for letter in "xyz"), *orientation(joint))


FREE = JointKind(
    keys=(ORIENTATION,),
    blocks=_free_parts,
    forbids=forbidding("none"),
    words={"en": "free", "sk": "voľné"},
    mark=JointMark((MarkPart("flight"), MarkPart("frames", 3)), sign=PageSign()),
    gimbals=gimbals(3),
)
"""Free joint: six freedoms, no contact. Class t = 0."""
