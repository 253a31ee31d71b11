"""A controller at work in one run: its force at a state or held since its last sample, and the rows of the run.

Sample k is taken at k T, and acts from (k + m) T + r on, where m T + r is the delay and 0 ≤ r < T. The integration
stops at all these times, so that a step never goes across a jump of a force. What acts at a time is kept, so that a run
can be reported again without asking the controller twice.

Where a controller takes samples, a run has a row wherever a force may change, if no other rows are asked for. Where
samples are few, a period is divided, so that there are `SAMPLES` rows at least.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.simulation.equations.controller import Cuts, Feedback, Placed
from symdyn.simulation.prescribed.forces import Forces, force_names
from symdyn.simulation.prescribed.formulas_in_time import SAMPLES

SAME = 1e-9
"""Part of a period by which two times may differ and are one."""

STEP = 1e-6
"""Size of a difference, over that of the coordinate or 1, of a law that does not tell its slope."""


class ControllerError(SimulateError):
    """A controller that raised something, or returned what no force can be: what it was, and when."""


def lateness(feedback: Feedback) -> tuple[int, float]:
    """Return how late forces of a controller that takes samples act: whole periods, and the rest, s."""
    assert feedback.period is not None, "only of controllers that take samples"
    whole, rest = divmod(feedback.delay, feedback.period)
    if feedback.period - rest < SAME * feedback.period:
        whole, rest = whole + 1, 0.0
    return int(whole), rest if rest > SAME * feedback.period else 0.0


class Loop:
    """A controller of a scene with nq coordinates, nv velocities and some inputs, in a run to the time `until`.

    Attributes:
        samples: how many were taken.
        cuts: when forces were cut at their limits.
    """

    def __init__(self, placed: Placed, nq: int, nv: int, until: float, inputs: int = 0) -> None:
        """Take a controller; it says nothing before `start`."""
        self.placed, self.nq, self.nv, self.until = placed, nq, nv, until
        self.size = nv + inputs
        feedback = placed.feedback
        self.law, self.period = feedback.law, feedback.period
        self.samples = 0
        self.late, self.rest = (0, 0.0) if self.period is None else lateness(feedback)
        self.cuts = Cuts(placed.names, placed.units, placed.least, placed.most)
        self._since, self._held = [-math.inf], [self._cut(np.array(placed.initial))]
        self._waiting: deque[tuple[float, Array]] = deque()

    def start(self, q: Array, u: Array) -> None:
        """Begin at t = 0: take the first sample, if samples are taken."""
        if self.period is not None:
            self.cuts.change(0.0, self.cuts.of(np.array(self.placed.initial)))
            self._sample(q, u)
            self._act(0.0)
        elif self.cuts.limited:
            self.cuts.change(0.0, self.cuts.of(self._said(0.0, q, u)))

    def look(self, t0: float, t1: float, states: Callable[[Array], Array]) -> None:
        """Look, of a controller that acts all the time, where its forces pass their limits in a step from t0 to t1.

        `states` are those at times of the step, shape (k, nx).
        """
        if self.period is None and self.cuts.limited:

            def asked(t: float) -> Array:
                x = states(np.array([t]))[0]
                return self._said(t, x[: self.nq], x[self.nq : self.nq + self.nv])

            self.cuts.look(t0, t1, asked)

    @property
    def due(self) -> float:
        """The next time at which a sample is taken or a force may change; the end of the run if there is none."""
        if self.period is None:
            return self.until
        found = min([self.samples * self.period, *(when for when, _ in self._waiting)])
        return self.until if found > self.until - SAME * self.period else found

    def halt(self, t: float, q: Array, u: Array) -> bool:
        """Take the sample of a time and let act what acts from then on; tell whether the time was due."""
        if t >= self.until or t < self.due:
            return False
        assert self.period is not None, "else only the end is due"
        if t >= self.samples * self.period:
            self._sample(q, u)
        self._act(t)
        return True

    def __call__(self, t: npt.ArrayLike, q: Array, u: Array) -> Array:
        """Return driving forces, then inputs, at times () or (N,) and states, shape (nv + inputs,) or (N, ..)."""
        times = np.asarray(t, dtype=np.float64)
        found = np.zeros((*times.shape, self.size))
        places = list(self.placed.places)
        if not times.ndim:
            now = float(times)
            found[places] = self.requested(now, q, u) if self.period is None else self._acting(now)
            return found
        for k, now in enumerate(times.tolist()):
            try:
                found[k, places] = self.requested(now, q[k], u[k]) if self.period is None else self._acting(now)
            except ControllerError:  # the run has ended there
                found[k, places] = math.nan
        return found

    def _acting(self, t: float) -> Array:
        slack = SAME * (self.period or 0.0)  # a row's time and a sample's may be rounded differently
        return self._held[bisect_right(self._since, t + slack) - 1]

    def requested(self, t: float, q: Array, u: Array) -> Array:
        """Return what the law says, cut at its limits, shape (m,); errors as of `_said`."""
        return self._cut(self._said(t, q, u))

    def _said(self, t: float, q: Array, u: Array) -> Array:
        """Return what the law says, shape (m,).

        Raises:
            ControllerError: it raised something, or returned what is no force.
        """
        names, when, title = self.placed.names, f"at t = {t:.9g} s", self.placed.title
        try:
            said = self.law(t, q.copy(), u.copy())
        except Exception as fault:
            words = f": {fault}" if str(fault) else ""
            raise ControllerError(f"{title} raised {type(fault).__name__}{words} {when}") from fault
        try:
            found = np.asarray(said, dtype=np.float64)
        except (TypeError, ValueError):
            raise ControllerError(f"{title} returned {said!r:.80}, which is no force, {when}") from None
        if found.shape != (len(names),) and not (found.shape == () and len(names) == 1):
            raise ControllerError(
                f"{title} returned numbers of shape {found.shape} {when}; "
                f"{', '.join(names)} {'takes' if len(names) == 1 else 'take'} shape ({len(names)},)"
            )
        found = found.reshape(len(names))
        for name, value in zip(names, found, strict=True):
            if not math.isfinite(value):
                raise ControllerError(f"{title} returned {value} for {name} {when}")
        return found

    def slope(self, t: float, q: Array, u: Array) -> Array:
        """Return their derivative by (q, u) at a state, shape (nv + inputs, nq + nv); 0 of what is held or cut."""
        found = np.zeros((self.size, self.nq + self.nv))
        if self.period is not None:
            return found
        own = getattr(self.law, "slope", None)
        rows = self._differences(t, q, u) if own is None else np.array(own(t, q, u))
        forces = self.requested(t, q, u)
        for k, (row, force) in enumerate(zip(rows, forces, strict=True)):
            if self.placed.least[k] < force < self.placed.most[k]:
                found[self.placed.places[k]] = row
        return found

    def _differences(self, t: float, q: Array, u: Array) -> Array:
        x, columns = np.concatenate([q, u]), []
        for k in range(len(x)):
            step = STEP * max(1.0, abs(float(x[k])))
            ahead, behind = x.copy(), x.copy()
            ahead[k] += step
            behind[k] -= step
            pair = (self.requested(t, one[: self.nq], one[self.nq :]) for one in (ahead, behind))
            columns.append((next(pair) - next(pair)) / (2 * step))
        return np.array(columns).T

    def _cut(self, forces: Array) -> Array:
        return np.clip(forces, self.placed.least, self.placed.most)

    def _sample(self, q: Array, u: Array) -> None:
        assert self.period is not None
        k = self.samples
        self._waiting.append(((k + self.late) * self.period + self.rest, self._said(k * self.period, q, u)))
        self.samples += 1

    def _act(self, t: float) -> None:
        while self._waiting and self._waiting[0][0] <= t:
            when, forces = self._waiting.popleft()
            self._since.append(when)
            self._held.append(self._cut(forces))
            self.cuts.change(when, self.cuts.of(forces))


class Loops:
    """Several that act together: a controller, and functions that forces are given by; at most one takes samples."""

    def __init__(self, loops: Sequence[Loop]) -> None:
        """Take them; each says nothing before `start`."""
        self.loops = tuple(loops)
        self.period = next((one.period for one in loops if one.period is not None), None)

    def start(self, q: Array, u: Array) -> None:
        """Begin at t = 0."""
        for one in self.loops:
            one.start(q, u)

    @property
    def due(self) -> float:
        """The next time at which a force may change, see `Loop.due`."""
        return min(one.due for one in self.loops)

    def halt(self, t: float, q: Array, u: Array) -> bool:
        """Let act what acts from a time on; tell whether it was due."""
        heard = [one.halt(t, q, u) for one in self.loops]
        return any(heard)

    def look(self, t0: float, t1: float, states: Callable[[Array], Array]) -> None:
        """Look where forces pass their limits in a step, see `Loop.look`."""
        for one in self.loops:
            one.look(t0, t1, states)

    def __call__(self, t: npt.ArrayLike, q: Array, u: Array) -> Array:
        """Return the sum of their forces at times () or (N,) and states, shape (nv,) or (N, nv)."""
        return np.asarray(sum(one(t, q, u) for one in self.loops))

    def slope(self, t: float, q: Array, u: Array) -> Array:
        """Return ∂τ/∂(q, u) at a state, shape (nv, nq + nv)."""
        return np.asarray(sum(one.slope(t, q, u) for one in self.loops))


MOST = 200_000
"""Samples beyond which some have no row of their own, unless that is asked for."""


def sampled_rows(placed: Placed, until: float) -> Array:
    """Return the times of the rows, ascending from 0 to `until`: samples, what lies between, and changes of forces."""
    period = _period(placed)
    count = math.floor(until / period * (1 + 1e-12))
    step = math.ceil(max(1, count) / MOST)
    numbers = np.arange(0, count + 1, step)
    times = numbers * period
    if step == 1:
        parts = math.ceil(SAMPLES * period / until)
        rest = lateness(placed.feedback)[1]
        between = [times + period * k / parts for k in range(1, min(parts, SAMPLES + 1))]
        between += [times + rest] if rest else []
        times = np.concatenate([times, *between])
    times = np.sort(times[times < until - SAME * period], kind="stable")
    apart = np.diff(times, prepend=-math.inf) > SAME * period
    return np.append(times[apart], until)


def hidden(placed: Placed, times: Array) -> list[str]:
    """Return what is said where samples lie between rows at times, nothing where all of them are seen."""
    period = _period(placed)
    late, rest = lateness(placed.feedback)
    acts = np.arange(late, math.floor(times[-1] / period * (1 + 1e-12)) + 1) * period + rest
    acts = acts[acts < times[-1] - SAME * period]
    unseen = np.maximum(np.bincount(np.searchsorted(times, acts - SAME * period), minlength=1) - 1, 0)
    if not unseen.any():
        return []
    return [
        f"the controller takes a sample every {period:g} s, and {int(unseen.sum())} of {len(acts)} lie between rows, "
        f"up to {int(unseen.max())} between two: the columns show the last one; {argument('every', period)} "
        "shows all"
    ]


def held_columns(scene: Scene, forces: Forces, placed: Placed, others: tuple[int, ...]) -> tuple[str, ...]:
    """Return the columns that are constant from one sample to the next: forces, inputs, and outputs made of them alone.

    `others` are the places of what acts all the time beside the controller.
    """
    names, constant = force_names(scene), {one.name for one in scene.parameters}
    moving = {*forces.tables, *others}

    def still(k: int, held: set[str]) -> bool:
        return k not in moving and set(forces.formula(k).symbols) <= constant | held

    first = len(scene.velocities)
    inputs = {names[k] for k in range(first, len(names)) if k in placed.places and still(k, set())}
    drives = {
        names[k]
        for k in range(first)
        if still(k, inputs) and (k in placed.places or inputs.intersection(forces.formula(k).symbols))
    }
    found = inputs | drives
    outputs = {
        one.name for one in scene.outputs if found.intersection(s := set(one.formula.symbols)) and s <= constant | found
    }
    return tuple(name for name in (*names, *(one.name for one in scene.outputs)) if name in found | outputs)


def _period(placed: Placed) -> float:
    assert placed.feedback.period is not None, "only of controllers that take samples"
    return placed.feedback.period
