"""Runs in lockstep by heyoka's Taylor method in batch mode: as many lanes as a vector has, each with its own step.

For smooth trees that nothing ends before their time. It needs no C compiler, and is the one for the last digits.

Reference: Biscani and Izzo, Revisiting high-order Taylor methods for astrodynamics and celestial mechanics (2021).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.interrupts import interrupts_wait
from symdyn.program import Program
from symdyn.runtime import load_program
from symdyn.simulation.ensemble import lockstep, one_by_one
from symdyn.simulation.ensemble.measures import Sums, sums_of
from symdyn.simulation.ensemble.task import RunBlock, RunMode, Runner, Task, replaced
from symdyn.simulation.forward import LARGEST
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.integrate.heyoka_expressions import TURNING, UNSEEN, Expressions, library
from symdyn.simulation.integrate.taylor import SHORTEST, SMALLEST
from symdyn.simulation.trajectory import END

CHUNK = 512
"""Runs whose samples are looked at together."""


def refuses(task: Task) -> str:
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
    branches = sorted({node.op.name.lower() for node in nodes if node.op in (Op.ABS, Op.SIGN, *UNSEEN, *TURNING)})
    if branches:
        return f"a series may overlook a turn of {' and '.join(branches)}"
    return f"{len(nodes)} operations would take heyoka long to compile" if len(nodes) > LARGEST else ""


def ready(task: Task) -> Runner:
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
    again = one_by_one.ready(task)

    def run(part: slice) -> RunBlock:
        x = np.hstack(task.lanes.states(part))
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


MODE = RunMode(
    "taylor lockstep",
    "as many runs in lockstep as a vector has lanes, by Taylor's method",
    "heyoka",
    CHUNK,
    ready,
    refuses,
    ("taylor",),
    False,
)
