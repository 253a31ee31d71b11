"""Work against precision of a scene's motion: one point a tolerance and method, error against a finer reference.

The reference is the Taylor method at machine epsilon where it applies, else DOP853 at its finest. Its own error is seen
from a second one, at a tolerance ten times as coarse, and no error is told that is smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from symdyn.bench.model import Curve, Point
from symdyn.errors import SimulateError
from symdyn.scene import JOINTS, Scene
from symdyn.simulate import METHODS, Trajectory, simulate
from symdyn.simulate.integrate import importable

TOLERANCES = tuple(10.0**-k for k in range(3, 14))
FINEST = {"taylor": (1e-15, 1e-14), "dop853": (2.3e-14, 2.3e-13)}

LONGEST = 3.0
"""Seconds of one method after which its finer tolerances are left out."""


def curves(
    scene: Scene,
    until: float = 2.0,
    methods: Sequence[str] | None = None,
    tolerances: Sequence[float] = TOLERANCES,
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[Curve, ...]:
    """Return work and precision of the motion without drives, a curve a method; see `lively` for its start.

    Args:
        scene: the mechanism, its parameters bound.
        until: seconds of motion.
        methods: keys of `METHODS`; None takes all whose library is installed.
        tolerances: relative, in falling order.
        progress: told what is being done.

    Raises:
        SimulateError: the scene cannot be simulated at all.
        DerivationError: there is no forward dynamics.
    """
    progress("a reference of the motion")
    start = lively(scene)
    reference, floor = _reference(scene, until, start)
    found = []
    for name, method in METHODS.items():
        if not importable(method.module) or (methods is not None and name not in methods):
            continue
        progress(f"work and precision of {name}")
        points = tuple(_points(scene, until, start, name, tolerances, reference, floor))
        if points:
            found.append(Curve(name, points))
    return tuple(found)


def lively(scene: Scene) -> dict[str, str]:
    """Return a start away from rest for a tree that says nothing about it: half a radian, a tenth of a metre."""
    if scene.loops or any(joint.start or joint.start_rates or joint.motion for joint in scene.joints):
        return {}
    amounts = {"rad": "1/2", "m": "1/10"}
    return {
        name: amounts[unit]
        for joint in scene.moving
        for name, unit in zip(joint.coordinates, JOINTS[joint.type].coordinates(joint), strict=True)
        if unit in amounts
    }


def _reference(scene: Scene, until: float, start: Mapping[str, str]) -> tuple[Trajectory, float]:
    """Return the best motion that there is, and how far another one nearly as good is off."""
    for name, (best, second) in FINEST.items():
        try:
            one, other = (simulate(scene, until=until, start=start, method=name, rtol=rtol) for rtol in (best, second))
        except SimulateError:
            if name == list(FINEST)[-1]:
                raise
            continue
        return one, _distance(one, other)
    raise AssertionError("the last reference returns or raises")


def _points(
    scene: Scene,
    until: float,
    start: Mapping[str, str],
    name: str,
    tolerances: Sequence[float],
    reference: Trajectory,
    floor: float,
) -> Iterator[Point]:
    spent = 0.0
    for tolerance in tolerances:
        if spent > LONGEST:
            return
        try:
            made = simulate(scene, until=until, start=start, method=name, rtol=tolerance)
        except SimulateError:
            return
        spent += made.wall
        if made.stopped != "end":
            continue
        error = max(_distance(made, reference), floor)
        drift = made.monitors["energy"] / (made.monitors["energy_scale"] or 1.0)
        yield Point(tolerance, made.wall, made.evaluations, error, drift)


def _distance(one: Trajectory, other: Trajectory) -> float:
    """Return the largest difference of the states at the end, over the largest entry of either state, at least 1."""
    a, b = (np.concatenate([x.q[-1], x.qd[-1]]) for x in (one, other))
    return float(np.max(np.abs(a - b), initial=0.0) / max(1.0, np.abs(b).max(initial=0.0)))
