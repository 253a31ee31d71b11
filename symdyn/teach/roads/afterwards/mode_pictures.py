"""Pictures of mode shapes: the mechanism at rest, and at both ends of a swing, far larger than a small one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symdyn.draw import Array, Drawing, Item, Shape, Title, extent_of, mechanism, places, svg, watched
from symdyn.teach.document import Picture
from symdyn.teach.lesson import Prose
from symdyn.teach.shown_state import Chosen

ANGLE, PART = 0.35, 0.15
"""The largest displacement: of an angle, rad, and of a length over the extent of the mechanism."""


def mode_picture(
    lesson: Prose, chosen: Chosen, rest: Array, shape: Array, units: Sequence[str], number: int
) -> Picture:
    """Return the picture of one shape about a place of rest; q and shape have shape (nq,)."""
    scene, values = lesson.scene, chosen.parameters
    length = extent_of(scene, rest, values)
    limits = np.array([ANGLE if unit == "rad" else PART * length for unit in units])
    away = shape / float((np.abs(shape) / limits).max())
    q = np.stack([rest + away, rest, rest - away])
    found = places(scene, q, values)
    view = watched(scene, found, values, q, None)
    items, _ = mechanism(scene, found, view)
    drawn = [replace(one, depth=one.depth[:1], shapes=tuple(_at(x, 0) for x in one.shapes)) for one in items]
    ghosts = [shape for one in items for k in (1, 2) for shape in _ghost(one, k)]
    ghost = Item("ghosts", Title("{text}", text=lesson.text("near.ghosts")), 0, np.full(1, -1e6), tuple(ghosts))
    title = lesson.text("near.shape.alt", number=str(number), scene=scene.name)
    prefix = f"mode{number}-"
    text = svg(Drawing(title, (ghost, *drawn), ()), prefix, titles=lesson.titles)
    return Picture(text, lesson.say("near.shape", number=str(number)), title, f"mode{number}")


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
