"""Pictures of a scene and of one of its bodies as SVG text."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.arguments import walked
from symdyn.draw.body_shapes import COLOURS, carrier, link
from symdyn.draw.coordinate_marks import marks
from symdyn.draw.corner import with_corner
from symdyn.draw.force_arrows import Wrench, links, wrench
from symdyn.draw.ground import ground, planes
from symdyn.draw.joint_symbols import symbol, triad
from symdyn.draw.label_places import Label, put
from symdyn.draw.lettering import Text
from symdyn.draw.picture_files import File, check_picture, write_picture
from symdyn.draw.places import Array, Places
from symdyn.draw.positions import pose, values_of
from symdyn.draw.shapes import Item
from symdyn.draw.shown_text import SvgText
from symdyn.draw.stage import Stage
from symdyn.draw.svg import Drawing, svg
from symdyn.draw.titles import ENGLISH, Title
from symdyn.draw.view import View
from symdyn.emit.print import latex_symbols
from symdyn.errors import DrawError, quoted
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.scene.values import Load, suggestion

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
) -> SvgText:
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
        view: azimuth and elevation of the viewer in degrees; None chooses.
        frames: whether to draw the axes of every moved joint frame.
        labels: what is named: any of "coordinates", "bodies", "joints", "points". Loads and springs always are.
        wrenches: more forces and couples to draw.
        prefix: in front of every id, so that several pictures fit into one page.
        scheme: "auto" follows the reader's preference; "light" and "dark" use plain colours.
        file: where the picture is written to as well: .svg, .pdf or .png (those two by matplotlib; "auto" is light).
        titles: what parts are called in another language, from the English of `symdyn.draw.titles`.
        letters: more letters, of masses and lengths, each beside its point.

    Raises:
        DrawError: q of another shape, an unknown name, loops that do not close, no real value at q, or a file of
            another kind or that cannot be written.
    """
    wrenches, letters = walked(picture, locals(), "wrenches", "letters", error=DrawError)
    if file is not None:
        check_picture(file)
    shown = drawing(scene_of(scene), q, parameters, view, frames, labels, wrenches, letters)
    return delivered(shown, prefix, scheme, file, titles)


def delivered(shown: Drawing, prefix: str, scheme: str, file: File | None, titles: Mapping[str, str]) -> SvgText:
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
            raise DrawError(f'there are no labels of "{kind}"; known are {", ".join(LABELS)}')
    if q is None:
        shown, values = pose(scene, parameters=parameters)
    else:
        shown, values = _numbers(scene, q), values_of(scene, parameters)
    stage = Stage(scene, shown.reshape(1, -1), values, view)
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
    return with_corner(Drawing(scene.name, items, put(names, segments)), scene, found, seen, segments)


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
            text = Title(JOINT["led"], type=joint.type, name=joint.name, leader=joint.coupling.coordinate)
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


def _numbers(scene: Scene, q: Sequence[float] | Array) -> Array:
    try:
        return np.atleast_1d(np.asarray(q, dtype=np.float64))
    except (TypeError, ValueError, OverflowError) as fault:
        names = ", ".join(scene.coordinates)
        raise DrawError(f"{scene.name}: q = {quoted(q)} is no position; give a number for each of {names}") from fault


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


def known_body(scene: Scene, name: str) -> None:
    """Raise DrawError for a name that is no moving body."""
    bodies = [body.name for body in scene.bodies]
    if name not in bodies:
        reason = "does not move" if name == Scene.GROUND else "is not a body"
        raise DrawError(f'{scene.name}: "{name}" {reason}; {suggestion(name, bodies)}')
