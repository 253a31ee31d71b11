"""Steps: the names of the lengths of springs and dampers between two points."""

from __future__ import annotations

from collections.abc import Container, Sequence

from symdyn.algebra import Form, Function, Power, Symbol
from symdyn.graph import Op
from symdyn.teach.derivations.velocities import folded
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
    positive = {one.name for one in lesson.scene.parameters if one.positive}
    blocks = [folded(lesson, Formula(name, _root(form, positive))) for name, form in defined]
    return [Step("lengths", lesson.say("lengths"), tuple(blocks), lesson.say("lengths.reason"))]


def _root(form: Form, positive: Container[str]) -> Form:
    """Return a root of a product of squares as that of what is positive times amounts: √(l² sin² q) is l |sin q|."""
    if not isinstance(form, Function) or form.op is not Op.SQRT:
        return form
    factors = form.args[0].factors
    if not all(isinstance(x, Power) and x.exponent == 2 for x in factors):
        return form
    bases = [x.base for x in factors if isinstance(x, Power)]
    plain = [x for x in bases if isinstance(x, Symbol) and x.name in positive]
    return Form.product((*plain, *(Function(Op.ABS, (x,)) for x in bases if x not in plain)))
