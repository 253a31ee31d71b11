"""What output error has found: parameters, starts, and what the data leave open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import UnknownNameError
from symdyn.rounding import in_digits
from symdyn.scene import Scene, bind
from symdyn.scene.values import listed, suggestion
from symdyn.shown import Shown
from symdyn.table import Table


@dataclass(frozen=True, eq=False)
class OutputFit(Shown):
    """Parameters with which a simulated run is closest to measured columns.

    Attributes:
        scene: the mechanism, its parameters as they were.
        names: of what was estimated: parameters, then positions and velocities of the starts, `start x` or, of more
            than one piece, `start 2 x`.
        units: likewise.
        before: values that the scene gives, and guesses of starts, shape (k,).
        estimate: shape (k,).
        covariance: shape (k, k), from the scatter of the residuals, taken as independent from sample to sample.
        parameters: how many of the names are parameters.
        measured: names of the columns that were fitted.
        noise: standard deviation of the residuals of each, shape (m,).
        correlation: of their residuals from one sample to the next, shape (m,).
        residuals: by piece of the log: simulated less measured, shape (N, m).
        t: by piece: times, s, shape (N,).
        condition: number of the weighted Jacobian, its columns scaled to length one.
        dof: samples less estimates.
        runs: how many runs were taken.
        notes: what a user should know.
    """

    scene: Scene
    names: tuple[str, ...]
    units: tuple[str, ...]
    before: Array = field(repr=False)
    estimate: Array = field(repr=False)
    covariance: Array = field(repr=False)
    parameters: int
    measured: tuple[str, ...]
    noise: Array = field(repr=False)
    correlation: Array = field(repr=False)
    residuals: tuple[Array, ...] = field(repr=False)
    t: tuple[Array, ...] = field(repr=False)
    condition: float
    dof: int
    runs: int
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        parts = zip(self.names[: self.parameters], self.estimate, self.standard_errors, strict=False)
        said = ", ".join(f"{name} = {value:.5g} ± {error:.2g}" for name, value, error in parts)
        return f"<OutputFit of {self.scene.name} to {listed(self.measured)}: {said}>"

    def __getitem__(self, name: str) -> float:
        """Return an estimate by its name; UnknownNameError if there is none."""
        return float(self.estimate[self._place(name)])

    @property
    def standard_errors(self) -> Array:
        """Of every estimate, shape (k,)."""
        return np.sqrt(np.diag(self.covariance))

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """Return the ends of an interval that holds the true value with a probability."""
        from scipy.stats import t

        k = self._place(name)
        reach = float(t.ppf(0.5 + level / 2, self.dof) * self.standard_errors[k])
        return float(self.estimate[k]) - reach, float(self.estimate[k]) + reach

    @property
    def values(self) -> Mapping[str, float]:
        """Estimates of parameters by name."""
        return dict(zip(self.names[: self.parameters], self.estimate.tolist(), strict=False))

    @property
    def identified(self) -> Scene:
        """The scene with the parameters that were found."""
        return bind(self.scene, self.values)

    def table(self) -> Table[str]:
        """Return name, unit, before, after and standard error of every estimate."""
        columns = zip(self.names, self.units, self.before, self.estimate, self.standard_errors, strict=True)
        rows = [
            (name, unit, in_digits(before, 5), in_digits(after, 5), in_digits(error, 2))
            for name, unit, before, after, error in columns
        ]
        heads = ("parameter", "unit", "before", "after", "standard error")
        return Table(heads, rows, range(2, 5), f"parameters of {self.scene.name}")

    def _place(self, name: str) -> int:
        if name not in self.names:
            raise UnknownNameError(f"{name} is not there; {suggestion(name, self.names)}")
        return self.names.index(name)
