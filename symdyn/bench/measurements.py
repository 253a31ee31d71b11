"""The nouns of this package: what was measured of one implementation, and all of it together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from symdyn.rounding import in_digits


@dataclass(frozen=True)
class Errors:
    """Distribution of the error of one implementation of one function over the states of one region.

    Attributes:
        region: where the states lie, a key of `REGIONS`.
        states: how many there are at which the function is finite.
        ulp: median, 99th percentile and maximum of the largest error of an entry, in ulps of the largest entry.
        condition: the same of the largest share of an entry's own running error bound: below 1 the code is as good as
            rounding every operation once allows, whatever the condition of the output.
        backward: the same of |M qdd + h - tau| / (|M||qdd| + |h| + |tau|), infinity norms, in units of the roundoff;
            None for what solves no linear equations.
    """

    region: str
    states: int
    ulp: tuple[float, float, float]
    condition: tuple[float, float, float]
    backward: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Measured:
    """One implementation of one function.

    Attributes:
        function: its name.
        way: how it is called, such as "C batch".
        real: "double", "float" or "dd".
        machine: "native", "portable", or "" where no compiler took part.
        formulation: the derivation that the code was generated from.
        operations: of one call, by name.
        generate: seconds to derive, lower and emit it.
        compile: seconds to compile it; None where nothing is compiled.
        call: nanoseconds a state.
        relative: 99th percentile of the error relative to the largest entry, in the worst region; NaN where there is no
            state at which the function is real.
        errors: by region.
        best: whether no other implementation of this function is both as fast and as accurate.
    """

    function: str
    way: str
    real: str
    machine: str
    formulation: str
    operations: Mapping[str, int]
    generate: float
    compile: float | None
    call: float
    relative: float
    errors: tuple[Errors, ...]
    best: bool = False

    @property
    def label(self) -> str:
        """What it is, in one phrase."""
        words = [self.way, self.formulation]
        words += [self.real] if self.real != "double" else []
        words += [self.machine] if self.machine == "portable" else []
        return ", ".join(words)

    @property
    def nanoseconds(self) -> str:
        """Time of a call in ns with three digits, without an exponent."""
        return in_digits(self.call, 3) if self.call < 1000 else f"{self.call:.0f}"


@dataclass(frozen=True)
class Point:
    """One trajectory.

    Attributes:
        tolerance: that was asked for.
        seconds: processor time of the integration.
        evaluations: of the right-hand side; steps where the method counts these.
        error: of the end, or the drift of the energy.
        best: whether no other point of any method is both as fast and as good.
    """

    tolerance: float
    seconds: float
    evaluations: int
    error: float
    best: bool = False


@dataclass(frozen=True)
class Curve:
    """Work and precision of one method, a point a tolerance."""

    method: str
    points: tuple[Point, ...]


@dataclass(frozen=True)
class MotionPrecision:
    """Work and precision of a scene's motion.

    Attributes:
        until, later: seconds of the motions whose end and whose energy are looked at.
        reference: how the end was found that all are judged by.
        uncertain: how far that may be off; no smaller error is told.
        precision: error of the end, a curve a method.
        drift: largest drift of the energy over its size, a curve a method.
        notes: what was left out and why.
    """

    until: float
    later: float
    reference: str
    uncertain: float
    precision: tuple[Curve, ...]
    drift: tuple[Curve, ...]
    notes: tuple[str, ...] = ()

    @property
    def choices(self) -> list[tuple[Curve, Point]]:
        """The Pareto-best points of all curves of precision, the fastest first."""
        return sorted(((c, p) for c in self.precision for p in c.points if p.best), key=lambda pair: pair[1].seconds)


@dataclass(frozen=True)
class Bench:
    """Run time against error of a scene's functions.

    Attributes:
        scene: its name.
        command: what makes the report again.
        about: the machine, in pairs of words.
        regions: what each region is, by name.
        measured: every function and implementation.
        motion: work and precision of trajectories; None where none were computed.
        notes: what was left out and why.
    """

    scene: str
    command: str
    about: tuple[tuple[str, str], ...]
    regions: Mapping[str, str]
    measured: tuple[Measured, ...]
    motion: MotionPrecision | None = None
    notes: tuple[str, ...] = ()

    @property
    def functions(self) -> tuple[str, ...]:
        """Names of the functions, in order."""
        return tuple(dict.fromkeys(one.function for one in self.measured))

    def best(self, function: str) -> list[Measured]:
        """Return the Pareto-best implementations of a function, the fastest first."""
        return sorted((one for one in self.measured if one.function == function and one.best), key=lambda one: one.call)

    def as_dict(self) -> dict[str, Any]:
        """Return the report for JSON."""
        return asdict(self)

    def files(self) -> dict[str, str]:
        """Return the reports by the names of their files: a page, Markdown, and JSON without what is not finite."""
        from symdyn.bench.report import bench_files

        return bench_files(self)


SAME = 1.25
"""Errors that differ by less than this factor are the same: a few states tell no more."""


def unbeaten(pairs: Sequence[tuple[float, float]]) -> list[bool]:
    """Return of each pair of time and error whether it is finite and no other one is faster and as accurate."""
    return [
        math.isfinite(error) and not any(other < time and off <= SAME * error for other, off in pairs)
        for time, error in pairs
    ]
