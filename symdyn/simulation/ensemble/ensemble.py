"""The noun of this folder: many runs of one scene, each with its start and values, and what was measured of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import check_arguments
from symdyn.errors import UnknownNameError
from symdyn.scene import Scene
from symdyn.scene.values import listed, suggestion
from symdyn.shown import Shown
from symdyn.simulation import tables
from symdyn.simulation.columns import Column
from symdyn.simulation.trajectory import END, INTERRUPTED

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]


@dataclass(frozen=True, eq=False)
class Ensemble(Shown):
    """Many runs of one scene, in the order of the arrays they were given as.

    Attributes:
        scene: the mechanism; varied parameters have no value of their own here that means anything.
        varied: what differs between runs, by name, each of shape (N,).
        t: when each run ended, s, shape (N,).
        q, qd: where, shapes (N, nq) and (N, nv); NaN for runs that did not begin.
        measures: by the text of each, shape (N,); NaN where a run has none.
        times: of samples, s, shape (T,); measures are taken over these.
        samples: q and q̇ at these times, shape (N, T, nq + nv), NaN behind a run's end; None where not asked for.
        stopped: why each run ended, shape (N,): an index into `words`.
        words: "end" first, and in words what else ended runs.
        method: the integrator and how it was run.
        rtol, atol: its tolerances.
        steps: taken in all.
        preparing, wall: seconds until the first run began, and from there on.
        notes: what a user should know.
    """

    scene: Scene
    varied: Mapping[str, Array]
    t: Array
    q: Array
    qd: Array
    measures: Mapping[str, Array]
    times: Array
    stopped: npt.NDArray[np.int64]
    words: tuple[str, ...]
    samples: Array | None = None
    method: str = ""
    rtol: float = 0.0
    atol: float = 0.0
    steps: int = 0
    preparing: float = 0.0
    wall: float = 0.0
    notes: tuple[str, ...] = field(default=())

    def __len__(self) -> int:
        """Return how many runs there are."""
        return len(self.t)

    def __repr__(self) -> str:
        ended = int((self.stopped != 0).sum())
        told = f"; {ended} ended otherwise" if ended else ""
        return f"<Ensemble of {self.scene.name}: {len(self)} runs over {listed(self.varied)}{told}>"

    @property
    def complete(self) -> npt.NDArray[np.bool_]:
        """Which runs reached their end, shape (N,)."""
        return np.asarray(self.stopped == self.words.index(END))

    @property
    def interrupted(self) -> bool:
        """Whether a user ended one of them."""
        return INTERRUPTED in (self.words[k] for k in self.stopped)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of what there is a number of for every run."""
        ends = (f"end({name})" for name in (*self.scene.coordinates, *self.scene.velocities))
        return tuple(dict.fromkeys((*self.varied, *self.measures, *ends)))

    def __getitem__(self, name: str) -> Array:
        """Return what was varied, a measure, or a coordinate or velocity at the end as `end(q1)`; shape (N,).

        Raises:
            UnknownNameError: there is none; it says what it may have been.
        """
        check_arguments(Ensemble.__getitem__, locals(), UnknownNameError)
        for known in (self.varied, self.measures, self._ends):
            if name in known:
                return known[name]
        raise UnknownNameError(f"{self.scene.name}: {name} is not known; {suggestion(name, self.names)}")

    @property
    def _ends(self) -> dict[str, Array]:
        names = (*self.scene.coordinates, *self.scene.velocities)
        return {f"end({name})": x for name, x in zip(names, np.hstack([self.q, self.qd]).T, strict=True)}

    def to_pandas(self) -> pandas.DataFrame:
        """Return a data frame, a row a run: what was varied, measures, ends, and why it ended.

        Raises:
            SimulateError: pandas is not installed.
        """
        numbers = np.column_stack([np.arange(len(self)), *(self[name] for name in self.names)])
        columns = [Column(name, "", "") for name in ("run", *self.names)]
        about = {"scene": self.scene.name, "method": self.method, "rtol": self.rtol, "atol": self.atol}
        found = tables.frame(columns, numbers, about)
        found.index = found.index.astype("int64")
        found["stopped"] = np.array(self.words, dtype=object)[self.stopped]
        return found
