"""Bodies as links: from the frame of the joint that carries a body to all that is on it, and where its masses are."""

from __future__ import annotations

import numpy as np

from symdyn.draw.outlines import Outlined
from symdyn.draw.places import Array, JointAxis, Placed, Places, unit
from symdyn.draw.shapes import Item, Shape, disc, dot, line, path, sign
from symdyn.draw.titles import Title
from symdyn.draw.view import View
from symdyn.scene import Scene

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
    return ends


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
    for row in scene.contacts:
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
