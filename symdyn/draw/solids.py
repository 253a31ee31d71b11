"""Solids as triangles with normals: boxes, cylinders, balls and patches, put where they belong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.draw.places import Array

Triangles = np.ndarray[Any, np.dtype[np.int64]]
AROUND, DOWN = 32, 16  # corners of a circle, and of half of one


@dataclass(frozen=True)
class Solid:
    """A surface of one colour.

    Attributes:
        points: shape (n, 3), m.
        normals: unit vectors outwards, one a point, shape (n, 3).
        triangles: three points each, counterclockwise from outside, shape (k, 3).
        colour: #rrggbb.
        alpha: from 0 (nothing is seen) to 1.
    """

    points: Array
    normals: Array
    triangles: Triangles
    colour: str
    alpha: float = 1.0

    def put(self, R: Array, p: Array, scale: Array | float = 1.0) -> Solid:
        """Return the solid scaled along its axes, turned by R and moved by p."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R * np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,)), p
        return self.moved(T)

    def moved(self, T: Array, unit: float = 1.0) -> Solid:
        """Return the solid where a matrix of shape (4, 4) takes it, which may stretch it; lengths times a unit."""
        A = T[:3, :3]
        with np.errstate(all="ignore"):
            normals = self.normals @ np.linalg.pinv(A)
            length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.where(length > 0, normals / np.where(length > 0, length, 1.0), [0.0, 0.0, 1.0])
        triangles = self.triangles[:, ::-1] if np.linalg.det(A) < 0 else self.triangles  # a mirror turns them round
        return Solid((self.points @ A.T + T[:3, 3]) * unit, normals, triangles, self.colour, self.alpha)


def box(half: Array, colour: str, alpha: float = 1.0) -> Solid:
    """Return a box around the origin with half its lengths, shape (3,)."""
    points, normals = [], []
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal = sign * np.eye(3)[axis]
            u, v = np.eye(3)[(axis + 1) % 3], sign * np.eye(3)[(axis + 2) % 3]
            points += [(normal + a * u + b * v) * half for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            normals += [normal] * 4
    corners = 4 * np.arange(6)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    return Solid(np.array(points), np.array(normals), corners.reshape(-1, 3), colour, alpha)


def cylinder(radius: float, half: float, colour: str, alpha: float = 1.0) -> Solid:
    """Return a cylinder around z with half its length."""
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    round_ = np.stack([np.cos(angles), np.sin(angles), np.zeros(AROUND)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    rings = [round_ * radius + sign * half * up for sign in (-1, 1)]
    k = np.arange(AROUND)
    after = (k + 1) % AROUND
    side = np.concatenate([np.stack([k, after, AROUND + after], 1), np.stack([k, AROUND + after, AROUND + k], 1)])
    points, normals, triangles = [*rings], [round_, round_], [side]
    for sign, ring in zip((-1, 1), rings, strict=True):
        first = sum(map(len, points))
        points.append(np.concatenate([ring, [sign * half * up]]))
        normals.append(np.tile(sign * up, (AROUND + 1, 1)))
        fan = np.stack([k, after, np.full(AROUND, AROUND)], 1) + first
        triangles.append(fan if sign > 0 else fan[:, ::-1])
    return Solid(np.concatenate(points), np.concatenate(normals), np.concatenate(triangles), colour, alpha)


def ball(radius: float, colour: str, alpha: float = 1.0) -> Solid:
    """Return a ball around the origin."""
    down, around = np.linspace(0, np.pi, DOWN + 1), np.linspace(0, 2 * np.pi, AROUND + 1)
    theta, phi = (x.ravel() for x in np.meshgrid(down, around, indexing="ij"))
    normals = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(DOWN), np.arange(AROUND), indexing="ij"))
    a, b = i * (AROUND + 1) + j, (i + 1) * (AROUND + 1) + j
    triangles = np.concatenate([np.stack([a, b, b + 1], 1)[i < DOWN - 1], np.stack([a, b + 1, a + 1], 1)[i > 0]])
    return Solid(normals * radius, normals, triangles, colour, alpha)


def patch(corners: Array, colour: str, alpha: float = 1.0) -> Solid:
    """Return a flat surface with four corners, shape (4, 3)."""
    normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
    length = float(np.linalg.norm(normal))
    normals = np.tile(normal / length if length > 0 else [0.0, 0.0, 1.0], (4, 1))
    return Solid(corners.copy(), normals, np.array([[0, 1, 2], [0, 2, 3]]), colour, alpha)


def along(axis: Array) -> Array:
    """Return a rotation that takes z to a unit vector, always the same one for the same axis."""
    least = np.eye(3)[int(np.argmin(np.round(np.abs(axis), 6)))]
    x = np.cross(least, axis)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=1)


def bar(a: Array, b: Array, half: float, colour: str) -> tuple[Solid, ...]:
    """Return a box from one point to another; nothing where they are one."""
    length = float(np.linalg.norm(b - a))
    if not length > 0:
        return ()
    return (box(np.array([half, half, length / 2]), colour).put(along((b - a) / length), (a + b) / 2),)
