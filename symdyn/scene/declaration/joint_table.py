"""Joints as tables: raw keys to `Joint`, in the tree and where they close loops; every fault collected.

A joint in the tree names its coordinates and its drives, or gets q<k> and tau<k>, counted over the whole scene. Every
other key says something about its velocities; a key that a type knows nothing of is refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, TypeGuard

from symdyn.scene.declaration.coupling import Mimic, couple, read_mimic
from symdyn.scene.forces.force_table import read_rubbing
from symdyn.scene.joints.joint_table import JOINTS, own_keys
from symdyn.scene.values.element import Element
from symdyn.scene.values.entry import Entry, EntryReader, Faults, as_list, plain, show
from symdyn.scene.values.folding import mul
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.joint import Joint, Limits, velocity_name
from symdyn.scene.values.names import choice
from symdyn.scene.values.quantity import FormulaError, Quantity, spell
from symdyn.scene.values.requested_units import fits_place

PLACE_KEYS = ("type", "parent", "child", "origin", "tip")

OWN_KEYS = ("coordinate", "coordinates", "drive", "drives", "force", "forces", "start", "start_rates", "motion")
"""What only a joint with coordinates of its own has."""

SINGLE_KEYS = ("mimic", "armature", "rotor", "limits", "motion")
"""What only a joint with one velocity has; a ball has an armature too."""

RATE_KEYS = ("mimic", "armature", "rotor", "damping", "friction", "limits")

LOCK_KEYS = ("locked", "position")

LIMIT_KEYS = ("lower", "upper", "velocity", "effort")

STAND_IN = next(iter(JOINTS))
"""Type of a joint whose type is none; the mistake is reported where it stands."""


def loop_keys() -> tuple[str, ...]:
    """Return the keys of a joint that closes a loop."""
    return (*PLACE_KEYS, *own_keys())


def joint_keys() -> tuple[str, ...]:
    """Return the keys of a joint in the tree."""
    return (*loop_keys(), *OWN_KEYS, *RATE_KEYS, *LOCK_KEYS)


def read_joints(entries: Sequence[Entry], faults: Faults) -> tuple[Joint, ...]:
    """Return the joints of the tree, parents first as the entries are."""
    keys = joint_keys()
    tables = [EntryReader(entry, faults, keys) for entry in entries]
    joints: list[Joint] = []
    mimics: list[Mimic | None] = []
    nq = nv = 0
    for table in tables:
        kind = _type(table)
        placed = _placed(table, kind, _shape(table, kind))
        mimics.append(read_mimic(table) if JOINTS[placed.type].velocities(placed) else None)
        joints.append(_joint(table, placed, nq, nv, mimics[-1] is not None))
        nq, nv = nq + len(joints[-1].coordinates), nv + len(joints[-1].rates)
    return couple(joints, mimics, tables)


def read_loops(entries: Sequence[Entry], faults: Faults) -> tuple[Joint, ...]:
    """Return the joints that close loops; what is asked of a type that closes none would be advice for nothing."""
    loops = []
    for entry in entries:
        table = EntryReader(entry, faults, joint_keys())
        _refuse(table, (*OWN_KEYS, *RATE_KEYS, *LOCK_KEYS), "a joint that closes a loop")
        kind = _type(table)
        loops.append(_placed(table, kind, () if JOINTS[kind].forbids is None else _shape(table, kind)))
    return tuple(loops)


def freedoms(entry: Entry) -> int:
    """Return how many freedoms a declared joint has; mistakes are reported where it is read."""
    raw = entry.table.get("type")
    kind = raw if isinstance(raw, str) and raw in JOINTS else STAND_IN
    table = EntryReader(entry, Faults(""), tuple(entry.table))
    return len(JOINTS[kind].velocities(Joint("", kind, "", "", _shape(table, kind))))


def _shape(table: EntryReader, kind: str) -> tuple[tuple[str, Any], ...]:
    return tuple((key.name, key.declared(table)) for key in JOINTS[kind].keys)


def _type(table: EntryReader) -> str:
    """Return a key of `JOINTS`; `STAND_IN` for what is none."""
    kind = table.required("type", f"write one of {', '.join(JOINTS)}")
    if kind in JOINTS:
        own = {key.name for key in JOINTS[kind].keys}
        strange = [key for key in own_keys() if key not in own]
        _refuse(table, strange, f"a {kind} joint")
        return kind
    if kind:
        table.fault(f'type = "{kind}" is not a joint; {choice(kind, JOINTS)}')
    table.faults.nameless(table.entry.where, "type", kind)
    return STAND_IN


def _placed(table: EntryReader, kind: str, shape: tuple[tuple[str, Any], ...]) -> Joint:
    """Return a joint of its type and frames, without coordinates."""
    return Joint(
        name=table.entry.name,
        type=kind,
        parent=table.required("parent", 'write the body that carries it, or "ground"'),
        child=table.required("child", "write the body that it carries"),
        shape=shape,
        origin=table.pose("origin"),
        tip=table.pose("tip"),
    )


def _joint(table: EntryReader, joint: Joint, nq: int, nv: int, follows: bool) -> Joint:
    """Return a placed joint as one of the tree; nq coordinates and nv velocities of the scene come before its own."""
    kind = joint.type
    units = JOINTS[kind].coordinates(joint)
    speeds = JOINTS[kind].velocities(joint)
    for keys, what in meaningless(joint, follows):
        _refuse(table, keys, what)
    if not speeds:
        return joint
    data, dry = _friction(table, kind, len(speeds))
    said: dict[str, Any] = {"armature": _armature(table), "damping": table.quantity("damping")}
    said |= {"friction": data, "dry": dry, "limits": _limits(table)}
    if follows:
        return replace(joint, **said)
    coordinates = _coordinates(table, kind, len(units), nq)
    return replace(
        joint,
        **said,
        coordinates=coordinates,
        velocities=_velocities(joint, coordinates),
        forces=_forces(table, kind, speeds),
        drives=_drives(table, kind, len(speeds), nv),
        start=_numbers(table, "start", len(units), f"a {kind} joint has {len(units)} coordinates"),
        start_rates=_numbers(table, "start_rates", len(speeds), f"a {kind} joint has {len(speeds)} velocities"),
        motion=table.quantity("motion") if "motion" in table else None,
    )


def meaningless(joint: Joint, follows: bool = False) -> Iterator[tuple[Sequence[str], str]]:
    """Yield keys that have no meaning for a joint, and what it is."""
    kind, speeds = JOINTS[joint.type], JOINTS[joint.type].velocities(joint)
    if not speeds:
        yield (*OWN_KEYS, *RATE_KEYS, *LOCK_KEYS), f"a {joint.type} joint"
        return
    if follows:
        yield (*OWN_KEYS, *LOCK_KEYS), "a joint that follows another one"
    if len(speeds) != 1:
        keys = [key for key in SINGLE_KEYS if key != "armature" or not kind.ball(joint)]
        yield keys, f"a {joint.type} joint, which has {len(speeds)} velocities"
    if kind.names_coordinates:
        yield ("mimic",), f"a {joint.type} joint"


def _refuse(table: EntryReader, keys: Sequence[str], what: str) -> None:
    for key in keys:
        if key in table and not (key == "drive" and table.raw[key] is False):
            table.fault(f"{key} = {show(table.raw[key])} has no meaning for {what}; leave it out")


def _either(table: EntryReader, one: str, several: str) -> str:
    """Return which of two keys is given, the first if none is."""
    if one in table and several in table:
        table.fault(f"{one} and {several} say the same thing twice; give one of them")
    return several if several in table else one


def _coordinates(table: EntryReader, kind: str, n: int, before: int) -> tuple[str, ...]:
    default = tuple(f"q{before + k}" for k in range(1, n + 1))
    key = _either(table, "coordinate", "coordinates")
    if key not in table:
        if JOINTS[kind].names_coordinates:
            table.fault('coordinates is missing; name those that its steps use, such as coordinates = ["u"]')
        return default
    if key == "coordinate" and n == 1:
        return (table.text("coordinate", default[0]),)
    names = as_list(table.raw[key])
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


def _drives(table: EntryReader, kind: str, n: int, before: int) -> tuple[str | None, ...]:
    """Return the names of the drives, one a velocity, None where it is passive."""
    default = [f"tau{before + k}" for k in range(1, n + 1)]
    key = _either(table, "drive", "drives")
    raw = plain(table.raw.get(key, True))
    if raw is False:
        return (None,) * n
    if raw is True:
        return tuple(default)
    if "" in as_list(raw):
        table.fault(
            f"{key} = {show(raw)} is no name; give one such as {show(default[0])}, or false where it is passive"
        )
        return tuple(default)
    if n == 1 and key == "drive" and not isinstance(raw, (list, tuple)):
        return (table.text("drive", default[0]) or default[0],)
    given = as_list(raw)
    if len(given) != n:
        table.fault(f"{key} = {show(raw)} has {len(given)} entries; a {kind} joint has {n} velocities")
        return tuple(default)
    names: list[str | None] = []
    for own, one in zip(default, given, strict=True):
        if not isinstance(one, (str, bool)):
            table.fault(f"{key}: {show(one)} is no name, nor true or false; write one such as {show(own)}")
        names.append(None if one is False else own if one is True or not isinstance(one, str) else one)
    return tuple(names)


def _forces(table: EntryReader, kind: str, speeds: Sequence[str]) -> tuple[Quantity, ...]:
    key = _either(table, "force", "forces")
    forces = _numbers(table, key, len(speeds), f"a {kind} joint has {len(speeds)} velocities")
    return forces if any(force != Quantity.ZERO for force in forces) else ()


def _numbers(table: EntryReader, key: str, n: int, why: str) -> tuple[Quantity, ...]:
    """Return a number or a list of n numbers; () where the key is not given or does not fit."""
    if key not in table:
        return ()
    given = as_list(table.raw[key])
    if len(given) != n:
        some = "one number" if len(given) == 1 else f"{len(given)} numbers"
        table.fault(f"{key} = {show(table.raw[key])} is {some}; {why}")
        return ()
    try:
        return tuple(quantity(plain(one)) for one in given)
    except FormulaError as error:
        table.refuse(key, error)
        return ()


def _armature(table: EntryReader) -> Quantity:
    """Return the inertia of a rotor seen at the joint: as it is, or behind a gear, inertia · gear²."""
    if "rotor" not in table:
        return table.quantity("armature")  # its sign is looked at when values are known
    if "armature" in table:
        table.fault("armature and rotor say the same thing twice; give one of them")
    advice = "write rotor = { inertia = 1e-4, gear = 100 }"
    inner = table.inner("rotor", ("inertia", "gear"), advice)
    if "inertia" not in inner:
        inner.fault(f"inertia is missing; {advice}")
    inertia, gear = inner.quantity("inertia"), inner.quantity("gear", Quantity.ONE)
    fits_place(inner, "inertia", inertia, ("kg m^2", "kg"))
    fits_place(inner, "gear", gear, ("1", "rad/m"))
    if gear == Quantity.ZERO:
        inner.fault(f"gear = 0 turns no rotor; {advice}")
    if isinstance(inertia.value, Fraction) and inertia.value < 0:
        inner.fault(f"inertia = {spell(inertia)} is negative; give an inertia of zero or more")
        return Quantity.ZERO
    try:
        return mul(inertia, mul(gear, gear))
    except FormulaError as error:
        table.refuse("rotor", error)
        return Quantity.ZERO


def acts(friction: object) -> TypeGuard[Mapping[str, object]]:
    """Tell whether raw friction is a table of what acts; a number is data, also one as a table with its unit."""
    return isinstance(friction, Mapping) and "value" not in friction


def _friction(table: EntryReader, kind: str, n: int) -> tuple[Quantity, Element | None]:
    """Return dry friction as data, and as it enters the equations."""
    raw = table.raw.get("friction")
    if not acts(raw):
        return table.quantity("friction"), None
    if n != 1:
        table.fault(f"friction is a table, which has no meaning for a {kind} joint; give loads instead")
    entry = Entry(table.entry.name, raw, f"{table.entry.where}: friction")
    return Quantity.ZERO, read_rubbing(entry, "friction", table.faults)


def _limits(table: EntryReader) -> Limits:
    if "limits" not in table:
        return Limits()
    inner = table.inner("limits", LIMIT_KEYS, "write limits = { lower = -1, upper = 1, velocity = 2, effort = 50 }")
    return Limits(*(inner.quantity(key) if inner.raw.get(key) is not None else None for key in LIMIT_KEYS))
