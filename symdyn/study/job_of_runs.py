"""Many runs of one scene: the function `ensemble`, and the jobs of `sweep`, read and checked, block by block."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeAlias, Unpack

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.arguments import native, with_fields
from symdyn.errors import SimulateError, SymdynError, spoken
from symdyn.scene import Scene, SceneLike, bind
from symdyn.scene.values import Faults, Parameter, ask_for_units, split_commas
from symdyn.simulation import Forces, Measure, Measures, Problem, Run, RunBlock, read_feedback, read_task
from symdyn.simulation.prescribed import Entries, words
from symdyn.study.design import read_design
from symdyn.study.distributions import Over, middle, read_over
from symdyn.study.job import BlockResult, Job, Measured, Wanted, check_names, impossible, read_measured, units_of
from symdyn.study.runs import ENDED, FAILED, MOST_TOLD, NOT_MADE, STOPPED, Ends, Runs

NO_NUMBER = "the motion has no finite value"


@with_fields(Run)
def ensemble(
    scene: SceneLike | Problem,
    *,
    forces: Forces | Entries = (),
    start: Mapping[str, Any] | str | None = None,
    start_rates: Mapping[str, Any] | str | None = None,
    values: Mapping[str, Any] | str | None = None,
    measures: Measures = (),
    samples: bool = False,
    feedback: object = None,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
    **fields: Unpack[Run.Fields],
) -> Runs:
    """Return many runs of a scene from t = 0 on, each as `simulate` would run it.

    Starts and values of parameters are numbers or formulas for all runs, or arrays with a number for each.
    Equations are made and compiled once.

    >>> import symdyn
    >>> cart = symdyn.example("cart_pole")
    >>> runs = symdyn.ensemble(cart, until=1, start={"theta": [0.1, 0.2, 0.3]}, measures="max(abs(x))")
    >>> runs["max(abs(x))"].round(5)
    array([0.02531, 0.02741, 0.02949])

    Interrupted (Ctrl-C), it returns what was done; the other runs are not made, and NaN.

    Args:
        scene: the mechanism; parameters that vary need no value of their own. Of a `Problem`, what the runs start from
            goes before its start, name by name.
        **fields: of `Run`.
        forces: driving forces of all runs, as for `simulate`.
        start: by coordinate, numbers, formulas in parameters, or arrays of shape (N,).
        start_rates: likewise by velocity.
        values: likewise by parameter, without symbols.
        measures: formulas of statistics over a run's samples, such as "max(abs(q1)) - end(q2)", see `FOLDS`; or
            functions of a run.
        samples: whether to keep the states at the samples.
        feedback: a controller of all runs, as for `simulate`; its noise is the same in each. Gains alone are formulas
            of forces, and as fast; with others `simulate` makes the runs.
        workers: threads; None for one a core. Runs by `simulate` itself go one after the other; `sweep` has processes.
        progress: called with the share that is done.
        say: called with lines for the user.
        rtol: relative tolerance of a step; None is 1e-9, of `gauss` what it takes itself.
            Below 1e-16 runs have 31 digits (`gauss`), one by one; what is returned are doubles.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
        SceneError: a value that the scene cannot have.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    problem, run = Problem.requested(ensemble, locals(), "start", "start_rates", "values")
    (samples,), began = native(bool, samples), time.perf_counter()
    task = read_task(problem, run, start, start_rates, values, measures, samples, workers, feedback)
    given: Any = words(split_commas(values), "values", Faults("")) if isinstance(values, str) else values
    pairs = [] if given is None else [(name, middle(x)) for name, x in given.items()]
    ask_for_units(problem.scene.parameters, pairs, "values")
    found, wall = task.run(workers, progress, say)
    preparing = time.perf_counter() - began - wall
    bound, varied = task.scene, task.lanes.varied
    states = (*bound.coordinates, *bound.velocities)
    units = units_of(bound, (*varied, *states))
    units |= {f"end({name})": units[name] for name in states} | {one.text: one.unit(bound) for one in task.measures}
    about = {
        "design": "given", "count": task.lanes.count, "method": task.mode.name, "rtol": task.rtol, "atol": task.atol,
        "steps": found.steps, "preparing": preparing,
    }  # fmt: skip
    columns = [np.empty((task.lanes.count, 0)), *(column[:, None] for column in varied.values())]
    return Runs(
        bound.name, tuple(varied), units, np.hstack(columns), task.measured(found), *endings(found), about, found.notes,
        wall, Ends(states, found.t, found.q, found.u, task.times, found.samples),
    )  # fmt: skip


def endings(found: RunBlock) -> tuple[NDArray[np.uint8], dict[int, str]]:
    """Return how each run ended, a key of `WORDS`, and in words what ended those that did not reach their end."""
    began, whole = np.isfinite(found.q).all(axis=1), found.complete
    codes = np.where(began, np.where(whole, ENDED, STOPPED), FAILED)
    codes[found.interrupted] = NOT_MADE
    words = {int(row): found.stopped[row] for row in np.flatnonzero(~whole & ~found.interrupted)}
    return codes.astype(np.uint8), words | {int(row): NO_NUMBER for row in np.flatnonzero(whole & ~began)}


LANES, LARGE, MOST = 64, 8192, 32768
"""Runs of a block, where nothing else is given: a part of all of them, so that there is progress, in multiples of what
compiled code takes in lockstep; of many, in multiples of what keeps threads busy."""

PARTS = 16


def runs_job(
    problem: Problem,
    run: Run,
    over: Over,
    measure: Wanted,
    feedback: object,
    design: str | None,
    count: int | None,
    seed: int,
    size: int | None,
    faults: Faults,
) -> Job:
    """Return what `sweep` is to make; arguments as there, `size` being its block.

    Raises:
        SimulateError: with every fault, those that there are already among them.
    """
    scene, forces = problem.scene, problem.forces
    if isinstance(forces, Forces):
        faults.add("forces", "parsed forces have no text for a store; give them as formulas, tables or files")
        forces = ()
    said = [forces] if isinstance(forces, str) else forces
    letters = _letters(said)
    varied = read_over(scene, over, letters, faults)
    planned = read_design(varied, design, count, seed, faults)
    if size is not None and size < 1:
        faults.add("block", f"{size} is no number of runs; give 1 or more")
    names = [one.name for one in varied]
    known = {one.name for one in scene.parameters}
    if planned is not None and not faults.lines:
        first = dict(zip(names, planned.values(0, 1)[0].tolist(), strict=True))
        free = {one.name: first[one.name] for one in scene.free_parameters if one.name in first}
        moving = {*known, *scene.coordinates, *scene.first_order}
        more = tuple(Parameter(name) for name in names if name not in moving)
        scene = bind(
            replace(scene, parameters=(*scene.parameters, *more)), free | {p.name: first[p.name] for p in more}
        )
    parts = {
        "values": [name for name in names if name in {one.name for one in scene.parameters}],
        "start": [name for name in names if name in (*scene.coordinates, *(one.name for one in scene.states))],
        "start_rates": [name for name in names if name in scene.velocities],
    }
    start, rates = faults.taken(lambda: problem.by_name, ({}, {}))
    given = {"start": start, "start_rates": rates}
    for part, table in given.items():
        for name in set(table) & set(parts[part]):
            faults.add(part.replace("_", " "), f"{name} is varied; leave it out here")
    measures = tuple(_checked(scene, one, faults) for one in read_measured(measure, faults))
    check_names(measures, names, faults)
    problem, read = replace(problem, scene=scene, forces=forces), Forces()
    if not scene.free_parameters or not faults.lines:
        read, _, _, _ = problem.posed(run, faults)
    feedback = None if feedback is None else faults.taken(lambda: read_feedback(scene, feedback), None)
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    assert planned is not None, "what is missing is a fault"
    plain = {"until": run.until, **given, "forces": _said(forces), "feedback": _law_said(feedback), **vars(run)}
    told = tuple((key, str(value)) for key, value in plain.items() if value not in (None, (), [], {}, False, ""))
    asked = {**given, "forces": read, "feedback": feedback, "run": run, "varied": parts}
    return Job("runs", block, scene, planned, measures, asked, told, size or usual_block(planned.count))


def usual_block(count: int) -> int:
    """Return how many runs a block has of so many.

    >>> usual_block(100), usual_block(10_000), usual_block(10**5), usual_block(10**9)
    (64, 640, 8192, 32768)
    """
    share = -(-count // PARTS)
    unit = LANES if share <= LARGE // 2 else LARGE
    return min(MOST, max(unit, -(-share // unit) * unit))


def _checked(scene: Scene, one: Measured, faults: Faults) -> Measured:
    """Return a measure with its unit; what is wrong with it is among the faults."""
    if one.function is not None:
        return one
    read = Measure.read(scene, one.formula, faults)
    called = one.name if one.name.isidentifier() else ""  # what has no name is called as it is written
    return one if read is None else replace(one, unit=read.unit(scene, called))


def _letters(forces: Any) -> tuple[str, ...]:
    several = forces if isinstance(forces, Sequence) else [forces]  # a function, for one, has no formulas
    texts = forces.values() if isinstance(forces, Mapping) else [spoken(one).partition("=")[2] for one in several]
    return tuple(dict.fromkeys(word for text in texts for word in re.findall(r"[A-Za-z]\w*", spoken(text))))


def _said(forces: Entries) -> str:
    """Return what decides forces, as text: formulas, and what files hold."""
    if isinstance(forces, str | Path):
        return _said([forces])
    if isinstance(forces, Mapping):
        return "; ".join(f"{name}={_text(one)}" for name, one in forces.items())
    return "; ".join(map(_text, forces)) if isinstance(forces, Sequence) else _text(forces)


def _law_said(feedback: Any) -> str:
    """Return what decides a controller, as text: its settings, and the numbers of its law; of a function its name."""
    if feedback is None:
        return ""
    law = feedback.law
    parts = {} if not is_dataclass(law) else {one.name: getattr(law, one.name) for one in fields(law)}
    numbers = {name: one.tolist() if isinstance(one, np.ndarray) else one for name, one in parts.items()}
    return repr({**(numbers or {"law": _text(law)}), **feedback.given, "scene": ""})


def _text(one: Any) -> str:
    if isinstance(one, str | Path) and "=" not in str(one):
        with suppress(OSError):
            return f"{Path(one).name} {sha256(Path(one).read_bytes()).hexdigest()}"
    if isinstance(one, str | int | float | Fraction):
        return "".join(str(one).split())
    if isinstance(one, Mapping):
        return _said(one)
    with suppress(TypeError, ValueError):
        return sha256(np.asarray(one, dtype=np.float64).tobytes()).hexdigest()
    return getattr(one, "__qualname__", type(one).__qualname__)


def block(job: Job, first: int, last: int) -> BlockResult:
    """Return measures over runs; those at values that the scene cannot have fail alone, and the others go on."""
    values = job.design.values(first, last)
    measures = np.full((len(values), len(job.measures)), np.nan)
    codes = np.full(len(values), FAILED, dtype=np.uint8)
    told, notes = impossible(job, values), dict[str, None]()
    rows = np.array([row for row in range(len(values)) if row not in told], dtype=np.int64)
    for some, found, measured in _possible(job, values, rows, told):
        if found.interrupted.any():
            raise KeyboardInterrupt
        notes |= dict.fromkeys(found.notes)
        codes[some], words = endings(found)
        for column, one in enumerate(job.measures):
            measures[some, column] = measured[one.formula]
        told |= {int(some[row]): word for row, word in words.items()}
    measures[codes == FAILED] = np.nan
    return BlockResult(
        measures, codes, dict(sorted((first + row, word) for row, word in told.items())[:MOST_TOLD]), tuple(notes)
    )


Some: TypeAlias = tuple[NDArray[np.int64], RunBlock, dict[str, Array]]
"""Rows of a block, their runs, and measures of these by their formulas."""


def _possible(job: Job, values: Array, rows: NDArray[np.int64], reported: dict[int, str]) -> Iterator[Some]:
    """Yield rows and their runs; rows that spoil the others are found by halving, and their words go to `reported`."""
    if not len(rows):
        return
    try:
        found = _together(job, values[rows])
    except SymdynError as fault:
        if len(rows) == 1:
            reported[int(rows[0])] = " ".join(str(fault).split())
            return
        for half in np.array_split(rows, 2):
            yield from _possible(job, values, half, reported)
        return
    yield rows, *found


def _together(job: Job, values: Array) -> tuple[RunBlock, dict[str, Array]]:
    """Return runs at these values in lanes, as `ensemble` makes them, and their measures."""
    asked, columns = job.requested, dict(zip(job.design.names, values.T, strict=True))
    parts = {
        part: dict(asked.get(part, {})) | {n: columns[n] for n in names} for part, names in asked["varied"].items()
    }
    problem = Problem(job.scene, asked["forces"])
    formulas = [
        one.formula if one.function is None else Measure.of_run(one.formula, one.function) for one in job.measures
    ]
    task = read_task(
        problem, asked["run"], parts["start"], parts["start_rates"], parts["values"], formulas, workers=job.threads,
        feedback=asked["feedback"],
    )  # fmt: skip
    found, _ = task.run(job.threads)
    return found, task.measured(found)
