"""What is hatched: a support under every joint that hangs on the ground, and the planes that wheels and blades touch.

A plane is a square, or a line where it is seen edge-on.
"""

from __future__ import annotations

import numpy as np

from symdyn.draw.body_shapes import farthest
from symdyn.draw.joint_symbols import parts, rail_ends
from symdyn.draw.places import Array, JointAxis, Places, across, unit
from symdyn.draw.shapes import Item, Shape, circle_points, line, path
from symdyn.draw.titles import Title
from symdyn.draw.view import View
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, MarkPart
from symdyn.scene.values import Contact

AROUND, SHARE = 1.5, 0.3
"""How far a plane is drawn around what touches it: in radii of a wheel, and for a blade over the size of the scene."""

STROKES = 9


def ground(scene: Scene, places: Places, view: View) -> tuple[Item, ...]:
    """Return the supports, one item each."""
    items = []
    held = [hinge for hinge in places.hinges if Scene.GROUND in (hinge.joint.parent, hinge.joint.child)]
    for hinge in held:
        if not JOINTS[hinge.joint.type].class_t(hinge.joint):
            continue  # nothing holds it
        rail = next((part for part in parts(hinge, view) if part.shape == "rail"), None)
        if not view.planar:
            shapes = _stand(hinge, places, view, alone=len(held) == 1)
        elif rail:
            shapes = _hatched_rail(hinge, view, rail)
        else:
            shapes = _bearing(scene, hinge, places, view)
        title = Title("ground at joint {name}", name=hinge.joint.name)
        items.append(Item(f"ground-{hinge.joint.name}", title, 0, np.zeros(places.count), shapes))
    return tuple(items)


def _seat(hinge: JointAxis) -> Array:
    """Return where the joint sits on the ground, shape (N, 3)."""
    return hinge.fixed.p if hinge.joint.parent == Scene.GROUND else hinge.moved.p


def _bearing(scene: Scene, hinge: JointAxis, places: Places, view: View) -> tuple[Shape, ...]:
    """Return a triangle on a hatched line, on the side of the joint that its body leaves free."""
    at, s = view.flat(_seat(hinge)), view.size
    other = hinge.joint.child if hinge.joint.parent == Scene.GROUND else hinge.joint.parent
    tip = at if other == Scene.GROUND else view.flat(farthest(scene, places, other, _seat(hinge)))
    hangs = float(np.mean(tip[:, 1] - at[:, 1])) > 1e-6
    down = np.array([0.0, -1.0 if hangs else 1.0])
    base = at + down * 2.4 * s
    wide = np.array([1.0, 0.0]) * 1.3 * s
    triangle = path("support", np.stack([at, base + wide, base - wide], axis=1), closed=True)
    return (triangle, *hatches(base - wide * 1.7, base + wide * 1.7, down, s))


def _hatched_rail(hinge: JointAxis, view: View, rail: MarkPart) -> tuple[Shape, ...]:
    """Return the line that a slider sits on, hatched below or on the left."""
    a, b = rail_ends(hinge, view, rail, 4.0)
    way = unit(b - a)[0]
    down = np.array([-way[1], way[0]])
    down = down if (round(down[1], 6), -down[0]) > (0, 0) else -down
    shift = down * view.size * 1.25
    return hatches(a + shift, b + shift, down, view.size)


def hatches(a: Array, b: Array, down: Array, s: float) -> tuple[Shape, ...]:
    """Return a line with strokes on one side of it."""
    way = unit(b - a)
    count = max(4, min(40, round(float(np.linalg.norm(b[0] - a[0])) / (0.75 * s))))
    strokes = []
    for k in range(count):
        top = a + (b - a) * ((k + 0.7) / count)
        strokes.append(np.stack([top, top + (down - way * 0.8) * s * 0.75], axis=1))
    return (path("hatch", *strokes, size=1.2), line("floor", a, b, size=2.0))


def _stand(hinge: JointAxis, places: Places, view: View, alone: bool) -> tuple[Shape, ...]:
    """Return a hatched plate and the post on it that carries the joint.

    The plate is level. One joint right above the origin of the ground stands on a plate there.
    """
    seat, up = _seat(hinge), -unit(places.gravity) if np.any(places.gravity) else np.array([0.0, 0.0, 1.0])
    rise = seat[0] - places.ground.p[0]
    column = alone and float(np.linalg.norm(np.cross(rise, up))) < 1e-6 and float(rise @ up) > 3 * view.reach
    foot = places.ground.p if column else seat - up * view.reach * 2.6
    x = across(np.broadcast_to(up, seat.shape))
    y = np.cross(up, x)
    half = view.reach * 3.2
    corners = circle_points(view, foot, x * half * 2**0.5, y * half * 2**0.5, np.pi / 4 + np.arange(4) * np.pi / 2)
    strokes = []
    for k in np.linspace(-0.75, 0.75, 7):
        low, high = max(-1.0, 2 * k - 1), min(1.0, 2 * k + 1)  # of the lines u - v = 2k in the square
        ends = [foot + (u * x + (u - 2 * k) * y) * half for u in (low, high)]
        strokes.append(np.stack([view.flat(end) for end in ends], axis=1))
    plate = path("stand", corners, closed=True)
    post = line("post", view.flat(foot), view.flat(seat), size=view.size * 0.7)
    return (plate, path("hatch", *strokes, size=1.0), post)


# Planes


def planes(scene: Scene, places: Places, view: View) -> tuple[Item, ...]:
    """Return the planes, one item each, as large as what happens on them at all moments that are found."""
    items = []
    for row, corners in patches(scene, places):
        title = Title("plane of contact {name}", name=row.name)
        shapes = _shown(view.flat(corners), view.lean(places.touches[row.name].normal), view)
        items.append(Item(f"plane-{row.name}", title, 0, np.zeros(places.count), shapes))
    return tuple(items)


def patches(scene: Scene, places: Places) -> list[tuple[Contact, Array]]:
    """Return every plane by the first row that is about it, with the corners of what is drawn, shape (N, 4, 3)."""
    rows_of: dict[object, list[Contact]] = {}
    for row in scene.contacts:
        if places.touches[row.name].drawn:
            rows_of.setdefault(row.plane, []).append(row)
    corners = []
    for rows in rows_of.values():
        plane = places.touches[rows[0].name]
        ways = (plane.along, np.cross(plane.normal, plane.along))
        margin = AROUND * max(places.wheels[row.name][2] if row.name in places.wheels else 0.0 for row in rows)
        margin = margin or SHARE * _size(places)
        spots = np.stack([places.touches[row.name].spot - plane.at for row in rows])
        if rows[0].plane.body != Scene.GROUND:  # out to where the body is
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


def _size(places: Places) -> float:
    """Return the largest distance of joints and contacts in the mechanism, 1 m if there is none."""
    spots = [hinge.moved.p for hinge in places.hinges] + [hinge.fixed.p for hinge in places.hinges]
    spots += [touch.spot for touch in places.touches.values()]
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


def pushes(row: Contact, places: Places) -> tuple[Array, list[Array]]:
    """Return where a contact acts at the first position that is found, and its unit forces, as its multipliers go."""
    touch = places.touches[row.name]
    n, spot = touch.normal[0], touch.spot[0]
    if touch.across is not None:
        return spot, [touch.across[0]]
    _, axis, radius = places.wheels[row.name]
    a = np.cross(n, touch.along[0]) if axis is None else axis[0]
    w = float(np.linalg.norm(np.cross(a, n))) or 1.0
    along = np.cross(a, n) / w
    ways = {"along": along, "across": np.cross(n, along), "normal": n}
    return spot - radius * (n - (n @ a) * a) / w, [ways[component] for component in row.components]
