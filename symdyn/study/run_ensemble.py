"""Many runs in one call: the function `ensemble`, and how runs in lanes ended."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from symdyn.arguments import native, with_fields
from symdyn.scene import SceneLike
from symdyn.simulation import Forces, Measure, Problem, Run, RunBlock, read_task
from symdyn.simulation.prescribed import Entries
from symdyn.study.job import units_of
from symdyn.study.runs import ENDED, FAILED, NOT_MADE, STOPPED, Ends, Runs

NO_NUMBER = "the motion has no finite value"


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
    (samples,), began = native(bool, samples), time.perf_counter()
    task = read_task(problem, run, start, start_rates, values, measures, samples, workers)
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
