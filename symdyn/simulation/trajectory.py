"""The noun of this room: what moved, how, and how well the laws of mechanics were kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.errors import UnknownNameError
from symdyn.scene import Scene, acceleration_name
from symdyn.scene.values.names import choice
from symdyn.shown import Shown
from symdyn.simulation.prescribed.forces import drive_names
from symdyn.simulation.prescribed.formulas_in_time import TIME

END = "end"
INTERRUPTED = "interrupted"


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


@dataclass(frozen=True)
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

    @property
    def complete(self) -> bool:
        """Whether it reached its end, or a formula that was to stop it; else `stopped` says why it did not."""
        return self.stopped == END or (bool(self.events) and self.events[-1].formula == self.stopped)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns of `table`."""
        rates = self.scene.velocities
        accelerations = (acceleration_name(name) for name in rates)
        return (TIME, *self.scene.coordinates, *rates, *accelerations, *drive_names(self.scene), *self.extra)

    def table(self) -> tuple[tuple[str, ...], Array]:
        """Return names of columns and the numbers, shape (N, columns)."""
        columns = [self.t[:, None], self.q, self.qd, self.qdd, self.tau]
        columns += [column[:, None] for column in self.extra.values()]
        return self.names, np.hstack(columns)

    def keys(self) -> tuple[str, ...]:
        """Return the names of the columns, so that a run is taken for a table."""
        return self.names

    def __getitem__(self, name: str) -> Array:
        """Return a column by its name, shape (N,).

        Raises:
            UnknownNameError: there is none; it says what it may have been.
        """
        names, table = self.table()
        if name not in names:
            what = f"no column {name}" if isinstance(name, str) else f"columns have names, and {name!r:.40} is none"
            raise UnknownNameError(f"{self.scene.name}: {what}; {choice(str(name), names)}")
        return table[:, names.index(name)]
