"""What stands beside the mechanism: the direction of gravity, and in a spatial picture that of the ground's axes."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symdyn.draw.force_arrows import END_ON, end_on
from symdyn.draw.label_places import ROUGH, Label, Put, crosses
from symdyn.draw.lettering import FONT, Text
from symdyn.draw.places import Array, Places, unit
from symdyn.draw.shapes import Item, Shape, arrow
from symdyn.draw.svg import Drawing
from symdyn.draw.titles import Title
from symdyn.draw.view import View
from symdyn.emit.print import latex_symbols
from symdyn.graph import Op
from symdyn.scene import Scene

LONG, AXIS = 34.0, 26.0  # lengths of the arrows of gravity and of axes
NEAR = 100.0  # so that no line leads to the letters


def with_corner(drawing: Drawing, scene: Scene, places: Places, view: View, segments: Array) -> Drawing:
    """Return the drawing with arrows in a free corner, or beside it where no corner is free."""
    blocks = []
    if np.any(places.gravity):
        blocks.append(_gravity(scene, places, view))
    if not view.planar:
        blocks.append(_axes(view))
    for items, labels in blocks:
        shift = _free_place(drawing, items, labels, segments)
        moved = tuple(_moved(item, shift) for item in items)
        named = tuple(Put(replace(one.label, at=one.label.at + shift), one.offset) for one in labels)
        drawing = replace(drawing, items=drawing.items + moved, labels=drawing.labels + named)
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
    taken = np.concatenate([one.box for one in drawing.labels] or [np.zeros((0, 2, 2))])
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
