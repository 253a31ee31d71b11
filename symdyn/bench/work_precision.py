"""Work against precision of a scene's motion: a curve a method, a point a tolerance.

Over a short time the error of the end is measured, against more digits than a double has; over a long one the drift of
the energy, with the work of what takes it or gives it counted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from symdyn.bench.measurements import Curve, MotionPrecision, Point, unbeaten
from symdyn.errors import SimulateError
from symdyn.extras import install
from symdyn.scene import Scene, SceneUnits
from symdyn.simulation import METHODS, TimedRuns

Array = npt.NDArray[np.float64]

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
        progress: told what is being done.

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
        if quick and name not in QUICK_METHODS:
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
    """Yield a point a tolerance until they take too long; an error below what is known is told as that."""
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
