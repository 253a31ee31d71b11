"""Loops, contacts and rows that tie nothing: a door's second hinge forbids what the first one forbids already.

A mechanism of these alone moves as the open one, by Lagrange's method; one with others as well has multipliers of
the others.
"""

from __future__ import annotations

from symdyn.teach.document import Step
from symdyn.teach.lesson import Lesson


def silent_steps(lesson: Lesson) -> list[Step]:
    """Return the step that names what ties nothing, and why; none where everything ties something."""
    if not lesson.scene.is_closed:
        return []
    loops = lesson.workspace.loops
    owners = dict.fromkeys((one.owner, one.loop) for one in loops.recursive.labels)
    speaking = {(loops.recursive.labels[k].owner, loops.recursive.labels[k].loop) for k in loops.decisions.kept}
    silent = [owner for owner in owners if owner not in speaking]
    if not silent:
        return []
    claim = lesson.say("ties.silent", names=", ".join(name for name, _ in silent))
    return [Step("ties.silent", claim, (), lesson.say("ties.silent.reason"))]
