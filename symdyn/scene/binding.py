"""Binding parameters: the same scene with values given to some of them.

A parameter keeps its name and gets its value, which the program folds in. One whose value is zero is zero at once in
every formula, so that the derivations see what is gone: a massless body, a shift of no length, gravity. It is no
longer assumed to be positive then.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.graph import Graph
from symdyn.scene.declaration.draft import draft_of
from symdyn.scene.declaration.reading import value_for
from symdyn.scene.declaration.whole_scene import check
from symdyn.scene.values.entry import Faults, show
from symdyn.scene.values.mapping import map_quantities, substituted
from symdyn.scene.values.model import Parameter, Scene
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.quantity import FormulaError, Quantity


def bind(scene: Scene, values: Mapping[str, object]) -> Scene:
    """Return the scene with values for some of its parameters, in place of values they may have.

    Args:
        scene: any scene.
        values: by name of the parameter: a number in SI, formula text without symbols, a value with its unit such as
            "400 mm", or a quantity.

    Raises:
        SceneError: an unknown parameter, no number, or a value that the scene cannot have; with every fault.
    """
    check_arguments(bind, locals(), SceneError)
    faults = Faults(scene.source or scene.name)
    names = {parameter.name: parameter for parameter in scene.parameters}
    known: dict[str, Parameter] = {}
    for name, raw in values.items():
        if name not in names:
            faults.add("", f'"{name}" is not a parameter; {suggestion(name, names)}')
            continue
        try:
            value, unit, written = value_for(names[name], raw)
        except FormulaError as error:
            reason = str(error)
            told = f"{show(raw)} {reason}" if reason.startswith("is in ") else reason
            faults.add(f"parameters.{name}", f"value {told}")
            continue
        known[name] = replace(names[name], value=value, unit=unit, written=written)
    faults.close()
    parameters = tuple(known.get(p.name, p) for p in scene.parameters)
    bound = without_zeros(replace(scene, parameters=parameters), faults)
    said = any(one.unit != names[name].unit for name, one in known.items())
    check(draft_of(bound), faults, dimensions=said)  # which no value changes but one that says a unit first
    faults.close()
    return bound


def without_zeros(scene: Scene, faults: Faults | None = None) -> Scene:
    """Return the scene with zero in every formula for the parameters that are zero; they cannot be bound again there.

    Raises:
        SceneError: a formula has no value then.
    """
    faults = faults or Faults(scene.source or scene.name)
    zeros = {p.name: Quantity.ZERO for p in scene.parameters if p.value and not p.value.symbols and _is_zero(p.value)}
    if not zeros:
        return scene
    parameters = tuple(replace(p, positive=p.positive and p.name not in zeros) for p in scene.parameters)
    try:
        return map_quantities(replace(scene, parameters=parameters), lambda one: substituted(one, zeros))
    except FormulaError as error:
        faults.add("", f"with {' = '.join(zeros)} = 0 a formula has no value: {error}")
        faults.close()
        raise AssertionError("a fault closes") from error


def without_hidden_zeros(scene: Scene) -> Scene:
    """Return the scene with zero in place of what is zero with its parameters' values, such as a mass a - b, too.

    For derivations, which see then what is gone; other values cannot be given to these parameters there any more.

    Raises:
        SceneError: a formula has no value with a parameter that is zero.
    """
    scene = without_zeros(scene)
    values = {p.name: p.value for p in scene.parameters if p.value and not p.value.symbols}

    def settled(one: Quantity) -> Quantity:
        """Return zero for a formula of parameters that is zero with their values."""
        if not one.symbols or not set(one.symbols) <= values.keys():
            return one
        try:
            return Quantity.ZERO if _is_zero(substituted(one, values)) else one
        except FormulaError:  # told where it is computed with
            return one

    return map_quantities(scene, settled) if values else scene


def _is_zero(value: Quantity) -> bool:
    try:
        return value.express(Graph()).is_zero
    except ZeroDivisionError:
        return False  # reported by the check
