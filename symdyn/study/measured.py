"""In which units measures are."""

from __future__ import annotations

from symdyn.scene import Scene, SceneUnits
from symdyn.simulation import Measure, fold_units


def unit_of(measure: Measure, scene: Scene, called: str = "") -> str:
    """Return the unit of a measure; "" where a number in it may carry one, or nothing tells it."""
    return SceneUnits(scene).of_formula(measure.formula, fold_units(scene, measure.folds), called)
