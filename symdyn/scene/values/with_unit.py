"""Quantities that were written with a unit: whether it fits where they stand, and how they are written again."""

from __future__ import annotations

import re
from collections.abc import Container, Sequence

from symdyn.scene.values.folding import fraction
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.spelling import spell
from symdyn.scene.values.table import Table
from symdyn.scene.values.unit import Unit, UnitError, out_of_si


def fits(value: Quantity, unit: Unit | None, letters: Container[str] = ()) -> None:
    """Look whether a value, where it was written with a unit, is of the kind of another one.

    Args:
        value: any.
        unit: the unit of what it is for, None where nothing tells it.
        letters: that a formula might name there, one of which may have been meant.

    Raises:
        UnitError: it is not.
    """
    if value.unit and unit is not None:
        own = Unit.read(value.unit)
        number = fraction(out_of_si(value, own))
        reason = own.misfit(unit, "" if number is None else spell(number))
        if reason:
            raise UnitError(f"{reason}{_letters_meant(value, letters)}")


def _letters_meant(value: Quantity, letters: Container[str]) -> str:
    """Return how a value is written as a formula, where all names of its unit are letters: 3*m of 3 m; else ""."""
    names = re.findall(r"[^\W\d]\w*", value.unit)
    if not names or not all(name in letters for name in names):
        return ""
    number = spell(out_of_si(value, Unit.read(value.unit)))
    factors = re.sub(r"(?<=\w) (?=\w)", "*", value.unit).replace("^", "**")
    told = "the letter" if len(names) == 1 else "the letters"
    return f"; for {number} times {told} write {number}*{factors}"


def fits_place(table: Table, key: str, value: Quantity, units: Sequence[str]) -> None:
    """Report a value of a table, where it was written with a unit, that is in none of the units that may stand there.

    For what is computed with when it is read, so that its unit is lost; what is kept is looked at in its scene.
    """
    try:
        if not value.unit or any(Unit.read(value.unit).misfit(Unit.read(one)) is None for one in units):
            return
        fits(value, Unit.read(units[0]))
    except UnitError as error:
        table.refuse(key, error)


def with_unit(value: Quantity, unit: str) -> str:
    """Return a quantity of SI as a number and a unit."""
    return f"{spell(out_of_si(value, Unit.read(unit)))} {unit}"
