"""What pictures are made of: paths, dots, discs and signs, at N moments each.

Coordinates are in units of the picture, y down. A shape keeps its make-up from moment to moment, only numbers change,
so that one description serves a picture and an animation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from symdyn.draw.places import Array, across, unit
from symdyn.draw.titles import Title
from symdyn.draw.view import View


@dataclass(frozen=True)
class Shape:
    """One element of a picture.

    Attributes:
        kind: "path", "dot" (a circle on paper), "disc" (a circle in space) or "sign" (a fixed path put somewhere).
        look: its classes in the style sheet.
        points: shape (N, k, 2); k = 1 but for a path.
        parts: of a path, number of points of each of its parts.
        closed: of a path, whether each part returns to its first point.
        size: stroke width of a path, radius of a dot or disc.
        tilt: of a disc, minor radius and angle of the major axis in degrees, shape (N, 2).
        sign: of a sign, its path.
    """

    kind: str
    look: str
    points: Array
    parts: tuple[int, ...] = ()
    closed: bool = False
    size: float = 1.0
    tilt: Array = field(default_factory=lambda: np.zeros((0, 2)))
    sign: str = ""

    @property
    def segments(self) -> Array:
        """What labels keep away from: line segments, shape (N, S, 2, 2)."""
        if self.kind == "path":
            pieces, first = [], 0
            for count in self.parts:
                part = self.points[:, first : first + count]
                part = np.concatenate([part, part[:, :1]], axis=1) if self.closed else part
                pieces.append(np.stack([part[:, :-1], part[:, 1:]], axis=2))
                first += count
            return np.concatenate(pieces, axis=1)
        r = self.size * 0.8
        corners = np.array([[[-r, -r], [r, r]], [[-r, r], [r, -r]]])
        return np.asarray(self.points[:, :, None, :] + corners[None])


@dataclass(frozen=True)
class Item:
    """Shapes that belong together: a body, a joint, a load.

    Attributes:
        id: of its group in the picture, without the picture's prefix.
        title: what a reader is told who points at it.
        layer: what lies on top: 0 ground, 1 mechanism, 2 marks.
        depth: how near it is to the viewer, shape (N,); decides within a layer.
    """

    id: str
    title: Title
    layer: int
    depth: Array
    shapes: tuple[Shape, ...]


def path(look: str, *parts: Array, closed: bool = False, size: float = 1.4) -> Shape:
    """Return a path through points, one array of shape (N, k, 2) a part."""
    return Shape("path", look, np.concatenate(parts, axis=1), tuple(part.shape[1] for part in parts), closed, size)


def line(look: str, *points: Array, size: float = 1.4) -> Shape:
    """Return a line through points of shape (N, 2) each."""
    return path(look, np.stack(points, axis=1), size=size)


def dot(look: str, at: Array, radius: float) -> Shape:
    """Return a circle on paper around a point of shape (N, 2)."""
    return Shape("dot", look, at[:, None, :], size=radius)


def disc(look: str, view: View, at: Array, normal: Array, radius: float) -> Shape:
    """Return a circle in space around a point, shape (N, 3), with a unit normal."""
    flat = view.lean(normal)
    angle = np.degrees(np.arctan2(flat[:, 1], flat[:, 0])) + 90
    angle = np.where(np.linalg.norm(flat, axis=1) < 1e-9, 0.0, angle % 180)
    minor = radius * np.abs(normal @ view.toward)
    return Shape("disc", look, view.flat(at)[:, None, :], size=radius, tilt=np.stack([minor, angle], axis=1))


def sign(look: str, at: Array, drawing: str, size: float) -> Shape:
    """Return a fixed path, about `size` around (0, 0), put at a point of shape (N, 2)."""
    return Shape("sign", look, at[:, None, :], size=size, sign=drawing)


def arrow(
    look: str, tail: Array, tip: Array, size: float = 1.6, head: float = 8.0, heads: int = 1
) -> tuple[Shape, ...]:
    """Return an arrow between points of shape (N, 2) with one head, or with two behind each other for a couple."""
    way = unit(tip - tail)
    length = np.minimum(head, np.linalg.norm(tip - tail, axis=1, keepdims=True) * 0.6)
    back = tip - way * length * heads
    found = [line(look, tail, back + way * length * 0.3, size=size)]
    found += [_head(look, tip - way * length * k, way, length) for k in range(heads)]
    return tuple(found)


def arc_arrow(look: str, points: Array, size: float = 1.6, head: float = 8.0) -> tuple[Shape, ...]:
    """Return a curve through points of shape (N, k, 2) with an arrow head at its end."""
    tip = points[:, -1]
    before = np.argmax(np.linalg.norm(points - tip[:, None], axis=2) <= head * 0.9, axis=1)
    back = points[np.arange(len(points)), np.minimum(before, points.shape[1] - 2)]
    way, length = unit(tip - back), np.full((len(tip), 1), head)
    shortened = points.copy()
    near = np.arange(points.shape[1])[None, :] > before[:, None]
    shortened[near] = np.repeat((tip - way * head * 0.7)[:, None], points.shape[1], axis=1)[near]
    return (path(look, shortened, size=size), _head(look, tip, way, length))


def _head(look: str, tip: Array, way: Array, length: Array) -> Shape:
    side = np.stack([-way[:, 1], way[:, 0]], axis=1) * length * 0.36
    back = tip - way * length
    return path(f"{look} head", np.stack([tip, back + side, back - side], axis=1), closed=True, size=0.6)


# Bodies of revolution and boxes in space


def cylinder(look: str, view: View, at: Array, axis: Array, half: float, radius: float) -> tuple[Shape, ...]:
    """Return a cylinder around a point with half its length and its radius in units of the picture."""
    way = axis * half / view.scale
    front = np.where((axis @ view.toward >= 0)[:, None], 1.0, -1.0)
    near, far = at + front * way, at - front * way
    ends = (view.flat(far), view.flat(near))
    return (
        disc(look, view, far, axis, radius - 0.6),
        line(f"{look} edge", *ends, size=2 * radius),
        line(f"{look} inside", *ends, size=2 * radius - 2.4),
        disc(look, view, near, axis, radius - 0.6),
    )


def box(look: str, view: View, at: Array, axis: Array, half: float, width: float) -> tuple[Shape, ...]:
    """Return the three visible faces of a box along an axis, half its length and half its width as of the cylinder."""
    first = across(axis)
    second = np.cross(axis, first)
    ways = [axis * half / view.scale, first * width / view.scale, second * width / view.scale]
    ways = [np.where((way @ view.toward >= 0)[:, None], way, -way) for way in ways]
    faces = []
    for k in range(3):
        a, b, c = ways[k], ways[(k + 1) % 3], ways[(k + 2) % 3]
        corners = [at + a + b + c, at + a - b + c, at + a - b - c, at + a + b - c]
        faces.append(path(look, np.stack([view.flat(corner) for corner in corners], axis=1), closed=True))
    return tuple(faces)


def circle_points(view: View, at: Array, x: Array, y: Array, angles: Array) -> Array:
    """Return at + x cos θ + y sin θ in the picture, shape (N, k, 2); angles of shape (k,) or (N, k)."""
    angles = np.broadcast_to(angles, (len(at), angles.shape[-1]))[:, :, None]
    return view.flat(at[:, None] + np.cos(angles) * x[:, None] + np.sin(angles) * y[:, None])


def joined(groups: Sequence[tuple[Shape, ...]]) -> tuple[Shape, ...]:
    """Return the shapes of all groups."""
    return tuple(shape for group in groups for shape in group)
