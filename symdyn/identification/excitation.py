"""Exciting motions: `Excitation`, the families of periodic motions that it is sought in, and what is minimised.

A coordinate moves by a row of functions of time times coefficients:

    q = Φ(t) z,  q̇ = Φ̇(t) z,  q̈ = Φ̈(t) z           Φ: one constant, then functions that rest at t = 0 and T

Every family is restricted to motions whose velocity and acceleration vanish where a period begins. So a drive starts
and ends at rest, and a log of several periods can be averaged over them.

Criteria are functions of the singular values σ of the stacked base regressor:

    condition            σ_max / σ_min of the rows as they are, over the noise of each drive
    scaled_condition     the same of columns of length 1: no unit of a parameter weighs
    determinant          -ln det(AᵀA), A the rows over √N: the volume of the ellipsoid of errors

A condition number has no derivative where two singular values meet, which is where its minimum is. In its place |A|_16
|A⁺|_16 is minimised, in the norm (Σ σ^16)^(1/16), which is larger by p^(1/8) at most.

References: Gautier and Khalil, Exciting trajectories for the identification of base inertial parameters (1992);
Swevers, Ganseman, Tükel, De Schutter and Van Brussel, Optimal robot excitation and identification (1997), for Fourier
series and the determinant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, ClassVar

import numpy as np

from symdyn.algebra import Array
from symdyn.frozen import dataclass
from symdyn.identification.bounds import Bound
from symdyn.rounding import in_digits
from symdyn.scene import Scene
from symdyn.shown import Shown
from symdyn.simulation import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure


NORM = 16
"""Exponent of the norms that stand for the largest of singular values."""

LEAST = 1e-13
"""Eigenvalue of AᵀA, over the largest, below which its digits mean nothing."""


@dataclass(frozen=True)
class Criterion:
    """What is made small.

    Attributes:
        text: what it is, one line.
        scaled: whether columns are divided by their lengths before.
        smooth: from singular values, shape (p,), to a number and its slopes, shape (p,).
        displayed: from singular values to the number that a user is shown.
    """

    text: str
    scaled: bool
    smooth: Callable[[Array], tuple[float, Array]]
    displayed: Callable[[Array], float]

    def value(self, A: Array) -> float:
        """Return what a user is shown of rows A, shape (N, n, p)."""
        rows = A.reshape(-1, A.shape[-1])
        sizes = np.linalg.svd(rows / _lengths(A) if self.scaled else rows, compute_uv=False)
        return self.displayed(np.asarray(sizes, dtype=np.float64))

    def slope(self, A: Array) -> tuple[float, Array]:
        """Return the smooth number of rows A, shape (N, n, p), and its slope by every entry, of the same shape.

        Products go instant by instant: on matrices of a few hundred rows, threads of BLAS wait longer than they work.
        """
        length = _lengths(A) if self.scaled else np.ones(A.shape[-1])
        B = A / length
        squares, V = np.linalg.eigh(np.matmul(B.transpose(0, 2, 1), B).sum(axis=0))
        sizes = np.sqrt(np.maximum(squares, LEAST * squares[-1]))
        value, slopes = self.smooth(sizes)
        found = np.matmul(B, (V * (slopes / sizes)) @ V.T)
        if self.scaled:
            found = (found - B * (found * B).sum(axis=(0, 1))) / length
        return value, found


def _lengths(A: Array) -> Array:
    length = np.sqrt((A**2).sum(axis=(0, 1)))
    return np.where(length > 0, length, 1.0)


def _condition(sizes: Array) -> tuple[float, Array]:
    large, small = (sizes / sizes.max()) ** NORM, (sizes.min() / sizes) ** NORM
    value = np.log(sizes.max() / sizes.min()) + (np.log(large.sum()) + np.log(small.sum())) / NORM
    return float(value), (large / large.sum() - small / small.sum()) / sizes


def _determinant(sizes: Array) -> tuple[float, Array]:
    return float(-2 * np.log(sizes).mean()), -2 / len(sizes) / sizes


def _ratio(sizes: Array) -> float:
    return float(sizes[0] / sizes[-1]) if sizes[-1] > 0 else float("inf")


def _volume(sizes: Array) -> float:
    return float(-2 * np.log(sizes).sum()) if sizes[-1] > 0 else float("inf")


CRITERIA: Mapping[str, Criterion] = {
    "condition": Criterion("condition number of the base regressor", False, _condition, _ratio),
    "scaled_condition": Criterion("condition number of its columns, each of length 1", True, _condition, _ratio),
    "determinant": Criterion("-ln det of the information matrix a sample", False, _determinant, _volume),
}


DEGREE = 5
"""Of the splines: accelerations are cubic, their second rates continuous."""


@dataclass(frozen=True)
class Basis:
    """A row of functions of time at N times, shape (N, k) each."""

    position: Array  # values; the first column is 1, no other has a size far from 1
    rate: Array  # first derivatives, 1/s
    second: Array  # second derivatives, 1/s^2

    @property
    def count(self) -> int:
        """How many functions there are."""
        return int(self.position.shape[1])


@dataclass(frozen=True)
class Family:
    """A family of periodic motions.

    Attributes:
        text: what it is, one line.
        least: fewest terms with which anything moves.
        functions: (times in periods, terms) to values, first and second derivatives by that time, shape (N, k) each,
            the constant left out.
    """

    text: str
    least: int
    functions: Callable[[Array, int], tuple[Array, Array, Array]]

    def basis(self, t: Array, period: float, terms: int) -> Basis:
        """Return the functions at times (N,), s, those that do not rest where a period begins left out."""
        from scipy.linalg import null_space

        _, rate, second = self.functions(np.zeros(1), terms)
        rest = np.vstack([rate, second])
        resting = null_space(rest / np.abs(rest).max(axis=1, keepdims=True))
        resting = resting * np.sign(resting[np.abs(resting).argmax(axis=0), np.arange(resting.shape[1])])
        x, v, a = (part @ resting for part in self.functions(np.asarray(t) / period, terms))
        none = np.zeros((len(x), 1))
        return Basis(np.hstack([none + 1, x]), np.hstack([none, v]) / period, np.hstack([none, a]) / period**2)


def _fourier(phase: Array, terms: int) -> tuple[Array, Array, Array]:
    """Return sines and cosines of 1 to `terms` rounds a period, the l-th over l."""
    order = np.arange(1, terms + 1)
    pace = 2 * np.pi * order
    angle = phase[:, None] * pace
    sine, cosine = np.sin(angle) / order, np.cos(angle) / order
    return (
        np.hstack([sine, cosine]),
        np.hstack([cosine * pace, -sine * pace]),
        -np.hstack([sine * pace**2, cosine * pace**2]),
    )


def _splines(phase: Array, terms: int) -> tuple[Array, Array, Array]:
    """Return periodic B-splines of degree 5 on 2 terms + 1 equal intervals; together they are 1, so one is left out."""
    from scipy.interpolate import BSpline

    intervals = 2 * terms + 1
    knots = np.arange(-DEGREE, intervals + DEGREE + 1) / intervals
    wrapped = np.vstack([np.eye(intervals), np.eye(intervals)[:DEGREE]])
    curve = BSpline(knots, wrapped, DEGREE)
    inside = phase % 1.0
    x, v, a = (np.asarray(curve(inside, nu=order), dtype=np.float64)[:, 1:] for order in range(3))
    return x, v, a


FAMILIES: Mapping[str, Family] = {
    "fourier": Family("Fourier series: sines and cosines of whole rounds a period", 2, _fourier),
    "splines": Family("periodic splines of degree 5, twice as many intervals as terms and one", 2, _splines),
}


@dataclass(frozen=True)
class Improved:
    """One start of the search and what became of it.

    Attributes:
        before, after: the criterion at the start as it was drawn, and in the end.
        keeps: whether what was found keeps all limits.
    """

    before: float
    after: float
    keeps: bool


@dataclass(frozen=True)
class Reached:
    """How near a motion comes to a limit.

    Attributes:
        bound: the limits.
        low, high: smallest and largest value over the whole period.
        active: whether it comes nearer to one of them than a fiftieth of the range.
    """

    bound: Bound
    low: float
    high: float
    active: bool


@dataclass(frozen=True, eq=False)
class Excitation(Shown):
    """A periodic motion from which base parameters are well identifiable; it starts and ends at rest.

    Attributes:
        run: the motion with the forces that the scene predicts; rows from 0 to the period.
        family, criterion: of `families` and `criteria`.
        period: s.
        terms: of the family.
        seed: what repeats it.
        condition: condition number of the base regressor over the noise of the drives, rows of one period.
        scaled_condition: the same, each column divided by its length.
        determinant: -ln det of AᵀA, A those rows over √N.
        starts: of the search, in order.
        reached: what has limits, and how near the motion comes.
        margin: least distance to a limit between samples too, in parts of half its range.
        coefficients: of the family's functions by coordinate, rad or m, shape (k, nq).
        notes: what a user should know.
        families, criteria: those that there are.
    """

    families: ClassVar[tuple[str, ...]] = tuple(FAMILIES)
    criteria: ClassVar[tuple[str, ...]] = tuple(CRITERIA)

    run: Trajectory
    family: str
    criterion: str
    period: float
    terms: int
    seed: int
    condition: float
    scaled_condition: float
    determinant: float
    starts: tuple[Improved, ...]
    reached: tuple[Reached, ...]
    margin: float
    coefficients: Array
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        kept = f"{len(self.run.t)} rows, {self.period:g} s"
        return f"<Excitation of {self.scene.name}: {self.family}, {kept}, condition {in_digits(self.condition, 4)}>"

    @property
    def scene(self) -> Scene:
        """The mechanism."""
        return self.run.scene

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self.run.names

    @property
    def t(self) -> Array:
        """Times, s, shape (N,)."""
        return self.run.t

    @property
    def q(self) -> Array:
        """Coordinates, rad or m, shape (N, nq)."""
        return self.run.q

    @property
    def qd(self) -> Array:
        """Velocities, shape (N, nv)."""
        return self.run.qd

    @property
    def qdd(self) -> Array:
        """Accelerations, shape (N, nv)."""
        return self.run.qdd

    @property
    def tau(self) -> Array:
        """Driving forces that the scene predicts, shape (N, nv)."""
        return self.run.tau

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the limits that the motion goes to."""
        return tuple(one.bound.name for one in self.reached if one.active)

    def to_csv(self, file: str | Path | IO[str] | None = None) -> str:
        """Return the motion as CSV, which `inverse` and `identify` read; of a file that it fills, the name.

        Raises:
            EmitError: the file cannot be written, or takes no text.
        """
        return self.run.to_csv(file)

    def plot(self, *names: str | Sequence[str | Sequence[str]], **options: Any) -> Figure:
        """Return a figure of the motion, all as of `Trajectory.plot`."""
        return self.run.plot(*names, **options)

    def lines(self) -> list[str]:
        """Return its description, line by line."""
        best = min((one for one in self.starts if one.keeps), key=lambda one: one.after, default=None)
        found = [
            f"{self.scene.name}: {self.family}, {self.terms} terms, {self.period:g} s, seed {self.seed}",
            f"condition number {in_digits(self.condition, 4)}, of columns of length 1 "
            f"{in_digits(self.scaled_condition, 4)}, -ln det {in_digits(self.determinant, 5)}",
        ]
        for k, one in enumerate(self.starts):
            kept = " *" if one is best else "" if one.keeps else " (leaves limits)"
            found.append(f"start {k + 1}: {in_digits(one.before, 4)} -> {in_digits(one.after, 4)}{kept}")
        found.append(f"limits kept, by {in_digits(100 * self.margin, 3)} % of half the range at least")
        found.append(f"limits that it goes to: {', '.join(self.active) or 'none'}")
        return found

    def as_json(self) -> dict[str, Any]:
        """Return the same as a JSON value."""
        return {
            "scene": self.scene.name,
            "family": self.family,
            "criterion": self.criterion,
            "period": self.period,
            "terms": self.terms,
            "seed": self.seed,
            "condition": self.condition,
            "scaled_condition": self.scaled_condition,
            "determinant": self.determinant,
            "starts": [{"before": one.before, "after": one.after, "keeps": one.keeps} for one in self.starts],
            "limits": {
                one.bound.name: {"low": one.low, "high": one.high, "active": one.active} for one in self.reached
            },
            "margin": self.margin,
            "notes": list(self.notes),
        }
