"""Compiled functions with parameters free: what depends on parameters alone is computed once for a set of values.

f(x, p) = h(x, P(p))        h is compiled, and called with the prepared values P(p)
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.build.load import load_program
from symdyn.dynamics.roads.equations import Equations, Function
from symdyn.errors import DerivationError
from symdyn.graph import Graph
from symdyn.program import Program, formulate, lower, prepare
from symdyn.program.assemble import PARAMS
from symdyn.program.prepare import PREPARE, is_prepared
from symdyn.scene import Scene
from symdyn.simulation.equations.kept import Kept
from symdyn.simulation.equations.opened import Opened

Array = npt.NDArray[np.float64]
Calls = Mapping[str, Callable[..., Any]]


@dataclass(frozen=True)
class Compiled:
    """Functions of a scene whose parameters are free.

    Attributes:
        program: the functions of states and parameters.
        prepared: the same of states and prepared values; what is compiled.
        calls: its functions by name, batches too.
    """

    program: Program
    prepared: Program
    calls: Calls = field(repr=False)

    def values(self, parameters: Mapping[str, float]) -> Array:
        """Return the prepared values, shape (K,), of the parameters by name.

        Raises:
            DerivationError: they are not finite, as where something is divided by zero.
        """
        if not is_prepared(self.prepared):
            return np.empty(0)
        (names,) = (a.symbols for a in self.prepared[PREPARE].function.arguments)
        with np.errstate(all="ignore"):
            found: Array = self.calls[PREPARE](np.array([parameters[str(one.value)] for one in names]))
        if not np.isfinite(found).all():
            raise DerivationError(
                f"{self.program.scene.name}: with its parameters' values something would divide by zero, or have no "
                "real value: a mass matrix is singular then, or a formula has no value; give another value"
            )
        return found

    def at(self, parameters: Mapping[str, float]) -> Calls:
        """Return the functions of states alone, at values of the parameters by name; errors as of `values`."""
        prepared = self.values(parameters)
        if not len(prepared):
            return self.calls
        return {name: partial(call, prepared) for name, call in self.calls.items() if name != PREPARE}

    def takes(self, name: str) -> list[str]:
        """Return the names of the arguments of a function at values."""
        return [one.name for one in self.program[name].function.arguments if one.name != PARAMS]


def compiled(scene: Scene, graph: Graph, functions: Sequence[Function]) -> Compiled:
    """Return functions on a graph, compiled; those without entries are left out."""
    functions = [_parameters_first(one) for one in functions if one.entries]
    program = lower(Equations(scene, graph, tuple(functions)))
    prepared = prepare(program)
    if is_prepared(prepared) and not prepared[PREPARE].function.entries:  # nothing depends on what is free
        return compiled(scene, graph, [_without_parameters(one) for one in functions])
    return Compiled(program, prepared, load_program(prepared, lean=True)[0])


def requested(scene: Opened, requests: tuple[str, ...], decisions: Hashable = None) -> Compiled:
    """Return outputs of a scene by name, compiled once for all values at which the same is decided."""

    def make() -> Compiled:
        equations = formulate(scene.scene, requests, closing=scene.closing)
        return compiled(scene.scene, equations.graph, equations.functions)

    return _KEPT.get((scene.scene, requests, decisions), make)


_KEPT: Kept[Compiled] = Kept()


def _parameters_first(function: Function) -> Function:
    """Return a function whose parameters can be bound by `partial`, which costs a call the least."""
    return replace(function, arguments=tuple(sorted(function.arguments, key=lambda one: one.name != PARAMS)))


def _without_parameters(function: Function) -> Function:
    return replace(function, arguments=tuple(one for one in function.arguments if one.name != PARAMS))
