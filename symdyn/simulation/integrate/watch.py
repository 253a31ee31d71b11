"""Events of a motion: which formulas pass zero inside a step, when and where.

An event happens where its formula changes its sign. One that is zero at the start is armed by the sign that it takes
right behind, which is that of its first derivative there that is not zero. What touches zero and turns back has not
crossed it. A formula that has no real value for a while takes the sign that it has behind that as its own: it has not
passed zero; nor has one that changes its sign through infinity.

A stretch of time is sampled, and divided until the samples are sure to show every sign (see `looks` and `passages`), so
that a formula that rises and falls again between two of them is seen. How far what is smooth can bend between them:

    f(s) ≈ Σ c_j T_j(s)        -1 ≤ s ≤ 1, from values at s_k = -cos(π k / n)
    |T_j''| ≤ j² (j² - 1) / 3  so that f leaves its chord between two nodes by Σ |c_j| j² (j² - 1)/3 · Δ²/8 at most

The nodes are no multiples of each other: a formula whose period is a part of the stretch does not hide between them.

A limit is passed where it is left behind by more than `SLACK`, since a joint that rests on it has rounding errors; the
time and the place are those at which the limit itself was passed.

References: Shampine, Gladwell and Brankin, Reliable solution of special event location problems for ODEs (1991);
Trefethen, Approximation Theory and Approximation Practice (2013), chapters 2 and 3.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.frozen import dataclass
from symdyn.simulation.integrate.integration import Hit, InitialValueProblem, IntegrationError


@dataclass(frozen=True)
class Looks:
    """Nodes of a stretch."""

    parts: Array  # where they are, over its length, ascending from 0 to 1; shape (n + 1,)
    coefficients: Array  # what makes c of values at the nodes, shape (n + 1, n + 1)
    bends: Array  # what |c_j| adds to how far the interpolant leaves a chord, shape (n + 1,)

    def times(self, begin: float, end: float) -> Array:
        """Return the times of the nodes, the ends as they are."""
        found = begin + (end - begin) * self.parts
        found[-1] = end
        return found

    def bend(self, values: Array) -> Array:
        """Return how far formulas can leave their chords, shape (k,), from values (n + 1, k)."""
        return np.asarray(self.bends @ np.abs(self.coefficients @ values))

    def sure(self, values: Array) -> npt.NDArray[np.bool_]:
        """Tell which formulas have no zero in the stretch, shape (k,), from values (n + 1, k); NaN is not sure."""
        signs = np.sign(values)
        alike = np.all(signs == signs[0], axis=0)
        return np.asarray(alike & (np.abs(values).min(axis=0) > self.bend(values)))


def looks(n: int) -> Looks:
    """Return n + 1 nodes, n even."""
    k = np.arange(n + 1)
    halved = np.where((k == 0) | (k == n), 0.5, 1.0)
    angles = np.pi * np.outer(k, n - k) / n
    parts = (1.0 - np.cos(np.pi * k / n)) / 2
    parts[n // 2] = 0.5
    widest = np.sin(np.pi / n)
    return Looks(parts, 2.0 / n * np.cos(angles) * np.outer(halved, halved), widest**2 / 8 * k**2 * (k**2 - 1.0) / 3)


FIRST = looks(4)
"""The looks at every step."""

CLOSER = looks(16)
"""The looks at a stretch where the first were not sure."""


EPS = float(np.finfo(np.float64).eps)

NARROW = 1e-6
"""Part of a step below which a stretch is narrow."""

DIVISIONS = 400
"""Narrow stretches that are divided in one place: what rounds to and fro at zero would take them without end."""

MOST = 10_000
"""The same in a whole step, which of a motion without forces may be the whole run."""

REAL = 1e-12
"""Part of a step to which it is found where a formula begins to have a real value, or ends to have one."""

MONOTONE = 4.0
"""Between nodes whose values differ by so many times what a formula can bend there it has one zero at most."""

POLE = 10.0
"""How many times larger a formula is where it changes its sign than close by, if it does so through infinity."""

HALVINGS = 1000
"""Steps of the search for a zero at most; one of high order takes more than a hundred."""

Look = Callable[[Array], Array]
"""Returns the values of a formula at times, shape (N,)."""

Place = tuple[float, float]
"""A time, and a value there."""


class Search:
    """The search for the passages of one formula in one step.

    Attributes:
        armed: the sign that it had last, NaN for none.
        given_up: from when on it was not divided though it was not sure, s; None where all is sure.
    """

    def __init__(self, look: Look, begin: Place, end: Place, armed: float, most: int = MOST) -> None:
        """Take the ends of a step, the sign before it, and how many narrow stretches are divided."""
        self.look, self.begin, self.end, self.armed = look, begin, end, armed
        self.given_up: float | None = None
        self.left, self.here = most, 0
        self.length = end[0] - begin[0]

    def passages(self) -> Iterator[tuple[Place, Place]]:
        """Yield stretches in which the formula passes zero once, in order; `armed` is then the sign behind."""
        waiting = [(self.begin, self.end, math.inf)]
        while waiting:
            low, high, bend = waiting.pop()
            if math.inf > self.armed * low[1] > bend < self.armed * high[1] < math.inf:  # sure, as most are
                continue
            if not self._sure(low, high, bend) and self._may(low, high):
                times = CLOSER.times(low[0], high[0])
                values = np.concatenate([[low[1]], self.look(times[1:-1]), [high[1]]])
                if np.isfinite(values).any():
                    known = float(CLOSER.bend(values))
                    bend = math.inf if math.isnan(known) else known
                    places = [*zip(times.tolist(), values.tolist(), strict=True)]
                    waiting += [(a, b, bend) for a, b in zip(places[-2::-1], places[:0:-1], strict=True)]
                    continue
            before, self.armed = self._signs(low, high)
            if before * self.armed < 0:
                yield low, high

    def _signs(self, low: Place, high: Place) -> tuple[float, float]:
        """Return the signs before and behind a stretch, NaN for none."""
        if not _real(low, high):
            return math.nan, math.nan
        before = self.armed if self.armed in (-1.0, 1.0) else _sign(low[1]) or math.nan
        return before, _sign(high[1]) or before

    def _sure(self, low: Place, high: Place, bend: float) -> bool:
        """Tell whether a stretch has one zero at most, and that where the signs differ, or is as short as can be."""
        width = high[0] - low[0]
        if not _real(low, high):
            return width <= REAL * self.length
        before, behind = self._signs(low, high)
        far = min(abs(low[1]), abs(high[1])) if before == behind else abs(high[1] - low[1]) / MONOTONE
        return far > bend or bend == 0.0 or width <= 4 * EPS * abs(high[0])

    def _may(self, low: Place, high: Place) -> bool:
        """Tell whether a stretch that is not sure is to be divided: not where too many narrow ones were."""
        narrow = high[0] - low[0] <= NARROW * self.length
        self.here = self.here + 1 if narrow else 0
        self.left -= narrow
        if self.here <= DIVISIONS and self.left > 0:
            return True
        self.given_up = low[0] if self.given_up is None else self.given_up
        return False


def _sign(value: float) -> float:
    return math.copysign(1.0, value) if value else 0.0


def _real(low: Place, high: Place) -> bool:
    return math.isfinite(low[1]) and math.isfinite(high[1])


def zero(look: Look, low: Place, high: Place) -> float:
    """Return the time between two at which a formula vanishes that changes its sign there, or has no value there."""
    from scipy.optimize import brentq

    if low[1] * high[1] >= 0 or low[0] >= high[0]:  # it vanishes at the first of them
        return low[0]
    known = dict((low, high))

    def value(t: float) -> float:
        found = known[t] if t in known else float(look(np.array([t]))[0])
        return 0.0 if math.isnan(found) else found

    found, _ = brentq(value, low[0], high[0], xtol=1e-24, rtol=4 * EPS, maxiter=HALVINGS, full_output=True, disp=False)
    return float(found)


def jumps(look: Look, t: float, begin: float, end: float) -> bool:
    """Tell whether a formula passes infinity where it changes its sign, at t in a step, or has no value there."""
    near = max(NARROW * (end - begin), 1e3 * EPS * abs(t))
    before, there, behind = np.abs(look(np.array([max(begin, t - near), t, min(end, t + near)])))
    return bool(np.isnan(there) or there > POLE * np.fmax(before, behind))


ROUNDING = 8 * EPS
"""How far coordinates, over their size, may be off where a formula at the start is said to be zero."""

SOON = 0.25 ** np.arange(26.0, 0.0, -1.0)
"""Parts of the first step, ascending, at which the sign is looked for that a formula takes behind its zero."""

CLEAR = 1e4
"""Times what rounding makes of it, from where on a formula tells how it leaves its zero."""

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
        again: takes it once more, up to a sooner time, so that nothing of it is beyond that, or returns None.
    """

    t0: float
    t1: float
    x1: Array
    at: Callable[[Array], Array]
    evaluations: int = 0
    again: Callable[[float], IntegrationStep | None] = lambda until: None

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
        bent: the event at the end of the last step where the equations bend, None of another end.
    """

    values: Array
    armed: Array
    _noise_at: tuple[Array, Array] | None

    def __init__(self, problem: InitialValueProblem) -> None:
        self.problem, self.kinds = problem, problem.system.kinds
        self.slack = np.array([kind.slack for kind in self.kinds])
        self._held = np.array([kind.contact is not None for kind in self.kinds], dtype=bool)  # never below zero
        self.bent: int | None = None
        self.entered: dict[int, tuple[float, Array]] = {}
        if problem.stops:
            self._stand(problem.begin, problem.x)
            self.armed = np.where(
                np.abs(self.values) <= self._noise(problem.begin, problem.x), 0.0, np.sign(self.values)
            )
            self.armed[self._held] = np.maximum(self.armed[self._held], 0.0)

    def copy(self) -> Watch:
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
        if self.bent is not None:
            untold[self.bent] = True
        before, self.armed = self.armed, np.where(untold, self.armed, np.sign(self.values))
        return [Hit(int(k), t, x) for k in np.flatnonzero(before * self.armed < 0) if self._counts(int(k))]

    def until_bend(self, step: IntegrationStep) -> tuple[IntegrationStep, list[Hit]]:
        """Return a step up to the first place where the equations bend, all of it without such, and its events.

        Right behind such a place its formula is zero but for errors of the interpolant: it counts as passed again only
        where its sign at the end of the step says so.
        """
        bends, last, before = self.problem.bends, self.bent, self.copy() if self.problem.bends else self
        hits, self.bent = self.within(step), None
        if last is not None:
            again = [hit for hit in hits if hit.event == last][-1:] if self.armed[last] != before.armed[last] else []
            hits = [hit for hit in hits if hit.event != last or hit in again]
        bend = next((hit for hit in hits if hit.event in bends and step.t0 < hit.t < step.t1), None)
        if bend is None or before.armed[bend.event] not in (-1.0, 1.0):
            return step, hits
        self.__dict__.update(before.__dict__)
        behind = -float(self.armed[bend.event])
        sooner = IntegrationStep(step.t0, bend.t, bend.x, step.at, step.evaluations)
        step = step.again(bend.t) or sooner
        hits, self.bent = self.within(step), bend.event
        self.armed[bend.event] = behind  # whatever rounding has made of zero
        return step, hits

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
            noise = self._noise(step.t0, self.x)[k]
            told = np.flatnonzero(np.abs(values) > noise)
            if not len(told):
                return
            first = float(values[told[0]])
            begin = float(np.append(times, step.t1)[told[0]])
            self.armed[k] = 1.0 if self._held[k] else np.sign(first)
            if self._held[k]:  # zero where a contact has just struck: that zero is divided out
                clear = told[np.abs(values[told]) > CLEAR * noise]
                if len(clear) and np.all(values[told[0] : clear[0] + 1] > 0):
                    begin = float(np.append(times, step.t1)[clear[0]])
                    first = float(values[clear[0]]) / (begin - step.t0)
                    last /= step.t1 - step.t0
                    of = look

                    def look(times: Array) -> Array:
                        return of(times) / (times - step.t0)

        most = DIVISIONS if k in self.problem.unsure else MOST
        search = Search(look, (begin, first), (step.t1, last), float(self.armed[k]), most)
        for low, high in search.passages():
            self.armed[k] = search.armed
            t = zero(look, low, high)
            if self._counts(k) and not jumps(look, t, step.t0, step.t1):
                yield self._of_limit(step, k, t) if self.slack[k] else Hit(k, t, self._at(step, t))
        self.armed[k] = search.armed
        if search.given_up is not None:
            self.problem.unsure.setdefault(k, search.given_up)

    def _counts(self, k: int) -> bool:
        """Tell whether a passage to the sign that an event has now is in its direction: of limits, outwards."""
        direction = self.kinds[k].direction
        return not direction or bool(self.armed[k] * direction > 0)

    def _of_limit(self, step: IntegrationStep, k: int, until: float) -> Hit:
        """Return where a limit was passed for the last time until a time in a step at which it is beyond."""

        def look(times: Array) -> Array:
            return np.asarray(self._look(times, step.states(times))[:, k] + self.slack[k])

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
        hits = [self._of_limit(step, k, step.t1) for k in self._between()]
        self.entered = {hit.event: (hit.t, hit.x) for hit in hits}

    def _stand(self, t: float, x: Array) -> None:
        self.x, self.values, self._noise_at = x, self._look(np.array([t]), x[None])[0], None
        self.entered = {k: self.entered.get(k, (t, x)) for k in self._between()}

    def _between(self) -> list[int]:
        """Return the limits that are passed, but not by their slack."""
        return [int(k) for k in np.flatnonzero((self.values > -self.slack) & (self.values <= 0) & (self.slack > 0))]

    def _at(self, step: IntegrationStep, t: float) -> Array:
        found: Array = step.states(np.array([t]))[0]
        return found

    def _look(self, times: Array, states: Array) -> Array:
        found: Array = self.problem.system.evaluate("events", times, states) - self.slack
        return found

    def _noise(self, t: float, x: Array) -> Array:
        """Return what rounding of a state, shape (nx,), may make of the formulas, and loops that are all but closed.

        Limits have their slack for that.
        """
        if self._noise_at is not None and self._noise_at[0] is x:
            return self._noise_at[1]
        found = self._moved(t, x, ROUNDING * x)
        if self.problem.residue:  # those that have just passed, on interpolants that begin with an error of a step
            off = self._moved(t, x, self.problem.rtol * np.abs(x) + self.problem.atol)
            for k, residue in self.problem.residue.items():
                if self.kinds[k].contact is not None:  # it has been brought to zero
                    continue
                found[k] = max(found[k], residue, off[k])
                if residue < abs(self.values[k]) <= off[k] and t == self.problem.begin:
                    why = f"{self.kinds[k].text} comes again within the tolerance after t = {t:.9g} s"
                    raise IntegrationError(f"{why}; give a finer one, or jumps that lead further away")
        if self.problem.system.closed:
            open_by = LOOSE * self.problem.project.limit * np.maximum(1.0, np.abs(x))
            free = self.slack == 0.0
            found[free] += self._moved(t, x, open_by)[free]
        self._noise_at = x, found
        return found

    def _moved(self, t: float, x: Array, by: Array) -> Array:
        """Return by how much formulas change where each entry of a state does."""
        values = self._look(np.full(len(x) + 1, t), np.vstack([x, x + np.diag(by)]))
        return np.asarray(np.abs(values[1:] - values[0]).sum(axis=0))
