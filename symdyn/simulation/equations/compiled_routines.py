"""Compiled functions of a scene whose parameters are free: one compilation serves all values.

    f(x, p) = h(x, P(p))        h is compiled, and called with the prepared values P(p)

P(p), which depends on parameters alone, is computed once for a set of values. A scene is taken apart into one with its
named parameters free and their values, so that what is derived and compiled knows no value.

Some values decide the form of equations, and stay: zeros drop out, and right angles turn axes into axes. Such values
are part of the scene with free parameters, so that equations of another form are never taken for these.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any, Generic, TypeVar

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics import Argument, Equations, Function, LoopChoices, Workspace, derive_one
from symdyn.dynamics.loops import Numbers
from symdyn.dynamics.mechanism import TIME, body_placements
from symdyn.dynamics.outputs import arguments
from symdyn.errors import DerivationError, SimulateError
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Expr, Graph, evaluate, reachable, substitute, tangents
from symdyn.program import Program, lower, prepare
from symdyn.runtime import load_program
from symdyn.scene import Quantity, Scene, without_hidden_zeros
from symdyn.scene.values import FormulaError, Parameter, substituted
from symdyn.simulation.prescribed.forces import Forces
from symdyn.simulation.prescribed.formulas_in_time import parameter_values

Calls = Mapping[str, Callable[..., Any]]
T = TypeVar("T")


EVERYTHING = ("q", "qd", "tau", TIME)


def function_of(w: Workspace, name: str, entries: Sequence[Expr], takes: Sequence[str] = EVERYTHING) -> Function:
    """Return entries as a function of everything, inputs behind driving forces, or of what it takes.

    States of one's own stand behind velocities.
    """
    behind = {"tau": w.inputs if takes == EVERYTHING else (), "qd": w.states}
    given = [replace(a, symbols=(*a.symbols, *behind.get(a.name, ()))) for a in arguments(w, takes)]
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


def powers(w: Workspace, drives: Sequence[Expr], place: Mapping[Expr, Expr]) -> list[Expr]:
    """Return the power of drives, W, and that of all else beside gravity and springs.

    Energy that matter takes along or brings is among the latter, what K + P changes by while masses do, and what ends
    of springs bring in that move as they are told.
    """
    acts = (drives, substitute(w.Q, place))
    found = [w.graph.total(f * u for f, u in zip(some, w.state.qd, strict=True)) for some in acts]
    seeds = {**w.state.clock, **dict(zip(w.states, substitute(w.state_rates, place), strict=True))}
    if not seeds:
        return found
    energies = [x for name in ("kinetic_energy", "potential_energy") for x in derive_one(w, name).entries]
    return [found[0], w.graph.total([found[1], *substitute(tangents(energies, seeds), place)])]


@dataclass(frozen=True)
class Compiled:
    """Functions of a scene whose parameters are free."""

    program: Program  # the functions of states and parameters
    prepared: Program  # the same of states and prepared values; what is compiled
    calls: Calls = field(repr=False)  # its functions by name, batches too

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


@dataclass(frozen=True)
class Opened:
    """A scene and the values of its parameters, apart."""

    scene: Scene  # the mechanism with parameters free, but for those whose values decide its form
    values: Mapping[str, float]  # of all its parameters, by name

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
        return float(p.value)
    except FormulaError:
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
    for one in (found, found.in_quaternions):  # copies share what was derived
        one.derive()
    return found
