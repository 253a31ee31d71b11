"""Functions of a scene, parameters free, compiled: what depends on these alone is computed once for their values.

f(x, p) = h(x, P(p))        h is compiled, and called with the prepared values P(p)
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import Argument, Equations, Function, Workspace
from symdyn.dynamics.mechanism import TIME, body_placements
from symdyn.dynamics.outputs import arguments
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, substitute
from symdyn.program import Program, lower, prepare
from symdyn.runtime import load_program
from symdyn.scene import Quantity, Scene
from symdyn.simulation.prescribed.forces import Forces

Calls = Mapping[str, Callable[..., Any]]
T = TypeVar("T")


EVERYTHING = ("q", "qd", "tau", TIME)


def function_of(w: Workspace, name: str, entries: Sequence[Expr], takes: Sequence[str] = EVERYTHING) -> Function:
    """Return entries as a function of everything, inputs behind driving forces, or of what it takes."""
    letters = w.inputs
    given = [
        replace(a, symbols=(*a.symbols, *letters)) if a.name == "tau" and takes == EVERYTHING else a
        for a in arguments(w, takes)
    ]
    return plain(name, entries, given)


def points(w: Workspace) -> Function:
    """Return where the declared points of a scene are, ground axes, m, three entries each."""
    placed = body_placements(w.scene, w.graph) if w.scene.points else {}
    places = [placed[one.body] @ one.at.transform(w.graph) for one in w.scene.points]
    return function_of(w, "points", [x for place in places for x in place.p], ("q",))


def plain(name: str, entries: Sequence[Expr], takes: Sequence[Argument]) -> Function:
    """Return entries as a function of its arguments."""
    return Function(name, name, tuple(takes), "out", (len(entries),), tuple(entries), units="", formulation="")


def argument(graph: Graph, name: str, count: int) -> Argument:
    """Return an argument of so many numbers, such as a direction."""
    return Argument(name, tuple(graph.symbol(f"{name}[{k}]") for k in range(count)), name, ())


def acting(w: Workspace, forces: Forces) -> dict[Expr, Expr]:
    """Return what driving forces and inputs are: formulas, and the arguments that tables or controllers fill.

    An input of which nothing is said is what the scene says.
    """
    outside, found = forces.outside, dict[Expr, Expr]()
    for k, (one, letter) in enumerate(zip(w.scene.inputs, w.inputs, strict=True), w.state.n):
        usual = one.value if k not in outside else Quantity.ZERO
        formula = forces.formulas.get(k, usual).express(w.graph)
        found[letter] = formula + letter if k in outside else formula
    drives = substitute([forces.formula(k).express(w.graph) for k in range(w.state.n)], found)
    pairs = enumerate(zip(w.state.tau, drives, strict=True))
    return found | {tau: formula + tau if k in outside else formula for k, (tau, formula) in pairs}


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
        if not self.prepared.is_prepared:
            return np.empty(0)
        (names,) = (a.symbols for a in self.prepared[Program.PREPARE].function.arguments)
        with np.errstate(all="ignore"):
            found: Array = self.calls[Program.PREPARE](np.array([parameters[str(one.value)] for one in names]))
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
        return {name: partial(call, prepared) for name, call in self.calls.items() if name != Program.PREPARE}

    def takes(self, name: str) -> list[str]:
        """Return the names of the arguments of a function at values."""
        return [one.name for one in self.program[name].function.arguments if one.name != Program.PARAMS]


def compiled(scene: Scene, graph: Graph, functions: Sequence[Function]) -> Compiled:
    """Return functions on a graph, compiled; those without entries are left out."""
    functions = [  # parameters first, so that `partial` binds them, which costs a call the least
        replace(one, arguments=tuple(sorted(one.arguments, key=lambda a: a.name != Program.PARAMS)))
        for one in functions
        if one.entries
    ]
    program = lower(Equations(scene, graph, tuple(functions)))
    prepared = prepare(program)
    if prepared.is_prepared and not prepared[Program.PREPARE].function.entries:  # nothing depends on what is free
        free = [tuple(a for a in one.arguments if a.name != Program.PARAMS) for one in functions]
        return compiled(scene, graph, [replace(f, arguments=a) for f, a in zip(functions, free, strict=True)])
    return Compiled(program, prepared, load_program(prepared))


def compiled_entries(w: Workspace, parts: Mapping[str, tuple[Sequence[Expr], Sequence[Argument]]]) -> Calls:
    """Return functions by name, of their entries and arguments, compiled; none where there are no entries."""
    functions = [plain(name, *part) for name, part in parts.items()]
    return compiled(w.scene, w.graph, functions).calls if functions else {}


class Kept(Generic[T]):
    """What was made for the last few keys, of which the one that was longest not asked for goes first."""

    def __init__(self, most: int = 16) -> None:
        """Hold so many at most."""
        self._most = most
        self._things: dict[Any, T] = {}

    def get(self, key: Any, make: Callable[[], T]) -> T:
        """Return the thing of a key, made if there is none."""
        found = self._things.pop(key, None)
        self.put(key, make() if found is None else found)
        return self._things[key]

    def put(self, key: Any, thing: T) -> None:
        """Hold a thing as the one that was asked for last."""
        self._things.pop(key, None)
        self._things[key] = thing
        while len(self._things) > self._most:
            del self._things[next(iter(self._things))]

    def __iter__(self) -> Iterator[Any]:
        return iter(tuple(self._things))


_KEPT: Kept[Compiled] = Kept()


def compiled_once(key: Hashable, make: Callable[[], Compiled]) -> Compiled:
    """Return what was compiled for a key: functions of an open scene, and what was decided at values of it."""
    return _KEPT.get(key, make)
