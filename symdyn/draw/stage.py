"""A scene in its positions as pictures see it: where its parts are, and the view in which they fit.

Where nothing else is asked for it chooses the position, and values for parameters without any.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from symdyn.draw.ground import patches
from symdyn.draw.places import Array, Places, places
from symdyn.draw.view import View, look
from symdyn.dynamics.loops import Numbers
from symdyn.errors import DerivationError, DrawError
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import start_of
from symdyn.scene.values import Joint, suggestion, velocity_name
from symdyn.unlocked import cached_property

ANGLE = 0.6  # rad: what a picture turns a joint by that says nothing else, so that its angle can be seen
CURL = 4.2  # rad: what all of them may add up to
SHARE = 0.3  # of the mechanism's extent: what it slides one by


def values_of(scene: Scene, parameters: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return values of all parameters: those given, the declared ones, and 1 for what has none.

    Raises:
        DrawError: a name that is no parameter, or a value that is no finite number.
    """
    given = dict(parameters or {})
    names = [parameter.name for parameter in scene.parameters]
    for name in given:
        if name not in names:
            raise DrawError(f'{scene.name}: "{name}" is not a parameter; {suggestion(name, names)}')
    values = {}
    for parameter in scene.parameters:
        declared = None if parameter.value is None else parameter.value.at({})
        values[parameter.name] = float(1.0 if declared is None else declared)
    return values | {name: _finite(scene, name, value) for name, value in given.items()}


def _finite(scene: Scene, name: str, value: float) -> float:
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not math.isfinite(found):
        raise DrawError(f"{scene.name}: {name} = {' '.join(repr(value).split()):.60}: give a finite number")
    return found


def pose(
    scene: Scene, at: Mapping[str, float] | None = None, parameters: Mapping[str, float] | None = None
) -> tuple[Array, dict[str, float]]:
    """Return a position to draw, shape (nq,), and values of all parameters.

    The position is the scene's start. Where no joint has a start, turns show 0.6 rad, less where there are many, and
    slides a part of the extent, within their limits, so that the coordinates can be seen. Loops are closed, which keeps
    the coordinates that are given, and free parameters are then such that they can be.

    Raises:
        DrawError: an unknown name, or loops that do not close so.
    """
    given = dict(at or {})
    for name in given:
        if name not in scene.coordinates:
            raise DrawError(f'{scene.name}: "{name}" is not a coordinate; {suggestion(name, scene.coordinates)}')
    values = values_of(scene, parameters)
    if scene.loops or any(FORCES[one.kind].closes(one) for one in scene.contacts):
        return _closed(scene, given, values, parameters)
    declared = any(joint.start for joint in scene.joints)
    q = _start(scene, values)
    if not declared:
        angle = min(ANGLE, CURL / max(1, SceneUnits(scene).coordinates.count("rad")))
        seen = {"rad": angle, "m": SHARE * places(scene, q[None, :], values).reach}
        moved = zip(SceneUnits(scene).each_coordinate(), q, strict=True)
        q = np.array([_within(joint, seen.get(unit, x), values) for (joint, _, unit), x in moved])
    return _with(scene, q, given), values


def _closed(
    scene: Scene, given: Mapping[str, float], values: dict[str, float], parameters: Mapping[str, float] | None
) -> tuple[Array, dict[str, float]]:
    numbers = Numbers(scene)
    known = {p.name: values[p.name] for p in scene.free_parameters if parameters and p.name in parameters}
    try:
        numbers, assembly = numbers.witness(known)
        q = np.array(assembly.q)
        if given:
            velocities = list(scene.velocities)
            held = [velocities.index(velocity_name(name)) for name in given if velocity_name(name) in velocities]
            q = np.array(numbers.closed_position(_with(scene, q, given), held).q)
    except DerivationError as fault:
        raise DrawError(str(fault)) from fault
    return q, values | numbers.free


def _start(scene: Scene, values: Mapping[str, float]) -> Array:
    known = {name: Fraction(value) for name, value in values.items()}
    return np.array([float(one.at(known) or 0) for one in start_of(scene).position], dtype=np.float64)


def _with(scene: Scene, q: Array, given: Mapping[str, float]) -> Array:
    q = q.copy()
    for name, value in given.items():
        q[scene.coordinates.index(name)] = value
    return q


def _within(joint: Joint, at: float, values: Mapping[str, float]) -> float:
    """Return a coordinate well within the limits of its joint."""
    low, high = joint.range({name: Fraction(value) for name, value in values.items()})
    if not low < high:
        return at
    inner = 0.1 * (high - low) if math.isfinite(high - low) else 0.0
    return min(max(at, low + inner), high - inner)


@dataclass(frozen=True, eq=False)
class Stage:
    """A scene in positions.

    Attributes:
        scene: any.
        q: positions, shape (N, nq), in the order of the scene; rad, m or 1.
        parameters: values of all of them; None for the declared ones, and 1 for what has none.
        direction: azimuth and elevation of the viewer in degrees; None chooses.
    """

    scene: Scene
    q: Array
    parameters: Mapping[str, float] | None = None
    direction: tuple[float, float] | None = None

    @cached_property
    def values(self) -> Mapping[str, float]:
        """Values of all parameters."""
        return values_of(self.scene) if self.parameters is None else self.parameters

    @cached_property
    def places(self) -> Places:
        """Where everything is."""
        return places(self.scene, self.q, self.values)

    @cached_property
    def view(self) -> View:
        """The view in which everything fits."""
        nudged = self.q[:1] + 0.1 * (1 + np.arange(self.q.shape[-1]) % 5)  # by which chance shows
        first = [self.places, places(self.scene, nudged, self.values)]
        return look(first, points_to_hold(self.scene, self.places), self.direction)

    @property
    def extent(self) -> float:
        """The largest extent of all that a picture must hold, m; 1 of what has none."""
        return float(np.ptp(points_to_hold(self.scene, self.places), axis=0).max()) or 1.0


def points_to_hold(scene: Scene, result: Places) -> Array:
    """Return all points that a picture must hold, shape (K, 3)."""
    spots = result.spots + [at for ends in result.ends.values() for at in ends]
    for centre, _, radius in result.wheels.values():
        spots += [centre + sign * radius * axis for axis in np.eye(3) for sign in (-1, 1)]
    for body in result.bodies:
        if (outline := result.outlines.get(body.name)) is not None:
            spots += [body.frame.point(outline.centre + sign * x) for x in outline.ways for sign in (-1, 1)]
    spots += [corners[:, k] for _, corners in patches(scene, result) for k in range(4)]
    return np.concatenate(spots) if spots else np.zeros((1, 3))
