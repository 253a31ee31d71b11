"""A controller at work in one run: its force at a state or held since its last sample, and the rows of the run.

Sample k is taken at k T, and acts from (k + m) T + r on, where m T + r is the delay and 0 ≤ r < T. The integration
stops at all these times, so that a step never goes across a jump of a force. What acts at a time is kept, so that a run
can be reported again without asking the controller twice.

States z of a controller that acts all the time are a part of the state of the run, x = [q, u, z, W]. Those of one that
takes samples are kept here, from sample to sample, and so is all that it computed. What it measures may have noise, and
is then rounded to the steps of its converter.
"""

from __future__ import annotations

import copy
import math
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.errors import SimulateError, listed, quoted
from symdyn.scene import Scene
from symdyn.simulation.equations.controller import Feedback, Placed
from symdyn.simulation.equations.linear_law import LinearLaw
from symdyn.simulation.equations.saturation import Cuts
from symdyn.simulation.prescribed.forces import Forces, force_names
from symdyn.simulation.prescribed.formulas_in_time import SAMPLES

SAME = 1e-9
"""Part of a period by which two times may differ and are one."""

STEP = 1e-6
"""Size of a difference, over that of the coordinate or 1, of a law that does not tell its slope."""


class ControllerError(SimulateError):
    """A controller that raised something, or returned what no force can be: what it was, and when."""


def differences_of(of: Callable[[Array], Array], x: Array, relative: float) -> Array:
    """Return ∂f/∂x of a function by central differences, whose size is over that of each entry or 1; (m, nx)."""
    columns = []
    for k, value in enumerate(x.tolist()):
        step = relative * max(1.0, abs(value))
        ahead, behind = x.copy(), x.copy()
        ahead[k] += step
        behind[k] -= step
        columns.append((of(ahead) - of(behind)) / (2 * step))
    return np.array(columns).T


def lateness(feedback: Feedback) -> tuple[int, float]:
    """Return how late forces of a controller that takes samples act: whole periods, and the rest, s."""
    assert feedback.period is not None, "only of controllers that take samples"
    whole, rest = divmod(feedback.delay, feedback.period)
    if feedback.period - rest < SAME * feedback.period:
        whole, rest = whole + 1, 0.0
    return int(whole), rest if rest > SAME * feedback.period else 0.0


NOTHING: Array = np.zeros(0)


class Computed(NamedTuple):
    """What a controller computed at a time."""

    command: Array  # what it asked for, before limits, shape (m,)
    states: Array = NOTHING  # z, shape (n,)
    moved: Array = NOTHING  # ż, or z at the next sample, shape (n,)
    measured: Array = NOTHING  # the signals that it was told, shape (p,)
    reference: Array = NOTHING  # of a linear law, shape (p,)


class Loop:
    """A controller in a run to the time `until`, of a scene with nq coordinates, and nu velocities and states.

    The last `hidden` of the states are modes of contacts, which no law is told. It returns as many driving forces and
    inputs as `size` says.

    Attributes:
        beside: functions that forces are given by, which are added; they act all the time and have no limits or states.
        nz: how many states of the controller are states of the run.
        z: its states at the start, or at the next sample.
        taken: what columns show of its samples, in order.
        over: whether it takes no more samples.
        cuts: when forces were cut at their limits.
    """

    def __init__(
        self, placed: Placed, nq: int, nu: int, until: float, size: int, beside: Sequence[Placed] = (), hidden: int = 0
    ) -> None:
        """Take a controller; it says nothing before `start`."""
        self.placed, self.nq, self.nu, self.until, self.size = placed, nq, nu, until, size
        self.told = nu - hidden
        self.beside = tuple(Loop(one, nq, nu, until, size, (), hidden) for one in beside)
        feedback = placed.feedback
        self.law, self.period = feedback.law, feedback.period
        self.nz, self.z = 0, NOTHING
        self.taken: list[Array] = []
        self.over = False
        self.late, self.rest = (0, 0.0) if self.period is None else lateness(feedback)
        self.cuts = Cuts(placed.names, placed.units, placed.least, placed.most)
        self._since, self._held = [-math.inf], [self._cut(np.array(placed.initial))]
        self._waiting: deque[tuple[float, Array]] = deque()
        self._noise, self._steps = np.array(placed.noise), np.array(placed.steps)
        self._rough = np.flatnonzero((self._noise > 0) | (self._steps > 0)).tolist()
        self._led = [] if placed.signals is None else placed.signals.given
        self._random = np.random.default_rng(feedback.seed)

    @property
    def samples(self) -> int:
        """How many samples were taken."""
        return len(self.taken)

    def start(self, q: Array, u: Array) -> None:
        """Begin at t = 0: take the first sample, if samples are taken."""
        if self.period is not None:
            self.cuts.change(0.0, self.cuts.of(np.array(self.placed.initial)))
            self._sample(q, u)
            self._act(0.0)
            return
        if self.cuts.limited or isinstance(self.law, LinearLaw):
            found = self.computed(0.0, q, u, None)
            self.z, self.nz = found.states, len(found.states)
            self.cuts.change(0.0, self.cuts.of(found.command))

    def again(self, t: float) -> Loop:
        """Return what acted from a time of the run on, which is over: nobody asks the law for a sample twice."""
        found = copy.copy(self)
        found.cuts = Cuts(self.placed.names, self.placed.units, self.placed.least, self.placed.most)
        if self.period is not None:
            now, found.over = self._now(t), True
            found._since, found._held = self._since[: now + 1], self._held[: now + 1]
            found._waiting = deque(zip(self._since[now + 1 :], self._held[now + 1 :], strict=True))
        return found

    def look(self, t0: float, t1: float, states: Callable[[Array], Array]) -> None:
        """Look, of a controller that acts all the time, where its forces pass their limits in a step from t0 to t1.

        `states` are those at times of the step, shape (k, nx).
        """
        if self.period is None and self.cuts.limited:

            def asked(t: float) -> Array:
                x, n = states(np.array([t]))[0], self.nq + self.nu
                return self.computed(t, x[: self.nq], x[self.nq : n], x[n : n + self.nz]).command

            self.cuts.look(t0, t1, asked)

    @property
    def due(self) -> float:
        """The next time at which a sample is taken or a force may change; the end of the run if there is none."""
        if self.period is None:
            return self.until
        sample = math.inf if self.over else self.samples * self.period
        found = min([sample, *(when for when, _ in self._waiting)])
        return self.until if found > self.until - SAME * self.period else found

    def halt(self, t: float, q: Array, u: Array) -> bool:
        """Take the sample of a time and let act what acts from then on; tell whether the time was due."""
        if t >= self.until or t < self.due:
            return False
        assert self.period is not None, "else only the end is due"
        if not self.over and t >= self.samples * self.period:
            self._sample(q, u)
        self._act(t)
        return True

    def __call__(self, t: npt.ArrayLike, q: Array, u: Array, z: Array = NOTHING) -> Array:
        """Return driving forces, then inputs, at times () or (N,) and states, shape (nv + inputs,) or (N, ..)."""
        found, places = np.zeros((*np.shape(t), self.size)), list(self.placed.places)
        found[..., places] = self._each(self._acting, len(places), t, q, u, z)
        return np.asarray(sum((one(t, q, u) for one in self.beside), found))

    def rates(self, t: npt.ArrayLike, q: Array, u: Array, z: Array) -> Array:
        """Return ż at times () or (N,) and states, shape (nz,) or (N, nz)."""
        return self._each(lambda *state: self.computed(*state).moved, self.nz, t, q, u, z)

    @staticmethod
    def _each(of: Callable[..., Array], size: int, t: npt.ArrayLike, q: Array, u: Array, z: Array) -> Array:
        """Return a function of a time and a state at each of them, NaN where the controller ended the run."""
        times = np.asarray(t, dtype=np.float64)
        if not times.ndim:
            return of(float(times), q, u, z)
        found = np.full((len(times), size), math.nan)
        for k, now in enumerate(times.tolist()):
            try:
                found[k] = of(now, q[k], u[k], z[k] if z.ndim == 2 else z)
            except ControllerError:
                continue
        return found

    def _acting(self, t: float, q: Array, u: Array, z: Array) -> Array:
        if self.period is None:
            return self._cut(self.computed(t, q, u, z).command)
        return self._held[self._now(t)]

    def _now(self, t: float) -> int:
        slack = SAME * (self.period or 0.0)  # a row's time and a sample's may be rounded differently
        return bisect_right(self._since, t + slack) - 1

    def computed(self, t: float, q: Array, u: Array, z: Array | None) -> Computed:
        """Return what the controller computes from a state of the run and its own, shape (n,); None is its start.

        Raises:
            ControllerError: it raised something, returned what is no force, or measures what has no value.
        """
        u = u[: self.told]
        y, r = self._measure(t, q, u)
        if not isinstance(self.law, LinearLaw):
            q, u = (y[: self.nq], y[self.nq :]) if len(y) else (q, u)
            return Computed(self._said(t, q, u), measured=y)
        e = r - y
        z = self.law.start @ e if z is None else z
        command = self._finite(t, self.law.command(z, e))
        return Computed(command, z, self.law.moved(z, e, self._cut(command) - command), y, r)

    def _measure(self, t: float, q: Array, u: Array) -> tuple[Array, Array]:
        """Return measured signals and references, with noise where samples are taken, shape (p,) each.

        Of a law that is told the whole state these are coordinates and velocities, and nothing where all are exact.
        """
        signals, y, r = self.placed.signals, NOTHING, NOTHING
        if signals is not None:
            y, r = signals(t, q, u)
            for name, finite in zip(signals.measures, np.isfinite(r - y), strict=True):
                if not finite:
                    raise ControllerError(f"feedback: the measured signal {name} has no finite value at t = {t:.9g} s")
        elif self._rough:
            y = np.concatenate([q, u])
        if self._rough:
            y = y + self._noise * self._random.standard_normal(len(y))
            rough = self._steps > 0
            y[rough] = np.round(y[rough] / self._steps[rough]) * self._steps[rough]
        return y, r

    def _said(self, t: float, q: Array, u: Array) -> Array:
        """Return what the law says, shape (m,); ControllerError where it raised something, or returned no force."""
        names, when, title = self.placed.names, f"at t = {t:.9g} s", self.placed.title
        try:
            said = self.law(t, q.copy(), u.copy())
        except Exception as fault:
            words = f": {fault}" if str(fault) else ""
            state = listed(f"{k} = {x:.6g}" for k, x in zip(self.placed.labels, [*q, *u], strict=False))
            raise ControllerError(f"{title} raised {type(fault).__name__}{words} {when}, given {state}") from fault
        try:
            found = np.asarray("None" if said is None else said, dtype=np.float64)  # NumPy takes None as nan
        except (TypeError, ValueError):
            order = f"{', '.join(names)}" if hasattr(said, "keys") else ""
            order = order and f"; give numbers in this order: {order}"
            raise ControllerError(f"{title} returned {said!r:.80}, which is no force, {when}{order}") from None
        if found.shape != (len(names),) and not (found.shape == () and len(names) == 1):
            raise ControllerError(
                f"{title} returned {quoted(said)}, numbers of shape {found.shape}, {when}; give one number a force, in "
                f"this order: {', '.join(names)}"
            )
        return self._finite(t, found.reshape(len(names)))

    def _finite(self, t: float, command: Array) -> Array:
        for name, value in zip(self.placed.names, command.tolist(), strict=True):
            if not math.isfinite(value):
                raise ControllerError(f"{self.placed.title} returned {value} for {name} at t = {t:.9g} s")
        return command

    def slope(self, t: float, q: Array, u: Array, z: Array = NOTHING) -> Array:
        """Return ∂τ/∂(q, u, z), then of inputs, shape (nv + inputs, nq + nv + nz); 0 of what is held or cut."""
        found = np.zeros((self.size, self.nq + self.nu + self.nz))
        if self.period is None:
            rows, free = self._slopes(t, q, u, z)
            found[list(self.placed.places)] = free[:, None] * rows
        for one in self.beside:
            found[:, : self.nq + self.nu] += one.slope(t, q, u)
        return found

    def rate_slope(self, t: float, q: Array, u: Array, z: Array) -> Array:
        """Return ∂ż/∂(q, u, z), shape (nz, nq + nv + nz)."""
        signals, law = self.placed.signals, self.law
        if not self.nz or signals is None or not isinstance(law, LinearLaw):
            return np.zeros((0, self.nq + self.nu))
        rows, free = self._slopes(t, q, u, z)
        found = np.hstack([law.B @ self._unmoved(signals.slopes(t, q, u[: self.told])), law.A])
        return found + law.tracking @ ((free - 1.0)[:, None] * rows)

    def _slopes(self, t: float, q: Array, u: Array, z: Array) -> tuple[Array, Array]:
        """Return ∂v/∂(q, u, z), shape (m, nq + nv + nz), and 1 for what is not cut, 0 for what is, shape (m,)."""
        signals, law, u = self.placed.signals, self.law, u[: self.told]
        command = self.computed(t, q, u, z).command
        free = ((np.array(self.placed.least) < command) & (command < np.array(self.placed.most))).astype(float)
        if signals is not None and isinstance(law, LinearLaw):
            return np.hstack([law.D @ self._unmoved(signals.slopes(t, q, u)), law.C]), free
        own = getattr(law, "slope", None)
        if own is None:
            x = np.concatenate([q, u])
            return self._unmoved(differences_of(lambda y: self._said(t, y[: self.nq], y[self.nq :]), x, STEP)), free
        return self._unmoved(np.array(own(t, q, u))), free

    def _unmoved(self, slopes: Array) -> Array:
        """Return slopes of what a law is told, with zeros for modes of contacts, shape (.., nq + nu)."""
        return np.hstack([slopes, np.zeros((len(slopes), self.nu - self.told))])

    def _cut(self, forces: Array) -> Array:
        return np.clip(forces, self.placed.least, self.placed.most)

    def _sample(self, q: Array, u: Array) -> None:
        assert self.period is not None
        k = self.samples
        found = self.computed(k * self.period, q, u, self.z if k else None)
        self._waiting.append(((k + self.late) * self.period + self.rest, found.command))
        self.taken.append(self._row(k * self.period, q, u, found))
        self.z = found.moved

    def _act(self, t: float) -> None:
        while self._waiting and self._waiting[0][0] <= t:
            when, forces = self._waiting.popleft()
            self._since.append(when)
            self._held.append(self._cut(forces))
            self.cuts.change(when, self.cuts.of(forces))

    def columns(self, t: Array, q: Array, u: Array, z: Array) -> dict[str, Array]:
        """Return what the controller computed at times (N,) and states (N, ..), by name of a column, each (N,).

        Commands before their limits, its states, references that were given, and signals with noise; of one that takes
        samples what it computed at the last of them.
        """
        labels = self.placed.labels
        names = [f"command_{name}" for name in self.placed.names]
        names += self.law.states if isinstance(self.law, LinearLaw) else ()
        names += [f"reference_{labels[k]}" for k in self._led] + [f"measured_{labels[k]}" for k in self._rough]

        def row(t: float, q: Array, u: Array, z: Array) -> Array:
            if self.period is None:
                return self._row(t, q, u, self.computed(t, q, u, z))
            return self.taken[min(int(t / self.period + SAME), self.samples - 1)]

        return dict(zip(names, self._each(row, len(names), t, q, u, z).T, strict=True))

    def _row(self, t: float, q: Array, u: Array, found: Computed) -> Array:
        z, law, signals = found.states, self.law, self.placed.signals
        if signals is not None and isinstance(law, LinearLaw) and law.shown is not None:
            ahead, behind = (signals(t + sign * STEP, q, u[: self.told])[1] for sign in (1, -1))
            zero, slopes = law.shown
            z = z + zero + slopes[0] @ (found.reference - law.y0) + slopes[1] @ (ahead - behind) / (2 * STEP)
        return np.concatenate([found.command, z, found.reference[self._led], found.measured[self._rough]])


MOST = 200_000
"""Samples beyond which some have no row of their own, unless that is asked for."""


def sampled_rows(placed: Placed, until: float) -> Array:
    """Return the times of the rows, from 0 to `until`: samples, changes of forces, and `SAMPLES` rows at least."""
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
        f"up to {int(unseen.max())} between two: the columns show the last one; {argument('every', period)} shows all"
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
