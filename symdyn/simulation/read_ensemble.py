"""Many runs of one scene, as they are asked for, and the mode that runs them: the fastest one that applies.

Numbers and formulas stand for all runs; arrays have a number for each. What is varied is not written into equations:
these are made once, at values that are like those of the runs and decide nothing about their form.

One mode stands here: runs in lockstep by heyoka's Taylor method in batch mode, as many lanes as a vector has, each with
its own step. It is for smooth trees that nothing ends before their time, needs no C compiler, and is the one for the
last digits.

Reference: Biscani and Izzo, Revisiting high-order Taylor methods for astrodynamics and celestial mechanics (2021).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.errors import SimulateError, suggestion
from symdyn.graph import Expr, evaluate, reachable
from symdyn.interrupts import interrupts_wait
from symdyn.program import Program
from symdyn.runtime import load_program
from symdyn.scene import Quantity, Scene, SceneUnits, parse, with_values
from symdyn.scene.values import Faults, velocity_name
from symdyn.simulation import lockstep
from symdyn.simulation.ensemble_task import (
    ONE_BY_ONE,
    Lanes,
    RunBlock,
    RunMode,
    Runner,
    Task,
    one_after_other,
    replaced,
)
from symdyn.simulation.equations.controller import Feedback, placed, read_feedback
from symdyn.simulation.equations.linear_feedback import Gains
from symdyn.simulation.forward import LARGEST
from symdyn.simulation.initial import by_name
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.integrate.heyoka_expressions import BRANCHED, UNSEEN, Expressions, library
from symdyn.simulation.integrate.integration import END
from symdyn.simulation.integrate.taylor import SHORTEST, SMALLEST
from symdyn.simulation.measures import Measures, Sums, read_measures, sums_of
from symdyn.simulation.prescribed.forces import Forces, held
from symdyn.simulation.prescribed.formulas_in_time import parameter_values, read_formula
from symdyn.simulation.problem import Problem, Run

CHUNK = 512
"""Runs whose samples are looked at together."""


def _no_series(task: Task) -> str:
    """Return why series are not taken."""
    if not METHODS["taylor"].installed:
        return "heyoka is not installed"
    why = lockstep.shape(task)
    if why:
        return why
    if task.method is None and lockstep.stiff(task):
        return "the system is stiff"
    if quaternions(task.scene):
        return "quaternions are brought back to length 1 after steps"
    made = lockstep.functions(task)
    if made.watched and not task.ignore_limits:
        return "a joint's limit, or a formula, may end a run"
    nodes = [node for node in reachable(made.program["rates"].function.entries) if node.args]
    branches = sorted({node.op.name.lower() for node in nodes if node.op.turns or node.op in (*UNSEEN, *BRANCHED)})
    if branches:
        return f"a series may overlook a turn of {' and '.join(branches)}"
    return f"{len(nodes)} operations would take heyoka long to compile" if len(nodes) > LARGEST else ""


def _taylor(task: Task) -> Runner:
    """Return what runs a part, on one integrator."""
    made = lockstep.functions(task)
    calls, rates = load_program(made.program), made.program["rates"].function
    hy = library()
    lanes = max(1, hy.recommended_simd_size())
    symbols = {a.name: a.symbols for a in rates.arguments}
    states = [*symbols["q"], *symbols["qd"]]
    variables = [hy.expression(str(one.value)) for one in states]
    known: dict[Expr, Any] = dict(zip(states, variables, strict=True))
    known[symbols[TIME][0]] = hy.time
    known |= {one: hy.par[k] for k, one in enumerate(symbols.get(lockstep.VALUES, ()))}
    entries = evaluate(rates.entries, Expressions(), known)
    with interrupts_wait():
        system = list(zip(variables, entries, strict=True))
        ta = hy.taylor_adaptive_batch(system, np.zeros((len(states), lanes)), tol=max(task.rtol, SMALLEST))
    again = one_after_other(task)

    def run(part: slice) -> RunBlock:
        x = task.begun(part)
        parameters = task.lanes.parameters(part)
        values = np.empty((len(x), made.values))
        if made.values:
            given = np.array([np.broadcast_to(parameters[name], len(x)) for name in made.parameters]).T
            values[:] = calls[Program.PREPARE](np.ascontiguousarray(given))
        nq = len(task.scene.coordinates)
        times = task.times if task.insides or task.keep else task.times[-1:]  # nobody looks at samples
        found = np.empty((len(x), len(times), x.shape[1]))
        for k in range(0, len(x), lanes):
            rows = np.minimum(np.arange(k, k + lanes), len(x) - 1)
            grid = _grid(ta, x[rows], values[rows], times)
            found[k : k + lanes] = grid[: len(x) - k]
        sums: dict[Any, Sums] = {}
        if made.seen:
            given_values = (values[:, None],) if made.values else ()
            with np.errstate(all="ignore"):
                seen = calls["seen"](found[..., :nq], found[..., nq:], task.times, *given_values)
            sums = {one: sums_of(task.times, seen[..., k]) for k, one in enumerate(task.insides)}
        end = found[:, -1]
        block = RunBlock(
            np.full(len(x), task.until), end[:, :nq].copy(), end[:, nq:].copy(), (END,) * len(x), sums,
            found if task.keep else None,
        )  # fmt: skip
        lost = np.isnan(end).any(axis=1) | np.isinf(end).any(axis=1)
        return replaced(task, block, part, np.asarray(lost), again)

    return Runner(run)


def _grid(ta: Any, x: Array, values: Array, times: Array) -> Array:
    """Return states (lanes, T, nx) of some runs at times; NaN where one leaves what doubles hold."""
    lanes = len(x)
    ta.set_time(0.0)
    ta.state[:] = x.T
    ta.pars[:] = values.T[: len(ta.pars)]
    sure = _sure_step(ta)
    first = times[times <= sure]
    ahead = np.unique([0.0, *first, min(sure, times[-1])])
    rest = np.append(ahead[-1], times[len(first) :])
    found = np.full((len(times), x.shape[1], lanes), np.nan)
    parts = ((ahead, np.searchsorted(ahead, first), slice(0, len(first)), sure),
             (rest, np.arange(1, len(rest)), slice(len(first), None), np.inf))  # fmt: skip
    for grid, rows, at, longest in parts:
        if len(grid) > 1:  # a grid begins where the integrator stands
            _, states = ta.propagate_grid(np.tile(grid[:, None], lanes), max_delta_t=[longest] * lanes)
            found[at] = states[rows]
        elif at.start == 0:
            found[at] = x.T
    return found.transpose(2, 0, 1)


def _sure_step(ta: Any) -> float:
    """Return a first step that is short enough for all lanes, as `taylor` takes it: the last orders may vanish."""
    state = ta.state.copy()
    ta.step(max_delta_t=[SHORTEST] * state.shape[1], write_tc=True)
    norms = np.abs(ta.tc).max(axis=0)
    ta.set_time(0.0)
    ta.state[:] = state
    orders = np.arange(4, len(norms))[:, None]
    with np.errstate(all="ignore"):
        radius = np.nanmin((np.maximum(1.0, norms[0]) / norms[4:]) ** (1.0 / orders), initial=np.inf)
    return float(radius) / math.e**2 if radius > 0 else 1e-6


TAYLOR = RunMode(
    "taylor lockstep",
    "as many runs in lockstep as a vector has lanes, by Taylor's method",
    "heyoka",
    CHUNK,
    _taylor,
    _no_series,
    ("taylor",),
    False,
)


RTOL = 1e-9
"""Tolerance if none is given."""

MODES = (lockstep.MODE, TAYLOR, ONE_BY_ONE)
"""In the order in which they are tried; the last one takes everything."""


def read_task(
    problem: Problem,
    run: Run,
    start: object,
    start_rates: object,
    values: object,
    measures: Measures,
    samples: bool = False,
    workers: int | None = None,
    feedback: object = None,
) -> Task:
    """Return the runs that are asked for, and how they will be run; arguments as of `symdyn.ensemble`.

    Raises:
        SimulateError: with every fault, one line each.
        SceneError: a value that the scene cannot have.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    texts = tuple(measures) if isinstance(measures, Sequence) and not isinstance(measures, str) else (measures,)
    faults = Faults("")
    lanes = read_lanes(problem, start, start_rates, values, faults)
    given = faults.taken(lambda: replace(problem, scene=lanes.scene).driving, Forces())
    given, controller = faults.taken(lambda: with_feedback(lanes.scene, given, feedback, run.until), (given, None))
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
        lanes, given, times, run.every, read, tuple(map(str, run.stops)), relative, absolute,
        None if run.method is None else run.method.lower(), samples, run.ignore_limits, ONE_BY_ONE,
        feedback=controller,
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


def with_feedback(scene: Scene, forces: Forces, feedback: object, until: float) -> tuple[Forces, Feedback | None]:
    """Return forces of a controller that is nothing but gains with what acts beside it, or else the controller.

    Raises:
        SimulateError: with every fault of the controller.
    """
    if feedback is None:
        return forces, None
    found = read_feedback(scene, feedback)
    at = placed(scene, found, until)
    formulas = found.law.formulas if isinstance(found.law, Gains) and not found.given.keys() - {"inputs"} else None
    if (
        formulas is None
        or forces.functions
        or {*forces.outside, *(k for k in at.places if k in forces.formulas)} & {*at.places}
    ):
        return forces, found
    own = dict(zip(at.places, map(parse, formulas.values()), strict=True))
    return replace(forces, formulas={**forces.formulas, **own}), None


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
        "start": (*scene.coordinates, *(one.name for one in scene.states)),
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
                    read[what][name] = read_formula(one, allowed, f"{what}: {name}", faults, unit=unit, scene=bound)
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
            near[p.name] = float(p.value)
    for off in (OFF, 1.0):
        own = Faults("")
        with own.noted():
            off_these = {name: x * off or (0.0 if off == 1.0 else 1.0) for name, x in near.items()}
            return with_values(scene, {**plain, **off_these}) if plain or near else scene
    faults.lines += own.lines
    return scene


def _prescribed(scene: Scene, read: Mapping[str, Mapping[str, Any]], faults: Faults) -> None:
    moved = {scene.velocities[k] for k in scene.prescribed_velocities}
    for name in (*map(velocity_name, read["start"]), *read["start rates"]):
        if name in moved:
            said = name.removesuffix("_dot")
            faults.add("start", f"{said} has a prescribed motion, which says how it starts")
