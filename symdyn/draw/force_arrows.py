"""What acts: struts by the marks of their kinds, forces and couples as arrows, gravity.

A force is drawn from the point that it acts at. A couple is an arc in a planar scene, else an arrow with two heads
along its axis, right-handed. Arrows have one length: a picture shows directions, numbers are for tables.

Beside the mechanism stand the direction of gravity, and in a spatial picture those of the ground's axes.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from symdyn.draw.outlines import strings
from symdyn.draw.places import ROUGH, Array, JointAxis, Label, Places, Put, crosses, unit
from symdyn.draw.shapes import Item, Shape, Title, arc_arrow, arrow, circle_points, dot, path
from symdyn.draw.stage import View
from symdyn.draw.style import FONT, Text
from symdyn.draw.svg import Drawing
from symdyn.emit.print import latex_symbols
from symdyn.frozen import dataclass, replace
from symdyn.graph import Op
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.values import Element, Joint, Strut

ARROW = 46.0  # length of a force, units of the picture
BESIDE = 6.0  # how far a couple's arrow is beside its point, units of the picture
FACING = 0.98  # cosine between a couple's axis and the line of sight from which on it is an arc
END_ON = 0.12  # of a direction: what lies in the picture; below, the arrow is a point or a cross in a circle


@dataclass(frozen=True)
class Wrench:
    """A force and a couple to be drawn."""

    name: str  # of the force, as code writes it ("F_1") or in LaTeX ("m_1 g")
    at: Sequence[float]  # the point that it acts at, ground frame, m; shape (3,)
    force: Sequence[float] = (0.0, 0.0, 0.0)  # ground frame, N; zeros for none
    couple: Sequence[float] = (0.0, 0.0, 0.0)  # ground frame, N m; zeros for none
    couple_name: str = ""  # name of the couple; "" takes the force's


def wrench(one: Wrench, view: View, id: str) -> tuple[tuple[Item, ...], tuple[Label, ...]]:
    """Return the arrows of one wrench and their labels."""
    at, force, couple = (np.array([values], dtype=np.float64) for values in (one.at, one.force, one.couple))
    drawn = []
    if np.any(force):
        drawn.append(("force", id, one.name, _straight("force", view, at, unit(force), 1)))
    if np.any(couple):
        axis, look = unit(couple), "force couple"
        facing = float(np.abs(axis @ view.toward)[0]) > FACING
        arrows = _turning(look, view, at, axis) if facing else _straight(look, view, at, axis, 2)
        drawn.append(("couple", f"{id}-couple", one.couple_name or one.name, arrows))
    items = tuple(
        Item(key, Title("{type} {name}", type=what, name=Text.of_name(name).spoken), 2, view.depth(at), shapes)
        for what, key, name, (shapes, _, _) in drawn
    )
    labels = (
        Label(f"{key}-label", Text.of_name(name), tip, 5.0, away, f"{what}-text")
        for what, key, name, (_, tip, away) in drawn
    )
    return items, tuple(labels)


def _straight(look: str, view: View, at: Array, way: Array, heads: int) -> tuple[tuple[Shape, ...], Array, Array]:
    flat, start = view.lean(way), view.flat(at)
    if float(np.linalg.norm(flat)) < END_ON:
        near = float((way @ view.toward)[0]) > 0
        return end_on(look, start, 6.0, near), start, np.array([0.7071, -0.7071])
    if heads > 1:  # beside a force along the same line
        start = start + np.stack([-flat[:, 1], flat[:, 0]], axis=1) / np.linalg.norm(flat) * BESIDE
    tip = start + unit(flat) * ARROW
    return arrow(look, start, tip, 2.2, 9.0, heads), tip, unit(flat)[0]


def end_on(look: str, at: Array, radius: float, near: bool) -> tuple[Shape, ...]:
    """Return an arrow that points at the viewer, a point in a circle, or away, a cross in a circle."""
    ring = dot(f"{look} ring", at, radius)
    if near:
        return (ring, dot(f"{look} head", at, radius * 0.35))
    r = radius * 0.7
    strokes = [np.stack([at - np.array([r, k * r]), at + np.array([r, k * r])], axis=1) for k in (-1, 1)]
    return (ring, path(look, *strokes, size=1.4))


def _turning(look: str, view: View, at: Array, axis: Array) -> tuple[tuple[Shape, ...], Array, Array]:
    """Return a couple about the line of sight as three quarters of a circle."""
    sense = float(np.sign((axis @ view.toward)[0]))
    radius = 2.4 * view.size / view.scale
    x = np.broadcast_to(view.right * radius, at.shape)
    y = np.broadcast_to(view.up * radius, at.shape)
    curve = circle_points(view, at, x, y, sense * np.linspace(np.radians(-40), np.radians(230), 33))
    return arc_arrow(look, curve, 2.2, 9.0), curve[:, -1], unit(curve[0, -1] - view.flat(at)[0])


# Struts


def links(scene: Scene, places: Places, view: View) -> tuple[tuple[Item, ...], tuple[Label, ...]]:
    """Return all struts and their labels."""
    items: list[Item] = []
    labels: list[Label] = []
    for one in strings(scene):
        shapes, at = _link(one, scene, places, view)
        depth = np.zeros(places.count) if view.planar else np.full(places.count, -1e6)
        items.append(
            Item(f"{one.kind}-{one.name}", Title("{type} {name}", type=one.kind, name=one.name), 1, depth, shapes)
        )
        if one in scene.elements:  # a belt has no name
            text = Text.as_written(one.text) if one.text else Text.of_name(one.name)
            labels.append(Label(f"label-{one.name}", text, at, view.size * 1.2, None, "link-text"))
    return tuple(items), tuple(labels)


def _link(one: Element, scene: Scene, places: Places, view: View) -> tuple[tuple[Shape, ...], Array]:
    if one in places.routes:
        route = places.routes[one]
        drawn = np.stack([view.flat(at) for part in route for at in part], axis=1)
        shapes = [path(one.kind, drawn, size=1.6)]
        for (*_, start, end), wheel, centre in zip(route, one.ends[1:], places.ends[one][1:], strict=True):
            if wheel.turn:
                across, angles = end - centre, np.linspace(0, 2 * np.pi, 49)
                along = unit(end - start) * np.linalg.norm(across, axis=1, keepdims=True)
                shapes.append(path(one.kind, circle_points(view, centre, across, along, angles), size=1.0))
        return tuple(shapes), (view.flat(route[0][-1]) + view.flat(route[0][-2])) / 2
    assert isinstance(one, Strut), "a rope has a route"
    if one.ends:
        a, b = (view.flat(end) for end in places.ends[one])
        walls = [
            _wall(at, other, view.size)
            for at, other, end in ((a, b, 0), (b, a, 1))
            if one.ends[end].body == Scene.GROUND
        ]
        return (*walls, *_between(one, a, b, view.size)), (a + b) / 2
    hinge = next(hinge for hinge in places.hinges if hinge.joint.name == one.joint)
    if hinge.slides:
        return _beside(one, hinge, view, from_zero(scene, hinge.joint))
    at = view.flat(hinge.moved.p)
    (near, first), (far, last), width = FORCES[one.kind].lines.curl
    r, turns = np.linspace(near, far, 61) * view.size, np.linspace(first, last, 61)
    curve = np.stack([r * np.cos(turns), r * np.sin(turns)], axis=1)
    return (path(one.kind, at[:, None] + curve[None], size=width),), at + curve[-1]


def _beside(one: Strut, hinge: JointAxis, view: View, begins: bool) -> tuple[tuple[Shape, ...], Array]:
    """Return a strut of a slide: from the joint's zero, or from a wall behind it, to the slider."""
    along = hinge.slides[0]
    way = np.einsum("ni,ni->n", hinge.moved.p - hinge.fixed.p, along)
    length = 4 * view.size / view.scale  # of what can be drawn
    begins = begins and float(way.min()) > length
    room = 0.0 if begins else max(60.0, 30.0 - float(way.min()) * view.scale) / view.scale
    flat = unit(view.lean(along))
    side = np.stack([-flat[:, 1], flat[:, 0]], axis=1) * view.size * FORCES[one.kind].lines.side
    a = view.flat(hinge.fixed.p - along * room) + side
    b = view.flat(hinge.moved.p) - flat * 2 * view.size + side
    return (_wall(a, b, view.size, hinge.joint.parent == Scene.GROUND), *_between(one, a, b, view.size)), (a + b) / 2


def from_zero(scene: Scene, joint: Joint) -> bool:
    """Tell whether a slide's struts begin at its zero: its coordinate is the length of one of them."""
    return any(FORCES[one.kind].lines.has_length(one) for one in scene.struts if one.joint == joint.name)


def _wall(at: Array, other: Array, size: float, ground: bool = True) -> Shape:
    """Return what a spring is fixed to at one end: the ground is hatched, a body is not."""
    way = unit(other - at)
    along = np.stack([-way[:, 1], way[:, 0]], axis=1) * size
    strokes = [np.stack([at + along * k, at + along * (k - 0.5) - way * size * 0.6], axis=1) for k in (-0.5, 0.1, 0.7)]
    strokes = strokes if ground else []
    return path("floor", np.stack([at - along, at + along], axis=1), *strokes, size=1.4)


def _between(one: Strut, a: Array, b: Array, size: float) -> tuple[Shape, ...]:
    side = unit(np.stack([a[:, 1] - b[:, 1], b[:, 0] - a[:, 0]], axis=1)) * size * 0.75
    drawn = []
    for width, lines in FORCES[one.kind].lines.strokes:
        parts = [np.stack([a + (b - a) * share + side * off for share, off in points], axis=1) for points in lines]
        drawn.append(path(one.kind, *parts, size=width))
    return tuple(drawn)


LONG, AXIS = 34.0, 26.0  # lengths of the arrows of gravity and of axes
NEAR = 100.0  # so that no line leads to the letters


def with_corner(drawing: Drawing, scene: Scene, places: Places, view: View, segments: Array) -> Drawing:
    """Return the drawing with arrows in a free corner, or beside it where none is; segments are as it is framed."""
    blocks = []
    if np.any(places.gravity):
        blocks.append(_gravity(scene, places, view))
    if not view.planar:
        blocks.append(_axes(view))
    for items, labels in blocks:
        shift = _free_place(drawing, items, labels, segments)
        moved = tuple(_moved(item, shift) for item in items)
        way = np.zeros((1, 2)) if drawing.camera is None else drawing.camera  # what stands in the frame goes with it
        named = tuple(Put(replace(one.label, at=one.label.at + shift + way), one.offset) for one in labels)
        standing = tuple(_moved(item, way[:, None]) for item in moved)
        drawing = replace(drawing, items=drawing.items + standing, labels=drawing.labels + named)
        new = np.concatenate([shape.segments for item in moved for shape in item.shapes], axis=1)
        segments = np.concatenate([segments, np.broadcast_to(new, (len(segments), *new.shape[1:]))], axis=1)
    return drawing


Block = tuple[tuple[Item, ...], tuple[Put, ...]]


def _gravity(scene: Scene, places: Places, view: View) -> Block:
    way = view.lean(unit(places.gravity[None, :]))
    start = np.zeros((1, 2))
    if float(np.linalg.norm(way)) < END_ON:
        near = float(places.gravity @ view.toward) > 0
        shapes, beside = end_on("gravity", start, 7.0, near), np.array([16.0, 0.0])
    else:
        flat = unit(way)
        tip = flat * LONG
        shapes = arrow("gravity", start, tip, 2.0, 9.0)
        beside = tip[0] / 2 + np.array([abs(flat[0, 1]), -abs(flat[0, 0])]) * 13
    label = Label("label-gravity", Text.of_latex(_gravity_name(scene)), start, NEAR)
    return (Item("gravity", Title("direction of gravity"), 2, np.zeros(1), tuple(shapes)),), (Put(label, beside),)


def _gravity_name(scene: Scene) -> str:
    """Return the parameter that gravity is called by, else g."""
    entries = [entry for entry in scene.gravity if not (entry.op is Op.CONSTANT and entry.value == 0)]
    if len(entries) == 1:
        inner = entries[0].args[0] if entries[0].op is Op.NEG else entries[0]
        if inner.op is Op.SYMBOL:
            return latex_symbols(scene)[str(inner.value)]
    return "g"


def _axes(view: View) -> Block:
    shapes: list[Shape] = []
    labels: list[Put] = []
    start = np.zeros((1, 2))
    for k, letter in enumerate("xyz"):
        tip = view.lean(np.eye(3)[k : k + 1]) * AXIS
        shapes += arrow(f"triad-{letter}", start, tip, 1.8, 6.0)
        if float(np.linalg.norm(tip)) > 6:
            label = Label(f"label-axis-{letter}", Text.of_latex(letter), start, NEAR, None, f"{letter}-text")
            away = (tip[0] + unit(tip)[0] * FONT * (0.55 + 0.3 * further) for further in range(6))
            clear = (one for one in (Put(label, offset) for offset in away) if not _meets(one, labels))
            labels += list(clear)[:1]
    return (Item("axes", Title("directions of the ground's axes"), 2, np.zeros(1), tuple(shapes)),), tuple(labels)


def _meets(one: Put, others: Sequence[Put]) -> bool:
    """Return whether a label lies on others, all of one moment."""
    low, high = one.box[0]
    return any(bool(np.all((low < other.box[0, 1]) & (high > other.box[0, 0]))) for other in others)


def _moved(item: Item, shift: Array) -> Item:
    return replace(item, shapes=tuple(replace(shape, points=shape.points + shift) for shape in item.shapes))


def _free_place(drawing: Drawing, items: Sequence[Item], labels: Sequence[Put], segments: Array) -> Array:
    """Return where to put a block: the corners first, then along the edges, then beside the drawing."""
    left, top, wide, high = Drawing("", tuple(items), tuple(labels)).box
    x, y, width, height = drawing.box
    taken = np.concatenate([drawing.framed(one.box) for one in drawing.labels] or [np.zeros((0, 2, 2))])
    places = itertools.product((0.0, 1.0, 0.25, 0.75, 0.5), (0.0, 1.0, 0.5))
    for across, down in sorted(places, key=lambda place: (place[0] not in (0, 1)) + (place[1] not in (0, 1))):
        corner = np.array([x + (width - wide) * across, y + (height - high) * down])
        if width < wide or height < high:
            break
        low, far = corner[None] + ROUGH, corner[None] + np.array([[wide, high]]) - ROUGH
        boxed = np.any(np.all((taken[:, 0] < far) & (taken[:, 1] > low), axis=1))
        many = np.broadcast_to(low, (len(segments), 2)), np.broadcast_to(far, (len(segments), 2))
        if not boxed and not np.any(crosses(*many, segments)):
            return np.asarray(corner - [left, top])
    beside = np.array([x + width - 12.0, y + max(0.0, (height - high) / 2)])
    return np.asarray(beside - [left, top])
