"""Runs one after the other by `simulate`: whatever that takes, an ensemble takes.

What measures fold is read from the columns of each run.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.errors import MethodError, SimulateError, SymdynError
from symdyn.graph import Graph, evaluate
from symdyn.scene import Quantity
from symdyn.scene.values import LETTERS, Faults
from symdyn.simulation.ensemble.measures import Measure, Sums, read_measures, sums_of
from symdyn.simulation.ensemble.task import RunBlock, RunMode, Runner, Task, nothing
from symdyn.simulation.equations.compiled_routines import opened
from symdyn.simulation.forward import simulate
from symdyn.simulation.problem import Problem, Run
from symdyn.simulation.run_columns import multiplier_columns
from symdyn.simulation.trajectory import INTERRUPTED, Trajectory
from symdyn.simulation.variations import variations


def ready(task: Task) -> Runner:
    """Return what runs a part, one run after the other."""

    def run(part: slice) -> RunBlock:
        runs = range(task.lanes.count)[part]
        found = nothing(task, len(runs))
        t, q, u, sums, samples = found.t, found.q, found.u, found.sums, found.samples
        why, steps, notes = [], 0, dict[str, None]()
        for row, k in enumerate(runs):
            one = _one(task, k, notes)
            if isinstance(one, str):
                why.append(one)
                continue
            if one.stopped == INTERRUPTED:
                raise KeyboardInterrupt
            t[row], q[row], u[row] = one.t[-1], one.q[-1], one.qd[-1]
            why.append(_why(one))
            steps += one.steps
            for inside, kept in sums_over(task.insides, one).items():
                for name in Sums.__dataclass_fields__:
                    getattr(sums[inside], name)[row] = getattr(kept, name)
            if samples is not None:
                count = min(len(one.t), len(task.times))
                samples[row, :count] = np.hstack([one.q, one.qd])[:count]
        return RunBlock(t, q, u, tuple(why), sums, samples, steps, tuple(notes))

    return Runner(run)


def _one(task: Task, k: int, notes: dict[str, None]) -> Trajectory | str:
    """Return one run, or why there is none."""
    values, start, rates = task.lanes.one(k)
    named = {name for one in task.insides for name in one.symbols}
    try:
        return simulate(
            task.scene, forces=task.forces, start=start, start_rates=rates, values=values or None, until=task.until,
            every=task.every, method=task.method, rtol=task.rtol, atol=task.atol, stops=task.stops,
            ignore_limits=task.ignore_limits, reactions=any(name.startswith(LETTERS.reaction) for name in named),
            say=notes.setdefault,
        )  # fmt: skip
    except MethodError:  # nor would it apply to another run
        raise
    except SymdynError as fault:
        return " ".join(str(fault).split())


def _why(run: Trajectory) -> str:
    """Return why a run ended in words that many runs share: when it was is told apart."""
    ended = run.events[-1] if run.events and run.events[-1].stops else None
    return _AT.sub("t", run.stopped) if ended is None else ended.formula


_AT = re.compile(r"\bt = [-+.\deinf]+ s\b")


def sums_over(insides: Sequence[Quantity], run: Trajectory) -> Mapping[Quantity, Sums]:
    """Return what is kept of formulas over the rows of a run."""
    if not insides:
        return {}
    known = dict(zip(*(run.names, run.table()[1].T), strict=True))
    if any(name.startswith(LETTERS.multiplier) for one in insides for name in one.symbols):
        known |= multiplier_columns(run)
    known |= {name: np.asarray(value) for name, value in opened(run.scene).values.items()}
    graph = Graph()
    letters = {graph.symbol(n): known.get(n, np.nan) for one in insides for n in one.symbols}
    with np.errstate(all="ignore"):
        found = evaluate([one.express(graph) for one in insides], Batches(), letters)
        rows: list[Array] = [np.broadcast_to(np.asarray(y, dtype=np.float64), run.t.shape) for y in found]
        return {one: sums_of(run.t, y) for one, y in zip(insides, rows, strict=True)}


def measured(run: Trajectory, measures: Sequence[Measure]) -> Array:
    """Return measures of one run, shape (measures,)."""
    sums = sums_over(tuple(dict.fromkeys(inside for one in measures for inside in one.insides)), run)
    known = {name: np.asarray(value) for name, value in opened(run.scene).values.items()}
    return np.array([float(one.value(sums, known)) for one in measures])


def measure_slopes(problem: Problem, run: Run, measures: Sequence[str], names: Sequence[str]) -> Array:
    """Return the derivatives of measures of a run by each of the names, shape (measures, names); NaN where none is.

    A fold is taken of the run as it is to first order on both sides of every name: the largest value follows the
    sample where it is, and a measure that jumps from one sample to another has no derivative there.
    Names are as of `variations`; of the run only `until` and `every` are looked at.

    Raises:
        SimulateError: with every fault.
    """
    faults = Faults("")
    read = read_measures(problem.scene, measures, faults)
    faults.close(SimulateError)
    made = simulate(problem.as_read, until=run.until, every=run.every, say=lambda _: None)
    found = variations(made, problem.driving, problem.initial, names)
    slopes = np.zeros((len(read), len(names)))
    for k in range(len(names)):
        step = found.step(k)
        ahead, behind = (measured(found.beside(made, k, sign * step), read) for sign in (1, -1))
        slopes[:, k] = (ahead - behind) / (2 * step)
    return slopes


MODE = RunMode("one by one", "each run by `simulate`", "symdyn", 1, ready, lambda task: "", threads=False)
