"""From raw tables to a checked scene: the one way that TOML files, Denavit-Hartenberg tables and Python all take."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypedDict

from symdyn.scene.checks.draft import Draft
from symdyn.scene.checks.whole_scene import check
from symdyn.scene.declaration.body_table import read_body
from symdyn.scene.declaration.dh import BODY_KEYS, expand
from symdyn.scene.declaration.joint_table import joint_keys, read_joints, read_loops
from symdyn.scene.declaration.locking import lock, read_locks
from symdyn.scene.declaration.reading import Reading, ReadOptions
from symdyn.scene.declaration.spanning import span, turned
from symdyn.scene.declaration.value_in_unit import read_coherent, read_valued
from symdyn.scene.forces.force_kind import Scope
from symdyn.scene.forces.force_table import read_elements
from symdyn.scene.values.model import STANDARD_GRAVITY, Input, Parameter, Point, Scene, Signal
from symdyn.scene.values.quantity import NULL, Quantity, Vector
from symdyn.scene.values.table import Entry, Faults, Table, show

LANGUAGE = re.compile("[a-z]{2}")

PARAMETER_KEYS = ("value", "positive", "unit", "tolerance", "latex", "text")

POINT_KEYS = ("body", "at")

INPUT_KEYS = ("value", "unit", "latex", "text")

OUTPUT_KEYS = ("formula", "unit", "text")

TABLE_KEYS: Mapping[str, tuple[str, ...]] = {
    "parameters": PARAMETER_KEYS,
    "bodies": BODY_KEYS,
    "joints": joint_keys(),
    "points": POINT_KEYS,
    "inputs": INPUT_KEYS,
    "outputs": OUTPUT_KEYS,
}
"""The tables of a scene but those of elements, and their words."""


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
        more_bodies, more_joints = expand(declaration.dh, faults)
        bodies, joints = bodies + more_bodies, joints + more_joints
    held = [str(entry.table.get("joint")) for entries in declaration.elements.values() for entry in entries]
    spanned = span(joints, held, spanning_tree, faults)
    points = tuple(_point(entry, faults) for entry in declaration.points)
    named = {point.name: point for point in points}
    loops = (*declaration.loops, *spanned.cut)
    parameters = tuple(_parameter(entry, faults) for entry in declaration.parameters)
    gravity = _gravity(declaration.gravity, faults)
    scene = Scene(
        name=declaration.name,
        parameters=parameters,
        gravity=gravity,
        bodies=tuple(read_body(entry, faults) for entry in bodies),
        joints=tuple(
            turned(joint) if joint.name in spanned.turned else joint for joint in read_joints(spanned.joints, faults)
        ),
        points=points,
        loops=read_loops(loops, faults),
        inputs=tuple(_input(entry, faults) for entry in declaration.inputs),
        outputs=tuple(_output(entry, faults) for entry in declaration.outputs),
        dimensionless=_dimensionless(declaration.units, faults) or dimensionless,
        source=source,
    )
    elements = read_elements(declaration.elements, Scope(named, gravity, parameters), faults)
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


def _gravity(raw: object, faults: Faults) -> Vector:
    if raw is None:
        return STANDARD_GRAVITY
    if raw is False or (isinstance(raw, str) and raw == "none"):
        return NULL
    advice = 'give a vector such as [0, 0, -9.81], or "none"'
    if raw is True or isinstance(raw, str):
        faults.add("", f"gravity = {show(raw)} is not a vector; {advice}")
        return NULL
    return Table(Entry("", {"gravity": raw}, ""), faults, ("gravity",)).vector("gravity")


def _dimensionless(raw: object, faults: Faults) -> bool:
    if raw is not None and raw != "none":
        faults.add(
            "", f'units = {show(raw)} is not known; write units = "none" in a scene without dimensions, or leave it out'
        )
    return raw == "none"


class _Described(TypedDict):
    text: str
    texts: tuple[tuple[str, str], ...]


def _parameter(entry: Entry, faults: Faults) -> Parameter:
    table = Table(entry, faults, PARAMETER_KEYS)
    said = read_valued(table)
    return Parameter(
        name=entry.name,
        value=said.value,
        positive=table.flag("positive"),
        unit=said.unit,
        latex=table.text("latex") if "latex" in table else None,
        tolerance=table.tolerance(said.written or said.unit),
        written=said.written,
        **_described(table),
    )


def _input(entry: Entry, faults: Faults) -> Input:
    table = Table(entry, faults, INPUT_KEYS)
    said = read_valued(table)
    return Input(
        name=entry.name,
        value=said.value or Quantity.ZERO,
        unit=said.unit,
        written=said.written,
        latex=table.text("latex") if "latex" in table else None,
        **_described(table),
    )


def _output(entry: Entry, faults: Faults) -> Signal:
    table = Table(entry, faults, OUTPUT_KEYS)
    if "formula" not in table:
        table.fault('formula is missing; write what is looked at, such as formula = "point_tip_x"')
    return Signal(entry.name, table.quantity("formula"), read_coherent(table), **_described(table))


def _described(table: Table) -> _Described:
    """Return `text` and `texts` of what a row says it is, in one language or in several."""
    raw = table.raw.get("text", "")
    if not isinstance(raw, dict):
        return {"text": table.text("text"), "texts": ()}
    if not raw or not all(LANGUAGE.fullmatch(code) for code in raw):
        table.fault(f'text = {show(raw)} names languages by two letters, such as {{ en = "mass", sk = "hmotnosť" }}')
        return {"text": "", "texts": ()}
    each = Table(Entry(table.entry.name, raw, f"{table.entry.where}.text"), table.faults, tuple(raw))
    said = {code: each.text(code) for code in raw}
    first = "en" if "en" in said else next(iter(said))
    return {"text": said[first], "texts": tuple((code, text) for code, text in said.items() if code != "en")}


def _point(entry: Entry, faults: Faults) -> Point:
    table = Table(entry, faults, POINT_KEYS)
    return Point(entry.name, table.required("body", "write the body that carries the point"), table.pose("at"))
