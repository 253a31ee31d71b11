"""Keys of joint types and of elements as data: how they are read and written, checked, and called as parameters.

Shapes of raw values as JSON Schema, for editors: what a reader of the same word takes without looking at the rest.

number      a number, a formula, a number and a unit, or a table of both       vector   three of them
placement   {xyz, rpy}, [x, y, z], or elementary steps such as ["Tz", 0.1]
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from keyword import kwlist
from typing import Any, Generic, TypeVar

from symdyn.graph import Graph
from symdyn.scene.values.body import ELEMENTARY
from symdyn.scene.values.dimension import product
from symdyn.scene.values.entry import EntryReader, Faults, plain, shown
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.grammar import LONGEST_WORDS
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.made_names import Names
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import C_KEYWORDS, CLOCK, FORMULA_NAMES, LONGEST, listed
from symdyn.scene.values.quantity import FormulaError, Quantity, Value, Vector
from symdyn.scene.values.unit import Unit

Shape = Mapping[str, Any]

FORMULA: Shape = {"type": "string", "pattern": r"^[A-Za-z0-9_+\-*/()., \t\n]*[A-Za-z0-9][A-Za-z0-9_+\-*/()., \t\n]*$"}
VALUE: Shape = {
    "type": "string",
    "pattern": r"^\s*[+-]?\s*[0-9.][0-9.eE+\-/ ]*\(?[A-Za-zµμΩΩ°%][A-Za-z0-9µμΩΩ°%⁰¹²³⁴⁵⁶⁷⁸⁹⁻·⋅×*/^() \-]*$",
}
VALUED: Shape = {
    "type": "object",
    "properties": {"value": {"anyOf": [{"type": "number"}, FORMULA, VALUE]}, "unit": {"type": "string"}},
    "required": ["value"],
    "additionalProperties": False,
}
NUMBER: Shape = {"anyOf": [{"type": "number"}, FORMULA, VALUE, VALUED]}
NUMBERS: Shape = {"anyOf": [*NUMBER["anyOf"], {"type": "array", "items": NUMBER, "minItems": 1}]}
FLAG: Shape = {"type": "boolean"}
TEXT: Shape = {"type": "string", "maxLength": LONGEST_WORDS, "pattern": r"^[^\x00-\x1f\x7f]*$"}
NAMED: Shape = {**TEXT, "minLength": 1}
ANYTHING: Shape = {}


def several(shape: Shape, least: int, most: int | None = None) -> Shape:
    """Return a list of one shape; of exactly `least` where `most` is left out."""
    return {"type": "array", "items": shape, "minItems": least, "maxItems": least if most is None else most}


VECTOR: Shape = several(NUMBER, 3)


def choice_of(*words: str) -> Shape:
    """Return one of some words."""
    return {"enum": list(words)}


def table_shape(words: Mapping[str, Shape], required: Sequence[str] = ()) -> dict[str, Any]:
    """Return a table of these words and no others."""
    made: dict[str, Any] = {"type": "object", "properties": dict(words), "additionalProperties": False}
    return made | ({"required": list(required)} if required else {})


PLACEMENT: Shape = {
    "anyOf": [
        VECTOR,
        table_shape({"xyz": VECTOR, "rpy": VECTOR}),
        {
            "type": "array",
            "items": {
                "type": "array",
                "prefixItems": [choice_of(*ELEMENTARY), NUMBER],
                "minItems": 2,
                "maxItems": 2,
            },
        },
    ]
}


def exactly_one(*groups: Sequence[str]) -> dict[str, Any]:
    """Return that the words of one group are given, and none of the others."""
    every = [word for group in groups for word in group]
    return {
        "oneOf": [
            {"required": list(group), "properties": {word: False for word in every if word not in group}}
            for group in groups
        ]
    }


def not_both(pairs: Iterable[tuple[str, str]]) -> list[dict[str, Any]]:
    """Return that two words that say the same thing are not given together."""
    return [{"not": {"required": [one, other]}} for one, other in pairs]


def scene_name_shape() -> Shape:
    """Return the name of a scene, as `check_scene_name` judges it."""
    return {"type": "string", "pattern": rf"^[A-Za-z][A-Za-z0-9_]{{0,{LONGEST - 1}}}$"}


def name_shape(letter: bool = False) -> Shape:
    """Return a name that every target can print, as `check_name` judges it; a `letter` is one of formulas."""
    taken = [*kwlist, *C_KEYWORDS, *FORMULA_NAMES, *([CLOCK] if letter else [])]
    spelled = {"pattern": scene_name_shape()["pattern"]}
    return {"type": "string", "allOf": [spelled, {"not": {"pattern": r"_d?dot$"}}, {"not": {"enum": taken}}]}


T = TypeVar("T")

PARAMETERS, MOTION, TIMED = range(3)
"""What a formula may name: parameters alone, coordinates and velocities too, and t too."""


@dataclass(frozen=True)
class Stand:
    """Where a joint or an element stands while it is checked.

    Attributes:
        where: for messages.
        scene: in declared order, not yet checked.
        values: of its parameters.
        faults: takes what is wrong.
    """

    where: str
    scene: Scene
    values: Mapping[str, Value]
    faults: Faults

    def fault(self, what: str) -> None:
        """Report a fault of this joint or element."""
        self.faults.add(self.where, what)

    def value(self, quantity: Quantity) -> Value | None:
        """Return a value as far as it is known; a formula without one is reported as such."""
        return quantity.known_at(self.values)

    def direction(self, key: str, axis: Vector, tilt: str = "tilt by origin.rpy") -> bool:
        """Report a direction that has no length, or depends on symbols (`tilt` says what may); else return true."""
        text = f"{key} = [{', '.join(shown(x) for x in axis)}]"
        names = dict.fromkeys(name for x in axis for name in x.symbols)
        if names:
            self.fault(f"{text} depends on {listed(names)}; give numbers, and {tilt} instead")
            return False
        try:
            sizes = [(x.express(Graph()).is_zero, x.at({})) for x in axis]
        except (FormulaError, ZeroDivisionError):
            self.fault(f"{text} divides by zero, or has no real value; give a direction such as [0, 0, 1]")
            return False
        if all(zero or size == 0 for zero, size in sizes):
            self.fault(f"{text} has zero length; give a direction such as [0, 0, 1]")
            return False
        return True


@dataclass(frozen=True)
class Key(Generic[T]):
    """One thing that joints of a type, or elements of a kind, say beside what all of them say.

    Its value is a number, several of them, a direction, text, a tuple of texts, or steps in a joint's coordinates.

    Attributes:
        name: as scenes write it; an element has a field of that name.
        read: its value from a table, its name, and what stands in where nothing is said, or after a fault.
        default: its value where it is left out.
        example: what to write where it must be given; "" where it may be left out, or the kind tells.
        silent: whether a noun has its value without saying so, where the default does not decide.
        above_zero: what a number of zero or less is, and what to give instead; "" where it may be any.
        letters: of the parameters that stand for its numbers, one, or one an axis; () for none.
        unit: of its numbers; two of them at a joint that turns, and at one that slides or between two points.
        each: what the unit of a coefficient is divided by to get that of the next one, likewise.
        text: what they are, the name of what has them in place of {}.
        positive: whether such a parameter is the size of a number and the sign stands in front.
        geometry: whether it is a length of the mechanism, not a force.
        names: what its formulas may name; None of a direction, which is checked with what it directs.
        turned: of a direction, whether it is in the moved joint frame.
        shape: of its raw value, where its reader is none of those in `SHAPES`; None leaves that open.
    """

    name: str
    read: Callable[[EntryReader, str, T], T]
    default: T
    example: str = ""
    silent: Callable[[Any], bool] | None = None
    above_zero: str = ""
    letters: tuple[str, ...] = ()
    unit: str | tuple[str, str] = ""
    each: tuple[str, str] = ("", "")
    text: str = ""
    positive: bool = False
    geometry: bool = False
    names: int | None = PARAMETERS
    turned: bool = False
    shape: Shape | None = None

    @property
    def words(self) -> Mapping[str, Shape]:
        """Its raw value as JSON Schema, and what it is, by the key."""
        units = self.unit if isinstance(self.unit, str) else " or ".join(self.unit)
        told = ", ".join(part for part in (self.text.removesuffix(" of {}").replace(" of {}", ""), units) if part)
        shape = SHAPES.get(self.read, ANYTHING) if self.shape is None else self.shape
        return {self.name: {"description": told, **shape} if told else shape}

    @property
    def rules(self) -> Sequence[Shape]:
        """What is so of several keys: nothing, of one."""
        return []

    @property
    def keys(self) -> tuple[str, ...]:
        """The key, as a part of the table of an element."""
        return (self.name,)

    def of(self, one: Any) -> T:
        """Return what a joint or an element says."""
        value: T = (dict(one.shape) if isinstance(one, Joint) else vars(one)).get(self.name, self.default)
        return value

    def declared(self, table: EntryReader) -> T:
        """Return what a table says; a key that must be given and is not is a fault."""
        if self.example and self.name not in table:
            table.fault(f"{self.name} is missing; write {self.example}")
        return self.read(table, self.name, self.default)

    def fields(self, table: EntryReader, scope: object) -> dict[str, Any]:
        """Return the field of an element."""
        return {self.name: self.declared(table)}

    def raw(self, one: Any, scope: object) -> dict[str, object]:
        """Return what the table of an element says, nothing where the default says it; of one number no list."""
        value: Any = self.of(one)
        if self.silent(one) if self.silent else value == self.default:
            return {}
        alone = isinstance(value, tuple) and len(value) == 1 and isinstance(value[0], Quantity)
        return {self.name: value[0] if alone else value}

    def numbers(self, one: Any) -> Iterator[tuple[str, Quantity, int]]:
        """Return its quantities, and what they may name."""
        if self.names is not None:
            yield from ((f"{self.name}{index}", x, self.names) for index, x in indexed(self.of(one)))

    def unit_at(self, k: int, slides: bool) -> str:
        """Return the unit of the k-th of its numbers, "" where it is not known; of components all are alike."""
        unit, each = self.unit if isinstance(self.unit, str) else self.unit[slides], self.each[slides]
        if not (k and unit and each):
            return unit
        return product(list((Unit.read(unit) * Unit.read(each) ** -k).coherent))

    def named(self, one: Any, what: str, letter: str, k: int | str, names: Names, slides: bool = False) -> Any:
        """Return the k-th noun of its like with names in place of the numbers of this key; see `Part.named`."""
        if not self.letters or (what == "geometry") != self.geometry:
            return one
        value: Any = self.of(one)
        text = self.text.format(one.name)
        if len(self.letters) > 1:
            value = along(value, self.letters, str(k), self.unit_at(0, slides), text, names)
        else:
            called = [
                names.of(x, f"{self.letters[0]}{k}", self.unit_at(i, slides), text, self.positive)
                for i, (_, x) in enumerate(indexed(value))
            ]
            value = tuple(called) if isinstance(value, tuple) else next(iter(called), value)
        said = {self.name: value}
        return one.shaped(**said) if isinstance(one, Joint) else replace(one, **said)

    def check(self, one: Any, stand: Stand) -> None:
        """Report a number that has to be above zero and is not."""
        value: Any = self.of(one)
        if self.above_zero and (size := stand.value(value)) is not None and size <= 0:
            stand.fault(f"{self.name} = {shown(value)} {self.above_zero}")


def indexed(value: Any) -> Iterator[tuple[str, Quantity]]:
    """Return the quantities of a value, each with its index: "" alone, "[0]" and so on of several."""
    if isinstance(value, Quantity):
        yield "", value
    elif isinstance(value, tuple):
        yield from ((f"[{i}]", x) for i, x in enumerate(value) if isinstance(x, Quantity))


def along(vector: Vector, letters: tuple[str, ...], place: str, unit: str, text: str, names: Names) -> Vector:
    """Return a vector with its components named."""
    x, y, z = (
        names.of(entry, f"{letter}{place}", unit, f"{text}, along {axis}")
        for letter, axis, entry in zip(letters, "xyz", vector, strict=True)
    )
    return (x, y, z)


def always_given(one: Any) -> bool:
    """Tell that no noun has the value of a key without saying so, as of one that must be given."""
    return False


# Readers


def coefficients(table: EntryReader, key: str, usual: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
    """Return one number or a list of them."""
    if key not in table:
        return usual
    raw = plain(table.raw[key])
    given = list(raw) if isinstance(raw, (list, tuple)) else [raw]
    if not given:
        table.fault(f"{key} = [] holds no number; give one, or a list of coefficients")
    try:
        return tuple(quantity(plain(one)) for one in given)
    except FormulaError as error:
        table.refuse(key, error)
        return usual


def choice(*words: str) -> Callable[[EntryReader, str, str], str]:
    """Return the reader of one of some words, the first of which stands in."""

    def read(table: EntryReader, key: str, usual: str) -> str:
        word = table.text(key, usual)
        if word in words:
            return word
        listed = " or ".join(f'"{one}"' for one in words)
        table.fault(f'{key} = "{word}" is not known; write {listed}')
        return words[0]

    return read


SHAPES: Mapping[Callable[..., Any], Shape] = {
    EntryReader.quantity: NUMBER,
    EntryReader.vector: VECTOR,
    EntryReader.pose: PLACEMENT,
    EntryReader.text: TEXT,
    EntryReader.flag: FLAG,
    coefficients: NUMBERS,
}
"""Raw values by what reads them."""
