"""Joint types: one row each.

Here are those that are parts put together and forbid by words: lower pairs, points on lines and planes, no contact.

Custom joint: elementary motions whose amounts are formulas in its own coordinates. Class t = 6 - coordinates.

A cam, a screw with a varying pitch, a knee: the motion subspace is what the formulas' derivatives make it. It carries a
body of the tree; it closes no loop, since what it forbids has no closed form.

Numbers that joints of all types have, and where they start.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from symdyn.graph import Graph
from symdyn.scene.joints.blocks import (
    AXES,
    AXIS,
    FLIGHT,
    ORIENTATION,
    about_opposite,
    along,
    forbidding,
    gimbals,
    held,
    orientation,
    path,
    slide,
    turn,
)
from symdyn.scene.joints.compound_joints import HELICAL, ROD, UNIVERSAL
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
from symdyn.scene.values.body import UNMOVED, Pose
from symdyn.scene.values.dimension import FORCE_UNITS
from symdyn.scene.values.entry import EntryReader, as_list, plain, show
from symdyn.scene.values.joint import Joint, Limits
from symdyn.scene.values.key import OWN, Key, KeyGroup, flag, keys_of, number, optional, placement, shape_of
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.shape import NUMBER, choice_of, not_both, several


def _units(table: EntryReader, name: str, default: tuple[str, ...]) -> tuple[str, ...]:
    if name in table:
        raw = plain(table.raw[name])
        if isinstance(raw, (list, tuple)) and 1 <= len(raw) <= 6 and all(unit in ("rad", "m") for unit in raw):
            return tuple(raw)
        table.fault(f'{name} = {show(raw)} is not a list of one to six "rad" and "m"; write one for each coordinate')
    return default * (len(as_list(table.raw.get("coordinates"))) or 1)


STEPS = Key(
    "steps",
    EntryReader.pose,
    UNMOVED,
    example='the motion as steps such as [["Rz", "u"], ["Tx", "0.1*u"]]',
    names=OWN,
    holds="the motion: elementary steps whose amounts are formulas in its coordinates",
)

UNITS: Key[tuple[str, ...]] = Key(
    "units",
    _units,
    ("rad",),
    example='"rad" or "m" for each coordinate, such as units = ["rad"]',
    holds="of its coordinates",
    shape=several(choice_of("rad", "m"), 1, 6),
)


def _blocks(joint: Joint) -> tuple[JointBlock, ...]:
    return (path(STEPS.of(joint), joint.coordinates, UNITS.of(joint)),)


def _turned(joint: Joint) -> Joint:
    return joint.shaped(steps=STEPS.of(joint).inverse())


CUSTOM = JointKind(
    keys=(STEPS, UNITS),
    blocks=_blocks,
    forbids=None,
    words={"en": "given by formulas", "sk": "dané vzorcami"},
    mark=JointMark((MarkPart("wire"), MarkPart("diamond", 1.35))),
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
    held=lambda joint, angle: held(joint, angle, lambda x: (("R", x),)),
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
    held=lambda joint, way: held(joint, way, lambda x: (("T", x),)),
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


POINT_ON_PLANE = JointKind(
    keys=(AXIS, ORIENTATION),
    blocks=lambda joint: (*along(joint.axis, slide(AXES["x"]), slide(AXES["y"])), *orientation(joint)),
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


ORIGIN = placement("origin", "from the frame of the parent to that of the joint")

TIP = placement("tip", "from the moved frame of the joint to that of the child")

CHILD_ORIGIN = placement("child_origin", "from the frame of the child to that of the joint, in place of tip")


def _tip(table: EntryReader) -> dict[str, Pose]:
    """Return where the child's frame is in the moved joint's, which may be said the other way round."""
    if CHILD_ORIGIN.name not in table:
        return TIP.fields(table, None)
    if TIP.name in table:
        table.fault("tip and child_origin place the child in the joint and the joint in the child; write one of them")
    return {TIP.name: CHILD_ORIGIN.declared(table).inverse()}


BEHIND = KeyGroup(
    {**TIP.words, **CHILD_ORIGIN.words},
    lambda table, scope: _tip(table),
    TIP.raw,
    rules=not_both([(TIP.name, CHILD_ORIGIN.name)]),
)
"""Where the frame of the child is."""

LIMITS: tuple[Key[Quantity | None] | Key[bool], ...] = (
    Key("lower", optional(EntryReader.quantity), None, unit=("rad", "m"), shape=NUMBER),
    Key("upper", optional(EntryReader.quantity), None, unit=("rad", "m"), shape=NUMBER),
    Key("velocity", optional(EntryReader.quantity), None, unit=("rad/s", "m/s"), shape=NUMBER, never_negative=True),
    Key("effort", optional(EntryReader.quantity), None, unit=FORCE_UNITS, shape=NUMBER, never_negative=True),
    Key("restitution", optional(EntryReader.quantity), None, unit="1", shape=NUMBER, never_negative=True),
    flag("one_way", "whether its rate is never below zero"),
)
"""What a joint may do, each of them by its own key."""


def _limits(table: EntryReader, key: str, unlimited: Limits) -> Limits:
    if key not in table:
        return unlimited
    advice = "write limits = { lower = -1, upper = 1, velocity = 2, effort = 50 }"
    inner = table.inner(key, keys_of(LIMITS), advice)
    said: dict[str, Any] = {one.name: one.declared(inner) for one in LIMITS if inner.raw.get(one.name) is not None}
    return Limits(**said)


ARMATURE = number(
    "armature",
    ("kg m^2", "kg"),
    letters=("Ia",),
    text="rotor inertia at {}",
    positive=True,
    holds="inertia of a rotor, seen at the joint, {}",
    never_negative=True,
)

DAMPING = number(
    "damping",
    ("N m s/rad", "N s/m"),
    letters=("fv",),
    text="damping of {}",
    positive=True,
    holds="viscous, Q = -damping * rate, {}",
    never_negative=True,
)

DRY = number("friction", FORCE_UNITS, never_negative=True)
"""Dry friction as data; what acts is a table."""

LIMITED = Key(
    "limits", _limits, Limits(), inside=LIMITS, holds="lower <= q <= upper; rate and force", shape=shape_of(LIMITS)
)

RESISTING: tuple[Key[Quantity] | Key[Limits], ...] = (ARMATURE, DAMPING, DRY, LIMITED)
"""Numbers that joints of all types have, but for those that stand still."""


def own_keys() -> tuple[str, ...]:
    """Return the keys that some joint type takes, each once."""
    return tuple(dict.fromkeys(key.name for kind in JOINTS.values() for key in kind.keys))


def joint_motion(joint: Joint, graph: Graph) -> JointMotion:
    """Return the motion of the moved joint frame in the joint frame; velocities count from the joint's first."""
    if joint.coupling is not None:
        rate = graph.total(ratio * graph.symbol(name) for name, _, ratio in joint.moved_by(graph))
        return JOINTS[joint.type].motion(joint, graph, (joint.position(graph),), (rate,))
    q = tuple(graph.symbol(name) for name in joint.coordinates)
    return JOINTS[joint.type].motion(joint, graph, q, tuple(graph.symbol(name) for name in joint.rates))


# Where a scene starts: zeros where it does not say, no rotation for a quaternion


class Start(NamedTuple):
    """A state at the start.

    Attributes:
        position: shape (nq,), a guess of it where loops close; rad, m or 1.
        velocity: shape (nv,); rad/s or m/s.
    """

    position: tuple[Quantity, ...]
    velocity: tuple[Quantity, ...]


def start_of(scene: Scene) -> Start:
    """Return the state at the start."""
    return Start(
        tuple(x for joint in scene.joints for x in joint.start or resting(joint)),
        tuple(x for joint in scene.joints for x in joint.start_rates or (Quantity.ZERO,) * len(joint.rates)),
    )


def resting(joint: Joint) -> tuple[Quantity, ...]:
    """Return the coordinates of a joint that does not say where it starts: zeros, and (1, 0, 0, 0) for a quaternion."""
    values = [Quantity.ZERO] * len(joint.coordinates)
    first = JOINTS[joint.type].quaternion(joint)
    if first is not None:
        values[first] = Quantity.ONE
    return tuple(values)
