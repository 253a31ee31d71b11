"""Many runs in one call: the function `ensemble`.

Runs are handed out in parts of a fixed number, so that the same runs give the same bytes on any number of threads.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import replace
from typing import Any, Unpack

import numpy as np

from symdyn.arguments import native, with_fields
from symdyn.errors import SimulateError
from symdyn.scene import SceneLike
from symdyn.scene.values import Faults
from symdyn.simulation.ensemble import lockstep, one_by_one, taylor_lockstep
from symdyn.simulation.ensemble.ensemble import Ensemble
from symdyn.simulation.ensemble.lanes import read_lanes
from symdyn.simulation.ensemble.measures import Measure, read_measures
from symdyn.simulation.ensemble.task import RunBlock, RunMode, Runner, Task, joined, nothing
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import Forces, held
from symdyn.simulation.problem import Problem, Run
from symdyn.simulation.trajectory import END

RTOL = 1e-9
"""Tolerance if none is given."""

WAYS: Mapping[str, RunMode] = {
    "lockstep": lockstep.WAY,
    "taylor lockstep": taylor_lockstep.WAY,
    "one by one": one_by_one.WAY,
}
"""By name, in the order in which they are tried; the last one takes everything."""


@with_fields(Run)
def ensemble(
    scene: SceneLike | Problem,
    *,
    forces: Forces | Entries = (),
    start: Mapping[str, Any] | str | None = None,
    start_rates: Mapping[str, Any] | str | None = None,
    values: Mapping[str, Any] | str | None = None,
    measures: str | Measure | Sequence[str | Measure] = (),
    samples: bool = False,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
    **fields: Unpack[Run.Fields],
) -> Ensemble:
    """Return many runs of a scene from t = 0 on, each as `simulate` would run it.

    Starts and values of parameters are numbers or formulas for all runs, or arrays with a number for each.
    Equations are made and compiled once.

    >>> import symdyn
    >>> cart = symdyn.example("cart_pole")
    >>> runs = symdyn.ensemble(cart, until=1, start={"theta": [0.1, 0.2, 0.3]}, measures="max(abs(x))")
    >>> runs["max(abs(x))"].round(5)
    array([0.02531, 0.02741, 0.02949])

    Interrupted (Ctrl-C), it returns what was done; the other runs are NaN.

    Args:
        scene: the mechanism; parameters that vary need no value of their own. Of a `Problem`, what the runs start from
            goes before its start, name by name.
        **fields: of `Run`.
        forces: driving forces of all runs, as for `simulate`.
        start: by coordinate, numbers, formulas in parameters, or arrays of shape (N,).
        start_rates: likewise by velocity.
        values: likewise by parameter, without symbols.
        measures: formulas of folds over a run, such as "max(abs(q1)) - end(q2)", see `FOLDS`; they see samples alone.
        samples: whether to keep the states at the samples.
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
    (samples,), begin = native(bool, samples), time.perf_counter()
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
        None if run.method is None else run.method.lower(), samples, run.ignore_limits,
    )  # fmt: skip
    name, way, why = choose(task)
    tolerance = f"tolerance {relative:g}" if relative == absolute else f"tolerances {relative:g}, {absolute:g}"
    notes = [
        f"method: {name} ({way.library}), {tolerance}{f' ({why})' if why else ''}",
        *(
            line
            for one in way.methods
            if not METHODS[one].absolute
            for line in METHODS[one].tolerances(one, run.rtol, run.atol)[2]
        ),
        *held(lanes.scene, given, run.until),
    ]
    tell = say or (lambda line: None)
    for note in notes:
        tell(note)
    runner = way.ready(task)
    ready = time.perf_counter()
    found = joined(task, [*_run(task, way, runner, workers or _cores(), progress)])
    words = (END, *dict.fromkeys(one for one in found.stopped if one != END))
    place = {one: k for k, one in enumerate(words)}
    known = lanes.parameters()
    for note in found.notes:
        tell(note)
    return Ensemble(
        lanes.scene, lanes.varied, found.t, found.q, found.u,
        {one.text: np.broadcast_to(one.value(found.sums, known), (lanes.count,)) for one in read},
        times, np.array([place[one] for one in found.stopped], dtype=np.int64), words, found.samples, name,
        relative, absolute, found.steps, ready - begin, time.perf_counter() - ready, (*notes, *found.notes),
    )  # fmt: skip


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _run(
    task: Task, way: RunMode, runner: Runner, workers: int, progress: Callable[[float], None] | None
) -> Iterator[RunBlock]:
    """Yield parts in their order; those that an interrupt leaves undone are empty."""
    count = task.lanes.count
    parts = [slice(k, min(k + way.part, count)) for k in range(0, count, way.part)]
    done: dict[int, RunBlock] = {}
    try:
        for k, block in _parts(parts, runner, workers if way.threads else 0):
            done[k] = block
            if progress is not None:
                progress(len(done) / len(parts))
    except KeyboardInterrupt:
        pass
    for k, part in enumerate(parts):
        yield done.get(k) or nothing(task, part.stop - part.start)


def _parts(parts: Sequence[slice], runner: Runner, workers: int) -> Iterator[tuple[int, RunBlock]]:
    """Yield parts as they are done, on so many threads, none for this one; of an interrupt those half done too."""
    if workers == 0:
        for k, part in enumerate(parts):
            yield k, runner.run(part)
        return
    pool = ThreadPoolExecutor(min(workers, max(1, len(parts))))
    waiting = {pool.submit(runner.run, part): k for k, part in enumerate(parts)}
    try:
        while waiting:
            for one in wait(waiting, return_when=FIRST_COMPLETED).done:
                yield waiting.pop(one), one.result()
    except KeyboardInterrupt:
        runner.halt()
        pool.shutdown(wait=True, cancel_futures=True)
        yield from ((k, one.result()) for one, k in waiting.items() if not one.cancelled())
        raise
    finally:
        runner.halt()
        pool.shutdown(wait=True, cancel_futures=True)


def choose(task: Task) -> tuple[str, RunMode, str]:
    """Return the way that runs a task, its name, and why no faster one does, "" if none was refused."""
    why: list[str] = []
    for name, way in WAYS.items():
        if way.methods and task.method is not None and task.method not in way.methods:
            continue
        reason = way.refuses(task)
        if not reason:
            return name, way, "; ".join(dict.fromkeys(why))
        why.append(reason)
    raise AssertionError("the last way takes everything")
