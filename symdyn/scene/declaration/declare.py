"""From raw tables to a checked scene: the one way that TOML files, Denavit-Hartenberg tables and Python all take.

Denavit-Hartenberg tables are a compact way to write a chain of joints.

    standard   A_i = Rz(θ) Tz(d) Tx(a) Rx(α)                 link frame at the far end of its link
    modified   A_i = Rx(α) Tx(a) Rz(θ) Tz(d)                 a, α of row i are the book's a_(i-1), α_(i-1) (Craig)

The joint moves along or about its z axis: θ = theta + q for a revolute joint, d = d + q for a prismatic one, so theta
or d in a row is the offset of the coordinate. Rotation and shift along one axis commute, so both stand in the origin;
Tx(a) Rx(α) of a standard table is the tip. Body frames are the link frames of the table.

The JSON Schema for editors is made of the tables by which the reader goes: both know the same words. A schema sees one
table at a time. What takes a look at the rest of a scene stays with the reader: names that are declared nowhere, or
twice; formulas that have no value; masses below zero; joints that close no tree.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from typing import Any, TypeVar

from symdyn.frozen import dataclass, field, replace
from symdyn.scene.declaration.coupling import lock, read_locks
from symdyn.scene.declaration.draft import Draft
from symdyn.scene.declaration.joint_table import (
    COORDINATES,
    DRIVES,
    FORCE,
    OWN_COORDINATES,
    PARENT,
    ROWS,
    START,
    START_RATES,
    meaningless,
    place_keys,
    read_joints,
    read_loops,
)
from symdyn.scene.declaration.reading import Reading, ReadOptions
from symdyn.scene.declaration.scene_table import BODY, HEAD, INPUT, OUTPUT, PARAMETER, POINT, SHORT, with_rates
from symdyn.scene.declaration.spanning import span, turned
from symdyn.scene.declaration.states import SIGNAL, STATE, derived_apart, signals_apart
from symdyn.scene.declaration.tables import TABLE, curves_of, tabled
from symdyn.scene.declaration.whole_scene import check, note_angles
from symdyn.scene.forces.flows import with_flows
from symdyn.scene.forces.force_kind import ForceKind, Scope
from symdyn.scene.forces.force_table import kinds_of, read_elements, sections
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_table import JOINTS, own_keys
from symdyn.scene.values.body import Body
from symdyn.scene.values.entry import Entry, EntryReader, Faults, compose, plain, show, shown
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key, Part, fields_of, keys_of, needed_of, number, one_of, word
from symdyn.scene.values.letters import Input, Parameter, Signal, StateVariable
from symdyn.scene.values.model import Point, Scene
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity
from symdyn.scene.values.shape import NUMBER, Shape, choice_of, described, name_shape, table_shape

SECTIONS: Mapping[str, Sequence[Part]] = {
    "parameters": PARAMETER,
    "bodies": BODY,
    "joints": ROWS,
    "points": POINT,
    "inputs": INPUT,
    "outputs": OUTPUT,
    "states": STATE,
    "signals": SIGNAL,
    "tables": TABLE,
}
"""The tables of a scene but those of elements, and their keys; of joints those that all types share."""


@dataclass(frozen=True)
class Declaration:
    """A scene as raw as the user wrote it.

    Attributes:
        name: of the scene.
        gravity: raw value; None for the standard 9.81 m/s^2 along -z, False or "none" for no gravity.
        parameters, bodies, joints, points, inputs, outputs, states, signals, tables: declared tables.
        loops: declared joints that close loops.
        elements: declared tables of what acts, by section.
        dh: a Denavit-Hartenberg table.
        units: raw value; "none" for a scene that is without dimensions on purpose.
        text: raw value; what it is.
    """

    name: str
    gravity: object = None
    parameters: tuple[Entry, ...] = ()
    bodies: tuple[Entry, ...] = ()
    joints: tuple[Entry, ...] = ()
    points: tuple[Entry, ...] = ()
    loops: tuple[Entry, ...] = ()
    elements: Mapping[str, tuple[Entry, ...]] = field(default_factory=dict)
    dh: Entry | None = None
    inputs: tuple[Entry, ...] = ()
    outputs: tuple[Entry, ...] = ()
    states: tuple[Entry, ...] = ()
    signals: tuple[Entry, ...] = ()
    tables: tuple[Entry, ...] = ()
    units: object = None
    text: object = None


def reading_of(declaration: Declaration, faults: Faults, options: ReadOptions) -> Reading:
    """Return what a file declares, checked, with the notes that are in `faults` then.

    Raises:
        SceneError: with every fault of the file, one line each.
    """
    asked = (options.allow_invalid_inertia, options.spanning_tree, options.dimensionless)
    return Reading(assemble(declaration, faults.source, faults, *asked), tuple(faults.notes))


def assemble(
    declaration: Declaration,
    source: str,
    faults: Faults,
    allow_invalid_inertia: bool = False,
    spanning_tree: Sequence[str] | None = None,
    dimensionless: bool = False,
) -> Scene:
    """Return the checked scene, joints sorted parents first.

    Args:
        declaration: what the user wrote.
        source: where it was written, for messages.
        faults: faults found so far.
        allow_invalid_inertia: let every body pass whose inertia no body has, with a note in `faults` for each.
        spanning_tree: the joints to cut where joints close loops; None chooses them, with a note.
        dimensionless: check no dimensions, as where the declaration says so.

    Raises:
        SceneError: with every fault of the declaration, one line each.
    """
    bodies, joints = list(declaration.bodies), list(declaration.joints)
    if declaration.dh is not None:
        more_bodies, more_joints = _expand(declaration.dh, faults)
        bodies, joints = bodies + more_bodies, joints + more_joints
    held = [str(entry.table.get("joint")) for entries in declaration.elements.values() for entry in entries]
    spanned = span(joints, held, spanning_tree, faults)
    loops = (*declaration.loops, *spanned.cut)
    declared = _nouns(Parameter, PARAMETER, declaration.parameters, faults)
    parameters, derived = derived_apart(declared, [entry.where for entry in declaration.parameters], faults)
    head = _head(declaration, faults)
    inputs = tuple(with_rates(_nouns(Input, INPUT, declaration.inputs, faults)))
    scene = Scene(
        name=declaration.name,
        parameters=parameters,
        gravity=head["gravity"],
        bodies=_nouns(Body, BODY, bodies, faults),
        joints=tuple(
            turned(joint) if joint.name in spanned.turned else joint for joint in read_joints(spanned.joints, faults)
        ),
        points=_nouns(Point, POINT, declaration.points, faults),
        loops=read_loops(loops, faults),
        inputs=tuple(one for _, one in inputs),
        outputs=_nouns(Signal, OUTPUT, declaration.outputs, faults),
        derived=derived,
        states=_nouns(StateVariable, STATE, declaration.states, faults),
        signals=_nouns(Signal, SIGNAL, declaration.signals, faults),
        dimensionless=head["dimensionless"] or dimensionless,
        source=source,
        text=head["text"],
        texts=head["texts"],
    )
    curves = curves_of(declaration.tables, faults)
    scene = tabled(scene, curves, faults)
    scene = _written_out(scene, scene.derived_formulas, faults)
    declared_at = [entry.where for entry in declaration.signals]
    scene = replace(scene, signals=signals_apart(scene.signals, declared_at, faults))
    scope = Scope({point.name: point for point in scene.points}, scene.gravity, parameters)
    elements = read_elements(declaration.elements, scope, faults)
    scene = replace(scene, elements=tabled(tuple(one for _, one in elements), curves, faults))
    scene = _written_out(scene, scene.definitions, faults)
    scene = with_flows(scene, [entry.where for entry in bodies], faults)
    places = {"bodies": bodies, "joints": spanned.joints, "loops": loops}
    places |= {kind: getattr(declaration, kind) for kind in ("points", "outputs", "states", "signals")}
    places["inputs"] = [declaration.inputs[k] for k, _ in inputs]
    apart = {one.name for one in derived}
    places["parameters"] = [entry for entry in declaration.parameters if entry.name not in apart]
    places["derived"] = [entry for entry in declaration.parameters if entry.name in apart]
    where = {kind: tuple(entry.where for entry in entries) for kind, entries in places.items()}
    draft = Draft(scene, where | {"elements": tuple(place for place, _ in elements)})
    positions = read_locks(joints, faults)
    _note_friction(scene, faults)
    note_angles(scene, faults)
    used = {name for one in Quantity.inside(scene) for name in one.symbols}
    idle = [one.name for one in scene.parameters if one.name not in used and (one.name, scene.gravity) != ("g", NULL)]
    said = {*re.findall(r"\w+", repr(replace(declaration, parameters=())))} if idle else set()  # 0*R folds away
    for name in (one for one in idle if one not in said):
        faults.note(f"parameters.{name}", Reading.UNUSED)
    excused = check(draft, faults, allow_invalid_inertia)
    faults.close()
    carried = {body.name: body for body in scene.bodies}
    carried |= {name: replace(carried[name], allow_invalid_inertia=True) for name in excused}
    ordered = replace(scene, bodies=tuple(carried[joint.child] for joint in scene.joints))
    return lock(ordered, positions, faults) if positions else ordered


def _written_out(scene: Scene, formulas: Mapping[str, Quantity], faults: Faults) -> Scene:
    """Return the scene with formulas in place of the names that stand for them."""
    try:
        return scene.substituted(formulas)
    except FormulaError as error:
        names = ", ".join(f"{name} = {shown(formula)}" for name, formula in formulas.items())
        faults.add(
            "signals" if scene.signals else "parameters", f"with {names} a formula {error}; check what it divides by"
        )
        return scene


def _note_friction(scene: Scene, faults: Faults) -> None:
    """Note the joints whose friction is a plain number, which does not act."""
    names = [joint.name for joint in scene.joints if joint.friction != Quantity.ZERO]
    if names:
        found = f"friction is kept as data and enters no equation ({', '.join(names)})"
        faults.note("", f"{found}; write friction = {{ coulomb = 0.5, smoothing = 0.01 }} in the scene to have it act")


Noun = TypeVar("Noun")


def _nouns(
    noun: Callable[..., Noun], parts: Sequence[Part], entries: Sequence[Entry], faults: Faults
) -> tuple[Noun, ...]:
    """Return what tables of one section declare."""
    keys = keys_of(parts)
    return tuple(noun(name=one.name, **fields_of(parts, EntryReader(one, faults, keys))) for one in entries)


def _head(declaration: Declaration, faults: Faults) -> dict[str, Any]:
    """Return what stands above all tables."""
    said = {key: value for key, value in vars(declaration).items() if key in keys_of(HEAD) and value is not None}
    return fields_of(HEAD[1:], EntryReader(Entry("", said, ""), faults, keys_of(HEAD)))


# Denavit-Hartenberg tables

CONVENTIONS = ("standard", "modified")

CHAIN: tuple[Key[str], ...] = (
    one_of("convention", CONVENTIONS, "of the table", "", f'convention = "{CONVENTIONS[0]}" or "{CONVENTIONS[1]}"'),
    word("parent", PARENT.holds, default=Scene.GROUND),
)
"""What a table says of all of its rows, which stand under `links`."""

LINK: tuple[Key[Quantity], ...] = (
    number("theta", "rad", text="turn about z"),
    number("d", "m", text="shift along z"),
    number("a", "m", text="shift along x"),
    number("alpha", "rad", text="turn about x"),
)
"""What a row says beside the keys of its joint and its body."""

LINK_OF_JOINT = ("type", "pitch", *keys_of(ROWS))

LINK_KEYS = ("name", *keys_of(LINK), *LINK_OF_JOINT, *keys_of(BODY))


def _expand(entry: Entry, faults: Faults) -> tuple[list[Entry], list[Entry]]:
    """Return the bodies and joints that a table `dh` stands for; faults are collected."""
    table = EntryReader(entry, faults, (*keys_of(CHAIN), "links"))
    convention, parent = (key.declared(table) for key in CHAIN)
    faults.nameless(entry.where, "convention", convention)
    rows = plain(entry.table.get("links", ()))
    if not isinstance(rows, (list, tuple)) or not rows:
        table.fault("links is no list of rows; write one [[dh.links]] for each joint")
        return [], []
    bodies, joints = [], []
    for k, row in enumerate(rows, start=1):
        if not isinstance(row, Mapping):
            table.fault(f"links: row {k} = {show(row)} is not a table; give theta, d, a and alpha")
            continue
        named = row.get("name", f"link{k}")
        link = Entry(named if isinstance(named, str) else f"link{k}", row, f"dh.links.{named}")
        body, joint = _link(link, k, parent, convention, faults)
        bodies.append(body)
        joints.append(joint)
        parent = link.name
    return bodies, joints


def _link(link: Entry, k: int, parent: str, convention: str, faults: Faults) -> tuple[Entry, Entry]:
    table = EntryReader(link, faults, LINK_KEYS)
    table.text("name", link.name)
    turn, shift, length, twist = zip(("Rz", "Tz", "Tx", "Rx"), (key.declared(table) for key in LINK), strict=True)
    standard = convention != "modified"
    joint: dict[str, object] = {"type": "revolute", "parent": parent, "child": link.name}
    joint |= {key: link.table[key] for key in LINK_OF_JOINT if key in link.table}
    joint["origin"] = compose(turn, shift) if standard else compose(twist, length, turn, shift)
    joint["tip"] = compose(length, twist) if standard else compose()
    body = {key: link.table[key] for key in keys_of(BODY) if key in link.table}
    return Entry(link.name, body, link.where), Entry(f"joint{k}", joint, link.where)


DRAFT = "https://json-schema.org/draft/2020-12/schema"

TITLE = "Scene of symdyn"

NAME, LETTER = name_shape(), name_shape(letter=True)

OWN_NAME = described("its name", NAME)

USUAL = "revolute"
"""Type of a joint in a table of Denavit and Hartenberg that says none."""


def schema() -> dict[str, Any]:
    """Return the JSON Schema of scene files, draft 2020-12, as plain data."""
    place = place_keys()
    joint = _joint([*place, *_types(), *ROWS], needed_of(place))
    sheet = {
        section: _named(joint if section == "joints" else _table(parts), LETTER if section in SHORT else NAME)
        for section, parts in SECTIONS.items()
    }
    for section in SHORT:
        sheet[section]["additionalProperties"] = {"anyOf": [sheet[section]["additionalProperties"], NUMBER]}
    sheet |= {section: _named(_elements(section)) for section in sections()}
    loop = _joint([*place, *_types()], needed_of(place), tree=False)
    passive = {"description": "false, as of every joint that nothing drives", "const": False}
    loop["properties"] |= {"name": OWN_NAME, "drive": passive}
    words = {
        **_words(HEAD),
        **sheet,
        "loop": {"type": "array", "items": loop},
        "dh": _denavit_hartenberg(),
    }
    found = {"$schema": DRAFT, "title": TITLE, **table_shape(words)}
    return {**found, "anyOf": [{"required": ["joints"]}, {"required": ["dh"]}]}


def _named(table: Shape, name: Shape = NAME) -> dict[str, Any]:
    return {"type": "object", "propertyNames": name, "additionalProperties": table}


def _words(parts: Iterable[Part]) -> dict[str, Shape]:
    return {key: shape for part in parts for key, shape in part.words.items()}


def _rules(parts: Iterable[Part]) -> list[Shape]:
    return [rule for part in parts for rule in part.rules]


def _table(parts: Sequence[Part]) -> dict[str, Any]:
    rules = _rules(parts)
    return {**table_shape(_words(parts), needed_of(parts)), **({"allOf": rules} if rules else {})}


def _types() -> list[Part]:
    """Return what some types of joints take."""
    return [key for kind in JOINTS.values() for key in kind.keys]


def _joint(parts: Sequence[Part], required: Sequence[str], tree: bool = True) -> dict[str, Any]:
    """Return the table of a joint; what each type takes, needs and refuses stands in a rule of its own."""
    words = _words(parts)
    rules = [_of_type(name, kind, tree, "type" not in required and name == USUAL) for name, kind in JOINTS.items()]
    if tree:
        words["friction"] = {**words["friction"], "anyOf": [NUMBER, _elements("friction")]}
        rules.append({"if": {"required": ["mimic"]}, "then": {"properties": _refused(keys_of(OWN_COORDINATES))}})
    return {**table_shape(words, required), "allOf": [*rules, *_rules(parts)]}


def _refused(keys: Iterable[str]) -> dict[str, Any]:
    """Return that keys are not given; that nothing drives may be said of all joints."""
    return {key: {"const": False} if key == "drive" else False for key in keys}


def _of_type(name: str, kind: JointKind, tree: bool, usual: bool) -> dict[str, Any]:
    """Return what is so of a joint of one type, which need not be said where it is the usual one."""
    own = {key.name for key in kind.keys}
    refused: dict[str, Any] = {key: False for key in own_keys() if key not in own}
    needed = [key.name for key in kind.keys if key.example]
    then: dict[str, Any] = {}
    if tree:
        joint = Joint("", name, "", "", tuple((key.name, key.default) for key in kind.keys))
        refused |= _refused(key for keys, _ in meaningless(joint) for key in keys)
        if kind.names_coordinates:
            then["anyOf"] = [{"required": [key]} for key in ("coordinate", "coordinates")]
        else:
            then["allOf"] = _lengths(kind, joint, own)
    then |= {"properties": refused} | ({"required": needed} if needed else {})
    this = {"properties": {"type": {"const": name}}}
    return {"if": this if usual else {**this, "required": ["type"]}, "then": then}


def _lengths(kind: JointKind, joint: Joint, own: Container[str]) -> list[dict[str, Any]]:
    """Return how long the lists of a joint are, which may be left to its orientation."""
    usual = {"properties": _counts(kind, joint)}
    if "orientation" not in own:
        return [usual]
    angles = {"properties": _counts(kind, joint.shaped(orientation="zyx"))}
    return [{"if": {"properties": {"orientation": {"const": "quaternion"}}}, "then": usual, "else": angles}]


def _counts(kind: JointKind, joint: Joint) -> dict[str, Any]:
    """Return how long the lists of a joint with these coordinates and velocities are; one number is no list."""
    nq, nv = len(kind.coordinates(joint)), len(kind.velocities(joint))
    found: dict[str, Any] = {"coordinate": {"type": "string"}} if nq == 1 else {}
    for part in (COORDINATES, START, DRIVES, FORCE, START_RATES) if nv else ():
        n, lists = nq if part in (COORDINATES, START) else nv, ["array", "boolean"] if part is DRIVES else "array"
        for key in part.keys:
            found.setdefault(key, {"minItems": n, "maxItems": n} | ({"type": lists} if n > 1 else {}))
    return found


def _elements(section: str) -> dict[str, Any]:
    """Return the table of an element; of the kinds that share a section `type` tells which."""
    kinds = kinds_of(section)
    words = {key: shape for kind in kinds.values() for key, shape in _words(kind.parts).items()}
    if len(kinds) == 1:
        (kind,) = kinds.values()
        return {**table_shape(words), "allOf": _rules_of(kind)}
    first, *_ = kinds
    rules = []
    for name, kind in kinds.items():
        own = keys_of(kind.parts)
        this: dict[str, Any] = {"properties": {"type": {"const": name}}}
        this |= {} if name == first else {"required": ["type"]}
        then = {"properties": {key: False for key in words if key not in own}, "allOf": _rules_of(kind)}
        rules.append({"if": this, "then": then})
    return {**table_shape({"type": choice_of(*kinds), **words}), "allOf": rules}


def _rules_of(kind: ForceKind) -> list[Shape]:
    """Return what is so of several keys of an element."""
    needs = [{"anyOf": [{"required": [key]} for key in kind.needs]}] if kind.needs else []
    needed = needed_of(kind.parts)
    return [*needs, *([{"required": needed}] if needed else []), *_rules(kind.parts)]


def _denavit_hartenberg() -> dict[str, Any]:
    """Return the table [dh]; its rows are joints and bodies at once."""
    type_, *_ = place_keys()
    link = _joint([type_, *ROWS], ())
    own = {key: shape for key, shape in _words(_types()).items() if key in LINK_OF_JOINT}
    link["properties"] |= {"name": OWN_NAME, **_words(LINK), **own, **_words(BODY)}
    link["allOf"] += _rules(BODY)
    words = {
        **_words(CHAIN),
        "links": {"description": "one row a joint", "type": "array", "items": link, "minItems": 1},
    }
    return {
        "description": "a chain of joints by its Denavit-Hartenberg parameters",
        **table_shape(words, [*needed_of(CHAIN), "links"]),
    }
