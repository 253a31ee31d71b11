"""Coordinates: turns as arcs from the zero position, slides as dimensions, both with an arrow at the end.

A coordinate that is too near zero for that shows its sense: a short dashed arrow the way it grows.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symdyn.draw.body_shapes import farthest
from symdyn.draw.label_places import Label
from symdyn.draw.lettering import Text
from symdyn.draw.places import Array, FrameStep, JointAxis, Places, across, unit
from symdyn.draw.shapes import Item, arc_arrow, arrow, circle_points, line
from symdyn.draw.titles import Title
from symdyn.draw.view import View
from symdyn.scene import Scene

SHORT = 10.0  # units of the picture: an arc or a dimension below this shows the sense alone
SENSE = np.radians(55)


def marks(
    scene: Scene, places: Places, view: View, latex: Mapping[str, str]
) -> tuple[tuple[Item, ...], tuple[Label, ...]]:
    """Return arcs and dimensions of all coordinates, which `latex` spells, and their labels, at one moment."""
    items: list[Item] = []
    labels: list[Label] = []
    taken: list[tuple[Array, float]] = []
    for hinge in places.hinges:
        if hinge.closes or not hinge.joint.coordinates:
            continue
        named = [step for step in hinge.steps if step.name]
        told = {step.name for step in named}
        for step in named:
            if step.slides:
                drawn, label = _slide(places, hinge, step, view, latex)
            else:
                drawn, label = _turn(scene, places, hinge, step, view, latex, taken)
            items.append(drawn)
            labels.append(label)
        rest = [name for name in hinge.joint.coordinates if name not in told]
        if rest:
            between = ", " if len(rest) < 3 else "…"
            text = Text.of_latex(between.join(latex[name] for name in dict.fromkeys([rest[0], rest[-1]])))
            labels.append(Label(f"label-{rest[0]}", text, view.flat(hinge.moved.p), view.size * 1.8, None, "mark-text"))
    return tuple(items), tuple(labels)


def _turn(
    scene: Scene, places: Places, hinge: JointAxis, step: FrameStep, view: View, latex: Mapping[str, str],
    taken: list[tuple[Array, float]],
) -> tuple[Item, Label]:  # fmt: skip
    at, axis, amount = step.at, step.axis, float(step.amount[0])
    amount = float(np.fmod(amount, 2 * np.pi)) if abs(amount) > 2 * np.pi else amount
    reach = farthest(scene, places, hinge.joint.child, at) - at
    level = reach - np.einsum("ni,ni->n", reach, axis)[:, None] * axis
    length = float(np.linalg.norm(level[0])) * view.scale
    arbitrary = length < 2.0
    if arbitrary:
        zero = across(axis)
    else:
        now = unit(level)
        zero = np.cos(amount) * now - np.sin(amount) * np.cross(axis, now)
    widest = (3.9 if view.planar else 5.2) * view.size
    radius = widest if arbitrary else max(2.4 * view.size, min(widest, 0.6 * length))
    centre = view.flat(at)[0]
    while any(np.linalg.norm(centre - other) < 3 * view.size and abs(radius - r) < view.size for other, r in taken):
        radius += 1.2 * view.size
    taken.append((centre, radius))
    x, y = zero * radius / view.scale, np.cross(axis, zero) * radius / view.scale
    tiny = abs(amount) * radius < SHORT
    ends = np.linspace(0, SENSE if tiny else amount, 33)
    curve = circle_points(view, at, x, y, ends)
    rays = [0.0] + ([amount] if arbitrary and not tiny else [])
    near, far = 1.35 * view.size / radius, 1 + 8 / radius
    shapes = []
    for a in rays:
        ray = np.cos(a) * x + np.sin(a) * y
        shapes.append(line("zero", view.flat(at + near * ray), view.flat(at + far * ray), size=1.0))
    shapes += arc_arrow("mark sense" if tiny else "mark", curve, head=min(8.0, view.size))
    middle = curve[:, 16]
    item = Item(f"mark-{step.name}", Title("coordinate {name}", name=step.name), 2, view.depth(at), tuple(shapes))
    away = unit(middle - centre)[0]
    return item, Label(f"label-{step.name}", Text.of_latex(latex[step.name]), middle, 4.0, away, "mark-text")


def _slide(
    places: Places, hinge: JointAxis, step: FrameStep, view: View, latex: Mapping[str, str]
) -> tuple[Item, Label]:
    a, b = view.flat(step.at), view.flat(step.at + step.axis * step.amount[:, None])
    tiny = float(np.linalg.norm(b - a)) < SHORT
    way = unit(view.lean(step.axis))
    side = np.stack([-way[:, 1], way[:, 0]], axis=1)
    others = [view.flat(one.moved.p) for one in places.hinges] + [
        view.flat(one.com) for one in places.bodies if one.com is not None
    ]
    lie = float(np.mean([np.sum((other - a) * side) for other in others]))
    side = -side if lie > 1e-6 or (abs(lie) <= 1e-6 and side[0, 1] < 0) else side
    hatched = view.planar and Scene.GROUND in (hinge.joint.parent, hinge.joint.child)
    off = side * view.size * (4.4 if hatched else 2.9)
    if tiny:
        b = a + way * 4.2 * view.size
        shapes = arrow("mark sense", a + off, b + off, head=min(8.0, view.size))
    else:
        shapes = (
            line("extension", a, a + off * 1.18, size=0.9),
            line("extension", b, b + off * 1.18, size=0.9),
            *arrow("mark", a + off, b + off, head=min(8.0, view.size)),
        )
    item = Item(f"mark-{step.name}", Title("coordinate {name}", name=step.name), 2, view.depth(step.at), tuple(shapes))
    middle = (a + b) / 2 + off
    return item, Label(f"label-{step.name}", Text.of_latex(latex[step.name]), middle, 4.0, unit(side)[0], "mark-text")
