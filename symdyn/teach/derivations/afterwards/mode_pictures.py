"""Pictures of mode shapes: the mechanism at rest, and at both ends of a swing, far larger than a small one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import Stage, swing
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
    length = Stage(scene, rest[None], values).found.reach
    limits = np.array([ANGLE if unit == "rad" else PART * length for unit in units])
    away = shape / float((np.abs(shape) / limits).max())
    title = lesson.text("near.shape.alt", number=str(number), scene=scene.name)
    stage = Stage(scene, np.stack([rest + away, rest, rest - away]), values)
    text = swing(stage, title, lesson.text("near.ghosts"), f"mode{number}-", lesson.titles)
    return Picture(text, lesson.say("near.shape", number=str(number)), title, f"mode{number}")
