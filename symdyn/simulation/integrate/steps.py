"""Integrators that go step by step: samples inside of steps, events, projection at their ends, and getting nowhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from symdyn.algebra import Array
from symdyn.graph import Op, reachable
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate.method import InitialValueProblem, IntegrationError, Piece
from symdyn.simulation.integrate.watch import IntegrationStep, Watch

Resume = Callable[[float, Array], None]


def follow(
    problem: InitialValueProblem, steps: Iterator[IntegrationStep], resume: Resume, slack: float = 1.0
) -> Iterator[Piece]:
    """Yield a piece a step: its samples, events on its interpolant, and projection at its end.

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
        if loop is not None:
            loop.look(step.t0, end, step.states)
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

    def __init__(self, problem: InitialValueProblem) -> None:
        """Look whether anything jumps."""
        self.jumps = problem.system.once(_jumps)
        self.until, self.begin, self.steps = problem.until, 0.0, 0

    def check(self, step: IntegrationStep) -> None:
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
