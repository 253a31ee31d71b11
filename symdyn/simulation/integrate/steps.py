"""Integrators that go step by step: samples inside of steps, events, projection at their ends, and getting nowhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symdyn.algebra.numeric import Array
from symdyn.graph import Op, reachable
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate.method import Hit, IntegrationError, Piece, Problem


@dataclass(frozen=True)
class Step:
    """One step of an integrator that goes step by step.

    Attributes:
        t0, t1: where it begins and ends.
        x1: state at its end.
        at: states inside, shape (k, nx), at times (k,).
        evaluations: of the right-hand side, so far.
    """

    t0: float
    t1: float
    x1: Array
    at: Callable[[Array], Array]
    evaluations: int


Resume = Callable[[float, Array], None]


def follow(problem: Problem, steps: Iterator[Step], resume: Resume, slack: float = 1.0) -> Iterator[Piece]:
    """Yield a piece a step: its samples, events by bisection on its interpolant, and projection at its end.

    Steps are made when they are asked for. They `resume` from another state than that of the last one where a
    projection has moved it, which waits for `slack` times its limit: multistep methods lose their past then; and where
    a controller was due.
    """
    events, pace, loop = Watch(problem), Pace(problem), problem.system.loop
    nq, nv = problem.system.nq, problem.system.nv
    seen = 0
    if problem.times[0] == 0.0:
        yield Piece(problem.times[:1], problem.x[None], (), (0.0, problem.x), 0, 0)
    for step in steps:
        if not np.all(np.isfinite(step.x1)):
            raise IntegrationError(f"the motion leaves what doubles hold after t = {step.t0:g} s")
        pace.check(step)
        hits = events.within(step)
        stop = next((hit for hit in hits if problem.stops[hit.event]), None)
        end = step.t1 if stop is None else stop.t
        first, last = np.searchsorted(problem.times, (step.t0, end), side="right")
        inside = problem.times[first:last]
        x = step.at(inside) if len(inside) else np.empty((0, len(problem.x)))
        if len(inside) and inside[-1] == step.t1:
            x[-1] = step.x1
        projected = (problem.project(one) for one in x)
        kept = np.array([a if b is None else b for a, b in zip(x, projected, strict=True)]).reshape(x.shape)
        now = step.x1 if stop is None else stop.x
        used, seen = step.evaluations - seen, step.evaluations
        if stop is not None:
            yield Piece(inside, kept, tuple(h for h in hits if h.t <= end), (end, now), 1, used, True)
            return
        moved = problem.project(step.x1, slack) if step.t1 < problem.until else None
        after = step.x1 if moved is None else moved
        yield Piece(inside, kept, tuple(hits), (step.t1, after), 1, used)
        due = loop is not None and loop.halt(step.t1, after[:nq], after[nq : nq + nv])
        if moved is not None or due:
            resume(step.t1, after)
            jumps = events.restart(step.t1, after)
            stopped = any(problem.stops[hit.event] for hit in jumps)
            if jumps:
                yield Piece(problem.times[:0], x[:0], tuple(jumps), (step.t1, after), 0, 0, stopped)
            if stopped:
                return


class Pace:
    """Notices an integrator that gets nowhere, by how far the last steps have come."""

    STEPS = 3000
    """After so many steps it is looked."""

    MOST = 1e7
    """Steps that the rest of the way may take where a force jumps: at rest, as in dry friction, it holds the state."""

    LEAST = 1e-9
    """Part of the time by which so many steps must advance it: less is a motion that goes beyond all bounds."""

    def __init__(self, problem: Problem) -> None:
        """Look whether anything jumps."""
        self.jumps = problem.system.once(_jumps)
        self.until, self.begin, self.steps = problem.until, 0.0, 0

    def check(self, step: Step) -> None:
        """Raise IntegrationError where the last steps lead nowhere."""
        self.steps += 1
        if self.steps < self.STEPS:
            return
        way = step.t1 - self.begin
        if self.jumps and (self.until - step.t1) * self.steps > self.MOST * way:
            raise IntegrationError(
                f"the motion sticks at t = {step.t1:g} s, where a force with sign jumps to and fro; write a steep "
                "tanh(v/0.01) in place of sign(v), or give the joint friction with smoothing"
            )
        if way <= self.LEAST * step.t1:
            raise IntegrationError(
                f"the motion goes beyond all bounds, or a formula has no real value, after t = {step.t1:.9g} s: "
                f"{self.steps} steps have advanced the time by {way:.1g} s"
            )
        self.begin, self.steps = step.t1, 0


def _jumps(system: StateEquations) -> bool:
    return any(node.op is Op.SIGN for node in reachable(system.program["rates"].function.entries))


class Watch:
    """Zeros of the events inside steps; what is zero at the start has not crossed."""

    POINTS = 4
    """Parts of a step that are looked at, so that two crossings in one step are seen unless they are very close."""

    def __init__(self, problem: Problem) -> None:
        """Remember the values at t = 0."""
        self.problem = problem
        self.last: Array = np.empty(0)
        self.restart(0.0, problem.x)

    def restart(self, t: float, x: Array) -> list[Hit]:
        """Go on from another state, or with other forces; return the events that were jumped over."""
        if not self.problem.stops:
            return []
        values = self._values(np.array([t]), x[None])[0]
        if not len(self.last):
            self.last = values
            return []
        return [Hit(int(k), float(t), x) for k in np.nonzero(self._crossed(values))[0]]

    def _crossed(self, values: Array) -> npt.NDArray[np.bool_]:
        """Tell which events lie between the last values and these, which are the last ones then."""
        crossed = self.last * values < 0
        crossed[self.problem.outward :] &= values[self.problem.outward :] > 0
        self.last = np.where(values == 0, self.last, values)  # a zero met exactly is seen by the next value
        return crossed

    def _values(self, t: Array, x: Array) -> Array:
        return self.problem.system.tell("events", t, x)

    def within(self, step: Step) -> list[Hit]:
        """Return the events of a step, in order of time."""
        if not self.problem.stops:
            return []
        times = np.linspace(step.t0, step.t1, self.POINTS + 1)[1:]
        states = np.vstack([step.at(times[:-1]), step.x1])
        hits: list[Hit] = []
        before = step.t0
        for t, values in zip(times, self._values(times, states), strict=True):
            for k in np.nonzero(self._crossed(values))[0]:
                hits.append(self._hit(step, int(k), before, float(t)))
            before = float(t)
        return sorted(hits, key=lambda hit: hit.t)

    def _hit(self, step: Step, event: int, low: float, high: float) -> Hit:
        """Return where an event's formula vanishes between two times."""
        from scipy.optimize import brentq

        def state(t: float) -> Array:
            return step.x1 if t == step.t1 else step.at(np.array([t]))[0]

        def value(t: float) -> float:
            return float(self._values(np.array([t]), state(t)[None])[0, event])

        if value(low) * value(high) > 0:  # the zero was met exactly at `low`
            return Hit(event, low, state(low))
        t = float(brentq(value, low, high, xtol=1e-15 * max(1.0, abs(high)), rtol=8.9e-16))
        return Hit(event, t, state(t))
