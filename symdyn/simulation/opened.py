"""A scene with its named parameters free, and their values beside it: what is derived and compiled knows no value.

Some values decide the form of equations, and stay: what is zero drops out, and right angles turn axes into axes. Such
values are part of the open scene, so that equations of another form are never taken for these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import Closing
from symdyn.dynamics.loops.numbers import Numbers, numbers_of
from symdyn.errors import SimulateError
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import Scene, express, without_hidden_zeros
from symdyn.simulation.reading import parameter_values


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
    def closing(self) -> Closing:
        """What tells derivations at which values decisions about closed loops are made."""
        return Closing(parameters=tuple((p.name, self.values[p.name]) for p in self.scene.free_parameters))


@lru_cache(maxsize=16)
def opened(scene: Scene) -> Opened:
    """Return a scene with its parameters free, and their values.

    Raises:
        SimulateError: one has no value, or none that is a real number.
    """
    parameter_values(scene)
    scene, graph = without_hidden_zeros(scene), Graph()
    parameters, values = [], {}
    for p in scene.parameters:
        assert p.value is not None, "all have values"
        try:
            value = express(p.value, graph)
            (values[p.name],) = evaluate([value], Floats(), {})
        except (ArithmeticError, ValueError):
            raise SimulateError(f"{scene.name}: parameters.{p.name} has no real value") from None
        parameters.append(p if _decides(value, graph) else replace(p, value=None))
    return Opened(replace(scene, parameters=tuple(parameters)), values)


def _decides(value: Expr, graph: Graph) -> bool:
    """Tell whether a value decides the form of equations: zero does, and a right angle."""
    return value.is_zero or graph.sin(value).is_zero or graph.cos(value).is_zero


@lru_cache(maxsize=16)
def _open_numbers(scene: Scene) -> Numbers:
    return numbers_of(scene)


def numbers_at(scene: Scene) -> Numbers:
    """Return a scene in numbers, at its values; what is derived of it is derived once for all values."""
    found = opened(scene)
    return _open_numbers(found.scene).afresh(found.values)
