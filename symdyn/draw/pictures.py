"""Pictures of a scene and of one of its bodies as SVG text.

Of coordinates turns are arcs from the zero position, slides dimensions, both with an arrow at the end. A coordinate
that is too near zero for that shows its sense: a short dashed arrow the way it grows.

A swing shows a mechanism in its middle and at both ends, in one picture. Text of pictures is text like any other, and
in a notebook what it describes.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from symdyn.arguments import suggesting, walked
from symdyn.draw.force_arrows import Wrench, links, with_corner, wrench
from symdyn.draw.ground import ground, planes, symbol, triad
from symdyn.draw.paint import File, check_picture, write_picture
from symdyn.draw.places import Array, FrameStep, JointAxis, Label, Places, across, put, unit
from symdyn.draw.shapes import (
    COLOURS,
    ENGLISH,
    Item,
    Shape,
    Title,
    arc_arrow,
    arrow,
    carrier,
    circle_points,
    farthest,
    line,
    link,
)
from symdyn.draw.stage import Stage, View, pose, values_of
from symdyn.draw.style import Text
from symdyn.draw.svg import Drawing, svg
from symdyn.emit.print import latex_symbols
from symdyn.errors import DrawError, choice, quoted, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.scene.values import Load
from symdyn.shown import Shown

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


class SvgText(str, Shown):
    """A picture as SVG; a notebook shows the picture."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Return a word in place of the text, which `print` gives."""
        return f"<SVG of {len(self)} characters>"


class HtmlText(str, Shown):
    """A page as HTML; a notebook shows the page in a frame."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Return a word in place of the text, which `print` gives."""
        return f"<HTML of {len(self)} characters>"


JOINT = {
    "joint": "{type} joint {name}",
    "loop": "{type} loop joint {name}",
    "led": "{type} joint {name}, follows {leader}",
}


@dataclass(frozen=True)
class Lettered:
    """A letter to be drawn, LaTeX such as m_1, and the point that it stands at, ground frame, m; shape (3,)."""

    latex: str
    at: Sequence[float]


LABELS = ("coordinates", "bodies", "joints", "points")


@suggesting
def picture(
    scene: SceneLike,
    q: Sequence[float] | Array | None = None,
    parameters: Mapping[str, float] | None = None,
    view: tuple[float, float] | None = None,
    frames: bool = False,
    labels: Collection[str] = ("coordinates", "bodies"),
    wrenches: Sequence[Wrench] = (),
    prefix: str = "",
    scheme: str = "auto",
    file: File | None = None,
    titles: Mapping[str, str] = ENGLISH,
    letters: Sequence[Lettered] = (),
) -> str:
    """Return a picture of the mechanism as SVG text; the same input gives the same bytes.

    A planar scene is seen face-on, gravity downwards; a spatial one in a parallel projection. The group of every body,
    joint, load and strut has an id such as `body-link1`, and a title.

    >>> import symdyn
    >>> svg = symdyn.picture(symdyn.example("cart_pole"), q=[0.2, 0.5])
    >>> svg[:4], "body-pole" in svg
    ('<svg', True)

    Args:
        scene: any scene.
        q: position, shape (nq,), in the scene's order; rad, m or 1. None: see `pose`.
        parameters: values of parameters; those without any are 1, or such that loops close.
        view: azimuth and elevation of the viewer in degrees; None for the usual ones.
        frames: draw the axes of every moved joint frame, x red, y green, z blue.
        labels: what is named: any of "coordinates", "bodies", "joints", "points". Loads and springs always are.
        wrenches: more forces and couples to draw.
        prefix: in front of every id, so that several pictures fit into one page.
        scheme: colours: "auto" follows the reader's preference, "light" and "dark" are plain.
        file: where the picture is written to as well: .svg, .pdf or .png (those two by matplotlib; "auto" is light).
        titles: what parts are called in another language, from the English of `symdyn.draw.shapes`.
        letters: more symbols, of masses and lengths, each beside its point.

    Raises:
        DrawError: q of another shape, an unknown name, loops that do not close, no real value at q, or a file of
            another kind or that cannot be written.
    """
    wrenches, letters = walked(picture, locals(), "wrenches", "letters", error=DrawError)
    if file is not None:
        check_picture(file)
    shown = drawing(scene_of(scene), q, parameters, view, frames, labels, wrenches, letters)
    return delivered(shown, prefix, scheme, file, titles)


def delivered(shown: Drawing, prefix: str, scheme: str, file: File | None, titles: Mapping[str, str]) -> str:
    """Return a drawing as SVG text, and write it where it shall also be."""
    text = SvgText(svg(shown, prefix, scheme, titles=titles))
    if file is not None:
        write_picture(file, shown, text, scheme)
    return text


@np.errstate(all="ignore")  # a place that no double holds is told by the text of the picture
def drawing(
    scene: Scene,
    q: Sequence[float] | Array | None = None,
    parameters: Mapping[str, float] | None = None,
    view: tuple[float, float] | None = None,
    frames: bool = False,
    labels: Collection[str] = ("coordinates", "bodies"),
    wrenches: Sequence[Wrench] = (),
    letters: Sequence[Lettered] = (),
) -> Drawing:
    """Return what `picture` writes, as shapes and placed labels."""
    for kind in labels:
        if kind not in LABELS:
            raise DrawError(f'there are no labels of "{kind}"; {choice(kind, LABELS)}')
    stage = staged(scene, q, parameters, view)
    found, seen = stage.places, stage.view
    items, names = mechanism(scene, found, seen)
    if "coordinates" in labels:
        arcs, marked = marks(scene, found, seen, latex_symbols(scene))
        items, names = items + arcs, marked + names
    more, forced = _acting(found, scene, seen, wrenches)
    items, names = items + more, forced + names
    if frames:
        items += _triads(found, seen)
    names += tuple(
        Label(f"label-letter-{k}", Text.of_name(one.latex), seen.flat(np.array([one.at])), seen.size * 0.8)
        for k, one in enumerate(letters, 1)
    )
    names += _names(found, seen, labels)
    segments = lines(items, 1)
    return with_corner(
        Drawing(scene.name, items, put(with_descriptions(scene, names), segments)), scene, found, seen, segments
    )


def mechanism(scene: Scene, places: Places, view: View) -> tuple[tuple[Item, ...], tuple[Label, ...]]:
    """Return planes, ground, springs, bodies and joints, and the labels of springs, at every moment that is found."""
    items = [*planes(scene, places, view), *ground(scene, places, view)]
    elastic, labels = links(scene, places, view)
    items += elastic
    for k, body in enumerate(places.bodies):
        items += link(scene, places, body, view, k % COLOURS)
    for hinge in places.hinges:
        joint = hinge.joint
        kind = "loop" if hinge.closes else "joint"
        text = Title(JOINT[kind], type=joint.type, name=joint.name)
        if joint.coupling:
            text = Title(JOINT["led"], type=joint.type, name=joint.name, leader=", ".join(joint.coupling.coordinates))
        ends = [item.depth for item in items if item.id in (f"body-{joint.parent}", f"body-{joint.child}")]
        depth = np.max([view.depth(hinge.moved.p), *ends], axis=0) + view.size  # a joint lies on what it connects
        items.append(Item(f"{kind}-{joint.name}", text, 1, depth, symbol(hinge, view)))
    return tuple(items), labels


def lines(items: Sequence[Item], count: int) -> Array:
    """Return the segments of all shapes, which labels keep clear of, shape (count, S, 2, 2)."""
    found = [shape.segments for item in items for shape in item.shapes if "halo" not in shape.look]
    return np.concatenate([np.broadcast_to(x, (count, *x.shape[1:])) for x in (np.zeros((1, 0, 2, 2)), *found)], axis=1)


def _acting(
    places: Places, scene: Scene, view: View, wrenches: Sequence[Wrench]
) -> tuple[tuple[Item, ...], tuple[Label, ...]]:
    """Return the arrows of the scene's loads and of other wrenches, and their labels."""
    items: tuple[Item, ...] = ()
    labels: tuple[Label, ...] = ()
    loads = [(f"load-{load.name}", load_wrench(load, places)) for load in scene.loads]
    for id, one in (*loads, *((f"wrench-{k + 1}", one) for k, one in enumerate(wrenches))):
        drawn, named = wrench(one, view, id)
        items, labels = items + drawn, labels + named
    return items, labels


def load_wrench(load: Load, places: Places) -> Wrench:
    """Return a load of the scene as it is now."""
    (at,), (force, couple) = places.ends[load], places.acting[load]
    return Wrench(load.name, at[0].tolist(), force[0].tolist(), couple[0].tolist())


def staged(
    scene: Scene, q: Sequence[float] | Array | None, parameters: Mapping[str, float] | None,
    view: tuple[float, float] | None = None,
) -> Stage:  # fmt: skip
    """Return a scene at one position, as `picture` takes it."""
    if q is None:
        shown, values = pose(scene, parameters=parameters)
    else:
        shown, values = _numbers(scene, q), values_of(scene, parameters)
    return Stage(scene, shown.reshape(1, -1), values, view)


def _numbers(scene: Scene, q: Sequence[float] | Array) -> Array:
    try:
        found = np.atleast_1d(np.asarray(q, dtype=np.float64))
    except (TypeError, ValueError, OverflowError):
        found = np.empty((0, 0))
    if found.shape != (len(scene.coordinates),):
        names = ", ".join(scene.coordinates)
        raise DrawError(f"{scene.name}: q = {quoted(q)} is no position; give a number for each of {names}")
    return found


def _triads(places: Places, view: View) -> tuple[Item, ...]:
    items = [
        Item(
            "frame-ground", Title("frame of the ground"), 2, np.zeros(1), triad(view, places.ground.p, places.ground.R)
        )
    ]
    for hinge in places.hinges:
        if not hinge.closes:
            shapes = triad(view, hinge.moved.p, hinge.moved.R)
            title = Title("moved frame of joint {name}", name=hinge.joint.name)
            items.append(Item(f"frame-{hinge.joint.name}", title, 2, view.depth(hinge.moved.p), shapes))
    return tuple(items)


def _names(places: Places, view: View, labels: Collection[str]) -> tuple[Label, ...]:
    names: list[Label] = []
    gap = view.size * 1.1
    if "points" in labels:
        for name, (_, frame) in places.points.items():
            names.append(Label(f"label-point-{name}", Text.of_part(name), view.flat(frame.p), gap))
    if "joints" in labels:
        for hinge in places.hinges:
            name = hinge.joint.name
            names.append(Label(f"label-joint-{name}", Text.of_part(name), view.flat(hinge.moved.p), gap * 1.3))
    if "bodies" in labels:
        names += body_names(places, view)
    return tuple(names)


def body_names(places: Places, view: View) -> list[Label]:
    """Return labels of all bodies, at their centres of mass or at their only particle, else at their joint."""
    names = []
    for body in places.bodies:
        at = body.com if body.com is not None else body.particles[0][1] if len(body.particles) == 1 else None
        place = carrier(places, body.name).moved.p if at is None else at
        names.append(Label(f"label-body-{body.name}", Text.of_part(body.name), view.flat(place), view.size * 1.1))
    return names


def with_descriptions(scene: Scene, labels: Sequence[Label]) -> list[Label]:
    """Return labels of bodies, joints, loads and contacts that have a description by that, in place of the name."""
    words = {f"label-body-{one.name}": one.text for one in scene.bodies}
    words |= {f"label-joint-{one.name}": one.text for one in scene.joints}
    words |= {f"label-joint-{one.name}": one.text for one in scene.loops}
    words |= {f"label-joint-{one.name}": one.text for one in scene.elements}
    words |= {f"load-{one.name}{turn}-label": one.text for one in scene.loads for turn in ("", "-couple")}
    return [replace(one, text=Text.as_written(words[one.id])) if words.get(one.id) else one for one in labels]


def known_body(scene: Scene, name: str) -> None:
    """Raise DrawError for a name that is no moving body."""
    bodies = [body.name for body in scene.bodies]
    if name not in bodies:
        reason = "does not move" if name == Scene.GROUND else "is not a body"
        raise DrawError(f'{scene.name}: "{name}" {reason}; {suggestion(name, bodies)}')


def swing(stage: Stage, title: str, ghosts: str, prefix: str, titles: Mapping[str, str]) -> str:
    """Return the picture of one end, with thin outlines of bodies in the middle and at the other end, as SVG.

    Args:
        stage: the scene at one end, in the middle and at the other end.
        title: of the picture.
        ghosts: what the outlines are called.
        prefix: in front of every id.
        titles: what parts are called, as of `picture`.
    """
    items, _ = mechanism(stage.scene, stage.places, stage.view)
    drawn = [replace(one, depth=one.depth[:1], shapes=tuple(_at(x, 0) for x in one.shapes)) for one in items]
    outlines = [shape for one in items for k in (1, 2) for shape in _ghost(one, k)]
    ghost = Item("ghosts", Title("{text}", text=ghosts), 0, np.full(1, -1e6), tuple(outlines))
    return svg(Drawing(title, (ghost, *drawn), ()), prefix, titles=titles)


def _at(shape: Shape, k: int) -> Shape:
    tilt = shape.tilt[k : k + 1] if len(shape.tilt) > 1 else shape.tilt
    return replace(shape, points=shape.points[min(k, len(shape.points) - 1)][None], tilt=tilt)


def _ghost(item: Item, k: int) -> list[Shape]:
    """Return the thin outline of a body: dashed at rest, full at the other end."""
    if not item.id.startswith("body-"):
        return []
    kept = [_at(shape, k) for shape in item.shapes if shape.kind in ("path", "disc") and shape.look != "halo"]
    look = "zero" if k == 1 else "trace"
    return [replace(shape, look=look, size=1.4 if shape.kind == "path" else shape.size) for shape in kept]
