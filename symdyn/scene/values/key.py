"""Keys of tables as data: how they are read and written, checked, and called as parameters."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

from symdyn.errors import listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import Graph
from symdyn.scene.values.body import UNMOVED, Pose
from symdyn.scene.values.dimension import product
from symdyn.scene.values.entry import EntryReader, Faults, compose, plain, quantities, said_pose, shown
from symdyn.scene.values.folding import neg
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.letters import Parameter
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity, Value, Vector
from symdyn.scene.values.shape import (
    ANYTHING,
    FLAG,
    NAMED,
    NUMBER,
    NUMBERS,
    PLACEMENT,
    TEXT,
    VECTOR,
    Shape,
    choice_of,
    described,
    table_shape,
)
from symdyn.scene.values.unit import Unit

T = TypeVar("T")


class Names:
    """Parameters as they are made up."""

    def __init__(self, suffix: str) -> None:
        self.suffix = suffix
        self.added: list[Parameter] = []

    def of(self, quantity: Quantity, name: str, unit: str, text: str, positive: bool = False) -> Quantity:
        """Return a symbol for a number, and what is zero or a formula in symbols as it is.

        Args:
            quantity: what may be a number.
            name: of the parameter; another one of that name is called <name>_2.
            unit: of the parameter.
            text: of the parameter.
            positive: let the parameter be the magnitude of the number, and the sign stand in front of it.
        """
        if quantity.symbols:
            return quantity
        if quantity.is_zero:
            return Quantity.ZERO
        value = quantity.at({})
        negative = positive and value is not None and value < 0
        quantity = neg(quantity) if negative else quantity
        taken = {parameter.name for parameter in self.added}
        unique, k = f"{name}{self.suffix}", 1
        while unique in taken:
            k += 1
            unique = f"{name}_{k}{self.suffix}"
        self.added.append(Parameter(unique, quantity, positive, unit, None, text))
        return -Quantity.symbol(unique) if negative else Quantity.symbol(unique)


PARAMETERS, MOTION, TIMED, OWN, STATED, PLACED, LED = range(7)
"""What a formula may name: parameters alone; coordinates, velocities too; and t too; own coordinates; states too.

Last, of what moves as it is told: parameters, t, and inputs that have a rate, or two.
"""


@dataclass(frozen=True)
class Stand:
    """Where a joint or an element stands while it is checked, as is its scene, in declared order."""

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


class KeyedQuantity(NamedTuple):
    """A quantity of a noun: its key, what it may name, and its unit, "" where that is not known."""

    key: str
    quantity: Quantity
    names: int = PARAMETERS
    unit: str = ""


class Part:
    """A part of a declared table: some keys, and the fields of its noun that they fill; see `Key` and `KeyGroup`.

    The scope is what a table of its sort is read and written with beside itself, such as the points of the scene.
    """

    words: Mapping[str, Shape]  # the raw value of each key as JSON Schema, and what it is
    rules: Sequence[Shape] = ()  # what is so of several keys, likewise

    @property
    def keys(self) -> tuple[str, ...]:
        return tuple(self.words)

    def fields(self, table: EntryReader, scope: Any) -> dict[str, Any]:
        """Return the fields that a table says, every fault collected."""
        raise NotImplementedError

    def raw(self, one: Any, scope: Any) -> dict[str, object]:
        """Return what a table says of a noun; what has its default value is left out."""
        raise NotImplementedError

    def numbers(self, one: Any, slides: bool = True) -> Iterator[KeyedQuantity]:
        """Return every quantity, of an element at a joint that turns where it does not slide."""
        return iter(())

    def named(self, one: Any, what: str, letter: str, k: int, names: Names, slides: bool = False) -> Any:
        """Return the k-th noun of its section with names in place of its numbers; `what` is "geometry" or "forces"."""
        return one

    def check(self, one: Any, stand: Stand) -> None:
        """Report what is wrong in a noun."""


@dataclass(frozen=True)
class Key(Part, Generic[T]):
    """One thing that a table says: how it is read, what it is, and how it is written.

    Its value is a number, several of them, a direction, a placement, text, or nouns that have keys of their own.

    Attributes:
        name: as scenes write it.
        read: its value from a table, its name, and what stands in where nothing is said, or after a fault.
        default: its value where it is left out.
        example: what to write where it must be given; "" where it may be left out, or the kind tells.
        silent: whether a noun has its value without saying so, where neither the default nor the example decides.
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
        holds: what it is, for who writes a scene, with its units in place of {}; "" makes it of `text` and `unit`.
        field: of its noun that has it; "" where that is called like the key.
        said: makes its raw value, where that is not its value.
        inside: the keys of the noun that is its value, or of each of them.
        never_negative: whether a number below zero is a fault.
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
    holds: str = ""
    field: str = ""
    said: Callable[[T], object] | None = None
    inside: tuple[Key[Any], ...] = ()
    never_negative: bool = False
    rules: Sequence[Shape] = ()
    words: Mapping[str, Shape] = dataclasses.field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        units = self.unit if isinstance(self.unit, str) else " or ".join(self.unit)
        told = ", ".join(part for part in (self.text.removesuffix(" of {}").replace(" of {}", ""), units) if part)
        object.__setattr__(self, "words", {self.name: described(self.holds.replace("{}", units) or told, self.taken)})

    @property
    def taken(self) -> Shape:
        """Its raw value as JSON Schema."""
        return SHAPES.get(self.read, ANYTHING) if self.shape is None else self.shape

    def of(self, one: Any) -> T:
        """Return what a noun says; of a joint that may be a key of its type."""
        of_its_type = dict(one.shape) if isinstance(one, Joint) else {}
        said = of_its_type if self.name in of_its_type else vars(one)
        value: T = said.get(self.field or self.name, self.default)
        return value

    def declared(self, table: EntryReader) -> T:
        """Return what a table says; a key that must be given and is not is a fault."""
        if self.example and self.name not in table:
            table.fault(f"{self.name} is missing; write {self.example}")
            return Quantity.ONE if self.above_zero else self.read(table, self.name, self.default)  # type: ignore[return-value]
        return self.read(table, self.name, self.default)

    def fields(self, table: EntryReader, scope: object) -> dict[str, Any]:
        return {self.field or self.name: self.declared(table)}

    def raw(self, one: Any, scope: object) -> dict[str, object]:
        """Return what the table of a noun says, nothing where the default says it; of one number no list."""
        value: Any = self.of(one)
        if value is None or (self.silent(one) if self.silent else value == self.default and not self.example):
            return {}
        if self.said is not None:
            return {self.name: self.said(value)}
        alone = isinstance(value, tuple) and len(value) == 1 and isinstance(value[0], Quantity)
        return {self.name: value[0] if alone else raw_of(self.inside, value) if self.inside else value}

    def numbers(self, one: Any, slides: bool = True) -> Iterator[KeyedQuantity]:
        value: Any = self.of(one)
        if self.inside:
            several = isinstance(value, tuple)
            for i, noun in enumerate(value if several else () if value is None else (value,)):
                place = f"{self.name}[{i}]" if several else self.name
                for key in self.inside:
                    yield from (x._replace(key=f"{place}.{x.key}") for x in key.numbers(noun, slides))
        elif isinstance(value, Pose):
            for kind, amount in value.steps:
                unit = "m" if kind.startswith("T") else "rad"
                yield KeyedQuantity(f"{self.name}.{kind}", amount, self.names or PARAMETERS, unit)
        elif self.names is not None:
            for k, (index, x) in enumerate(indexed(value)):
                yield KeyedQuantity(f"{self.name}{index}", x, self.names, self.unit_at(k, slides))

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
        of_its_type = isinstance(one, Joint) and self.name not in vars(one)
        return one.shaped(**said) if of_its_type else replace(one, **said)

    def check(self, one: Any, stand: Stand, place: str = "") -> None:
        """Report a number that is too small; `place` is in front of its key, of a noun that is inside another one."""
        value: Any = self.of(one)
        for key in self.inside if value is not None else ():
            key.check(value, stand, f"{place}{self.name}.")
        size = stand.value(value) if (self.above_zero or self.never_negative) and value is not None else None
        if self.above_zero and size is not None and size <= 0:
            stand.fault(f"{place}{self.name} = {shown(value)} {self.above_zero}")
        if self.never_negative and size is not None and size < 0:
            stand.fault(f"{place}{self.name} = {float(size):.6g} is negative; give zero or more")


@dataclass(frozen=True)
class KeyGroup(Part):
    """Keys that say fields of a noun together; their numbers, if there are any, are looked at elsewhere.

    Attributes:
        words: the raw value of each key as JSON Schema, and what it is.
        read: the fields from a table, and from its scope.
        said: what a table says of a noun.
        rules: what is so of several keys, likewise.
    """

    words: Mapping[str, Shape]
    read: Callable[[EntryReader, Any], dict[str, Any]] = lambda table, scope: {}
    said: Callable[[Any, Any], dict[str, object]] = lambda noun, scope: {}
    rules: Sequence[Shape] = ()

    def fields(self, table: EntryReader, scope: Any) -> dict[str, Any]:
        return self.read(table, scope)

    def raw(self, one: Any, scope: Any) -> dict[str, object]:
        return self.said(one, scope)


def keys_of(parts: Iterable[Part]) -> tuple[str, ...]:
    """Return all keys of a table."""
    return tuple(key for part in parts for key in part.keys)


def fields_of(parts: Iterable[Part], table: EntryReader, scope: object = None) -> dict[str, Any]:
    """Return the fields of a noun that its table says."""
    return {name: value for part in parts for name, value in part.fields(table, scope).items()}


def raw_of(parts: Iterable[Part], one: object, scope: object = None) -> dict[str, object]:
    """Return what the table of a noun says."""
    return {key: value for part in parts for key, value in part.raw(one, scope).items()}


def needed_of(parts: Iterable[Part]) -> list[str]:
    """Return the keys that a table must have."""
    return [part.name for part in parts if isinstance(part, Key) and part.example]


def shape_of(keys: Iterable[Key[Any]], required: Sequence[str] = ()) -> Shape:
    """Return a table of keys, of which what they are is not told."""
    return table_shape({key.name: key.taken for key in keys}, required)


def indexed(value: Any) -> Iterator[tuple[str, Quantity]]:
    """Return the quantities of a value, each with its index: "" alone, "[0]" and so on of several."""
    found = value if isinstance(value, tuple) else (value,)
    yield from ((f"[{i}]" * (len(found) > 1), x) for i, x in enumerate(found) if isinstance(x, Quantity))


def along(vector: Vector, letters: tuple[str, ...], place: str, unit: str, text: str, names: Names) -> Vector:
    """Return a vector with its components named."""
    x, y, z = (
        names.of(entry, f"{letter}{place}", unit, f"{text}, along {axis}")
        for letter, axis, entry in zip(letters, "xyz", vector, strict=True)
    )
    return (x, y, z)


def word(name: str, holds: str, example: str = "", default: str = "", shape: Shape = NAMED) -> Key[str]:
    """Return the key of a word, such as the name of a body."""
    return Key(name, EntryReader.text, default, example, holds=holds, shape=shape)


def one_of(name: str, words: Sequence[str], holds: str, default: str, example: str = "") -> Key[str]:
    """Return the key of one of some words."""

    def read(table: EntryReader, key: str, usual: str) -> str:
        return chosen(table, key, usual, words)

    return Key(name, read, default, example, holds=holds, shape=choice_of(*words))


def flag(name: str, holds: str) -> Key[bool]:
    """Return the key of what is so only where it is said."""
    return Key(name, EntryReader.flag, False, holds=holds)


def number(name: str, unit: str | tuple[str, str] = "", **more: Any) -> Key[Quantity]:
    """Return the key of a number, which is zero where nothing else is said; `more` as of any key."""
    return Key(name, EntryReader.quantity, Quantity.ZERO, unit=unit, **more)


def placement(name: str, holds: str) -> Key[Pose]:
    """Return the key of a placement, which is not written where its steps do nothing."""

    def unmoved(one: Any) -> bool:
        return not compose(*vars(one)[name].steps).steps

    return Key(name, EntryReader.pose, UNMOVED, silent=unmoved, holds=holds, said=said_pose)


# Readers


def optional(read: Callable[[EntryReader, str], T]) -> Callable[[EntryReader, str, T | None], T | None]:
    """Return the reader of what may be left out, and is none then."""
    return lambda table, key, usual: read(table, key) if key in table else usual


def coefficients(table: EntryReader, key: str, usual: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
    """Return one number or a list of them."""
    if key not in table:
        return usual
    raw = plain(table.raw[key])
    given = list(raw) if isinstance(raw, (list, tuple)) else [raw]
    if not given:
        table.fault(f"{key} = [] holds no number; give one, or a list of coefficients")
    return table.parsed(key, usual, lambda _: quantities(given))


def chosen(table: EntryReader, key: str, usual: str, words: Sequence[str]) -> str:
    """Return one of some words; after a fault, what stands in where nothing is said."""
    word = table.text(key, usual)
    if word in words or word == usual:
        return word
    listed = " or ".join(f'"{one}"' for one in words)
    table.fault(f'{key} = "{word}" is not known; write {listed}')
    return usual


SHAPES: Mapping[Callable[..., Any], Shape] = {
    EntryReader.quantity: NUMBER,
    EntryReader.vector: VECTOR,
    EntryReader.pose: PLACEMENT,
    EntryReader.text: TEXT,
    EntryReader.flag: FLAG,
    coefficients: NUMBERS,
}
"""Raw values by what reads them."""
