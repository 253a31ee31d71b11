"""Exercises of a mechanism as learning platforms ask them: one list of parts, by variants, which every writer walks.

A part is a question of the lesson with what is said before it, in the order of the derivation; asked is what all
variants have. Wrong answers that a rule gives, and its words, are those of `symdyn.teach.student.mistakes`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import Union

from symdyn.algebra import Form, Number
from symdyn.emit.print import latex_symbols, text_of
from symdyn.errors import DerivationError, TeachError, choice
from symdyn.frozen import dataclass
from symdyn.scene import Scene
from symdyn.teach.document import Blank, Block, Choice, Document, Questions
from symdyn.teach.languages import Language, language_of
from symdyn.teach.practice.exercises import ROUNDED, is_given, judge
from symdyn.teach.practice.questions import BALANCED, drive_alone, front
from symdyn.teach.student.answer import Answer, in_words
from symdyn.teach.student.derivation_check import check_derivation
from symdyn.teach.student.diagnosis import Diagnosis
from symdyn.teach.student.grammar import Names, Target
from symdyn.teach.student.mistakes import FREE, Mistake
from symdyn.teach.student.motions import PLACES, SAME, Point, beside
from symdyn.teach.student.statements import read_formula
from symdyn.unlocked import cached_property

MARKS: Mapping[str, int] = {"equation": 3, "solved": 3, "result": 3, "rate": 2, "lagrangian": 2}
"""Marks of a part by the kind of its step; of all others one."""

NEAR = SAME  # of the largest value: what counts as nothing
RULES = 40  # wrong answers of one part that a platform knows, the likely ones first


@dataclass(frozen=True)
class Wrong:
    """A wrong answer, what it is worth at the points of `Variant.marks`, and the rule that it forgets, in words."""

    form: Form
    marks: tuple[float, float]
    text: str


@dataclass(frozen=True)
class Part:
    """One question of one variant."""

    key: str  # of the question, the same in every variant
    asked: Union[Blank, Choice]  # the question
    before: tuple[Block, ...] = ()  # what is said before it
    answer: Form = Number.ZERO  # a right one to what is typed, in symbols of the scene
    front: Form = Number.ZERO  # what stands in front of the answer to an equation
    equation: int | None = None  # the number of the equation, from 0; None for a value
    wrong: tuple[Wrong, ...] = ()  # wrong answers that a platform knows
    is_free: bool = False  # whether a constant may be added to the answer, which moves

    @property
    def marks(self) -> int:
        """What a right answer is worth."""
        return MARKS.get(self.key.partition(":")[0], 1)

    @property
    def is_rounded(self) -> bool:
        """Whether a number answers it that is right to a part of itself."""
        return isinstance(self.asked, Blank) and self.asked.left.startswith(ROUNDED)


@dataclass(frozen=True)
class Variant:
    """One lesson with exercises as a platform asks them; `seed` as of `Handout`, None for the scene itself."""

    document: Document
    seed: int | None

    @property
    def scene(self) -> Scene:
        """The mechanism."""
        return self.document.scene

    @cached_property
    def task(self) -> tuple[Block, ...]:
        """What is known: the picture, the symbols, how the variant differs."""
        steps = (step for part in self.document.sections if is_given(part) for step in part.steps if not step.needs)
        return tuple(block for step in steps for block in step.spoken() if not isinstance(block, Questions))

    @cached_property
    def typed(self) -> dict[str, str]:
        """LaTeX of every symbol that an answer may have, by its name."""
        latex = latex_symbols(self.scene)
        return {name: latex[name] for name in dict.fromkeys(Names(self.scene).symbols.values()) if name in latex}

    @cached_property
    def diagnosis(self) -> Diagnosis:
        """What is known of mistakes and motions of the mechanism."""
        scene = self.scene.as_parameters()
        return Diagnosis(scene, beside(scene))

    @cached_property
    def groups(self) -> list[tuple[Sequence[Point], Sequence[Sequence[Point]]]]:
        """Points on the motions, as many elsewhere, and where each equation is broken; without motions drawn ones."""
        motions, drawn = self.diagnosis.motions, self.diagnosis.points.at
        return [(one.on[: 2 * PLACES], one.off) for one in motions.groups] if motions else [(drawn[: 2 * PLACES], ())]

    @cached_property
    def parts(self) -> dict[str, Part]:
        """The questions by key, in the order of the derivation."""
        return {part.key: part for part in self._parts()}

    def _parts(self) -> Iterator[Part]:
        for section in self.document.sections:
            for step in section.steps:
                before: list[Block] = [step.claim] if step.claim.parts else []
                for block in step.blocks:
                    if isinstance(block, Blank):
                        yield self._of(block, tuple(before))
                    elif isinstance(block, Choice):
                        yield Part(block.key, block, tuple(before))
                    else:
                        before.append(block)
                        continue
                    before = []

    def _of(self, blank: Blank, before: tuple[Block, ...]) -> Part:
        left, answer = blank.left, Form.of(self.document.value(blank.answer))
        if self.diagnosis.course is None or not left.startswith(BALANCED):
            free = left.startswith(FREE) and bool({*self.scene.coordinates, *self.scene.velocities} & {*answer.symbols})
            return Part(blank.key, blank, before, answer, wrong=self._wrong(left, answer, None, free), is_free=free)
        i, beside = int(left.partition(":")[2]) - 1, front(self.diagnosis, left)
        wrong = self._wrong(left, answer, i) if left.startswith("tau:") and not self.scene.is_constrained else ()
        return Part(blank.key, blank, before, answer, beside, i, wrong)

    def marks(self, part: Part) -> list[Point]:
        """Return the points that mark answers: two, or where a constant is free two and two, whose changes count."""
        points = self.diagnosis.points
        return [points.at[k] for k in points.marks(part.is_free)[: 4 if part.is_free else 2]]

    def _wrong(self, left: str, answer: Form, equation: int | None, free: bool = False) -> tuple[Wrong, ...]:
        """Return wrong answers with their rules; of an equation with the loads that stand in front of its box."""
        words, course = language_of(self.document.language), self.diagnosis.course
        known = self.diagnosis.of(left, answer, RULES)
        beside = course.right.Q[equation] if course is not None and equation is not None else None
        nodes = [one.node if beside is None else one.node + beside for one in known]
        rows = self.diagnosis.points.marked(nodes, free) if nodes else []
        return tuple(
            Wrong(Form.of(node), (float(f"{row[0]:.9g}"), float(f"{row[1]:.9g}")), _rule(words, one))
            for one, node, row in zip(known, nodes, rows, strict=True)
            if all(map(isfinite, row[:2]))
        )


def _rule(words: Language, one: Mistake) -> str:
    """Return what a rule says."""
    say = words.mistakes
    where = say["where"].format(of=one.of) if one.of else ""
    rule = say[one.rule] + where + (say["or"] + say[one.other] if one.other else "")
    return words.lesson["answer.mistake"].format(rule=rule)


@dataclass(frozen=True)
class Told:
    """What an answer is told: whether it could be read, whether it is right, and that in words."""

    read: bool
    right: bool
    text: str


def marked(document: Document, key: str, text: str) -> Told:
    """Return what `check_derivation` says to an answer of one question of a lesson with exercises.

    Args:
        document: one with exercises.
        key: of the question.
        text: the answer, plain or LaTeX; of a question with options the letters of what is chosen.

    Raises:
        TeachError: there is no such question.
    """
    asked = {block.key: block for _, block in document.blocks() if isinstance(block, Questions)}
    if key not in asked:
        raise TeachError(f"there is no exercise {key!r}; {choice(key, asked)}")
    block, scene = asked[key], document.scene.as_parameters()
    words = language_of(document.language).lesson
    if not text.strip():
        return Told(False, False, words["fault.empty"])
    others = beside(scene)
    targets = {goal.course_key: goal for goal in Names(scene, tuple(others)).targets.values()}
    requested = block.left if isinstance(block, Blank) else ""
    left = requested.replace("solved:", "tau:")
    diagnosis = Diagnosis(scene, others)
    known = requested.startswith(BALANCED) and diagnosis.course is not None
    if left in targets and (known or not requested.startswith(BALANCED)) and left:
        drive = ""
        try:
            answers, drive = boxed(text, targets[left], requested if known else "", diagnosis, key)
        except DerivationError:
            answers = []
        except TeachError as fault:
            return Told(False, False, str(fault))
        if drive:
            return Told(True, True, words["answer.drive"].format(text=drive))
        if told := [in_words(one, document.language)[0] for one in answers]:  # without the terms that it should have
            return Told(True, all(one.right for one in answers), "\n".join(told))
    if isinstance(block, Blank):
        try:
            read_formula(text, document.scene)
        except TeachError as fault:
            return Told(False, False, str(fault))
    said = judge(document, key, text)
    unread = words["answer.letters"].partition("{")[0]
    return Told(not said.startswith(unread), said in (words["answer.right"], words["answer.shifted"]), said)


def boxed(text: str, target: Target, requested: str, diagnosis: Diagnosis, name: str) -> tuple[list[Answer], str]:
    """Return answers to what is typed into a box, as `check_derivation` gives them.

    Without "=" it stands behind what is in front of the box, or behind the drive alone where that is right (then the
    drive is returned), or tells more than that loads are wrong.
    """
    scene, moves = diagnosis.scene, requested.startswith(BALANCED) and "=" not in text
    before = f"{text_of(front(diagnosis, requested))} = " if moves else ""
    answers = check_derivation(before + text, scene, name, target)
    if not moves or not (drive := drive_alone(diagnosis, requested)) or all(one.right for one in answers):
        return answers, ""
    alone = check_derivation(f"{drive} = {text}", scene, name, target)
    rule, other = (next((one.mistake.rule for one in some if one.mistake), "") for some in (answers, alone))
    if all(one.right for one in alone):
        return alone, drive
    twice = rule == "termfactor" != other  # a load that stands in front, too
    return (alone if other and (twice or rule in ("", "friction", "force")) else answers), ""
