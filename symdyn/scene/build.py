"""Scenes in Python: the same words, the same checks and the same result as a TOML file.

    arm = scene(
        "pendulum",
        parameters=[parameter("m", 1, unit="kg"), parameter("l", "1/2", unit="m")],
        bodies=[body("bob", mass="m", com=[0, "-l", 0])],
        joints=[revolute("hinge", "ground", "bob", axis=[0, 0, 1])],
        gravity=[0, -9.81, 0],
    )

Wherever a number is wanted there may be an int, a Fraction, a float (0.1 means 1/10), a formula, a value with its
unit in text, such as "500 mm", or a quantity. Numbers without a unit are in SI.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, Protocol, TypedDict, Unpack

from symdyn.arguments import check_arguments, checked, suggesting
from symdyn.errors import SceneError, suggestion
from symdyn.scene.declaration.declare import Declaration, assemble
from symdyn.scene.forces.force_table import sections
from symdyn.scene.values.body import Particle
from symdyn.scene.values.entry import Entry, Faults, Number, Placement, Three, entry, rows_of, show
from symdyn.scene.values.model import Scene


class Elements(TypedDict, total=False):
    """What acts beside gravity and drives, and constraints on velocities; each declared by functions of its name."""

    springs: Sequence[Entry]
    dampers: Sequence[Entry]
    loads: Sequence[Entry]
    flows: Sequence[Entry]
    constraints: Sequence[Entry]
    ropes: Sequence[Entry]
    contacts: Sequence[Entry]


Inertia = Three | Sequence[Three] | Mapping[str, Number]
Declared = Number | Mapping[str, object] | None


@suggesting
def parameter(
    name: str,
    value: Number | None = None,
    *,
    positive: bool = False,
    unit: str = "",
    latex: str | None = None,
    text: str = "",
    tolerance: Number | Mapping[str, Number] | None = None,
) -> Entry:
    """Declare a named constant; without a value it becomes an argument of every generated function.

    Args:
        name: as formulas write it.
        value: a number, in `unit`; or text, "500 mm" too.
        positive: whether it is above zero whatever its value.
        unit: of the value, such as "mm"; SI where none is given.
        latex: how to print it.
        text: a description for tables.
        tolerance: how far the value may be off, such as "5 %", "0.1 mm", or a number in `unit`.
    """
    return entry("parameters", **locals())


@suggesting
def body(
    name: str,
    *,
    mass: Number | None = None,
    com: Three | None = None,
    first_moment: Three | None = None,
    inertia: Inertia | None = None,
    about: Literal["com", "frame"] | None = None,
    particles: Sequence[Particle | Mapping[str, object]] | None = None,
    allow_invalid_inertia: bool = False,
    shape: str | Mapping[str, object] | None = None,
    text: str = "",
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
        allow_invalid_inertia: accept an inertia that is not physically consistent.
        shape: "rod", "disc", "ring", "ball", "plate", "point", or such as {"type": "disc", "radius": 0.3}.
        text: a description, which lessons and pictures call it by.
    """
    said = locals()
    said["inertia_about"] = said.pop("about")
    return entry("bodies", **said)


@suggesting
def point(name: str, body: str, at: Placement | None = None) -> Entry:
    """Declare a named frame on a body, placed like the origin of a joint."""
    return entry("points", **locals())


@suggesting
def input_signal(
    name: str, value: Number | None = None, *, rates: int = 0, unit: str = "", latex: str | None = None, text: str = ""
) -> Entry:
    """Declare an input: a symbol whose value is given over time from outside, such as a motor's voltage.

    Args:
        name: as the formulas of forces and loads write it.
        rates: how many of its rates are inputs too, NAME_dot and NAME_ddot; 2 of one that is the `motion` of a joint.
        value: where none is given over time, in `unit`, or text, "20 mV" too; zero when left out.
        unit: of the value, such as "V" or "mV"; generated functions take SI.
        latex: how to print it.
        text: a description for tables.
    """
    return entry("inputs", **locals())


@suggesting
def output(name: str, formula: Number, *, unit: str = "", text: str = "") -> Entry:
    """Declare an output, a formula with a name: `grip` may be "point_tip_x - x".

    Args:
        name: of its column, and of the functions "output:NAME".
        formula: in what moves, drives, inputs, parameters, t, places such as `point_tip_x` and `reaction_hinge_fx`.
        unit: of SI; where none is given, that of its formula, unless a number in it may carry one.
        text: a description for tables.
    """
    return entry("outputs", **locals())


@suggesting
def state(
    name: str,
    rate: Number,
    *,
    start: Number | None = None,
    unit: str = "",
    reset: Mapping[str, Number] | None = None,
    latex: str | None = None,
    text: str = "",
) -> Entry:
    """Declare a state of one's own, such as a motor's current: rate "(u - R*i - k*theta_dot)/L".

    Args:
        name: as formulas write it.
        rate: in coordinates, velocities, states, signals, inputs, parameters and t.
        start: where it starts; zero when left out.
        unit: of SI.
        reset: where it jumps, {"when": "s - 1", "to": 0, "way": "up"}: when `when` passes zero, upwards.
        latex: how to print it.
        text: a description for tables.
    """
    return entry("states", **locals())


@suggesting
def signal(name: str, formula: Number, *, unit: str = "", text: str = "") -> Entry:
    """Declare a formula in what rates of states may use, for others by its name; unit and text as of `state`."""
    return entry("signals", **locals())


@suggesting
def table(
    name: str,
    points: str | Sequence[Sequence[object]] | Mapping[object, object],
    *,
    method: Literal["linear", "akima", "cubic"] = "linear",
) -> Entry:
    """Declare a table of numbers, which formulas read as `table("name", x)`.

    Args:
        name: of it in formulas.
        points: rows or columns x, y, x ascending, or a CSV file; of two arguments rows (y, z, ...) below ("", x, ...).
        method: what stands between points, of two arguments along both.
    """
    return entry("tables", **locals() | {"points": rows_of(points)})


@checked(SceneError)
def dh_table(
    convention: Literal["standard", "modified"], links: Sequence[Mapping[str, object]], parent: str = "ground"
) -> Entry:
    """Declare a chain by Denavit-Hartenberg rows.

    Args:
        convention: "standard" or "modified".
        links: rows with theta, d, a, alpha (rad, m), and the keys of joints and bodies, as in a TOML file.
        parent: the body that carries the chain.
    """
    return Entry("dh", {"convention": convention, "parent": parent, "links": list(links)}, "dh")


@suggesting
def scene(
    name: str,
    *,
    parameters: Sequence[Entry] | Mapping[str, Declared] = (),
    gravity: Three | bool | str | None = None,
    bodies: Sequence[Entry] = (),
    joints: Sequence[Entry] = (),
    points: Sequence[Entry] = (),
    loops: Sequence[Entry] = (),
    dh: Entry | None = None,
    inputs: Sequence[Entry] | Mapping[str, Declared] = (),
    outputs: Sequence[Entry] | Mapping[str, Declared] = (),
    states: Sequence[Entry] = (),
    signals: Sequence[Entry] | Mapping[str, Declared] = (),
    tables: Sequence[Entry] = (),
    source: str = "",
    allow_invalid_inertia: bool = False,
    spanning_tree: Sequence[str] | None = None,
    units: Literal["none"] | None = None,
    text: str = "",
    **elements: Unpack[Elements],
) -> Scene:
    """Return the checked scene.

    Args:
        name: of the scene, used for file and function names.
        parameters: declared by `parameter`, or values by name, None without one, or {"value": 1, "unit": "kg"}.
        gravity: acceleration of free fall in the ground frame, m/s^2; [0, 0, -9.81] when left out, False for none.
        bodies: declared by `body`.
        joints: declared by `joint`, `revolute` and its like, in any order.
        points: declared by `point`.
        loops: declared by `loop`.
        dh: declared by `dh_table`.
        inputs: declared by `input_signal`, or by name values where none are given over time, or {"rates": 1}.
        outputs: declared by `output`, or formulas by name.
        states: declared by `state`.
        signals: declared by `signal`, or formulas by name.
        tables: declared by `table`.
        source: stands in front of every fault; the name of the scene when left out.
        allow_invalid_inertia: accept inertias that are not physically consistent, of every body.
        spanning_tree: names of the joints to cut where `joints` close loops; chosen when left out.
        units: "none" in a scene that is without dimensions on purpose, so that none is checked.
        text: a description, which lessons are titled with.
        elements: `springs`, `dampers`, `loads`, `constraints`, `ropes` and `contacts`, each declared by functions.

    Raises:
        SceneError: with every fault of the declaration, one line each.
    """
    said = locals()
    check_arguments(scene, {k: x for k, x in said.items() if "[Entry]" not in scene.__annotations__[k]}, SceneError)
    acting = dict[str, Any](elements)
    for one in (section for section in acting if section not in sections()):
        raise TypeError(f"scene() takes no {one}; {suggestion(one, [*[*said][:-1], *sections()])}")
    faults = Faults(source or str(name))
    declaration = Declaration(
        name=name,
        gravity=gravity,
        parameters=_entries("parameters", "parameter", parameters, faults),
        bodies=_entries("bodies", "body", bodies, faults),
        joints=_entries("joints", "joint", joints, faults),
        points=_entries("points", "point", points, faults),
        loops=_entries("loop", "loop", loops, faults),
        elements={one: _entries(one, one.removesuffix("s"), some, faults) for one, some in acting.items()},
        dh=dh,
        inputs=_entries("inputs", "input_signal", inputs, faults),
        outputs=_entries("outputs", "output", outputs, faults),
        states=_entries("states", "state", states, faults),
        signals=_entries("signals", "signal", signals, faults),
        tables=_entries("tables", "table", tables, faults),
        units=units,
        text=text or None,
    )
    return assemble(declaration, source, faults, allow_invalid_inertia, spanning_tree)


def _entries(kind: str, maker: str, entries: Any, faults: Faults) -> tuple[Entry, ...]:
    right, by_name = [], isinstance(entries, Mapping)
    if by_name and kind in ("parameters", "inputs", "outputs", "signals"):  # of values, or of tables as those of a file
        make, pairs = globals()[maker], entries.items()
        entries = [make(name, **one) if isinstance(one, Mapping) else make(name, one) for name, one in pairs]
    elif by_name or isinstance(entries, Entry | str) or not isinstance(entries, Iterable):
        first = next(iter(entries), "NAME") if by_name else getattr(entries, "name", "NAME")
        faults.add(kind, f'this is no list; give [{maker}("{first}", ...)]')
        faults.close(SceneError)
    for one in entries:
        if isinstance(one, Entry) and one.where.startswith(f"{kind}."):
            right.append(one)
        else:
            shown = one.where if isinstance(one, Entry) else show(one)
            faults.add(kind, f"{shown} was not made by {maker}(...)")
    return tuple(right)


JointType = Literal[
    "revolute", "prismatic", "fixed", "helical", "cylindrical", "universal", "spherical", "planar", "point_on_line",
    "point_on_plane", "rod", "free", "custom",
]  # fmt: skip
"""The types of joints, for editors; `JOINTS` has them, and those that were added."""


class LimitKeys(TypedDict, total=False):
    """Limits of a joint; what is left out or None is unlimited."""

    lower: Number | None
    upper: Number | None
    velocity: Number | None
    effort: Number | None
    restitution: Number | None
    one_way: bool


class MimicKeys(TypedDict, total=False):
    """What a joint follows: a joint, a coordinate of one that has several, or several of them by `ratios`."""

    joint: str
    coordinate: str
    ratio: Number
    radii: Sequence[Number]
    mesh: Literal["external", "internal"]
    ratios: Mapping[str, Number]
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
    """The keywords of `joint`; which of them a type takes is its row in `JOINTS`."""

    axis: Three | None
    origin: Placement | None
    tip: Placement | None
    child_origin: Placement | None
    coordinate: str | None
    coordinates: Sequence[str] | None
    latex: str | Sequence[str] | None
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
    second_axis: Three | None
    pitch: Number
    length: Number
    orientation: str | None
    steps: Placement
    units: Sequence[str]
    text: str


class Maker(Protocol):
    """A function that declares joints of one type."""

    def __call__(self, name: str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
        """Declare a joint; the arguments are those of `joint`."""


@suggesting
def joint(name: str, type: JointType | str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
    """Declare a joint; joints may close loops: then some are cut and some turned round, see `loop` to choose which.

    Args:
        name: of the joint.
        type: a key of `JOINTS`, such as "revolute", "spherical" or "fixed".
        parent: the body that carries it, or "ground".
        child: the body it carries.
        **keys: as in a TOML file, those of its type (see `JOINTS`) among them:
        origin: from the parent's body frame to the joint frame: {"xyz": .., "rpy": ..}, [x, y, z], steps or a Pose.
        tip: from the moved joint frame to the child's body frame; or child_origin: from that to the joint frame.
        coordinate: name of q of a joint that has one; q1, q2, ... when left out.
        coordinates: names of all of its q, a quaternion's as (w, x, y, z); latex: how q is printed, a list for several.
        drive: name of what drives it, towards growing q; True for tau1, tau2, ..., False: none; a list for several.
        force: generalized force Q beside the drive, of the same sign, N m or N, in what moves, inputs and t; or a list.
        mimic: {"joint": name, "ratio": 1, "offset": 0}, position = ratio · position of that joint + offset, in place
            of a coordinate; {"coordinate": name, ...} of a joint with several; {"joint": name, "radii": [its r, own r],
            "mesh": "external"} of wheels; {"ratios": {name: ratio, ...}} of several, as in a differential gear.
        armature: inertia of a rotor, seen at the joint, kg m^2 or kg; at a ball about all axes alike.
        rotor: {"inertia": ..., "gear": ...} in its place: armature = inertia · gear^2.
        damping: viscous damping of every velocity, Q = -damping · rate, N m s/rad or N s/m.
        friction: dry friction, N m or N, kept as data; {"coulomb": ..., ...} enters the equations, see `Friction`.
        limits: {"lower": ..., "upper": ..., ...}, data; "restitution" makes stops of two, "one_way": True a freewheel.
        start: position at the start, or a guess of it where loops close; zeros, and no rotation, when left out.
        start_rates: velocities at the start; zeros when left out.
        motion: prescribed motion, a formula in t and inputs with rates, of a joint with a drive.
        locked: the joint stands still and becomes a fixed one.
        position: where it stands, rad or m; zero when left out.
        axis: direction in the joint frame, any length but zero; z when left out.
        second_axis: of a universal joint, in the frame that the first rotation has turned; x when left out.
        pitch: of a helical joint, advance a turn, m; length: of a rod, m.
        orientation: of a motion that is spherical in part: "quaternion", or three axes such as "zyx".
        steps: of a custom joint, its motion: steps whose amounts are formulas in its coordinates.
        units: of a custom joint, "rad" or "m" for every coordinate.
        text: a description, which lessons and pictures call it by.
    """
    plain = {"drive": True, "locked": False}  # what is so without saying it
    said = {key: value for key, value in keys.items() if value is not plain.get(key)}
    return entry("joints", name, type=type, parent=parent, child=child, **said)


def _maker(type: str, text: str) -> Maker:
    def made(name: str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
        return joint(name, type, parent, child, **keys)

    made.__name__ = made.__qualname__ = type  # what a message calls it, and what pickles by its name
    made.__doc__ = f"Declare {text}; the arguments are those of `joint`."
    return suggesting(made)


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


@suggesting
def loop(name: str, type: JointType | str, parent: str, child: str, **keys: Unpack[JointKeys]) -> Entry:
    """Declare a joint that closes a loop; the arguments are those of `joint`, and it has no coordinates."""
    return entry("loop", name, type=type, parent=parent, child=child, **keys)
