"""Steps: products and squares of rates, and why each of their coefficients k_C, k_D is there or not."""

from __future__ import annotations

from symdyn.algebra.form import ZERO, Form, Symbol, power_of, product_of
from symdyn.emit.equations import Printable
from symdyn.emit.formula_text import text_of
from symdyn.scene import JOINTS
from symdyn.teach.document import Block, Formula, Step, Values, Words
from symdyn.teach.equations import WIDEST, coefficient_key, node_of
from symdyn.teach.lesson import Lesson
from symdyn.teach.velocities import length

SHORT = 4
"""Terms of a coefficient that stands in a table."""


def rates_step(lesson: Lesson, page: Printable, kind: str) -> Step:
    """Return a table: each coefficient of a product of velocities, and why it is there or not."""
    rows, slides = [], [unit == "m" for j in lesson.scene.moving for unit in JOINTS[j.type].velocities(j)]
    for c in page.coefficients:
        if c.kind == kind:
            short = length(c.form) <= SHORT and len(text_of(c.form)) <= WIDEST
            value = Words((c.form,)) if short else lesson.say("long.short", terms=str(length(c.form)))
            why = lesson.say(_why(lesson, c.indices, slides, c.vanishes, kind), **_places(lesson, c.indices))
            rows.append((Words((Symbol(coefficient_key(c)),)), value, why))
    head = (lesson.say("table.coefficient"), lesson.say("table.value"), lesson.say("table.why"))
    blocks: list[Block] = [Values(head, tuple(rows))]
    if kind == "k_D" and (number := lesson.number("k_D:1,1")):
        torque = f"{kind} torque"
        node = node_of(lesson, "k_D:1,1") * lesson.state.qd[0] * lesson.state.qd[0]
        lesson.name(torque, "M", "D", "11", node=node)
        product = product_of((Symbol("k_D:1,1"), power_of(Symbol(str(lesson.state.qd[0].value)), 2)))
        blocks.append(Formula(torque, product, number, ZERO))
    number = lesson.number("k_D:1,1") if kind == "k_D" else ""
    reference = f"({number})" if number else ""
    claim, reason = lesson.say(f"meaning.{kind}"), lesson.say(f"meaning.{kind}.reason")
    return Step(f"meaning:{kind}", claim, tuple(blocks), reason, reference)


def _places(lesson: Lesson, indices: tuple[int, ...]) -> dict[str, str | Form | Words]:
    i, j, *rest = indices
    k = rest[0] if rest else j
    qd = [Symbol(str(u.value)) for u in lesson.state.qd]
    return {"i": str(i), "j": qd[j - 1], "k": qd[k - 1], "axis": str(j)}


def _why(lesson: Lesson, indices: tuple[int, ...], slides: list[bool], vanishes: bool, kind: str) -> str:
    """Return the key of the sentence that says why a coefficient is there or not."""
    i, j, *rest = (x - 1 for x in indices)
    closed, along = lesson.closed, ".slide" if slides[i] else ""
    if kind == "k_D":
        if not vanishes:
            return f"k_D.acts{along}"
        if slides[j]:
            return "k_D.straight"
        if i == j:
            return "k_D.own"
        depends = closed.ring.derivative(closed.M[j][j], closed.state.q[i])
        depends_too = closed.ring.derivative(closed.M[i][j], closed.state.q[j])
        return f"k_D.cancel{along}" if depends or depends_too else f"k_D.meets{along}"
    if not vanishes:
        return f"k_C.acts{along}"
    k = rest[0]
    if slides[j]:
        return "k_C.straight"
    parts = ((i, j, k), (i, k, j), (j, k, i))
    slopes = [closed.ring.derivative(closed.M[a][b], closed.state.q[c]) for a, b, c in parts]
    return f"k_C.cancel{along}" if any(slopes) else "k_C.nothing"
