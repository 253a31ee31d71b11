"""A run as a trajectory: motion, forces, columns, monitors, events, and what ended it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symdyn.scene.values import Faults
from symdyn.simulation.columns import apart
from symdyn.simulation.equations.crossings import Limit
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate.method import Hit
from symdyn.simulation.joint_limits import named, reached
from symdyn.simulation.monitors import needed, observe
from symdyn.simulation.reaction_columns import axes_of, reaction_columns
from symdyn.simulation.run import STOPPED, Integration
from symdyn.simulation.signal_columns import output_columns
from symdyn.simulation.trajectory import END, INTERRUPTED, Event, Trajectory
from symdyn.simulation.valueless import valueless

AHEAD = (0.0, 1e-6, 1e-5, 1e-4)
"""Parts of the time, or seconds, by which it is looked ahead for what has no value where a run ends."""


def trajectory_of(
    system: StateEquations, run: Integration, formulas: Sequence[str], flags: Sequence[bool], reactions: bool | str
) -> Trajectory:
    """Return what a run is told as: motion, forces, columns, monitors, events, and what ended it."""
    scene = system.scene
    parts = slice(0, system.nq), slice(system.nq, system.nq + system.nv)
    q, u = (run.x[:, part] for part in parts)
    events = _events(system, run, formulas, flags)
    with np.errstate(all="ignore"):  # a motion that leaves what is real has its last row there
        columns, monitors = observe(system, run.t, run.x)
        qdd = system.evaluate("rates", run.t, run.x)[:, parts[1]]
        tau = np.broadcast_to(system.evaluate("drives", run.t, run.x), u.shape)
        found = Trajectory(scene, run.t, q, u, qdd, tau, events=events, stopped=_why(system, formulas, run))
        if scene.inputs:
            told = np.broadcast_to(system.evaluate("inputs", run.t, run.x), (len(run.t), len(scene.inputs)))
            columns = {one.name: column for one, column in zip(scene.inputs, told.T, strict=True)} | columns
            found = replace(found, extra=columns)
        if scene.points:
            columns |= dict(zip(scene.point_letters, system.evaluate("points", run.t, run.x).T, strict=True))
        if axes := axes_of(reactions, Faults("")):
            columns |= reaction_columns(found, given=True, axes=axes)
        columns |= output_columns(replace(found, extra=columns), given=True)
        contacts, seen = needed(system, found)
    for one in contacts:
        monitors[f"normal_force {one.row.name}"] = float(one.normal.min())
        monitors[f"friction_coefficient {one.row.name}"] = float(one.friction.max())
    return replace(found, extra=apart(scene, columns), monitors=monitors, notes=tuple(seen))


def _events(
    system: StateEquations, run: Integration, formulas: Sequence[str], flags: Sequence[bool]
) -> tuple[Event, ...]:
    """Return the zeros of formulas, and behind them the limit of a joint that ended the run."""
    nq, nv = system.nq, system.nv
    told = [(hit, formulas[hit.event], flags[hit.event]) for hit in run.hits if hit.event < len(formulas)]
    if run.stopped == STOPPED and (limit := _limit(system, run.hits[-1], formulas)) is not None:
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


def _limit(system: StateEquations, hit: Hit, formulas: Sequence[str]) -> Limit | None:
    """Return the limit that a hit tells of, None of another event."""
    k = hit.event - len(formulas) - len(system.ends)
    return system.limits[k] if k >= 0 else None


def _why(system: StateEquations, formulas: Sequence[str], run: Integration) -> str:
    """Return what ended a run: its time, a formula of the user, where equations end, or what has no value there."""
    if run.stopped in (END, INTERRUPTED):
        return run.stopped
    if run.stopped == STOPPED:
        hit = run.hits[-1]
        if hit.event < len(formulas):
            return formulas[hit.event]
        if (limit := _limit(system, hit, formulas)) is not None:
            return reached(limit, system.scene, hit.t)
        return f"t = {hit.t:.9g} s: {system.ends[hit.event - len(formulas)]}"
    t, x = float(run.t[-1]), run.x[-1]
    if system.changes(x[: system.nq]):
        return f"{run.stopped}; a change point of the loops is near, where branches of their motion meet"
    rates = np.nan_to_num(system.evaluate("rates", np.array([t]), x[None])[0])
    places = (x + way * max(1.0, t) * rates for way in AHEAD)
    parts = (
        valueless(system.scene, system.forces, t, one[: system.nq], one[system.nq : system.nq + system.nv])
        for one in places
    )
    found = next(filter(None, parts), "")
    return f"{run.stopped}; {found}" if found else run.stopped
