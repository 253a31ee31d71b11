"""Forces prescribed, motion computed: the door `simulate`."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symdyn.errors import SimulateError
from symdyn.scene import Quantity, Scene
from symdyn.scene.names import suggestion
from symdyn.scene.table import Faults
from symdyn.simulate.choose import Choice, choose
from symdyn.simulate.constraints import Projection
from symdyn.simulate.forces import Forces, held, read_forces
from symdyn.simulate.initial import Start, read_start, singular
from symdyn.simulate.integrate import METHODS, Hit, IntegrationError, Piece, Problem
from symdyn.simulate.model import END, INTERRUPTED, Event, Trajectory
from symdyn.simulate.monitors import observe
from symdyn.simulate.reactions import reaction_columns
from symdyn.simulate.reading import TIME, close, parameter_values, read_formula
from symdyn.simulate.samples import sample_times
from symdyn.simulate.system import System, build_system

Array = npt.NDArray[np.float64]

DRIFT = 1e-2
"""Constraints may be missed by this part of the tolerance before a state is projected, and by rounding at least."""

ROUNDING = 1e-14

FINEST, SMALLEST = 1e-16, 1e-300
"""The finest relative tolerance that means anything in doubles, and the smallest absolute one."""


def simulate(
    scene: Scene,
    forces: Forces | str | Sequence[str] | Mapping[str, str] = Forces(),  # noqa: B008  frozen
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
        forces: driving forces, from `read_forces`, or what that takes.
        until: time of the end, s.
        start: formulas by coordinate, in place of what the scene says; or a whole state.
        start_rates: formulas by velocity.
        method: a key of `METHODS`; None chooses.
        rtol: relative tolerance of a step; None takes the method's.
        atol: absolute tolerance of a step; None takes rtol.
        stops: formulas in t, coordinates, velocities and parameters; where one crosses zero the run ends.
        reports: likewise; where one crosses zero the event is kept.
        every: seconds between samples; None for 200 samples.
        reactions: add the columns of all joint reactions.
        progress: called with the share that is done.
        say: called with lines for the user: the method and why.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    forces = forces if isinstance(forces, Forces) else read_forces(scene, forces)
    formulas = (*stops, *reports)
    zeros, times, initial = _checked(scene, until, every, rtol, atol, formulas, method, start, start_rates)
    notes = (*initial.notes, *held(scene, forces, until))
    for note in notes:
        _tell(say, note)
    system = build_system(scene, forces, zeros)
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
    stopped = formulas[run.hits[-1].event] if run.stopped == STOPPED else run.stopped
    events = tuple(_event(system, formulas, flags, hit) for hit in run.hits)
    q, u = run.x[:, : system.nq], run.x[:, system.nq : system.nq + system.nv]
    with np.errstate(all="ignore"):  # a motion that leaves what is real has its last row there
        columns, monitors = observe(system, run.t, run.x)
        qdd = system.tell("rates", run.t, run.x)[:, system.nq : system.nq + system.nv]
        tau = np.broadcast_to(system.tell("drives", run.t, run.x), u.shape)
        if reactions:
            columns |= reaction_columns(scene, run.t, q, u, qdd)
    return Trajectory(
        scene, run.t, q, u, qdd, tau, columns, monitors, events, stopped, choice.name, relative, absolute, run.steps,
        run.evaluations, run.preparing, run.wall, notes,
    )  # fmt: skip


STOPPED = "stopped by an event"


@dataclass(frozen=True)
class _Run:
    """What an integrator has found until it ended, and why it ended; see `Trajectory`."""

    t: Array
    x: Array
    hits: tuple[Hit, ...]
    stopped: str
    steps: int
    evaluations: int
    preparing: float
    wall: float


def _integrated(problem: Problem, choice: Choice, progress: Callable[[float], None] | None) -> _Run:
    """Return what the integrator finds until its end, an event, an interrupt or a failure."""
    pieces: list[Piece] = []
    stopped = END
    begin = ready = time.perf_counter()
    try:
        with np.errstate(all="ignore"):  # what tells that a motion ends there is said in words
            for piece in choice.method.run(problem):
                if not pieces:
                    ready = time.perf_counter()
                pieces.append(piece)
                if progress is not None:
                    progress(piece.now[0] / problem.until)
    except KeyboardInterrupt:
        stopped = INTERRUPTED
    except IntegrationError as fault:
        stopped = str(fault)
    wall = time.perf_counter() - ready
    now = pieces[-1].now if pieces else (0.0, problem.x)
    t = np.concatenate([np.empty(0), *(piece.t for piece in pieces)])
    x = np.concatenate([np.empty((0, len(problem.x))), *(piece.x for piece in pieces)])
    if not len(t) or now[0] > t[-1]:  # where it stands when it ends between two samples
        t, x = np.append(t, now[0]), np.vstack([x, now[1]])
    hits = tuple(hit for piece in pieces for hit in piece.hits)
    if pieces and pieces[-1].stopped:
        stopped = STOPPED
    steps, evaluations = (sum(getattr(piece, name) for piece in pieces) for name in ("steps", "evaluations"))
    return _Run(t, x, hits, stopped, steps, evaluations, ready - begin, wall)


def _checked(
    scene: Scene,
    until: float,
    every: float | None,
    rtol: float | None,
    atol: float | None,
    formulas: Sequence[str],
    method: str | None,
    start: Mapping[str, str] | Start | None,
    start_rates: Mapping[str, str] | None,
) -> tuple[tuple[Quantity, ...], Array, Start]:
    """Return formulas of events, times of samples and the start; all faults together."""
    faults: list[str] = []
    initial = None
    try:
        initial = start if isinstance(start, Start) else read_start(scene, start, start_rates)
    except SimulateError as error:
        faults += error.faults
    try:
        events, times = check_run(scene, until, every, rtol, atol, formulas, method)
    except SimulateError as error:
        faults += error.faults
    if faults:
        raise SimulateError(tuple(dict.fromkeys(faults)))
    assert initial is not None, "without faults there is a start"
    return events, times, initial


def check_run(
    scene: Scene,
    until: float,
    every: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    formulas: Sequence[str] = (),
    method: str | None = None,
) -> tuple[tuple[Quantity, ...], Array]:
    """Return the formulas of events and the times of samples of a run; arguments as for `simulate`.

    Raises:
        SimulateError: with every fault, one line each.
    """
    values = parameter_values(scene)
    faults = Faults("")
    allowed = (TIME, *scene.coordinates, *scene.velocities, *values)
    events = [read_formula(text, allowed, "event", faults) for text in formulas]
    for text, event in zip(formulas, events, strict=True):
        if event is not None and not event.symbols:
            faults.add("event", f'"{text}" is a constant, which crosses nothing')
    for name, value, least in (("rtol", rtol, FINEST), ("atol", atol, SMALLEST)):
        if value is not None and not least <= value < 1:
            faults.add("", f"{name} = {value:g} is not a tolerance; give one between {least:g} and 1, such as 1e-9")
    if method is not None and method.lower() not in METHODS:
        faults.add("", f"method {method} is not known; {suggestion(method, METHODS)}")
    times = sample_times(until, every, faults)
    close(faults)
    return tuple(event for event in events if event is not None), times


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
