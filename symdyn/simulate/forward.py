"""Forces prescribed, motion computed: the door `simulate`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.scene.table import Faults
from symdyn.simulate.choose import Choice, choose
from symdyn.simulate.constraints import Projection
from symdyn.simulate.forces import Forces
from symdyn.simulate.initial import Start, read_start, singular
from symdyn.simulate.integrate import Hit, IntegrationError, Problem
from symdyn.simulate.model import END, INTERRUPTED, Event, Trajectory
from symdyn.simulate.monitors import observe
from symdyn.simulate.reactions import reaction_columns
from symdyn.simulate.reading import TIME, close, parameter_values, read_formula
from symdyn.simulate.system import System, build_system

Array = npt.NDArray[np.float64]

SAMPLES = 200
"""Samples after the first, if no spacing is given."""

MOST = 20_000_000
"""Samples that are more than anybody reads."""

DRIFT = 1e-2
"""Constraints may be missed by this part of the tolerance before a state is projected, and by rounding at least."""

ROUNDING = 1e-14


def simulate(
    scene: Scene,
    forces: Forces = Forces(),  # noqa: B008  frozen
    until: float = 10.0,
    start: Mapping[str, str] | Start | None = None,
    start_rates: Mapping[str, str] | None = None,
    method: str | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    stops: Sequence[str] = (),
    reports: Sequence[str] = (),
    every: float | None = None,
    reactions: bool = False,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Trajectory:
    """Return the motion that forces give a scene from t = 0 on.

    An interrupt (Ctrl-C) while it integrates returns what was computed so far; `Trajectory.stopped` says so.

    Args:
        scene: the mechanism, its parameters bound.
        forces: driving forces, from `read_forces`.
        until: time of the end, s.
        start: formulas by coordinate, in place of what the scene says; or a whole state.
        start_rates: formulas by velocity.
        method: a key of `METHODS`; None chooses.
        rtol, atol: relative and absolute tolerance of a step; None takes the method's, and rtol.
        stops, reports: formulas in t, coordinates, velocities and parameters; where one crosses zero the run ends, or
            the event is kept.
        every: seconds between samples; None for 200 samples.
        reactions: add the columns of all joint reactions.
        progress: called with the share that is done.
        say: called with lines for the user: the method and why.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    formulas = (*stops, *reports)
    events, times, initial = _checked(scene, until, every, rtol, atol, formulas, start, start_rates)
    for note in initial.notes:
        _tell(say, note)
    system = build_system(scene, forces, events)
    x = np.concatenate([initial.q, initial.u, np.zeros(int(system.works))])
    _ready(system, x)
    choice = choose(system, x, until, method)
    relative = choice.method.rtol if rtol is None else rtol
    absolute = relative if atol is None else atol
    _tell(say, _method(choice, relative, absolute))
    projection = Projection(system, max(ROUNDING, DRIFT * relative))
    flags = tuple(k < len(stops) for k in range(len(formulas)))
    problem = Problem(system, x, times, relative, absolute, flags, projection)
    run = _integrated(problem, choice, progress)
    t, states, hits, stopped, steps, evaluations, wall = run
    ending = formulas[hits[-1].event] if stopped == STOPPED else stopped
    found = tuple(_event(system, formulas, flags, hit) for hit in hits)
    columns, monitors = observe(system, t, states)
    q, u = states[:, : system.nq], states[:, system.nq : system.nq + system.nv]
    qdd = system.tell("rates", t, states)[:, system.nq : system.nq + system.nv]
    tau = np.broadcast_to(system.tell("drives", t, states), u.shape)
    if reactions:
        columns |= reaction_columns(scene, t, q, u, qdd)
    return Trajectory(
        scene, t, q, u, qdd, tau, columns, monitors, found, ending, choice.name, relative, absolute, steps, evaluations,
        wall, initial.notes,
    )  # fmt: skip


STOPPED = "stopped by an event"


def _integrated(
    problem: Problem, choice: Choice, progress: Callable[[float], None] | None
) -> tuple[Array, Array, list[Hit], str, int, int, float]:
    """Return times, states, events, why it ended, steps, evaluations and seconds."""
    t: list[Array] = []
    x: list[Array] = []
    hits: list[Hit] = []
    now, stopped, steps, evaluations = (0.0, problem.x), END, 0, 0
    clock = time.perf_counter()
    try:
        for piece in choice.method.run(problem):
            t.append(piece.t)
            x.append(piece.x)
            now = piece.now
            hits += piece.hits
            steps += piece.steps
            evaluations += piece.evaluations
            stopped = STOPPED if piece.stopped else END
            if progress is not None:
                progress(now[0] / problem.until)
    except KeyboardInterrupt:
        stopped = INTERRUPTED
    except IntegrationError as fault:
        stopped = str(fault)
    wall = time.perf_counter() - clock
    times = np.concatenate(t) if t else np.empty(0)
    states = np.concatenate(x) if x else np.empty((0, len(problem.x)))
    if not len(times) or now[0] > times[-1]:  # where it stands when it ends between two samples
        times, states = np.append(times, now[0]), np.vstack([states, now[1]])
    return times, states, hits, stopped, steps, evaluations, wall


def _checked(
    scene: Scene,
    until: float,
    every: float | None,
    rtol: float | None,
    atol: float | None,
    formulas: Sequence[str],
    start: Mapping[str, str] | Start | None,
    start_rates: Mapping[str, str] | None,
) -> tuple[tuple[object, ...], Array, Start]:
    """Return formulas of events, times of samples and the start; all faults together."""
    values = parameter_values(scene)
    faults = Faults("")
    allowed = (TIME, *scene.coordinates, *scene.velocities, *values)
    events = tuple(read_formula(text, allowed, "event", faults) for text in formulas)
    for text, event in zip(formulas, events, strict=True):
        if event is not None and not event.symbols:
            faults.add("event", f'"{text}" is a constant, which crosses nothing')
    for name, value in (("rtol", rtol), ("atol", atol)):
        if value is not None and not 0 < value < 1:
            faults.add("", f"{name} = {value:g} is not a tolerance; give one between 1e-15 and 1, such as 1e-9")
    times = sample_times(until, every, faults)
    initial = None
    try:
        initial = start if isinstance(start, Start) else read_start(scene, start, start_rates)
    except SimulateError as error:
        faults.lines += error.faults
    close(faults)
    assert initial is not None, "without faults there is a start"
    return events, times, initial


def sample_times(until: float, every: float | None, faults: Faults) -> Array:
    """Return 0, every, 2 every, ..., until."""
    if not (math.isfinite(until) and until > 0):
        faults.add("", f"until = {until:g} s is not a time after the start; give a positive one")
        return np.zeros(1)
    if every is None:
        return np.linspace(0.0, until, SAMPLES + 1)
    if not (math.isfinite(every) and every > 0) or until / every > MOST:
        faults.add("", f"every = {every:g} s is no spacing of samples for {until:g} s")
        return np.zeros(1)
    count = math.floor(until / every * (1 + 1e-12))
    times = every * np.arange(count + 1)
    if until - times[-1] > 1e-9 * every:
        return np.append(times, until)
    times[-1] = until
    return times


def _ready(system: System, x: Array) -> None:
    """Raise SimulateError where the accelerations at the start do not exist."""
    with np.errstate(all="ignore"):
        rates = system.rates(0.0, x)
    why = "" if system.closed else singular(system.scene, x[: system.nq])
    if not why and not np.all(np.isfinite(rates)):
        why = "the accelerations have no finite value at the start; give another start"
    if why:
        raise SimulateError(f"{system.scene.name}: {why}")


def _method(choice: Choice, rtol: float, atol: float) -> str:
    """Return what is said about the method."""
    tolerance = f"tolerance {rtol:g}" if rtol == atol else f"tolerances {rtol:g} relative, {atol:g} absolute"
    reason = f" ({choice.reason})" if choice.reason else ""
    return f"method: {choice.name} ({choice.method.library}), {tolerance}{reason}"


def _event(system: System, formulas: Sequence[str], flags: Sequence[bool], hit: Hit) -> Event:
    q, u = hit.x[: system.nq], hit.x[system.nq : system.nq + system.nv]
    return Event(formulas[hit.event], hit.t, q, u, flags[hit.event])


def _tell(say: Callable[[str], None] | None, line: str) -> None:
    if say is not None:
        say(line)
