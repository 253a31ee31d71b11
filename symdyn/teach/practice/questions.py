"""What a page is told to check answers by value: never a result itself, nor a formula that a mistake gives.

A sheet to print has the task, numbered questions with room to write, and solutions where they are wanted. In formats in
which nothing opens, solutions and what follows from them stand at the end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from math import isfinite
from typing import Any

from symdyn.algebra import Form, Number, Symbol
from symdyn.emit.print import Latex, latex_symbols, text_of
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene
from symdyn.scene.values import acceleration_name
from symdyn.teach.document import Blank, Block, Box, Choice, Document, Fold, Questions, Room, Section, Step, Words
from symdyn.teach.languages import fill, language_of
from symdyn.teach.lesson import called
from symdyn.teach.mathematics import inner
from symdyn.teach.practice.exercises import ENOUGH, ROUNDED, is_given, quantities
from symdyn.teach.student import mistakes, parts
from symdyn.teach.student.answer import settled
from symdyn.teach.student.diagnosis import BOUND, DRAWN, SCALED, SCALES, TWINS, Diagnosis, Points
from symdyn.teach.student.differences import KINDS
from symdyn.teach.student.evidence import PAIRED, Column
from symdyn.teach.student.grammar import PAGE, Names
from symdyn.teach.student.mistakes import FREE, MOST as MOST_WRONG
from symdyn.teach.student.motions import Point, beside, rows_of
from symdyn.teach.student.rows import in_ground
from symdyn.teach.student.statements import CALLED, SPEEDS

SMALL, BUDGET = 4, 1000
"""Velocities of a scene of which a page knows all mistakes; of a larger one so many in all its blanks."""


def questions(document: Document) -> dict[str, Any]:
    """Return what a page needs to check answers, as JSON takes it; empty for a document without blanks."""
    every = [block for _, block in document.blocks() if isinstance(block, Questions)]
    blanks = {block.key: block for block in every if isinstance(block, Blank)}
    if not every:
        return {}
    asked = {key: (blank.left, Form.of(document.value(blank.answer))) for key, blank in blanks.items()}
    choices = {block.key: block.right for block in every if isinstance(block, Choice)}
    return {**questions_of(document.scene, asked, document.language), "choices": choices}


def questions_of(scene: Scene, requested: Mapping[str, tuple[str, Form]], language: str) -> dict[str, Any]:
    """Return what a page needs to check answers to some questions, as JSON takes it.

    Args:
        scene: the mechanism.
        requested: by key of a question the key of its quantity, as documents have it, and its value.
        language: of the answers.

    Returns:
        names and how they are written; points, see `symdyn.teach.student.diagnosis`, with values of questions there;
        those that a constant may be added to (free), or that a number answers which is right to a part of itself
        (rounded); balances and alone: of equations what vanishes, and what stands in front of their answers; mistakes:
        rules with what they give at a few points; terms: see `Evidence`, with the numbers of their columns; motions:
        points on the motions, with what questions are worth there; grammar, words.
    """
    scene = scene.as_parameters()
    requested = {key: (left, settled(form, scene)) for key, (left, form) in requested.items()}
    multipliers = beside(scene)
    names, diagnosis = Names(scene, tuple(multipliers)), Diagnosis(scene, multipliers)
    points = diagnosis.points
    few = MOST_WRONG if len(scene.velocities) <= SMALL else max(20, BUDGET // max(1, len(requested)))
    balanced = not scene.is_constrained and diagnosis.course is not None
    columns: dict[tuple[Any, ...], int] = {}
    balances = {key: left for key, (left, _) in requested.items() if balanced and left.startswith(BALANCED)}
    values = {
        key: [_digits(row[0]) for row in points.values([form.express(Graph())])] for key, (_, form) in requested.items()
    }
    spoken = language_of(language)
    return {
        "symbols": dict(names.symbols),
        "dotted": names.derivatives,
        "formulas": {name: text_of(form) for name, form in names.formulas.items()},
        "ground": {name: text_of(form) for name, form in in_ground(scene).items()},
        "short": {key: [form.op.name.lower(), form.symbols] for key, form in names.shorthands.items()},  # type: ignore[attr-defined]
        "quantities": {word: str(target) for word, target in quantities(names).items()},
        "shown": {
            x: f"<mrow>{inner(y)}</mrow>" for x, y in latex_symbols(scene, (*multipliers, *names.formulas)).items()
        },
        "drawn": DRAWN,
        "twins": TWINS,
        "bound": BOUND,
        "scaled": SCALED,
        "scales": SCALES,
        "united": [
            key
            for key, row in values.items()
            if points.united([row[0], row[SCALED]]) and (key in balances or not requested[key][0].startswith(BALANCED))
        ],
        "unit": [
            key
            for key, (left, _) in requested.items()
            if left.startswith(BALANCED) and diagnosis.has_unit(int(left.partition(":")[2]) - 1)
        ],
        "free": [key for key, (left, _) in requested.items() if left.startswith(FREE)],
        "rounded": [key for key, (left, _) in requested.items() if left.startswith(ROUNDED)],
        "enough": ENOUGH,
        "called": {
            key: x for key, (left, _) in requested.items() for begin, x in CALLED.items() if left.startswith(begin)
        },
        "points": [dict(point) for point in points.at],
        "values": values,
        "named": {
            key: found
            for key, (left, form) in requested.items()
            if (found := sorted(diagnosis.letters(left, None if left.startswith(BALANCED) else form)))
        },
        "seen": {
            key: sorted(diagnosis.seen(x, None if x.startswith(BALANCED) else y)) for key, (x, y) in requested.items()
        },
        "balances": {key: _balance(diagnosis, points, left) for key, left in balances.items()},
        "mistakes": {
            key: _marked(diagnosis, points, left, form, key in balances, few) for key, (left, form) in requested.items()
        },
        "marks": {"plain": points.marks(), "free": points.marks(True)},
        "pairs": points.pairs,
        "motions": _motions(diagnosis, requested),
        "parameters": [p.name for p in scene.parameters],
        "alone": {key: drive for key, (left, _) in requested.items() if (drive := drive_alone(diagnosis, left))},
        "terms": {key: told for key, (left, _) in requested.items() if (told := _terms(diagnosis, left, columns))},
        "columns": list(columns),
        "apart": _apart(diagnosis),
        "grammar": PAGE,
        "speeds": SPEEDS.pattern,
        "words": {key: text for key, text in spoken.lesson.items() if key.startswith(("answer.", "fault."))}
        | {"mistakes": dict(spoken.mistakes), "decimal": spoken.decimal}
        | {"changes": {key: spoken.answers[key].partition(":")[0].capitalize() for key in KINDS}},
    }


BALANCED = ("tau:", "solved:")
"""What keys of equations begin with: with a drive, or solved for the acceleration of its joint."""


def _motions(diagnosis: Diagnosis, requested: Mapping[str, tuple[str, Form]]) -> dict[str, Any] | None:
    """Return what answers are judged by on the motions of the scene; None where none are drawn."""
    motions, scene = diagnosis.motions, diagnosis.scene
    if motions is None:
        return None
    names = list(motions.groups[0].on[0])
    asked: dict[str, Any] = {}
    for key, (left, form) in requested.items():
        if left.startswith(ROUNDED):  # a number that is right to a part of itself is no value on the motions
            continue
        if left.startswith(BALANCED):
            i = int(left.partition(":")[2]) - 1
            before = front(diagnosis, left)
            asked[key] = {"equation": i, "front": _on(motions.values(before, i))}
            asked[key]["before"] = text_of(before)
        else:
            asked[key] = {"values": _on(motions.values(form))}
        asked[key]["left"] = left
    groups = [
        {
            "declared": one.declared,
            "on": [[p[x] for x in names] for p in one.on],
            "off": [[[p[x] for x in names] for p in off] for off in one.off],
        }
        for one in motions.groups
    ]
    return {
        "names": names,
        "groups": groups,
        "asked": asked,
        "free": FREE,
        "multipliers": list(motions.rows),
        "drives": scene.drives,
        "keeps": bool(scene.constraints),
    }


def _on(values: Sequence[Mapping[str, Sequence[float]]]) -> list[dict[str, list[float]]]:
    """Return values on the motions without their last digits, which depend on the order of sums."""
    return [{kind: [_digits(x) for x in row] for kind, row in group.items()} for group in values]


def _terms(diagnosis: Diagnosis, left: str, known: dict[tuple[Any, ...], int]) -> list[dict[str, Any]]:
    """Return what tells the terms of a result apart: numbers of columns, which are added to those known, and handles.

    A column is kind, formula in MathML, values and what stands squared in it.
    """
    shown = Latex(latex_symbols(diagnosis.scene, tuple(diagnosis.others)))
    every = diagnosis.evidence(left.replace("solved:", "tau:"))

    def columns(of: Sequence[Column]) -> list[int]:
        texts = [inner(shown(x.form)) if x.form is not None else "" for x in of]
        rows = [(x.kind, text, tuple(_row(x.values)), x.squared, x.also) for x, text in zip(of, texts, strict=True)]
        return [known.setdefault(row, len(known)) for row in rows]

    return [
        {
            "rows": columns(one.columns),
            "beside": columns(one.beside),
            "alike": one.alike,
            "made": [x.of for x in one.columns],
            "right": _row(one.right),
            "handles": [[_steps(x.steps), _row(x.right), x.parameter] for x in one.handles],
            "common": list(map(_row, one.common)),
            "free": one.free,
            "tied": one.tied,
            "multipliers": one.how == "rows",
        }
        for one in every
    ]


def _steps(steps: Sequence[Point]) -> list[dict[str, float]]:
    """Return how symbols move, point by point; once where it is the same at all."""
    return [dict(one) for one in (steps[:1] if all(one == steps[0] for one in steps) else steps)]


def _row(values: Sequence[float]) -> list[float]:
    return [_digits(x) for x in values]


def _apart(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the points where terms are told apart, what their factors may be, and which rules they tell."""
    if diagnosis.motions is None:
        return None
    points = [{name: _digits(x) for name, x in point.items()} for point in diagnosis.motions.along]
    atoms = [[one.function, one.of, one.unit, [_digits(x) for x in one.values]] for one in diagnosis.atoms.every]
    return {
        "points": points,
        "atoms": atoms,
        "states": mistakes.STATES,
        "suits": mistakes.SUITS,
        "vague": [*mistakes.VAGUE, "coupling"],
        "plain": mistakes.PLAIN,
        "angles": ("relative", "absolute"),
        "paired": PAIRED,
        "whole": mistakes.ALL_OF_IT,
        "rates": mistakes.OF_RATES,
        "kept": mistakes.KEPT,
        "swapped": mistakes.SWAPPED,
        "ratios": sorted(" ".join(names) for names in diagnosis.atoms.ratios),
        "times": parts.WHOLE,
        "both": parts.BOTH,
        "round": parts.ROUND,
        "prices": (parts.SCALED, parts.UNTIED),
    }


def front(diagnosis: Diagnosis, left: str) -> Form:
    """Return what stands in front of the answer to an equation: drive, loads, multipliers; or the acceleration."""
    i = int(left.partition(":")[2]) - 1
    if left.startswith("solved"):
        return Symbol(acceleration_name(diagnosis.scene.velocities[i]))
    assert diagnosis.course is not None, "an equation of a lesson has a course"
    held = (Form.product((Symbol(name), G[i])) for name, (_, G) in rows_of(diagnosis.scene).items())
    return Form.sum((Form.of(diagnosis.drive(i) + diagnosis.course.right.Q[i]), *held))


def drive_alone(diagnosis: Diagnosis, left: str) -> str:
    """Return the drive of an equation that has more than it in front of its answer, "" for none."""
    drive = diagnosis.scene.drives[int(left[4:]) - 1] if left.startswith("tau:") and diagnosis.course else None
    return drive if drive and front(diagnosis, left) != Symbol(drive) else ""


def _digits(value: float, count: int = 12) -> float:
    return float(f"{value:.{count}g}")


def _balance(diagnosis: Diagnosis, points: Points, left: str) -> dict[str, Any]:
    course, i = diagnosis.course, int(left.partition(":")[2]) - 1
    assert course is not None, "an equation of a lesson has a course"
    tau = course.value(f"tau:{i + 1}", course.right)
    assert tau is not None, "every joint has a drive or none"
    zero = [_digits(row[0]) for row in points.values([tau - diagnosis.drive(i)])]
    alone = acceleration_name(diagnosis.scene.velocities[i]) if left.startswith("solved") else ""
    beside = not alone and not course.right.Q[i].is_zero  # the box has them in front of it, with the drive
    names, rest = diagnosis.law(i)
    told = {"zero": zero, "law": [names, _row(rest)], "alone": alone, "beside": beside}
    return told | {"drive": diagnosis.scene.drives[i] if not alone else None}


def _marked(diagnosis: Diagnosis, points: Points, left: str, form: Form, balanced: bool, few: int) -> list[list[Any]]:
    """Return the mistakes of a quantity, see `questions_of`; none of an equation that rows tie to others."""
    if left.startswith(BALANCED) and not balanced:
        return []
    key = f"tau:{left.partition(':')[2]}" if balanced else left
    known = diagnosis.of(key, form, few)
    if not known:
        return []
    rows: list[list[float]]
    if balanced:
        drive: Expr = diagnosis.drive(int(key.partition(":")[2]) - 1)
        nodes = [one.node - drive for one in known]
        rows = [list(row) for row in zip(*points.values(nodes, points.pairs), strict=True)]
    else:
        rows = points.marked([one.node for one in known], left.startswith(FREE))
    every = [
        (one, [_digits(x, 8) for x in row]) for one, row in zip(known, rows, strict=True) if all(map(isfinite, row))
    ]
    groups = groupby(every, lambda pair: (pair[0].rule, pair[0].of, pair[0].other))
    return [[*head, [row for _, row in of]] for head, of in groups]


FEWEST, MOST = 3, 18
"""Lines of room below a question."""


def sheet(document: Document, solutions: bool = False) -> Document:
    """Return a document with exercises as a sheet; what is no task and no question is left out.

    Args:
        document: one with exercises.
        solutions: in place of the room to write, each question's solution.
    """
    texts = language_of(document.language).lesson
    given = [section for section in document.sections if is_given(section)]
    known = [replace(part, steps=tuple(x for x in part.steps if not x.needs)) for part in given]
    steps: list[Step] = []
    for section in document.sections:
        for step in section.steps:
            before: list[Block] = [step.claim] if step.claim.parts else []
            for block in step.blocks:
                if not isinstance(block, Questions):
                    before.append(block)
                    continue
                claim = Words((f"{len(steps) + 1}. ", *block.ask.parts))
                if isinstance(block, Choice):
                    before += block.listed
                answer = block.solution if solutions else (Room(_lines(block.solution)),)
                steps.append(Step(f"question:{block.key}", claim, (*before, *answer)))
                before = []
    sections = (*known, Section("questions", texts["section.questions"], tuple(steps)))
    title = texts["sheet.title"].format(scene=called(document.scene))
    return replace(document, title=title, sections=sections, brief=False)


def _lines(solution: Sequence[Block]) -> int:
    """Return how many lines a solution takes by hand: one for each of its formulas and what surrounds them."""
    return min(MOST, max(FEWEST, 2 + len(solution)))


def solutions_last(document: Document) -> Document:
    """Return the document with solutions and steps that need them in a section at its end; one without as it is."""
    if not any(isinstance(block, Questions) for _, block in document.blocks()):
        return document
    texts = language_of(document.language).lesson
    solved: list[Step] = []
    sections = []
    for section in document.sections:
        shown = []
        for step in section.steps:
            if step.needs:
                reason = [step.reason] if step.reason.parts else []
                solved.append(_folded(document, f"follows:{step.key}", step.claim, [*step.blocks, *reason]))
                continue
            shown.append(step)
            for block in step.blocks:
                if isinstance(block, Questions):
                    claim = block.ask
                    if isinstance(block, Blank):
                        told = "exercise.solved.zero" if block.shown == Number.ZERO else "exercise.solved"
                        claim = Words(fill(texts[told], {"left": block.shown}))
                    solved.append(_folded(document, f"solution:{block.key}", claim, block.solution))
        if any(step.needs for step in section.steps):
            shown.append(Step(f"later:{section.key}", Words(()), (Words((texts["exercise.last"],)),)))
        sections.append(replace(section, steps=tuple(shown)))
    sections.append(Section("solutions", texts["section.solutions"], tuple(solved)))
    return replace(document, sections=tuple(sections))


def _folded(document: Document, key: str, claim: Words, blocks: Sequence[Block]) -> Step:
    summary = Words((language_of(document.language).lesson["exercise.solution"],))
    if blocks and isinstance(blocks[0], Box):
        summary = blocks[0].title
    return Step(key, claim, (Fold(summary, tuple(blocks)),) if blocks else ())
