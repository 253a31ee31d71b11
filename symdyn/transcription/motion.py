"""The unknowns of a problem as a motion: columns, forces over time, phases and what happens between them."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import listed
from symdyn.frozen import dataclass, field, replace
from symdyn.scene import Scene
from symdyn.simulation import Forces, Impact, Trajectory, change_of, column_words
from symdyn.simulation.prescribed import ForceTable
from symdyn.transcription.grid import Row
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.transcription.transcribed import Collocation


@dataclass(frozen=True)
class Pieces(ForceTable):
    """A polynomial in each interval, through the values at the stages; t are the ends of the intervals."""

    c: Row = ()  # stages within an interval, 0 … 1
    values: Array = field(default_factory=lambda: np.zeros((0, 0)))  # at the stages, shape (N, s)

    @cached_property
    def _curve(self) -> Callable[[Array], Array]:
        from scipy.interpolate import PPoly

        powers = np.vander([float(x) for x in self.c])  # highest first, as PPoly has them
        widths = np.diff(self.t)
        found: Callable[[Array], Array] = PPoly(
            np.linalg.solve(powers, self.values.T) / widths ** np.arange(len(self.c))[::-1, None], self.t
        )
        return found


CLOSE = 1e-6
"""What is rounding beside a gap or a speed."""

APART = 1e6
"""By how much later a phase begins for what is interpolated within each, s."""


def forces_of(problem: Collocation, z: Array) -> Forces:
    """Return the driving forces over time, see `Solution.forces`."""
    grid, times, values = problem.grid, problem.times(z), z[problem.place["force"]]
    if len(problem.method.c) == 1:
        t = times[grid.stage]
        return Forces(tables={k: ForceTable(t, x) for k, x in zip(problem.driven, values.T, strict=True)})
    t = times[grid.node[[0, *grid.ends]]]
    tables = [Pieces(t, np.zeros(len(t)), c=problem.method.c, values=x[grid.of]) for x in values.T]
    return Forces(tables=dict(zip(problem.driven, tables, strict=True)))


def run_of(scene: Scene, problem: Collocation, z: Array, notes: tuple[str, ...], wall: float) -> Trajectory:
    """Return the motion at all points."""
    grid, place, t = problem.grid, problem.place, problem.times(z)
    stages = np.concatenate([z[place["a"]], _driving(problem, z), z[place["contact"]]], axis=1)
    n, count = len(scene.velocities), place["contact"].shape[1]
    apart = t + APART * grid.phase
    every = np.stack([np.interp(apart, apart[grid.stage], x) for x in stages.T], axis=1)
    a, tau, given, pushed = np.split(every, [n, 2 * n, every.shape[1] - count], axis=1)
    q, s, u = (z[place[kind]] for kind in ("q", "s", "u"))
    curves = dict(zip(problem.drives, forces_of(problem, z).tables.values(), strict=True))
    extra = dict(zip((one.name for one in scene.given), np.hstack([given, s]).T, strict=True))
    extra |= _contact_columns(problem, z, q, pushed)
    notes = (*passed(problem, z), *notes)
    impacts = impacts_of(problem, z)
    return Trajectory(scene, t, q, u, a, tau, extra, notes=notes, wall=wall, curves=curves, impacts=impacts)


def _contact_columns(problem: Collocation, z: Array, q: Array, forces: Array) -> dict[str, Array]:
    """Return gap, forces and mode of every contact, as runs have them."""
    touches, found = problem.source.written.contacts.touches, dict[str, Array]()
    if not touches:
        return {}
    gaps = iter(problem.source.locals["touch"].value({"q": q, "free": z[problem.place["free"]]}).T)
    pushed = iter(forces.T)
    for touch, (closed, _, slip) in zip(touches, problem.modes.T.reshape(-1, 3, len(problem.schedule)), strict=True):
        name = touch.law.name
        found |= {f"gap_{name}": next(gaps)} if touch.normal else {}
        found |= {word: next(pushed) for word in column_words(name, bool(touch.normal), len(touch.tangents))}
        found[f"mode_{name}"] = np.where(slip, 2.0 * slip, closed)[problem.grid.phase]
    return found


PASSED = 1e-3
"""Of the largest gap or speed, what is the wrong way and told."""


def passed(problem: Collocation, z: Array) -> tuple[str, ...]:
    """Return notes on what is below its plane, or slips the other way, inside of intervals."""
    touches, grid = problem.source.written.contacts.touches, problem.grid
    if not touches:
        return ()
    state = {kind: z[problem.place[kind]] for kind in ("q", "s", "u", "free")} | {TIME: problem.times(z)}
    each = problem.source.locals["open"].value({**state, "mode": problem.modes[grid.phase]}).T
    words = [(one, "is below its plane", one.active is not None) for one in touches if one.normal]
    words += [(one, "slips the other way", False) for one in touches if one.tangents]
    found = []
    for (one, what, may), values in zip(words, each, strict=True):
        at, most = int(values.argmin()), float(np.abs(values).max())
        if values[at] < -max(PASSED * most, CLOSE) and not may:
            told = f"{one.law.name} {what} inside of an interval of phase {grid.phase[at] + 1}"
            found.append(f"{told}: give more intervals, or another schedule if they do not help")
    return tuple(found)


MISSED = 1e-2
"""Of what a coordinate or velocity goes through, by how much a simulated end may miss what was asked."""


def missed(problem: Collocation, found: Trajectory, run: Trajectory) -> tuple[str, ...]:
    """Return a note where a run with the forces of a solution ends elsewhere than was asked."""
    if not run.ended:
        return (f"simulated with its forces, the motion ends before: {run.stopped}",)
    names, units = (*found.scene.coordinates, *found.scene.velocities), {one.name: one.unit for one in run.columns}
    far = []
    for name, k in zip(names, np.concatenate([problem.place["q"][-1], problem.place["u"][-1]]), strict=True):
        end, asked = float(run[name][-1]), float(problem.lower[k])
        if asked == problem.upper[k] and abs(end - asked) > max(MISSED * np.ptp(found[name]), CLOSE):
            far.append(f"{name} = {end:.4g} {units[name]} and not {asked:.4g}".replace("  ", " "))
    helps = "give more intervals, or follow the motion with feedback=found.track()"
    return (f"simulated with its forces, the motion ends at {listed(far, 4)}: {helps}",) if far else ()


def _driving(problem: Collocation, z: Array) -> Array:
    """Return all driving forces at the stages, those of prescribed motions as well, and inputs, shape (S, …)."""
    count = len(problem.scene.velocities) + len(problem.scene.inputs)
    found = np.zeros((len(problem.grid.stage), count))
    found[:, list(problem.driven)] = z[problem.place["force"]]
    led = problem.scene.prescribed_velocities
    if led:
        found[:, list(led)] = z[problem.place["multiplier"]][:, -len(led) :]
    return found


def phases_of(run: Trajectory, problem: Collocation) -> tuple[Trajectory, ...]:
    """Return the motion of each phase."""
    found = []
    for k in range(len(problem.schedule)):
        rows = problem.grid.phase == k
        parts = {name: getattr(run, name)[rows] for name in ("t", "q", "qd", "qdd", "tau")}
        found.append(replace(run, **parts, extra={name: x[rows] for name, x in run.extra.items()}, impacts=()))
    return tuple(found)


def impacts_of(problem: Collocation, z: Array) -> tuple[Impact, ...]:
    """Return what happens at contacts between phases, in order."""
    if len(problem.schedule) == 1:
        return ()
    written, at, k = problem.source.written, problem.at(z, "joint"), problem.source.written.rows
    law, kicks, found = problem.locals["law"].value, at["impulse"], list[Impact]()
    alone = np.tile([1.0, 0.0, 0.0], at["impulse"].shape)  # so that the law tells W u
    before, after = (law({**at, "u": at[kind], "law": alone}) for kind in ("before", "u"))
    lost = 0.0 - np.sum(kicks * (before + after), axis=1) / 2
    for number, (one, then) in enumerate(pairwise(problem.schedule)):
        k = written.rows
        words = tuple(then.word(x.law.name, bool(x.tangents)) for x in written.contacts.touches)
        for touch in written.contacts.touches:
            name, first, k = touch.law.name, k, k + len(touch.rows)
            if what := change_of(one.mode(name), then.mode(name), name in then.strikes, touch.law.kind):
                u, v = (float(x[number, first]) if touch.normal else 0.0 for x in (before, after))
                impulse, t = tuple(kicks[number, first:k].tolist()), float(at[TIME][number])
                found.append(Impact(t, name, what, u, v, impulse, float(lost[number]), words, unit=touch.unit))
    return tuple(found)
