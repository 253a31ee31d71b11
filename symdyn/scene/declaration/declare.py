"""From raw tables to a checked scene: the one way that TOML files, Denavit-Hartenberg tables and Python all take.

Denavit-Hartenberg tables are a compact way to write a chain of joints.

    standard   A_i = Rz(θ) Tz(d) Tx(a) Rx(α)                 link frame at the far end of its link
    modified   A_i = Rx(α) Tx(a) Rz(θ) Tz(d)                 a, α of row i are the book's a_(i-1), α_(i-1) (Craig)

The joint moves along or about its z axis: θ = theta + q for a revolute joint, d = d + q for a prismatic one, so theta
or d in a row is the offset of the coordinate. Rotation and shift along one axis commute, so both stand in the origin;
Tx(a) Rx(α) of a standard table is the tip. Body frames are the link frames of the table.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from symdyn.scene.declaration.coupling import lock, read_locks
from symdyn.scene.declaration.draft import Draft
from symdyn.scene.declaration.joint_table import PARENT, ROWS, read_joints, read_loops
from symdyn.scene.declaration.reading import Reading, ReadOptions
from symdyn.scene.declaration.scene_table import BODY, HEAD, INPUT, OUTPUT, PARAMETER, POINT
from symdyn.scene.declaration.spanning import span, turned
from symdyn.scene.declaration.whole_scene import check
from symdyn.scene.forces.force_kind import Scope
from symdyn.scene.forces.force_table import read_elements
from symdyn.scene.values.body import Body
from symdyn.scene.values.entry import Entry, EntryReader, Faults, compose, plain, show
from symdyn.scene.values.key import Key, Part, fields_of, keys_of, number, one_of, word
from symdyn.scene.values.model import Input, Parameter, Point, Scene, Signal
from symdyn.scene.values.quantity import Quantity

SECTIONS: Mapping[str, Sequence[Part]] = {
    "parameters": PARAMETER,
    "bodies": BODY,
    "joints": ROWS,
    "points": POINT,
    "inputs": INPUT,
    "outputs": OUTPUT,
}
"""The tables of a scene but those of elements, and their keys; of joints those that all types share."""


@dataclass(frozen=True)
class Declaration:
    """A scene as raw as the user wrote it.

    Attributes:
        name: of the scene.
        gravity: raw value; None for the standard 9.81 m/s^2 along -z, False or "none" for no gravity.
        parameters, bodies, joints, points, inputs, outputs: declared tables.
        loops: declared joints that close loops.
        elements: declared tables of what acts, by section.
        dh: a Denavit-Hartenberg table.
        units: raw value; "none" for a scene that is without dimensions on purpose.
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
    units: object = None


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
    points = _nouns(Point, POINT, declaration.points, faults)
    named = {point.name: point for point in points}
    loops = (*declaration.loops, *spanned.cut)
    parameters = _nouns(Parameter, PARAMETER, declaration.parameters, faults)
    head = _head(declaration, faults)
    scene = Scene(
        name=declaration.name,
        parameters=parameters,
        gravity=head["gravity"],
        bodies=_nouns(Body, BODY, bodies, faults),
        joints=tuple(
            turned(joint) if joint.name in spanned.turned else joint for joint in read_joints(spanned.joints, faults)
        ),
        points=points,
        loops=read_loops(loops, faults),
        inputs=_nouns(Input, INPUT, declaration.inputs, faults),
        outputs=_nouns(Signal, OUTPUT, declaration.outputs, faults),
        dimensionless=head["dimensionless"] or dimensionless,
        source=source,
    )
    elements = read_elements(declaration.elements, Scope(named, scene.gravity, parameters), faults)
    scene = replace(scene, elements=tuple(one for _, one in elements))
    places = {"bodies": bodies, "joints": spanned.joints, "loops": loops}
    places |= {kind: getattr(declaration, kind) for kind in ("parameters", "points", "inputs", "outputs")}
    where = {kind: tuple(entry.where for entry in entries) for kind, entries in places.items()}
    draft = Draft(scene, where | {"elements": tuple(place for place, _ in elements)})
    positions = read_locks(joints, faults)
    _note_friction(scene, faults)
    excused = check(draft, faults, allow_invalid_inertia)
    faults.close()
    carried = {body.name: body for body in scene.bodies}
    carried |= {name: replace(carried[name], allow_invalid_inertia=True) for name in excused}
    ordered = replace(scene, bodies=tuple(carried[joint.child] for joint in scene.joints))
    return lock(ordered, positions, faults) if positions else ordered


def _note_friction(scene: Scene, faults: Faults) -> None:
    """Note the joints whose friction is a plain number, which does not act."""
    names = [joint.name for joint in scene.joints if joint.friction != Quantity.ZERO]
    if names:
        found = f"friction is kept as data and enters no equation ({', '.join(names)})"
        faults.note("", f"{found}; a scene says friction = {{ coulomb = 0.5, smoothing = 0.01 }} to have it act")


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
"""What a row says: of itself, of its joint, and of its body."""


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
