"""A scene in its positions as pictures see it: where its parts are, and the view in which they fit.

A view is face-on where the scene is planar, else along a direction, always without perspective. That of a film holds
the whole motion, or goes with a mechanism that travels far. Where nothing else is asked for the position is chosen
here, and values for parameters without any.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np

from symdyn.draw.ground import patches
from symdyn.draw.places import Array, Places, places, unit
from symdyn.dynamics.loops import Numbers
from symdyn.errors import DerivationError, DrawError, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.scene import Scene, SceneUnits, bind
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import start_of
from symdyn.scene.values import Joint, ask_for_units, velocity_name
from symdyn.unlocked import cached_property

WIDE, HIGH = 360.0, 300.0  # what the mechanism may take, in units of the picture
AZIMUTHS = (-60, -35, -25, 30, 55, 120, 150, -120, -145)
ELEVATIONS = (35, 25)
LARGEST, SMALLEST = 8.0, 2.5  # half the width of a joint's symbol
TOUCHING = 4.0  # units of the picture within which two points are one for the choice of that size
EDGE_ON = 60.0  # what a turn costs whose plane is seen edge-on, against crowded points
PLANE = 1e-9  # how far a unit axis may lean and still be parallel
FILM = 1.35  # times as large as a picture is a film, in which most of the frame is empty most of the time
FAR = 1.8  # times as large as in a view of the whole way must what travels be for the view to follow it
STEADY, PART = 1.0, 0.2  # s, and part of a film: the view follows what is left when so much is averaged
FARTHEST = 1e300  # m a unit of the picture: beyond it, the other way round is nothing


@dataclass(frozen=True)
class View:
    """A parallel projection.

    Attributes:
        right, up, toward: unit vectors in the ground frame; the third points at the viewer.
        scale: units of the picture a metre.
        middle: what is drawn at (0, 0), m in the picture's plane; shape (2,).
        planar: whether the scene is planar and seen face-on.
        size: half the width of a joint's symbol, in units of the picture.
    """

    right: Array
    up: Array
    toward: Array
    scale: float
    middle: Array
    planar: bool
    size: float

    @property
    def reach(self) -> float:
        """Half the width of a joint's symbol, m."""
        return self.size / self.scale

    def lean(self, vectors: Array) -> Array:
        """Return directions, shape (..., 3), in the picture, m; shape (..., 2), y down."""
        return np.stack([vectors @ self.right, -(vectors @ self.up)], axis=-1)

    def flat(self, points: Array) -> Array:
        """Return points, shape (..., 3), in the picture, in its units; shape (..., 2), y down."""
        return np.asarray((self.lean(points) - self.middle) * self.scale)

    def depth(self, points: Array) -> Array:
        """Return how near points are to the viewer, in units of the picture; zero where all lie in one plane."""
        return np.zeros(points.shape[:-1]) if self.planar else np.asarray(points @ self.toward * self.scale)


def look(first: Sequence[Places], spots: Array, direction: tuple[float, float] | None) -> View:
    """Return the view of a scene.

    Args:
        first: the scene at two positions, by which planes are told from chance.
        spots: points that the picture must show, shape (K, 3).
        direction: azimuth and elevation of the viewer in degrees, from x about the upward vertical and from the
            horizontal plane; None chooses.

    Raises:
        DrawError: an elevation beyond 90 degrees, or a number that is none.
    """
    upward = vertical(first[0].gravity)
    joints = np.array([hinge.moved.p[0] for hinge in first[0].hinges]).reshape(-1, 3)
    if direction is not None:
        azimuth, elevation = direction
        if not (math.isfinite(azimuth) and -90 <= elevation <= 90):
            raise DrawError(f"view {azimuth:g}, {elevation:g}: azimuth and elevation are degrees, -90 to 90 the second")
        return _fitted(*_around(upward, azimuth, elevation), spots, joints, False)
    normal = plane(first)
    if normal is not None:
        up = first[0].gravity - (first[0].gravity @ normal) * normal
        falls = float(np.linalg.norm(up)) > 1e-6 * float(np.linalg.norm(first[0].gravity))
        up = -unit(up) if falls else _level(normal)
        return _fitted(np.cross(up, normal), up, normal, spots, joints, True)
    views = [_around(upward, a, e) for e, a in itertools.product(ELEVATIONS, AZIMUTHS)]
    right, up, toward = min(views, key=lambda axes: _crowding(spots, axes) + _edge_on(first[0], axes))
    return _fitted(right, up, toward, spots, joints, False)


def plane(first: Sequence[Places]) -> Array | None:
    """Return the normal of a planar scene, towards the viewer; None for a spatial one.

    A scene is planar when every turn is about one direction and every slide across it.
    """
    turns, slides = [], []
    for hinge in (hinge for one in first for hinge in one.hinges):
        turns += [axis[0] for axis in hinge.turns]
        slides += [way[0] for way in hinge.slides]
    if turns:
        normal = turns[0]
    elif not slides:
        return None
    else:
        ropes = [part[-1][0] - route[0][0][0] for route in first[0].routes.values() for part in route]
        ways = (*slides, unit(first[0].gravity), *ropes, *np.eye(3)[::-1])
        others = [np.cross(slides[0], other) for other in ways]
        normal = unit(next(other for other in others if np.linalg.norm(other) > 1e-6))
    if any(np.linalg.norm(np.cross(normal, axis)) > PLANE for axis in turns):
        return None
    if any(abs(normal @ axis) > PLANE for axis in slides):
        return None
    facing = [x for x in (normal[2], -normal[1], normal[0]) if abs(x) > 1e-6]
    return np.asarray(normal * np.sign(facing[0])) + 0.0


def vertical(gravity: Array) -> Array:
    """Return the unit vector against gravity, z where there is none."""
    length = float(np.linalg.norm(gravity))
    return np.asarray(-gravity / length) + 0.0 if length > 0 else np.array([0.0, 0.0, 1.0])


def _level(normal: Array) -> Array:
    """Return the axis of the ground frame that shows upwards where gravity does not tell: y, else z."""
    for axis in (np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])):
        flat = axis - (axis @ normal) * normal
        if np.linalg.norm(flat) > 0.5:
            return unit(flat)
    raise AssertionError("a plane leans away from y or from z")


def _around(vertical: Array, azimuth: float, elevation: float) -> tuple[Array, Array, Array]:
    """Return right, up and toward of a viewer at an azimuth and elevation in degrees."""
    ahead = np.array([1.0, 0.0, 0.0]) if abs(vertical[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = unit(ahead - (ahead @ vertical) * vertical)
    y = np.cross(vertical, x)
    a, e = math.radians(azimuth), math.radians(elevation)
    level = math.cos(a) * x + math.sin(a) * y
    toward = math.cos(e) * level + math.sin(e) * vertical
    right = math.cos(a) * y - math.sin(a) * x
    return right, np.cross(toward, right), toward


def _crowding(spots: Array, axes: tuple[Array, Array, Array]) -> float:
    """Return how much different points of the scene fall upon each other in a view."""
    size = float(np.ptp(spots, axis=0).max()) if len(spots) else 0.0
    if not size:
        return 0.0
    spots = np.unique(np.round(spots / size, 6), axis=0)[:60]
    flat = np.stack([spots @ axes[0], spots @ axes[1]], axis=-1)
    apart = np.linalg.norm(flat[:, None] - flat[None], axis=-1)[np.triu_indices(len(flat), 1)]
    return float(np.round(np.sum(1 / (apart + 0.05) ** 2), 6))


def _edge_on(places: Places, axes: tuple[Array, Array, Array]) -> float:
    """Return how much the planes of turns are seen edge-on, where angles cannot be read."""
    turns = [step.axis[0] for hinge in places.hinges for step in hinge.steps if not step.slides]
    return float(np.round(sum(EDGE_ON * max(0.0, 0.3 - abs(float(axis @ axes[2]))) for axis in turns), 6))


def _fitted(right: Array, up: Array, toward: Array, spots: Array, joints: Array, planar: bool) -> View:
    """Return the view in which all spots are as large as fits."""
    flat = np.stack([spots @ right, -(spots @ up)], axis=-1)
    low, high = flat.min(axis=0), flat.max(axis=0)
    ways = high - low
    size = max(ways[0] / WIDE, ways[1] / HIGH, float(np.abs(flat).max()) * 1e-12)
    scale = float(1 / min(size, FARTHEST)) if size > 0 else 100.0
    return View(right, up, toward, scale, (low + high) / 2, planar, _symbol(joints @ np.stack([right, up], 1) * scale))


def _symbol(joints: Array) -> float:
    """Return half the width of a joint's symbol that leaves room between most joints, places of shape (K, 2)."""
    apart = np.linalg.norm(joints[:, None] - joints[None], axis=-1)
    nearest = np.where(apart > TOUCHING, apart, np.inf).min(axis=1, initial=np.inf)
    near = np.sort(nearest[np.isfinite(nearest)])
    return min(LARGEST, max(SMALLEST, float(near[len(near) // 4]) / 5)) if len(near) else LARGEST


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
            told = scene.derived_words(name) or f'"{name}" is not a parameter; {suggestion(name, names)}'
            raise DrawError(f"{scene.name}: {told}")
    ask_for_units(scene.parameters, given.items(), "parameters")
    texts = {name: value for name, value in given.items() if isinstance(value, str)}
    values = {}
    for parameter in (bind(scene, texts) if texts else scene).parameters:
        declared = None if parameter.value is None else parameter.value.at({})
        values[parameter.name] = float(1.0 if declared is None else declared)
    return values | {name: _finite(scene, name, value) for name, value in given.items() if name not in texts}


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
    if scene.loops or any(FORCES[one.kind].holonomic(one) for one in scene.contacts):
        return _closed(scene, given, values, parameters)
    declared = any(joint.start for joint in scene.joints)
    known = {name: Fraction(value) for name, value in values.items()}
    q = np.array([float(one.at(known) or 0) for one in start_of(scene).position], dtype=np.float64)
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
        return values_of(self.scene) if self.parameters is None else self.parameters

    @cached_property
    def places(self) -> Places:
        return places(self.scene, self.q, self.values)

    @cached_property
    def view(self) -> View:
        nudged = self.q[:1] + 0.1 * (1 + np.arange(self.q.shape[-1]) % 5)  # by which chance shows
        first = [self.places, places(self.scene, nudged, self.values)]
        return look(first, points_to_hold(self.scene, self.places), self.direction)

    def filmed(self, t: Array) -> tuple[View, Array | None]:
        """Return the view of a film at times, shape (N,), and the way of its middle in the picture, shape (N, 2).

        The way is None where the view is fixed, which it is along an axis of the picture where little of the way is.
        """
        seen, found = self.view, self.places
        spots = seen.flat(np.stack(_travelling(found) or [np.zeros((found.count, 3))], axis=1))
        way = _steady((spots.min(axis=1) + spots.max(axis=1)) / 2, t)
        own = np.ptp((spots - way[:, None]).reshape(-1, 2), axis=0)
        still = np.ptp(way, axis=0) < own / 2
        way[:, still] = ((way.min(axis=0) + way.max(axis=0)) / 2)[still]
        near = float(np.max(np.ptp((spots - way[:, None]).reshape(-1, 2), axis=0) / (WIDE, HIGH)))
        follows = 0 < near < 1 / FAR
        closer = FILM / near if follows else FILM
        joints = np.array([hinge.moved.p[0] for hinge in found.hinges]).reshape(-1, 3)
        size = _symbol(joints @ np.stack([seen.right, seen.up], 1) * seen.scale * closer)
        return replace(seen, scale=seen.scale * closer, size=size), way * closer if follows else None

    @property
    def extent(self) -> float:
        """The largest extent of all that a picture must hold, m; 1 of what has none."""
        return float(np.ptp(points_to_hold(self.scene, self.places), axis=0).max()) or 1.0


def _travelling(result: Places) -> list[Array]:
    """Return the points of the mechanism itself, shape (N, 3) each: no ground that it slides or flies along."""
    spots = [hinge.moved.p for hinge in result.hinges]
    spots += [body.com for body in result.bodies if body.com is not None]
    spots += [at for body in result.bodies for _, at in body.particles]
    spots += [frame.p for _, frame in result.points.values()]
    for centre, _, radius in result.wheels.values():
        spots += [centre + sign * radius * axis for axis in np.eye(3) for sign in (-1, 1)]
    for body in result.bodies:
        if (outline := result.outlines.get(body.name)) is not None:
            spots += [body.frame.point(outline.centre + sign * x) for x in outline.ways for sign in (-1, 1)]
    return spots


def _steady(way: Array, t: Array) -> Array:
    """Return a way, shape (N, 2), without what is quick in it; straight at its ends as it was."""
    half = int(min(STEADY / 2 / max(float(np.diff(t).mean()), 1e-9), PART / 2 * len(t))) if len(t) > 1 else 0
    padded = np.pad(way, ((half, half), (0, 0)), "reflect", reflect_type="odd")
    kernel = np.full(2 * half + 1, 1 / (2 * half + 1))
    return np.stack([np.convolve(column, kernel, "valid") for column in padded.T], axis=1)


def points_to_hold(scene: Scene, result: Places) -> Array:
    """Return all points that a picture must hold, shape (K, 3)."""
    spots = [*_travelling(result), *(hinge.fixed.p for hinge in result.hinges)]
    spots += [at for ends in result.ends.values() for at in ends]
    spots += [hinge.wire.reshape(-1, 3) for hinge in result.hinges if hinge.wire is not None]
    spots += [corners[:, k] for _, corners in patches(scene, result) for k in range(4)]
    return np.concatenate(spots) if spots else np.zeros((1, 3))
