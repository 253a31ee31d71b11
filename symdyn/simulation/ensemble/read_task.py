"""Many runs of one scene, as they are asked for, and the mode that runs them: the fastest one that applies.

Numbers and formulas stand for all runs; arrays have a number for each. What is varied is not written into equations:
these are made once, at values that are like those of the runs and decide nothing about their form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.scene import Quantity, Scene, SceneUnits, bind
from symdyn.scene.values import Faults, suggestion, velocity_name
from symdyn.simulation.ensemble import lockstep, one_by_one, taylor_lockstep
from symdyn.simulation.ensemble.measures import Measure, read_measures
from symdyn.simulation.ensemble.task import Lanes, RunMode, Task, number
from symdyn.simulation.initial import by_name
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.prescribed.forces import Forces, held
from symdyn.simulation.prescribed.formulas_in_time import parameter_values, read_formula
from symdyn.simulation.problem import Problem, Run

RTOL = 1e-9
"""Tolerance if none is given."""

MODES = (lockstep.MODE, taylor_lockstep.MODE, one_by_one.MODE)
"""In the order in which they are tried; the last one takes everything."""


def read_task(
    problem: Problem,
    run: Run,
    start: object,
    start_rates: object,
    values: object,
    measures: str | Measure | Sequence[str | Measure],
    samples: bool = False,
    workers: int | None = None,
) -> Task:
    """Return the runs that are asked for, and how they will be run; arguments as of `symdyn.ensemble`.

    Raises:
        SimulateError: with every fault, one line each.
        SceneError: a value that the scene cannot have.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    texts = (measures,) if isinstance(measures, str | Measure) else tuple(measures)
    faults = Faults("")
    lanes = read_lanes(problem, start, start_rates, values, faults)
    given = faults.taken(lambda: replace(problem, scene=lanes.scene).driving, Forces())
    read = faults.taken(lambda: read_measures(lanes.scene, texts, faults), ())
    _, times = faults.taken(lambda: run.checked(lanes.scene), ((), np.zeros(1)))
    if workers is not None and workers < 1:
        faults.add("", f"workers = {workers} is no number of threads; give 1 or more, or none")
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    asked = METHODS.get((run.method or "").lower())
    usual = asked.rtol if asked is not None and asked.beyond_doubles else RTOL
    relative = usual if run.rtol is None else run.rtol
    absolute = relative if run.atol is None else run.atol
    task = Task(
        lanes, given, times, run.every, read, tuple(run.stops), relative, absolute,
        None if run.method is None else run.method.lower(), samples, run.ignore_limits, one_by_one.MODE,
    )  # fmt: skip
    mode, why = choose(task)
    tolerance = f"tolerance {relative:g}" if relative == absolute else f"tolerances {relative:g}, {absolute:g}"
    notes = (
        f"method: {mode.name} ({mode.library}), {tolerance}{f' ({why})' if why else ''}",
        *(
            line
            for one in mode.methods
            if not METHODS[one].absolute
            for line in METHODS[one].tolerances(one, run.rtol, run.atol)[2]
        ),
        *held(lanes.scene, given, run.until),
    )
    return replace(task, mode=mode, notes=notes)


def choose(task: Task) -> tuple[RunMode, str]:
    """Return the mode that runs a task, and why no faster one does, "" if none was refused."""
    why: list[str] = []
    for mode in MODES:
        if mode.methods and task.method is not None and task.method not in mode.methods:
            continue
        reason = mode.refuses(task)
        if not reason:
            return mode, "; ".join(dict.fromkeys(why))
        why.append(reason)
    raise AssertionError("the last mode takes everything")


OFF = 1 + 1 / 17
"""Equations are made at values so much off those of a run, lest a zero or an equality there decide their form."""


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
            near[p.name] = number(p.value)
    for off in (OFF, 1.0):
        own = Faults("")
        with own.noted():
            off_these = {name: x * off or (0.0 if off == 1.0 else 1.0) for name, x in near.items()}
            return bind(scene, {**plain, **off_these}) if plain or near else scene
    faults.lines += own.lines
    return scene


def _prescribed(scene: Scene, read: Mapping[str, Mapping[str, Any]], faults: Faults) -> None:
    moved = {scene.velocities[k] for k in scene.prescribed_velocities}
    for name in (*map(velocity_name, read["start"]), *read["start rates"]):
        if name in moved:
            said = name.removesuffix("_dot")
            faults.add("start", f"{said} has a prescribed motion, which says how it starts")
