"""An integration: what an integrator is given and yields, and a run from its start to its end, however it ends.

An integrator is a generator: it yields the samples of the stretch that it has just covered, so that whoever draws them
can show progress, and stop between any two with all before them in hand.

A run ends by time, an event, an interrupt or a failure. A long one reports how long it will take. One that would take
years is ended: the time of the end may be a typing error, `--until 1e6` for 1e0. The pace is that of the stretch since
the last look, so that a slow beginning does not count; it takes two such looks to end a run.

Where a run cannot begin or go on since something has no value at a state, that part of the scene is named.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from functools import partial

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.frozen import dataclass, field, replace
from symdyn.simulation.equations.control_loop import ControllerError
from symdyn.simulation.equations.events import jumped
from symdyn.simulation.equations.system import Projection, StateEquations


class IntegrationError(SimulateError):
    """An integrator that cannot go on: what it said."""


@dataclass(frozen=True)
class InitialValueProblem:
    """One integration.

    Attributes:
        system: the equations.
        x: state at its begin, shape (nx,).
        times: where samples are wanted, ascending, from its begin, 0 of a run, to the end; shape (N,).
        rtol, atol: tolerances on a step, relative and absolute.
        stops: whether an event of each of the system's kinds ends the run; () looks for none.
        project: brings states back to their constraints.
        low: what the state is beyond its doubles, shape (nx,); None for nothing.
        unsure: from when on in a step passages of an event may have been overlooked, s, by event; the search fills it.
        residue: what guards may be at its begin and still be zero, by event, where one has just passed.
    """

    system: StateEquations
    x: Array
    times: Array
    rtol: float
    atol: float
    stops: tuple[bool, ...]
    project: Projection
    low: Array | None = None
    unsure: dict[int, float] = field(default_factory=dict)
    residue: Mapping[int, float] = field(default_factory=dict)

    @property
    def begin(self) -> float:
        return float(self.times[0])

    @property
    def until(self) -> float:
        return float(self.times[-1])

    def halts(self, event: int) -> bool:
        """Tell whether an integrator halts at an event: it ends the run, or something jumps."""
        return self.stops[event] or self.system.kinds[event].halts

    @property
    def bends(self) -> Collection[int]:
        """Which of the events are places where the equations bend; none where none is looked for."""
        return self.system.bends if self.stops else ()

    @property
    def bound(self) -> float:
        """Time beyond which no step may go: where a controller is due, else the end."""
        return self.until if self.system.loop is None else min(self.until, self.system.loop.due)


@dataclass(frozen=True)
class Hit:
    """An event: which formula crossed zero, when and where."""

    event: int
    t: float
    x: Array


@dataclass(frozen=True)
class Piece:
    """What an integrator has found since the last piece.

    Attributes:
        t: times of the samples, shape (k,), k may be 0.
        x: their states, shape (k, nx).
        hits: events in that stretch, in order.
        now: where the integration stands: time and state.
        steps: steps taken in that stretch.
        evaluations: of the right-hand side in that stretch.
        stopped: whether the last hit ended the stretch, by ending the run or by a jump.
        low: what states are beyond their doubles, shape (k, nx); None of methods that compute in doubles.
    """

    t: Array
    x: Array
    hits: tuple[Hit, ...]
    now: tuple[float, Array]
    steps: int
    evaluations: int
    stopped: bool = False
    low: Array | None = None


Integrator = Callable[[InitialValueProblem], Iterator[Piece]]

END, INTERRUPTED, STOPPED = "end", "interrupted", "stopped by an event"
"""How an integration ended; else why the integrator gave up."""

SHARE = 0.1
"""Part of the tolerance that multistep methods are given for a step: the errors of theirs add up, to ten and more."""


DOUBLES = 1e-16
"""The finest relative tolerance that means anything in doubles."""


@dataclass(frozen=True)
class Method:
    """An integrator.

    Attributes:
        library: whose it is.
        text: what it is, one line.
        module: what must be importable.
        extra: the extra of this package that installs it; "" for none.
        rtol: tolerance if none is given.
        run: the integrator.
        refuses: why it does not apply to a system, "" if it does.
        finds_events: whether it looks for zeros of formulas, and stops at limits of joints.
        finest: the finest relative tolerance that it works with, and that means anything in the numbers it computes in.
        absolute: whether it has an absolute tolerance too.
        multistep: whether a step rests on those before, so that it begins anew slowly.
        step: length of its steps, s, of one that has no tolerance; else None.
    """

    library: str
    text: str
    module: str
    extra: str
    rtol: float
    run: Integrator
    refuses: Callable[[StateEquations], str] = lambda system: ""
    finds_events: bool = True
    finest: float = DOUBLES
    absolute: bool = True
    multistep: bool = False
    step: float | None = None

    @property
    def installed(self) -> bool:
        return importable(self.module)

    @property
    def beyond_doubles(self) -> bool:
        """Whether it computes with more digits than doubles have."""
        return self.finest < DOUBLES

    def tolerances(self, name: str, rtol: float | None, atol: float | None) -> tuple[float, float, list[str]]:
        """Return the relative and the absolute tolerance that it takes, and what is said of others that are asked for.

        `name` is its own; None asks for none.
        """
        if self.step is not None:
            told = [] if rtol is atol is None else [f"tolerances have no effect: {name} has steps of one length"]
            return 0.0, 0.0, told
        relative = self.rtol if rtol is None else max(rtol, self.finest)
        absolute = relative if atol is None or not self.absolute else atol
        said = []
        if rtol is not None and rtol < self.finest:
            said.append(f"rtol = {rtol:g} is finer than what {name} works with; it takes {self.finest:.2g}")
        if atol is not None and not self.absolute and atol != relative:
            said.append(
                f"atol = {atol:g} has no effect: {name} has one tolerance, rtol = {relative:g}, relative to the "
                "largest number of a state, or absolute where that is below 1"
            )
        return relative, absolute, said


LIBRARIES_RAISE = (ArithmeticError, ValueError, RuntimeError, MemoryError)
"""What integrators and linear algebra of others end with, where a state is not finite or a matrix is singular."""


def integrate(method: Method, problem: InitialValueProblem) -> Iterator[Piece]:
    """Yield the pieces of a motion; whatever a library ends with is told in words, and what came before it stands.

    Raises:
        IntegrationError: the integrator cannot go on.
    """
    t = problem.begin
    try:
        with np.errstate(all="ignore"):  # what tells that a motion ends there is said in words
            for piece in _through_jumps(method, problem):
                t = piece.now[0]
                yield piece
    except ControllerError as fault:
        raise IntegrationError(str(fault)) from fault
    except LIBRARIES_RAISE as fault:
        if isinstance(fault.__cause__ or fault.__context__, KeyboardInterrupt):  # a library's own words for Ctrl-C
            raise KeyboardInterrupt from fault
        raise IntegrationError(f"{method.library} cannot go on after t = {t:g} s: {fault}") from fault


SAME, CLOSEST, MANY, ULPS = 1e-12, 1e-9, 1000, 8
"""Times that are one, in s and over the time; the least of it that so many events take; roundings to go on behind."""


def _through_jumps(method: Method, problem: InitialValueProblem) -> Iterator[Piece]:
    """Yield the pieces of a motion, which goes on behind an event at which something jumps."""
    whole, times, residue = problem, list[float](), dict[int, float]()
    while True:
        again: tuple[float, Array] | None = None
        for found in method.run(problem):
            piece = found
            if problem is not whole and len(piece.t) and piece.t[0] == problem.begin:  # a row that was told
                piece = replace(piece, t=piece.t[1:], x=piece.x[1:])
            if not piece.stopped or any(whole.stops[hit.event] for hit in piece.hits):
                yield piece
                continue
            t, x = piece.now
            last = [hit.event for hit in piece.hits if hit.t >= t - SAME * max(1.0, t)]
            x, more, residue = jumped(whole.system, whole.stops, t, x, last)
            stopped = any(whole.stops[k] for k in more)
            again = None if stopped else (t, x)
            yield replace(piece, hits=(*piece.hits, *(Hit(k, t, x) for k in more)), now=(t, x), stopped=stopped)
        if again is None or again[0] >= whole.until:
            return
        if times and again[0] <= times[-1]:  # a force jumps there, whose value ahead told the event: go on behind it
            t, x = times[-1] + ULPS * np.spacing(times[-1]), again[1]
            passed, again = whole.times[(whole.times > times[-1]) & (whole.times <= t)], (t, x)
            yield Piece(passed, np.tile(x, (len(passed), 1)), (), again, 0, 0)
        times.append(again[0])
        if len(times) > MANY and times[-1] - times[-MANY] <= CLOSEST * times[-1]:
            span = f"{MANY} of them in {times[-1] - times[-MANY]:.1g} s"
            raise IntegrationError(f"events come closer and closer at t = {again[0]:.9g} s: {span}")
        later = whole.times[whole.times > again[0]]
        problem = replace(whole, x=again[1], times=np.append(again[0], later), low=None, residue=residue)


def importable(name: str) -> bool:
    """Tell whether a module is installed."""
    from importlib.util import find_spec

    return find_spec(name) is not None


@dataclass(frozen=True)
class Integration:
    """What an integrator has found until it ended.

    Attributes:
        t, x: times and states of the samples, and where it stood at its end; shapes (N,) and (N, nx).
        hits: events in order; of several at one time the last is one that ends runs, if any does.
        stopped: "end", "interrupted", `STOPPED` by the last of the hits, or why the integrator gave up.
        steps, evaluations: of the integrator.
        preparing, wall: seconds until its first state, and from there on.
        low: what states are beyond their doubles, shape (N, nx); None of methods that compute in doubles.
    """

    t: Array
    x: Array
    hits: tuple[Hit, ...]
    stopped: str
    steps: int
    evaluations: int
    preparing: float
    wall: float
    low: Array | None = None


def integrated(
    problem: InitialValueProblem,
    method: Method,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Integration:
    """Return what an integrator finds; `progress` hears the share that is done, `say` how long a long run takes."""
    pieces: list[Piece] = []
    stopped, outlook = END, Outlook(problem.until, say)
    begin = ready = time.perf_counter()
    try:
        for piece in integrate(method, problem):
            if not pieces:
                ready = time.perf_counter()
            pieces.append(piece)
            outlook.look(piece.now[0], partial(_why, problem, *piece.now))
            if progress is not None:
                progress(piece.now[0] / problem.until)
    except KeyboardInterrupt:
        stopped = INTERRUPTED
    except IntegrationError as fault:
        stopped = str(fault)
    wall, flags = time.perf_counter() - ready, problem.stops
    now = pieces[-1].now if pieces else (problem.begin, problem.x)
    t = np.concatenate([np.empty(0), *(piece.t for piece in pieces)])
    x = np.concatenate([np.empty((0, len(problem.x))), *(piece.x for piece in pieces)])
    low = _low(pieces)
    if pieces and pieces[-1].stopped and len(t) and t[-1] > now[0]:  # a limit is passed before its slack is
        before = t <= now[0]
        t, x = t[before], x[before]
    if not len(t) or now[0] > t[-1]:  # where it stands when it ends between two samples
        t, x = np.append(t, now[0]), np.vstack([x, now[1]])
    hits = tuple(sorted((hit for piece in pieces for hit in piece.hits), key=lambda hit: (hit.t, flags[hit.event])))
    if pieces and pieces[-1].stopped:
        stopped = STOPPED
    steps, evaluations = (sum(getattr(piece, name) for piece in pieces) for name in ("steps", "evaluations"))
    if low is not None and len(low) < len(x):  # where it stands between two samples doubles are enough
        low = np.vstack([low, np.zeros_like(x[len(low) :])])
    return _real(problem, Integration(t, x, hits, stopped, steps, evaluations, ready - begin, wall, low))


def _low(pieces: list[Piece]) -> Array | None:
    """Return what samples are beyond their doubles, None where there are no more digits."""
    parts = [piece.low for piece in pieces if piece.low is not None]
    return np.concatenate(parts) if parts else None


def _real(problem: InitialValueProblem, run: Integration) -> Integration:
    """Return a run without its last row where an event stopped it at a place without accelerations."""
    if run.stopped != STOPPED or len(run.t) < 2:
        return run
    with np.errstate(all="ignore"):
        last = problem.system.evaluate("rates", run.t[-1:], run.x[-1:])
    return run if np.all(np.isfinite(last)) else replace(run, t=run.t[:-1], x=run.x[:-1])


GROWN = 100.0
"""Times the largest velocity at the start, or 1 if that is less, beyond which one is named in a run that takes long."""


def _why(problem: InitialValueProblem, t: float, x: Array) -> str:
    """Return what makes a run slow, in words; "" where neither a controller nor a velocity does."""
    loop, nq, n = problem.system.loop, problem.system.nq, problem.system.nq + problem.system.nu
    with suppress(ControllerError):  # one that raises ends the run where the motion asks it
        always = [loop, loop] if loop is not None and loop.period is None else []
        answers = [one(t, x[:nq], x[nq:n], x[n : n + one.nz]) for one in always]
        if answers and not np.array_equal(answers[0], answers[1]):
            return (
                "; the controller answers otherwise when it is asked again at the same state: one that keeps something"
                " from call to call takes a period, Feedback(law, forces, period=0.01), and is asked once in each"
            )
    velocities = slice(nq, nq + problem.system.nv)
    now, first = x[velocities], np.max(np.abs(problem.x[velocities]), initial=1.0)
    k = int(np.argmax(np.abs(now))) if len(now) else 0
    if not len(now) or abs(now[k]) <= GROWN * first:
        return ""
    return (
        f"; {problem.system.scene.velocities[k]} has grown to {now[k]:.2g} in SI units, so look whether it is unstable"
    )


FIRST = 3.0
"""Seconds of computing before the first look, and after each look four times as many."""

LONG, HOPELESS = 60.0, 365.25 * 86400.0
"""Seconds of computing that are worth a word, and those that nobody waits for."""

UNITS = (("year", HOPELESS), ("day", 86400.0), ("hour", 3600.0), ("minute", 60.0), ("second", 1.0))


class Outlook:
    """Looks at the pace of a run."""

    def __init__(self, until: float, say: Callable[[str], None] | None) -> None:
        self.until, self.say = until, say
        self.next, self.t, self.begin = FIRST, 0.0, time.perf_counter()
        self.last, self.hopeless = self.begin, False

    def look(self, t: float, why: Callable[[], str] = str) -> None:
        """Tell how long the rest takes, and why.

        Raises:
            IntegrationError: it would take years.
        """
        now = time.perf_counter()
        if t == 0.0:  # compiling is no part of the pace
            self.begin = self.last = now
        if now - self.last < self.next:
            return
        rest = (self.until - t) * ((now - self.last) / (t - self.t)) if t > self.t else float("inf")
        spent = now - self.begin
        if rest > HOPELESS and self.hopeless:
            raise IntegrationError(
                f"t = {t:g} s after {spoken(spent)} of computing; at this pace t = {self.until:g} s takes "
                f"{spoken(rest)}, so the run ends here; give an end that is sooner, or a coarser tolerance{why()}"
            )
        if rest > LONG and self.say is not None:
            self.say(
                f"t = {t:g} s after {spoken(spent)}; at this pace the end at t = {self.until:g} s is "
                f"{spoken(rest)} away; Ctrl-C ends the run with what it has{why()}"
            )
        self.last, self.t, self.next, self.hopeless = now, t, 4 * self.next, rest > HOPELESS


def spoken(seconds: float) -> str:
    """Return a duration in words, such as "about 5 hours"."""
    name, unit = next(((name, unit) for name, unit in UNITS if seconds >= unit), UNITS[-1])
    number = f"{seconds / unit:.2g}" if seconds < 1000 * HOPELESS else f"{seconds / unit:.0e}"
    return f"about {number} {name}{'s' * (number != '1')}"
