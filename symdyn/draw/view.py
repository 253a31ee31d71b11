"""How a picture looks at a scene: face-on where it is planar, else along a direction, always without perspective."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.draw.places import Array, Places, unit
from symdyn.errors import DrawError

WIDE, HIGH = 360.0, 300.0  # what the mechanism may take, in units of the picture
AZIMUTHS = (-60, -35, -25, 30, 55, 120, 150, -120, -145)
ELEVATIONS = (35, 25)
LARGEST, SMALLEST = 8.0, 2.5  # half the width of a joint's symbol
TOUCHING = 4.0  # units of the picture within which two points are one for the choice of that size
EDGE_ON = 60.0  # what a turn costs whose plane is seen edge-on, against crowded points
PLANE = 1e-9  # how far a unit axis may lean and still be parallel
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
        others = [np.cross(slides[0], other) for other in (*slides, unit(first[0].gravity), *np.eye(3)[::-1])]
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
