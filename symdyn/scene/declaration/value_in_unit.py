"""A letter's value and unit as a table says them: `{ value = 500, unit = "mm" }`, `"500 mm"`, or a unit alone.

The value becomes SI, and its unit the coherent one; the unit that was chosen is kept, for whoever writes the scene.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from symdyn.errors import SceneError
from symdyn.scene.values import folding
from symdyn.scene.values.folding import FormulaError, fraction
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.model import Letter
from symdyn.scene.values.quantity import ONE, ZERO, Quantity
from symdyn.scene.values.spelling import spell
from symdyn.scene.values.table import Table
from symdyn.scene.values.unit import Unit, UnitError, in_si
from symdyn.scene.values.value import value_of
from symdyn.scene.values.with_unit import fits, with_unit


@dataclass(frozen=True)
class Valued:
    """A value with its unit.

    Attributes:
        value: in SI; None where none is said.
        unit: the coherent unit, "" where none is said.
        written: the unit that was chosen, where it is another one.
    """

    value: Quantity | None = None
    unit: str = ""
    written: str = ""


def read_valued(table: Table) -> Valued:
    """Return what `value` and `unit` of a table say; what is wrong with them is a fault of the table."""
    text = table.text("unit")
    value = table.quantity("value") if "value" in table else None
    try:
        unit = Unit.read(text) if text else None
    except UnitError as error:
        table.refuse("unit", error)
        return Valued(value)
    try:
        return in_unit(value, unit)
    except FormulaError as error:
        table.refuse("value", error)
        return valued(None, unit)


def read_coherent(table: Table) -> str:
    """Return the `unit` of a table whose formula is computed, which is in SI."""
    text = table.text("unit")
    try:
        unit = Unit.read(text) if text else None
    except UnitError as error:
        table.refuse("unit", error)
        return ""
    if unit is None or unit.is_coherent:
        return text
    table.fault(f'unit = "{text}" is of numbers that are not in SI, and what is computed is; write "{unit.si}"')
    return unit.si


def in_unit(value: Quantity | None, unit: Unit | None) -> Valued:
    """Return a value beside a unit: a bare number is in it, one with a unit of its own is converted.

    Raises:
        FormulaError: the value's own unit does not fit, or the value is beyond what a double holds.
    """
    if value is None or not value.unit:
        return valued(value and in_si(value, unit) if unit else value, unit)
    fits(value, unit)
    return valued(value, unit or Unit.read(value.unit))


def valued(value: Quantity | None, unit: Unit | None) -> Valued:
    """Return a value in SI beside the unit that was chosen."""
    if unit is None:
        return Valued(value)
    return Valued(value, unit.si, "" if unit.is_coherent else unit.text)


def as_written(letter: Letter) -> str:
    """Return a letter's value as its writer said it, "500 mm", where that is in another unit than SI's, else ""."""
    unit = letter.written or (letter.value.unit if letter.value is not None else "")
    if not unit or letter.value is None or Unit.read(unit).is_coherent:
        return ""
    return with_unit(letter.value, unit)


def value_for(letter: Letter, raw: object) -> tuple[Quantity, str, str]:
    """Return a value that is given to a letter, SI where it has no unit of its own; and the letter's units then.

    Raises:
        FormulaError: it is no value, or one of another kind.
    """
    value = quantity(raw)
    if not value.unit:
        return value, letter.unit, letter.written
    unit = Unit.read(letter.unit) if letter.unit else None
    fits(value, unit)
    own = valued(value, unit or Unit.read(value.unit))
    return value, own.unit, letter.written if unit else own.written


def ask_for_units(letters: Iterable[Letter], given: Iterable[tuple[str, str]], option: str) -> None:
    """Look whether bare numbers were typed for letters that are in another unit than that of SI.

    Args:
        letters: those of the scene.
        given: name and text of what was typed.
        option: in which.

    Raises:
        SceneError: there are such, and what may be meant.
    """
    chosen = {one.name: one for one in letters if one.written}
    told = (question(chosen[name], text) for name, text in given if name in chosen)
    asked = [f"{option}: {one}" for one in told if one]
    if asked:
        raise SceneError(asked)


def in_si_here(letters: Iterable[Letter], given: Iterable[tuple[str, str]]) -> tuple[str, ...]:
    """Return what is to be said of formulas that were typed for letters that are in another unit than that of SI.

    A formula cannot be asked about as a number can, since letters of it may stand in SI.
    """
    chosen = {one.name: one for one in letters if one.written}
    told = []
    for name, text in given:
        try:
            found = quantity(text) if name in chosen else ZERO
        except FormulaError:
            continue
        if found.symbols and not found.unit:
            told.append(f"{name} is in {chosen[name].unit} here, its file says {chosen[name].written}")
    return tuple(dict.fromkeys(told))


def _is_bare(text: str) -> bool:
    """Tell whether a text is a number without a unit, other than zero, which is zero in all of them."""
    try:
        found = quantity(text)
    except FormulaError:
        return False
    return not (found.unit or found.symbols or found == ZERO)


def question(letter: Letter, text: str) -> str:
    """Return what a bare number may mean of a letter that is in another unit than that of SI; "" where all is said."""
    if not letter.written or not _is_bare(text):
        return ""
    number = fraction(quantity(text))
    size = ONE if number is None else folding.constant(number)
    there = float(value_of(in_si(size, Unit.read(letter.written)), {}) or 0)
    front = f"{letter.name} is given in {letter.written}: say {letter.name}="
    return f"{front}{spell(size)}{letter.written} or {letter.name}={there:.12g}{letter.unit}"
