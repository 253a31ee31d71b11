"""The nouns of this package: what was measured of one implementation, and all of it together; hard cases.

Of a scene's motion it is work against precision: a curve a method, a point a tolerance. Over a short time the error of
the end is measured, against more digits than a double has; over a long one the drift of the energy, with the work of
what takes it or gives it counted.

A hard case has its metric, its bound and what was measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.extras import install
from symdyn.frozen import asdict, dataclass, replace
from symdyn.rounding import in_digits
from symdyn.scene import Scene, SceneUnits
from symdyn.simulation import METHODS, TimedRuns, Trajectory
from symdyn.table import Table
from symdyn.verdict import Claims, Judged, Unclaimed, Verdict


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
        variant: how it is called, such as "C batch".
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
    variant: str
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
        words = [self.variant, self.formulation]
        words += [self.real] if self.real != "double" else []
        words += [self.machine] if self.machine == "portable" else []
        return ", ".join(words)

    @property
    def nanoseconds(self) -> str:
        """Time of a call in ns with three digits, without an exponent."""
        return in_digits(self.call, 3) if self.call < 1000 else f"{self.call:.0f}"


@dataclass(frozen=True)
class Point:
    """One trajectory."""

    tolerance: float  # that was asked for
    seconds: float  # processor time of the integration
    evaluations: int  # of the right-hand side; steps where the method counts these
    error: float  # of the end, or the drift of the energy
    best: bool = False  # whether no other point of any method is both as fast and as good


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
        uncertain: how far that may be off; no smaller error is reported.
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
        return tuple(dict.fromkeys(one.function for one in self.measured))

    def best(self, function: str) -> list[Measured]:
        """Return the Pareto-best implementations of a function, the fastest first."""
        return sorted((one for one in self.measured if one.function == function and one.best), key=lambda one: one.call)

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)

    def files(self) -> dict[str, str]:
        """Return the reports by the names of their files: a page, Markdown, and JSON without what is not finite."""
        from symdyn.bench.report import files, html, markdown

        return files("bench", html(self), markdown(self), self.as_dict())


SAME = 1.25
"""Errors that differ by less than this factor are the same: a few states show no more."""


def unbeaten(pairs: Sequence[tuple[float, float]]) -> list[bool]:
    """Return of each pair of time and error whether it is finite and no other one is faster and as accurate."""
    return [
        math.isfinite(error) and not any(other < time and off <= SAME * error for other, off in pairs)
        for time, error in pairs
    ]


QUICK_METHODS = ("taylor", "dop853", "radau", "lsoda", "cvode")
TOLERANCES, QUICK = tuple(10.0**-k for k in range(3, 14)), (1e-3, 1e-6, 1e-9, 1e-12)
LONG, LONG_QUICK = (1e-6, 1e-9, 1e-12), (1e-6, 1e-9)
UNTIL, LATER, LATER_QUICK = 2.0, 100.0, 10.0
"""Seconds of the short motion and of the long one."""

PATIENCE, PATIENCE_QUICK = 3.0, 0.08
"""Seconds of one method after which its finer tolerances, and long runs, are left out."""

AGAIN = 0.02
"""Runs that are shorter, s, are timed three times."""

SAMPLES = 401


def motion(scene: Scene, quick: bool = False, progress: Callable[[str], None] = lambda _: None) -> MotionPrecision:
    """Return work and precision of the motion without drives, by every method whose library is installed.

    Args:
        scene: the mechanism; it starts as `lively` says.
        quick: few methods and tolerances, and little patience.
        progress: takes what is being done.

    Raises:
        SimulateError: the scene cannot be simulated, has parameters without values, or no accelerations at its start.
        DerivationError: there is no forward dynamics.
    """
    progress("a reference of the motion")
    runs = TimedRuns.of(scene, lively(scene))
    known = runs.truth(UNTIL)
    if known.distance(runs.x) == 0:
        raise SimulateError(f"{scene.name}: nothing moves from its start; give joints start or start_rates")
    notes, slow, precise, drifts = [], [], [], []
    tolerances, patience = (QUICK, PATIENCE_QUICK) if quick else (TOLERANCES, PATIENCE)
    later = LATER_QUICK if quick else LATER
    for name, method in METHODS.items():
        if (quick and name not in QUICK_METHODS) or method.step is not None:
            continue
        why = "" if method.installed else f"{method.library} is not installed; {install(method.extra)}"
        why = why or method.refuses(runs.system)
        if why:
            notes.append(f"{name} was not measured: {why}")
            continue
        progress(f"work and precision of {name}")
        points = tuple(_points(runs, name, tolerances, patience, known.distance, known.uncertain))
        if len(points) < len(tolerances):
            slow.append(f"{name} below {points[-1].tolerance:.0e}" if points else name)
        precise.append(Curve(name, points))
        wanted = [p for p in points if p.tolerance in (LONG_QUICK if quick else LONG)]
        drifts.append(Curve(name, tuple(_drifts(runs, name, wanted, later, patience))))
    if slow:
        notes.append(f"Left out, for they take over {patience:g} s or fail: {', '.join(slow)}")
    return MotionPrecision(
        UNTIL, later, known.how, known.uncertain, tuple(marked(precise)), tuple(marked(drifts)), tuple(notes)
    )  # fmt: skip


def lively(scene: Scene) -> dict[str, str]:
    """Return a start away from rest for a tree that says nothing about it: half a radian, a tenth of a metre."""
    if scene.loops or any(joint.start or joint.start_rates or joint.motion for joint in scene.joints):
        return {}
    amounts = {"rad": "1/2", "m": "1/10"}
    return {
        name: amounts[unit]
        for name, unit in zip(scene.coordinates, SceneUnits(scene).coordinates, strict=True)
        if unit in amounts
    }


def marked(curves: Sequence[Curve]) -> list[Curve]:
    """Return the curves without empty ones, those points marked that no other one beats in both time and error."""
    best = iter(unbeaten([(p.seconds, p.error) for curve in curves for p in curve.points]))
    found = [replace(c, points=tuple(replace(p, best=next(best)) for p in c.points)) for c in curves]
    return [curve for curve in found if curve.points]


def _points(
    runs: TimedRuns,
    name: str,
    tolerances: Sequence[float],
    patience: float,
    distance: Callable[[Array], float],
    least: float,
) -> Iterator[Point]:
    """Yield a point a tolerance until they take too long; an error below what is known is reported as that."""
    spent = before = last = 0.0
    for tolerance in tolerances:
        expected = last * last / before if before else last
        if spent + expected > patience:
            return
        try:
            made = runs.run(name, tolerance, UNTIL)
            took = made.seconds
            if took < AGAIN:
                took = min(took, *(runs.run(name, tolerance, UNTIL).seconds for _ in range(2)))
        except SimulateError:
            return
        spent, before, last = spent + took, last, took
        yield Point(tolerance, took, made.evaluations, max(distance(made.x[-1]), least))


def _drifts(runs: TimedRuns, name: str, points: Sequence[Point], later: float, patience: float) -> Iterator[Point]:
    """Yield the largest drift of the energy over a long run, where the short one says that it ends in time."""
    for point in points:
        if point.seconds * later / UNTIL > 2 * patience:
            return
        try:
            made = runs.run(name, point.tolerance, later, SAMPLES)
        except SimulateError:
            return
        yield Point(point.tolerance, made.seconds, made.evaluations, runs.drift(made, later))


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
        not_run: what this machine cannot run, of families that were not asked for by name.
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
        cases = [{"family": c.family, **asdict(c), "verdict": c.verdict, "passed": c.passed} for c in self.cases]
        return {**asdict(self), "cases": cases, **self._verdicts()}

    @property
    def table(self) -> Table[str]:
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
        from symdyn.bench.report import files, stress_html, stress_markdown

        return files("stress", stress_html(self), stress_markdown(self), self.as_dict())


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
