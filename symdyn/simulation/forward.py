"""Forces prescribed, motion computed: the function `simulate`.

Of integrators Taylor's is taken where it applies, implicit methods where the system is stiff, else DOP853. A system is
stiff where a motion dies out so fast, -Re λ, that an explicit method would have to follow it although nothing
oscillates or grows nearly as fast; λ are the eigenvalues of ∂f/∂x at the start. What dies out as fast as something else
grows is a saddle, as at a pendulum's top, which friction has no part in.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Unpack

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, with_fields
from symdyn.dynamics.outputs import lacks_modes, with_modes
from symdyn.errors import MethodError, SimulateError
from symdyn.extras import install
from symdyn.frozen import dataclass, replace
from symdyn.scene import Quantity, Scene, SceneLike
from symdyn.scene.values import LETTERS, Faults
from symdyn.simulation.columns import apart, axes_of
from symdyn.simulation.equations.contact_modes import check_names
from symdyn.simulation.equations.control_loop import Loop, held_columns, hidden, sampled_rows
from symdyn.simulation.equations.controller import Placed, placed, placed_function, read_feedback
from symdyn.simulation.equations.implicit import differences
from symdyn.simulation.equations.linear_feedback import Gains, Schedule
from symdyn.simulation.equations.saturation import saturation_report
from symdyn.simulation.equations.settling import begun
from symdyn.simulation.equations.system import Projection, StateEquations
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.initial import Start, beyond_doubles, singular
from symdyn.simulation.integrate import METHODS, InitialValueProblem, named
from symdyn.simulation.integrate.heyoka_expressions import overlooks, refuses, size
from symdyn.simulation.integrate.integration import DOUBLES, END, INTERRUPTED, STOPPED, Integration, Method, integrated
from symdyn.simulation.integrate.valueless import valueless
from symdyn.simulation.prescribed.forces import Forces, held
from symdyn.simulation.prescribed.formulas_in_time import bound, parameter_values
from symdyn.simulation.problem import Problem, Run
from symdyn.simulation.trajectory import Trajectory
from symdyn.simulation.trajectory_builder import (
    DenseOutput,
    at_start,
    nothing_ignored,
    on_the_way,
    overlooked,
    stopping,
    trajectory_of,
)

STIFF_STEPS, STIFF_RATIO = 3000.0, 50.0
"""Beyond both a system is stiff: steps that stability asks of an explicit method, decay over oscillation or growth."""

OTHERWISE = "dop853"
"""What steps over a change point of loops, where series end."""

LARGEST = 3000
"""Operations that heyoka compiles within a few seconds."""


@dataclass(frozen=True)
class Choice:
    """An integrator and why it was taken."""

    name: str  # its key in `METHODS`
    method: Method  # the integrator
    reason: str  # in words, "" for none
    otherwise: str | None = None  # the one to take where it cannot go on, if nobody asked for it; None for none


def choose(
    system: StateEquations,
    x: Array,
    until: float,
    requested: str | None = None,
    rtol: float | None = None,
    limited: bool = False,
) -> Choice:
    """Return the integrator for a system that starts at x: the one of `METHODS` that was asked for, or that fits.

    A relative tolerance below what doubles have takes the one that computes in more; `limited` says whether limits of
    joints end the run.

    Raises:
        SimulateError: there is no such method, it does not apply, or its library is missing.
    """
    if requested is not None:
        return _asked(system, requested.lower(), limited, rtol, "take dop853")
    if rtol is not None and rtol < DOUBLES:
        return replace(_asked(system, _finer(), limited, rtol), reason="doubles have no such tolerance")
    if is_stiff(system, x, until):
        anew = "samples" if system.loop is not None and system.loop.period is not None else ""
        anew = anew or ("events of contacts" if system.contacts is not None else "")
        name = "cvode" if METHODS["cvode"].installed and not anew else "radau"
        why = f", and multistep methods would begin anew at {anew}" if anew else ""
        return Choice(name, METHODS[name], f"the system is stiff{why}")
    why = refuses(system)
    if not why and overlooks(system):
        why = f"a series may overlook a turn of {overlooks(system)}"
    if not why and size(system) > LARGEST:
        why = f"{size(system)} operations would take heyoka long to compile"
    if not why and not METHODS["taylor"].installed:
        why = f"heyoka is not installed; {install('simulate')}"
    if not why:
        return Choice("taylor", METHODS["taylor"], "", OTHERWISE if system.closed else None)
    return Choice("dop853", METHODS["dop853"], f"no Taylor method: {why}")


def _finer() -> str:
    return min(METHODS, key=lambda name: METHODS[name].finest)


def _asked(system: StateEquations, name: str, limited: bool, rtol: float | None, other: str = "") -> Choice:
    """Return a method by its name; `other` is what else to do where it does not apply."""
    method = named(name)
    if not method.installed:
        raise MethodError(f"method {name} needs {method.library}; {install(method.extra)}")
    why = method.refuses(system)
    if not why and system.contacts is not None and method.multistep:
        why, other = "it would begin anew at every event of a contact, with small steps", "take radau"
    if not method.finds_events and not why and limited:
        lets = argument("ignore_limits", True)
        why = f"joints have limits, which end runs, and it looks for no events ({lets} lets it)"
    coarser = f"give {argument('rtol', DOUBLES)} or more" if rtol is not None and rtol < DOUBLES else ""
    if why:
        raise MethodError(f"method {name} does not apply: {why}; {' and '.join(filter(None, (other, coarser)))}")
    if coarser and not method.beyond_doubles:
        raise MethodError(f"method {name} computes in doubles: {coarser}, or no method, which takes {_finer()}")
    return Choice(name, method, "")


def is_stiff(system: StateEquations, x: Array, until: float) -> bool:
    """Tell whether a system is stiff at the start; a jump there, which looks infinitely steep, is no stiffness."""
    return dies_out_fast(lambda step: differences(system, 0.0, x, step), until)


def dies_out_fast(jacobian: Callable[[float], Array], until: float) -> bool:
    """Tell whether a system is stiff, from its ∂f/∂x by differences of a relative size."""
    decays = []
    for step in (1e-5, 1e-6):
        eigenvalues = np.linalg.eigvals(jacobian(step))
        decay = float(np.max(-eigenvalues.real, initial=0.0))
        lively = float(np.max(np.maximum(np.abs(eigenvalues.imag), eigenvalues.real), initial=0.0))
        if not (decay * until > STIFF_STEPS and decay > STIFF_RATIO * lively):
            return False
        decays.append(decay)
    return decays[1] < 2 * decays[0]


DRIFT = 1e-2
"""Constraints may be missed by this part of the tolerance before a state is projected, and by rounding at least."""

ROUNDING = 1e-14


@with_fields(Problem, Run)
def simulate(
    scene: SceneLike | Problem,
    *,
    reports: str | Sequence[str] = (),
    reactions: bool | str = False,
    feedback: object = None,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
    **fields: Unpack[Run.OfProblem],
) -> Trajectory:
    """Return the motion that forces give a scene from t = 0 on.

    Equations are compiled once for all values of named parameters. Other values need no compiling, unless a numerical
    decision changes, such as which constraints are independent; that is reported.

    A run that cannot go on, or is interrupted (Ctrl-C), returns what was computed so far. `Trajectory.stopped` has the
    reason; without `say`, a RuntimeWarning reports that a run could not go on, or that it takes more than a minute.

    >>> import symdyn
    >>> run = symdyn.simulate(symdyn.example("cart_pole"), forces="F=0.5*cos(t)", until=2)
    >>> run.t.shape, run.q.shape, run.stopped
    ((201,), (201, 2), 'end')
    >>> bool(abs(run["x"][-1]) < 1)
    True

    Args:
        scene: the mechanism, its parameters bound; or a `Problem`.
        **fields: forces, start and values as of `Problem`; until, method, tolerances, stops as of `Run`: problem.py.
        reports: formulas of non-terminal events, as `stops` are of terminal ones; where one crosses zero it is kept.
        reactions: add the columns of all joint reactions and multipliers, in axes "body" (of the child, as usual),
            "joint" (of the joint frame on the parent) or "ground". True is "body".
        feedback: a controller, whose forces are added: a function of time, coordinates and velocities that returns the
            force of every input; a matrix K, τ = -K x, of coordinates and then velocities; gains, or a .json file of
            them; a regulator, or what else has a method `feedback`; a linear system of python-control or SciPy, between
            reference less measured signals and forces; or a `Feedback` of any of these, with period, delay, limits and
            noise. What it computed are columns. Of one that takes samples all are rows, unless `every` is given.
        progress: called with the share that is done.
        say: called with lines for the user: the method and why.

    Raises:
        SimulateError: with every fault of the arguments, one line each.
        SceneError: a value that the scene cannot have, or of no parameter.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    problem, run = Problem.requested(simulate, locals())
    tell = say or _note
    reports = (reports,) if isinstance(reports, str) else tuple(reports)
    scene, formulas, faults = problem.scene, (*map(str, run.stops), *reports), Faults("")
    given, initial, zeros, times = problem.posed(run, faults, reports)
    axes_of(reactions, faults, scene)
    outside = Control()
    with faults.noted():
        outside = control(scene, feedback, given, run.until)
        given = replace(given, fed=outside.places)
    faults.lines[:] = dict.fromkeys(faults.lines)
    faults.close(SimulateError)
    times = outside.samples(run.until, run.every, times)
    system, x = ready(problem, given, zeros, initial, run.until, outside)
    check_start(system, x)
    flags = tuple(k < len(run.stops) for k in range(len(formulas)))
    limits = stopping(system, run.ignore_limits)
    kinds = enumerate(system.kinds)
    looked_for = tuple(flags[k] if k < len(flags) else limits.get(k, bool(kind.end)) for k, kind in kinds)
    notes = (*initial.notes, *held(scene, given, run.until), *system.notes, *at_start(system, x, limits))
    notes += (*nothing_ignored(system, run.ignore_limits), *outside.notes(times, initial.q))
    notes += tuple(outside.twice(scene, given))
    for note in notes:
        tell(note)

    choice = choose(system, x, run.until, run.method, run.rtol, any(limits.values()))
    _refuse_reactions(scene, choice, bool(reactions))

    def attempt(choice: Choice) -> tuple[Integration, InitialValueProblem, list[str]]:
        relative, absolute, others = choice.method.tolerances(choice.name, run.rtol, run.atol)
        for line in (_method(choice, relative, absolute), *others):
            tell(line)
        projection = Projection(system, max(ROUNDING, DRIFT * relative))
        asked = InitialValueProblem(
            system,
            x,
            times,
            relative,
            absolute,
            looked_for,
            projection,
            beyond_doubles(scene, initial, len(x)) if choice.method.beyond_doubles else None,
        )
        return integrated(asked, choice.method, progress, say or _warn), asked, others

    begun_with = () if system.contacts is None else tuple(system.contacts.told)
    made, asked, others = attempt(choice)
    if choice.otherwise is not None and made.stopped not in (END, STOPPED, INTERRUPTED):
        choice = Choice(choice.otherwise, METHODS[choice.otherwise], f"{choice.name}: {made.stopped}")
        if system.contacts is not None:
            system.contacts.told[:] = begun_with
        made, asked, others = attempt(choice)

    def reported(made: Integration) -> Trajectory:
        rows = trajectory_of(system, made, formulas, flags, reactions)
        return outside.reported(rows, made.x, given, system.loop)

    found = reported(made)
    between = METHODS[OTHERWISE] if choice.method.beyond_doubles else choice.method
    seen = (*found.notes, *on_the_way(system, made.t, made.x, made.hits, limits))
    seen += (*overlooked(asked.unsure, formulas),)
    for note in seen:
        tell(note)
    low = None if made.low is None else made.low[:, : system.nq + system.nv]
    found = replace(
        found, low=low, method=choice.name, rtol=asked.rtol, atol=asked.atol, steps=made.steps,
        evaluations=made.evaluations, preparing=made.preparing, wall=made.wall, notes=(*notes, *others, *seen),
        dense=DenseOutput(made, asked, between, lambda more: replace(reported(more), impacts=found.impacts)),
    )  # fmt: skip
    if say is None and not found.complete and found.stopped != INTERRUPTED:
        warnings.warn(
            f"{scene.name}: {found.stopped}; rows until t = {found.t[-1]:g} s are kept", RuntimeWarning, stacklevel=3
        )
    return found


def _refuse_reactions(scene: Scene, choice: Choice, asked: bool) -> None:
    """Raise SimulateError where reactions are asked for of a method whose accelerations do not know impacts."""
    named = [name for one in scene.outputs for name in one.formula.symbols if name.startswith(LETTERS.reaction)]
    if choice.method.step is not None and (asked or named):
        told = f"{choice.name} has impacts within its steps, and its accelerations do not"
        raise SimulateError(f"{scene.name}: reactions: {told}; take taylor or dop853, or leave reactions out")


def ready(
    problem: Problem, given: Forces, events: Sequence[Quantity], initial: Start, until: float, outside: Control
) -> tuple[StateEquations, Array]:
    """Return the equations with all that acts from outside, and the state at the start, shape (nx,)."""
    scene = problem.scene
    whole = with_modes(scene) if lacks_modes(scene) else scene
    check_names(whole)
    initial = replace(initial, s=np.append(initial.s, np.zeros(len(whole.states) - len(scene.states))))
    system = state_equations(whole, given, events, problem.whole)
    system = replace(system, loop=outside.begun(whole, initial, until, system.hidden))
    own = np.zeros(0) if system.loop is None else system.loop.z[: system.nz]
    x = np.concatenate([initial.q, initial.u, initial.s, own, np.zeros(int(system.works))])
    if system.contacts is None:
        return system, x
    system = replace(system, contacts=replace(system.contacts, told=[], pushed={}, declared=scene))
    return system, begun(system, x)


def _note(line: str) -> None:
    """Warn, where nobody listens, of degrees that are taken for radians."""
    if line.endswith("for degrees"):
        warnings.warn(line, RuntimeWarning, stacklevel=4)


def _warn(line: str) -> None:
    """Warn, where nobody listens, of a run that takes long."""
    warnings.warn(line, RuntimeWarning, stacklevel=7)  # at the call of simulate


def check_start(system: StateEquations, x: Array) -> None:
    """Raise SimulateError where the accelerations at the start do not exist."""
    with np.errstate(all="ignore"):
        rates = system.rates(0.0, x)
    why = "" if system.closed or not system.nv else singular(system, x)
    if not np.all(np.isfinite(rates)):
        part = valueless(system.scene, system.forces, 0.0, *system.parts(x)[:2])
        why = f"start: {part}; give another start" if part else why
        why = why or "the accelerations have no finite value at the start; give another start"
    if why:
        raise SimulateError(f"{system.scene.name}: {why}")


def _method(choice: Choice, rtol: float, atol: float) -> str:
    tolerance = f"tolerance {rtol:g}" if rtol == atol else f"tolerances {rtol:g} relative, {atol:g} absolute"
    if choice.method.step is not None:
        tolerance = f"steps of {choice.method.step:g} s at most, {choice.method.text}"
    reason = f" ({choice.reason})" if choice.reason else ""
    return f"method: {choice.name} ({choice.method.library}), {tolerance}{reason}"


@dataclass(frozen=True)
class Control:
    """What acts on a run from outside of its equations: a controller, and functions that forces are given by.

    It says at which times the run has samples, and what is told of the controller in the end.
    """

    controller: Placed | None = None  # None where there is none
    functions: tuple[Placed, ...] = ()  # forces that are functions

    @property
    def laws(self) -> tuple[Placed, ...]:
        """All of them, the controller first."""
        return (*(() if self.controller is None else (self.controller,)), *self.functions)

    @property
    def places(self) -> tuple[int, ...]:
        """The indices of the forces and inputs on which they act."""
        return tuple(dict.fromkeys(k for law in self.laws for k in law.places))

    @property
    def sampled(self) -> Placed | None:
        """The controller if it takes samples."""
        return self.controller if self.controller is not None and self.controller.feedback.period is not None else None

    def samples(self, until: float, every: float | None, usual: Array) -> Array:
        """Return the times of a run's samples: the usual ones, or the controller's where nobody asks for others."""
        return usual if self.sampled is None or every is not None else sampled_rows(self.sampled, until)

    def notes(self, times: Array, q: Array) -> list[str]:
        """Return what is said of what has no effect, of a start far from gains, and of samples between those times."""
        if self.controller is None:
            return []
        feedback, found = self.controller.feedback, []
        if len(feedback.initial) and not (self.sampled and feedback.delay):
            found.append("feedback: initial has no effect: without a period and a delay the first force acts at once")
        if (period := feedback.period or 0.0) >= times[-1]:
            write = f'of ms write "{period:g} ms"'
            found.append(f"feedback: one sample is taken, as a period of {period:g} s is the whole run; {write}")
        if isinstance(feedback.law, Schedule) and feedback.law.end < times[-1]:
            found.append(
                f"feedback: the motion that is followed ends at t = {feedback.law.end:g} s, not at rest where forces "
                "hold it: its last forces, place and velocities stay from then on"
            )
        if isinstance(feedback.law, Gains) and "reference" not in feedback.given:
            found += feedback.law.far(q)
        return found if self.sampled is None else found + hidden(self.sampled, times)

    def twice(self, scene: Scene, forces: Forces) -> list[str]:
        """Return what is said of forces that are, where gains aim, what these add themselves."""
        law, values = self.controller, parameter_values(scene)
        if law is None or not isinstance(gains := law.feedback.law, Gains):
            return []
        names = (*scene.coordinates, *scene.velocities, *(one.name for one in scene.states))
        aim = dict(zip(names, [*gains.q0, *gains.u0], strict=True))
        return [
            f"{name}: forces give {u0:.6g} {unit} at x0, and the gains add u0 = {u0:.6g} {unit}, together {2 * u0:.6g} "
            f"{unit}; leave it out of forces, unless it acts twice"
            for name, k, u0, unit in zip(law.names, law.places, law.initial, law.units, strict=True)
            if u0 and np.isclose(float(bound(forces.formula(k), values).known_at(aim) or 0), u0, rtol=1e-6)
        ]

    def begun(self, scene: Scene, initial: Start, until: float, hidden: int = 0) -> Loop | None:
        """Return them at work at the start of a run, None where there are none; see `Loop` for `hidden`."""
        if not self.laws:
            return None
        first, *beside = self.laws
        n, nu = len(scene.velocities), len(scene.velocities) + len(scene.states)
        found = Loop(first, len(scene.coordinates), nu, until, n + len(scene.inputs), beside, hidden)
        with np.errstate(all="ignore"):  # what has no value is told
            found.start(initial.q, np.append(initial.u, initial.s))
        return found

    def reported(self, trajectory: Trajectory, x: Array, forces: Forces, loop: Loop | None) -> Trajectory:
        """Return a run, of states (N, nx), with what is told of the controller.

        That are columns of what it computed, which columns are under zero-order hold, and saturations.
        """
        if self.controller is None or loop is None:
            return trajectory
        cuts, end = loop.cuts, float(trajectory.t[-1])
        others = tuple(k for one in self.functions for k in one.places)
        n = loop.nq + loop.nu
        with np.errstate(all="ignore"):
            told = loop.columns(trajectory.t, trajectory.q, x[:, loop.nq : n], x[:, n : n + loop.nz])
        extra = apart(trajectory.scene, {**trajectory.extra, **told})
        held: tuple[str, ...] = ()
        if self.sampled is not None:
            held = (*held_columns(trajectory.scene, forces, self.sampled, others), *list(extra)[-len(told) :])
        notes = (*trajectory.notes, *saturation_report(cuts, end))
        return replace(trajectory, extra=extra, held=held, saturations=cuts.until(end), notes=notes)


def control(scene: Scene, feedback: object, forces: Forces, until: float) -> Control:
    """Return what acts from outside, from what `simulate` is given.

    Raises:
        SimulateError: with every fault, one line each.
    """
    controller = None if feedback is None else placed(scene, read_feedback(scene, feedback), until)
    return Control(controller, tuple(placed_function(scene, one, until) for one in forces.functions))
