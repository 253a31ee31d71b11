"""What a solver found, as a motion and as forces, what these forces make of the mechanism, and second derivatives.

The Hessian of σ f(z) + λᵀ g(z) is for solvers that take Newton's steps:

    Φ        w · (entries of a local function), a number for every place; w are multipliers, and weights of defects
    bends    ∂²Φ/∂x_i∂x_j that are not zero, j <= i, at every place: again one compiled function for all

Between places the defects are linear in everything but the time of the end, T: what an interval's length multiplies
gives the column of T.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.arguments import suggesting
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import SimulateError, listed, quoted
from symdyn.frozen import dataclass, field
from symdyn.graph import gradient, tangents
from symdyn.rounding import in_digits
from symdyn.scene import Scene, with_values
from symdyn.shown import Shown
from symdyn.simulation import Forces, Impact, Start, Trajectory, compiled_entries, simulate
from symdyn.transcription.grid import ROWWISE, Places
from symdyn.transcription.local import PLACES, Source, appearing, argument_of, inputs_of, symbols_of
from symdyn.transcription.motion import forces_of, impacts_of, missed, passed, phases_of, run_of
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symdyn.simulation import Feedback
    from symdyn.transcription.transcribed import Collocation

Weighing = Mapping[str, float] | Sequence[float] | float | Array | None
"""A weight of states or of drives, as of `lqr`."""


@suggesting
def along(problem: Collocation, motion: Trajectory) -> Array:
    """Return z of a motion, shape (size,), by cubic splines between its samples; multipliers are those that fit best.

    Slacks are zero, and parameters as the scene has them. Samples at the problem's points stay as they are.

    Raises:
        SimulateError: the problem has phases, whose velocities jump.
    """
    if len(problem.schedule) > 1:
        told = "give the z of a solution with as many intervals: solve(guess=found.z)"
        raise SimulateError(f"{problem.scene.name}: no smooth curve goes through impacts between phases; {told}")
    from scipy.interpolate import CubicSpline

    z, place, grid = problem.guess.copy(), problem.place, problem.grid
    z[place["T"]] = np.clip(motion.t[-1], problem.lower[place["T"]], problem.upper[place["T"]])
    duration = problem.time(z)
    t = duration * grid.share
    forces = np.hstack([motion.tau, motion.inputs])[:, list(problem.driven)]
    for kind, values, points in (
        ("q", motion.q, t), ("s", motion.own_states, t), ("u", motion.qd, t),
        ("a", motion.qdd, t[grid.stage]), ("force", forces, t[grid.stage]),
    ):  # fmt: skip
        z[place[kind]] = CubicSpline(motion.t, values)(points)
    count = place["multiplier"].shape[1]
    z[place["slack"]] = z[place["multiplier"]] = 0.0
    if count:
        nv = place["a"].shape[1]
        miss, J = problem.residual(z)[problem.row["balance"][:, :nv]], problem.jacobian(z)
        for rows, columns, off in zip(problem.row["balance"][:, :nv], place["multiplier"], miss, strict=True):
            push = J[rows][:, columns].toarray()
            z[columns] = -np.linalg.lstsq(push, off, rcond=None)[0]
    return z


@dataclass(frozen=True)
class Searched:
    """What was searched, and what was found there.

    Attributes:
        starts: how many searches there were, the first from the guess.
        seed: of those that were drawn; None where none was.
        led: cost of each optimum that was found, best first, and how many starts led there.
        failed: what the solver said of the others, and of how many.
    """

    starts: int = 1
    seed: int | None = None
    led: tuple[tuple[float, int], ...] = ()
    failed: tuple[tuple[str, int], ...] = ()

    def __str__(self) -> str:
        """Return it in words, one line."""
        drawn = f" (the guess, and {self.starts - 1} drawn by seed {self.seed})" if self.starts > 1 else ""
        searched = f"searched from {self.starts} start{'s' * (self.starts > 1)}{drawn}"
        parts = [f"{in_digits(cost, 9)} ({count} start{'s' * (count > 1)})" for cost, count in self.led]
        what = f"{len(parts)} optim{'a' if len(parts) > 1 else 'um'} by the conditions of first order"
        optima = f"{what}: {', '.join(parts)}" if parts else "no optimum"
        ended = "".join(f"; {count} ended with {status}" for status, count in self.failed)
        more = "; another start may find a better one: starts=8" if self.starts == 1 else "; there may be better ones"
        return f"{searched}: {optima}{ended}{more}"


@dataclass(frozen=True, eq=False)
class Solution(Shown):
    """A point that a solver ended at: where conditions of first order hold, a local optimum at best.

    Attributes:
        problem: what was solved.
        z: the unknowns, shape (size,).
        multipliers: of the equations, shape (rows,): f falls by so much a unit by which one is let go.
        objective: f(z).
        violation: largest miss of a bound or an equation.
        success: whether the solver says that it is optimal.
        status: what the solver says.
        iterations: of the solver.
        wall: seconds that it took.
        others: further optima that other starts led to, best first.
        searched: how many starts, which, and what they led to.
    """

    problem: Collocation = field(repr=False)
    z: Array = field(repr=False)
    multipliers: Array = field(repr=False)
    objective: float
    violation: float
    success: bool
    status: str
    iterations: int
    wall: float
    others: tuple[Solution, ...] = field(default=(), repr=False)
    searched: Searched = Searched()

    def __repr__(self) -> str:
        found = f"{in_digits(self.objective, 9)}, {self.status} after {self.iterations} iterations"
        left = f"; not given at the end: {listed(self.problem.ends[1])}" if self.problem.ends[1] else ""
        others = f"; {len(self.optima)} optima from {self.searched.starts} starts" if self.others else ""
        cost = "".join(f"; {one}" for one in self.problem.notes if one.startswith("no cost"))
        return f"<Solution of {self.problem.scene.name}: {found}{cost}{others}{left}>"

    def __getitem__(self, name: str | Sequence[str]) -> Array:
        """Return a column of its run, or several; errors as there."""
        return self.run[name]

    def __call__(self, t: object) -> NoReturn:
        """Raise SimulateError: what is between its points is for a simulation to tell."""
        raise SimulateError(f".run has numbers at .run.t; .simulated()({quoted(t)}) is the motion at any time")

    @property
    def optima(self) -> tuple[Solution, ...]:
        """All optima that were found, this one and the others, best first."""
        return tuple(sorted((self, *self.others), key=lambda one: one.objective))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What a user should know: of the problem, of contacts, what its forces miss, and what was searched."""
        touches, known = self.problem.source.written.contacts.touches, self.searched.led or self.searched.failed
        beyond = missed(self.problem, self.run, self.simulated()) if self.success and not touches else ()
        return (*self.problem.notes, *passed(self.problem, self.z), *beyond, *([str(self.searched)] if known else []))

    @property
    def duration(self) -> float:
        """The time of the end, s."""
        return self.problem.time(self.z)

    @property
    def parameters(self) -> dict[str, float]:
        """The values of the parameters that were unknowns."""
        return self.problem.parameters(self.z)

    @property
    def scene(self) -> Scene:
        """The mechanism with these values."""
        return with_values(self.problem.scene, self.parameters) if self.problem.free else self.problem.scene

    @property
    def run(self) -> Trajectory:
        """The motion at all points; accelerations and forces of others than stages lie in between.

        Where phases meet there are two rows, before and behind what happens there.
        """
        return run_of(self.scene, self.problem, self.z, (*self.problem.notes, self.status), self.wall)

    @property
    def phases(self) -> tuple[Trajectory, ...]:
        """The motion of each phase, which goes on where the one before ends; one alone without contacts."""
        return phases_of(self.run, self.problem)

    @property
    def impacts(self) -> tuple[Impact, ...]:
        """What happens at contacts where phases meet, in order, as runs tell it."""
        return impacts_of(self.problem, self.z)

    def plot(self, *names: str | Sequence[str | Sequence[str]], **options: Any) -> Figure:
        """Return a figure of the motion, all as of `Trajectory.plot`."""
        return self.run.plot(*names, **options)

    @property
    def forces(self) -> Forces:
        """The driving forces over time, for `simulate`: a polynomial through the stages of each interval.

        Where an interval has one stage alone, as in the midpoint rule, a smooth curve goes through those of all.
        """
        return forces_of(self.problem, self.z)

    def track(self, Q: Weighing = None, R: Weighing = None, end: Weighing = None) -> Feedback:
        """Return the controller that follows the motion: forces and gains over time, by the regulator along it.

        `symdyn.simulate(found.scene, until=1, start={"theta": 0.05}, feedback=found.track({"x": 10}, {"F": 0.1}))` runs
        the mechanism with it from another start.

        Args:
            Q: weight of states, as of `symdyn.linear.track`.
            R: of drives.
            end: of the deviation at the end.

        Raises:
            LinearizeError: with every fault of the weights.
        """
        from symdyn.linear import track  # late: most solutions are not followed

        return track(self.run, Q, R, end)

    def simulated(self, **options: Any) -> Trajectory:
        """Return the motion that the forces give, from the same start; `options` are those of `simulate`, before these.

        It may rest on limits of joints, and goes on where rounding passes one.
        """
        place = self.problem.place
        start = Start(self.z[place["q"][0]], self.z[place["u"][0]], s=self.z[place["s"][0]])
        usual: dict[str, Any] = {"forces": self.forces, "until": self.duration, "start": start, "ignore_limits": True}
        return simulate(self.scene, **usual | options)


WEIGHTS = "weights"

Pair = tuple[tuple[str, int], tuple[str, int]]


@dataclass(frozen=True)
class Bends:
    """Second derivatives of a local function, weighed.

    Attributes:
        pairs: the two unknowns of each, by kind and place in it.
        value: function of the unknowns by kind and of weights, shape (count, size), to (count, pairs).
    """

    pairs: tuple[Pair, ...]
    value: Callable[[Mapping[str, Array], Array], Array]


@dataclass(frozen=True, eq=False)
class Lagrangian:
    """The Hessian of a problem's Lagrangian, upper triangle.

    Attributes:
        problem: whose it is.
        rows, columns: of its entries, shape (nonzeros,), column by column; none occurs twice, rows <= columns.
    """

    problem: Collocation
    rows: Places
    columns: Places
    bends: Mapping[str, Bends] = field(repr=False)
    wires: Mapping[str, tuple[NDArray[np.bool_], Array]] = field(repr=False)
    merged: Places = field(repr=False)

    def __reduce__(self) -> tuple[Callable[[Collocation], Lagrangian], tuple[Collocation]]:
        """Return how it is made again."""
        return lagrangian, (self.problem,)

    def values(self, z: Array, sigma: float, multipliers: Array) -> Array:
        """Return the entries at z, shape (nonzeros,)."""
        parts = np.concatenate([np.zeros(0), *(np.ravel(part) for part in _parts(self, z, sigma, multipliers))])
        return np.asarray(np.bincount(self.merged, parts, len(self.rows)).astype(np.float64))


def lagrangian(problem: Collocation) -> Lagrangian:
    """Return the Hessian of a problem's Lagrangian as a function, compiled."""
    bends = _compiled(problem.source)
    wires: dict[str, tuple[NDArray[np.bool_], Array]] = {}
    places: list[tuple[Places, Places]] = []
    for name, one in bends.items():
        points = problem.points(PLACES[name])
        sides = [np.empty((len(points), len(one.pairs)), dtype=np.int64) for _ in range(2)]
        chain = np.ones(sides[0].shape)
        for k, pair in enumerate(one.pairs):
            for side, (kind, place) in zip(sides, pair, strict=True):
                side[:, k] = problem.column(kind, place, points)
                chain[:, k] *= problem.grid.share[points] if kind == TIME else 1.0
        known = (sides[0] >= 0) & (sides[1] >= 0)
        wires[name] = known, chain
        places.append((sides[0][known], sides[1][known]))
    T = problem.place["T"]
    if len(T):
        places += _beside_time(problem)
    pairs = [np.broadcast_arrays(*pair) for pair in places]
    first, second = (np.concatenate([pair[k].ravel() for pair in pairs] or [T]) for k in (0, 1))
    keys = np.maximum(first, second) * problem.size + np.minimum(first, second)
    unique, merged = np.unique(keys, return_inverse=True)
    columns, rows = np.divmod(unique, problem.size)
    return Lagrangian(problem, rows, columns, bends, wires, merged.ravel())


def _beside_time(problem: Collocation) -> list[tuple[Places, Places]]:
    """Return the unknowns that the length of an interval multiplies: at rates, accelerations and the running cost."""
    T = problem.place["T"][problem.stage_phases][:, None]
    found = [(T, problem.place["a"])]
    for columns, known, _ in (problem.wires[name] for name in ("rates", "running") if name in problem.locals):
        found.append((np.broadcast_to(T, columns.shape)[known], columns[known]))
    return found


def _parts(of: Lagrangian, z: Array, sigma: float, multipliers: Array) -> list[Array]:
    problem, grid = of.problem, of.problem.grid
    by_row = {kind: multipliers[row] for kind, row in problem.row.items()}
    defects, first = by_row["defects"], problem.locals["rates"].size  # of accelerations, behind what has a formula
    shares = -(problem.between[1].T @ defects.ravel()).reshape(len(grid.stage), -1)  # of what T multiplies
    T = problem.lasting(z, problem.stage_phases, 1)
    weights = {
        "rates": T * shares[:, :first],
        **{name: by_row[name] for name in ROWWISE},
        "pull": np.zeros((len(grid.node), defects.shape[2])),
        "running": sigma * T * grid.quadrature[:, None],
        "final": np.full((1, 1), sigma),
    }
    weights["pull"][grid.ends] = -defects[:, -1]
    at = {**{where: problem.at(z, where) for where in ("stage", "end")}, **problem.elsewhere(z)}
    found = []
    for name, one in of.bends.items():
        known, chain = of.wires[name]
        found.append((one.value(at[PLACES[name]], weights[name]) * chain)[known])
    if len(problem.place["T"]):
        found.append(shares[:, first:])
        for name, each in (("rates", shares), ("running", sigma * grid.quadrature[:, None])):
            if name in problem.locals:
                local, (columns, known, chain) = problem.locals[name], problem.wires[name]
                slopes = each[:, [i for i, _, _ in local.pattern]] * local.slopes(at["stage"]) * chain
                found.append(np.where(columns == problem.place["T"][0], 2.0, 1.0)[known] * slopes[known])
    return found


@lru_cache(maxsize=16)
def _compiled(source: Source) -> dict[str, Bends]:
    """Return the second derivatives of the local functions that are not linear."""
    w, written = source.workspace, source.written
    parts, pairs, takes = {}, {}, {}
    for name, entries in written.entries.items():
        if not entries:
            continue
        inputs = inputs_of(written, entries)
        symbols = [symbol for _, _, symbol in inputs]
        weights = argument_of(WEIGHTS, symbols_of(w, WEIGHTS, len(entries)))
        total = w.graph.dot(weights.symbols, entries)
        slopes = gradient(total, symbols)
        bent = {
            (i, j): value
            for j, x in enumerate(symbols)
            for i, value in enumerate(tangents(slopes[j:], {x: w.graph.one}), start=j)
            if not value.is_zero
        }
        if not bent:
            continue
        pairs[name] = tuple((inputs[i][:2], inputs[j][:2]) for i, j in bent)
        seen = appearing(bent.values())
        takes[name] = [kind for kind, those in written.kinds.items() if kind == "q" or not seen.isdisjoint(those)]
        known = [argument_of(kind, written.kinds[kind]) for kind in takes[name]]
        parts[f"{name}_bends"] = list(bent.values()), [*known, weights]
    calls = compiled_entries(w, parts)

    def caller(name: str) -> Callable[[Mapping[str, Array], Array], Array]:
        call, kinds = calls[f"{name}_bends"], takes[name]
        return lambda at, weights: np.asarray(call(*(at[kind] for kind in kinds), weights), dtype=np.float64)

    return {name: Bends(pairs[name], caller(name)) for name in pairs}
