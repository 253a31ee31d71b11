"""Keys of elements as data: how they are read, what they are when nothing is said, how their numbers are called."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from symdyn.scene.forces.kind import PARAMETERS, Part, Scope
from symdyn.scene.values.folding import FormulaError
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.made_names import Names
from symdyn.scene.values.quantity import NULL, ZERO, Quantity, Vector
from symdyn.scene.values.table import Table, plain


@dataclass(frozen=True)
class Form:
    """A form of values.

    Attributes:
        read: what a table says under a key, or what is usual where it says nothing; faults collected.
        empty: what stands in for what is missing or wrong.
        raw: what a table says of a value.
    """

    read: Callable[[Table, str, Any], Any]
    empty: Any
    raw: Callable[[Any], object] = lambda value: value


@dataclass(frozen=True)
class Key(Part):
    """A key, and the field of the same name.

    Attributes:
        name: of key and field.
        form: of its value.
        default: its value where nothing is said; None: it is always said.
        silent: whether a noun has its value without saying so, where the default does not decide.
        letters: of the parameters that stand for its numbers, one, or one an axis; () for none.
        unit: of those parameters; two of them at a joint that turns, and at one that slides.
        text: what they are, the name of what has them in place of {}.
        positive: whether such a parameter is the size of a number and the sign stands in front.
        geometry: whether it is a length of the mechanism, not a force.
        names: what its formulas may name; None of a direction, which is checked with what it directs.
    """

    name: str
    form: Form
    default: Any = None
    silent: Callable[[Any], bool] | None = None
    letters: tuple[str, ...] = ()
    unit: str | tuple[str, str] = ""
    text: str = ""
    positive: bool = False
    geometry: bool = False
    names: int | None = PARAMETERS

    @property
    def keys(self) -> tuple[str, ...]:  # type: ignore[override]
        """The key."""
        return (self.name,)

    def read(self, table: Table, scope: Scope | None = None) -> dict[str, Any]:
        """Return the field."""
        usual = self.form.empty if self.default is None else self.default
        return {self.name: self.form.read(table, self.name, usual)}

    def raw(self, one: Any, scope: Scope | None = None) -> dict[str, object]:
        """Return what a table says, nothing where the default says it."""
        value = getattr(one, self.name)
        silent = value == self.default if self.silent is None else self.silent(one)
        return {} if silent else {self.name: self.form.raw(value)}

    def numbers(self, one: Any) -> Iterator[tuple[str, Quantity, int]]:
        """Return its quantities."""
        value = getattr(one, self.name)
        if self.names is not None:
            yield from ((f"{self.name}{index}", x, self.names) for index, x in indexed(value))

    def named(self, one: Any, what: str, letter: str, k: int, names: Names) -> Any:
        """Return the noun with the numbers of this key named."""
        if not self.letters or (what == "geometry") != self.geometry:
            return one
        return self.called(one, one.name, k, names)

    def called(self, one: Any, of: str, k: int, names: Names, slides: bool = False) -> Any:
        """Return a noun with the numbers of this key named, as those of `of`, the k-th of its like."""
        value, text = getattr(one, self.name), self.text.format(of)
        unit = self.unit if isinstance(self.unit, str) else self.unit[slides]
        if len(self.letters) > 1:
            return replace(one, **{self.name: along(value, self.letters, str(k), unit, text, names)})

        def name(x: Quantity) -> Quantity:
            return names.of(x, f"{self.letters[0]}{k}", unit, text, self.positive)

        many = isinstance(value, tuple)
        return replace(one, **{self.name: tuple(map(name, value)) if many else value and name(value)})


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


def _coefficients(table: Table, key: str, usual: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
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


NUMBER = Form(Table.quantity, ZERO)

VECTOR = Form(Table.vector, NULL)

COEFFICIENTS = Form(_coefficients, (), lambda value: value[0] if len(value) == 1 else value)


def choice(*words: str) -> Form:
    """Return the form of one of some words, the first of which stands in."""

    def read(table: Table, key: str, usual: str) -> str:
        word = table.text(key, usual)
        if word in words:
            return word
        listed = " or ".join(f'"{one}"' for one in words)
        table.fault(f'{key} = "{word}" is not known; write {listed}')
        return words[0]

    return Form(read, words[0])
