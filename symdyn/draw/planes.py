"""The planes that wheels, balls and blades touch: a hatched square, or a hatched line where it is seen edge-on."""

from __future__ import annotations

import numpy as np

from symdyn.draw.ground import hatches
from symdyn.draw.places import Array, Places
from symdyn.draw.shapes import Item, Shape, path
from symdyn.draw.view import View
from symdyn.scene import GROUND, Row, Scene

AROUND, SHARE = 1.5, 0.3
"""How far a plane is drawn around what touches it: in radii of a wheel, and for a blade over the size of the scene."""

STROKES = 9


def planes(scene: Scene, found: Places, view: View) -> tuple[Item, ...]:
    """Return the planes, one item each, as large as what happens on them at all moments that are found."""
    items = []
    for row, corners in patches(scene, found):
        title = f"plane of contact {row.name}"
        shapes = _shown(view.flat(corners), view.lean(found.touches[row.name].normal), view)
        items.append(Item(f"plane-{row.name}", title, 0, np.zeros(found.count), shapes))
    return tuple(items)


def patches(scene: Scene, found: Places) -> list[tuple[Row, Array]]:
    """Return every plane by the first row that is about it, with the corners of what is drawn, shape (N, 4, 3)."""
    rows_of: dict[object, list[Row]] = {}
    for row in scene.rows:
        if row.name in found.touches and found.touches[row.name].drawn:
            rows_of.setdefault(row.plane, []).append(row)
    corners = []
    for rows in rows_of.values():
        plane = found.touches[rows[0].name]
        ways = (plane.along, np.cross(plane.normal, plane.along))
        margin = AROUND * max(found.wheels[row.name][2] if row.name in found.wheels else 0.0 for row in rows)
        margin = margin or SHARE * _size(found)
        spots = np.stack([found.touches[row.name].spot - plane.at for row in rows])
        if rows[0].plane.body != GROUND:  # out to where the body is
            spots = np.concatenate([spots, np.zeros_like(spots[:1])])
        low, high = [], []
        for way in ways:
            along = np.einsum("rni,ni->rn", spots, way)
            low.append(along.min() - margin)
            high.append(along.max() + margin)
        ends = ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))
        square = np.stack([plane.at + u * ways[0] + v * ways[1] for u, v in ends], axis=1)
        corners.append((rows[0], square))
    return corners


def _size(found: Places) -> float:
    """Return the largest distance of joints and contacts in the mechanism, 1 m if there is none."""
    spots = [hinge.moved.p for hinge in found.hinges] + [hinge.fixed.p for hinge in found.hinges]
    spots += [touch.spot for touch in found.touches.values()]
    return float(np.ptp(np.concatenate(spots), axis=0).max(initial=0.0)) or 1.0


def _shown(corners: Array, normal: Array, view: View) -> tuple[Shape, ...]:
    """Return the shapes of a square with corners (N, 4, 2) in the picture, whose normal is (N, 2) there."""
    if view.planar and float(np.linalg.norm(normal, axis=1).min()) > 1 - 1e-9:
        a, b, _, d = (corners[:, k] for k in range(4))
        far = b if float(np.linalg.norm(b[0] - a[0])) > float(np.linalg.norm(d[0] - a[0])) else d
        return hatches(a, far, -normal, view.size)
    a, b, c, d = (corners[:, k] for k in range(4))
    shares = np.linspace(0, 1, STROKES + 2)[1:-1]
    strokes = [np.stack([a + (b - a) * s, d + (c - d) * s], axis=1) for s in shares]
    return (path("stand", corners, closed=True), path("hatch", *strokes, size=0.8))


def pushes(row: Row, found: Places) -> tuple[Array, list[Array]]:
    """Return where a contact acts at the first position that is found, and its unit forces, as its multipliers go."""
    touch = found.touches[row.name]
    n, spot = touch.normal[0], touch.spot[0]
    if touch.across is not None:
        return spot, [touch.across[0]]
    _, axis, radius = found.wheels[row.name]
    a = np.cross(n, touch.along[0]) if axis is None else axis[0]
    w = float(np.linalg.norm(np.cross(a, n))) or 1.0
    along = np.cross(a, n) / w
    ways = {"along": along, "across": np.cross(n, along), "normal": n}
    return spot - radius * (n - (n @ a) * a) / w, [ways[component] for component in row.components]
