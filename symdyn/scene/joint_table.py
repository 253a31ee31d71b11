"""Joints as tables: raw keys to `Joint`, in the tree and where they close loops; every fault collected.

A joint in the tree names its coordinates and its drives, or gets q<k> and tau<k>, counted over the whole scene. Every
other key says something about its velocities; a key that a type knows nothing of is refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from symdyn.scene.coupling import Mimic, couple, read_mimic
from symdyn.scene.folding import FormulaError, mul
from symdyn.scene.formula import quantity
from symdyn.scene.joints import JOINTS
from symdyn.scene.loads import Friction
from symdyn.scene.model import Joint, Limits, Pose, velocity_name
from symdyn.scene.names import choice
from symdyn.scene.quantity import ONE, ZERO, Quantity, Vector, number
from symdyn.scene.spelling import spell
from symdyn.scene.table import Entry, Faults, Table, plain, show

PLACE_KEYS = ("type", "parent", "child", "origin", "tip")

SHAPE_KEYS = tuple(dict.fromkeys(key for kind in JOINTS.values() for key in kind.keys))

OWN_KEYS = ("coordinate", "coordinates", "drive", "drives", "force", "forces", "start", "start_rates", "motion")
"""What only a joint with coordinates of its own has."""

SINGLE_KEYS = ("mimic", "armature", "rotor", "limits", "motion")
"""What only a joint with one velocity has; a ball has an armature too."""

RATE_KEYS = ("mimic", "armature", "rotor", "damping", "friction", "limits")

LOCK_KEYS = ("locked", "position")

JOINT_KEYS = (*PLACE_KEYS, *SHAPE_KEYS, *OWN_KEYS, *RATE_KEYS, *LOCK_KEYS)

LOOP_KEYS = (*PLACE_KEYS, *SHAPE_KEYS)

LIMIT_KEYS = ("lower", "upper", "velocity", "effort")

FRICTION_KEYS = ("coulomb", "static", "stribeck", "smoothing")

Z_AXIS: Vector = (ZERO, ZERO, number(1))


def read_joints(entries: Sequence[Entry], faults: Faults) -> tuple[Joint, ...]:
    """Return the joints of the tree, parents first as the entries are."""
    tables = [Table(entry, faults, JOINT_KEYS) for entry in entries]
    joints: list[Joint] = []
    mimics: list[Mimic | None] = []
    nq = nv = 0
    for table in tables:
        kind = _type(table)
        mimics.append(read_mimic(table) if kind != "fixed" else None)
        joints.append(_joint(table, kind, nq, nv, mimics[-1] is not None))
        nq, nv = nq + len(joints[-1].coordinates), nv + len(joints[-1].rates)
    return couple(joints, mimics, tables)


def read_loops(entries: Sequence[Entry], faults: Faults) -> tuple[Joint, ...]:
    """Return the joints that close loops."""
    loops = []
    for entry in entries:
        table = Table(entry, faults, JOINT_KEYS)
        _refuse(table, (*OWN_KEYS, *RATE_KEYS, *LOCK_KEYS), "a joint that closes a loop")
        loops.append(_placed(table, _type(table)))
    return tuple(loops)


def _type(table: Table) -> str:
    """Return a key of `JOINTS`; "revolute" stands in for what is none."""
    kind = table.required("type", f"write one of {', '.join(JOINTS)}")
    if kind in JOINTS:
        strange = [key for key in SHAPE_KEYS if key not in JOINTS[kind].keys]
        _refuse(table, strange, f"a {kind} joint")
        return kind
    if kind:
        table.fault(f'type = "{kind}" is not a joint; {choice(kind, JOINTS)}')
    table.faults.nameless(table.entry.where, "type", kind)
    return "revolute"


def _placed(table: Table, kind: str) -> Joint:
    """Return a joint of its type and frames, without coordinates."""
    return Joint(
        name=table.entry.name,
        type=kind,
        parent=table.required("parent", 'write the body that carries it, or "ground"'),
        child=table.required("child", "write the body that it carries"),
        axis=table.vector("axis", Z_AXIS),
        origin=table.pose("origin"),
        tip=table.pose("tip"),
        second_axis=table.vector("second_axis", (ONE, ZERO, ZERO)),
        pitch=_needed(table, kind, "pitch", "pitch = 0.01, the advance a turn in metres"),
        length=_needed(table, kind, "length", "length = 0.5, the distance of its ends in metres"),
        orientation=_orientation(table),
    )


def _needed(table: Table, kind: str, key: str, example: str) -> Quantity:
    if key in JOINTS[kind].keys and key not in table and table.raw.get("type") == kind:
        table.fault(f"{key} is missing; write {example}")
    return table.quantity(key)


def _orientation(table: Table) -> str:
    raw = table.text("orientation", "quaternion")
    axes = len(raw) == 3 and all(letter in "xyz" for letter in raw) and raw[0] != raw[1] != raw[2]
    if raw != "quaternion" and not axes:
        table.fault(
            f'orientation = {show(raw)} is neither "quaternion" nor three axes of which no two neighbours are equal; '
            'write one such as "zyx" or "zxz"'
        )
        return "quaternion"
    return raw


def _joint(table: Table, kind: str, nq: int, nv: int, follows: bool) -> Joint:
    """Return a joint of the tree; nq coordinates and nv velocities of the scene come before its own."""
    joint = _placed(table, kind)
    if kind == "custom":
        joint = replace(joint, steps=_steps(table), units=_units(table))
    units = JOINTS[kind].coordinates(joint)
    speeds = JOINTS[kind].velocities(joint)
    if kind == "fixed":
        _refuse(table, (*OWN_KEYS, *RATE_KEYS, *LOCK_KEYS), "a fixed joint")
        return joint
    if follows:
        _refuse(table, (*OWN_KEYS, *LOCK_KEYS), "a joint that follows another one")
    if len(speeds) != 1:
        keys = [key for key in SINGLE_KEYS if key != "armature" or not JOINTS[kind].ball]
        _refuse(table, keys, f"a {kind} joint, which has {len(speeds)} velocities")
    if kind == "custom":
        _refuse(table, ("mimic",), "a custom joint")
    friction, dry = _friction(table, kind, len(speeds))
    joint = replace(
        joint,
        armature=_armature(table),
        damping=table.quantity("damping"),
        friction=friction,
        dry=dry,
        limits=_limits(table),
    )
    if follows:
        return joint
    coordinates = _coordinates(table, kind, len(units), nq)
    joint = replace(
        joint, coordinates=coordinates, velocities=_velocities(joint, coordinates), forces=_forces(table, kind, speeds)
    )
    return replace(
        joint,
        drives=_drives(table, kind, len(speeds), nv),
        start=_numbers(table, "start", len(units), f"a {kind} joint has {len(units)} coordinates"),
        start_rates=_numbers(table, "start_rates", len(speeds), f"a {kind} joint has {len(speeds)} velocities"),
        motion=table.quantity("motion") if "motion" in table else None,
    )


def _refuse(table: Table, keys: Sequence[str], what: str) -> None:
    for key in keys:
        if key in table and not (key == "drive" and table.raw[key] is False):
            table.fault(f"{key} = {show(table.raw[key])} has no meaning for {what}; leave it out")


def _steps(table: Table) -> Pose:
    if "steps" not in table:
        table.fault('steps is missing; write the motion as steps such as [["Rz", "u"], ["Tx", "0.1*u"]]')
    return table.pose("steps")


def _units(table: Table) -> tuple[str, ...]:
    raw = plain(table.raw.get("units"))
    if raw is None:
        table.fault('units is missing; write "rad" or "m" for each coordinate, such as units = ["rad"]')
    elif isinstance(raw, (list, tuple)) and 1 <= len(raw) <= 6 and all(unit in ("rad", "m") for unit in raw):
        return tuple(raw)
    else:
        table.fault(f'units = {show(raw)} is not a list of one to six "rad" and "m"; write one for each coordinate')
    return ("rad",) * (len(_listed(table.raw.get("coordinates"))) or 1)


def _listed(raw: object) -> list[object]:
    """Return a list as it is, anything else that is given as the only entry of one."""
    raw = plain(raw)
    return [] if raw is None else list(raw) if isinstance(raw, (list, tuple)) else [raw]


def _either(table: Table, one: str, several: str) -> str:
    """Return which of two keys is given, the first if none is."""
    if one in table and several in table:
        table.fault(f"{one} and {several} say the same thing twice; give one of them")
    return several if several in table else one


def _coordinates(table: Table, kind: str, n: int, before: int) -> tuple[str, ...]:
    default = tuple(f"q{before + k}" for k in range(1, n + 1))
    key = _either(table, "coordinate", "coordinates")
    if key not in table:
        if kind == "custom":
            table.fault('coordinates is missing; name those that its steps use, such as coordinates = ["u"]')
        return default
    if key == "coordinate" and n == 1:
        return (table.text("coordinate", default[0]) or default[0],)
    names = _listed(table.raw[key])
    wrong = [name for name in names if not isinstance(name, str)]
    if wrong:
        table.fault(f"{key}: {show(wrong[0])} is not text; put it in quotes, such as {key} = [{show(default[0])}]")
        return default
    if len(names) != n:
        table.fault(f"{key} = {show(table.raw[key])} has {len(names)} names; a {kind} joint has {n} coordinates")
        return default
    return tuple(str(name) for name in names)


def _velocities(joint: Joint, coordinates: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the velocities where some are no rates of coordinates: <joint>_wx ... of a quaternion."""
    names: list[str] = []
    i = 0
    blocks = JOINTS[joint.type].blocks(joint)
    for block in blocks:
        nq = len(block.coordinates)
        rates = [velocity_name(q) for q in coordinates[i : i + nq]]
        names += [f"{joint.name}_{letter}" for letter in block.letters] or rates
        i += nq
    return tuple(names) if any(block.letters for block in blocks) else ()


def _drives(table: Table, kind: str, n: int, before: int) -> tuple[str | None, ...]:
    """Return the names of the drives, one a velocity, None where it is passive."""
    default = [f"tau{before + k}" for k in range(1, n + 1)]
    key = _either(table, "drive", "drives")
    raw = plain(table.raw.get(key, True))
    if raw is False:
        return (None,) * n
    if raw is True:
        return tuple(default)
    if n == 1 and key == "drive" and not isinstance(raw, (list, tuple)):
        return (table.text("drive", default[0]) or default[0],)
    given = _listed(raw)
    if len(given) != n:
        table.fault(f"{key} = {show(raw)} has {len(given)} entries; a {kind} joint has {n} velocities")
        return tuple(default)
    names: list[str | None] = []
    for own, one in zip(default, given, strict=True):
        if not isinstance(one, (str, bool)):
            table.fault(f"{key}: {show(one)} is no name, nor true or false; write one such as {show(own)}")
        names.append(None if one is False else own if one is True or not isinstance(one, str) else one)
    return tuple(names)


def _forces(table: Table, kind: str, speeds: Sequence[str]) -> tuple[Quantity, ...]:
    key = _either(table, "force", "forces")
    forces = _numbers(table, key, len(speeds), f"a {kind} joint has {len(speeds)} velocities")
    return forces if any(force != ZERO for force in forces) else ()


def _numbers(table: Table, key: str, n: int, why: str) -> tuple[Quantity, ...]:
    """Return a number or a list of n numbers; () where the key is not given or does not fit."""
    if key not in table:
        return ()
    given = _listed(table.raw[key])
    if len(given) != n:
        some = "one number" if len(given) == 1 else f"{len(given)} numbers"
        table.fault(f"{key} = {show(table.raw[key])} is {some}; {why}")
        return ()
    try:
        return tuple(quantity(plain(one)) for one in given)
    except FormulaError as error:
        table.refuse(key, error)
        return ()


def _armature(table: Table) -> Quantity:
    """Return the inertia of a rotor seen at the joint: as it is, or behind a gear, inertia · gear²."""
    if "rotor" not in table:
        armature = table.quantity("armature")
        _not_negative(table, "armature", armature)
        return armature
    if "armature" in table:
        table.fault("armature and rotor say the same thing twice; give one of them")
    advice = "write rotor = { inertia = 1e-4, gear = 100 }"
    inner = table.inner("rotor", ("inertia", "gear"), advice)
    if "inertia" not in inner:
        inner.fault(f"inertia is missing; {advice}")
    inertia, gear = inner.quantity("inertia"), inner.quantity("gear", ONE)
    _not_negative(inner, "inertia", inertia)
    if gear == ZERO:
        inner.fault(f"gear = 0 turns no rotor; {advice}")
    try:
        return mul(inertia, mul(gear, gear))
    except FormulaError as error:
        table.refuse("rotor", error)
        return ZERO


def _not_negative(table: Table, key: str, inertia: Quantity) -> None:
    if isinstance(inertia.value, Fraction) and inertia.value < 0:
        table.fault(f"{key} = {spell(inertia)} is negative; give an inertia of zero or more")


def _friction(table: Table, kind: str, n: int) -> tuple[Quantity, Friction | None]:
    """Return dry friction as data, and as it enters the equations."""
    if not isinstance(table.raw.get("friction"), Mapping):
        return table.quantity("friction"), None
    if n != 1:
        table.fault(f"friction is a table, which has no meaning for a {kind} joint; give loads instead")
    advice = "write friction = { coulomb = 0.5, static = 0.7, stribeck = 0.1, smoothing = 0.01 }"
    inner = table.inner("friction", FRICTION_KEYS, advice)
    if "coulomb" not in inner:
        inner.fault(f"coulomb is missing; {advice}")
    return ZERO, Friction(
        coulomb=inner.quantity("coulomb"),
        static=inner.quantity("static") if "static" in inner else None,
        stribeck=inner.quantity("stribeck", ONE),
        smoothing=inner.quantity("smoothing"),
    )


def _limits(table: Table) -> Limits:
    if "limits" not in table:
        return Limits()
    inner = table.inner("limits", LIMIT_KEYS, "write limits = { lower = -1, upper = 1, velocity = 2, effort = 50 }")
    return Limits(*(inner.quantity(key) if inner.raw.get(key) is not None else None for key in LIMIT_KEYS))
