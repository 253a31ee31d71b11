"""Symbols of joints: the parts that joint types make them of, one function a part.

A symbol shows what the joint leaves free: a ring or a cylinder turns, a box slides, a cylinder with a thread does both.
What the child carries is filled with paper, what the parent carries (rails, plates) is a plain line.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from symdyn.draw.places import Array, JointAxis, across
from symdyn.draw.shapes import Shape, arrow, box, circle_points, cylinder, dot, joined, line, path
from symdyn.draw.view import View
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, MarkPart


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


def _line(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    return (line("axis", *_ends(hinge, view, part), size=1.2),)


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


def _ring(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    return (dot("joint", view.flat(hinge.moved.p), view.size * 0.8),)


def _ball(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    return (dot("joint ball", view.flat(hinge.moved.p), view.size * part.half),)


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


def _flight(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    return (_apart("flight", hinge, view),)


def _apart(look: str, hinge: JointAxis, view: View) -> Shape:
    return line(look, view.flat(hinge.fixed.p), view.flat(hinge.moved.p), size=1.2)


def _frames(hinge: JointAxis, view: View, part: MarkPart) -> tuple[Shape, ...]:
    return joined([triad(view, frame.p, frame.R, part.half) for frame in (hinge.fixed, hinge.moved)])


PARTS: dict[str, Callable[[JointAxis, View, MarkPart], tuple[Shape, ...]]] = {
    "line": _line,
    "arm": _arm,
    "arrow": _arrow,
    "cylinder": partial(_solid, cylinder),
    "box": partial(_solid, box),
    "slider": _slider,
    "thread": _thread,
    "rail": _rail,
    "plate": _plate,
    "ring": _ring,
    "ball": _ball,
    "socket": _socket,
    "square": partial(_polygon, "weld", [[-1, -1], [1, -1], [1, 1], [-1, 1]]),
    "diamond": partial(_polygon, "joint", [[-1, 0], [0, -1], [1, 0], [0, 1]]),
    "rod": _rod,
    "flight": _flight,
    "frames": _frames,
}
