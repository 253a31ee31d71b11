"""What an exciting motion is: `Excitation`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, ClassVar

from symdyn.algebra import Array
from symdyn.identification.bounds import Bound
from symdyn.identification.criteria import CRITERIA
from symdyn.identification.families import FAMILIES
from symdyn.rounding import in_digits
from symdyn.scene import Scene
from symdyn.shown import Shown
from symdyn.simulation import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
        active: whether it comes nearer to one of them than a fiftieth of the room.
    """

    bound: Bound
    low: float
    high: float
    active: bool


@dataclass(frozen=True, eq=False)
class Excitation(Shown):
    """A periodic motion that tells base parameters well; it starts and ends at rest, and further periods may follow.

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
        margin: least distance to a limit between samples too, in parts of half its room.
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
        """Return the motion as CSV, which `inverse` and `identify` read; written to a file if given.

        Raises:
            EmitError: the file cannot be written, or takes no text.
        """
        return self.run.to_csv(file)

    def plot(self, *names: str | Sequence[str]) -> Figure:
        """Return a figure of matplotlib: coordinates, velocities and forces, or the columns that are named.

        Raises:
            UnknownNameError: there is no such column.
            SimulateError: matplotlib is not installed.
        """
        return self.run.plot(*names)

    def lines(self) -> list[str]:
        """Return what is told of it, line by line."""
        best = min((one for one in self.starts if one.keeps), key=lambda one: one.after, default=None)
        found = [
            f"{self.scene.name}: {self.family}, {self.terms} terms, {self.period:g} s, seed {self.seed}",
            f"condition number {in_digits(self.condition, 4)}, of columns of length 1 "
            f"{in_digits(self.scaled_condition, 4)}, -ln det {in_digits(self.determinant, 5)}",
        ]
        for k, one in enumerate(self.starts):
            kept = " *" if one is best else "" if one.keeps else " (leaves limits)"
            found.append(f"start {k + 1}: {in_digits(one.before, 4)} -> {in_digits(one.after, 4)}{kept}")
        found.append(f"limits kept, by {in_digits(100 * self.margin, 3)} % of half the room at least")
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
