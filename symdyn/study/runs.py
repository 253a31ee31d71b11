"""The noun of this package: many runs of one scene, what was varied, and what came of it, a row a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.arguments import check_arguments, native, walked
from symdyn.emit import write_file
from symdyn.errors import EmitError, SimulateError, UnknownNameError, choice, listed, quoted
from symdyn.extras import package
from symdyn.frozen import dataclass, field
from symdyn.rounding import in_digits
from symdyn.shown import Shown
from symdyn.study.design import SALTELLI, Indices, indices
from symdyn.table import Table

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


QUANTILES = (0.05, 0.5, 0.95)

NOT_MADE, ENDED, STOPPED, FAILED = range(4)

WORDS = {NOT_MADE: "not made", ENDED: "end", STOPPED: "stopped", FAILED: "failed"}
"""How a run ended, by its code: at the time that was asked for, earlier because something stopped it, or nowhere."""

SHOWN = 20  # rows of a table

MOST_TOLD = 10
"""Runs of a sweep that did not end whose words are kept, those with the lowest numbers."""


@dataclass(frozen=True)
class Ends:
    """Where runs ended, and their states on the way.

    Attributes:
        names: coordinates, then velocities.
        t: when each run ended, s, shape (N,).
        q, qd: where, shapes (N, nq) and (N, nv); NaN for runs that did not begin.
        times: of samples, s, shape (T,); measures are taken over these.
        samples: q and q̇ at these times, shape (N, T, nq + nv), NaN behind a run's end; None where not asked for.
    """

    names: tuple[str, ...]
    t: Array
    q: Array
    qd: Array
    times: Array
    samples: Array | None = None


class Rows(NamedTuple):
    """Names of columns and numbers, shape (N, columns), the last one the code of each run; shown as a table."""

    names: tuple[str, ...]
    numbers: Array

    def __repr__(self) -> str:
        more = len(self.numbers) - SHOWN
        return repr(self.written) + (f"\n ... {more} rows more" if more > 0 else "")

    @property
    def written(self) -> Table[str]:
        """The first rows as text, how each run ended in words."""
        rows = [(*(in_digits(x, 6) for x in row), WORDS[int(code)]) for *row, code in self.numbers[:SHOWN].tolist()]
        return Table(self.names, rows, range(len(self.names) - 1))


@dataclass(frozen=True, eq=False)
class Runs(Shown):
    """Many runs of one scene, or calls of one of its functions: what `ensemble` and `sweep` return.

    Attributes:
        scene: name of the mechanism.
        names: of what was varied, shape (k,).
        units: of the columns, by name; "" where it is not known.
        values: what each run was made with, shape (N, k).
        measures: what came of it by name, each of shape (N,); NaN where a run failed or was not made.
        codes: how each run ended, shape (N,): a key of `WORDS`.
        reasons: in words what ended those that did not reach their end, by number of the run; of a sweep the first few.
        about: how they were made: design, seed, hash of the scene, method, ...
        notes: what a user should know.
        wall: seconds that the runs of this call took.
        ends: `t`, `q`, `qd` and `samples` as below, `times` of these, s; None of a sweep, which keeps measures alone.
    """

    scene: str
    names: tuple[str, ...]
    units: Mapping[str, str]
    values: Array
    measures: Mapping[str, Array]
    codes: NDArray[np.uint8]
    reasons: Mapping[int, str] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    wall: float = 0.0
    ends: Ends | None = None

    def __repr__(self) -> str:
        counts = {"not made": self.left, "failed": self.failed, "stopped": self.stopped}
        why = next((f": {why}" for k, why in self.reasons.items() if self.codes[k] == FAILED), "")
        otherwise = ", ".join(f"{count} {how}{why * (how == 'failed')}" for how, count in counts.items() if count)
        several = f"{len(self)} runs" + (f" ({otherwise})" if otherwise else "")
        over = f" over {listed(self.names)}" if self.names else ""
        measured = f"; {listed(self.measures)}" if self.measures else ""
        return f"<Runs of {self.scene}: {several}{over}{measured}>"

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
    def outcomes(self) -> tuple[str, ...]:
        """What came of the runs: measures, then coordinates and velocities at the end as `end(q1)`, where kept."""
        return tuple(dict.fromkeys((*self.measures, *self._ends)))

    @property
    def columns(self) -> tuple[str, ...]:
        """What was varied, then what came of it."""
        return (*self.names, *self.outcomes)

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the columns: `"m1" in runs`."""
        return iter(self.columns)

    def __getitem__(self, name: str | Sequence[str]) -> Array:
        """Return a column by its name, shape (N,), or several by a list of names, shape (N, len(names)).

        Raises:
            UnknownNameError: there is none; the message names a similar one.
        """
        check_arguments(Runs.__getitem__, locals(), UnknownNameError)
        if not isinstance(name, str):
            return np.array([self[one] for one in name]).reshape(-1, len(self)).T
        if name in self.measures:
            return self.measures[name]
        if name in self.names:
            return np.asarray(self.values[:, self.names.index(name)])
        if name in (ends := self._ends):
            return ends[name]
        raise UnknownNameError(f"{self.scene}: there is no column {name}; {choice(str(name), self.columns)}")

    @property
    def _ends(self) -> dict[str, Array]:
        if self.ends is None:
            return {}
        states = np.hstack([self.ends.q, self.ends.qd])
        return {f"end({name})": x for name, x in zip(self.ends.names, states.T, strict=True)}

    @property
    def _kept(self) -> Ends:
        if self.ends is None:
            raise SimulateError(
                f"{self.scene}: a sweep keeps measures alone; measure such as end(q1), or take symdyn.ensemble"
            )
        return self.ends

    @property
    def t(self) -> Array:
        """When each run ended, s, shape (N,); of `ensemble` alone, as are `q`, `qd` and `samples`."""
        return self._kept.t

    @property
    def q(self) -> Array:
        """Coordinates where runs ended, shape (N, nq)."""
        return self._kept.q

    @property
    def qd(self) -> Array:
        """Velocities where runs ended, shape (N, nv)."""
        return self._kept.qd

    @property
    def samples(self) -> Array | None:
        """States at the samples, shape (N, T, nq + nv); None where they were not asked for."""
        return self._kept.samples

    def quantiles(self, name: str | None = None, at: Sequence[float] = QUANTILES) -> Array:
        """Return quantiles of a column over the runs that have a value, shape (len(at),); NaN where none has.

        Here and below the only measure that there is needs no name.

        Raises:
            UnknownNameError: there is no such column.
            SimulateError: a quantile that is not from 0 to 1.
        """
        (at,) = walked(Runs.quantiles, locals(), "at", error=SimulateError)
        at = native(float, *at)
        if not all(0 <= one <= 1 for one in at):
            raise SimulateError(f"at = {quoted(list(at))}: quantiles are from 0 to 1, such as [0.05, 0.5, 0.95]")
        known = self.known(name)
        return np.quantile(known, at) if known.size else np.full(len(at), np.nan)

    def known(self, name: str | None = None) -> Array:
        """Return a column of the runs that have a value, shape (n,).

        Raises:
            UnknownNameError: there is no such column, or none is named and there are several measures.
        """
        if name is None and len(self.measures) != 1:
            raise UnknownNameError(f"name: give one of {', '.join(self.measures) or 'the columns'}")
        column = self[next(iter(self.measures)) if name is None else name]
        return np.asarray(column[np.isfinite(column)])

    def mean(self, name: str | None = None) -> float:
        """Return the mean of a column over the runs that have a value; NaN where none has."""
        known = self.known(name)
        with np.errstate(all="ignore"):
            return float(known.mean()) if known.size else np.nan

    def sd(self, name: str | None = None) -> float:
        """Return the standard deviation of a column over the runs that have a value; NaN for less than two."""
        known = self.known(name)
        with np.errstate(all="ignore"):
            return float(known.std(ddof=1)) if known.size > 1 else np.nan

    def extremes(self, name: str | None = None) -> tuple[float, float]:
        """Return the least and the largest number of a column; NaN where there is none."""
        known = self.known(name)
        return (float(known.min()), float(known.max())) if known.size else (np.nan, np.nan)

    def table(self) -> Rows:
        """Return names of columns and the numbers, shape (N, columns); the last one is the code of each run."""
        numbers = np.column_stack([*(self[name] for name in self), self.codes.astype(float)])
        return Rows((*self.columns, "ended"), numbers)

    def to_csv(self, file: str | Path | None = None) -> str:
        """Return the table as CSV with every digit, `ended` in words; of a file that it fills, the name.

        Raises:
            EmitError: the file cannot be written.
        """
        check_arguments(Runs.to_csv, locals(), EmitError)
        names, numbers = self.table()
        text = Table(names, [(*row, WORDS[int(code)]) for *row, code in numbers.tolist()]).csv()
        return text if file is None else str(write_file(file, text))

    def indices(self, measure: str | None = None, level: float = 0.95, resamples: int = 400, seed: int = 0) -> Indices:
        """Return Sobol's indices of a measure, with intervals.

        >>> import symdyn
        >>> runs = symdyn.sweep(symdyn.example("pendulum"), ["m=uniform(1,2)", "q1=uniform(0.1,0.2)"], "max(abs(q1))",
        ...     until=1, design="saltelli", count=8)
        >>> runs.indices("max(abs(q1))").names
        ('m', 'q1')

        Args:
            measure: a column of runs of the design "saltelli"; of one measure it need not be said.
            level: with which chance the intervals hold the indices.
            resamples: how often groups are drawn again for the intervals.
            seed: of these draws.

        Raises:
            SimulateError: another design, or too few groups whose runs all have a value.
            UnknownNameError: there is no such measure.
        """
        check_arguments(Runs.indices, locals(), SimulateError)
        return indices(self, measure, level, resamples, seed)

    def plot(self, *outcomes: str, kind: str | None = None, axes: Axes | Sequence[Axes] | None = None) -> Figure:
        """Return a figure of matplotlib, which a notebook shows: of all measures, or of some.

        Args:
            outcomes: names of measures, or such as `end(q1)` where ends are kept; none for all measures, or else ends.
            kind: a key of `symdyn.study.PLOTS`; None takes what fits: indices for their design, a curve over one
                name, a heat map over a grid of two, a tornado over a larger one, else histograms.
            axes: of a figure of yours, one a measure, to draw into; its figure is returned.

        Raises:
            SimulateError: no such measure or kind, one that does not fit, no run with a value, or no matplotlib.
        """
        check_arguments(Runs.plot, locals(), SimulateError)
        from symdyn.study.plots import figure

        return figure(self, outcomes, kind, axes)

    def save_plot(self, file: str | Path, kind: str | None = None) -> None:
        """Write a plot of all measures to a .svg, .pdf, .png or .html file; `kind` as of `plot`.

        Raises:
            SimulateError: another ending, or a file that cannot be written; and as of `plot`.
        """
        check_arguments(Runs.save_plot, locals(), SimulateError)
        from symdyn.study.plots import plot

        plot(self, Path(file), kind=kind)

    def drawn(self, kind: Literal["svg", "pdf", "png"]) -> bytes:
        """Return the plot of all measures that have values as a picture; errors as of `plot`."""
        check_arguments(Runs.drawn, locals(), SimulateError)
        from symdyn.study.plots import drawn_runs

        return drawn_runs(self, kind, [name for name in self.measures or self.outcomes if self.known(name).size])

    @property
    def has_indices(self) -> bool:
        """Whether its design is that of Sobol's indices."""
        return self.about.get("design") == SALTELLI

    def to_pandas(self) -> pandas.DataFrame:
        """Return the columns as a data frame, a row a run; `attrs` has their units and why runs failed.

        Raises:
            SimulateError: pandas is not installed.
        """
        pandas = package("pandas", SimulateError)
        found = pandas.DataFrame({name: self[name] for name in self.columns})
        found["ended"] = pandas.Categorical([WORDS[int(code)] for code in self.codes], list(WORDS.values()))
        found.attrs |= {"units": dict(self.units), "scene": self.scene, "reasons": dict(self.reasons), **self.about}
        return found
