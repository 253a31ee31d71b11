"""Joints as tables, in the tree and where they close loops: a row a key, or one for one freedom and one for several.

A joint in the tree names its coordinates and its drives, or gets q<k> and tau<k>, counted over the whole scene. Every
other key says something about its velocities; a key that a type knows nothing of is refused. Every fault is collected.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, TypeGuard

from symdyn.errors import choice, hint
from symdyn.frozen import dataclass, field, replace
from symdyn.scene.declaration.coupling import LOCKED, MIMIC, RATIOS, Mimic, couple, read_mimic, said_mimic
from symdyn.scene.forces.attachments import OF_THE_TREE
from symdyn.scene.forces.force_kind import Scope
from symdyn.scene.forces.force_table import read_rubbing, table_of
from symdyn.scene.joints.joint_table import ARMATURE, BEHIND, DAMPING, DRY, JOINTS, LIMITED, ORIGIN, own_keys
from symdyn.scene.values.description import DESCRIBED
from symdyn.scene.values.dimensional_analysis import fits_place
from symdyn.scene.values.entry import Entry, EntryReader, Faults, as_list, plain, quantities, show
from symdyn.scene.values.folding import mul
from symdyn.scene.values.grammar import check_scene_name
from symdyn.scene.values.joint import Joint, velocity_name
from symdyn.scene.values.key import Key, KeyGroup, Part, fields_of, keys_of, number, optional, raw_of, shape_of, word
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, spell
from symdyn.scene.values.shape import ANYTHING, FLAG, NUMBER, TEXT, Shape, choice_of, described, name_shape, not_both

PARENT = word("parent", 'name of the body that carries it, or "ground"', 'the body that carries it, or "ground"')

CHILD = word("child", "name of the body it carries", "the body that it carries")


def place_keys() -> tuple[Part, ...]:
    """Return what all joints say of type, bodies and frames, the types being those that are known by now."""
    type_ = word("type", "what kind of joint", f"one of {', '.join(JOINTS)}", shape=choice_of(*JOINTS))
    return (type_, DESCRIBED, PARENT, CHILD, ORIGIN, BEHIND)


@dataclass(frozen=True)
class Standing:
    """A joint while its table is read or written, and what it needs of the joints of its scene.

    Attributes:
        joint: of its type, where it is.
        nq, nv: coordinates and velocities of the joints before it.
        leaders: names of joints by their coordinate.
    """

    joint: Joint
    nq: int
    nv: int
    leaders: Mapping[str, str] = field(default_factory=dict)

    @property
    def letters(self) -> tuple[str, ...]:
        """Names of its coordinates where none are given: q<k>, counted over the scene."""
        units = JOINTS[self.joint.type].coordinates(self.joint)
        return tuple(f"q{self.nq + k}" for k in range(1, len(units) + 1))

    @property
    def drives(self) -> tuple[str, ...]:
        """Names of its drives where none are given: tau<k>, counted over the scene."""
        speeds = JOINTS[self.joint.type].velocities(self.joint)
        return tuple(f"tau{self.nv + k}" for k in range(1, len(speeds) + 1))

    def has(self, n: int, what: str) -> str:
        """Return what a message says of its number of coordinates or velocities."""
        return f"a {self.joint.type} joint has {n} {what}"


def _one_or_more(keys: Sequence[str], values: Sequence[object]) -> dict[str, object]:
    """Return one value under the first key, several under the last, none under none."""
    return {} if not values else {keys[0]: values[0]} if len(values) == 1 else {keys[-1]: list(values)}


def _either(table: EntryReader, one: str, several: str) -> str:
    """Return which of two keys is given, the first if none is."""
    if one in table and several in table:
        table.fault(f"{one} and {several} give the same quantity; write one of them")
    return several if several in table else one


def _coordinates(table: EntryReader, at: Standing) -> dict[str, Any]:
    names = _coordinate_names(table, at)
    latex = tuple(zip(names, _texts(table, "latex", at, ()), strict=False))
    return {"coordinates": names, "velocities": _velocities(at.joint, names), "latex": latex}


def _coordinate_names(table: EntryReader, at: Standing) -> tuple[str, ...]:
    default = at.letters
    key = _either(table, *NAMES)
    if key not in table and JOINTS[at.joint.type].names_coordinates:
        table.fault('coordinates is missing; name those that its steps use, such as coordinates = ["u"]')
    if key in table and key == NAMES[0] and len(default) == 1:
        return (table.text(key, default[0]),)
    return _texts(table, key, at, default)


def _texts(table: EntryReader, key: str, at: Standing, otherwise: tuple[str, ...]) -> tuple[str, ...]:
    """Return a text for each coordinate; something else where the key is not given or does not fit."""
    given, n = as_list(table.raw.get(key)), len(at.letters)
    wrong = [one for one in given if not isinstance(one, str)]
    if wrong:
        table.fault(f"{key}: {show(wrong[0])} is not text; put it in quotes, such as {key} = [{show(at.letters[0])}]")
    elif key in table and len(given) != n:
        table.fault(f"{key} = {show(table.raw[key])} has {len(given)} names; {at.has(n, 'coordinates')}")
    elif key in table:
        return tuple(map(str, given))
    return otherwise


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


def _said_coordinates(joint: Joint, at: Standing) -> dict[str, object]:
    made_up = joint.coordinates == at.letters and not JOINTS[joint.type].names_coordinates
    shown = _one_or_more(("latex",), [x for q in joint.coordinates for name, x in joint.latex if name == q])
    return ({} if made_up else _one_or_more(NAMES, joint.coordinates)) | shown


NAMES = ("coordinate", "coordinates")

LETTER = name_shape(letter=True)

LETTERS, TEXTS = ({"anyOf": [one, {"type": "array", "items": one}]} for one in (LETTER, TEXT))

COORDINATES = KeyGroup(
    {
        "coordinate": described("name of q; q1, q2, ... when left out", LETTERS),
        "coordinates": described("names of q of a joint that has several", LETTERS),
        "latex": described("symbol of q in printed equations; of several, a list", TEXTS),
    },
    _coordinates,
    _said_coordinates,
    rules=not_both([NAMES]),
)


def _drives(table: EntryReader, at: Standing) -> tuple[str | None, ...]:
    default = at.drives
    key = _either(table, *DRIVES.keys)
    raw = plain(table.raw.get(key, True))
    if raw is False:
        return (None,) * len(default)
    if raw is True:
        return default
    if any(isinstance(one, str) and (check_scene_name(one) or one.lower() in NO_DRIVE) for one in as_list(raw)):
        told = f"{show(default[0])}, false where it is passive; motion prescribes it, force acts beside"
        table.fault(f"{key} = {show(raw)} is no name; give one such as {told}")
        return default
    if len(default) == 1 and key == DRIVES.keys[0] and not isinstance(raw, (list, tuple)):
        return (table.text(key, default[0]) or default[0],)
    given = as_list(raw)
    if len(given) != len(default):
        table.fault(f"{key} = {show(raw)} has {len(given)} entries; {at.has(len(default), 'velocities')}")
        return default
    names: list[str | None] = []
    for own, one in zip(default, given, strict=True):
        if not isinstance(one, (str, bool)):
            table.fault(f"{key}: {show(one)} is no name, nor true or false; write one such as {show(own)}")
        names.append(None if one is False else own if one is True or not isinstance(one, str) else one)
    return tuple(names)


def _said_drives(joint: Joint, at: Standing) -> dict[str, object]:
    if not joint.coordinates or joint.drives == at.drives:
        return {}
    if not any(joint.drives):
        return {DRIVES.keys[0]: False}
    return _one_or_more(DRIVES.keys, [name or False for name in joint.drives])


NO_DRIVE = ("none", "false", "true", "no", "yes", "off", "on", "passive")

DRIVE: Shape = {"anyOf": [LETTER, FLAG, {"type": "array", "items": {"anyOf": [LETTER, FLAG]}}]}

DRIVES = KeyGroup(
    {
        "drive": described("name of the driving force or torque, towards growing q; false: passive", DRIVE),
        "drives": described("names of the driving forces, false where it is passive", DRIVE),
    },
    lambda table, at: {"drives": _drives(table, at)},
    _said_drives,
    rules=not_both([("drive", "drives")]),
)


def _acting(forces: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
    return forces if any(force != Quantity.ZERO for force in forces) else ()


def _numbers(table: EntryReader, key: str, at: Standing, what: str = "velocities") -> tuple[Quantity, ...]:
    """Return a number for each coordinate or velocity; () where the key is not given or does not fit."""
    if key not in table:
        return ()
    n, given = len(at.drives if what == "velocities" else at.letters), as_list(table.raw[key])
    if len(given) != n:
        some = "one number" if len(given) == 1 else f"{len(given)} numbers"
        table.fault(f"{key} = {show(table.raw[key])} is {some}; {at.has(n, what)}")
        return ()
    return table.parsed(key, (), lambda _: quantities(given))


EACH: Shape = {"anyOf": [NUMBER, {"type": "array", "items": NUMBER}]}

FORCE: KeyGroup = KeyGroup(
    {
        "force": described("generalized force Q beside the drive, towards growing q, N m or N; a formula", EACH),
        "forces": described("generalized forces, one a velocity, N m or N", EACH),
    },
    lambda table, at: {"forces": _acting(_numbers(table, _either(table, *FORCE.keys), at))},
    lambda joint, at: _one_or_more(FORCE.keys, _acting(joint.forces)),
    rules=not_both([("force", "forces")]),
)

FOLLOWED = KeyGroup(
    {
        "mimic": described(
            "position = ratio * position of another joint + offset, or the sum of several",
            {**shape_of(MIMIC), "oneOf": [{"required": [key]} for key in ("joint", "coordinate", RATIOS.name)]},
        )
    },
    said=lambda joint, at: said_mimic(joint.coupling, at.leaders),  # `read_mimic` reads all joints together
)

ROTOR = (number("inertia"), Key("gear", EntryReader.quantity, Quantity.ONE))


def _armature(table: EntryReader) -> Quantity:
    """Return the inertia of a rotor seen at the joint: as it is, or behind a gear, inertia · gear²."""
    if _either(table, "armature", "rotor") == "armature":
        return ARMATURE.declared(table)
    advice = "write rotor = { inertia = 1e-4, gear = 100 }"
    inner = table.inner("rotor", keys_of(ROTOR), advice)
    if "inertia" not in inner:
        inner.fault(f"inertia is missing; {advice}")
    inertia, gear = (key.declared(inner) for key in ROTOR)
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


ROTORS = KeyGroup(
    {
        **ARMATURE.words,
        "rotor": described("in place of armature, which is inertia * gear^2", shape_of(ROTOR, ["inertia"])),
    },
    lambda table, at: {"armature": _armature(table)},
    ARMATURE.raw,
    rules=not_both([("armature", "rotor")]),
)


def acts(friction: object) -> TypeGuard[Mapping[str, object]]:
    """Tell whether raw friction is a table of what acts; a number is data, also one as a table with its unit."""
    return isinstance(friction, Mapping) and "value" not in friction


def _friction(table: EntryReader, at: Standing) -> dict[str, Any]:
    raw = table.raw.get("friction")
    if not acts(raw):
        return {"friction": DRY.declared(table), "dry": None}
    if len(at.drives) != 1:
        table.fault(f"friction is a table, which has no meaning for a {at.joint.type} joint; give loads instead")
    entry = Entry(table.entry.name, raw, f"{table.entry.where}: friction")
    return {"friction": Quantity.ZERO, "dry": read_rubbing(entry, "friction", table.faults)}


def _said_friction(joint: Joint, at: Standing) -> dict[str, object]:
    return {"friction": table_of(joint.dry, Scope({}, NULL, ()))} if joint.dry else DRY.raw(joint, at)


FRICTION = KeyGroup(
    {"friction": described("a number is data; a table acts, against the rate", ANYTHING)}, _friction, _said_friction
)

START = KeyGroup(
    {"start": described("position at the start, rad or m; a guess where loops close", EACH)},
    read=lambda table, at: {"start": _numbers(table, "start", at, "coordinates")},
    said=lambda joint, at: _one_or_more(["start"], joint.start),
)

START_RATES = KeyGroup(
    {"start_rates": described("velocity at the start", EACH)},
    read=lambda table, at: {"start_rates": _numbers(table, "start_rates", at)},
    said=lambda joint, at: _one_or_more(["start_rates"], joint.start_rates),
)

MOTION = Key("motion", optional(EntryReader.quantity), None, holds="prescribed motion, a formula in t", shape=NUMBER)


OWN_COORDINATES: tuple[Part, ...] = (COORDINATES, DRIVES, FORCE, START, START_RATES, MOTION)
"""What only a joint with coordinates of its own has."""

ROWS: tuple[Part, ...] = (
    *(COORDINATES, DRIVES, FOLLOWED, FORCE, ROTORS, DAMPING, FRICTION, LIMITED, START, START_RATES, MOTION, LOCKED),
)
"""What joints of all types say beside place and type, in the order in which it is written."""

SINGLE: tuple[Part, ...] = (FOLLOWED, ROTORS, LIMITED, MOTION)
"""What only a joint with one velocity has; a ball has an armature too."""


def said_place(joint: Joint) -> dict[str, object]:
    """Return what the table of a joint says of type, bodies and frames."""
    shape = {key.name: key.of(joint) for key in JOINTS[joint.type].keys}
    parts = raw_of((DESCRIBED, PARENT, CHILD), joint), raw_of((ORIGIN, BEHIND), joint)
    return {"type": joint.type, **parts[0], **shape, **parts[1]}


def said_joint(joint: Joint, at: Standing) -> dict[str, object]:
    """Return what the table of a joint of the tree says."""
    return said_place(joint) | raw_of(ROWS, joint, at)


# Reading

STAND_IN = next(iter(JOINTS))
"""Type of a joint whose type is none; the mistake is reported where it stands."""


def loop_keys() -> tuple[str, ...]:
    """Return the keys of a joint that closes a loop."""
    return (*keys_of(place_keys()), *own_keys())


def joint_keys() -> tuple[str, ...]:
    """Return the keys of a joint in the tree."""
    return (*loop_keys(), *keys_of(ROWS))


def read_joints(entries: Sequence[Entry], faults: Faults) -> tuple[Joint, ...]:
    """Return the joints of the tree, parents first as the entries are."""
    keys = joint_keys()
    tables = [EntryReader(entry, faults, keys) for entry in entries]
    joints: list[Joint] = []
    mimics: list[Mimic | None] = []
    nq = nv = 0
    names = {entry.name for entry in entries}
    for table in tables:
        kind = _type(table)
        placed = _placed(table, kind, _shape(table, kind))
        mimic = read_mimic(table) if JOINTS[placed.type].velocities(placed) else None
        mimics.append(mimic)
        follows = mimic is not None and (mimic.key != "joint" or mimic.ratios[0][0] in names)
        joints.append(_joint(table, placed, nq, nv, follows))
        nq, nv = nq + len(joints[-1].coordinates), nv + len(joints[-1].rates)
    return couple(joints, mimics, tables)


def read_loops(entries: Sequence[Entry], faults: Faults) -> tuple[Joint, ...]:
    """Return the joints that close loops; what is asked of a type that closes none would be advice for nothing."""
    loops = []
    for entry in entries:
        own = keys_of(JOINTS[raw].keys) if (raw := str(entry.table.get("type"))) in JOINTS else own_keys()
        known = joint_keys() if entry.where.startswith("joints.") else (*keys_of(place_keys()), *own)
        table = EntryReader(entry, faults, known, joint_keys())
        kind = _type(table)
        joint = _placed(table, kind, () if JOINTS[kind].forbids is None else _shape(table, kind))
        for keys, what in meaningless(joint):
            _refuse(table, keys, what)
        instead = OF_THE_TREE.format(joint.name)
        ends = f'from = {{ body = "{joint.parent}", at = .. }}, to = {{ body = "{joint.child}", at = .. }}'
        damper = f"; or [dampers.NAME] with {ends}, two points on its axis" if kind == "prismatic" else ""
        for key in keys_of(ROWS):
            _refuse(table, [key], "a joint that closes a loop", instead + damper * (key in DAMPING.words))
        loops.append(joint)
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
    kind = str(place_keys()[0].fields(table, None)["type"])
    if kind in JOINTS:
        own = {key.name for key in JOINTS[kind].keys}
        strange = [key for key in own_keys() if key not in own]
        _refuse(table, strange, f"a {kind} joint")
        return kind
    if kind:
        table.fault(f'type = "{kind}" is not a joint; {hint("types", kind) or choice(kind, JOINTS)}')
    table.faults.nameless(table.entry.where, "type", kind)
    return STAND_IN


def _placed(table: EntryReader, kind: str, shape: tuple[tuple[str, Any], ...]) -> Joint:
    return Joint(table.entry.name, kind, shape=shape, **fields_of((DESCRIBED, PARENT, CHILD, ORIGIN, BEHIND), table))


def _joint(table: EntryReader, joint: Joint, nq: int, nv: int, follows: bool) -> Joint:
    """Return a placed joint as one of the tree; nq coordinates and nv velocities of the scene come before its own."""
    for keys, what in meaningless(joint, follows):
        _refuse(table, keys, what)
    if not JOINTS[joint.type].velocities(joint):
        return joint
    parts = [part for part in ROWS if not (follows and part in OWN_COORDINATES)]
    return replace(joint, **fields_of(parts, table, Standing(joint, nq, nv)))


def meaningless(joint: Joint, follows: bool = False) -> Iterator[tuple[Sequence[str], str]]:
    """Yield keys that have no meaning for a joint, and what it is."""
    kind, speeds = JOINTS[joint.type], JOINTS[joint.type].velocities(joint)
    if not speeds:
        yield keys_of(ROWS), f"a {joint.type} joint"
        return
    if follows:
        yield keys_of((*OWN_COORDINATES, LOCKED)), "a joint that follows another one"
    if len(speeds) != 1:
        keys = [key for key in keys_of(SINGLE) if key != ARMATURE.name or not kind.ball(joint)]
        yield keys, f"a {joint.type} joint, which has {len(speeds)} velocities"
    if kind.names_coordinates:
        yield FOLLOWED.keys, f"a {joint.type} joint"


def _refuse(table: EntryReader, keys: Sequence[str], what: str, instead: str = "leave it out") -> None:
    for key in keys:
        raw, said = table.raw.get(key), f"{key} = {show(table.raw.get(key))} has no meaning for "
        if not (key not in table or (key == "drive" and raw is False) or table.faults.told(table.entry.where, said)):
            table.fault(f"{said}{what}; {instead}")
