"""Forces prescribed, motion computed: the function `simulate`."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import check_arguments, doubles
from symdyn.errors import SimulateError
from symdyn.scene import Quantity, Scene, SceneLike, scene_of
from symdyn.scene.values import Faults, suggestion
from symdyn.simulation.control import Control, control
from symdyn.simulation.equations.projection import Projection
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.feedback.controller import Feedback, Law
from symdyn.simulation.feedback.gains import Gains
from symdyn.simulation.initial import Start, Values, beyond_doubles, read_start, singular
from symdyn.simulation.integrate import FINEST, METHODS
from symdyn.simulation.integrate.method import Problem
from symdyn.simulation.integrator import Choice, choose
from symdyn.simulation.joint_limits import at_start, nothing_ignored, on_the_way, stopping
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import Forces, held, read_forces
from symdyn.simulation.prescribed.formulas_in_time import parameter_values, read_seen
from symdyn.simulation.prescribed.numbers_in_time import sample_times
from symdyn.simulation.reaction_columns import axes_of
from symdyn.simulation.run import STOPPED, Run, integrated
from symdyn.simulation.trajectory import END, INTERRUPTED, Trajectory
from symdyn.simulation.trajectory_builder import overlooked, trajectory_of
from symdyn.simulation.valueless import valueless

DRIFT = 1e-2
"""Constraints may be missed by this part of the tolerance before a state is projected, and by rounding at least."""

ROUNDING = 1e-14

SMALLEST = 1e-300
"""The smallest absolute tolerance that means anything."""


def simulate(
    scene: SceneLike,
    forces: Forces | Entries = Forces(),  # noqa: B008  frozen
    until: float = 10.0,
    start: Values | Start | None = None,
    start_rates: Values | None = None,
    method: str | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    stops: str | Sequence[str] = (),
    reports: str | Sequence[str] = (),
    every: float | None = None,
    reactions: bool | str = False,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
    values: Mapping[str, object] | None = None,
    feedback: Feedback | Gains | Law | Mapping[str, object] | str | Path | None = None,
    ignore_limits: bool = False,
) -> Trajectory:
    """Return the motion that forces give a scene from t = 0 on.

    Equations are compiled once for all values of named parameters; for other values of them nothing is compiled, unless
    numbers decide otherwise than before, which is said.

    A run that cannot go on, or is interrupted (Ctrl-C), returns what was computed so far. `Trajectory.stopped` says
    why, and of the first so does a RuntimeWarning unless somebody listens (`say`).

    >>> import symdyn
    >>> run = symdyn.simulate(symdyn.example("cart_pole"), "F=0.5*cos(t)", until=2)
    >>> run.t.shape, run.q.shape, run.stopped
    ((201,), (201, 2), 'end')
    >>> bool(abs(run["x"][-1]) < 1)
    True

    Args:
        scene: the mechanism, its parameters bound.
        forces: driving forces, from `read_forces`, or what that takes.
        until: time of the end, s.
        start: formulas by coordinate, or as "q1=0.3,q2=pi/2", in place of what the scene says; or a whole state.
        start_rates: formulas by velocity.
        method: a key of `METHODS`; None chooses.
        rtol: relative tolerance of a step; None takes the method's. Below 1e-16 the run has 31 digits (`gauss`).
        atol: absolute tolerance of a step; None takes rtol.
        stops: formulas in what outputs may name, and in outputs; where one crosses zero the run ends.
        reports: likewise; where one crosses zero the event is kept.
        every: seconds between rows; None for 200 of them, and of a controller that takes samples for all of these.
        reactions: add the columns of all joint reactions and multipliers, in axes "body", "joint" or "ground"; True is
            "body".
        progress: called with the share that is done.
        say: called with lines for the user: the method and why.
        values: of parameters, in place of those that the scene gives: numbers or formulas by name.
        feedback: a controller, whose forces are added: a function of time, coordinates and velocities that returns the
            force of every input; a `Feedback` of one, with period, delay and limits; gains, or a .json file of them.
        ignore_limits: go on where a joint reaches a limit of its position; else the run stops there, with an event.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
        SceneError: a value that the scene cannot have, or of no parameter.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    check_arguments(simulate, locals(), SimulateError)
    until, every, rtol, atol = doubles(until, every, rtol, atol)
    scene = scene_of(scene)
    one_run({"start": start, "start rates": start_rates, "values": values})
    scene = scene_of(scene, values)
    stops, reports = ((one,) if isinstance(one, str) else tuple(one) for one in (stops, reports))
    formulas, faults, given = (*stops, *reports), Faults(""), Forces()
    with faults.noted():
        given = forces if isinstance(forces, Forces) else read_forces(scene, forces)
    with faults.noted():
        initial = read_start(scene, start, start_rates)
    with faults.noted():
        zeros, times = check_run(scene, until, every, rtol, atol, formulas, method, reactions)
    outside = Control()
    with faults.noted():
        outside = control(scene, feedback, given, until)
        given = replace(given, fed=outside.places)
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    times = outside.rows(until, every, times)
    system = state_equations(scene, given, zeros, initial.q if isinstance(start, Start) else None)
    system = replace(system, loop=outside.begun(scene, initial, until))
    x = np.concatenate([initial.q, initial.u, np.zeros(int(system.works))])
    ready(system, x)
    flags = tuple(k < len(stops) for k in range(len(formulas)))
    limits = stopping(system, ignore_limits)
    looked_for = (*flags, *(True for _ in system.ends), *limits)
    notes = (*initial.notes, *held(scene, given, until), *system.notes, *at_start(system, x, limits))
    notes += (*nothing_ignored(system, ignore_limits), *outside.notes(times))
    for note in notes:
        _tell(say, note)

    choice = choose(system, x, until, method, rtol, any(limits))

    def attempt(choice: Choice) -> tuple[Run, Problem, list[str]]:
        relative, absolute, others = choice.method.tolerances(choice.name, rtol, atol)
        for line in (_method(choice, relative, absolute), *others):
            _tell(say, line)
        projection = Projection(system, max(ROUNDING, DRIFT * relative))
        problem = Problem(
            system,
            x,
            times,
            relative,
            absolute,
            looked_for,
            projection,
            beyond_doubles(scene, initial, len(x)) if choice.method.beyond_doubles else None,
        )
        return integrated(problem, choice.method, progress, say), problem, others

    run, problem, others = attempt(choice)
    if choice.otherwise is not None and run.stopped not in (END, STOPPED, INTERRUPTED):
        choice = Choice(choice.otherwise, METHODS[choice.otherwise], f"{choice.name}: {run.stopped}")
        run, problem, others = attempt(choice)
    found = outside.told(trajectory_of(system, run, formulas, flags, reactions), given, system.loop)
    seen = (*found.notes, *on_the_way(system, run.t, run.x, run.hits, limits))
    seen += (*overlooked(problem.unsure, formulas),)
    for note in seen:
        _tell(say, note)
    found = replace(
        found, low=_beyond(system, run), method=choice.name, rtol=problem.rtol, atol=problem.atol, steps=run.steps,
        evaluations=run.evaluations, preparing=run.preparing, wall=run.wall, notes=(*notes, *others, *seen),
    )  # fmt: skip
    if say is None and not found.complete and found.stopped != INTERRUPTED:
        warnings.warn(f"{scene.name}: {found.stopped}; the rows until then are kept", RuntimeWarning, stacklevel=2)
    return found


def _beyond(system: StateEquations, run: Run) -> Array | None:
    """Return what coordinates and velocities of a run are beyond their doubles, None where they are doubles."""
    return None if run.low is None else run.low[:, : system.nq + system.nv]


def one_run(specified: Mapping[str, object]) -> None:
    """Raise SimulateError where a number of a run is an array: that is many runs."""
    many = [
        f"{what}: {name} has {np.size(one)} numbers, and a run takes one; symdyn.ensemble takes arrays, a run a number"
        for what, given in specified.items()
        for name, one in (given.items() if isinstance(given, Mapping) else ())
        if isinstance(one, Sequence | np.ndarray) and not isinstance(one, str) and np.ndim(one) > 0
    ]
    if many:
        raise SimulateError(many)


def check_run(
    scene: Scene,
    until: float,
    every: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    formulas: Sequence[str] = (),
    method: str | None = None,
    reactions: bool | str = False,
    finest: float = FINEST,
) -> tuple[tuple[Quantity, ...], Array]:
    """Return the formulas of events and the times of samples of a run; arguments as for `simulate`.

    `finest` is the finest relative tolerance that there is a method for.

    Raises:
        SimulateError: with every fault, one line each.
    """
    parameter_values(scene)
    faults = Faults("")
    events = [read_seen(scene, text, "event", faults) for text in formulas]
    for text, event in zip(formulas, events, strict=True):
        if event is not None and not event.symbols:
            faults.add("event", f'"{text}" is a constant, which crosses nothing')
    for name, value, least in (("rtol", rtol, finest), ("atol", atol, SMALLEST)):
        if value is not None and not least <= value < 1:
            faults.add("", f"{name} = {value:g} is not a tolerance; give one between {least:g} and 1, such as 1e-9")
    if method is not None and method.lower() not in METHODS:
        faults.add("", f"method {method} is not known; {suggestion(method, METHODS)}")
    axes_of(reactions, faults, scene)
    times = sample_times(until, every, faults)
    faults.close(SimulateError)
    return tuple(event for event in events if event is not None), times


def ready(system: StateEquations, x: Array) -> None:
    """Raise SimulateError where the accelerations at the start do not exist."""
    with np.errstate(all="ignore"):
        rates = system.rates(0.0, x)
    why = "" if system.closed else singular(system, x[: system.nq])
    if not np.all(np.isfinite(rates)):
        part = valueless(system.scene, system.forces, 0.0, x[: system.nq], x[system.nq : system.nq + system.nv])
        why = f"start: {part}; give another start" if part else why
        why = why or "the accelerations have no finite value at the start; give another start"
    if why:
        raise SimulateError(f"{system.scene.name}: {why}")


def _method(choice: Choice, rtol: float, atol: float) -> str:
    """Return what is said about the method."""
    tolerance = f"tolerance {rtol:g}" if rtol == atol else f"tolerances {rtol:g} relative, {atol:g} absolute"
    reason = f" ({choice.reason})" if choice.reason else ""
    return f"method: {choice.name} ({choice.method.library}), {tolerance}{reason}"


def _tell(say: Callable[[str], None] | None, line: str) -> None:
    if say is not None:
        say(line)
