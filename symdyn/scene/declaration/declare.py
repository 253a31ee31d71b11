"""From raw tables to a checked scene: the one way that TOML files, Denavit-Hartenberg tables and Python all take.

Bodies as tables: raw keys to `Body`, every fault collected.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypedDict

from symdyn.bounds import BOUNDS
from symdyn.scene.declaration.coupling import lock, read_locks
from symdyn.scene.declaration.dh import BODY_KEYS, expand
from symdyn.scene.declaration.draft import Draft
from symdyn.scene.declaration.joint_table import joint_keys, read_joints, read_loops
from symdyn.scene.declaration.reading import Reading, ReadOptions, read_coherent, read_valued
from symdyn.scene.declaration.spanning import span, turned
from symdyn.scene.declaration.whole_scene import check
from symdyn.scene.forces.force_kind import Scope
from symdyn.scene.forces.force_table import read_elements
from symdyn.scene.values.body import Body, Outline, Particle
from symdyn.scene.values.entry import Entry, EntryReader, Faults, plain, show, shown, vector
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.model import STANDARD_GRAVITY, Input, Parameter, Point, Scene, Signal
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.outline import OUTLINES
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Vector

MOST_PARTICLES = BOUNDS["particles of a body"]
"""Particles of a body; each is a term of every formula, so that more of them are given by their sums."""

INERTIA_KEYS = ("xx", "yy", "zz", "xy", "xz", "yz")


def read_body(entry: Entry, faults: Faults) -> Body:
    """Return a declared body."""
    table = EntryReader(entry, faults, BODY_KEYS if not entry.where.startswith("dh.") else tuple(entry.table))
    about = table.text("inertia_about", "frame" if "first_moment" in table else "com")
    if about not in ("com", "frame"):
        table.fault(f'inertia_about = "{about}" is not known; write "com" or "frame"')
    elif "inertia" in table and "inertia_about" not in table:
        table.fault('inertia_about is missing; write "com" (centre of mass) or "frame" (origin of the body frame)')
    if "first_moment" in table:
        if "com" in table:
            table.fault("com and first_moment say the same thing twice; give one of them")
        if about == "com":
            table.fault(
                'first_moment goes with inertia_about = "frame"; give com instead, or the inertia about the frame'
            )
    return Body(
        name=entry.name,
        mass=table.quantity("mass"),
        com=None if "first_moment" in table else table.vector("com"),
        first_moment=table.vector("first_moment") if "first_moment" in table else None,
        inertia=_inertia(table),
        about=about,
        particles=_particles(table, faults),
        allow_invalid_inertia=table.flag("allow_invalid_inertia"),
        shape=_shape(table, faults) if "shape" in table else None,
    )


def _inertia(table: EntryReader) -> tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]:
    """Return (xx, yy, zz, xy, xz, yz) from a diagonal, a table of entries or a symmetric matrix."""
    nothing = (Quantity.ZERO,) * 6
    raw = plain(table.raw.get("inertia", (0, 0, 0)))
    try:
        if isinstance(raw, Mapping):
            for key in raw:
                if key not in INERTIA_KEYS:
                    raise FormulaError(f"has an unknown key {show(str(key))}; {suggestion(str(key), INERTIA_KEYS)}")
            xx, yy, zz, xy, xz, yz = (quantity(raw.get(key, 0)) for key in INERTIA_KEYS)
            return xx, yy, zz, xy, xz, yz
        if not isinstance(raw, (list, tuple)) or len(raw) != 3:
            raise FormulaError("is neither [xx, yy, zz] nor a table { xx = 1, yy = 1, zz = 1, xy = 0, xz = 0, yz = 0 }")
        if not any(isinstance(row, (list, tuple)) for row in raw):
            return (*vector(raw), Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
        rows = [vector(row) for row in raw]
        if any(rows[i][j] != rows[j][i] for i in range(3) for j in range(i)):
            raise FormulaError("is not symmetric; entry [i][j] must equal entry [j][i]")
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = rows
    except FormulaError as error:
        table.refuse("inertia", error)
        return nothing
    return xx, yy, zz, xy, xz, yz


def _shape(table: EntryReader, faults: Faults) -> Outline | None:
    """Return what a body looks like, from a word or a table with sizes."""
    raw = plain(table.raw["shape"])
    if isinstance(raw, Outline):
        return raw
    given: Mapping[str, object] = raw if isinstance(raw, Mapping) else {"type": raw}
    if not isinstance(given.get("type"), str) or given["type"] not in OUTLINES:
        known = ", ".join(f'"{word}"' for word in OUTLINES)
        table.fault(f"shape = {show(raw)} is not known; write one of {known}, or a table with such a type")
        return None
    kind = OUTLINES[str(given["type"])]
    keys = ("type", *(() if kind.axis is None else ("axis",)), *kind.sizes)
    row = EntryReader(Entry("", given, f"{table.entry.where}: shape"), faults, keys)
    sizes = tuple((size, row.quantity(size)) for size in kind.sizes if size in row)
    for size, length in sizes:
        if isinstance(length.value, Fraction) and length.value <= 0:
            row.fault(f"{size} = {shown(length)} is no length; give one above zero")
    bare = all(entry == Quantity.ZERO for entry in _inertia(table)) or table.quantity("mass") == Quantity.ZERO
    if bare and len(sizes) < len(kind.sizes):
        row.fault(f"{' and '.join(kind.sizes)} missing, which no inertia tells; write them beside type")
    axis = row.vector("axis") if "axis" in row else None
    if axis is not None and (any(x.symbols for x in axis) or axis == NULL):
        row.fault("axis is no direction in numbers; give one such as [0, 0, 1]")
        axis = None
    return Outline(str(given["type"]), sizes, axis)


def _particles(table: EntryReader, faults: Faults) -> tuple[Particle, ...]:
    raw = table.raw.get("particles", ())
    advice = 'give a list such as [{ mass = "m1", at = [0, 0, 0] }]'
    if not isinstance(raw, (list, tuple)):
        table.fault(f"particles = {show(raw)} is not a list; {advice}")
        return ()
    if len(raw) > MOST_PARTICLES:
        table.fault(
            f"particles lists {len(raw)}; {MOST_PARTICLES} are allowed, give the mass, com and inertia of all together"
        )
        return ()
    particles = []
    for k, item in enumerate(raw):
        if isinstance(item, Particle):
            particles.append(item)
            continue
        if not isinstance(item, Mapping):
            table.fault(f"particles[{k}] = {show(item)} is not a table; {advice}")
            continue
        row = EntryReader(Entry("", item, f"{table.entry.where}: particles[{k}]"), faults, ("mass", "at"))
        for key in ("mass", "at"):
            if key not in row:
                row.fault(f"{key} is missing; {advice}")
        particles.append(Particle(row.quantity("mass"), row.vector("at")))
    return tuple(particles)


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
    return EntryReader(Entry("", {"gravity": raw}, ""), faults, ("gravity",)).vector("gravity")


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
    table = EntryReader(entry, faults, PARAMETER_KEYS)
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
    table = EntryReader(entry, faults, INPUT_KEYS)
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
    table = EntryReader(entry, faults, OUTPUT_KEYS)
    if "formula" not in table:
        table.fault('formula is missing; write what is looked at, such as formula = "point_tip_x"')
    return Signal(entry.name, table.quantity("formula"), read_coherent(table), **_described(table))


def _described(table: EntryReader) -> _Described:
    """Return `text` and `texts` of what a row says it is, in one language or in several."""
    raw = table.raw.get("text", "")
    if not isinstance(raw, dict):
        return {"text": table.text("text"), "texts": ()}
    if not raw or not all(LANGUAGE.fullmatch(code) for code in raw):
        table.fault(f'text = {show(raw)} names languages by two letters, such as {{ en = "mass", sk = "hmotnosť" }}')
        return {"text": "", "texts": ()}
    each = EntryReader(Entry(table.entry.name, raw, f"{table.entry.where}.text"), table.faults, tuple(raw))
    said = {code: each.text(code) for code in raw}
    first = "en" if "en" in said else next(iter(said))
    return {"text": said[first], "texts": tuple((code, text) for code, text in said.items() if code != "en")}


def _point(entry: Entry, faults: Faults) -> Point:
    table = EntryReader(entry, faults, POINT_KEYS)
    return Point(entry.name, table.required("body", "write the body that carries the point"), table.pose("at"))
