"""Error bars on motions and forces, to first order in what is uncertain: the noun."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import check_arguments
from symdyn.dynamics.mechanism import TIME
from symdyn.emit import write_file
from symdyn.errors import EmitError, SimulateError, UnknownNameError, quoted
from symdyn.scene.values import choice, listed
from symdyn.shown import Shown
from symdyn.simulation.columns import Column
from symdyn.simulation.tables import columns_csv, frame
from symdyn.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    from matplotlib.figure import Figure

SD = "sd_"
"""What a standard deviation's column begins with, in """


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
        """Return the standard deviation of a column at every time, shape (N,).

        Raises:
            UnknownNameError: there is no such column; it says what it may have been.
        """
        return np.asarray(self.sd[:, self._place(name)])

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
        """Return the table as CSV with every digit; written to a file if one is given.

        Raises:
            EmitError: the file cannot be written.
        """
        check_arguments(Uncertainty.to_csv, locals(), EmitError)
        text = columns_csv(*self.table())
        if file is not None:
            write_file(file, text)
        return text

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
        from symdyn.simulation.bands import drawn_bands

        return drawn_bands(self, kind)

    def plot(self, *names: str | Sequence[str]) -> Figure:
        """Return a figure of matplotlib, which a notebook shows: each column with bands of one and two deviations.

        Raises:
            UnknownNameError: there is no such column.
            SimulateError: matplotlib is not installed.
        """
        check_arguments(Uncertainty.plot, locals(), UnknownNameError)
        from symdyn.simulation.bands import figure

        return figure(self, [one for some in names for one in ([some] if isinstance(some, str) else some)])
