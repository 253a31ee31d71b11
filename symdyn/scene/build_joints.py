"""Joints in Python: one maker a type, the same words as in a TOML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, Protocol, TypedDict, Unpack

from symdyn.scene.values.table import Entry, Number, Placement, Three, entry

JointType = Literal[
    "revolute",
    "prismatic",
    "fixed",
    "helical",
    "cylindrical",
    "universal",
    "spherical",
    "planar",
    "point_on_line",
    "point_on_plane",
    "rod",
    "free",
    "custom",
]
"""The types of joints, for editors; `JOINTS` has them, and those that were added."""


class LimitKeys(TypedDict, total=False):
    """Limits of a joint; what is left out or None is unlimited."""

    lower: Number | None
    upper: Number | None
    velocity: Number | None
    effort: Number | None


class MimicKeys(TypedDict, total=False):
    """What a joint follows: a joint, or a coordinate of one that has several."""

    joint: str
    coordinate: str
    ratio: Number
    offset: Number


class RotorKeys(TypedDict, total=False):
    """A rotor behind a gear."""

    inertia: Number
    gear: Number


class FrictionKeys(TypedDict, total=False):
    """Dry friction that acts; see `Friction`."""

    coulomb: Number
    static: Number
    stribeck: Number
    smoothing: Number


class JointKeys(TypedDict, total=False):
    """The keywords of `joint`; which of them a type takes, its row in `JOINTS` says."""

    origin: Placement | None
    tip: Placement | None
    coordinate: str | None
    coordinates: Sequence[str] | None
    drive: str | bool | Sequence[str | bool]
    force: Number | Sequence[Number] | None
    mimic: MimicKeys | Mapping[str, Number | str] | None
    armature: Number | None
    rotor: RotorKeys | Mapping[str, Number] | None
    damping: Number | None
    friction: Number | FrictionKeys | Mapping[str, Number] | None
    limits: LimitKeys | Mapping[str, Number | None] | None
    start: Number | Sequence[Number] | None
    start_rates: Number | Sequence[Number] | None
    motion: Number | None
    locked: bool
    position: Number | None
    axis: Three | None
    second_axis: Three | None
    pitch: Number
    length: Number
    orientation: str | None
    steps: Placement
    units: Sequence[str]


class Maker(Protocol):
    """A function that declares joints of one type."""

    def __call__(self, name: str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
        """Declare a joint; the arguments are those of `joint`."""


def joint(name: str, type: JointType | str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
    """Declare a joint.

    Joints may close loops: then some are cut and some turned round, see `loop` to say which.

    Args:
        name: of the joint.
        type: a key of `JOINTS`, such as "revolute", "spherical" or "fixed".
        parent: the body it hangs on, or "ground".
        child: the body it carries.
        **keys: as in a TOML file, those of its type (see `JOINTS`) among them:
        origin: from the parent's body frame to the joint frame: {"xyz": ..., "rpy": ...}, [x, y, z], steps or a
            Pose.
        tip: from the moved joint frame to the child's body frame.
        coordinate: name of q of a joint that has one; q1, q2, ... when left out.
        coordinates: names of all of its q; a quaternion's four are (w, x, y, z).
        drive: name of the driving force or torque; True for tau1, tau2, ..., False for a passive joint; a list with
            one of these for every velocity.
        force: generalized force beside the drive, N m or N, in parameters, coordinates, velocities and t; a list
            with one for every velocity.
        mimic: {"joint": name, "ratio": 1, "offset": 0} of a joint that follows another one, in place of a
            coordinate: position = ratio · position of that joint + offset; {"coordinate": name, ...} of a joint
            with several.
        armature: inertia of a rotor, seen at the joint, kg m^2 or kg; at a ball about all axes alike.
        rotor: {"inertia": ..., "gear": ...} in its place: armature = inertia · gear^2.
        damping: viscous damping of every velocity, N m s/rad or N s/m.
        friction: dry friction, N m or N, kept as data; or {"coulomb": ..., "static": ..., "stribeck": ...,
            "smoothing": ...} for friction that enters the equations, see `Friction`.
        limits: {"lower": ..., "upper": ..., "velocity": ..., "effort": ...}; what is left out or None is unlimited;
            kept as data.
        start: position at the start, or a guess of it where loops close; zeros, and no rotation, when left out.
        start_rates: velocities at the start; zeros when left out.
        motion: prescribed motion, a formula in t, of a joint with a drive.
        locked: the joint stands still and becomes a fixed one.
        position: where it stands, rad or m; zero when left out.
        axis: direction in the joint frame, any length but zero; z when left out.
        second_axis: of a universal joint, in the frame that the first rotation has turned; x when left out.
        pitch: of a helical joint, advance a turn, m.
        length: of a rod, m.
        orientation: of a motion that is spherical in part: "quaternion", or three axes such as "zyx".
        steps: of a custom joint, its motion: steps whose amounts are formulas in its coordinates.
        units: of a custom joint, "rad" or "m" for every coordinate.
    """
    plain = {"drive": True, "locked": False}  # what is so without saying it
    said = {key: value for key, value in keys.items() if value is not plain.get(key)}
    return entry("joints", name, type=type, parent=parent, child=child, **said)


def _maker(type: str, text: str) -> Maker:
    def made(name: str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
        return joint(name, type, parent, child, **keys)

    made.__name__ = made.__qualname__ = type  # what a message calls it, and what pickles by its name
    made.__doc__ = f"Declare {text}; the arguments are those of `joint`."
    return made


revolute = _maker("revolute", "a revolute joint")
prismatic = _maker("prismatic", "a prismatic joint")
fixed = _maker("fixed", "a weld of two bodies")
helical = _maker("helical", "a screw, whose pitch must be given")
cylindrical = _maker("cylindrical", "a joint that turns about its axis and slides along it")
universal = _maker("universal", "a universal (Cardan) joint")
spherical = _maker("spherical", "a ball and socket")
planar = _maker("planar", "two translations across the axis and a rotation about it")
point_on_line = _maker("point_on_line", "a point that slides along the axis, the child turning about it")
point_on_plane = _maker("point_on_plane", "a point in the plane across the axis, the child turning about it")
rod = _maker("rod", "a massless rod between two points, whose length must be given")
free = _maker("free", "a body without contact, in six coordinates or seven")
custom = _maker("custom", "a joint by the steps of its motion, which must be given with its units")


def loop(name: str, type: JointType | str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
    """Declare a joint that closes a loop; the arguments are those of `joint`, and it has no coordinates."""
    return entry("loop", name, type=type, parent=parent, child=child, **keys)
