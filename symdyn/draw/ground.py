"""Symbols of joints, and what is hatched: supports, and the planes that wheels and blades touch.

A support stands under every joint that hangs on the ground; a plane is a square, or a line where it is seen edge-on.
Symbols are made of parts, one function a part. A symbol shows what the joint leaves free: a ring or a cylinder turns, a
box slides, a cylinder with a thread does both. What the child carries is filled with paper, what the parent carries
(rails, plates) is a plain line.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from symdyn.draw.outlines import touching
from symdyn.draw.places import Array, JointAxis, Places, across, unit
from symdyn.draw.shapes import (
    Item,
    Shape,
    Title,
    arrow,
    box,
    circle_points,
    cylinder,
    dot,
    farthest,
    joined,
    line,
    path,
)
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, MarkPart
from symdyn.scene.values import Contact

if TYPE_CHECKING:
    from symdyn.draw.stage import View


def symbol(hinge: JointAxis, view: View) -> tuple[Shape, ...]:
    """Return the symbol of a joint; that of a loop which does not close shows its gap."""
    shown = joined([PARTS[part.shape](hinge, view, part) for part in parts(hinge, view)])
    if not hinge.closes:
        return shown
    gap = _apart("gap", hinge, view)
    shifted = float(np.linalg.norm(gap.points[:, 1] - gap.points[:, 0], axis=1).max())
    parted = shifted > 1.0 and JOINTS[hinge.joint.type].pins(hinge.joint)
    return (gap, *shown) if parted else shown


def parts(hinge: JointAxis, view: View) -> tuple[MarkPart, ...]:
    """Return what the symbol of a joint is made of."""
    mark = JOINTS[hinge.joint.type].mark
    return mark.flat if view.planar and mark.flat else mark.parts


def direction(hinge: JointAxis, part: MarkPart) -> Array:
    """Return the direction of a part, unit vectors."""
    return hinge.ways[part.way] if part.way in hinge.ways else hinge.fixed.R[:, :, "xyz".index(part.way)]


def triad(view: View, at: Array, R: Array, half: float = 3.0) -> tuple[Shape, ...]:
    """Return the axes of a frame as arrows, x, y, z; one that points at the viewer is not more than a speck."""
    tips = [at + R[:, :, k] * view.reach * half for k in range(3)]
    return joined([arrow(f"triad-{'xyz'[k]}", view.flat(at), view.flat(tip), 1.6, 5.0) for k, tip in enumerate(tips)])


# Along a direction


def _arm(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    ends = _ends(hinge, view, part)
    return (line("cross", *ends, size=2.6), *(dot("joint", end, view.size * 0.42) for end in ends))


def _ends(hinge: JointAxis, view: View, part: MarkPart) -> list[Array]:
    reach = direction(hinge, part) * view.reach
    return [view.flat(hinge.moved.p + reach * k) for k in (-part.half, part.half)]


def _arrow(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    tip = hinge.moved.p + direction(hinge, part) * view.reach * part.half
    return arrow("axis", view.flat(hinge.moved.p), view.flat(tip), 1.2, 6.0)


def _solid(make: Callable[..., tuple[Shape, ...]], hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    return make("joint", view, hinge.moved.p, direction(hinge, part), part.half * view.size, view.size)


def _slider(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    at, way = view.flat(hinge.moved.p), view.lean(direction(hinge, part))
    side = np.stack([-way[:, 1], way[:, 0]], axis=1) * view.size * 1.25
    way = way * view.size * part.half
    corners = np.stack([at + way + side, at - way + side, at - way - side, at + way - side], axis=1)
    return (path("joint", corners, closed=True),)


def _thread(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    axis = direction(hinge, part)
    front = view.toward - (axis @ view.toward)[:, None] * axis
    length = np.linalg.norm(front, axis=1, keepdims=True)
    front = np.where(length > 1e-6, front / np.where(length > 1e-6, length, 1), across(axis))
    side, angles = np.cross(axis, front), np.linspace(-np.pi / 2, np.pi / 2, 7)
    threads = []
    for k in (-1.2, -0.4, 0.4):
        rises = (k + 0.8 * (angles / np.pi + 0.5)) * view.reach
        at = hinge.moved.p[:, None] + axis[:, None] * rises[None, :, None]
        turned = np.cos(angles)[None, :, None] * front[:, None] + np.sin(angles)[None, :, None] * side[:, None]
        threads.append(view.flat(at + turned * view.reach * 0.93))
    return (path("thread", *threads, size=1.2),)


def _rail(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    """Return what a slide runs on, as long as all its ways; on the ground of a planar scene `ground` draws it."""
    if view.planar and Scene.GROUND in (hinge.joint.parent, hinge.joint.child):
        return ()
    return (line("rail", *rail_ends(hinge, view, part, 3.2), size=2.4),)


def rail_ends(hinge: JointAxis, view: View, part: MarkPart, beyond: float) -> tuple[Array, Array]:
    """Return the ends of a rail in the picture, some sizes of a symbol beyond all places of the slider."""
    axis = direction(hinge, part)
    way = np.einsum("ni,ni->n", hinge.moved.p - hinge.fixed.p, axis)
    low, high = min(0.0, float(way.min())) - beyond * view.reach, max(0.0, float(way.max())) + beyond * view.reach
    return view.flat(hinge.fixed.p + axis * low), view.flat(hinge.fixed.p + axis * high)


def _plate(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    """Return the plate that a joint moves on, as wide as all its ways."""
    axis = direction(hinge, part)
    first = across(axis)
    second = np.cross(axis, first)
    gone = float(np.linalg.norm(hinge.moved.p - hinge.fixed.p, axis=1).max())
    width = part.half * view.reach + gone
    corners = circle_points(view, hinge.fixed.p, first * width, second * width, np.pi / 4 + np.arange(4) * np.pi / 2)
    return (path("plate", corners, closed=True),)


# At a point, or between the ends


def _socket(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    angles = np.linspace(np.radians(-35), np.radians(215), 19)
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1)[None] * view.size * 1.45
    return (path("socket", view.flat(hinge.moved.p)[:, None] + around, size=2.0),)


def _polygon(look: str, corners: list[list[int]], hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    around = np.array(corners) * (view.size * part.half)
    return (path(look, view.flat(hinge.moved.p)[:, None] + around[None], closed=True),)


def _rod(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    ends = (view.flat(hinge.fixed.p), view.flat(hinge.moved.p))
    balls = (dot("joint ball", end, view.size * part.half) for end in ends)
    return (line("halo", *ends, size=5.4), line("rod", *ends, size=2.4), *balls)


def _wire(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    if hinge.wire is None:
        return (_apart("flight", hinge, view),)
    return (line("rail", *(view.flat(hinge.wire[:, k]) for k in range(hinge.wire.shape[1])), size=2.0),)


def _apart(look: str, hinge: JointAxis, view: View) -> Shape:
    return line(look, view.flat(hinge.fixed.p), view.flat(hinge.moved.p), size=1.2)


PARTS: dict[str, Callable[[JointAxis, View, MarkPart], tuple[Shape, ...]]] = {
    "line": lambda hinge, view, part: (line("axis", *_ends(hinge, view, part), size=1.2),),
    "arm": _arm,
    "arrow": _arrow,
    "cylinder": partial(_solid, cylinder),
    "box": partial(_solid, box),
    "slider": _slider,
    "thread": _thread,
    "rail": _rail,
    "wire": _wire,
    "plate": _plate,
    "ring": lambda hinge, view, part: (dot("joint", view.flat(hinge.moved.p), view.size * 0.8),),
    "ball": lambda hinge, view, part: (dot("joint ball", view.flat(hinge.moved.p), view.size * part.half),),
    "socket": _socket,
    "square": partial(_polygon, "weld", [[-1, -1], [1, -1], [1, 1], [-1, 1]]),
    "diamond": partial(_polygon, "joint", [[-1, 0], [0, -1], [1, 0], [0, 1]]),
    "rod": _rod,
    "flight": lambda hinge, view, part: (_apart("flight", hinge, view),),
    "frames": lambda hinge, view, part: joined([triad(view, X.p, X.R, part.half) for X in (hinge.fixed, hinge.moved)]),
}


AROUND, SHARE = 1.5, 0.3
"""How far a plane is drawn around what touches it: in radii of a wheel, and for a blade over the size of the scene."""

STROKES = 9

LONG = 600.0  # units of the picture, beyond which there are more strokes: a view sees a part of that ground


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
            # the line that a slider sits on, hatched below or on the left
            a, b = rail_ends(hinge, view, rail, 4.0)
            way = unit(b - a)[0]
            down = np.array([-way[1], way[0]])
            down = down if (round(down[1], 6), -down[0]) > (0, 0) else -down
            shift = down * view.size * 1.25
            shapes = hatches(a + shift, b + shift, down, view.size)
        else:
            shapes = _bearing(scene, hinge, places, view)
        title = Title("ground at joint {name}", name=hinge.joint.name)
        items.append(Item(f"ground-{hinge.joint.name}", title, 0, np.zeros(places.count), shapes))
    return tuple(items)


def _seat(hinge: JointAxis) -> Array:
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


def hatches(a: Array, b: Array, down: Array, s: float) -> tuple[Shape, ...]:
    """Return a line with strokes on one side of it."""
    way = unit(b - a)
    length = float(np.linalg.norm(b[0] - a[0]))
    count = max(4, round(min(40 * max(1.0, length / LONG), length / (0.75 * s))))
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
    for row in touching(scene):
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
    count = round(STROKES * max(1.0, float(np.linalg.norm(b[0] - a[0])) / LONG))
    shares = np.linspace(0, 1, count + 2)[1:-1]
    strokes = [np.stack([a + (b - a) * s, d + (c - d) * s], axis=1) for s in shares]
    return (path("stand", corners, closed=True), path("hatch", *strokes, size=0.8))


def pushes(row: Contact, places: Places, k: int = 0) -> tuple[Array, list[Array]]:
    """Return where a contact acts at position k of those found, and its unit forces, as its multipliers go."""
    touch = places.touches[row.name]
    n, spot = touch.normal[k], touch.spot[k]
    if touch.across is not None:
        return spot, [touch.across[k]]
    _, axis, radius = places.wheels.get(row.name, (None, None, 0.0))  # a point is a small ball
    a = np.cross(n, touch.along[k]) if axis is None else axis[k]
    w = float(np.linalg.norm(np.cross(a, n))) or 1.0
    along = np.cross(a, n) / w
    ways = {"along": along, "across": np.cross(n, along), "normal": n}
    return spot - radius * (n - (n @ a) * a) / w, [ways[component] for component in row.components]
