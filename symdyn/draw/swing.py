"""A mechanism in the middle and at both ends of a swing, in one picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from symdyn.draw.pictures import mechanism
from symdyn.draw.shapes import Item, Shape
from symdyn.draw.stage import Stage
from symdyn.draw.svg import Drawing, svg
from symdyn.draw.titles import Title


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
    """Return a shape at one moment."""
    tilt = shape.tilt[k : k + 1] if len(shape.tilt) > 1 else shape.tilt
    return replace(shape, points=shape.points[min(k, len(shape.points) - 1)][None], tilt=tilt)


def _ghost(item: Item, k: int) -> list[Shape]:
    """Return the thin outline of a body: dashed at rest, full at the other end."""
    if not item.id.startswith("body-"):
        return []
    kept = [_at(shape, k) for shape in item.shapes if shape.kind in ("path", "disc") and shape.look != "halo"]
    look = "zero" if k == 1 else "trace"
    return [replace(shape, look=look, size=1.4 if shape.kind == "path" else shape.size) for shape in kept]
