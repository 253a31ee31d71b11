"""The noun of this package: what moved, how, and how well the laws of mechanics were kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Literal

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import check_arguments
from symdyn.dynamics.mechanism import TIME
from symdyn.emit import write_file
from symdyn.errors import EmitError, SimulateError, UnknownNameError, listed, quoted
from symdyn.frozen import asdict, dataclass, field
from symdyn.graph import Graph
from symdyn.scene import Scene
from symdyn.scene.values import LETTERS, Letter, acceleration_name, split_commas
from symdyn.shown import Shown
from symdyn.simulation.columns import Column, columns, columns_csv, data_set, frame, known, missing
from symdyn.simulation.equations.contact_modes import Impact
from symdyn.simulation.equations.saturation import Saturation, cut_lines
from symdyn.simulation.integrate.integration import END, INTERRUPTED
from symdyn.simulation.prescribed.courses import ForceTable
from symdyn.simulation.prescribed.forces import drive_names

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MONITORS = {
    "energy": "largest error of the energy balance, J",
    "energy_scale": "energy that moved, J",
    "loops": "largest residual of the loops, m or 1",
    "loop_rates": "largest velocity against the rows, m/s or rad/s",
    "quaternions": "largest error of a squared length of a quaternion",
    "momenta": "largest change of a conserved momentum",
    "normal_force": "smallest normal force, N",
    "friction_coefficient": "largest friction coefficient that is needed",
    "tension": "smallest tension, N",
    "penetration": "deepest gap below zero, m or rad",
    "contact_laws": "largest force against the laws of contact and friction, over the largest force",
}
"""What the monitors of a run tell, in words; those of a contact or a rope have its name behind theirs."""


@dataclass(frozen=True)
class Event:
    """A formula that crossed zero, or the limit of a joint that ended a run.

    Attributes:
        formula: as the user wrote it; or joint and limit, such as "joint elbow: upper limit 1.57 rad".
        t: when, s.
        q, u: where, shapes (nq,) and (nv,).
        stops: whether it ended the run.
    """

    formula: str
    t: float
    q: Array
    u: Array
    stops: bool


@dataclass(frozen=True, eq=False)
class Trajectory(Shown):
    """A motion and its forces over time.

    Attributes:
        scene: the mechanism.
        t: times, s, shape (N,).
        q: coordinates, shape (N, nq); rad, m or 1.
        qd: velocities, shape (N, nv).
        qdd: their rates, shape (N, nv).
        tau: driving forces, shape (N, nv).
        extra: more columns by name, each of shape (N,): energies, powers, residuals, momenta, reactions.
        monitors: largest violation of each law over all samples, by name.
        events: what crossed zero, in order.
        stopped: "end", "interrupted", the formula that ended the run, or in words what else did: a limit, a failure.
        method: name of the integrator, "" where nothing was integrated.
        rtol, atol: its tolerances.
        steps, evaluations: of the integrator.
        preparing: seconds until the integrator was ready; heyoka compiles in them.
        wall: seconds that integrating took.
        notes: what a user should know.
        low: what q and qd are beyond their doubles, shape (N, nq + nv), of runs with 31 digits; else None.
        held: names of the columns that a controller holds from one sample to the next.
        saturations: when a controller's forces were cut at their limits, in order.
        curves: driving forces between rows, functions of t by name, where they are known, as those of an optimum;
            `simulate(forces=run)` takes them.
        impacts: what happened at contacts, stops and dry friction, in order: times, velocities, impulses, energy lost.
        dense: what the run is between its rows, see `run(t)`; None of motions that were not integrated here.
    """

    scene: Scene
    t: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array
    extra: Mapping[str, Array] = field(default_factory=dict)
    monitors: Mapping[str, float] = field(default_factory=dict)
    events: tuple[Event, ...] = ()
    stopped: str = END
    method: str = ""
    rtol: float = 0.0
    atol: float = 0.0
    steps: int = 0
    evaluations: int = 0
    preparing: float = 0.0
    wall: float = 0.0
    notes: tuple[str, ...] = ()
    low: Array | None = None
    held: tuple[str, ...] = ()
    saturations: tuple[Saturation, ...] = ()
    curves: Mapping[str, ForceTable] = field(default_factory=dict, repr=False)
    impacts: tuple[Impact, ...] = ()
    dense: Callable[[Trajectory, Array], Trajectory] | None = field(default=None, repr=False)

    def __getstate__(self) -> dict[str, object]:
        """Return what another process is sent: the rows, not the equations that go on between them."""
        return {**self.__dict__, "dense": None}

    def __repr__(self) -> str:
        span = f"t = {self.t[0]:g} … {self.t[-1]:g} s, " if len(self.t) else ""
        ended = "" if self.complete else f"; ended: {self.stopped}"
        return f"<Trajectory of {self.scene.name}: {span}{len(self.t)} rows of {listed(self.names)}{ended}>"

    @property
    def complete(self) -> bool:
        """Whether it reached its end, or a formula that was to stop it; else `stopped` says why it did not."""
        return self.stopped == END or (bool(self.events) and self.events[-1].formula == self.stopped)

    @property
    def ended(self) -> bool:
        """Whether it reached the time of its end."""
        return self.stopped == END

    @property
    def interrupted(self) -> bool:
        """Whether a user ended it."""
        return self.stopped == INTERRUPTED

    @property
    def cut_lines(self) -> list[str]:
        """Times in which forces were cut in words, the first of many."""
        return cut_lines(self.saturations)

    @property
    def monitor_rows(self) -> list[tuple[str, float]]:
        """What the monitors tell, in words, and their values."""
        parts = [(name.partition(" "), value) for name, value in self.monitors.items()]
        return [(MONITORS.get(kind, kind) + (f", of {of}" if of else ""), value) for (kind, _, of), value in parts]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns of `table`."""
        rates = self.scene.velocities
        accelerations = (acceleration_name(name) for name in rates)
        return (TIME, *self.scene.coordinates, *rates, *accelerations, *drive_names(self.scene), *self.extra)

    @property
    def columns(self) -> tuple[Column, ...]:
        """What each of the columns is, its unit for one."""
        return columns(self.scene, self.extra)

    @property
    def inputs(self) -> Array:
        """What was given over time, shape (N, inputs); what no column tells is as the scene says."""
        return self._told(self.scene.inputs)

    @property
    def states(self) -> Array:
        """Coordinates, velocities and states of one's own, shape (N, all of them): x of ẋ = f(x)."""
        return np.hstack([self.q, self.qd, self.own_states])

    @property
    def own_states(self) -> Array:
        """The states of one's own, shape (N, states); what no column tells stays where the scene starts."""
        return self._told(self.scene.states)

    def _told(self, letters: Sequence[Letter]) -> Array:
        graph = Graph()
        usual = self.scene.at_time(graph)
        each = [self.extra.get(x.name, np.full(len(self.t), usual[graph.symbol(x.name)])) for x in letters]
        return np.array(each).reshape(-1, len(self.t)).T

    @staticmethod
    def check_columns(scene: Scene, names: Iterable[str]) -> None:
        """Raise UnknownNameError for a name that no column of a run of the scene will have."""
        own = [one.name for one in (*scene.given, *scene.outputs)]
        every = [one.name for one in columns(scene, own)]
        for name in names:
            if not any(letter in name for letter in "*?[") and name not in every and not known(name):
                raise UnknownNameError(f"{scene.name}: {missing(name, every, scene)}")

    def __call__(self, t: float | Sequence[float] | Array) -> Trajectory:
        """Return the run at other times, a row for each, as exact as its own rows: all columns, and all that they need.

        The integrator goes on from the row before each time, at the tolerances of the run, so that many times at once
        cost less than one after the other. What was sampled by a controller is not sampled again; a law that acts all
        the time, or a function of time, is asked again.

        >>> import symdyn
        >>> run = symdyn.simulate(symdyn.example("cart_pole"), forces="F=0.5*cos(t)", until=2)
        >>> run([0.505, 1.0]).q.shape, bool(run(1.0)["x"] == run["x"][100])
        ((2, 2), True)

        Args:
            t: times within the run in any order, s, shape (N,); one number gives one row.

        Raises:
            SimulateError: a time outside of the run, or a motion that was not integrated here: that of `inverse`, of a
                file or of another process.
        """
        check_arguments(Trajectory.__call__, locals(), SimulateError)
        if self.dense is None:
            raise SimulateError(
                f"{self.scene.name}: there are no equations at hand that go on between the rows of this motion: it is "
                "given, or comes from a file or another process; simulate it, or interpolate its columns"
            )
        try:
            times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        except (TypeError, ValueError):
            times = np.empty((0, 0))
        if times.ndim != 1:
            raise SimulateError(f"{self.scene.name}: t = {quoted(t)}: give a time, s, or a list of times")
        return self.dense(self, times)

    def table(self) -> tuple[tuple[str, ...], Array]:
        """Return names of columns and the numbers, shape (N, columns)."""
        parts = [self.t[:, None], self.q, self.qd, self.qdd, self.tau]
        parts += [column[:, None] for column in self.extra.values()]
        return self.names, np.hstack(parts)

    def keys(self) -> tuple[str, ...]:
        """Return the names of the columns, so that a run is taken for a table."""
        return self.names

    def __len__(self) -> int:
        """Return how many rows it has."""
        return len(self.t)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """Return the numbers of the table, shape (N, columns), as a data frame does."""
        return np.asarray(self.table()[1], dtype)

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the columns: `"q1" in run`, `dict(run)`."""
        return iter(self.names)

    def __getitem__(self, name: str | Sequence[str]) -> Array:
        """Return a column by its name, shape (N,), or several by a list of names, shape (N, len(names)).

        What follows from the motion alone need not be a column: spring_s_force, point_tip_x_dot, kinetic_energy.

        Raises:
            UnknownNameError: there is none; it says what it may have been.
        """
        asked, names = name if isinstance(name, list | tuple) else [name], self.names
        state = (x for part in (self.t[:, None], self.q, self.qd, self.qdd, self.tau) for x in part.T)
        every = dict(zip(names, [*state, *self.extra.values()], strict=True))
        if late := [one for one in asked if isinstance(one, str) and one not in every]:
            from symdyn.simulation.force_columns import columns_of_motion

            every |= columns_of_motion(self, late)
        known = (*names, *LETTERS.of_struts(self.scene.struts))
        for one in asked:
            if not isinstance(one, str) or one not in every:
                raise UnknownNameError(f"{self.scene.name}: {missing(one, known, self.scene)}")
        if isinstance(name, str):
            return np.array(every[name])
        return np.array([every[one] for one in name]).reshape(-1, len(self.t)).T

    def to_csv(self, file: str | Path | IO[str] | None = None) -> str:
        """Return the table as CSV with every digit, which `simulate` and `inverse` read; of a file it fills, the name.

        Coordinates and velocities of runs with 31 digits have all of these.

        Raises:
            EmitError: the file cannot be written, or takes no text.
        """
        text = columns_csv(*self.table(), self.low)
        if isinstance(file, (str, Path)):
            return str(write_file(file, text))
        if file is not None:
            try:
                file.write(text)
                return ""
            except (AttributeError, OSError, TypeError, ValueError) as fault:
                raise EmitError(f"{self.scene.name}: file = {quoted(file)} takes no text: {fault}") from None
        return text

    def to_npz(self, file: str | Path) -> None:
        """Write the columns, their names, units and how the run was made to a .npz file, which `numpy.load` reads.

        Raises:
            SimulateError: another ending, or a file that cannot be written.
        """
        check_arguments(Trajectory.to_npz, locals(), SimulateError)
        from symdyn.simulation.panels import write_npz

        write_npz(self, Path(file))

    def to_pandas(self) -> pandas.DataFrame:
        """Return the columns as a data frame over the index t, s; `attrs["units"]` has a unit for each.

        Raises:
            SimulateError: pandas is not installed.
        """
        return frame(self.columns, self.table()[1], self._about)

    def to_xarray(self) -> xarray.Dataset:
        """Return the columns as a data set over the coordinate t, s; each has its unit as `attrs["units"]`.

        Raises:
            SimulateError: xarray is not installed.
        """
        return data_set(self.columns, self.table()[1], self._about)

    def about(self) -> dict[str, Any]:
        """Return how it was made, and how well laws were kept, for JSON; the same run, the same text."""
        return {
            "scene": self.scene.name,
            "method": self.method,
            "rtol": self.rtol,
            "atol": self.atol,
            "steps": self.steps,
            "evaluations": self.evaluations,
            "stopped": self.stopped,
            "events": [{"formula": e.formula, "t": e.t, "stops": e.stops} for e in self.events],
            **({"impacts": [asdict(one) for one in self.impacts]} if self.impacts else {}),
            "saturations": [asdict(one) for one in self.saturations],
            "held": list(self.held),
            "monitors": dict(self.monitors),
        }

    def plot(
        self,
        *names: str | Sequence[str | Sequence[str]],
        axes: Axes | Sequence[Axes] | None = None,
        width: float | str | None = None,
        x: str | None = None,
        degrees: bool = False,
    ) -> Figure:
        """Return a figure of matplotlib, which a notebook shows and whose axes are yours to change.

        Args:
            names: of columns, or patterns such as "point_*", one panel a unit; or lists of them, one panel each:
                `plot([["x"], ["F", "reaction_*"]])`. Without any, the coordinates, velocities, inputs, driving forces,
                reactions that the run has, outputs and energies; forces that are zero all the time are left out.
            axes: of a figure of yours, as many as panels, to draw into; its figure is returned.
            width: "column" of a paper, 3.3 in, with small letters and without a heading; "slide", 11 in, with large
                ones; or inches. Usually 8.
            x: the column that all are drawn over, such as the angle of a crank; None is t.
            degrees: whether angles, their rates and accelerations are in degrees.

        Raises:
            UnknownNameError: there is no such column.
            SimulateError: matplotlib is not installed, or no such width.
            DrawError: another number of axes than of panels.
        """
        check_arguments(Trajectory.plot, locals(), UnknownNameError)
        from symdyn.simulation.panels import figure

        each = [one for some in names for one in ([some] if isinstance(some, str) else some)]
        return figure(self, each, axes, width, x, degrees)

    def save_plot(
        self, file: str | Path, names: Sequence[str | Sequence[str]] = (), width: float | str | None = None
    ) -> None:
        """Write a plot to a .svg, .pdf, .png or .html file; `names` (or a text with commas) and `width` as of `plot`.

        Raises:
            UnknownNameError: there is no such column.
            SimulateError: another ending, no matplotlib, or a file that cannot be written.
        """
        check_arguments(Trajectory.save_plot, locals(), SimulateError)
        from symdyn.simulation.panels import plot

        plot(self, Path(file), split_commas(names) if isinstance(names, str) else list(names), width)

    def drawn(self, kind: Literal["svg", "pdf", "png"]) -> bytes:
        """Return the usual plot as a picture; the same run, the same bytes.

        Raises:
            SimulateError: another kind, or matplotlib is not installed.
        """
        check_arguments(Trajectory.drawn, locals(), SimulateError)
        from symdyn.simulation.panels import draw

        return draw(self, kind)

    def animate(self, fps: float = 30.0, loop: bool = True) -> str:
        """Return the mechanism as it moves, a page that a notebook shows; all as of `symdyn.animation`.

        Raises:
            DrawError: a rate that is none, or a motion that cannot be drawn.
        """
        from symdyn.draw import animation

        return animation(self, fps=fps, loop=loop)

    def film(
        self,
        file: str | Path,
        fps: float | None = None,
        size: int | tuple[int, int] | None = None,
        loop: bool = True,
        note: Callable[[str], None] | None = None,
    ) -> Path:
        """Write the mechanism as it moves to a .html, .svg, .gif, .mp4 or .glb file; all else as of `symdyn.film`.

        Raises:
            DrawError: an ending that is not known, a motion that cannot be drawn, or a file that cannot be written.
        """
        from symdyn.draw import film

        return film(self, file=file, fps=fps, size=size, loop=loop, note=note)

    @property
    def _about(self) -> dict[str, str | float]:
        made: dict[str, str | float] = (
            {"method": self.method, "rtol": self.rtol, "atol": self.atol} if self.method else {}
        )
        return {"scene": self.scene.name, "stopped": self.stopped, **made}
