"""What follows from equations once they stand, section by section: rests, what is conserved, steady motions, limits."""

from __future__ import annotations

from symdyn.emit.print.printable import Printable
from symdyn.teach.document import Section
from symdyn.teach.lesson import Lesson
from symdyn.teach.roads.afterwards.equilibria import equilibrium_step, places_of_rest
from symdyn.teach.roads.afterwards.near_rest import near_rest_steps
from symdyn.teach.shown_state import Chosen

MOST = 6
"""Degrees of freedom up to which it is all said; of more, only where the mechanism rests."""


def after_sections(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Section]:
    """Return the sections after the equations of an open mechanism; their keys begin with "after"."""
    rests = places_of_rest(lesson, chosen)
    steps = [equilibrium_step(lesson, rests), *near_rest_steps(lesson, rests, chosen)]
    found = [("after.rests", steps)]
    return [lesson.section(key, steps) for key, steps in found if steps]
