"""Zeros of formulas along a motion: which events happen inside a step, when and where.

An event happens where its formula changes its sign. One that is zero at the start is armed by the sign that it takes
right behind, which is that of its first derivative there that is not zero; what touches zero and turns back has not
crossed it. A stretch is divided until its looks are sure (see `looks` and `passages`), so that a formula that rises and
falls again between two of them is seen.

A limit is passed where it is left behind by more than `SLACK`, for a joint that rests on it rounds; the time and the
place are those at which the limit itself was passed.

Reference: Shampine, Gladwell and Brankin, Reliable solution of special event location problems for ODEs (1991).
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.simulation.equations.crossings import SLACK
from symdyn.simulation.integrate.looks import FIRST
from symdyn.simulation.integrate.method import Hit, InitialValueProblem
from symdyn.simulation.integrate.passages import DIVISIONS, EPS, MOST, Search, jumps, zero

ROUNDING = 8 * EPS
"""How far coordinates, over their size, may be off where a formula at the start is said to be zero."""

SOON = 0.25 ** np.arange(26.0, 0.0, -1.0)
"""Parts of the first step, ascending, at which the sign is looked for that a formula takes behind its zero."""

BEHIND = 64
"""Parts of a stretch that are looked at for where a limit was passed, whose slack was passed at its end."""


@dataclass(frozen=True)
class IntegrationStep:
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
    evaluations: int = 0

    def states(self, times: Array) -> Array:
        """Return the states at times, that at the end as it is."""
        x = np.array(self.at(times), dtype=np.float64).reshape(len(times), -1)
        x[times == self.t1] = self.x1
        return x


LOOSE = 100.0
"""Times the limit to which loops are kept that a state between two steps is off by."""


class Watch:
    """Looks for the events of a run, step after step.

    Attributes:
        values: of the formulas where it stands, those of limits less their slack.
        armed: the signs that they had last, 0 of those that have been zero since the start, NaN where there was no real
            value.
        entered: since when and where a limit has been passed, but not by its slack, by event.
    """

    values: Array
    armed: Array

    def __init__(self, problem: InitialValueProblem) -> None:
        """Stand at t = 0."""
        self.problem = problem
        self.entered: dict[int, tuple[float, Array]] = {}
        if problem.stops:
            self._stand(0.0, problem.x)
            self.armed = np.where(np.abs(self.values) <= self._noise(0.0, problem.x), 0.0, np.sign(self.values))

    def copy(self) -> Watch:
        """Return one that stands where this one does."""
        found = copy.copy(self)
        found.entered = dict(self.entered)
        if self.problem.stops:
            found.armed = self.armed.copy()
        return found

    def restart(self, t: float, x: Array) -> list[Hit]:
        """Go on from another state, or with other forces; return the events that were jumped over."""
        if not self.problem.stops:
            return []
        self._stand(t, x)
        untold = self.values == 0.0
        if not self.armed.all():  # what has been zero since the start is so but for rounding
            untold |= (self.armed == 0.0) & (np.abs(self.values) <= self._noise(t, x))
        before, self.armed = self.armed, np.where(untold, self.armed, np.sign(self.values))
        return [Hit(int(k), t, x) for k in np.flatnonzero(before * self.armed < 0) if self._counts(int(k))]

    def within(self, step: IntegrationStep) -> list[Hit]:
        """Return the events of a step, in order of time."""
        if not self.problem.stops:
            return []
        times = FIRST.times(step.t0, step.t1)
        values = np.vstack([self.values, self._look(times[1:], step.states(times[1:]))])
        hits: list[Hit] = []
        for k in np.flatnonzero(~(FIRST.sure(values) & (np.sign(values[-1]) == self.armed))):
            hits += self._of_one(step, int(k), values[0, k], values[-1, k])
        self.values, self.x = values[-1], step.x1
        self._enter(step)
        return sorted(hits, key=lambda hit: hit.t)

    def _of_one(self, step: IntegrationStep, k: int, first: float, last: float) -> Iterator[Hit]:
        """Yield the passages of one event in a step, from its values at the ends."""

        def look(times: Array) -> Array:
            return self._look(times, step.states(times))[:, k]

        begin = step.t0
        if self.armed[k] == 0.0:
            times = step.t0 + (step.t1 - step.t0) * SOON
            values = np.append(look(times), last)
            told = np.flatnonzero(np.abs(values) > self._noise(step.t0, self.x)[k])
            if not len(told):
                return
            first = float(values[told[0]])
            begin = float(np.append(times, step.t1)[told[0]])
            self.armed[k] = np.sign(first)
        most = DIVISIONS if k in self.problem.unsure else MOST
        search = Search(look, (begin, first), (step.t1, last), float(self.armed[k]), most)
        for low, high in search.passages():
            self.armed[k] = search.armed
            t = zero(look, low, high)
            if self._counts(k) and not jumps(look, t, step.t0, step.t1):
                yield self._of_limit(step, k, t) if k >= self.problem.outward else Hit(k, t, self._at(step, t))
        self.armed[k] = search.armed
        if search.given_up is not None:
            self.problem.unsure.setdefault(k, search.given_up)

    def _counts(self, k: int) -> bool:
        """Tell whether a passage to the sign that an event has now is one: of limits, those outwards are."""
        return k < self.problem.outward or bool(self.armed[k] > 0)

    def _of_limit(self, step: IntegrationStep, k: int, until: float) -> Hit:
        """Return where a limit was passed for the last time until a time in a step at which it is beyond."""

        def look(times: Array) -> Array:
            return self._look(times, step.states(times))[:, k] + SLACK

        times = np.linspace(step.t0, until, BEHIND + 1)
        beyond = look(times)
        kept = np.flatnonzero(beyond[:-1] <= 0)
        if not len(kept):
            return Hit(k, *self.entered.get(k, (step.t0, self._at(step, step.t0))))
        low = int(kept[-1])
        t = zero(look, (float(times[low]), beyond[low]), (float(times[low + 1]), beyond[low + 1]))
        return Hit(k, t, self._at(step, t))

    def _enter(self, step: IntegrationStep) -> None:
        """Keep in mind which limits are passed at the end of a step, but not by their slack."""
        first = self.problem.outward
        slack = np.flatnonzero((self.values[first:] > -SLACK) & (self.values[first:] <= 0)) + first
        hits = [self._of_limit(step, int(k), step.t1) for k in slack]
        self.entered = {hit.event: (hit.t, hit.x) for hit in hits}

    def _stand(self, t: float, x: Array) -> None:
        self.x, self.values = x, self._look(np.array([t]), x[None])[0]
        first = self.problem.outward
        slack = np.flatnonzero((self.values[first:] > -SLACK) & (self.values[first:] <= 0)) + first
        self.entered = {int(k): self.entered.get(int(k), (t, x)) for k in slack}

    def _at(self, step: IntegrationStep, t: float) -> Array:
        found: Array = step.states(np.array([t]))[0]
        return found

    def _look(self, times: Array, states: Array) -> Array:
        """Return the values at states (N, nx), shape (N, events)."""
        values = np.array(self.problem.system.evaluate("events", times, states))
        values[:, self.problem.outward :] -= SLACK
        return values

    def _noise(self, t: float, x: Array) -> Array:
        """Return what rounding of a state, shape (nx,), may make of the formulas, and loops that are all but closed.

        Limits have their slack for that.
        """
        found = self._moved(t, x, ROUNDING * x)
        if self.problem.system.closed:
            open_by = LOOSE * self.problem.project.limit * np.maximum(1.0, np.abs(x))
            free = slice(self.problem.outward)
            found[free] += self._moved(t, x, open_by)[free]
        return found

    def _moved(self, t: float, x: Array, by: Array) -> Array:
        """Return by how much formulas change where each entry of a state does."""
        values = self._look(np.full(len(x) + 1, t), np.vstack([x, x + np.diag(by)]))
        return np.asarray(np.abs(values[1:] - values[0]).sum(axis=0))
