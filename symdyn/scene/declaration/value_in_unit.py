"""A letter's value and unit as a table says them: `{ value = 500, unit = "mm" }`, `"500 mm"`, or a unit alone.

The value becomes SI, and its unit the coherent one; the unit that was chosen is kept, for whoever writes the scene.
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.scene.values.formula import quantity
from symdyn.scene.values.model import Letter
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.table import Table
from symdyn.scene.values.unit import Unit, UnitError, in_si
from symdyn.scene.values.with_unit import fits


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
