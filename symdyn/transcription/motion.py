"""The unknowns of a problem as a motion: columns, forces over time, phases and what happens between them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symdyn.algebra import Array
from symdyn.scene import Scene
from symdyn.simulation import Forces, Trajectory
from symdyn.simulation.equations.contact_modes import BREAKS, FRICTIONS, LIFTS, STOPS, STRIKES, Impact
from symdyn.simulation.prescribed import ForceTable
from symdyn.transcription.grid import Row
from symdyn.transcription.nonlinear_program import NonlinearProgram
from symdyn.transcription.phased import Passage, Phased
from symdyn.transcription.phases import Phase
from symdyn.transcription.transcribed import Collocation
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class Pieces(ForceTable):
    """A polynomial in each interval, through the values at the stages; t are the ends of the intervals.

    Attributes:
        c: stages within an interval, 0 … 1.
        values: at the stages, shape (N, s).
    """

    c: Row = ()
    values: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @cached_property
    def _curve(self) -> Callable[[Array], Array]:
        from scipy.interpolate import PPoly

        powers = np.vander([float(x) for x in self.c])  # highest first, as PPoly has them
        widths = np.diff(self.t)
        found: Callable[[Array], Array] = PPoly(
            np.linalg.solve(powers, self.values.T) / widths ** np.arange(len(self.c))[::-1, None], self.t
        )
        return found


def _each(problem: NonlinearProgram, z: Array) -> Iterator[tuple[Collocation, Array, float, float]]:
    """Yield the problem of each phase, its unknowns, when it begins and how long it takes, s."""
    began = 0.0
    for one, part in zip(problem.parts, problem.split(z), strict=True):
        yield one, part, began, one.time(part)
        began += one.time(part)


def forces_of(problem: NonlinearProgram, z: Array) -> Forces:
    """Return the driving forces over time, see `Solution.forces`."""
    first, t, values = problem.parts[0], list[Array](), list[Array]()
    alone = len(first.method.c) == 1
    for one, part, began, takes in _each(problem, z):
        at = began + takes * one.grid.share[one.grid.stage if alone else one.grid.node]
        t.append(at if alone or one.last else at[:-1])
        found = part[one.place["force"]]
        values.append(found if alone else found[one.grid.of])
    times, every = np.concatenate(t), np.concatenate(values)
    tables = [
        ForceTable(times, every[:, k]) if alone else Pieces(times, np.zeros(len(times)), first.method.c, every[..., k])
        for k in range(len(first.driven))
    ]
    return Forces(tables=dict(zip(first.driven, tables, strict=True)))


def phases_of(scene: Scene, problem: NonlinearProgram, z: Array) -> tuple[Trajectory, ...]:
    """Return the motion of each phase, with columns of contacts as runs have them."""
    found = []
    for one, part, began, takes in _each(problem, z):
        t, at, place = began + takes * one.grid.share, began + takes * one.grid.share[one.grid.stage], one.place
        stages = np.concatenate([part[place["a"]], _driving(one, part), part[place["contact"]]], axis=1)
        n, contacts = len(scene.velocities), one.source.written.contacts
        columns = np.stack([np.interp(t, at, x) for x in stages.T], axis=1)
        a, tau, given, pushed = np.split(columns, [n, 2 * n, columns.shape[1] - len(contacts.forces)], axis=1)
        q, s, u = (part[place[kind]] for kind in ("q", "s", "u"))
        extra = dict(zip((x.name for x in scene.given), np.hstack([given, s]).T, strict=True))
        gaps, forces = iter(_gaps(one, q, part)), iter(pushed.T)
        for touch, (closed, _, slip) in zip(contacts.touches, one.mode.reshape(-1, 3), strict=True):
            name, along = touch.law.name, len(touch.tangents)
            if touch.normal:
                extra |= {f"gap_{name}": next(gaps), f"normal_{name}": next(forces)}
            extra |= {f"{word}_{name}": next(forces) for word in (("friction",) if along == 1 else FRICTIONS[:along])}
            extra[f"mode_{name}"] = np.full(len(t), 2.0 * slip if slip else closed)
        found.append(Trajectory(scene, t, q, u, a, tau, extra))
    return tuple(found)


def _gaps(one: Collocation, q: Array, part: Array) -> Array:
    """Return g of every contact that has one, shape (gaps, P)."""
    told = one.source.locals.get("touch")
    return np.zeros((0, len(q))) if told is None else told.value({"q": q, "free": part[one.place["free"]]}).T


def _driving(problem: Collocation, z: Array) -> Array:
    """Return all driving forces at the stages, those of prescribed motions as well, and inputs, shape (S, …)."""
    count = len(problem.scene.velocities) + len(problem.scene.inputs)
    found = np.zeros((len(problem.grid.stage), count))
    found[:, list(problem.driven)] = z[problem.place["force"]]
    led = problem.scene.prescribed_velocities
    if led:
        found[:, list(led)] = z[problem.place["multiplier"]][:, -len(led) :]
    return found


def run_of(
    scene: Scene, problem: NonlinearProgram, z: Array, phases: Sequence[Trajectory], status: str, wall: float
) -> Trajectory:
    """Return the whole motion."""
    q, u, a, tau = (np.concatenate([getattr(one, name) for one in phases]) for name in ("q", "qd", "qdd", "tau"))
    extra = {name: np.concatenate([one.extra[name] for one in phases]) for name in phases[0].extra}
    t = np.concatenate([one.t for one in phases])
    curves = dict(zip(problem.parts[0].drives, forces_of(problem, z).tables.values(), strict=True))
    told = {"notes": (*problem.notes, status), "wall": wall, "curves": curves, "impacts": impacts_of(problem, z)}
    return Trajectory(scene, t, q, u, a, tau, extra, **told)


def impacts_of(problem: NonlinearProgram, z: Array) -> tuple[Impact, ...]:
    """Return what happens at contacts between phases, in order."""
    if not isinstance(problem, Phased):
        return ()
    ends = [began + takes for _, _, began, takes in _each(problem, z)]
    between = zip(ends, problem.passages, problem.schedule, problem.schedule[1:], strict=False)
    return tuple(told for t, passage, *sides in between for told in _between(problem, z, t, passage, *sides))


def _between(problem: Phased, z: Array, t: float, passage: Passage, one: Phase, then: Phase) -> Iterator[Impact]:
    written, at = problem.parts[0].source.written, passage.at(z)
    alone = np.zeros((at["impulse"].shape[1], 3))
    alone[:, 0] = 1.0  # so that the law tells W u
    law, kicks = problem.joining["law"].value, at["impulse"][0]
    before, after = (law({**at, "u": at[kind], "law": alone.ravel()})[0] for kind in ("before", "u"))
    lost, k = float(-kicks @ (before + after)) / 2, written.rows
    words = tuple(then.word(x.law.name, bool(x.tangents)) for x in written.contacts.touches)
    for touch in written.contacts.touches:
        name, rows = touch.law.name, slice(k, k + len(touch.rows))
        k += len(touch.rows)
        (closed, stuck, _), (closes, sticks, slip) = one.mode(name), then.mode(name)
        what = STRIKES if name in then.strikes or closes > closed else LIFTS if closed > closes else ""
        what = what or (BREAKS if stuck and slip else STOPS if sticks > stuck else "")
        if what:
            rates = (float(before[rows][0]), float(after[rows][0])) if touch.normal else (0.0, 0.0)
            yield Impact(t, name, what, *rates, tuple(kicks[rows].tolist()), lost, words, None, touch.unit)
