"""A document with exercises for formats in which nothing opens: solutions and what follows from them at the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.algebra import Number
from symdyn.teach.document import Blank, Block, Box, Document, Fold, Section, Step, Words
from symdyn.teach.languages import fill, language_of


def solutions_last(document: Document) -> Document:
    """Return the document with solutions and steps that need them in a section at its end; one without as it is."""
    if not any(isinstance(block, Blank) for _, block in document.blocks()):
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
