"""Tables of a scene but for joints and what acts: a row a key, from raw values to nouns and back, faults collected."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from fractions import Fraction
from typing import Any

from symdyn.bounds import BOUNDS
from symdyn.errors import choice, suggestion
from symdyn.scene.declaration.reading import read_coherent, read_valued, said_value
from symdyn.scene.values.body import OUTLINES, Body, Outline, Particle
from symdyn.scene.values.description import DESCRIBED
from symdyn.scene.values.dimensional_analysis import fits
from symdyn.scene.values.entry import Entry, EntryReader, as_vector, plain, show, shown, vector
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.joint import acceleration_name, velocity_name
from symdyn.scene.values.key import (
    STATED,
    Key,
    KeyedQuantity,
    KeyGroup,
    Part,
    chosen,
    fields_of,
    flag,
    indexed,
    keys_of,
    number,
    optional,
    placement,
    shape_of,
    word,
)
from symdyn.scene.values.letters import LONGEST, WORDS, Input, Parameter, Tolerance, read_tolerance
from symdyn.scene.values.model import STANDARD_GRAVITY
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Vector
from symdyn.scene.values.shape import (
    NUMBER,
    TEXT,
    VECTOR,
    Shape,
    choice_of,
    described,
    not_both,
    scene_name_shape,
    several,
    table_shape,
)
from symdyn.scene.values.unit import Unit

# Head


def _gravity(table: EntryReader, key: str, usual: Vector) -> Vector:
    raw = table.raw.get(key)
    if raw is False or (isinstance(raw, str) and raw == "none"):
        return NULL
    if key in table and not isinstance(plain(raw), list | tuple):
        table.fault(f"{key} = {show(raw)} is not a vector; {_fall(raw)}")
        return NULL
    return table.vector(key, usual if key not in table else NULL)


def _fall(raw: object) -> str:
    """Return what to write for gravity that is no vector: a letter, a size, or what says that there is none."""
    text = str(raw).strip()
    if text.lower() in ("off", "no", "zero", "0", "0.0", "none"):
        return 'write gravity = "none"'
    size = re.sub(r"^(\d+),(\d+)$", r"\1.\2", text.lstrip("+- "))
    listed = as_vector(size if size[:1].isalpha() else text, "-9.81") or ('[0, 0, "-g"]' if size in ("g", "G") else "")
    if not listed and re.match(r"\d+\.?\d*(e[+-]?\d+)?( ?/ ?\d+)?( ?[a-z°].*)?$", size, re.IGNORECASE):
        with suppress(FormulaError):  # another kind of unit: 1 g is a gram
            fits(quantity(size), Unit.read("m/s^2"))
            bare = re.fullmatch(r"\d+(\.\d+)?(e[+-]?\d+)?", size, re.IGNORECASE)
            listed = f"[0, 0, -{size}]" if bare else f'[0, 0, "-{size}"]'
    return f"write gravity = {listed}" if listed else 'give a vector such as [0, 0, -9.81], or "none"'


def _dimensionless(table: EntryReader, key: str, usual: bool) -> bool:
    raw = table.raw.get(key)
    if raw is not None and raw != "none":
        table.fault(f'{key} = {show(raw)} is not known; write {key} = "none" for no dimensions, or leave it out')
    return raw == "none"


GRAVITY: Key[Vector] = Key(
    "gravity",
    _gravity,
    STANDARD_GRAVITY,
    unit="m/s^2",
    holds='acceleration of free fall in the ground frame, {}; "none" for none',
    said=lambda gravity: "none" if gravity == NULL else gravity,
    shape={"anyOf": [VECTOR, {"enum": [False, "none"]}]},
)

HEAD: tuple[Part, ...] = (
    word("name", "its name, of files and functions too", 'name = "two_link"', shape=scene_name_shape()),
    Key(
        "units",
        _dimensionless,
        False,
        field="dimensionless",
        holds='"none" of a scene without dimensions; else they are checked',
        said=lambda _: "none",
        shape={"const": "none"},
    ),
    DESCRIBED,
    GRAVITY,
)
"""What stands above all tables, in the order in which it is written."""


# Bodies

MOST_PARTICLES = BOUNDS["particles of a body"]
"""Particles of a body; each is a term of every formula, so that more of them are given by their sums."""

INERTIA_KEYS = ("xx", "yy", "zz", "xy", "xz", "yz")

Inertia = tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]

NO_INERTIA: Inertia = (Quantity.ZERO,) * 6


def _com(table: EntryReader, key: str, origin: Vector | None) -> Vector | None:
    return None if "first_moment" in table else table.vector(key)


def _moment(table: EntryReader, key: str, usual: Vector | None) -> Vector | None:
    if key not in table:
        return usual
    if "com" in table:
        table.fault(f"com and {key} give the same quantity; write one of them")
    return table.vector(key)


def _inertia(table: EntryReader, key: str, nothing: Inertia) -> Inertia:
    """Return (xx, yy, zz, xy, xz, yz) from a diagonal, a table of entries or a symmetric matrix."""
    raw = plain(table.raw.get(key, (0, 0, 0)))
    try:
        if isinstance(raw, Mapping):
            for entry in raw:
                if entry not in INERTIA_KEYS:
                    raise FormulaError(f"has an unknown key {show(str(entry))}; {suggestion(str(entry), INERTIA_KEYS)}")
            xx, yy, zz, xy, xz, yz = (quantity(raw.get(entry, 0)) for entry in INERTIA_KEYS)
            return xx, yy, zz, xy, xz, yz
        if not isinstance(raw, (list, tuple)) or len(raw) != 3:
            raise FormulaError(
                "is neither [xx, yy, zz], of a ball [J, J, J], nor a table "
                "{ xx = 1, yy = 1, zz = 1, xy = 0, xz = 0, yz = 0 }"
            )
        if not any(isinstance(row, (list, tuple)) for row in raw):
            return (*vector(raw), Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
        rows = [vector(row) for row in raw]
        if any(rows[i][j] != rows[j][i] for i in range(3) for j in range(i)):
            raise FormulaError("is not symmetric; entry [i][j] must equal entry [j][i]")
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = rows
    except FormulaError as error:
        table.refuse(key, error)
        return nothing
    return xx, yy, zz, xy, xz, yz


def _said_inertia(inertia: Inertia) -> object:
    if not any(entry != Quantity.ZERO for entry in inertia[3:]):
        return inertia[:3]
    return {key: entry for key, entry in zip(INERTIA_KEYS, inertia, strict=True) if entry != Quantity.ZERO}


ABOUT = ("com", "frame")


def _about(table: EntryReader, key: str, usual: str) -> str:
    about = chosen(table, key, "frame" if "first_moment" in table else usual, ABOUT)
    if "inertia" in table and ("com" in table or "first_moment" in table) and key not in table:
        table.fault(f'{key} is missing; write "com" (centre of mass) or "frame" (origin of the body frame)')
    if "first_moment" in table and about == "com":
        table.fault(f'first_moment goes with {key} = "frame"; give com instead, or the inertia about the frame')
    return about


def _says_nothing_about(body: Body) -> bool:
    """Tell whether nothing refers to a point, or to the one that stands in."""
    return body.inertia == NO_INERTIA and body.about == ("com" if body.first_moment is None else "frame")


PARTICLE: tuple[Key[Quantity] | Key[Vector], ...] = (
    number("mass", "kg"),
    Key("at", EntryReader.vector, NULL, unit="m"),
)


def _particles(table: EntryReader, key: str, usual: tuple[Particle, ...]) -> tuple[Particle, ...]:
    raw = table.raw.get(key, ())
    advice = 'give a list such as [{ mass = "m1", at = [0, 0, 0] }]'
    if not isinstance(raw, (list, tuple)):
        table.fault(f"{key} = {show(raw)} is not a list; {advice}")
        return ()
    if len(raw) > MOST_PARTICLES:
        table.fault(f"{key} lists {len(raw)}; {MOST_PARTICLES} are allowed, give mass, com and inertia of all")
        return ()
    particles = []
    for k, item in enumerate(raw):
        if isinstance(item, Particle):
            particles.append(item)
            continue
        if not isinstance(item, Mapping):
            table.fault(f"{key}[{k}] = {show(item)} is not a table; {advice}")
            continue
        row = EntryReader(Entry("", item, f"{table.entry.where}: {key}[{k}]"), table.faults, keys_of(PARTICLE))
        for one in PARTICLE:
            if one.name not in row:
                row.fault(f"{one.name} is missing; {advice}")
        particles.append(Particle(**fields_of(PARTICLE, row)))
    return tuple(particles)


def _outline(table: EntryReader, key: str, usual: Outline | None) -> Outline | None:
    raw = plain(table.raw.get(key, usual))
    if raw is None or isinstance(raw, Outline):
        return raw
    given: Mapping[str, object] = raw if isinstance(raw, Mapping) else {"type": raw}
    if not isinstance(given.get("type"), str) or given["type"] not in OUTLINES:
        told = f"{choice(given.get('type'), OUTLINES)}, or a table with such a type and sizes"
        table.fault(f"{key} = {show(raw)} is not known; {told}")
        return None
    kind = OUTLINES[str(given["type"])]
    keys = ("type", *(() if kind.axis is None else ("axis",)), *kind.sizes)
    row = EntryReader(Entry("", given, f"{table.entry.where}: {key}"), table.faults, keys)
    sizes = tuple((size, row.quantity(size)) for size in kind.sizes if size in row)
    for size, length in sizes:
        if isinstance(length.value, Fraction) and length.value <= 0:
            row.fault(f"{size} = {shown(length)} is no length; give one above zero")
    bare = INERTIA.declared(table) == NO_INERTIA or MASS.declared(table) == Quantity.ZERO
    if bare and len(sizes) < len(kind.sizes):
        row.fault(f"{' and '.join(kind.sizes)} missing, and no inertia to compute them from; write them beside type")
    axis = row.vector("axis") if "axis" in row else None
    if axis is not None and (any(x.symbols for x in axis) or axis == NULL):
        row.fault("axis is no direction in numbers; give one such as [0, 0, 1]")
        axis = None
    return Outline(str(given["type"]), sizes, axis)


def _said_outline(outline: Outline | None) -> object:
    assert outline is not None, "what is none is not written"
    more = dict(outline.sizes) | ({"axis": outline.axis} if outline.axis else {})
    return {"type": outline.type, **more} if more else outline.type


def _outline_shapes() -> Iterator[Shape]:
    for name, kind in OUTLINES.items():
        axis = {} if kind.axis is None else {"axis": VECTOR}
        yield table_shape({"type": {"const": name}, **dict.fromkeys(kind.sizes, NUMBER), **axis}, ["type"])


class _OutlineKey(Key[Outline | None]):
    """The key of what a body looks like, whose sizes are called as its type has them."""

    def numbers(self, one: Body, slides: bool = True) -> Iterator[KeyedQuantity]:
        """Return its sizes and the numbers of its axis."""
        outline = one.shape
        if outline is not None:
            yield from (KeyedQuantity(f"{self.name}.{size}", x, unit="m") for size, x in outline.sizes)
            yield from (KeyedQuantity(f"{self.name}.axis{index}", x) for index, x in indexed(outline.axis))


MASS = number("mass", "kg", names=STATED)

INERTIA = Key(
    "inertia",
    _inertia,
    NO_INERTIA,
    unit="kg m^2",
    names=STATED,
    holds="{}: [xx, yy, zz], a symmetric matrix, or a table of matrix entries",
    said=_said_inertia,
    shape={"anyOf": [VECTOR, several(VECTOR, 3), table_shape(dict.fromkeys(INERTIA_KEYS, NUMBER))]},
)

_BODY: tuple[Key[Any], ...] = (
    MASS,
    Key("com", _com, NULL, unit="m", text="centre of mass in the body frame", shape=VECTOR),
    Key(
        "first_moment", _moment, None, unit="kg m", holds="mass times centre of mass, {}, in place of com", shape=VECTOR
    ),
    INERTIA,
    Key(
        "inertia_about",
        _about,
        "com",
        field="about",
        silent=_says_nothing_about,
        holds="what the inertia refers to: centre of mass or origin of the frame",
        shape=choice_of(*ABOUT),
        rules=(
            *(
                {"if": {"required": ["inertia", centre]}, "then": {"required": ["inertia_about"]}}
                for centre in ("com", "first_moment")
            ),
            {"if": {"required": ["first_moment"]}, "then": {"properties": {"inertia_about": choice_of("frame")}}},
            *not_both([("com", "first_moment")]),
        ),
    ),
    Key(
        "particles",
        _particles,
        (),
        inside=PARTICLE,
        holds="point masses of the body",
        said=lambda particles: [{key.name: key.of(one) for key in PARTICLE} for one in particles],
        shape=several(shape_of(PARTICLE, keys_of(PARTICLE)), 0, MOST_PARTICLES),
    ),
    flag("allow_invalid_inertia", "accept an inertia that is not physically consistent"),
    _OutlineKey(
        "shape",
        _outline,
        None,
        holds="its shape in pictures, where it is not to be computed from its inertia",
        said=_said_outline,
        shape={"anyOf": [choice_of(*OUTLINES), *_outline_shapes()]},
    ),
)

BODY: tuple[Part, ...] = (*_BODY, DESCRIBED)
"""What tables of bodies say, in the order in which they are written."""


# Parameters, inputs, outputs, points


def _value_and_unit(told: str, usual: Quantity | None) -> KeyGroup:
    """Return the keys of the value of a letter and of its unit, which are read together."""

    def read(table: EntryReader, scope: object) -> dict[str, Any]:
        found = read_valued(table)
        value = usual if found.value is None else found.value
        return {"value": value, "unit": found.unit, "written": found.written}

    def said(letter: Parameter | Input, scope: object) -> dict[str, object]:
        value, unit = said_value(letter)
        return ({} if value == usual else {"value": value}) | ({"unit": unit} if unit else {})

    unit = described("of its value, such as mm, kg or N/m: a bare number is in it", TEXT)
    return KeyGroup({"value": described(told, NUMBER), "unit": unit}, read, said)


def _tolerance(table: EntryReader, key: str, usual: Tolerance | None) -> Tolerance | None:
    if key not in table:
        return usual
    found = read_valued(table)
    return table.parsed(key, usual, lambda raw: read_tolerance(raw, found.written or found.unit))


TOLERANCE: Shape = {
    "anyOf": [
        {"type": "number", "exclusiveMinimum": 0},
        {"type": "string", "maxLength": LONGEST, "pattern": r"^[^0-9]*[0-9.]"},
    ]
}

LATEX = Key("latex", optional(EntryReader.text), None, holds="its symbol in printed equations", shape=TEXT)

PARAMETER: tuple[Part, ...] = (
    _value_and_unit("its value; without one it is an argument of generated functions", None),
    flag("positive", "whether it is above zero whatever its value, so that forms get shorter"),
    Key(
        "tolerance",
        _tolerance,
        None,
        holds='how far the value may be off, for sweeps: "5 %" of it, "0.1 mm", 0.02; or { sigma = .. }, a deviation',
        said=lambda one: one and ({"sigma": one.text} if one.sigma else one.text),
        shape={"anyOf": [TOLERANCE, *(table_shape({one: TOLERANCE}, (one,)) for one in WORDS)]},
    ),
    LATEX,
    DESCRIBED,
)

MOST_RATES = 2
"""Rates of an input: what moves with it has a velocity and an acceleration."""


def _rates(table: EntryReader, key: str, usual: int) -> int:
    raw = table.raw.get(key, usual)
    if not isinstance(raw, int) or isinstance(raw, bool) or not 0 <= raw <= MOST_RATES:
        table.fault(f"{key} = {show(raw)} is none of 0, 1, 2; write {key} = 2 where it moves a joint, 1 for a spring")
        return usual
    return raw


INPUT: tuple[Part, ...] = (
    _value_and_unit("its value where none is given over time; zero when left out", Quantity.ZERO),
    Key(
        "rates",
        _rates,
        0,
        holds="how many of its rates, NAME_dot and NAME_ddot, are inputs too",
        said=Quantity.number,
        shape={"type": "integer", "minimum": 0, "maximum": MOST_RATES},
    ),
    LATEX,
    DESCRIBED,
)


def with_rates(inputs: Iterable[Input]) -> Iterator[tuple[int, Input]]:
    """Yield declared inputs and behind each its rates, with the number of the declared one; its text tells of all."""
    for k, one in enumerate(inputs):
        yield k, one
        of, name, unit = one.name, velocity_name(one.name), one.unit
        for order in range(1, one.rates + 1):
            unit = one.unit and f"{one.unit}/s" + (f"^{order}" if order > 1 else "")
            yield k, Input(name, unit=unit, of=of)
            of, name = name, acceleration_name(name)


OUTPUT: tuple[Part, ...] = (
    number(
        "formula",
        example='what is looked at, such as formula = "point_tip_x"',
        holds="of coordinates, rates, points, reactions, inputs, parameters and t",
    ),
    Key("unit", read_coherent, "", holds="of SI, for tables, comments and axes of plots", shape=TEXT),
    DESCRIBED,
)

POINT: tuple[Part, ...] = (
    word("body", "name of the body that carries it", "the body that carries the point"),
    placement("at", "placement in the frame of the body"),
)

SHORT: Mapping[str, str] = {"parameters": "value", "inputs": "value", "outputs": "formula", "signals": "formula"}
"""What a number or text in place of a table says; names of such tables are those of letters or of columns."""
