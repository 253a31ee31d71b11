"""Directions as a scene declares them: numbers, of any length but zero."""

from __future__ import annotations

from symdyn.graph import Graph, Op
from symdyn.scene.values.folding import FormulaError
from symdyn.scene.values.names import listed
from symdyn.scene.values.quantity import ZERO, Quantity, Vector, express
from symdyn.scene.values.table import Faults, shown
from symdyn.scene.values.value import value_of


def direction(where: str, key: str, axis: Vector, faults: Faults, tilt: str = "tilt by origin.rpy") -> bool:
    """Report a direction that depends on symbols or has no length; tell whether it is one.

    `tilt` says what turns it by a parameter.
    """
    text = f"{key} = [{', '.join(shown(x) for x in axis)}]"
    names = dict.fromkeys(name for x in axis for name in x.symbols)
    if names:
        faults.add(where, f"{text} depends on {listed(names)}; give numbers, and {tilt} instead")
    elif not all(_has_value(x) for x in axis):
        faults.add(where, f"{text} divides by zero, or has no real value; give a direction such as [0, 0, 1]")
    elif all(vanishes(x) for x in axis):
        faults.add(where, f"{text} has zero length; give a direction such as [0, 0, 1]")
    else:
        return True
    return False


def _has_value(quantity: Quantity) -> bool:
    try:
        express(quantity, Graph())
        value_of(quantity, {})
    except (FormulaError, ZeroDivisionError):
        return False
    return True


def vanishes(quantity: Quantity) -> bool:
    """Tell whether a quantity without symbols is zero."""
    if quantity.op is Op.CONSTANT:
        return quantity == ZERO
    try:
        return express(quantity, graph := Graph()) is graph.zero or value_of(quantity, {}) == 0
    except (FormulaError, ZeroDivisionError):
        return False  # reported as a formula without a value
