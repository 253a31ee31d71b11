"""Runs in lockstep: 64 at a time in compiled code, each with its own step, what measures fold taken along.

A tree under forces that are formulas. Runs that come to their end otherwise than by time (a joint's limit, a formula
that stops them, a step that would vanish, more steps than a system that is not stiff takes) are run again by
`simulate`, which says when and why.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np

from symdyn.dynamics.mechanism import quaternions
from symdyn.errors import MissingCompiler
from symdyn.runtime import find_compiler
from symdyn.scene.values import LETTERS, Faults
from symdyn.simulation.ensemble import one_by_one
from symdyn.simulation.ensemble.lockstep_code import Library, library
from symdyn.simulation.ensemble.lockstep_functions import ENERGIES, Lockstep, jacobian_at, lockstep
from symdyn.simulation.ensemble.measures import Sums
from symdyn.simulation.ensemble.task import RunBlock, RunMode, Runner, Task, replaced
from symdyn.simulation.equations.compiled_routines import Kept
from symdyn.simulation.equations.parametrised import opened
from symdyn.simulation.integrate.method import DOUBLES
from symdyn.simulation.integrator import dies_out_fast
from symdyn.simulation.prescribed.formulas_in_time import read_seen
from symdyn.simulation.trajectory import END, INTERRUPTED

ENDED, HALTED = 0, 4
"""Why a run ended, in the words of the template: by time, or since it was to be halted; all else is looked at again."""

_FUNCTIONS: Kept[Lockstep] = Kept()
_LIBRARIES: Kept[Library] = Kept()


def refuses(task: Task) -> str:
    """Return why runs are not run in lockstep."""
    if why := shape(task):
        return why
    try:
        find_compiler()
    except MissingCompiler:
        return "there is no C compiler"
    return "the system is stiff" if task.method is None and stiff(task) else ""


def shape(task: Task) -> str:
    """Return why rates are no functions of a state, time and parameters alone."""
    scene, forces = task.scene, task.forces
    if task.rtol < DOUBLES:
        return "doubles have no such tolerance"
    if scene.is_closed:
        return "loops close"
    if not scene.velocities:
        return "nothing moves"
    if forces.tables:
        return "a force is a table"
    if forces.functions or forces.fed:
        return "a force is a function"
    columns = {name for one in task.insides for name in one.symbols if name in LETTERS.columns and name not in ENERGIES}
    if columns:
        return f"{', '.join(sorted(columns))} is known of whole runs"
    free = {p.name for p in opened(scene).scene.free_parameters}
    decided = [name for name in task.lanes.values if name not in free]
    if decided:
        return f"{', '.join(decided)} decides the form of equations"
    return ""


def stiff(task: Task) -> bool:
    """Tell whether the first run is stiff at its start."""
    if not task.lanes.count:
        return False
    one = slice(0, 1)
    values = {name: float(np.ravel(x)[0]) for name, x in task.lanes.parameters(one).items()}
    jacobian = jacobian_at(functions(task), values, np.hstack(task.lanes.states(one))[0])
    return dies_out_fast(jacobian, task.until)


def _key(task: Task) -> tuple[Hashable, ...]:
    return opened(task.scene).scene, *task.forces.form, task.insides, task.stops, task.ignore_limits


def functions(task: Task) -> Lockstep:
    """Return what is to be run, derived once for all values."""

    def make() -> Lockstep:
        stops = [read_seen(task.scene, text, "event", Faults("")) for text in task.stops]
        known = [one for one in stops if one is not None]
        return lockstep(opened(task.scene), task.forces, task.insides, known, task.ignore_limits)

    return _FUNCTIONS.get(_key(task), make)


def ready(task: Task) -> Runner:
    """Return what runs a part; what it runs is compiled once."""
    scene, key, parts = task.scene, _key(task), functions(task)
    names = list(scene.coordinates)
    firsts = [names.index(group[0]) for group in quaternions(scene)]
    made = _LIBRARIES.get(key, lambda: library(parts, firsts))
    again = one_by_one.ready(task)
    halt = np.zeros(1, dtype=np.int32)

    def run(part: slice) -> RunBlock:
        return _run(task, made, halt, part, again)

    def stop() -> None:
        halt[0] = 1

    return Runner(run, stop)


def _run(task: Task, made: Library, halt: Any, part: slice, again: Runner) -> RunBlock:
    lanes, nq = task.lanes, made.nq
    runs = len(range(lanes.count)[part])
    x = np.hstack(lanes.states(part))
    values = made.prepared(lanes.parameters(part), runs)
    times = task.times if task.insides or task.keep else task.times[-1:]  # nobody looks at samples
    end, t, why, kept, samples, steps = made.run(x, values, times, (task.rtol, task.atol), halt, task.keep)
    stopped = np.full(runs, END, dtype=object)
    stopped[why == HALTED] = INTERRUPTED
    end[why == HALTED], kept[why == HALTED] = np.nan, np.nan
    sums = {one: _sums(kept[:, k], t) for k, one in enumerate(task.insides)}
    block = RunBlock(t, end[:, :nq], end[:, nq:], tuple(stopped.tolist()), sums, samples, steps)
    return replaced(task, block, part, (why != ENDED) & (why != HALTED), again)


def _sums(kept: Any, t: Any) -> Sums:
    """Return what was kept of a formula; where it had no value, none of it has."""
    first, last, least, most, when_least, when_most, area, squares = kept.T.copy()
    lost = ~np.isfinite(area)
    for one in (least, most, when_least, when_most, area, squares):
        one[lost] = np.nan
    return Sums(first, last, least, most, when_least, when_most, area, squares, t.copy())


MODE = RunMode("lockstep", "64 runs in lockstep by DOP853", "compiled", 4096, ready, refuses, ("dop853",))
