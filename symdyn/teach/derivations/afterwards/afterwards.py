"""What follows from equations once they stand, section by section: rests, what is conserved, steady motions, limits."""

from __future__ import annotations

from symdyn.emit.print import Printable
from symdyn.teach.derivations.afterwards.comparison import comparison_step
from symdyn.teach.derivations.afterwards.equilibria import equilibrium_step, places_of_rest
from symdyn.teach.derivations.afterwards.limits import limit_steps
from symdyn.teach.derivations.afterwards.momenta import momentum_steps
from symdyn.teach.derivations.afterwards.near_rest import near_rest_steps
from symdyn.teach.derivations.afterwards.phase import landscape_step, phase_step
from symdyn.teach.derivations.afterwards.reduced import reduced
from symdyn.teach.derivations.afterwards.steady import steady_step
from symdyn.teach.document import Section, Step
from symdyn.teach.lesson import Lesson
from symdyn.teach.shown_state import Chosen

MOST = 3
"""Degrees of freedom up to which it is all said; of more, where the mechanism rests and what is conserved."""


def after_sections(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Section]:
    """Return the sections after the equations of an open mechanism; their keys begin with "after"."""
    rests, small = places_of_rest(lesson, chosen), lesson.state.n <= MOST
    left = reduced(lesson, chosen) if small else None
    steady = None if left is None else steady_step(lesson, left)
    seen = phase_step(lesson, left) if left is not None else landscape_step(lesson, rests, chosen) if small else None
    found: dict[str, list[Step | None]] = {
        "after.rests": [equilibrium_step(lesson, rests), *near_rest_steps(lesson, rests, chosen)],
        "after.conserved": list(momentum_steps(lesson, page, chosen)),
        "after.steady": [steady],
        "after.landscape": [seen],
        "after.terms": [comparison_step(lesson, page, chosen) if small else None],
        "after.limits": list(limit_steps(lesson, left, chosen)) if small else [],
    }
    kept = {key: [step for step in steps if step is not None] for key, steps in found.items()}
    return [lesson.section(key, steps) for key, steps in kept.items() if steps]
