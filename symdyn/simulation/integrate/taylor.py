"""heyoka's adaptive Taylor method: the graph in its expressions, compiled by LLVM for steps of any order.

heyoka takes a step from the last two orders of the series, and believes it. Where tanh or exp is flat to the last
digit, as smoothed friction is away from rest, no order of the series knows of the turn ahead; where a root comes to
zero, as the length of a spring may, its series goes on below. Equations with these are followed step by step, and a
step is kept only if the series has the rates of the equations all along it.

Of closed mechanisms every step is brought back to the loops at its end: the series knows of them only that their
accelerations are kept, and what misses them grows, by 4e6 in 5 s of an RSSR whose neighbours part by 65.

Reference: Biscani and Izzo, Revisiting high-order Taylor methods for astrodynamics and celestial mechanics (2021).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.interrupts import interrupts_wait
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate import heyoka_expressions
from symdyn.simulation.integrate.heyoka_expressions import guarded, library, parameters, refuses, size, translate
from symdyn.simulation.integrate.integration import Hit, InitialValueProblem, IntegrationError, Method, Piece
from symdyn.simulation.integrate.watch import IntegrationStep, Watch

COMPACT = 250
"""Operations from which on loops are compiled in place of straight code, which would take long."""

COMPACT_SOON = 700
"""The same where code is compiled without optimisation, which takes a tenth of the time."""

STRETCH = 200
"""Steps after which the caller hears of it."""

SAMPLES = 20_000
"""Samples of one stretch: of millions, only those near by are looked at."""

PATIENT = 10.0
"""How many times its limit a projection of quaternions, and of loops in proportion, waits for."""

LOST = 1e3
"""How many times its limit a step that is right never misses: ten times the tolerance."""

SMALLEST = float(np.finfo(np.float64).eps)


@contextmanager
def integrator(problem: InitialValueProblem) -> Iterator[Any]:
    """Lend heyoka's integrator at the start of a problem; it is compiled once for all values of parameters."""
    system, tolerance = problem.system, problem.rtol
    idle = system.once(_idle).setdefault(tolerance, [])
    ta = idle.pop() if idle else _integrator(system, tolerance)
    ta.time, ta.state[:] = problem.begin, problem.x
    ta.pars[:] = parameters(system)[: len(ta.pars)]  # behind the last one that is used heyoka has none
    yield ta
    idle.append(ta)


def _idle(system: StateEquations) -> dict[float, list[Any]]:
    """Return where integrators wait, by tolerance; at first there are none."""
    return {}


def _integrator(system: StateEquations, tolerance: float) -> Any:
    variables, entries = translate(system)
    compact = size(system) > (COMPACT_SOON if system.closed else COMPACT)
    options: dict[str, Any] = {"tol": tolerance, "compact_mode": compact}
    soon = system.contacts is not None or (system.closed and not compact)
    if soon:  # where each step is looked at, its code is not worth more than it costs: 11 s of 12 for a rimless wheel
        options["opt_level"] = 0
    start = np.zeros(len(variables))

    def make() -> Any:
        return library().taylor_adaptive(list(zip(variables, entries, strict=True)), start, **options)

    with interrupts_wait():
        kept = not (compact or soon)  # loops compile soon
        return heyoka_expressions.integrator([*variables, *entries], options, make) if kept else make()


def run(problem: InitialValueProblem) -> Iterator[Piece]:
    """Yield the pieces of the motion by heyoka's Taylor method, `STRETCH` steps each.

    Raises:
        IntegrationError: the motion leaves what doubles hold.
    """
    with integrator(problem) as ta:
        yield from _stretches(problem, ta)


def _stretches(problem: InitialValueProblem, ta: Any) -> Iterator[Piece]:
    stretch = Stretch(ta, problem)
    times, done = problem.times, 1
    yield Piece(times[:1], problem.x[None], (), (problem.begin, problem.x), 0, 0)
    goal = min(problem.begin + _sure_step(ta), problem.until)
    while ta.time < problem.until:
        inside = times[done : np.searchsorted(times, goal, side="right")][:SAMPLES]
        x, steps, why = stretch.cover(inside, min(goal, float(inside[-1])) if len(inside) == SAMPLES else goal)
        hits, stretch.found = stretch.found, []
        stop = next((one for one in hits if problem.halts(one.event)), None)
        end = min(float(ta.time), problem.until)  # heyoka's clock has more digits, and may pass the end by rounding
        now = (end, ta.state.copy()) if stop is None else (stop.t, stop.x)
        kept = inside[: len(x)][inside[: len(x)] <= now[0]]
        yield Piece(
            kept, x[: len(kept)], tuple(one for one in hits if one.t <= now[0]), now, steps, steps, stop is not None
        )
        if stop is not None:
            return
        if why:
            raise IntegrationError(why)
        done += len(kept)
        goal = problem.until


class Stretch:
    """Some steps of heyoka's, the samples in them, and the events that are `found`."""

    def __init__(self, ta: Any, problem: InitialValueProblem) -> None:
        self.ta, self.problem = ta, problem
        self.watch, self.found = Watch(problem), list[Hit]()
        self.begin = problem.begin
        self.guard = Guard(problem) if guarded(problem.system) else None
        self.longest = math.inf
        self.patience = 0.0 if problem.system.swerves else PATIENT
        self.why = ""

    def cover(self, inside: Array, goal: float) -> tuple[Array, int, str]:
        """Return the states at times `inside` as far as it came, shape (k, nx), its steps, and why it cannot go on.

        It goes to `goal`, or `STRETCH` steps, or until an event stops it.
        """
        if self.guard is not None:
            return self._step_by_step(inside, goal)
        begin, start, watch = float(self.ta.time), self.ta.state.copy(), self.watch.copy()
        grid = np.unique(np.concatenate([[begin], inside, [goal]]))
        each = {"callback": self._after} if self.problem.project.active or self.problem.stops else {}
        outcome, _, _, steps, _, states = self.ta.propagate_grid(grid, max_steps=STRETCH, **each)
        if outcome == library().taylor_outcome.err_nf_state:  # once more, to stand where it was still finite
            self.ta.time, self.ta.state[:] = begin, start
            self.begin, self.watch, self.found = begin, watch, []
            return self._step_by_step(inside, goal)
        return states[np.searchsorted(grid, inside[inside <= grid[len(states) - 1]])], int(steps), self.why

    def _step_by_step(self, inside: Array, goal: float) -> tuple[Array, int, str]:
        ta, steps = self.ta, 0
        rows: list[Array] = []
        while ta.time < goal and steps < STRETCH:
            begin, start = float(ta.time), ta.state.copy()
            ta.step(max_delta_t=min(goal - begin, self.longest), write_tc=True)
            finite = math.isfinite(ta.time) and bool(np.all(np.isfinite(ta.state)))
            if not finite or (self.guard is not None and not self.guard.holds(ta.tc, begin, ta.time - begin)):
                self.longest = (ta.time - begin) / 2 if finite else 0.0
                ta.time, ta.state[:] = begin, start
                if self.longest <= SMALLEST * max(1.0, begin):
                    why = "the motion leaves what doubles hold, or a formula has no real value"
                    return _states(rows, start), steps, f"{why}, after t = {begin:g} s"
                continue
            self.longest *= 2
            steps += 1
            for t in inside[len(rows) : np.searchsorted(inside, ta.time, side="right")]:
                ta.update_d_output(t)
                rows.append(ta.d_output.copy())
            if not self._after(ta):
                break
        return _states(rows, ta.state), steps, self.why

    def _after(self, ta: Any) -> bool:
        """Look for events in a step, and bring its end back to its constraints; tell whether to go on."""
        project, end = self.problem.project, float(ta.time)
        begin, self.begin = self.begin, end
        if self.problem.stops and end > begin:
            self.found += self.watch.within(IntegrationStep(begin, end, ta.state.copy(), _series(ta.tc.copy(), begin)))
        drift = project.drift(ta.state) if project.active else 0.0
        if drift > LOST * project.limit:
            self.why = f"the series leave the constraints after t = {end:g} s"
            return False
        if drift > self.patience * project.limit:
            ta.state[:] = project.projected(ta.state)
            self.found += self.watch.restart(end, ta.state.copy())
        return not any(self.problem.halts(one.event) for one in self.found)


def _series(coefficients: Array, begin: float) -> Callable[[Array], Array]:
    """Return the states (k, nx) at times of a step, from its series (nx, orders + 1) about its begin."""

    def states(times: Array) -> Array:
        return (times - begin)[:, None] ** np.arange(coefficients.shape[1]) @ coefficients.T

    return states


def _states(rows: list[Array], like: Array) -> Array:
    return np.array(rows, dtype=np.float64).reshape(-1, len(like))


class Guard:
    """Looks whether the series of a step has the rates that the equations have."""

    def __init__(self, problem: InitialValueProblem) -> None:
        self.system, self.limit = problem.system, SLACK * problem.rtol

    def holds(self, series: Array, t: float, h: float) -> bool:
        """Tell whether a step of length h from t on is to be believed; series: (nx, orders + 1)."""
        orders = np.arange(series.shape[1])
        powers = (h * PLACES[:, None]) ** orders
        states = powers @ series.T
        slopes = powers[:, :-1] @ (series[:, 1:] * orders[1:]).T
        with np.errstate(all="ignore"):
            off = h * np.abs(slopes - self.system.evaluate("rates", t + h * PLACES, states))
        return bool(np.all(off <= self.limit * np.maximum(1.0, np.abs(states).max(axis=1))[:, None]))


PLACES = np.arange(1, 9) / 8
"""Where in a step its rates are looked at, over its length."""

SLACK = 30.0
"""How many times the tolerance they may be off, times the step; of steps that are right, less than four were seen."""


def _sure_step(ta: Any) -> float:
    """Return a step that is short enough at the start.

    heyoka takes it from the last two orders of the series alone. Both vanish at states with symmetries, such as a
    pendulum that starts level and at rest, whose motion has the orders 2, 6, 10, ... only: the step would be far too
    long. The shortest step by any of the orders from 4 on is taken in its place; a step later the symmetry is gone.
    """
    state, begin = ta.state.copy(), ta.time
    ta.step(max_delta_t=SHORTEST, write_tc=True)
    series = np.abs(ta.tc)
    ta.state[:], ta.time = state, begin
    norms = series.max(axis=0)
    size = max(1.0, norms[0])
    orders = np.arange(4, len(norms))
    with np.errstate(divide="ignore"):
        radius = np.min((size / norms[4:]) ** (1.0 / orders))
    return float(radius) / math.e**2


SHORTEST = 1e-200
"""A step that changes nothing, s."""


METHODS = {
    "taylor": Method(
        "heyoka",
        "Taylor method of adaptive order and step",
        "heyoka",
        "simulate",
        1e-12,
        run,
        refuses,
        finest=SMALLEST,
        absolute=False,
    )
}
