"""Many runs in one call: the function `ensemble`.

Runs are handed out in parts of a fixed number, so that the same runs give the same bytes on any number of threads.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.arguments import check_arguments, doubles, flags
from symdyn.errors import SimulateError
from symdyn.scene import SceneLike, scene_of
from symdyn.scene.values import Faults
from symdyn.simulation.ensemble import lockstep, one_by_one, taylor_lockstep
from symdyn.simulation.ensemble.ensemble import Ensemble
from symdyn.simulation.ensemble.lanes import read_lanes
from symdyn.simulation.ensemble.measures import Measure, read_measures
from symdyn.simulation.ensemble.task import RunBlock, RunMode, Runner, Task, joined, nothing
from symdyn.simulation.forward import check_run
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import Forces, held, read_forces
from symdyn.simulation.trajectory import END

RTOL = 1e-9
"""Tolerance if none is given."""

WAYS: Mapping[str, RunMode] = {
    "lockstep": lockstep.WAY,
    "taylor lockstep": taylor_lockstep.WAY,
    "one by one": one_by_one.WAY,
}
"""By name, in the order in which they are tried; the last one takes everything."""


def ensemble(
    scene: SceneLike,
    forces: Forces | Entries = Forces(),  # noqa: B008  frozen
    until: float = 10.0,
    start: Mapping[str, Any] | str | None = None,
    start_rates: Mapping[str, Any] | str | None = None,
    values: Mapping[str, Any] | str | None = None,
    measures: str | Measure | Sequence[str | Measure] = (),
    every: float | None = None,
    samples: bool = False,
    method: str | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    stops: str | Sequence[str] = (),
    workers: int | None = None,
    ignore_limits: bool = False,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
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
        scene: the mechanism; parameters that vary need no value of their own.
        forces: driving forces of all runs, as for `simulate`.
        until: time of the end, s.
        start: by coordinate, numbers, formulas in parameters, or arrays of shape (N,).
        start_rates: likewise by velocity.
        values: likewise by parameter, without symbols.
        measures: formulas of folds over a run, such as "max(abs(q1)) - end(q2)", see `FOLDS`; they see samples alone.
        every: seconds between samples; None for 200 samples.
        samples: whether to keep the states at the samples.
        method: an integrator, a key of `symdyn.simulation.METHODS`; None takes the fastest that applies.
        rtol: relative tolerance of a step; None is 1e-9, of `gauss` what it takes itself.
            Below 1e-16 runs have 31 digits (`gauss`), one by one; what is returned are doubles.
        atol: absolute tolerance of a step; None takes rtol.
        stops: formulas; where one crosses zero a run ends.
        workers: threads; None for one a core. Runs by `simulate` itself go one after the other; `sweep` has processes.
        ignore_limits: go on where a joint reaches a limit of its position.
        progress: called with the share that is done.
        say: called with lines for the user.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
        SceneError: a value that the scene cannot have.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    check_arguments(ensemble, locals(), SimulateError)
    (until, every, rtol, atol), (samples, ignore_limits) = (
        doubles(until, every, rtol, atol),
        flags(samples, ignore_limits),
    )
    begin = time.perf_counter()
    stops = (stops,) if isinstance(stops, str) else tuple(stops)
    texts = (measures,) if isinstance(measures, str | Measure) else tuple(measures)
    faults, given = Faults(""), Forces()
    lanes = read_lanes(scene_of(scene), start, start_rates, values, faults)
    times: npt.NDArray[np.float64] = np.zeros(1)
    read: tuple[Measure, ...] = ()
    with faults.noted():
        given = forces if isinstance(forces, Forces) else read_forces(lanes.scene, forces)
    with faults.noted():
        read = read_measures(lanes.scene, texts, faults)
    with faults.noted():
        _, times = check_run(lanes.scene, until, every, rtol, atol, stops, method)
    if workers is not None and workers < 1:
        faults.add("", f"workers = {workers} is no number of threads; give 1 or more, or none")
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    asked = METHODS.get((method or "").lower())
    usual = asked.rtol if asked is not None and asked.beyond_doubles else RTOL
    relative = usual if rtol is None else rtol
    absolute = relative if atol is None else atol
    task = Task(
        lanes, given, times, every, read, stops, relative, absolute, None if method is None else method.lower(),
        samples, ignore_limits,
    )  # fmt: skip
    name, way, why = choose(task)
    tolerance = f"tolerance {relative:g}" if relative == absolute else f"tolerances {relative:g}, {absolute:g}"
    notes = [
        f"method: {name} ({way.library}), {tolerance}{f' ({why})' if why else ''}",
        *(
            line
            for one in way.methods
            if not METHODS[one].absolute
            for line in METHODS[one].tolerances(one, rtol, atol)[2]
        ),
        *held(lanes.scene, given, until),
    ]
    for note in notes:
        if say is not None:
            say(note)
    runner = way.ready(task)
    ready = time.perf_counter()
    found = joined(task, [*_run(task, way, runner, workers or _cores(), progress)])
    words = (END, *dict.fromkeys(one for one in found.stopped if one != END))
    place = {one: k for k, one in enumerate(words)}
    known = lanes.parameters()
    if say is not None:
        for note in found.notes:
            say(note)
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
