"""The runs of an ensemble before they run: starts, rates and values of parameters, one a run, by name.

Numbers and formulas stand for all runs; arrays have a number for each. What is varied is not written into equations:
these are made once, at values that are like those of the runs and decide nothing about their form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics.mechanism import TIME, prescribed, quaternions
from symdyn.graph import Graph, evaluate
from symdyn.scene import Quantity, Scene, SceneUnits, bind
from symdyn.scene.joints import start_of
from symdyn.scene.values import Faults, spell, suggestion, velocity_name
from symdyn.simulation.initial import by_name
from symdyn.simulation.prescribed.formulas_in_time import parameter_values, read_formula
from symdyn.simulation.problem import Problem

OFF = 1 + 1 / 17
"""Equations are made at values so much off those of a run, lest a zero or an equality there decide their form."""


@dataclass(frozen=True)
class Lanes:
    """The runs of an ensemble.

    Attributes:
        scene: the mechanism, all parameters bound; varied ones at values near those of the runs.
        count: how many runs.
        start, rates: what is given in place of what the scene says, by coordinate and by velocity: formulas, or arrays
            of shape (count,).
        values: of varied parameters by name, shape (count,).
    """

    scene: Scene
    count: int
    start: Mapping[str, Quantity | Array] = field(default_factory=dict)
    rates: Mapping[str, Quantity | Array] = field(default_factory=dict)
    values: Mapping[str, Array] = field(default_factory=dict)

    @property
    def varied(self) -> dict[str, Array]:
        """What differs between runs, by name, shape (count,)."""
        given = (*self.values.items(), *self.start.items(), *self.rates.items())
        return {name: one for name, one in given if isinstance(one, np.ndarray)}

    def parameters(self, part: slice = slice(None)) -> dict[str, Array]:
        """Return the values of all parameters by name, numbers or shape (runs of the part,)."""
        known: dict[str, Any] = {p.name: _number(p.value) for p in self.scene.parameters if p.value is not None}
        return known | {name: one[part] for name, one in self.values.items()}

    def states(self, part: slice = slice(None)) -> tuple[Array, Array]:
        """Return where runs of a tree start, shapes (runs, nq) and (runs, nv); quaternions of length 1."""
        scene, graph = self.scene, Graph()
        moved = prescribed(scene, graph)
        q: list[Any] = [self.start.get(n, x) for n, x in zip(scene.coordinates, start_of(scene).position, strict=True)]
        u: list[Any] = [self.rates.get(n, x) for n, x in zip(scene.velocities, start_of(scene).velocity, strict=True)]
        known = {graph.symbol(name): value for name, value in self.parameters(part).items()}
        known[graph.symbol(TIME)] = np.zeros(())
        for k, position, rate in zip(moved.place, moved.position, moved.velocity, strict=True):
            place = scene.coordinates.index(scene.velocities[k].removesuffix("_dot"))
            q[place], u[k] = position, rate
        runs = len(range(self.count)[part])
        found = np.empty((len(q) + len(u), runs))
        with np.errstate(all="ignore"):
            for row, one in zip(found, (*q, *u), strict=True):
                if isinstance(one, np.ndarray):
                    row[:] = one[part]
                else:
                    entry = one.express(graph) if isinstance(one, Quantity) else one
                    row[:] = evaluate([entry], Batches(), known)[0]
        positions, rates = found[: len(q)].T.copy(), found[len(q) :].T.copy()
        names = list(scene.coordinates)
        for group in quaternions(scene):
            turn = slice(names.index(group[0]), names.index(group[0]) + 4)
            with np.errstate(all="ignore"):
                positions[:, turn] /= np.linalg.norm(positions[:, turn], axis=1, keepdims=True)
        return positions, rates

    def one(self, k: int) -> tuple[dict[str, float], dict[str, Any], dict[str, Any]]:
        """Return values, start and rates of one run, as `simulate` takes them."""
        values = {name: float(one[k]) for name, one in self.values.items()}
        start, rates = (
            {name: float(one[k]) if isinstance(one, np.ndarray) else spell(one) for name, one in given.items()}
            for given in (self.start, self.rates)
        )
        return values, start, rates


def read_lanes(problem: Problem, start: object, rates: object, values: object, faults: Faults) -> Lanes:
    """Return the runs of an ensemble; whatever is wrong is among the faults.

    Args:
        problem: the mechanism, and where runs start of which nothing else is given.
        start: numbers, formulas or arrays by coordinate, or formulas as "q1=0.3,q2=pi/2".
        rates: likewise by velocity, or by coordinate where the velocity is its rate.
        values: likewise by parameter, without symbols.
        faults: takes what is wrong.
    """
    scene, (usual, usual_rates) = problem.scene, problem.by_name
    given = {
        "start": {**usual, **by_name(start, "start", faults)},
        "start rates": {**usual_rates, **by_name(rates, "start rates", faults)},
        "values": by_name(values, "values", faults),
    }
    lengths: dict[str, int] = {}
    read: dict[str, dict[str, Any]] = {what: {} for what in given}
    known = {
        "start": scene.coordinates,
        "start rates": scene.velocities,
        "values": tuple(p.name for p in scene.parameters),
    }
    for what, entries in given.items():
        for name, raw in entries.items():
            spelled = velocity_name(name) if what == "start rates" and name not in scene.velocities else name
            if spelled not in known[what]:
                faults.add(what, f"{name} is not known; {suggestion(name, known[what])}")
            elif spelled in read[what]:
                faults.add(what, f"{spelled} is given twice")
            elif isinstance(raw, str | Quantity) or np.ndim(raw) == 0:
                read[what][spelled] = raw.item() if isinstance(raw, np.ndarray) else raw
            else:
                array = _array(raw, f"{what}: {name}", faults)
                if array is not None:
                    read[what][spelled] = array
                    lengths[f"{what} {name}"] = len(array)
    counts = {n for n in lengths.values() if n != 1}
    if len(counts) > 1:
        told = ", ".join(f"{name} has {n}" for name, n in lengths.items())
        faults.add("", f"arrays of different lengths: {told}; give each a number for every run")
    count = max(counts) if counts and 0 not in counts else 0 if counts else 1
    arrays: dict[str, Array] = {}
    plain: dict[str, Any] = {}
    for name, one in read["values"].items():
        (arrays if isinstance(one, np.ndarray) else plain)[name] = one
    arrays = {name: np.broadcast_to(one, (count,)) if len(one) in (1, count) else one for name, one in arrays.items()}
    _positive(scene, arrays, faults)
    bound = _bound(scene, plain, arrays, faults)
    with faults.noted():
        allowed, units, places = parameter_values(bound), SceneUnits(bound).letters, bound.coordinates
        _prescribed(bound, read, faults)
        for what in ("start", "start rates"):
            for name, one in read[what].items():
                if isinstance(one, np.ndarray):
                    read[what][name] = np.broadcast_to(one, (count,)) if len(one) in (1, count) else one
                else:
                    unit = units.get(velocity_name(name) if what == "start rates" and name in places else name, "")
                    read[what][name] = read_formula(one, allowed, f"{what}: {name}", faults, unit=unit)
    return Lanes(bound, count, read["start"], read["start rates"], arrays)


def _array(raw: object, where: str, faults: Faults) -> Array | None:
    """Return a number for every run; None after a fault."""
    try:
        found = np.array(raw, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        faults.add(where, "is no array of numbers; give a number for every run")
        return None
    if found.ndim != 1:
        faults.add(where, f"has shape {found.shape}; give a number for every run, shape (N,)")
        return None
    wrong = np.flatnonzero(~np.isfinite(found))
    if len(wrong):
        faults.add(where, f"run {wrong[0]} has {found[wrong[0]]}; every run needs a finite number")
        return None
    return found


def _positive(scene: Scene, arrays: Mapping[str, Array], faults: Faults) -> None:
    for p in scene.parameters:
        if not (p.positive and p.name in arrays):
            continue
        wrong = np.flatnonzero(arrays[p.name] <= 0)
        if len(wrong):
            worst = arrays[p.name][wrong[0]]
            faults.add(f"values: {p.name}", f"run {wrong[0]} has {worst:g}; it must be positive")


def _bound(scene: Scene, plain: Mapping[str, Any], arrays: Mapping[str, Array], faults: Faults) -> Scene:
    """Return the scene with its values, what is varied at values near those of the runs."""
    near = {name: float(one[0]) if len(one) else 1.0 for name, one in arrays.items()}
    for p in scene.parameters:
        if p.name in arrays and not len(arrays[p.name]) and p.value is not None:
            near[p.name] = _number(p.value)
    for off in (OFF, 1.0):
        own = Faults("")
        with own.noted():
            off_these = {name: x * off or (0.0 if off == 1.0 else 1.0) for name, x in near.items()}
            return bind(scene, {**plain, **off_these}) if plain or near else scene
    faults.lines += own.lines
    return scene


def _prescribed(scene: Scene, read: Mapping[str, Mapping[str, Any]], faults: Faults) -> None:
    moved = {scene.velocities[k] for k in scene.led_velocities}
    for name in (*map(velocity_name, read["start"]), *read["start rates"]):
        if name in moved:
            said = name.removesuffix("_dot")
            faults.add("start", f"{said} has a prescribed motion, which says how it starts")


def _number(value: Quantity) -> float:
    return float(evaluate([value.express(Graph())], Batches(), {})[0])
