"""Scenes in Python: the same words, the same checks and the same result as a TOML file.

    arm = scene(
        "pendulum",
        parameters=[parameter("m", 1, unit="kg"), parameter("l", "1/2", unit="m")],
        bodies=[body("bob", mass="m", com=[0, "-l", 0])],
        joints=[revolute("hinge", "ground", "bob", axis=[0, 0, 1])],
        gravity=[0, -9.81, 0],
    )

Wherever a number is wanted there may be an int, a Fraction, a float (0.1 means 1/10), a formula in text or a quantity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypedDict, Unpack

from symdyn.scene.declare import Declaration, assemble
from symdyn.scene.model import Particle, Pose, Scene
from symdyn.scene.quantity import Quantity
from symdyn.scene.table import Entry, Faults, show

Number = int | float | Fraction | str | Quantity
Three = Sequence[Number]
Placement = Pose | Mapping[str, Three] | Sequence[object]
Inertia = Three | Sequence[Three] | Mapping[str, Number]


def parameter(
    name: str,
    value: Number | None = None,
    *,
    positive: bool = False,
    unit: str = "",
    latex: str | None = None,
    text: str = "",
) -> Entry:
    """Declare a named constant; without a value it becomes an argument of every generated function."""
    return _entry("parameters", name, value=value, positive=positive, unit=unit, latex=latex, text=text)


def body(
    name: str,
    *,
    mass: Number | None = None,
    com: Three | None = None,
    first_moment: Three | None = None,
    inertia: Inertia | None = None,
    about: str | None = None,
    particles: Sequence[Particle | Mapping[str, object]] | None = None,
    allow_invalid_inertia: bool = False,
) -> Entry:
    """Declare a rigid body.

    Args:
        name: of the body.
        mass: kg.
        com: centre of mass in body coordinates, m; the origin when left out.
        first_moment: mass times centre of mass, kg m, instead of `com`; goes with about="frame".
        inertia: [xx, yy, zz], a symmetric 3 x 3 matrix, or {"xx": ..., "xy": ...}: matrix entries, kg m^2.
        about: "com" or "frame", the point that `inertia` refers to; must come with it.
        particles: point masses such as {"mass": "m1", "at": [0, 0, 1]}.
        allow_invalid_inertia: accept an inertia that no real body has.
    """
    return _entry(
        "bodies",
        name,
        mass=mass,
        com=com,
        first_moment=first_moment,
        inertia=inertia,
        inertia_about=about,
        particles=particles,
        allow_invalid_inertia=allow_invalid_inertia,
    )


class JointKeys(TypedDict, total=False):
    """The keywords of `joint`, which `revolute` and `prismatic` take too."""

    axis: Three | None
    origin: Placement | None
    tip: Placement | None
    coordinate: str | None
    drive: str | bool
    force: Number | None
    mimic: Mapping[str, Number] | None
    armature: Number | None
    damping: Number | None
    friction: Number | None
    limits: Mapping[str, Number | None] | None
    locked: bool
    position: Number | None


def joint(
    name: str,
    type: str,
    parent: str,
    child: str,
    *,
    axis: Three | None = None,
    origin: Placement | None = None,
    tip: Placement | None = None,
    coordinate: str | None = None,
    drive: str | bool = True,
    force: Number | None = None,
    mimic: Mapping[str, Number] | None = None,
    armature: Number | None = None,
    damping: Number | None = None,
    friction: Number | None = None,
    limits: Mapping[str, Number | None] | None = None,
    locked: bool = False,
    position: Number | None = None,
) -> Entry:
    """Declare a joint.

    Args:
        name: of the joint.
        type: "revolute", "prismatic" or "fixed".
        parent: the body it hangs on, or "ground".
        child: the body it carries.
        axis: direction in the joint frame, any length but zero; z when left out.
        origin: from the parent's body frame to the joint frame: {"xyz": ..., "rpy": ...}, [x, y, z], steps or a Pose.
        tip: from the moved joint frame to the child's body frame.
        coordinate: name of q; q1, q2, ... when left out.
        drive: name of the driving force or torque; True for tau1, tau2, ..., False for a passive joint.
        force: generalized force beside the drive, N m or N, in parameters, coordinates and velocities.
        mimic: {"joint": name, "ratio": 1, "offset": 0} of a joint that follows another one, in place of a coordinate:
            position = ratio · position of that joint + offset.
        armature: inertia of a rotor, seen at the joint, kg m^2 or kg.
        damping: viscous damping, N m s/rad or N s/m.
        friction: dry friction, N m or N; kept as data.
        limits: {"lower": ..., "upper": ..., "velocity": ..., "effort": ...}; what is left out or None is unlimited;
            kept as data.
        locked: the joint stands still and becomes a fixed one.
        position: where it stands, rad or m; zero when left out.
    """
    return _entry(
        "joints",
        name,
        type=type,
        parent=parent,
        child=child,
        axis=axis,
        origin=origin,
        tip=tip,
        coordinate=coordinate,
        drive=None if drive is True else drive,
        force=force,
        mimic=mimic,
        armature=armature,
        damping=damping,
        friction=friction,
        limits=limits,
        locked=locked or None,
        position=position,
    )


def revolute(name: str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
    """Declare a revolute joint; the arguments are those of `joint`."""
    return joint(name, "revolute", parent, child, **keys)


def prismatic(name: str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
    """Declare a prismatic joint; the arguments are those of `joint`."""
    return joint(name, "prismatic", parent, child, **keys)


def fixed(name: str, parent: str, child: str, *, origin: Placement | None = None) -> Entry:
    """Declare a weld of two bodies; the arguments are those of `joint`."""
    return joint(name, "fixed", parent, child, origin=origin)


def point(name: str, body: str, at: Placement | None = None) -> Entry:
    """Declare a named frame on a body, placed like the origin of a joint."""
    return _entry("points", name, body=body, at=at)


def dh_table(convention: str, links: Sequence[Mapping[str, object]], parent: str = "ground") -> Entry:
    """Declare a chain by Denavit-Hartenberg rows.

    Args:
        convention: "standard" or "modified".
        links: rows with theta, d, a, alpha (rad, m), and the keys of joints and bodies, as in a TOML file.
        parent: the body that the chain hangs on.
    """
    return Entry("dh", {"convention": convention, "parent": parent, "links": list(links)}, "dh")


def scene(
    name: str,
    *,
    parameters: Sequence[Entry] | Mapping[str, Number | None] = (),
    gravity: Three | bool | str | None = None,
    bodies: Sequence[Entry] = (),
    joints: Sequence[Entry] = (),
    points: Sequence[Entry] = (),
    dh: Entry | None = None,
    source: str = "",
    allow_invalid_inertia: bool = False,
) -> Scene:
    """Return the checked scene.

    Args:
        name: of the scene, used for file and function names.
        parameters: declared by `parameter`, or a mapping of names to values (None: without a value).
        gravity: acceleration of free fall in the ground frame, m/s^2; [0, 0, -9.81] when left out, False for none.
        bodies: declared by `body`.
        joints: declared by `joint`, `revolute`, `prismatic`, `fixed`, in any order.
        points: declared by `point`.
        dh: declared by `dh_table`.
        source: stands in front of every fault; the name of the scene when left out.
        allow_invalid_inertia: accept inertias that no real body has, of every body.

    Raises:
        SceneError: with every fault of the declaration, one line each.
    """
    if isinstance(parameters, Mapping):
        parameters = [parameter(key, value) for key, value in parameters.items()]
    faults = Faults(source or str(name))
    declaration = Declaration(
        name=name,
        gravity=gravity,
        parameters=_entries("parameters", "parameter", parameters, faults),
        bodies=_entries("bodies", "body", bodies, faults),
        joints=_entries("joints", "joint", joints, faults),
        points=_entries("points", "point", points, faults),
        dh=dh,
    )
    return assemble(declaration, source, faults, allow_invalid_inertia)


def _entries(kind: str, maker: str, entries: Sequence[Entry], faults: Faults) -> tuple[Entry, ...]:
    right = []
    for entry in entries:
        if isinstance(entry, Entry) and entry.where.startswith(f"{kind}."):
            right.append(entry)
        else:
            shown = entry.where if isinstance(entry, Entry) else show(entry)
            faults.add(kind, f"{shown} was not made by {maker}(...)")
    return tuple(right)


def _entry(kind: str, name: str, **table: object) -> Entry:
    """Return a table of what was given; what is None or at its default was not."""
    given = {key: value for key, value in table.items() if value is not None}
    return Entry(str(name), given, f"{kind}.{name}")
