"""Textbook mode: equation numbers of example 5.28 and boxes where the text, as transcribed, is wrong.

`READS` quotes the text; what is right and every check comes from the graph.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Symbol
from symdyn.graph import Op, substitute
from symdyn.scene import parse
from symdyn.scene.forces import elastic
from symdyn.teach.document import ERRATA, Block, Box, Formula, Section, Step, Words
from symdyn.teach.lesson import Lesson, Prose
from symdyn.teach.shown_state import Chosen

LAGRANGIAN = (
    "(m1 + m2)*h1**2*q1_dot**2/2 + m2*h2**2*(q1_dot**2 + 2*q1_dot*q2_dot + q2_dot**2)/2"
    " + m2*h1*h2*cos(q2)*(q1_dot**2 + q1_dot*q2_dot) + (m1 + m2)*g*h1*cos(q1) + m2*g*h2*cos(q1 + q2)"
)
"""(5.35), by which the example is known."""

NUMBERS = {
    "motion:1": "5.36",
    "K:1": "5.24", "P:1": "5.25", "K.definition:2": "5.26", "v2.definition:2": "5.27", "x:2": "5.28", "y:2": "5.29",
    "dx:2": "5.30", "dy:2": "5.31", "v2:2": "5.32", "P.definition:2": "5.33", "P:2": "5.34", "L.definition": "5.23",
    "L": "5.35", "momentum:1": "5.37", "rate:1": "5.38", "slope:1": "5.39", "equation:1": "5.40", "momentum:2": "5.41",
    "rate:2": "5.42", "slope:2": "5.43", "equation:2": "5.44", "k_z:1,1": "5.45", "J:1": "5.46", "Mz:1,1": "5.47",
    "Mz:2,2": "5.48", "k_z:2,2": "5.49", "Mz:1,2": "5.50", "k_z:1,2": "5.51", "split:1,2": "5.52", "Mz:2,1": "5.53",
    "k_z:2,1": "5.54", "k_D:1,1": "5.55",
}  # fmt: skip


@dataclass(frozen=True)
class Erratum:
    """One place where the text is wrong.

    Attributes:
        step: key of the step that the box stands behind.
        number: of the equation.
        left: what the equation gives, key of `Document.names`; "" where only words are wrong.
        reads: the right-hand side as printed, with this product's sign; see `LETTERS`.
        words: key of the sentence that says what is wrong.
    """

    step: str
    number: str
    left: str
    reads: str
    words: str


READS = (
    Erratum("potential:2", "5.33", "P:2", "-m2*g*y2", "erratum.5.33"),
    Erratum(
        "momentum:1",
        "5.37",
        "dL:/dq1_dot",
        "(m1 + m2)*h1**2*q1_dot + m2*h2**2*q1_dot + m2*h2**2*q2_dot + 2*m2*h1*h2*cos(q2)*q2_dot"
        " + m2*h1*h2*cos(q2)*q2_dot",
        "erratum.5.37",
    ),
    Erratum("equation:1", "5.40", "k_z:1,2", "m2*h2**2 + m1*h1*h2*cos(q2)", "erratum.5.40z"),
    Erratum("equation:1", "5.40", "k_D:1,2", "-m2*h1*h2*cos(q2)", "erratum.5.40D"),
    Erratum(
        "momentum:2",
        "5.41",
        "dL:/dq2_dot",
        "m2*h2**2*q1_ddot + m2*h2**2*q2_dot**2 + m2*h1*h2*cos(q2)*q1_dot",
        "erratum.5.41",
    ),
    Erratum(
        "rate:2",
        "5.42",
        "d/dt dL:/dq2_dot",
        "m2*h2**2*q1_ddot + m2*h2**2*q2_dot**2 + m2*h1*h2*cos(q2)*q1_ddot - m2*h1*h2*sin(q2)*q1_dot*q2_dot",
        "erratum.5.42",
    ),
    Erratum("slope:2", "5.43", "dL:/dq2", "-m2*h1*h2*sin(q2)*q1_dot*q2_dot - m*g*h2*sin(q1 + q2)", "erratum.5.43"),
    Erratum("equation:2", "5.44", "k_C:2,1,2", "-2*m2*h1*h2*sin(q2)", "erratum.5.44C"),
    Erratum("equation:2", "5.44", "k_D:2,1", "-m2*h1*h2*sin(q2)", "erratum.5.44D"),
    Erratum("meaning:k_z:2,2", "5.48, 5.50, 5.53, 5.55", "", "", "erratum.axes"),
)

LETTERS = {"y2": "y:2"}
"""Letters of the text that are names of the lesson."""

READ_AS = {"m": "m2"}
"""A letter that the text does not define, and what it is read as in the check."""


def numbers_for(lesson: Lesson) -> Mapping[str, str]:
    """Return equation numbers by key, none for any other scene than example 5.28."""
    scene = lesson.scene
    wanted = {"m1", "m2", "h1", "h2", "g"}
    if scene.coordinates != ("q1", "q2") or {p.name for p in scene.parameters} != wanted or elastic(scene):
        return {}
    same = lesson.vanishes(lesson.L - parse(LAGRANGIAN).express(lesson.graph))
    return NUMBERS if same and all(joint.drive for joint in scene.moving) else {}


def errata(lesson: Lesson, section: Section, chosen: Chosen) -> Section:
    """Return a section with a step of boxes behind each step where the source is wrong; `with_appendix` moves them."""
    steps: list[Step] = []
    signs = Box("remark", lesson.say("textbook.signs.title"), (lesson.say("textbook.signs"),))
    for one in section.steps:
        step = replace(one, blocks=(*one.blocks, signs)) if one.key == "equation:1" else one
        boxes = tuple(_box(lesson, wrong, chosen) for wrong in READS if wrong.step == step.key)
        steps += [step, Step(f"{ERRATA}{step.key}", Words(()), boxes)] if boxes else [step]
    return replace(section, steps=tuple(steps))


def with_appendix(prose: Prose, sections: Sequence[Section]) -> list[Section]:
    """Return the sections with what the textbook has wrong in one at their end, and a mark at each step before it."""
    kept, appendix, count = [], list[Step](), 0
    for section in sections:
        steps: list[Step] = []
        for step in section.steps:
            if not step.key.startswith(ERRATA):
                steps.append(step)
                continue
            numbers, boxes = [], []
            for box in step.blocks:
                assert isinstance(box, Box), "an erratum stands in a box"
                numbers.append(str(count := count + 1))
                boxes.append(replace(box, title=Words((f"{count}. ", *box.title.parts))))
            mark = prose.text("erratum.mark", numbers=", ".join(numbers))
            steps[-1] = replace(steps[-1], reference=", ".join(filter(None, (steps[-1].reference, mark))))
            appendix.append(replace(step, blocks=tuple(boxes)))
        kept.append(replace(section, steps=tuple(steps)))
    return [*kept, prose.section("errata", appendix)] if appendix else kept


def _box(lesson: Lesson, one: Erratum, chosen: Chosen) -> Box:
    """Return what the text reads, what is right, and the check: both in numbers at the lesson's state."""
    title = lesson.say("erratum.several" if "," in one.number else "erratum", number=one.number.replace(", ", "), ("))
    blocks: list[Block] = [lesson.say(one.words)]
    if one.left:
        printed = quoted(one.reads)
        node = lesson.names[one.left].node
        assert node is not None, f"{one.left} has no value"
        typed = parse(one.reads).express(lesson.graph)
        meanings = {lesson.graph.symbol(a): lesson.names[b].node for a, b in LETTERS.items()}
        meanings |= {lesson.graph.symbol(a): lesson.graph.symbol(b) for a, b in READ_AS.items()}
        (read,) = substitute([typed], {x: y for x, y in meanings.items() if y is not None})
        assert not lesson.vanishes(read - node), f"({one.number}) is right as quoted; {one.left}"
        wrong, right = chosen.of(read, node)
        left, where = Symbol(one.left), {"section": lesson.text("section.numbers")}
        blocks += [
            lesson.say("erratum.reads", left=left, form=printed),
            lesson.say("erratum.right"),
            Formula(one.left, lesson.short(node)),
            lesson.say("erratum.check", left=left, wrong=lesson.about(wrong), right=lesson.equals(right), **where),
        ]
    return Box("erratum", title, tuple(blocks))


def quoted(text: str) -> Form:
    """Return a formula as a form, term by term as it is written; letters become the lesson's names."""
    return _quoted(ast.parse(text, mode="eval").body)


def _quoted(node: ast.expr) -> Form:
    if isinstance(node, ast.BinOp):
        left = _quoted(node.left)
        if isinstance(node.op, ast.Pow):
            assert isinstance(node.right, ast.Constant), "an exponent is a number"
            return left.power(int(str(node.right.value)))
        right = _quoted(node.right)
        if isinstance(node.op, ast.Mult):
            return Form.product((left, right))
        return Form.sum((left, right if isinstance(node.op, ast.Add) else Form.product((Number.MINUS_ONE, right))))
    if isinstance(node, ast.UnaryOp):
        return Form.product((Number.MINUS_ONE, _quoted(node.operand)))
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name), "a function has a name"
        return Function(Op[node.func.id.upper()], tuple(map(_quoted, node.args)))
    if isinstance(node, ast.Constant):
        return Number(Fraction(str(node.value)))
    assert isinstance(node, ast.Name), "quotations hold sums, products, powers, sines"
    return Symbol(LETTERS.get(node.id, node.id))
