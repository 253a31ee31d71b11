"""What pictures are made of: paths, dots, discs and signs, at N moments each.

Coordinates are in units of the picture, y down. A shape keeps its make-up from moment to moment, only numbers change,
so that one description serves a picture and an animation.

A body is drawn as a link, from the frame of the joint that carries it to all that is on it, and where its masses are.
Who points at a part of a picture is told what it is in English; a lesson says it in its own language.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.draw.outlines import Outlined, gears, touching
from symdyn.draw.places import Array, JointAxis, Placed, Places, across, unit
from symdyn.frozen import dataclass, field
from symdyn.scene import Scene
from symdyn.scene.values import PlaneContact

if TYPE_CHECKING:
    from symdyn.draw.stage import View


class Title(str):
    """An English sentence with its places filled, which remembers how it was made."""

    template: str  # the sentence, with places in braces
    places: Mapping[str, str]  # what fills them

    def __new__(cls, template: str, **places: str) -> Title:
        made = super().__new__(cls, template.format(**places))
        made.template, made.places = template, places
        return made

    def sentence(self, words: Mapping[str, str]) -> str:
        """Return the sentence by a table from English: sentences, types of joints, "body NAME", "spring NAME"."""
        filled = {key: words.get(value, value) if key in TRANSLATED else value for key, value in self.places.items()}
        if "name" in filled:
            named = (one for one in ("joint", "contact") if one in self.template)
            part = next(named, self.places.get("type", "body"))
            filled["name"] = words.get(f"{part} {filled['name']}", filled["name"])
        return words.get(self.template, self.template).format(**filled)


ENGLISH: Mapping[str, str] = {}
"""Nothing to translate."""

TRANSLATED = ("type",)
"""Places that hold a word and no name."""


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
    """Shapes that belong together: a body, a joint, a load."""

    id: str  # of its group in the picture, without the picture's prefix
    title: Title  # what a reader is told who points at it
    layer: int  # what lies on top: 0 ground, 1 mechanism, 2 marks
    depth: Array  # how near it is to the viewer, shape (N,); decides within a layer
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


COLOURS = 6  # of bodies, in turns; the style sheet has as many

QUARTERS = "M0 0V{m}A{r} {r} 0 0 1 {r} 0ZM0 0V{r}A{r} {r} 0 0 1 {m} 0Z"


def carrier(places: Places, body: str) -> JointAxis:
    """Return the joint that carries a body."""
    return next(hinge for hinge in places.hinges if hinge.joint.child == body and not hinge.closes)


def spots(scene: Scene, result: Places, body: str) -> list[Array]:
    """Return what is on a body: joints, loops, particles, points, ends of springs and loads; shape (N, 3) each."""
    ends = [hinge.fixed.p for hinge in result.hinges if hinge.joint.parent == body]
    ends += [hinge.moved.p for hinge in result.hinges if hinge.joint.child == body and hinge.closes]
    ends += [at for _, at in result.body(body).particles]
    ends += [frame.p for owner, frame in result.points.values() if owner == body]
    for one, places in result.ends.items():
        ends += [at for at, end in zip(places, one.ends, strict=True) if end.body == body]
    struck = [one for one in scene.unilaterals if isinstance(one, PlaneContact) and one.place.body == body]
    return ends + [result.touches[one.name].spot for one in struck]


def farthest(scene: Scene, places: Places, body: str, start: Array) -> Array:
    """Return the spot, or the centre of mass, of a body that is farthest from a point, shape (N, 3)."""
    com = places.body(body).com
    ends = spots(scene, places, body) or ([] if com is None else [com])
    return max(ends, key=lambda end: round(float(np.linalg.norm(end[0] - start[0])), 9), default=start)


def link(scene: Scene, places: Places, body: Placed, view: View, colour: int) -> tuple[Item, ...]:
    """Return a body and, on top of it, its centre of mass and its particles."""
    start = carrier(places, body.name).moved.p
    outline, rod, shapes = places.outlines.get(body.name), list[Array](), list[Shape]()
    if outline is not None and outline.look == "rod":
        rod = ends_of(outline, body)
    elif outline is not None:
        shapes += outlined(outline, body, view, colour)
    along = rod if rod and between_ends(rod[0], rod[1], start, view) else []
    tips = outer(start, [*spots(scene, places, body.name), *along], view)
    com = body.com
    if com is not None and not tips:
        tips = outer(start, [com], view)
    elif com is not None and not any(between_ends(start, tip, com, view) for tip in tips):
        shapes.append(line("stem", view.flat(start), view.flat(com), size=1.4))
    if tips or rod:
        limbs = [np.stack([view.flat(at) for at in rod], axis=1)] if len(along) < len(rod) else []
        limbs += [np.stack([view.flat(start), view.flat(tip)], axis=1) for tip in tips]
        width = view.size * 0.7
        shapes += [path("halo", *limbs, size=width + 3), path(f"link body{colour}", *limbs, size=width)]
    for row in (*touching(scene), *gears(scene)):
        if row.name in places.wheels and row.place.body == body.name:
            centre, axis, radius = places.wheels[row.name]
            rims = [axis] if axis is not None else [np.broadcast_to(view.toward, centre.shape), body.frame.R[:, :, 2]]
            shapes += [disc(f"link body{colour}", view, centre, rim, radius * view.scale) for rim in rims]
    middle = np.mean([view.depth(start), *(view.depth(tip) for tip in tips)], axis=0)
    items = [Item(f"body-{body.name}", Title("body {name}", name=body.name), 1, middle, tuple(shapes))]
    heaviest = max((mass for one in places.bodies for mass, _ in one.particles), default=0.0)
    for k, (mass, at) in enumerate(body.particles):
        share = (max(mass, 0.0) / heaviest) ** (1 / 3) if heaviest > 0 else 1.0
        size = view.size * (0.4 + 0.6 * share)
        if any(float(np.linalg.norm(hinge.moved.p[0] - at[0])) < view.reach * 0.1 for hinge in places.hinges):
            size = max(size, 1.4 * view.size)  # it stays to be seen around the joint's symbol
        grain = dot(f"particle body{colour}", view.flat(at), size)
        title = Title("point mass {number} of {name}", number=str(k + 1), name=body.name)
        items.append(
            Item(f"mass-{body.name}-{k + 1}", title, 1, np.maximum(view.depth(at), middle) + view.size / 2, (grain,))
        )
    if com is not None:
        at, r = view.flat(com), round(view.size * 0.62, 2)
        mark = (dot("com", at, r), sign("com quarters", at, QUARTERS.format(r=r, m=-r), r))
        title = Title("centre of mass of {name}", name=body.name)
        items.append(Item(f"com-{body.name}", title, 1, np.maximum(view.depth(com), middle) + view.size / 2, mark))
    return tuple(items)


def ends_of(outline: Outlined, body: Placed) -> list[Array]:
    """Return both ends of a rod, shape (N, 3) each."""
    (way,) = outline.ways
    return [body.frame.point(outline.centre + sign * way) for sign in (-1, 1)]


def outlined(outline: Outlined, body: Placed, view: View, colour: int) -> list[Shape]:
    """Return what a body looks like that is more than a line, so that what lies behind it is seen."""
    centre, ways = body.frame.point(outline.centre), [body.frame.direction(way) for way in outline.ways]
    look = f"link body{colour}"
    if outline.look == "point":
        return [dot(f"particle body{colour}", view.flat(centre), view.size)]
    if outline.look == "plate":
        a, b = ways
        corners = [centre + x * a + y * b for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
        return [path(f"plate {look}", np.stack([view.flat(at) for at in corners], axis=1), closed=True, size=2.0)]
    radius = float(np.linalg.norm(outline.ways[0])) * view.scale
    if outline.look == "ball":
        rims = [np.broadcast_to(view.toward, centre.shape), unit(ways[2])]
        looks = (f"plate {look}", look)
        return [disc(one, view, centre, rim, radius) for one, rim in zip(looks, rims, strict=True)]
    rim, most = unit(np.cross(ways[0], ways[1])), view.flat(centre + ways[0])
    if outline.look == "ring":
        return [disc(look, view, centre, rim, radius), line(look, view.flat(centre + 0.88 * ways[0]), most, size=3)]
    spoke = line("stem", view.flat(centre - ways[0]), most)
    return [disc(f"plate {look}", view, centre, rim, radius), spoke]


def outer(start: Array, ends: list[Array], view: View) -> list[Array]:
    """Return those ends that no line to another one passes, and that are not the start itself."""
    far = [end for end in ends if float(np.linalg.norm(end[0] - start[0])) * view.scale > 1.0]
    far.sort(key=lambda end: -round(float(np.linalg.norm(end[0] - start[0])), 9))
    kept: list[Array] = []
    for end in far:
        if not any(between_ends(start, other, end, view) for other in kept):
            kept.append(end)
    return kept


def between_ends(start: Array, end: Array, point: Array, view: View) -> bool:
    """Return whether a point is on the line between two others, as far as an eye can tell."""
    way, off = end[0] - start[0], point[0] - start[0]
    share = float(np.clip(way @ off / (way @ way), 0, 1))
    return float(np.linalg.norm(off - share * way)) * view.scale < 1.0
