"""Quantities that were written with a unit: whether it fits where they stand, and how they are written again."""

from __future__ import annotations

from symdyn.scene.values.folding import fraction
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.spelling import spell, spell_fraction
from symdyn.scene.values.unit import Unit, UnitError, misfit, out_of_si, read_unit


def fits(value: Quantity, wanted: Unit | None) -> None:
    """Look whether a value, where it was written with a unit, is of the kind of another one.

    Raises:
        UnitError: it is not.
    """
    if value.unit and wanted is not None:
        own = read_unit(value.unit)
        number = fraction(out_of_si(value, own))
        reason = misfit(own, wanted, "" if number is None else spell_fraction(number))
        if reason:
            raise UnitError(reason)


def with_unit(value: Quantity, unit: str) -> str:
    """Return a quantity of SI as a number and a unit."""
    return f"{spell(out_of_si(value, read_unit(unit)))} {unit}"
