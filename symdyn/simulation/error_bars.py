"""Error bars on motions and forces, to first order in what is uncertain, and their plots: bands of one and two sd.

Of a given motion, driving forces have their derivatives by parameters as an output of their own. Where the motion
itself moves with a parameter (a path that joints follow, a motion that the scene prescribes), and for other columns,
derivatives are differences of runs with the parameter on both sides of its value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import check_arguments
from symdyn.draw import FilledFigure
from symdyn.dynamics import LoopChoices, Workspace, derive_one
from symdyn.dynamics.mechanism import TIME
from symdyn.emit import write_file
from symdyn.errors import DerivationError, EmitError, SimulateError, UnknownNameError, choice, listed, quoted
from symdyn.frozen import dataclass, field, replace
from symdyn.runtime import lambdify
from symdyn.shown import Shown
from symdyn.simulation.columns import FORCES, Column, columns_csv, frame
from symdyn.simulation.equations.compiled_routines import opened
from symdyn.simulation.forward import simulate
from symdyn.simulation.inverse_run import inverse
from symdyn.simulation.panels import check_plot, chosen
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import SceneMotion, drive_names, read_motion
from symdyn.simulation.prescribed.point_path import read_path
from symdyn.simulation.problem import Problem, Run
from symdyn.simulation.trajectory import Trajectory
from symdyn.simulation.variations import UNTOLD, variations

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


DERIVATIVES = "inverse_dynamics_by_parameters"

STEP = 1e-5
"""Part of a parameter's size, or 1, by which it is moved to both sides."""


def force_slopes(
    run: Trajectory,
    reported: Callable[[Mapping[str, float]], Trajectory],
    motion: SceneMotion,
    plain: bool,
    columns: Sequence[str],
    names: Sequence[str],
) -> tuple[Array, tuple[str, ...]]:
    """Return derivatives of columns by parameters, shape (N, columns, k), and notes.

    Args:
        run: the motion at the means.
        reported: the same at other values of parameters.
        motion: its laws.
        plain: whether no path is followed.
        columns: of the run.
        names: of parameters.

    Raises:
        SimulateError: a parameter that decides the form of the equations.
    """
    drives = drive_names(run.scene)
    exact = _exact(run, motion, names) if plain else None
    found = np.zeros((len(run.t), len(columns), len(names)))
    beside = [name for name in columns if exact is None or name not in drives]
    for j, name in enumerate(columns):
        if name not in beside and exact is not None:
            found[:, j] = exact[:, drives.index(name)]
    if not beside:
        return found, ()
    values = opened(run.scene).values
    at = [columns.index(name) for name in beside]
    for k, name in enumerate(names):
        step = STEP * (abs(values[name]) or 1.0)
        sides = [reported({name: values[name] + sign * step}) for sign in (1, -1)]
        if any(len(one.t) < len(run.t) for one in sides):
            raise SimulateError(f"{run.scene.name}: next to {name} = {values[name]:g} the motion has no forces")
        found[:, at, k] = np.array([(sides[0][one] - sides[1][one]) / (2 * step) for one in beside]).T
    return found, (f"by differences, not by derivatives: {', '.join(beside)}",)


def _exact(run: Trajectory, motion: SceneMotion, names: Sequence[str]) -> Array | None:
    """Return ∂τ/∂p, shape (N, nv, k), by its own output; None where there is none along this motion."""
    scene = run.scene
    if scene.prescribed_velocities or scene.states:  # states move with parameters, too
        return None
    given = tuple(name for name in scene.coordinates if name in motion.laws) if scene.is_constrained else ()
    choices = LoopChoices(independent=given)
    try:
        labels = derive_one(Workspace(scene, choices), DERIVATIVES).labels
        call = lambdify(scene, DERIVATIVES, closing=choices)
    except DerivationError:
        return None
    columns = labels[1]
    fixed = [name for name in names if name not in columns]
    if fixed:
        raise SimulateError(f"{scene.name}: {', '.join(fixed)} stands in no equation, as zero does; give such as 1e-9")
    known: dict[str, Array] = {"q": run.q, "qd": run.qd, "qdd": run.qdd, "t": run.t, "inputs": run.inputs}
    known |= {"internal": run.own_states}
    slopes = call(*(known[one.name] for one in call.operands))
    slopes = np.broadcast_to(slopes, (len(run.t), len(scene.velocities), len(columns)))
    return np.asarray(slopes[:, :, [columns.index(name) for name in names]])


USUAL = ("coordinates", "velocities", "outputs", FORCES)
"""Kinds of columns whose uncertainty is told where nobody chooses."""

MOST_PANELS = 12

COLOUR = "#1f5f99"

SD = "sd_"
"""What the name of a column of standard deviations begins with."""


@dataclass(frozen=True, eq=False)
class Uncertainty(Shown):
    """How uncertain columns of a run are, to first order: sd² = s C sᵀ, s = ∂column/∂(what is uncertain).

    Attributes:
        run: the run at the means.
        varied: what is uncertain: parameters, positions and velocities at the start, shape (k,).
        covariance: of these, shape (k, k).
        names: columns of the run, shape (m,).
        slopes: their derivatives at every time, shape (N, m, k); units of the column over those of the name.
        notes: what a user should know.
    """

    run: Trajectory
    varied: tuple[str, ...]
    covariance: Array
    names: tuple[str, ...]
    slopes: Array = field(repr=False)
    notes: tuple[str, ...] = ()

    @classmethod
    def of_run(
        cls, problem: Problem, run: Run, names: Sequence[str], covariance: Array, requested: Sequence[str]
    ) -> Uncertainty:
        """Return the uncertainty of a run by that of `names`, shape (k,), of this covariance, shape (k, k).

        `requested` are columns or patterns, none for the usual ones; of the run `until` and `every` are looked at.

        Raises:
            SimulateError: with every fault of the arguments; forces that have no derivative; or a run that fails.
            UnknownNameError: a column that is none.
        """
        scene, until, every = problem.scene, run.until, run.every
        made = simulate(problem.as_read, until=until, every=every, say=lambda _: None)
        if len(made.t) < 2 and made.complete:
            raise SimulateError(f"{scene.name}: every = {every}: the run to {until:g} s has one sample; give less")
        if len(made.t) < 2:
            raise SimulateError(f"{scene.name}: {made.stopped}; there is nothing to tell the uncertainty of")
        found = variations(made, problem.driving, problem.initial, names)
        columns = _columns(made, requested)
        said = () if made.complete else (f"{made.stopped}: the uncertainty is that of the rows until then",)
        return cls(made, tuple(names), covariance, columns, found.slopes(made, columns), (*made.notes, *said))

    @classmethod
    def of_forces(
        cls,
        problem: Problem,
        names: Sequence[str],
        covariance: Array,
        motion: Entries,
        path: Entries,
        times: npt.ArrayLike,
        requested: Sequence[str],
    ) -> Uncertainty:
        """Return the uncertainty of what a motion takes; arguments as of `of_run` and `inverse`."""
        scene = problem.scene
        laws, ways = read_motion(scene, motion), read_path(scene, path)

        def told(values: Mapping[str, float]) -> Trajectory:
            moved = replace(problem, values=values)
            return inverse(moved, laws, times, say=lambda _: None, path=ways)

        run = told({})
        columns = chosen(run.names, requested, scene) if requested else _columns(run, ())
        if not requested:
            columns = tuple(name for name in columns if name not in (*scene.coordinates, *scene.velocities))
        slopes, said = force_slopes(run, told, laws, not ways.points, columns, names)
        return cls(run, tuple(names), covariance, columns, slopes, (*run.notes, *said))

    def __repr__(self) -> str:
        what = f"{len(self.t)} rows of {listed(self.names)} by {listed(self.varied)}"
        return f"<Uncertainty of {self.run.scene.name}: {what}>"

    @property
    def t(self) -> Array:
        """Times, s, shape (N,)."""
        return self.run.t

    @property
    def values(self) -> Array:
        """The columns at the means, shape (N, m)."""
        return np.stack([self.run[name] for name in self.names], axis=1)

    @property
    def sd(self) -> Array:
        """Standard deviations, shape (N, m)."""
        variance: Array = np.einsum("nmi,ij,nmj->nm", self.slopes, self.covariance, self.slopes)
        return np.sqrt(np.maximum(variance, 0.0))

    @property
    def columns(self) -> tuple[Column, ...]:
        """What the columns are, their units for one."""
        known = {one.name: one for one in self.run.columns}
        return tuple(known[name] for name in self.names)

    def __getitem__(self, name: str) -> Array:
        """Return a column at every time, `bars["theta"]`, or its standard deviation, `bars["sd_theta"]`, shape (N,).

        Raises:
            UnknownNameError: there is no such column; it says what it may have been.
        """
        if not isinstance(name, str) or name in self.names:
            return np.asarray(self.values[:, self._place(name)])
        return np.asarray(self.sd[:, self._place(name.removeprefix(SD))])

    def shares(self, name: str) -> Array:
        """Return which part of a column's variance each uncertain name is to blame for, shape (N, k); rows sum to 1.

        A correlation counts for half to both of its names, so that a share may be negative. Where there is no variance
        at all, all shares are zero.

        Raises:
            UnknownNameError: there is no such column.
        """
        slopes = self.slopes[:, self._place(name)]
        parts = slopes * (slopes @ self.covariance)
        total = parts.sum(axis=1, keepdims=True)
        return np.asarray(np.divide(parts, total, out=np.zeros_like(parts), where=total > 0))

    def _place(self, name: str) -> int:
        if not isinstance(name, str) or name not in self.names:
            told = choice(name, self.names)
            raise UnknownNameError(f"{self.run.scene.name}: there is no uncertainty of {quoted(name)}; {told}")
        return self.names.index(name)

    def table(self) -> tuple[tuple[str, ...], Array]:
        """Return names of columns and the numbers: t, then each column and behind it its standard deviation."""
        both = np.stack([self.values, self.sd], axis=2).reshape(len(self.t), -1)
        names = (each for name in self.names for each in (name, SD + name))
        return (TIME, *names), np.hstack([self.t[:, None], both])

    def to_csv(self, file: str | Path | None = None) -> str:
        """Return the table as CSV with every digit; of a file that it fills, the name.

        Raises:
            EmitError: the file cannot be written.
        """
        check_arguments(Uncertainty.to_csv, locals(), EmitError)
        text = columns_csv(*self.table())
        return text if file is None else str(write_file(file, text))

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table as a data frame over the index t, s; `attrs["units"]` has a unit for each.

        Raises:
            SimulateError: pandas is not installed.
        """
        each = (Column(start + one.name, one.kind, one.unit) for one in self.columns for start in ("", SD))
        about: dict[str, Any] = {"scene": self.run.scene.name, "varied": self.varied}
        return frame((Column(TIME, "time", "s"), *each), self.table()[1], about)

    def drawn(self, kind: Literal["svg", "pdf", "png"]) -> bytes:
        """Return the plot of all columns as a picture; errors as of `plot`."""
        check_arguments(Uncertainty.drawn, locals(), SimulateError)
        return _filled(self, ()).picture(kind)

    def plot(self, *names: str | Sequence[str], axes: Axes | Sequence[Axes] | None = None) -> Figure:
        """Return a figure of matplotlib: each column with bands of one and two deviations; `axes` as of runs.

        Raises:
            UnknownNameError: there is no such column.
            SimulateError: matplotlib is not installed.
        """
        check_arguments(Uncertainty.plot, locals(), UnknownNameError)
        filled = _filled(self, [one for some in names for one in ([some] if isinstance(some, str) else some)])
        check_plot()
        return filled.figure(3 * len(self.t) * len(self.names), axes)


def _columns(run: Trajectory, requested: Sequence[str]) -> tuple[str, ...]:
    if requested:
        names = chosen(run.names, requested, run.scene)
        lacking = [name for name in names if name in UNTOLD or name == "t"]
        if lacking:
            raise SimulateError(f"{run.scene.name}: {', '.join(lacking)} has no uncertainty that could be told")
        return names
    moving = {one.name for one in run.columns if one.kind == FORCES and run[one.name].any()}
    return tuple(one.name for one in run.columns if one.kind in USUAL and (one.kind != FORCES or one.name in moving))


def _filled(uncertainty: Uncertainty, names: Sequence[str]) -> FilledFigure:
    every = chosen(uncertainty.names, names, uncertainty.run.scene) if names else uncertainty.names
    shown = every[:MOST_PANELS]

    def fill(made: Any) -> None:
        axes = made.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axis, name in zip(axes, shown, strict=True):
            _draw(axis, uncertainty, name)
        more = len(every) - len(shown)
        told = f"bands of one and two standard deviations, by {listed(uncertainty.varied)}"
        told += f" (and {more} more columns)" if more else ""
        axes[0].set_title(told, loc="left", fontsize=9).set_parse_math(False)
        axes[-1].set_xlabel("$t$, s" if uncertainty.run.columns[0].unit else "$t$")
        axes[0].figure.align_ylabels(axes)

    return FilledFigure(uncertainty.run.scene.name, (8.0, max(2.2, 0.4 + 1.6 * len(shown))), fill)


def _draw(axis: Any, uncertainty: Uncertainty, name: str) -> None:
    place = uncertainty.names.index(name)
    middle, sd = uncertainty.run[name], uncertainty.sd[:, place]
    for count, alpha in ((2, 0.18), (1, 0.28)):
        axis.fill_between(
            uncertainty.t, middle - count * sd, middle + count * sd, color=COLOUR, alpha=alpha, linewidth=0
        )
    axis.plot(uncertainty.t, middle, color=COLOUR, linewidth=1.0)
    unit = uncertainty.columns[place].printed_unit
    axis.set_ylabel(f"{name}, {unit}" if unit else name).set_parse_math(False)
    axis.grid(alpha=0.3)
