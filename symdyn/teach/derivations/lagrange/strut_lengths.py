"""The step that names the lengths of springs and dampers between two points, and their rates."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra import Form
from symdyn.teach.derivations.lagrange.velocities import folded
from symdyn.teach.document import Formula, Step
from symdyn.teach.lesson import Lesson, Prose


def length_steps(lesson: Lesson) -> list[Step]:
    """Return the step; none where no such length stands in the equations or in P."""
    page = lesson.page
    return defined_lengths(lesson, page.lengths.used((*page.forms, page.P)))


def defined_lengths(lesson: Prose, defined: Sequence[tuple[str, Form]]) -> list[Step]:
    """Return the step that says what names of the document stand for; none without."""
    if not defined:
        return []
    blocks = [folded(lesson, Formula(name, form)) for name, form in defined]
    return [Step("lengths", lesson.say("lengths"), tuple(blocks), lesson.say("lengths.reason"))]
