"""Output error: runs over the samples of a log, how these depend on starts and parameters, and the search over both.

    ẋ = f(t, x, p)        Ṡ = ∂f/∂x S + ∂f/∂p        classical Runge-Kutta, m steps between two samples

Steps stand on the samples, where tables of forces have their corners. What is differentiated is the map that was
computed, its steps as they are: a search sees one function and its own derivative. A closed mechanism is brought back
to its loops at every sample. Columns of a log may be times, some coordinates, velocities and states, and forces;
weighted residuals of all its pieces, and their Jacobian, go to Levenberg and Marquardt's method.

Reference: Bock, Numerical treatment of inverse problems in chemical reaction kinetics (1981).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import IdentifyError, SimulateError, SymdynError, listed, suggestion
from symdyn.frozen import dataclass, field, replace
from symdyn.scene import Scene, with_values
from symdyn.scene.values import Faults, velocity_name
from symdyn.simulation import Flow, Forces, Problem
from symdyn.simulation.prescribed import Columns, Entries, drive_names, read_entries

MOST_STEPS = 512
"""Steps between two samples beyond which a motion is too fast for them."""

CLOSE = 1e-5
"""By which part of their range coordinates may differ between m and 2 m steps."""

FORGETS = 1e6
"""A move of a start that grows by more than this is lost in rounding and noise."""

CLOSINGS, CLOSED = 8, 1e-10
"""Newton steps that close the loops at a start, and the coordinate by which the last of them may move it."""

Nodes = tuple[float, Array, Array, Array]
"""Length of a step, and what tables give at its beginning, middle and end."""


@dataclass(frozen=True)
class ShootingRun:
    """A run at the samples.

    Attributes:
        x: states, shape (N, nx).
        S: their derivatives by independent positions and velocities of the start, then parameters, shape (N, k, nx).
    """

    x: Array
    S: Array


@dataclass(frozen=True)
class Shooting:
    """One piece of a log, ready to be run at any values."""

    scene: Scene  # the mechanism, its parameters bound
    parameters: tuple[str, ...]  # names of those that are varied
    forces: Forces  # what drives it
    t: Array  # times of the samples, s, shape (N,)
    start: Array  # state that moves of the start are counted from, shape (nx,)
    chosen: tuple[list[int], list[int]]  # independent positions and velocities
    steps: int  # between two samples
    nodes: tuple[tuple[Nodes, ...], ...]  # steps with what tables give at them, shape (N - 1, steps)

    def along(self, values: Mapping[str, float]) -> Flow:
        """Return the flow at values of the parameters.

        Raises:
            SymdynError: values that the scene cannot have.
        """
        scene = with_values(self.scene, values) if values else self.scene
        return Flow.of(scene, self.forces, self.start[: len(scene.coordinates)], self.parameters)

    def grown(self, run: ShootingRun | None) -> float:
        """Return how many times moves of the start have grown until the end of a run."""
        count = len(self.chosen[0]) + len(self.chosen[1])
        return 0.0 if run is None else float(np.abs(run.S[-1, :count]).max())

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the independent positions and velocities of the start."""
        along = self.along({})
        return along.starting(self.start, self.chosen)[2][: -len(self.parameters) or None]

    def run(self, values: Mapping[str, float], moves: Array) -> ShootingRun | None:
        """Return the run at values of the parameters, its start moved by independent positions and velocities.

        None where there is none: values that the scene cannot have, loops that do not close, a state without a value.
        """
        try:
            with np.errstate(all="ignore"):
                along = self.along(values)
                x = self._moved(along, moves)
                ways, changes, _ = along.starting(x, self.chosen)
                return self._followed(along, x, ways, changes)
        except (SymdynError, np.linalg.LinAlgError):
            return None

    def _moved(self, along: Flow, moves: Array) -> Array:
        system, nq = along.system, along.system.nq
        ways, _, _ = along.starting(self.start, self.chosen)
        x = self.start + moves @ ways[: len(moves)]
        for part in system.quaternions:
            x[part] /= np.linalg.norm(x[part])
        if system.closed and not system.linear:
            for _ in range(CLOSINGS):
                before = x
                x = np.concatenate(system.on_manifold(x[:nq], x[nq:]))
                if np.abs(x - before).max() < CLOSED:
                    return x
            raise IdentifyError("the loops do not close")
        return x

    def _followed(self, along: Flow, x: Array, ways: Array, changes: Array) -> ShootingRun | None:
        system, nq = along.system, along.system.nq
        xs, S = np.empty((len(self.t), len(x))), np.empty((len(self.t), *ways.shape))
        xs[0], S[0] = x, ways
        for k, nodes in enumerate(self.nodes):
            t = float(self.t[k])
            for h, *given in nodes:
                x, ways = _step(along, (t, h), x, (ways, changes), given)
                t += h
            if not np.all(np.isfinite(x)):
                return None
            if system.closed and not system.linear:
                x = np.concatenate(system.on_manifold(x[:nq], x[nq:]))
            xs[k + 1], S[k + 1] = x, ways
        return ShootingRun(xs, S) if np.all(np.isfinite(S)) else None

    def until(self, count: int) -> Shooting:
        """Return the first samples alone."""
        return replace(self, t=self.t[:count], nodes=self.nodes[: count - 1])

    def refined(self, values: Mapping[str, float], moves: Array) -> Shooting:
        """Return it with as many steps between samples as the run needs; IdentifyError where no number is enough."""
        here, coarse = self, self.run(values, moves)
        while here.steps < MOST_STEPS:
            finer = with_steps(here, 2 * here.steps)
            fine = finer.run(values, moves)
            if fine is not None and coarse is not None:
                size = np.ptp(fine.x, axis=0) + 1e-3
                if np.all(np.abs(fine.x - coarse.x) <= CLOSE * size) or self.grown(fine) > FORGETS:
                    return here
            here, coarse = finer, fine
        raise IdentifyError(
            f"{self.scene.name}: {MOST_STEPS} steps between two samples do not follow the motion, too fast, stiff or "
            "without a value: give other values or starts, more samples a second, or a wider smoothing, which moves "
            "what is found"
        )


def shooting(scene: Scene, parameters: tuple[str, ...], forces: Forces, t: Array, start: Array) -> Shooting:
    """Return one piece of a log, ready to be run; SimulateError where a force jumps, or a parameter has no slope."""
    along = Flow.of(scene, forces, start[: len(scene.coordinates)], parameters, smooth=True)
    return with_steps(Shooting(scene, parameters, forces, t, start, along.independent(), 1, ()), 1)


def with_steps(piece: Shooting, steps: int) -> Shooting:
    """Return a piece with another number of steps between samples."""
    size = len(piece.scene.velocities) + len(piece.scene.inputs)
    h = np.repeat(np.diff(piece.t) / steps, steps)
    begin = (piece.t[:-1, None] + np.diff(piece.t)[:, None] * np.arange(steps) / steps).ravel()
    tables = [piece.forces.tabulated(begin + part * h, size) for part in (0.0, 0.5, 1.0)]
    each = list(zip(h.tolist(), *tables, strict=True))
    nodes = tuple(tuple(each[k : k + steps]) for k in range(0, len(each), steps))
    return replace(piece, steps=steps, nodes=nodes)


def _step(
    along: Flow, time: tuple[float, float], x: Array, tangent: tuple[Array, Array], given: list[Array]
) -> tuple[Array, Array]:
    """Return the state and its tangents after one step of the classical Runge-Kutta method."""
    (t, h), (S, changes) = time, tangent
    k1, d1 = along.both(t, x, given[0], S, changes)
    k2, d2 = along.both(t + h / 2, x + h / 2 * k1, given[1], S + h / 2 * d1, changes)
    k3, d3 = along.both(t + h / 2, x + h / 2 * k2, given[1], S + h / 2 * d2, changes)
    k4, d4 = along.both(t + h, x + h * k3, given[2], S + h * d3, changes)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), S + h / 6 * (d1 + 2 * d2 + 2 * d3 + d4)


FEWEST = 10
"""Samples that a piece has at least."""

FIRST = 12
"""Samples, at most, through which a line or a parabola guesses where a piece starts."""


@dataclass(frozen=True)
class Measured:
    """A piece of a log."""

    t: Array  # times, s, shape (N,)
    x: Array  # what was measured, shape (N, m)
    forces: Forces  # what drives the mechanism


def read_measured(
    problem: Problem, data: Entries, measured: Sequence[str] | None, pieces: int
) -> tuple[tuple[str, ...], tuple[Measured, ...], tuple[str, ...]]:
    """Return the names of the columns that are fitted, the pieces of all logs, and notes; SimulateError of every fault.

    Where nothing is `measured`, all coordinates and velocities are that the logs have; each log is cut into `pieces`.
    """
    scene, forces, faults = problem.scene, problem.forces, Faults("")
    scene.refuse_contacts("output error", SimulateError)
    if jumping := [one.name for one in scene.states if one.reset is not None]:
        told = f"output error knows no states that jump, and there is {listed(jumping)}; take the resets out"
        raise SimulateError(f"{scene.name}: {told}")
    known = (*scene.coordinates, *scene.first_order)
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
            what = "coordinate, velocity or state" if scene.states else "coordinate or velocity"
            faults.add("measured", f"{name} is no {what}; {suggestion(name, known)}")
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
    """Return a guess of the state at the first sample, shape (nx,), and notes; SimulateError of every fault.

    What is measured is read off the first samples, positions' rates too; the rest is as the user says, or the scene.
    """
    count = min(FIRST, len(piece.t))
    s = piece.t[:count] - piece.t[0]
    start, rates = dict[str, Any](), dict[str, Any]()
    for name, x in zip(names, piece.x[:count].T, strict=True):
        parts = np.polynomial.polynomial.polyfit(s / s[-1], x, min(2, count - 1))
        if name not in scene.velocities:
            start[name] = float(parts[0])
            rate = velocity_name(name)
            if rate in scene.velocities and rate not in names:
                rates[rate] = float(parts[1] / s[-1])
        else:
            rates[name] = float(parts[0])
    found = Problem(scene, (), start | guess[0], rates | guess[1]).initial
    return np.concatenate([found.q, found.moving]), found.notes


PARTS = (0.125, 0.25, 0.5, 1.0)
"""Of each piece, what a search looks at, one after the other."""

LOOSE = 1e-2
"""Weight of values before, relative, in searches that look at a part: what it does not identify does not wander off."""

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
    settled: bool = True  # whether the last search ended at a minimum, not at its last run
    look: Callable[[int], object] = abs
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
            self.look(self.runs)
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
    """Return the unknowns that fit all samples best, none below its least value; the search is left at them."""
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
    limits: dict[str, Any] = {"xtol": 1e-10, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": MOST_RUNS}
    found = least_squares(search.residuals, unknowns, search.jacobian, (least, np.inf), x_scale="jac", **limits)
    search.settled = found.status > 0
    return np.asarray(found.x, dtype=np.float64)
