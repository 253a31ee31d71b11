"""Symbols of joints: one function a joint type, and the table that names them.

A symbol shows what the joint leaves free: a ring or a cylinder turns, a box slides, a cylinder with a thread does both.
What the child carries is filled with paper, what the parent carries (rails, plates) is a plain line.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symdyn.draw.places import Array, Hinge, across
from symdyn.draw.shapes import Shape, arrow, box, circle_points, cylinder, dot, joined, line, path
from symdyn.draw.view import View
from symdyn.scene import GROUND

Symbol = Callable[[Hinge, View], tuple[Shape, ...]]


def _revolute(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    if view.planar:
        return _ring(view.flat(hinge.moved.p), view)
    return (
        _axis_line(hinge, view, 2.4),
        *cylinder("joint", view, hinge.moved.p, hinge.axis, 1.3 * view.size, view.size),
    )


def _prismatic(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    if view.planar:
        at, way = view.flat(hinge.moved.p), view.lean(hinge.axis)
        side = np.stack([-way[:, 1], way[:, 0]], axis=1) * view.size * 1.25
        way = way * view.size * 2
        corners = np.stack([at + way + side, at - way + side, at - way - side, at + way - side], axis=1)
        return (*_rail(hinge, view), path("joint", corners, closed=True))
    tip = hinge.moved.p + hinge.axis * view.reach * 4
    shown = arrow("axis", view.flat(hinge.moved.p), view.flat(tip), 1.2, 6.0)
    return (*_rail(hinge, view), *shown, *box("joint", view, hinge.moved.p, hinge.axis, 1.7 * view.size, view.size))


def _helical(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    body = cylinder("joint", view, hinge.moved.p, hinge.axis, 2 * view.size, view.size)
    front = view.toward - (hinge.axis @ view.toward)[:, None] * hinge.axis
    length = np.linalg.norm(front, axis=1, keepdims=True)
    front = np.where(length > 1e-6, front / np.where(length > 1e-6, length, 1), across(hinge.axis))
    side, angles = np.cross(hinge.axis, front), np.linspace(-np.pi / 2, np.pi / 2, 7)
    threads = []
    for k in (-1.2, -0.4, 0.4):
        rises = (k + 0.8 * (angles / np.pi + 0.5)) * view.reach
        at = hinge.moved.p[:, None] + hinge.axis[:, None] * rises[None, :, None]
        turned = np.cos(angles)[None, :, None] * front[:, None] + np.sin(angles)[None, :, None] * side[:, None]
        threads.append(view.flat(at + turned * view.reach * 0.93))
    return (*_rail(hinge, view), *body, path("thread", *threads, size=1.2))


def _cylindrical(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    body = cylinder("joint", view, hinge.moved.p, hinge.axis, 2 * view.size, view.size)
    return (*_rail(hinge, view), *body)


def _universal(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    at, arms = hinge.moved.p, []
    for axis in hinge.ways.values():
        ends = [view.flat(at + axis * view.reach * k) for k in (-1.7, 1.7)]
        arms.append((line("cross", *ends, size=2.6), *(dot("joint", end, view.size * 0.42) for end in ends)))
    return joined(arms)


def _spherical(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    at = view.flat(hinge.moved.p)
    angles = np.linspace(np.radians(-35), np.radians(215), 19)
    socket = at[:, None] + np.stack([np.cos(angles), np.sin(angles)], axis=1)[None] * view.size * 1.45
    return (path("socket", socket, size=2.0), dot("joint ball", at, view.size))


def _planar(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    if view.planar:
        return (*_plate(hinge, view, 3.0), *_ring(view.flat(hinge.moved.p), view))
    body = cylinder("joint", view, hinge.moved.p, hinge.axis, 0.6 * view.size, view.size)
    return (*_plate(hinge, view, 3.5), *body)


def _point_on_line(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    return (*_rail(hinge, view), dot("joint ball", view.flat(hinge.moved.p), view.size))


def _point_on_plane(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    return (*_plate(hinge, view, 3.5), dot("joint ball", view.flat(hinge.moved.p), view.size))


def _rod(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    ends = (view.flat(hinge.fixed.p), view.flat(hinge.moved.p))
    balls = (dot("joint ball", end, view.size * 0.7) for end in ends)
    return (line("halo", *ends, size=5.4), line("rod", *ends, size=2.4), *balls)


def _free(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    way = line("flight", view.flat(hinge.fixed.p), view.flat(hinge.moved.p), size=1.2)
    return (way, *triad(view, hinge.fixed.p, hinge.fixed.R), *triad(view, hinge.moved.p, hinge.moved.R))


def _fixed(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    at, r = view.flat(hinge.moved.p), view.size * 0.6
    corners = np.array([[-r, -r], [r, -r], [r, r], [-r, r]])
    return (path("weld", at[:, None] + corners[None], closed=True),)


def _custom(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    at, r = view.flat(hinge.moved.p), view.size * 1.35
    corners = np.array([[-r, 0], [0, -r], [r, 0], [0, r]])
    way = line("flight", view.flat(hinge.fixed.p), at, size=1.2)
    return (way, path("joint", at[:, None] + corners[None], closed=True))


SYMBOLS: dict[str, Symbol] = {
    "revolute": _revolute,
    "prismatic": _prismatic,
    "fixed": _fixed,
    "helical": _helical,
    "cylindrical": _cylindrical,
    "universal": _universal,
    "spherical": _spherical,
    "planar": _planar,
    "point_on_line": _point_on_line,
    "point_on_plane": _point_on_plane,
    "rod": _rod,
    "free": _free,
    "custom": _custom,
}


def symbol(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    """Return the symbol of a joint; that of a loop which does not close shows its gap."""
    shown = SYMBOLS[hinge.joint.type](hinge, view)
    if not hinge.closes:
        return shown
    gap = line("gap", view.flat(hinge.fixed.p), view.flat(hinge.moved.p), size=1.2)
    shifted = float(np.linalg.norm(gap.points[:, 1] - gap.points[:, 0], axis=1).max())
    parted = shifted > 1.0 and hinge.joint.type in ("revolute", "spherical", "universal", "fixed")
    return (gap, *shown) if parted else shown


def triad(view: View, at: Array, R: Array) -> tuple[Shape, ...]:
    """Return the axes of a frame as arrows, x, y, z; one that points at the viewer is not more than a speck."""
    tips = [at + R[:, :, k] * view.reach * 3 for k in range(3)]
    return joined([arrow(f"triad-{'xyz'[k]}", view.flat(at), view.flat(tip), 1.6, 5.0) for k, tip in enumerate(tips)])


def _ring(at: Array, view: View) -> tuple[Shape, ...]:
    return (dot("joint", at, view.size * 0.8),)


def _axis_line(hinge: Hinge, view: View, half: float) -> Shape:
    ends = [view.flat(hinge.moved.p + hinge.axis * view.reach * k) for k in (-half, half)]
    return line("axis", *ends, size=1.2)


def _rail(hinge: Hinge, view: View) -> tuple[Shape, ...]:
    """Return what a slide runs on, as long as all its ways; on the ground of a planar scene `ground` draws it."""
    if view.planar and GROUND in (hinge.joint.parent, hinge.joint.child):
        return ()
    return (line("rail", *rail_ends(hinge, view, 3.2), size=2.4),)


def rail_ends(hinge: Hinge, view: View, beyond: float) -> tuple[Array, Array]:
    """Return the ends of a rail in the picture, some sizes of a symbol beyond all places of the slider."""
    way = np.einsum("ni,ni->n", hinge.moved.p - hinge.fixed.p, hinge.axis)
    low, high = min(0.0, float(way.min())) - beyond * view.reach, max(0.0, float(way.max())) + beyond * view.reach
    return view.flat(hinge.fixed.p + hinge.axis * low), view.flat(hinge.fixed.p + hinge.axis * high)


def _plate(hinge: Hinge, view: View, half: float) -> tuple[Shape, ...]:
    """Return the plate that a joint moves on, as wide as all its ways."""
    first = across(hinge.axis)
    second = np.cross(hinge.axis, first)
    gone = float(np.linalg.norm(hinge.moved.p - hinge.fixed.p, axis=1).max())
    width = half * view.reach + gone
    corners = circle_points(view, hinge.fixed.p, first * width, second * width, np.pi / 4 + np.arange(4) * np.pi / 2)
    return (path("plate", corners, closed=True),)
