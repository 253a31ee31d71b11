"""Joint types: one row each, in a file of its own where it has code.

Joint types that are parts put together and forbid by words: lower pairs, points on lines and planes, no contact.

Custom joint: elementary motions whose amounts are formulas in its own coordinates. Class t = 6 - coordinates.

A cam, a screw with a varying pitch, a knee: the motion subspace is what the formulas' derivatives make it. It carries a
body of the tree; it closes no loop, since what it forbids has no closed form.
"""

from __future__ import annotations

from symdyn.graph import Graph
from symdyn.scene.joints.blocks import (
    AXES,
    AXIS,
    FLIGHT,
    ORIENTATION,
    about_opposite,
    along,
    gimbals,
    inverse,
    orientation,
    path,
    shifted_by,
    slide,
    turn,
    turned_by,
)
from symdyn.scene.joints.forbidden import forbidding
from symdyn.scene.joints.helical import HELICAL
from symdyn.scene.joints.joint_kind import (
    SLIDE,
    WELD,
    JointBlock,
    JointKind,
    JointMark,
    JointMotion,
    MarkPart,
    PageSign,
)
from symdyn.scene.joints.rod import ROD
from symdyn.scene.joints.universal import UNIVERSAL
from symdyn.scene.values.body import Pose
from symdyn.scene.values.entry import EntryReader, as_list, plain, show
from symdyn.scene.values.joint import Joint, velocity_name
from symdyn.scene.values.key import PLACEMENT, Key, choice_of, several


def _units(table: EntryReader, name: str, default: tuple[str, ...]) -> tuple[str, ...]:
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


JOINTS: dict[str, JointKind] = {
    "revolute": REVOLUTE,
    "prismatic": PRISMATIC,
    "fixed": FIXED,
    "helical": HELICAL,
    "cylindrical": CYLINDRICAL,
    "universal": UNIVERSAL,
    "spherical": SPHERICAL,
    "planar": PLANAR,
    "point_on_line": POINT_ON_LINE,
    "point_on_plane": POINT_ON_PLANE,
    "rod": ROD,
    "free": FREE,
    "custom": CUSTOM,
}


def own_keys() -> tuple[str, ...]:
    """Return the keys that some joint type takes, each once."""
    return tuple(dict.fromkeys(key.name for kind in JOINTS.values() for key in kind.keys))


def joint_motion(joint: Joint, graph: Graph) -> JointMotion:
    """Return the motion of the moved joint frame in the joint frame; velocities count from the joint's first."""
    if joint.coupling is not None:
        ratio = joint.coupling.ratio.express(graph)
        leader = graph.symbol(velocity_name(joint.coupling.coordinate))
        position = joint.position(graph)
        return JOINTS[joint.type].motion(joint, graph, (position,), (ratio * leader,))
    q = tuple(graph.symbol(name) for name in joint.coordinates)
    return JOINTS[joint.type].motion(joint, graph, q, tuple(graph.symbol(name) for name in joint.rates))
