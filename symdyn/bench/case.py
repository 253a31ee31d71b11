"""The nouns of the stress test: a case with its metric, its bound and what was measured; all cases together."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

from symdyn.rounding import in_digits
from symdyn.simulation import Trajectory
from symdyn.table import Table
from symdyn.verdict import Claims, Judged, Unclaimed, Verdict

NOTHING = "nothing could be compared"
HARD = ("family", "case", "metric", "bound", "measured", "passed", "worst")


@dataclass(frozen=True)
class Case:
    """One hard case.

    Attributes:
        name: what is hard about it.
        metric: what is measured.
        bound: what it must not exceed.
        measured: the largest value of all implementations, states and times; None where there was nothing to compare.
        worst: where that was, such as the implementation.
        family: a key of `FAMILIES`, which enters it.
    """

    name: str
    metric: str
    bound: float
    measured: float | None
    worst: str = ""
    family: str = ""

    @property
    def verdict(self) -> str:
        """One of `symdyn.verdict`: whether the bound holds; what is no number fails."""
        if self.measured is None:
            return Verdict.of(0)
        return Verdict.of(1, not (math.isfinite(self.measured) and self.measured <= self.bound))

    @property
    def passed(self) -> bool:
        """Whether something was measured, and the bound holds."""
        return self.verdict in Verdict.HOLD


@dataclass(frozen=True)
class Stress(Claims):
    """All cases of a run.

    Attributes:
        scene: whose scene, "" for the built-in ones.
        command: what runs it again.
        cases: in order.
        absent: families that are not about such a scene, and what does not exist there.
        not_run: what this machine cannot run, of families that nobody asked for by name.
        unshown: likewise of families that were asked for, and what has no value, or none that is real.
    """

    scene: str
    command: str
    cases: tuple[Case, ...]
    absent: tuple[Unclaimed, ...] = ()
    not_run: tuple[Unclaimed, ...] = ()
    unshown: tuple[Unclaimed, ...] = ()

    @property
    def claims(self) -> tuple[Judged, ...]:
        """What was claimed, and what became of it: a claim a case."""
        found = [
            Judged(f"{one.name}, {one.metric}", one.verdict, "" if one.passed else one.worst) for one in self.cases
        ]
        found += [Judged(one.what, Verdict.NOT_SHOWN, one.why) for one in self.unshown]
        return tuple(found)

    def as_dict(self) -> dict[str, Any]:
        """Return the table for JSON."""
        cases = [{"family": c.family, **asdict(c), "verdict": c.verdict, "passed": c.passed} for c in self.cases]
        return {**asdict(self), "cases": cases, **self.verdicts()}

    @property
    def table(self) -> Table[str]:
        """The cases, a row each."""
        rows = [
            (
                c.family,
                c.name,
                c.metric,
                in_digits(c.bound, 2),
                "" if c.measured is None else in_digits(c.measured, 2),
                "pass" if c.passed else "FAIL" if c.verdict == Verdict.DIFFERENT else c.verdict,
                c.worst,
            )
            for c in self.cases
        ]
        return Table(HARD, rows, (3, 4), f"{self.scene or 'built-in scenes'}: hard cases")

    def files(self) -> dict[str, str]:
        """Return the reports by the names of their files: a page, Markdown, and JSON without what is not finite."""
        from symdyn.bench.report import stress_files

        return stress_files(self)


def worst(pairs: Iterable[tuple[float | None, str]], nothing: str = NOTHING) -> tuple[float | None, str]:
    """Return the largest value and where it was; what is no number is larger than all.

    None stands for what could not be compared, and where all is such, it is what is returned, with `nothing`.
    """
    made = [(value, where) for value, where in pairs if value is not None]
    return max(made, key=lambda pair: math.inf if math.isnan(pair[0]) else pair[0], default=(None, nothing))


def of_motion(name: str, metric: str, bound: float, measured: float, made: Trajectory) -> Case:
    """Return a case about a motion; one that ends too early exceeds every bound."""
    return Case(
        name, metric, bound, float(measured) if made.ended else math.inf, made.method if made.ended else made.stopped
    )


def energy_drift(made: Trajectory) -> float:
    """Return the largest error of the balance of energy over its size."""
    return made.monitors["energy"] / (made.monitors["energy_scale"] or 1.0)
