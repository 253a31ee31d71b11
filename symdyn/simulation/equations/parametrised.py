"""A scene with its named parameters free, and their values beside it: what is derived and compiled knows no value.

Some values decide the form of equations, and stay: what is zero drops out, and right angles turn axes into axes. Such
values are part of the open scene, so that equations of another form are never taken for these.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

from symdyn.algebra import Floats
from symdyn.dynamics import LoopChoices
from symdyn.dynamics.loops import Numbers
from symdyn.errors import SimulateError
from symdyn.graph import Expr, Graph, evaluate, reachable
from symdyn.scene import Quantity, Scene, without_hidden_zeros
from symdyn.scene.values import FormulaError, Parameter, substituted
from symdyn.simulation.prescribed.formulas_in_time import parameter_values


@dataclass(frozen=True)
class Opened:
    """A scene and the values of its parameters, apart.

    Attributes:
        scene: the mechanism with parameters free, but for those whose values decide its form.
        values: of all its parameters, by name.
    """

    scene: Scene
    values: Mapping[str, float]

    @property
    def closing(self) -> LoopChoices:
        """What tells derivations at which values decisions about closed loops are made."""
        return LoopChoices(parameters=tuple((p.name, self.values[p.name]) for p in self.scene.free_parameters))

    def numbers(self) -> Numbers:
        """Return the scene in numbers, at its values; what is derived of it is derived once for all values."""
        return _open_numbers(self.scene).afresh(self.values)


@lru_cache(maxsize=16)
def opened(scene: Scene) -> Opened:
    """Return a scene with its parameters free, and their values.

    Raises:
        SimulateError: one has no value, or none that is a real number.
    """
    parameter_values(scene)
    values = {p.name: _value(scene, p) for p in scene.parameters}
    free = replace(scene, parameters=tuple(replace(p, value=None) for p in scene.parameters))
    if _plain(free, values):
        return Opened(free, values)
    scene, known = without_hidden_zeros(scene), {p.name: p.value for p in scene.parameters if p.value is not None}
    deciding = [one for one in _formulas_in(scene) if _decides_form(one, known)]
    kept = {name for one in deciding for name in one.symbols}
    parameters = tuple(p if p.name in kept else replace(p, value=None) for p in scene.parameters)
    return Opened(replace(scene, parameters=parameters), values)


def _value(scene: Scene, p: Parameter) -> float:
    assert p.value is not None, "all have values"
    try:
        return float(evaluate([p.value.express(Graph())], Floats(), {})[0])
    except (ArithmeticError, ValueError):
        raise SimulateError(f"{scene.name}: parameters.{p.name} has no real value") from None


def _plain(free: Scene, values: Mapping[str, float]) -> bool:
    """Tell whether values decide nothing about the form of equations, as far as doubles can tell."""
    graph, formulas, order = _formulas(free)
    try:
        found = evaluate(formulas, Floats(), {graph.symbol(name): x for name, x in values.items()}, order)
    except (ArithmeticError, ValueError):  # told where it is computed with
        return False
    return all(math.isfinite(2 * x) and abs(math.sin(2 * x)) > SMALL for x in (*values.values(), *found))


@lru_cache(maxsize=16)
def _formulas(free: Scene) -> tuple[Graph, list[Expr], tuple[Expr, ...]]:
    """Return the formulas in parameters that a scene holds, on a graph, and the order to evaluate them in."""
    graph = Graph()
    formulas = [one.express(graph) for one in _formulas_in(free)]
    return graph, formulas, reachable(formulas)


def _formulas_in(scene: Scene) -> list[Quantity]:
    """Return the formulas in parameters alone that a scene holds, and its parameters as such."""
    names = dict.fromkeys(p.name for p in scene.parameters)
    formulas = [one for one in Quantity.inside(scene) if one.symbols and names.keys() >= set(one.symbols)]
    return list(dict.fromkeys([*map(Quantity.symbol, names), *formulas]))


def _decides_form(formula: Quantity, values: Mapping[str, Quantity]) -> bool:
    """Tell whether the value of a formula decides the form of equations: zero does, and a right angle."""
    graph = Graph()
    try:
        angle = substituted(formula, values).express(graph)
    except (FormulaError, ZeroDivisionError):  # told where it is computed with
        return False
    return angle.is_zero or graph.sin(angle).is_zero or graph.cos(angle).is_zero


SMALL = 1e-9
"""Values below it are looked at exactly, whether they are zero."""


@lru_cache(maxsize=16)
def _open_numbers(scene: Scene) -> Numbers:
    found = Numbers(scene)
    for one in (found, found.plain):  # copies share what was derived
        one.derive()
    return found
