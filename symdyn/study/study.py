"""The noun of this package: what was varied, and what came of it, a row a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.arguments import check_arguments, native, walked
from symdyn.emit import write_file
from symdyn.errors import EmitError, SimulateError, UnknownNameError, quoted
from symdyn.scene.values import choice, listed
from symdyn.shown import Shown
from symdyn.study.design import SALTELLI
from symdyn.table import Table

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    from matplotlib.figure import Figure

    from symdyn.study.indices import Indices

QUANTILES = (0.05, 0.5, 0.95)

NOT_MADE, ENDED, STOPPED, FAILED = range(4)

WORDS = {NOT_MADE: "not made", ENDED: "end", STOPPED: "stopped", FAILED: "failed"}
"""How a run ended, by its code: at the time that was asked for, earlier because something stopped it, or nowhere."""

MOST_TOLD = 10
"""Runs that did not end whose words are kept, those with the lowest numbers."""


@dataclass(frozen=True, eq=False)
class Study(Shown):
    """Runs of one scene at many values.

    Attributes:
        scene: name of the mechanism.
        names: of what was varied, shape (k,).
        units: of what was varied and of measures, by name; "" where it is not known.
        values: what each run was made with, shape (N, k).
        measures: what came of it by name, each of shape (N,); NaN where a run failed or was not made.
        codes: how each run ended, shape (N,): a key of `WORDS`.
        told: in words what ended the first few of those that did not reach their end, by number of the run.
        about: how the study was made: design, seed, hash of the scene, ...
        notes: what a user should know.
        wall: seconds that the runs of this call took.
    """

    scene: str
    names: tuple[str, ...]
    units: Mapping[str, str]
    values: Array
    measures: Mapping[str, Array]
    codes: NDArray[np.uint8]
    told: Mapping[int, str] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    wall: float = 0.0

    def __repr__(self) -> str:
        left = f", {self.left} not made" if self.left else ""
        failed = f", {self.failed} failed" if self.failed else ""
        return (
            f"<Study of {self.scene}: {len(self)} runs{left}{failed} over {listed(self.names)}; "
            f"{listed(self.measures)}>"
        )

    def __len__(self) -> int:
        return len(self.values)

    @property
    def left(self) -> int:
        """How many runs were not made."""
        return int(np.count_nonzero(self.codes == NOT_MADE))

    @property
    def failed(self) -> int:
        """How many runs could not begin, or could not go on."""
        return int(np.count_nonzero(self.codes == FAILED))

    @property
    def stopped(self) -> int:
        """How many runs ended early because something stopped them, such as the limit of a joint."""
        return int(np.count_nonzero(self.codes == STOPPED))

    @property
    def complete(self) -> bool:
        """Whether every run was made."""
        return self.left == 0

    @property
    def columns(self) -> tuple[str, ...]:
        """What was varied, then measures."""
        return (*self.names, *self.measures)

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the columns: `"m1" in study`."""
        return iter(self.columns)

    def __getitem__(self, name: str) -> Array:
        """Return a column by its name, shape (N,).

        Raises:
            UnknownNameError: there is none; it says what it may have been.
        """
        check_arguments(Study.__getitem__, locals(), UnknownNameError)
        if name in self.measures:
            return self.measures[name]
        if name in self.names:
            return np.asarray(self.values[:, self.names.index(name)])
        raise UnknownNameError(f"{self.scene}: there is no column {name}; {choice(str(name), self.columns)}")

    def quantiles(self, name: str, at: Sequence[float] = QUANTILES) -> Array:
        """Return quantiles of a column over the runs that have a value, shape (len(at),); NaN where none has.

        Raises:
            UnknownNameError: there is no such column.
            SimulateError: a quantile that is not from 0 to 1.
        """
        (at,) = walked(Study.quantiles, locals(), "at", error=SimulateError)
        at = native(float, *at)
        if not all(0 <= one <= 1 for one in at):
            raise SimulateError(f"at = {quoted(list(at))}: quantiles are from 0 to 1, such as [0.05, 0.5, 0.95]")
        known = self.known(name)
        return np.quantile(known, at) if known.size else np.full(len(at), np.nan)

    def known(self, name: str) -> Array:
        """Return a column of the runs that have a value, shape (n,).

        Raises:
            UnknownNameError: there is no such column.
        """
        column = self[name]
        return np.asarray(column[np.isfinite(column)])

    def mean(self, name: str) -> float:
        """Return the mean of a column over the runs that have a value; NaN where none has."""
        known = self.known(name)
        with np.errstate(all="ignore"):
            return float(known.mean()) if known.size else np.nan

    def sd(self, name: str) -> float:
        """Return the standard deviation of a column over the runs that have a value; NaN for less than two."""
        known = self.known(name)
        with np.errstate(all="ignore"):
            return float(known.std(ddof=1)) if known.size > 1 else np.nan

    def extremes(self, name: str) -> tuple[float, float]:
        """Return the least and the largest number of a column; NaN where there is none."""
        known = self.known(name)
        return (float(known.min()), float(known.max())) if known.size else (np.nan, np.nan)

    def table(self) -> tuple[tuple[str, ...], Array]:
        """Return names of columns and the numbers, shape (N, columns); the last one is the code of each run."""
        parts = [self.values, *(one[:, None] for one in self.measures.values()), self.codes[:, None].astype(float)]
        return (*self.columns, "ended"), np.hstack(parts)

    def to_csv(self, file: str | Path | None = None) -> str:
        """Return the table as CSV with every digit, `ended` in words; written to a file if one is given.

        Raises:
            EmitError: the file cannot be written.
        """
        check_arguments(Study.to_csv, locals(), EmitError)
        rows = zip(np.hstack([self.values, *(one[:, None] for one in self.measures.values())]), self.codes, strict=True)
        cells = [(*row.tolist(), WORDS[int(code)]) for row, code in rows]
        text = Table((*self.columns, "ended"), cells).csv()
        if file is not None:
            write_file(file, text)
        return text

    def indices(self, measure: str, level: float = 0.95) -> Indices:
        """Return Sobol's indices of a measure, with intervals; arguments and errors as of `symdyn.study.indices`."""
        from symdyn.study.indices import indices

        return indices(self, measure, level)

    def plot(self, *measures: str, kind: str | None = None) -> Figure:
        """Return a figure of matplotlib, which a notebook shows: of all measures, or of some.

        Args:
            measures: names of measures.
            kind: a key of `symdyn.study.plots.PLOTS`; None takes what fits: indices for their design, a curve over one
                name, a heat map over a grid of two, a tornado over a larger one, else histograms.

        Raises:
            SimulateError: no such measure or kind, one that does not fit, no run with a value, or no matplotlib.
        """
        check_arguments(Study.plot, locals(), SimulateError)
        from symdyn.study.plots import figure

        return figure(self, measures, kind)

    def save_plot(self, file: str | Path, kind: str | None = None) -> None:
        """Write a plot of all measures to a .svg, .pdf, .png or .html file; `kind` as of `plot`.

        Raises:
            SimulateError: another ending, or a file that cannot be written; and as of `plot`.
        """
        check_arguments(Study.save_plot, locals(), SimulateError)
        from symdyn.study.plots import plot

        plot(self, Path(file), kind=kind)

    def drawn(self, kind: Literal["svg", "pdf", "png"]) -> bytes:
        """Return the plot of all measures that have values as a picture; errors as of `plot`."""
        check_arguments(Study.drawn, locals(), SimulateError)
        from symdyn.study.plots import drawn_study

        return drawn_study(self, kind, [name for name in self.measures if self.known(name).size])

    @property
    def has_indices(self) -> bool:
        """Whether its design is that of Sobol's indices."""
        return self.about.get("design") == SALTELLI

    def to_pandas(self) -> pandas.DataFrame:
        """Return the columns as a data frame, a row a run; `attrs["units"]` has a unit for each.

        Raises:
            SimulateError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise SimulateError(
                "to_pandas() needs pandas, which is not installed; pip install pandas, or take .table() and .to_csv()"
            ) from None
        found = pandas.DataFrame({name: self[name] for name in self.columns})
        found["ended"] = pandas.Categorical([WORDS[int(code)] for code in self.codes], list(WORDS.values()))
        found.attrs |= {"units": dict(self.units), "scene": self.scene, **self.about}
        return found
