"""The nouns of the stress test: a case with its metric, its bound and what was measured; all cases together."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from symdyn.simulation import Trajectory
from symdyn.simulation.trajectory import END


@dataclass(frozen=True)
class Case:
    """One hard case.

    Attributes:
        name: what is hard about it.
        metric: what is measured.
        bound: what it must not exceed.
        measured: the largest value of all implementations, states and times.
        worst: where that was, such as the implementation.
        family: a key of `FAMILIES`, which enters it.
    """

    name: str
    metric: str
    bound: float
    measured: float
    worst: str = ""
    family: str = ""

    @property
    def passed(self) -> bool:
        """Whether the bound holds; what is no number does not."""
        return bool(math.isfinite(self.measured) and self.measured <= self.bound)


@dataclass(frozen=True)
class Stress:
    """All cases of a run.

    Attributes:
        scene: whose scene, "" for the built-in ones.
        command: what runs it again.
        cases: in order.
        notes: what was left out and why.
    """

    scene: str
    command: str
    cases: tuple[Case, ...]
    notes: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether every case passed."""
        return all(case.passed for case in self.cases)

    def as_dict(self) -> dict[str, Any]:
        """Return the table for JSON."""
        cases = [{"family": c.family, **asdict(c), "passed": c.passed} for c in self.cases]
        return {**asdict(self), "cases": cases, "passed": self.passed}


def worst(pairs: list[tuple[float, str]]) -> tuple[float, str]:
    """Return the largest value and where it was; what is no number is larger than all."""
    return max(pairs, key=lambda pair: math.inf if math.isnan(pair[0]) else pair[0], default=(0.0, ""))


def of_motion(name: str, metric: str, bound: float, measured: float, made: Trajectory) -> Case:
    """Return a case about a motion; one that ends too early exceeds every bound."""
    ended = made.stopped == END
    return Case(name, metric, bound, float(measured) if ended else math.inf, made.method if ended else made.stopped)


def energy_drift(made: Trajectory) -> float:
    """Return the largest error of the balance of energy over its size."""
    return made.monitors["energy"] / (made.monitors["energy_scale"] or 1.0)
