"""A run as a trajectory: motion, forces, columns, monitors, events, limits, and what ended it.

Monitors show how well the laws of mechanics are kept. The balance of energy is K + P - W less its value at the start. W
is the work of drives, damping, friction and loads, integrated along with the motion; P holds gravity and springs.

The equations take contacts as two-sided and without slip. Whether a contact pushes, and which friction keeps it from
slipping, is computed from the multipliers N along the normal and F in the plane.

Limits of joints are reported where a run starts beyond one, is ended by one, or passes one. A joint that reaches a
limit of its position rests on its stop, which the equations do not know: beyond it they describe another mechanism's
motion. Limits of velocity and effort say what a drive can do; the equations hold beyond them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.errors import DerivationError, SimulateError, listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import Graph
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.forces import FORCES
from symdyn.scene.values import Contact, Faults, force_unit
from symdyn.simulation.columns import apart, axes_of
from symdyn.simulation.equations.compiled_routines import opened
from symdyn.simulation.equations.contact_modes import columns_of, laws_missed
from symdyn.simulation.equations.monitors import SLACK, STOPS, Limit
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.force_columns import multipliers, output_columns, reaction_columns, tension_columns
from symdyn.simulation.integrate.integration import (
    DOUBLES,
    END,
    INTERRUPTED,
    STOPPED,
    Hit,
    InitialValueProblem,
    Integration,
    Method,
    integrated,
)
from symdyn.simulation.integrate.valueless import valueless
from symdyn.simulation.trajectory import Event, Trajectory

DATA = "the limit is data for controllers, nothing in the equations keeps it"


def stopping(system: StateEquations, ignored: bool) -> dict[int, bool]:
    """Return of every limit whether it ends a run where a joint passes it, by the number of its kind of event."""
    return {k: limit.kind in STOPS and not ignored for k, limit in system.limits.items()}


def nothing_ignored(system: StateEquations, ignored: bool) -> tuple[str, ...]:
    """Return what is said where limits are to be ignored that there are not."""
    if not ignored or any(limit.kind in STOPS for limit in system.limits.values()):
        return ()
    return (f"ignoring limits has no effect: no joint of {system.scene.name} has a limit of its position",)


def named(limit: Limit, scene: Scene) -> str:
    """Return a limit by its joint, such as "joint elbow: upper limit 1.57 rad"."""
    return f"joint {limit.joint.name}: {limit.words(scene)}"


def reached(limit: Limit, scene: Scene, t: float) -> str:
    """Return what is said of a limit that ended a run."""
    return (
        f"joint {limit.joint.name} reaches its {limit.words(scene)} at t = {t:.9g} s, a stop that the equations do not "
        f"know; {argument('ignore_limits', True)} goes on"
    )


def at_start(system: StateEquations, x: Array, stops: Mapping[int, bool]) -> list[str]:
    """Return what is said of a start x, shape (nx,), beyond limits, of which some stop a run."""
    goes_on = "the run goes on until the joint has come back and passes it again"
    outside = beyond(system, np.zeros(1), x[None])
    found = [(limit, stops[k]) for k, limit in system.limits.items() if outside[0, k]]
    found += [(limit, False) for limit in _by_constant_forces(system, x)]
    return [
        f"{named(limit, system.scene)} is passed at the start; {goes_on if stop else DATA}" for limit, stop in found
    ]


def _by_constant_forces(system: StateEquations, x: Array) -> list[Limit]:
    """Return the limits of effort that a force passes which no state changes, so that nothing crosses zero."""
    scene, graph = system.scene, Graph()
    watched = {limit.joint.name for limit in system.limits.values() if limit.kind == "effort"}
    forces = np.broadcast_to(system.evaluate("drives", 0.0, x), (system.nv,))
    found = []
    for joint in scene.moving:
        limit, first = Limit(joint, "effort", graph.zero), scene.velocities.index(joint.rates[0])
        told = joint.name not in watched and joint.limits.effort is not None and len(joint.rates) == 1
        found += [limit] if told and abs(forces[first]) > limit.size(scene) else []
    return found


def on_the_way(system: StateEquations, t: Array, x: Array, hits: Sequence[Hit], stops: Mapping[int, bool]) -> list[str]:
    """Return what is said of limits that a run passed after its start, at samples or, by its hits, between them."""
    outside, found = beyond(system, t, x), []
    for k, limit in system.limits.items():
        stop = stops[k]
        times = [] if stop else [hit.t for hit in hits if hit.event == k]
        rows = slice(len(t) - stop)  # where a limit stops a run, its last row is beyond it
        found += passed(limit, system.scene, times or passages(t[rows], outside[rows, k])[int(outside[0, k]) :])
    return found


def beyond(system: StateEquations, t: Array, x: Array) -> Array:
    """Return whether guards of all kinds of events are positive, beyond a limit where it is one, shape (N, kinds)."""
    if not system.limits:
        return np.zeros((len(t), len(system.kinds)), dtype=bool)
    return np.asarray(system.evaluate("events", t, x) > SLACK)


def passages(t: Array, outside: Array) -> list[float]:
    """Return at which times, shape (N,), a limit has been passed that was kept a sample before; the first counts."""
    before = np.concatenate([[False], outside[:-1]])
    return [float(one) for one in t[outside & ~before]]


def passed(limit: Limit, scene: Scene, times: Sequence[float]) -> list[str]:
    """Return what is said of a limit that was passed at some times, nothing where there are none."""
    again = len(times) - 1
    more = f" and {again} time{'s' * (again > 1)} more" if again > 0 else ""
    return [f"{named(limit, scene)} is passed at t = {times[0]:.6g} s{more}; {DATA}"] if times else []


def observe(system: StateEquations, t: Array, x: Array) -> tuple[dict[str, Array], dict[str, float]]:
    """Return columns of energies, powers and residuals at states x, shape (N, nx), and the largest violations."""
    K, P = (np.broadcast_to(system.evaluate(name, t, x).reshape(-1), t.shape) for name in ("kinetic", "potential"))
    columns = {"kinetic_energy": K, "potential_energy": P}
    W = x[:, -1] if system.works else np.zeros_like(t)
    if system.works:
        power = system.evaluate("power", t, x)
        columns |= {"drive_power": power[..., 0], "other_power": power[..., 1], "work": W}
    columns["energy_error"] = (K + P - W) - (K[0] + P[0] - W[0])
    monitors = {"energy": _largest(columns["energy_error"]), "energy_scale": _largest(np.abs(K) + np.abs(P - P[0]))}
    if system.closed:
        for name, told in (("loop_error", "constraint_residual"), ("loop_rate_error", "row_rates")):
            columns[name] = np.abs(system.evaluate(told, t, x)).max(axis=-1, initial=0.0)
        monitors |= {"loops": _largest(columns["loop_error"]), "loop_rates": _largest(columns["loop_rate_error"])}
    if system.quaternions:
        lengths = [np.abs(np.einsum("ni,ni->n", x[:, part], x[:, part]) - 1.0) for part in system.quaternions]
        monitors["quaternions"] = max(_largest(one) for one in lengths)
    if system.momenta:
        places = [system.reported.index(k) for k in system.conserved]
        values = system.evaluate("momenta", t, x).reshape(len(t), -1)[:, places]
        columns |= {name: values[:, k] for k, name in enumerate(system.momenta)}
        monitors["momenta"] = _largest(values - values[0])
    return columns, monitors


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values), initial=0.0))


NOTHING, OFF_PLANE = 1e-9, 1e-4
"""Forces over the largest that are rounding; what a wheel goes across its plane in a run without a note, m."""


@dataclass(frozen=True)
class Needed:
    """What a contact needs over a motion."""

    row: Contact  # of the scene
    normal: Array  # N, shape (N,); it pulls where it is negative
    friction: Array  # |F| / N at least, where the contact pushes; 0 elsewhere, shape (N,)


def needed(system: StateEquations, motion: Trajectory) -> tuple[list[Needed], list[str]]:
    """Return what contacts that hold a height need over a motion, and what is to be said of it."""
    contacts = [row for row in system.scene.contacts if FORCES[row.kind].holonomic(row)]
    if not contacts:
        return [], _left(motion)
    labels, decisions = opened(system.scene).numbers().constraints.labels, system.decisions
    owners = {k: (label.owner, label.number) for k, label in enumerate(labels) if not label.loop}
    places = {owners[k]: place for place, k in enumerate(decisions.independent_rows) if k in owners}
    shared = {owners[k] for k in decisions.indeterminate if k in owners}
    sizes = multipliers(motion, decisions)
    found, notes = [], _left(motion)
    for row in contacts:
        mine = {row.components[number]: k for (name, number), k in places.items() if name == row.name}
        if "normal" not in mine or any((row.name, number) in shared for number in range(len(row.components))):
            notes.append(f"contact {row.name}: its forces are not unique and not reported")
            continue
        normal = sizes[:, mine["normal"]]
        plane = np.hypot(
            *(sizes[:, mine[way]] if way in mine else np.zeros_like(normal) for way in ("along", "across"))
        )
        size = float(np.abs(sizes).max(initial=0.0))
        pushes = normal > NOTHING * size
        one = Needed(row, normal, np.where(pushes, plane / np.where(pushes, normal, 1.0), 0.0))
        found.append(one)
        notes += _told(one, motion.t, size)
    return found, notes


def _left(motion: Trajectory) -> list[str]:
    """Return which wheels have gone off the plane that nothing holds them to."""
    free = [row for row in motion.scene.contacts if row.radius != Quantity.ZERO and "normal" not in row.components]
    if not free:
        return []
    numbers = opened(motion.scene).numbers()
    gaps = [one for one in numbers.contact_gaps if one.row in free]
    begun, ended = (np.array(numbers.at([one.height for one in gaps], q)) for q in motion.q[[0, -1]])
    return [
        f"contact {one.row.name}: {one.row.place.body} {'rises' if h > 0 else 'falls'} by {abs(h):.3g} m across its "
        'plane in this run; "normal" among its components holds it there'
        for one, h in zip(gaps, (ended - begun).tolist(), strict=True)
        if abs(h) > OFF_PLANE
    ]


def _told(one: Needed, t: Array, size: float) -> list[str]:
    """Return whether a contact would pull, and the friction that it needs."""
    notes, where = [], f"contact {one.row.name}"
    pulls = np.flatnonzero(one.normal < -NOTHING * size)
    if len(pulls):
        worst = int(one.normal.argmin())
        notes.append(
            f"{where}: its normal force would pull at t = {t[pulls[0]]:.6g} s, by up to {-one.normal[worst]:.3g} N at "
            f"t = {t[worst]:.6g} s; {one.row.place.body} would lift off there, which this "
            "model does not know"
        )
    if float(one.friction.max(initial=0.0)) > NOTHING:
        k = int(one.friction.argmax())
        notes.append(f"{where}: not to slip takes a friction coefficient of {one.friction[k]:.3g} at t = {t[k]:.6g} s")
    return notes


def tensions_in(motion: Trajectory) -> tuple[dict[str, float], list[str]]:
    """Return the least tension of every rope, N, and where one would push."""
    try:
        tensions = tension_columns(motion) if motion.scene.ropes else {}
    except DerivationError as fault:
        return {}, [str(fault).removeprefix(f"{motion.scene.name}: ")]
    notes, size = [], max((float(np.abs(one).max()) for one in tensions.values()), default=0.0)
    for rope in motion.scene.ropes:
        tension = tensions[f"tension_{rope.name}"]
        pushes = np.flatnonzero(tension < -NOTHING * size)
        if len(pushes):
            worst = int(tension.argmin())
            notes.append(
                f"rope {rope.name}: it would push at t = {motion.t[pushes[0]]:.6g} s, by up to {-tension[worst]:.3g} N "
                f"at t = {motion.t[worst]:.6g} s; it goes slack there, which this model does not know"
            )
    return {f"tension {name.removeprefix('tension_')}": float(one.min()) for name, one in tensions.items()}, notes


PASSIVE = 1e-7
"""Force of a passive joint, over the largest, that is rounding."""


def passive_forces(scene: Scene, tau: Array) -> list[str]:
    """Return what is to be said of driving forces, shape (N, nv), where there is no drive."""
    moved, largest = scene.prescribed_velocities, np.abs(tau).max(axis=0)
    units, told = SceneUnits(scene).velocities, ""
    if scene.states and scene.inputs:
        own, given = (listed(one.name for one in some) for some in (scene.states, scene.inputs))
        told = f" beside what {own} gives; for {given} that gives all of it ask collocation"
    return [
        f"{name.removesuffix('_dot')} has no drive, and the motion takes up to "
        f"{scene.in_shown_unit(f'{largest[k]:.3g}', force_unit(units[k]))} there{told}"
        for k, name in enumerate(scene.velocities)
        if scene.drives[k] is None and k not in moved and largest[k] > PASSIVE * max(1.0, float(largest.max()))
    ]


AHEAD = (0.0, 1e-6, 1e-5, 1e-4)
"""Parts of the time, or seconds, by which it is looked ahead for what has no value where a run ends."""


def trajectory_of(
    system: StateEquations, run: Integration, formulas: Sequence[str], flags: Sequence[bool], reactions: bool | str
) -> Trajectory:
    """Return what a run is told as: motion, forces, columns, monitors, events, and what ended it."""
    contacts = system.contacts
    scene = system.scene if contacts is None or contacts.declared is None else contacts.declared
    parts = slice(0, system.nq), slice(system.nq, system.nq + system.nv)
    q, u = (run.x[:, part] for part in parts)
    events = _events(system, run, formulas, flags)
    with np.errstate(all="ignore"):  # a motion that leaves what is real has its last row there
        columns, monitors = observe(system, run.t, run.x)
        qdd = system.evaluate("rates", run.t, run.x)[:, parts[1]]
        tau = np.broadcast_to(system.evaluate("drives", run.t, run.x), u.shape)
        found = Trajectory(scene, run.t, q, u, qdd, tau, events=events, stopped=_why(system, formulas, run))
        if scene.given:
            inputs = system.evaluate("inputs", run.t, run.x) if scene.inputs else 0.0
            told = np.broadcast_to(inputs, (len(run.t), len(scene.inputs)))
            own = run.x[:, system.nq + system.nv :][:, : len(scene.states)]
            given = zip(scene.given, (*told.T, *own.T), strict=True)
            columns = {one.name: column for one, column in given} | columns
            found = replace(found, extra=columns)
        if contacts is not None:
            columns |= columns_of(contacts, system, run.t, run.x)
            monitors |= laws_missed(contacts, system, run.t, run.x)
        if scene.points:
            columns |= dict(zip(scene.point_names, system.evaluate("points", run.t, run.x).T, strict=True))
        if axes := axes_of(reactions, Faults("")):
            columns |= reaction_columns(replace(found, extra=columns), given=True, axes=axes)
        columns |= output_columns(replace(found, extra=columns), given=True)
        lasting, seen = needed(system, found)
        least, pushes = tensions_in(found)
    for one in lasting:
        monitors[f"normal_force {one.row.name}"] = float(one.normal.min())
        monitors[f"friction_coefficient {one.row.name}"] = float(one.friction.max())
    monitors |= least
    impacts = () if contacts is None else tuple(contacts.told)
    return replace(found, extra=apart(scene, columns), monitors=monitors, notes=(*seen, *pushes), impacts=impacts)


@dataclass(frozen=True, eq=False)
class DenseOutput:
    """A run between its samples: its integrator goes on from the sample before, at the same tolerances.

    It keeps the samples and the equations, and costs nothing before it is asked. Samples of a controller and its forces
    are those of the run. Of runs with 31 digits it computes in doubles.
    """

    run: Integration  # what was found
    problem: InitialValueProblem  # what was integrated
    method: Method  # the integrator
    reported: Callable[[Integration], Trajectory]  # makes rows of it, those of all its columns

    def __call__(self, whole: Trajectory, t: Array) -> Trajectory:
        """Return a run at times, shape (N,), in any order.

        Raises:
            SimulateError: a time outside of the run, or what an integrator cannot pass.
        """
        first, last = self.run.t[0], self.run.t[-1]
        if len(outside := t[~((t >= first) & (t <= last))]):
            raise SimulateError(
                f"{whole.scene.name}: t = {outside[0]:.9g} s is outside of the run, {first:g} … {last:g} s; nothing is "
                "extrapolated, simulate a longer one"
            )
        times = np.concatenate([[first], t])  # errors of balances count from the begin
        rows = self.reported(replace(self.run, t=times, x=self._states(times), hits=(), stopped=END, low=None))
        arrays = {name: getattr(rows, name)[1:] for name in ("t", "q", "qd", "qdd", "tau")}
        return replace(whole, **arrays, extra={name: x[1:] for name, x in rows.extra.items()}, low=None)

    def _states(self, t: Array) -> Array:
        """Return the states at times of the run, shape (N, nx); those at samples as they are."""
        asked, places = np.unique(t, return_inverse=True)
        before = np.searchsorted(self.run.t, asked, side="right") - 1
        found = self.run.x[before]
        between = asked > self.run.t[before]
        for k in np.unique(before[between]):
            inside = between & (before == k)
            found[inside] = self._after(int(k), asked[inside])
        return np.asarray(found[places])

    def _after(self, k: int, t: Array) -> Array:
        """Return the states, shape (N, nx), at times after the sample k and before the next one."""
        begin, system = float(self.run.t[k]), self.problem.system
        loop = None if system.loop is None else system.loop.again(begin)
        times = np.concatenate([[begin], t])
        problem = replace(
            self.problem, system=replace(system, loop=loop), x=self.run.x[k], times=times, low=None,
            stops=tuple(False for _ in system.kinds) if system.jumps else (),
            atol=max(self.problem.atol, DOUBLES), unsure={},
        )  # fmt: skip
        part = integrated(problem, self.method)
        if part.stopped != END:
            raise SimulateError(f"{system.scene.name}: between t = {begin:.9g} s and the next sample: {part.stopped}")
        return part.x[1:]


def _events(
    system: StateEquations, run: Integration, formulas: Sequence[str], flags: Sequence[bool]
) -> tuple[Event, ...]:
    """Return the zeros of formulas, resets, and behind them the limit of a joint that ended the run."""
    nq, nv = system.nq, system.nv
    texts = {k: kind.text for k, kind in enumerate(system.kinds) if kind.text} | dict(enumerate(formulas))
    told = [
        (hit, texts[hit.event], hit.event < len(flags) and flags[hit.event]) for hit in run.hits if hit.event in texts
    ]
    if run.stopped == STOPPED and (limit := system.kinds[run.hits[-1].event].limit) is not None:
        told.append((run.hits[-1], named(limit, system.scene), True))
    return tuple(Event(text, hit.t, hit.x[:nq], hit.x[nq : nq + nv], stops) for hit, text, stops in told)


def overlooked(unsure: Mapping[int, float], formulas: Sequence[str]) -> list[str]:
    """Return what is said of formulas whose passages of zero may not all have been found, from times by event."""
    return [
        f"{formulas[k]}: it moves to and fro about zero from t = {t:.9g} s on, more often than is looked at in one "
        "step; events of it may be missing from there on"
        for k, t in sorted(unsure.items())
        if k < len(formulas)
    ]


def _why(system: StateEquations, formulas: Sequence[str], run: Integration) -> str:
    """Return what ended a run: its time, a formula of the user, where equations end, or what has no value there."""
    if run.stopped in (END, INTERRUPTED):
        return run.stopped
    if run.stopped == STOPPED:
        hit = run.hits[-1]
        if hit.event < len(formulas):
            return formulas[hit.event]
        kind = system.kinds[hit.event]
        if kind.limit is not None:
            return reached(kind.limit, system.scene, hit.t)
        return f"t = {hit.t:.9g} s: {kind.end}"
    t, x = float(run.t[-1]), run.x[-1]
    if system.changes(x[: system.nq]):
        return f"{run.stopped}; a change point of the loops is near, where branches of their motion meet"
    rates = np.nan_to_num(system.evaluate("rates", np.array([t]), x[None])[0])
    places = (x + way * max(1.0, t) * rates for way in AHEAD)
    parts = (valueless(system.scene, system.forces, t, *system.parts(one)[:2]) for one in places)
    found = next(filter(None, parts), "")
    return f"{run.stopped}; {found}" if found else run.stopped
