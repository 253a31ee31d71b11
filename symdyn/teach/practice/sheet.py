"""A sheet to print: the task, numbered questions with room to write, and solutions where they are wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.teach.document import Blank, Block, Document, Room, Section, Step, Words
from symdyn.teach.languages import language_of
from symdyn.teach.practice.exercises import is_given

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
                if not isinstance(block, Blank):
                    before.append(block)
                    continue
                claim = Words((f"{len(steps) + 1}. ", *block.ask.parts))
                answer = block.solution if solutions else (Room(_lines(block.solution)),)
                steps.append(Step(f"question:{block.key}", claim, (*before, *answer)))
                before = []
    sections = (*known, Section("questions", texts["section.questions"], tuple(steps)))
    return replace(document, title=texts["sheet.title"].format(scene=document.scene.name), sections=sections)


def _lines(solution: Sequence[Block]) -> int:
    """Return how many lines a solution takes by hand: one for each of its formulas and what surrounds them."""
    return min(MOST, max(FEWEST, 2 + len(solution)))
