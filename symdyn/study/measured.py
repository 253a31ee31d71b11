"""In which units measures are."""

from __future__ import annotations

from symdyn.graph import Op
from symdyn.scene import Quantity, Scene
from symdyn.scene.values.quantity import symbol
from symdyn.simulation.columns import unit_of as unit_of_column
from symdyn.simulation.ensemble.measures import Measure

UNITS = {"when_max": "s", "when_min": "s"}
"""Of folds that are in another unit than what they fold."""


def unit_of(measure: Measure, scene: Scene) -> str:
    """Return the unit of a measure, where it is one fold of one column, or of its size; "" of others."""
    if len(measure.folds) != 1 or _plain(measure.formula) != symbol(measure.folds[0][0]):
        return ""
    _, fold, inside = measure.folds[0]
    if fold in UNITS:
        return UNITS[fold]
    unit = unit_of_column(_plain(inside), scene)
    return f"{unit} s" if fold == "integral" and unit else unit


def _plain(formula: Quantity) -> Quantity:
    """Return what a formula is the size or the negative of."""
    return _plain(formula.args[0]) if formula.op in (Op.ABS, Op.NEG) else formula
