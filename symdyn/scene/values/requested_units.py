"""What is said and asked where a run gives a bare number to a letter that is in its writer's unit, "500 mm".

Quantities that were written with a unit: whether it fits where they stand, and how they are written again.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Sequence

from symdyn.errors import SceneError
from symdyn.scene.values import folding
from symdyn.scene.values.entry import EntryReader
from symdyn.scene.values.folding import fraction
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.model import Letter
from symdyn.scene.values.quantity import FormulaError, Quantity, spell
from symdyn.scene.values.unit import Unit, UnitError, in_si, out_of_si


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


def question(letter: Letter, text: str) -> str:
    """Return what a bare number may mean of a letter that is in another unit than that of SI; "" where all is said."""
    if not letter.written or not _is_bare(text):
        return ""
    number = fraction(quantity(text))
    size = Quantity.ONE if number is None else folding.constant(number)
    there = float(in_si(size, Unit.read(letter.written)).at({}) or 0)
    front = f"{letter.name} is given in {letter.written}: say {letter.name}="
    return f"{front}{spell(size)}{letter.written} or {letter.name}={there:.12g}{letter.unit}"


def _is_bare(text: str) -> bool:
    """Tell whether a text is a number without a unit, other than zero, which is zero in all of them."""
    try:
        found = quantity(text)
    except FormulaError:
        return False
    return not (found.unit or found.symbols or found == Quantity.ZERO)


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


def fits_place(table: EntryReader, key: str, value: Quantity, units: Sequence[str]) -> None:
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
