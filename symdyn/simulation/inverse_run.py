"""Inverse dynamics over time: the function `inverse`, from a prescribed motion to driving forces.

In a closed mechanism laws are needed for as many coordinates as it has freedoms; the others follow (following.py).
Where points and frames have paths, coordinates follow these too (along_path.py). Velocities of a quaternion are found
from q̇ = H u, their rates from q̈ = H u̇ + Ḣ u.

States of one's own are integrated beside the motion, ṡ = f(t, q(t), u(t), s), from their start at t = 0: a run of a
scene in which nothing moves, whose inputs are coordinates and velocities. An input that would make a state pull as the
motion takes it is not looked for: it acts on a rate of that force, and takes derivatives of the motion.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import suggesting
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.errors import SimulateError, quoted
from symdyn.scene import Scene, SceneLike
from symdyn.scene.values import Faults, spell, velocity_name
from symdyn.simulation.along_path import along
from symdyn.simulation.arm_branches import branches_of
from symdyn.simulation.columns import apart, axes_of
from symdyn.simulation.equations.compiled_routines import opened
from symdyn.simulation.equations.monitors import SLACK
from symdyn.simulation.following import Followed, Tied, followed
from symdyn.simulation.force_columns import input_columns, output_columns, reaction_columns
from symdyn.simulation.forward import simulate
from symdyn.simulation.initial import CONSISTENT, Start, Values, no_equations
from symdyn.simulation.integrate.integration import END
from symdyn.simulation.integrate.valueless import valueless
from symdyn.simulation.inverse_functions import InverseFunctions
from symdyn.simulation.prescribed.courses import ForceTable
from symdyn.simulation.prescribed.entries import Entries, has_index
from symdyn.simulation.prescribed.forces import Forces, SceneMotion, drive_names, motion_times, places_of, read_motion
from symdyn.simulation.prescribed.formulas_in_time import bound, parameter_values
from symdyn.simulation.prescribed.motion_laws import Law, constant, formula_law
from symdyn.simulation.prescribed.point_path import ScenePath, read_path
from symdyn.simulation.problem import Problem
from symdyn.simulation.trajectory import Trajectory
from symdyn.simulation.trajectory_builder import passages, passed, passive_forces, tensions_in

FINER = 8
"""Rows for one that is asked for, through which coordinates that follow others move between rows as states need it."""

UNIT = 1e-9
"""How far the length of a prescribed quaternion may be from one."""


@suggesting
def inverse(
    scene: SceneLike | Problem,
    motion: SceneMotion | Entries = (),
    times: npt.ArrayLike = (),
    reactions: bool | str = False,
    say: Callable[[str], None] | None = None,
    values: Mapping[str, object] | None = None,
    path: ScenePath | Entries = (),
    start: Values | None = None,
    forces: Forces | Entries = (),
    until: float | None = None,
    every: float | None = None,
    branch: int | None = None,
) -> Trajectory:
    """Return the driving forces, and on request all joint reactions, of a prescribed motion.

    A motion that a mechanism cannot go on with returns the rows until then. `Trajectory.stopped` has the reason;
    without `say`, a RuntimeWarning reports it.

    >>> import symdyn
    >>> run = symdyn.inverse(symdyn.example("two_link"), ["q1=t**2", "q2=0"], [0.0, 0.5, 1.0],
    ...     values=dict(m1=1, m2=1, h1=1, h2=1, g=9.81))
    >>> run.tau.round(4).tolist()
    [[10.0, 4.0], [17.2811, 6.427], [34.7645, 12.2548]]

    Args:
        scene: the mechanism, its parameters bound; or a `Problem`, without start rates.
        motion: laws of its coordinates, from `read_motion`, which takes parameters as they are then, or what that
            takes; coordinates without one rest at their start, or follow through the loops.
        times: s, shape (N,), ascending. None and no `until`: the rows of the one .csv file, or table, of the motion.
        reactions: add the columns of all joint reactions and multipliers, in axes as `simulate` has them.
        say: takes what a user should know.
        values: of parameters, in place of those that the scene gives: numbers or formulas by name.
        path: where points and frames are to be, from `read_path`, or what that takes; coordinates without a law follow.
        start: coordinates, such as "q1=0.3,q2=pi/2", in place of the scene's: where those without a law rest, and of
            several solutions, next to which one is taken at the first time; and states. Formulas by name.
        forces: of inputs what is given, as "u=12*sin(t)", or a .toml or .csv file; nothing takes the motion's table.
        until: time of the end, s, in place of times.
        every: seconds between samples then; None for 200 of them.
        branch: number of the posture, of those in closed form, that the path of a pose begins with; 1 is next to start.

    Raises:
        SimulateError: with every fault, one line each; and where there is not even a first row.
        SceneError: a value that the scene cannot have, or of no parameter.
        DerivationError: the drives do not fit the loops.
    """
    problem, asked = Problem.requested(inverse, locals())
    scene = problem.refused("it belongs to a run, and a motion is given", "start_rates").scene
    scene.refuse_contacts("inverse dynamics over time", SimulateError)
    motion, path, forces, t = _read(problem, motion, path, times, until if until is None else asked.until, asked.every)
    axes = _check(scene, motion, path, t, reactions)
    told = {places_of(scene)[name]: table for name, table in motion.inputs.items()}
    forces = replace(forces, tables={k: told[k] for k in told if k not in forces.formulas} | {**forces.tables})
    functions = InverseFunctions(scene, path)
    finer = FINER if scene.states and functions.follows else 1
    if finer > 1:
        t = np.interp(np.arange(finer * (len(t) - 1) + 1) / finer, np.arange(len(t)), t)
    guess = Start.guess(scene, problem.start)
    laws = _laws(scene, motion, guess, forces)
    lawful = [name for name in laws if name in motion.laws or name in _own(scene, forces)]
    if branch is not None:
        held = {name: float(laws[name](t[:1])[0][0]) for name in lawful}
        guess = branches_of(scene, path, held, guess, float(t[0])).chosen(branch)
    named = () if isinstance(problem.start, Start) else problem.by_name[0]
    found = _moved(scene, functions, motion, laws, lawful, t, path, guess)
    q, u, a, stopped = found.q, found.u, found.a, found.stopped
    notes = [*found.notes, *_left_out(scene, motion, named, lawful, guess, t, q[0])]
    columns = {"path_error" if path.points else "loop_error": found.off} if functions.holds else {}
    over_time, words = _over_time(problem, functions, laws, forces, t[: len(q)], q, u, a)
    n, stopped = len(next(iter(over_time.values()), q)), words or stopped
    t, q, u, a = t[:n:finer], q[:n:finer], u[:n:finer], a[:n:finer]
    n, stopped = _ended(t, functions.off_wheels(t, q, u), lambda _, k: functions.lifts[k], stopped)
    t, q, u, a = t[:n], q[:n], u[:n], a[:n]
    columns = {name: column[::finer][:n] for name, column in (over_time | columns).items()}
    letters = (scene.inputs, scene.states)
    given, states = (np.array([columns[one.name] for one in some]).reshape(-1, len(q)).T for some in letters)
    tau = functions("inverse_dynamics", t, q, u, a, inputs=given, states=states)
    state = np.hstack([u, states])
    n, stopped = _ended(
        t,
        ~np.isfinite(tau),
        lambda n, k: (
            valueless(scene, Forces(), float(t[n]), q[n], state[n])
            or f"no finite {drive_names(scene)[k]} gives {scene.name} this motion there, as at a dead centre; "
            "let another joint drive, or the motion keep away from it"
        ),
        stopped,
    )
    t, q, u, a, tau = t[:n], q[:n], u[:n], a[:n], tau[:n]
    columns = {name: column[:n] for name, column in columns.items()}
    columns["drive_power"] = np.einsum("ni,ni->n", tau, u)
    if scene.points:
        columns |= dict(zip(scene.point_names, functions("points", t, q, u).T, strict=True))
    if axes:
        columns |= reaction_columns(Trajectory(scene, t, q, u, a, tau, columns), given=False, axes=axes)
    columns |= output_columns(Trajectory(scene, t, q, u, a, tau, columns), given=False)
    run = Trajectory(scene, t, q, u, a, tau, apart(scene, columns), stopped=stopped)
    least, slack = tensions_in(run)
    notes += (*passive_forces(scene, tau), *_passed(scene, functions, t, q, u, tau), *slack)
    if say is not None:
        for note in notes:
            say(note)
    elif stopped != END:
        warnings.warn(f"{scene.name}: {stopped}; the rows until then are kept", RuntimeWarning, stacklevel=3)
    return replace(run, monitors=least, notes=tuple(notes))


def _read(
    problem: Problem,
    motion: SceneMotion | Entries,
    path: ScenePath | Entries,
    times: npt.ArrayLike,
    until: float | None,
    every: float | None,
) -> tuple[SceneMotion, ScenePath, Forces, Array]:
    """Return laws, paths, what is given of inputs, and times; SimulateError with every fault of all."""
    scene, faults, texts = problem.scene, Faults(""), [*_texts(motion), *_texts(path)]
    table: Any = motion
    if isinstance(times, tuple) and not times and until is every is None and hasattr(table, "keys"):
        if has_index(table):  # its own rows, as those of a file
            times = table.index
        elif TIME in table:
            times = table[TIME]
    read = (
        faults.taken(lambda: motion if isinstance(motion, SceneMotion) else read_motion(scene, motion), SceneMotion()),
        faults.taken(lambda: path if isinstance(path, ScenePath) else read_path(scene, path), ScenePath()),
        faults.taken(lambda: problem.inputs, Forces()),
        faults.taken(lambda: _times(times, texts, until, every), np.zeros(1)),
    )
    faults.close(SimulateError)
    return read


def _times(times: npt.ArrayLike, given: Sequence[str], until: float | None, every: float | None) -> Array:
    """Return times, shape (N,), of motions given as text too; SimulateError where they are none."""
    if isinstance(times, tuple) and not times:
        return motion_times(given, until, every)
    if until is not None or every is not None:
        raise SimulateError("times: until and every say them too; leave out either")
    if isinstance(times, Real):
        span = f"for 0 to {quoted(times)} s every 0.01 s: until={quoted(times)}, every=0.01"
        raise SimulateError(f"times = {quoted(times)}: times are a row of numbers; {span}")
    try:
        found = np.atleast_1d(np.asarray(times, dtype=np.float64))
    except (TypeError, ValueError, OverflowError):
        found = np.empty((0, 0))
    if found.ndim != 1:
        raise SimulateError(f"times: {quoted(times)} are no times; give numbers in s that rise, such as a linspace")
    return found


def _texts(entries: object) -> list[str]:
    """Return those of a motion's or a path's entries that are text or files."""
    every = entries if isinstance(entries, list | tuple) else [entries]
    return [str(one) for one in every if isinstance(one, str | Path)]


def _moved(
    scene: Scene,
    functions: InverseFunctions,
    motion: SceneMotion,
    laws: Mapping[str, Law],
    given: list[str],
    t: Array,
    path: ScenePath,
    guess: Array,
) -> Followed:
    """Return the motion that laws give, and what follows from them; SimulateError where there is not even a start."""
    q, rate, second = (np.stack(parts, axis=-1) for parts in zip(*(law(t) for law in laws.values()), strict=True))
    finite = np.isfinite(q) & np.isfinite(rate) & np.isfinite(second)
    if not finite.all():
        row, column = (int(one) for one in np.argwhere(~finite)[0])
        name = scene.coordinates[column]
        raise SimulateError(f"motion: {name}: {laws[name].text} has no finite value or derivative at t = {t[row]:g} s")
    free = [name for name in scene.coordinates if name not in given]
    if functions.follows:
        return _followed(scene, functions, motion, laws, given, t, path, guess)
    no_equations(opened(scene).numbers(), q[0])
    notes = (f"no law is given for {', '.join(free)}: at rest",) if free else ()
    return Followed(q, *_velocities(scene, functions, motion, t, q, rate, second), np.zeros(0), notes, END)


def _followed(
    scene: Scene,
    functions: InverseFunctions,
    motion: SceneMotion,
    laws: Mapping[str, Law],
    given: list[str],
    t: Array,
    path: ScenePath,
    guess: Array,
) -> Followed:
    """Return what follows from paths and the laws of `given` coordinates through loops and rows."""

    def known(at: Array) -> tuple[Array, Array, Array]:
        parts = list(zip(*(laws[name](at) for name in given), strict=True)) or [()] * 3
        q, rate, second = (np.array(part).reshape(len(given), len(at)).T for part in parts)
        return q, rate, second

    for lengths in _lengths(scene, known(t)[0], given):
        _unit(lengths)
    numbers = opened(scene).numbers()
    tied = Tied(numbers, lambda name, q, u: functions(name, 0.0, q, u), functions.holding)
    quasi = {scene.velocities.index(name): law for name, law in motion.quasi.items()}
    if path.points:
        found = along(tied, given, known, quasi, path, functions.rates, t, guess)
    else:
        found = followed(tied, given, known, quasi, t, guess)
    return replace(found, notes=tuple(dict.fromkeys((*found.notes, *numbers.doubts(found.q[0])))))


def _over_time(
    problem: Problem,
    functions: InverseFunctions,
    laws: Mapping[str, Law],
    forces: Forces,
    t: Array,
    q: Array,
    u: Array,
    a: Array,
) -> tuple[dict[str, Array], str]:
    """Return inputs and states along a motion, each of shape (N,), as far as they go, and why they end before, or "".

    Beside states, coordinates move by laws where they do so everywhere, else by cubics between rows.
    """
    scene, n = problem.scene, len(problem.scene.velocities)
    if not scene.states:
        return input_columns(scene, forces, t, q, u), ""
    from scipy.interpolate import CubicHermiteSpline  # late: it takes long to load

    moved = (*scene.coordinates, *scene.velocities)
    if not functions.follows and moved[n:] == tuple(map(velocity_name, moved[:n])):
        courses: list[Callable[[Array, int], Array]] = [
            partial(_of_law, law, order) for order in (0, 1) for law in laws.values()
        ]
    else:
        rate = np.einsum("nij,nj->ni", functions("kinematics", t, q, u), u)
        parts = zip(np.hstack([q, u]).T, np.hstack([rate, a]).T, strict=True)
        courses = [CubicHermiteSpline(t, *part) for part in parts]
    tables = {k - n: table for k, table in forces.tables.items()}
    tables |= {len(scene.inputs) + k: ForceTable(t, t, spline=one) for k, one in enumerate(courses)}

    def seen(of: Callable[..., Any], at: float, *_: Array) -> Any:
        state = np.array([course(np.array(at), 0) for course in courses])
        return of(at, state[: q.shape[1]], state[q.shape[1] :])

    told = Forces(
        {k - n: formula for k, formula in forces.formulas.items()},
        tables,
        tuple(k - n for k in forces.fed),
        tuple(replace(one, of=partial(seen, one.of)) for one in forces.functions),
    )
    own, start = [one.name for one in scene.states], problem.start
    given = (
        Start(np.zeros(0), np.zeros(0), s=start.s)
        if isinstance(start, Start)
        else {name: value for name, value in problem.by_name[0].items() if name in own}
    )
    run = simulate(scene.without_mechanism(), forces=told, start=given, until=float(t[-1]), say=lambda line: None)
    found = run(t[t <= run.t[-1]])
    names = [one.name for one in scene.given]
    return {name: found[name] for name in names}, "" if run.complete else f"states: {run.stopped}"


def _of_law(law: Law, order: int, at: Array, _: int) -> Array:
    return law(at)[order]


def _ended(t: Array, bad: npt.NDArray[np.bool_], why: Callable[[int, int], str], stopped: str) -> tuple[int, str]:
    """Return how many rows there are before a bad one, and what is said then; SimulateError where the first is one."""
    places = np.argwhere(bad)
    if not len(places):
        return len(bad), stopped
    n, k = (int(one) for one in places[0])
    told = f"motion: t = {t[n]:g} s: {why(n, k)}"
    if not n:
        raise SimulateError(told)
    return n, told


def _left_out(
    scene: Scene, motion: SceneMotion, named: Collection[str], lawful: Sequence[str], guess: Array, t: Array, q: Array
) -> list[str]:
    """Return what is not taken of a start's names, and which laws jump within the times."""
    told = [
        f"start: {name} = {x:.6g} is not taken: its law begins at {taken:.6g}"
        for name, x, taken in zip(scene.coordinates, guess, q, strict=True)
        if name in named and name in lawful and abs(x - taken) > CONSISTENT
    ]
    rates = [one for one in scene.velocities if one in named and one not in scene.coordinates]
    told += [f"start: {one} is not taken: velocities follow from the motion" for one in rates]
    return told + [
        f"motion: {name} jumps at t = {at:.6g} s; its rate and acceleration, and forces from them, leave that out"
        for name, law in motion.laws.items()
        if (at := law.jump(float(t[0]), float(t[-1]))) is not None
    ]


def _passed(scene: Scene, functions: InverseFunctions, t: Array, q: Array, u: Array, tau: Array) -> list[str]:
    """Return what is to be said of limits of joints that the motion and its forces leave, at the samples."""
    if not functions.limits:
        return []
    each = zip(functions.limits, functions("limits", t, q, u, tau=tau).T, strict=True)
    return [line for limit, value in each for line in passed(limit, scene, passages(t, value > SLACK))]


def _own(scene: Scene, forces: Forces) -> dict[str, Law]:
    """Return the laws that the scene itself prescribes, in inputs too."""
    inputs = {one.name: one.value for one in scene.inputs}
    values, names = parameter_values(scene) | inputs, (*drive_names(scene), *inputs)
    values |= {names[k]: bound(formula, values) for k, formula in forces.formulas.items()}
    tables = {names[k]: table for k, table in forces.tables.items()}
    values = {name: one for name, one in values.items() if name not in tables}
    moved = [(joint.coordinates[0], joint.motion) for joint in scene.joints if joint.motion is not None]
    return {name: formula_law(bound(motion, values), spell(motion), tables) for name, motion in moved}


def _laws(scene: Scene, motion: SceneMotion, start: Array, forces: Forces) -> dict[str, Law]:
    """Return a law for every coordinate, in order."""
    own = _own(scene, forces)
    return {
        name: motion.laws.get(name) or own.get(name) or constant(float(x))
        for name, x in zip(scene.coordinates, start, strict=True)
    }


def _check(scene: Scene, motion: SceneMotion, path: ScenePath, t: Array, reactions: bool | str) -> str:
    """Return the axes of reactions that are wanted, "" for none; all faults together."""
    parameter_values(scene)
    faults = Faults("")
    axes = axes_of(reactions, faults, scene)
    if not scene.velocities:
        faults.add(scene.name, "nothing moves: no joint has a coordinate")
    if not len(t):
        faults.add("times", "there is none; give them in seconds, such as numpy.linspace(0, 2, 201)")
    elif not np.all(np.isfinite(t)) or np.any(np.diff(t) <= 0):
        faults.add("times", "must be finite and rise")
    elif scene.states and (len(t) < 2 or t[0] != 0):
        faults.add("times", "states start at t = 0 and are integrated from there; give 0, and times behind it")
    for what, (low, high) in (("motion", motion.span), ("path", path.span)):
        if len(t) and (t[0] < low or t[-1] > high):
            faults.add(what, f"is known from {low:g} s to {high:g} s only; times go from {t[0]:g} s to {t[-1]:g} s")
    moved = scene.prescribed_velocities
    for name in motion.laws:
        if velocity_name(name) in [scene.velocities[k] for k in moved]:
            faults.add(
                "motion",
                f"{name} has a prescribed motion in the scene, that of its joint; leave it out here, or take that away",
            )
    faults.close(SimulateError)
    return axes


def _velocities(
    scene: Scene, functions: InverseFunctions, motion: SceneMotion, t: Array, q: Array, rate: Array, second: Array
) -> tuple[Array, Array]:
    """Return u and u̇ of positions whose rates are known; what tables say about quasi-velocities goes first."""
    H = functions("kinematics", t, q, np.zeros((len(t), len(scene.velocities))))
    back = np.linalg.pinv(H)
    off = np.abs(np.einsum("nij,nj->ni", H, np.einsum("nij,nj->ni", back, rate)) - rate)
    for lengths in _lengths(scene, q, scene.coordinates):
        _unit(lengths)
    u = np.einsum("nij,nj->ni", back, rate)
    a = np.einsum("nij,nj->ni", back, second - functions("turning", t, q, u))
    for k, name in enumerate(scene.velocities):
        if name in motion.quasi:
            u[:, k], a[:, k], _ = motion.quasi[name](t)
    if not motion.quasi and off.size and off.max() > 1e-6 * max(1.0, float(np.abs(rate).max())):
        raise SimulateError("motion: a quaternion changes its length; give unit quaternions")
    return u, a


def _lengths(scene: Scene, q: Array, names: Sequence[str]) -> list[Array]:
    """Return the lengths of the quaternions among columns of q, called `names`."""
    groups = [group for group in quaternions(scene) if group[0] in names]
    return [np.linalg.norm(q[:, list(names).index(group[0]) :][:, :4], axis=1) for group in groups]


def _unit(lengths: Array) -> None:
    if np.abs(lengths - 1.0).max() > UNIT:
        raise SimulateError(
            f"motion: a quaternion has the length {lengths[int(np.abs(lengths - 1).argmax())]:.6g}; "
            "give unit quaternions, such as cos(t/2) and sin(t/2)"
        )
