"""The step that names the lengths of springs and dampers between two points, and their rates."""

from __future__ import annotations

from symdyn.teach.document import Formula, Step
from symdyn.teach.lesson import Lesson
from symdyn.teach.roads.lagrange.velocities import folded


def length_steps(lesson: Lesson) -> list[Step]:
    """Return the step; none where no such length stands in the equations or in P."""
    page = lesson.page
    blocks = [folded(lesson, Formula(name, form)) for name, form in page.lengths.used((*page.forms, page.P))]
    if not blocks:
        return []
    return [Step("lengths", lesson.say("lengths"), tuple(blocks), lesson.say("lengths.reason"))]
