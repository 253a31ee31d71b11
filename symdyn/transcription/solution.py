"""What a solver found, as a motion and as forces, and what becomes of the mechanism under these forces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.rounding import in_digits
from symdyn.scene import Scene, bind
from symdyn.shown import Shown
from symdyn.simulation import Forces, Start, Trajectory, simulate
from symdyn.simulation.prescribed import ForceTable
from symdyn.transcription.tableaux import Row
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


def along(problem: Collocation, motion: Trajectory) -> Array:
    """Return z of a motion, shape (size,), by cubic splines between its samples; multipliers are those that fit best.

    Slacks are zero, and parameters as the scene has them. Samples at the problem's points stay as they are.
    """
    from scipy.interpolate import CubicSpline

    z, place, grid = problem.guess.copy(), problem.place, problem.grid
    z[place["T"]] = np.clip(motion.t[-1], problem.lower[place["T"]], problem.upper[place["T"]])
    duration = problem.time(z)
    t = duration * grid.share
    for kind, values, points in (("q", motion.q, t), ("u", motion.qd, t), ("a", motion.qdd, t[grid.stage])):
        z[place[kind]] = CubicSpline(motion.t, values)(points)
    z[place["force"]] = CubicSpline(motion.t, motion.tau[:, list(problem.driven)])(t[grid.stage])
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

    @property
    def optima(self) -> tuple[Solution, ...]:
        """All optima that were found, this one and the others, best first."""
        return tuple(sorted((self, *self.others), key=lambda one: one.objective))

    @property
    def notes(self) -> tuple[str, ...]:
        """What a user should know: of the problem, and what was searched, where that is known."""
        known = self.searched.led or self.searched.failed
        return (*self.problem.notes, *([str(self.searched)] if known else []))

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
        return bind(self.problem.scene, self.parameters) if self.problem.free else self.problem.scene

    @property
    def motion(self) -> Trajectory:
        """The motion at all points; accelerations and forces of others than stages lie in between."""
        problem, grid = self.problem, self.problem.grid
        t, at = self.duration * grid.share, self.duration * grid.share[grid.stage]
        stages = np.concatenate([self.z[problem.place["a"]], self._forces()], axis=1)
        a, tau = np.split(np.stack([np.interp(t, at, x) for x in stages.T], axis=1), 2, axis=1)
        q, u = self.z[problem.place["q"]], self.z[problem.place["u"]]
        return Trajectory(self.scene, t, q, u, a, tau, notes=(*problem.notes, self.status), wall=self.wall)

    @property
    def forces(self) -> Forces:
        """The driving forces over time, for `simulate`: a polynomial through the stages of each interval.

        Where an interval has one stage alone, as in the midpoint rule, a smooth curve goes through those of all.
        """
        problem, grid = self.problem, self.problem.grid
        values = self.z[problem.place["force"]]
        if len(problem.method.c) == 1:
            t = self.duration * grid.share[grid.stage]
            return Forces(tables={k: ForceTable(t, x) for k, x in zip(problem.driven, values.T, strict=True)})
        t = self.duration * grid.share[grid.node]
        tables = [Pieces(t, np.zeros(len(t)), problem.method.c, x[grid.of]) for x in values.T]
        return Forces(tables=dict(zip(problem.driven, tables, strict=True)))

    def simulated(self, **options: Any) -> Trajectory:
        """Return the motion that the forces give, from the same start; `options` are those of `simulate`.

        It may rest on limits of joints, and goes on where rounding passes one.
        """
        place = self.problem.place
        start = Start(self.z[place["q"][0]], self.z[place["u"][0]])
        options = {"ignore_limits": True} | options
        return simulate(self.scene, forces=self.forces, until=self.duration, start=start, **options)

    def _forces(self) -> Array:
        """Return all driving forces at the stages, those of prescribed motions as well, shape (S, nv)."""
        problem = self.problem
        found = np.zeros(problem.place["a"].shape)
        found[:, list(problem.driven)] = self.z[problem.place["force"]]
        led = problem.scene.led_velocities
        if led:
            found[:, list(led)] = self.z[problem.place["multiplier"]][:, -len(led) :]
        return found
