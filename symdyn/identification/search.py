"""The search of output error: weighted residuals over all pieces, their Jacobian, and Levenberg-Marquardt over both.

Columns of a log that output error takes: times, some coordinates and velocities, forces; and where a run starts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import IdentifyError, SimulateError
from symdyn.identification.shooting import FORGETS, Shooting, ShootingRun
from symdyn.scene import Scene
from symdyn.scene.values import Faults, listed, suggestion, velocity_name
from symdyn.simulation import Forces, Problem
from symdyn.simulation.prescribed import Columns, Entries, drive_names, read_entries

FEWEST = 10
"""Samples that a piece has at least."""

FIRST = 12
"""Samples, at most, through which a line or a parabola guesses where a piece starts."""


@dataclass(frozen=True)
class Measured:
    """A piece of a log.

    Attributes:
        t: times, s, shape (N,).
        x: what was measured, shape (N, m).
        forces: what drives the mechanism.
    """

    t: Array
    x: Array
    forces: Forces


def read_measured(
    problem: Problem, data: Entries, measured: Sequence[str] | None, pieces: int
) -> tuple[tuple[str, ...], tuple[Measured, ...], tuple[str, ...]]:
    """Return the names of the columns that are fitted, the pieces of all logs, and notes.

    Args:
        problem: the mechanism, and what is known of driving forces beside the columns of the logs.
        data: files, arrays by name or tables, one a log.
        measured: names of the columns that are fitted; None for all coordinates and velocities that the logs have.
        pieces: into how many pieces, of a start each, every log is cut.

    Raises:
        SimulateError: with every fault, one line each.
    """
    scene, forces, faults = problem.scene, problem.forces, Faults("")
    known = (*scene.coordinates, *scene.velocities)
    if isinstance(forces, Forces):
        raise SimulateError("forces: logs give some of them; give the others as text or by name, not read")
    logs = [data] if not isinstance(data, (list, tuple)) else data
    tables = list[Columns]()
    for one in logs:
        said = read_entries(one, "data", faults, (*known, *drive_names(scene), *(given.name for given in scene.inputs)))
        tables += said.tables
        if said.texts or said.functions:
            faults.add("data", "formulas and functions measure nothing; give a .csv file, arrays by name, or a table")
    if not tables and not faults.lines:
        faults.add("data", "there is no log; give a .csv file, arrays by name with t, or a table")
    faults.close(SimulateError)
    for name in measured or ():
        if name not in known:
            faults.add("measured", f"{name} is no coordinate or velocity; {suggestion(name, known)}")
    here = [name for name in known if all(name in one.values for one in tables)]
    names = tuple(here if measured is None else dict.fromkeys(measured))
    for one in tables:
        lost = [name for name in names if name not in one.values]
        there = f"it has {listed(tuple(one.values))}" if one.values else "it has none beside t"
        if lost or not names:
            what = f"the column {lost[0]}" if lost else f"column of {listed(known)} that all logs have"
            faults.add(one.source, f"has no {what.removeprefix('the ')}; {there}")
        if len(one.t) < FEWEST * pieces:
            faults.add(one.source, f"has {len(one.t)} rows; {FEWEST} a piece, {FEWEST * pieces} at least, are needed")
    if pieces < 1:
        faults.add("pieces", f"{pieces} is no number of pieces; give 1 or more")
    faults.close(SimulateError)
    found, notes = list[Measured](), dict[str, None]()
    for one in tables:
        drives = [name for name, drive in zip(drive_names(scene), scene.drives, strict=True) if drive]
        drives += [letter.name for letter in scene.inputs]
        columns = {name: one.values[name] for name in drives if name in one.values}
        given = Forces()
        with faults.noted():
            entries = [*forces] if isinstance(forces, list | tuple) else [forces]
            entries += [{TIME: one.t, **columns}] if columns else []
            given = replace(problem, forces=entries).driving
        silent = [name for k, name in enumerate(drives) if name not in columns and k not in given.formulas]
        if silent and "forces" not in problem.given:
            notes[f"{one.source}: no column of {listed(silent)}, which is taken as zero"] = None
        for part in np.array_split(np.arange(len(one.t)), pieces):
            x = np.column_stack([one.values[name][part] for name in names])
            found.append(Measured(one.t[part], x, given))
    faults.close(SimulateError)
    return names, tuple(found), tuple(notes)


def first_state(
    scene: Scene, names: Sequence[str], piece: Measured, guess: tuple[dict[str, Any], dict[str, Any]]
) -> tuple[Array, tuple[str, ...]]:
    """Return a guess of the state at the first sample, shape (nx,), and notes.

    What is measured is read off the first samples, positions' rates too; the rest is as the user says, or the scene.

    Raises:
        SimulateError: with every fault, one line each.
    """
    count = min(FIRST, len(piece.t))
    s = piece.t[:count] - piece.t[0]
    start, rates = dict[str, Any](), dict[str, Any]()
    for name, x in zip(names, piece.x[:count].T, strict=True):
        parts = np.polynomial.polynomial.polyfit(s / s[-1], x, min(2, count - 1))
        if name in scene.coordinates:
            start[name] = float(parts[0])
            rate = velocity_name(name)
            if rate in scene.velocities and rate not in names:
                rates[rate] = float(parts[1] / s[-1])
        else:
            rates[name] = float(parts[0])
    found = Problem(scene, (), start | guess[0], rates | guess[1]).initial
    return np.concatenate([found.q, found.u]), found.notes


PARTS = (0.125, 0.25, 0.5, 1.0)
"""Of each piece, what a search looks at, one after the other."""

LOOSE = 1e-2
"""Weight of values before, relative, in searches that look at a part: what a part does not tell does not wander off."""

ROUNDS = 4
"""Searches over everything; before each, weights are those of the residuals before."""

SETTLED = 0.02
"""Relative change of weights after which no other search is needed."""

MOST_RUNS = 60
"""Runs that one search takes."""


@dataclass
class Search:
    """Residuals and their Jacobian over the unknowns: parameters over their sizes, then moves of every start."""

    pieces: list[Shooting]
    data: Sequence[Measured]
    columns: list[int]
    parameters: tuple[str, ...]
    sizes: Array
    before: Array
    starts: int
    sigma: Array
    floor: Array
    loose: float = 0.0
    runs: int = 0
    _at: bytes = b""
    _runs: list[ShootingRun | None] = field(default_factory=list)

    def values(self, unknowns: Array) -> dict[str, float]:
        """Return parameters by name."""
        return dict(zip(self.parameters, (unknowns * self._scale)[: len(self.parameters)].tolist(), strict=True))

    @property
    def _scale(self) -> Array:
        return np.concatenate([self.sizes, np.ones(self.starts * len(self.pieces))])

    def moves(self, unknowns: Array, piece: int) -> Array:
        """Return the moves of the start of a piece."""
        first = len(self.parameters) + piece * self.starts
        return unknowns[first : first + self.starts]

    def run(self, unknowns: Array) -> list[ShootingRun | None]:
        """Return the runs of all pieces; the last ones are kept."""
        if self._at != unknowns.tobytes():
            values = self.values(unknowns)
            self._runs = [one.run(values, self.moves(unknowns, k)) for k, one in enumerate(self.pieces)]
            self._at, self.runs = unknowns.tobytes(), self.runs + len(self.pieces)
        return self._runs

    def forget(self) -> None:
        """Forget the last runs: pieces or what weighs have changed."""
        self._at = b""

    def missed(self, unknowns: Array) -> list[Array]:
        """Return simulated less measured by piece, shape (N, m); infinite where there is no run."""
        found: list[Array] = []
        for one, data in zip(self.run(unknowns), self.data, strict=True):
            x = data.x[: len(self.pieces[len(found)].t)]
            found.append(np.full(x.shape, np.inf) if one is None else one.x[:, self.columns] - x)
        return found

    def residuals(self, unknowns: Array) -> Array:
        """Return weighted residuals, and how far parameters are from before."""
        rows = np.concatenate([(one / self.sigma).ravel() for one in self.missed(unknowns)])
        return np.concatenate([rows, self.loose * (unknowns - self.before)])

    def jacobian(self, unknowns: Array) -> Array:
        """Return the derivative of the residuals."""
        n, blocks = len(self.parameters), []
        for k, one in enumerate(self.run(unknowns)):
            assert one is not None, "a search stays where there are runs"
            S = one.S[:, :, self.columns] / self.sigma
            block = np.zeros((S.shape[0] * S.shape[2], len(unknowns)))
            block[:, :n] = S[:, self.starts : self.starts + n].transpose(0, 2, 1).reshape(-1, n) * self.sizes
            first = n + k * self.starts
            block[:, first : first + self.starts] = S[:, : self.starts].transpose(0, 2, 1).reshape(-1, self.starts)
            blocks.append(block)
        return np.vstack([*blocks, self.loose * np.eye(len(unknowns))])


def searched(search: Search, least: Array) -> Array:
    """Return the unknowns that fit all samples best, none below its least value; the search is left at them.

    Raises:
        IdentifyError: there is no run, or the motion forgets its start.
    """
    whole, unknowns = list(search.pieces), search.before
    for part in PARTS:
        counts = [max(min(FEWEST, len(one.t)), round(part * len(one.t))) for one in whole]
        values = search.values(unknowns)
        search.pieces = [
            replace(one, steps=before.steps).until(count).refined(values, search.moves(unknowns, k))
            for k, (one, before, count) in enumerate(zip(whole, search.pieces, counts, strict=True))
        ]
        search.loose = LOOSE if part < 1 else 0.0
        for _ in range(ROUNDS if part == 1 else 1):
            unknowns = _best(search, unknowns, least)
            scatter = np.sqrt(np.mean(np.concatenate(search.missed(unknowns)) ** 2, axis=0))
            before, search.sigma = search.sigma, np.maximum(scatter, search.floor)
            if np.all(np.abs(search.sigma - before) <= SETTLED * before):
                break
    return unknowns


def _best(search: Search, unknowns: Array, least: Array) -> Array:
    """Return what one search finds."""
    from scipy.optimize import least_squares

    search.forget()
    grown = max(piece.grown(run) for piece, run in zip(search.pieces, search.run(unknowns), strict=True))
    if None in search.run(unknowns):
        raise IdentifyError("a run ends before the log does at the values that the search begins with; give other ones")
    if grown > FORGETS:
        raise IdentifyError(
            f"a change of the start grows {grown:.1g} times until the end of a piece: the motion forgets its start, "
            "and no search finds the run again; cut the log into pieces with a start of their own (pieces=4, or more)"
        )
    found = least_squares(
        search.residuals, unknowns, search.jacobian, bounds=(least, np.inf), x_scale="jac", xtol=1e-10, ftol=1e-12,
        gtol=1e-12, max_nfev=MOST_RUNS,
    )  # fmt: skip
    return np.asarray(found.x, dtype=np.float64)
