"""Many runs of one scene, as they are asked for, and the mode that runs them: the fastest one that applies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.scene.values import Faults
from symdyn.simulation.ensemble import lockstep, one_by_one, taylor_lockstep
from symdyn.simulation.ensemble.lanes import read_lanes
from symdyn.simulation.ensemble.measures import Measure, read_measures
from symdyn.simulation.ensemble.task import RunMode, Task
from symdyn.simulation.forward import check_run
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import Forces, held, read_forces

RTOL = 1e-9
"""Tolerance if none is given."""

MODES = (lockstep.MODE, taylor_lockstep.MODE, one_by_one.MODE)
"""In the order in which they are tried; the last one takes everything."""


def read_task(
    scene: Scene,
    forces: Forces | Entries,
    until: float,
    start: object,
    start_rates: object,
    values: object,
    measures: str | Measure | Sequence[str | Measure],
    every: float | None,
    samples: bool,
    method: str | None,
    rtol: float | None,
    atol: float | None,
    stops: str | Sequence[str],
    workers: int | None,
    ignore_limits: bool,
) -> Task:
    """Return the runs that are asked for, and how they will be run; arguments as of `symdyn.ensemble`.

    Raises:
        SimulateError: with every fault, one line each.
        SceneError: a value that the scene cannot have.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    stops = (stops,) if isinstance(stops, str) else tuple(stops)
    texts = (measures,) if isinstance(measures, str | Measure) else tuple(measures)
    faults, given = Faults(""), Forces()
    lanes = read_lanes(scene, start, start_rates, values, faults)
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
        samples, ignore_limits, one_by_one.MODE,
    )  # fmt: skip
    mode, why = choose(task)
    tolerance = f"tolerance {relative:g}" if relative == absolute else f"tolerances {relative:g}, {absolute:g}"
    notes = (
        f"method: {mode.name} ({mode.library}), {tolerance}{f' ({why})' if why else ''}",
        *(
            line
            for one in mode.methods
            if not METHODS[one].absolute
            for line in METHODS[one].tolerances(one, rtol, atol)[2]
        ),
        *held(lanes.scene, given, until),
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
