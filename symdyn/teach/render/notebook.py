"""A document as a Jupyter notebook, one file: prose, pictures, and cells that read the scene and check its formulas."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator
from typing import Any

from symdyn.emit import in_code, in_markdown
from symdyn.emit.code import page_stem
from symdyn.emit.print import text_of
from symdyn.scene import write_text
from symdyn.teach.document import Blank, Block, Document, Formula, Picture, Step
from symdyn.teach.languages import language_of
from symdyn.teach.practice.exercises import answer_of
from symdyn.teach.practice.solutions import solutions_last
from symdyn.teach.render.derivation_cells import Cells, derivable
from symdyn.teach.render.markdown import Page

Cell = dict[str, Any]

SETUP = '''from symdyn.scene import read_text
from symdyn.teach import check_derivation, in_words

scene = read_text({scene})


def check(text):
    """Compare formulas, plain text or LaTeX, with those of the scene."""
    for answer in check_derivation(text, scene):
        print("\\n".join(in_words(answer, {language!r})))'''

DERIVED = """from symdyn.teach.practice.derived import Derived

derived = Derived(scene, {language!r})
"""

EXERCISES = """

from symdyn.teach import walkthrough
from symdyn.teach.practice.exercises import judge, with_exercises

lesson = with_exercises(walkthrough(scene, {language!r}, formulation={formulation!r}))"""


def notebook(document: Document) -> dict[str, str]:
    """Return the one file by name."""
    cells = list(_cells(document))
    names = [re.sub(r"[^A-Za-z0-9_-]+", "-", cell["id"])[:60] for cell in cells]
    for k, (cell, name) in enumerate(zip(cells, names, strict=True)):
        cell["id"] = name if names.count(name) == 1 else f"{name[:55]}-{k}"
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    book = {
        "cells": cells,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}, "title": document.title},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return {f"{page_stem(document.scene.name)}.ipynb": json.dumps(book, ensure_ascii=False, indent=1) + "\n"}


def _cells(document: Document) -> Iterator[Cell]:
    document = solutions_last(document)
    page = _Page(document)
    yield _text("title", f"# {in_markdown(document.title)}")
    asked = any(isinstance(block, Blank) for _, block in document.blocks())
    setup = (SETUP + EXERCISES if asked else SETUP).format(
        scene=in_code(write_text(document.scene.in_si(), "toml").text),
        language=document.language,
        formulation=document.formulation,
    )
    yield _code("setup", setup)
    keys = {section.key for section in document.sections}
    derived = {} if asked or "questions" in keys else _derivation(document)
    inside = "positions" in keys
    for section in document.sections:
        yield _text(f"section-{section.key}", f"## {in_markdown(section.title)}")
        for step in section.steps:
            yield from _step(page, step)
        yield from derived.get(section.key, []) if inside else []
    if derived and not inside:
        yield _text("section-derive", f"## {in_markdown(language_of(document.language).lesson['section.derive'])}")
        yield from (cell for cells in derived.values() for cell in cells)


def _derivation(document: Document) -> dict[str, list[Cell]]:
    """Return the cells that derive the equations in SymPy, by the section that they follow; none of a large scene."""
    if not derivable(document.scene):
        return {}
    texts, cells = language_of(document.language).lesson, Cells(document.scene)
    bodies = ", ".join(f"{k} {body.name}" for k, body in enumerate(document.scene.bodies, 1))
    places = in_markdown(texts["derive.places"].format(bodies=bodies))
    found = {
        "positions": [
            _text("derive-letters", in_markdown(texts["derive.letters"])),
            _code("derive-symbols", f"{DERIVED.format(language=document.language)}\n{cells.symbols()}"),
            _text("derive-where", places),
            _code("derive-places", cells.places()),
        ],
        "energies": [
            _text("derive-energy", in_markdown(texts["derive.energies"])),
            _code("derive-energies", cells.energies()),
        ],
        "lagrangian": [_code("derive-lagrangian", cells.lagrangian())],
        "equations": [
            _text("derive-equation", in_markdown(texts["derive.equations"])),
            *(_code(f"derive-equation-{i + 1}", cells.equation(i)) for i in range(len(document.scene.velocities))),
        ],
    }
    return found | {"coefficients": [_code("derive-coefficients", cells.coefficients())]}


def _step(page: _Page, step: Step) -> Iterator[Cell]:
    """Yield the cells of a step: its text, then what can be run."""
    reference = f" {in_markdown(step.reference)}" if step.reference else ""
    reason = [page.words(step.reason)] if step.reason.parts else []
    parts = [f"**{page.words(step.claim)}**{reference}", *page.blocks(step.blocks), *reason]
    pictures = {f"{block.key}.svg": block.svg for block in step.blocks if isinstance(block, Picture)}
    yield _text(f"step-{step.key}", "\n\n".join(parts), pictures)
    if step.key.startswith("coefficients"):
        results = [block for block in step.blocks if isinstance(block, Formula)]
        found = [answer for block in results if (answer := answer_of(page.document, block)) is not None]
        if found:
            lines = [f"{page.spell.symbols[left]} = {text_of(form)}" for left, form in found]
            yield _code(f"check-{step.key}", f"check({in_code(chr(10).join(lines))})")
    for block in step.blocks:
        if isinstance(block, Blank):
            hint = language_of(page.document.language).lesson["exercise.example"]
            yield _code(f"answer-{block.key}", f'answer = ""  # {hint}\njudge(lesson, {in_code(block.key)}, answer)')


class _Page(Page):
    """Markdown whose pictures are attached to their cells."""

    def block(self, block: Block) -> Iterator[str]:
        if isinstance(block, Picture):
            yield f"![{in_markdown(block.alt)}](attachment:{block.key}.svg)"
            yield f"*{self.words(block.caption)}*"
        else:
            yield from super().block(block)


def _text(key: str, text: str, pictures: dict[str, str] | None = None) -> Cell:
    cell: Cell = {"cell_type": "markdown", "id": key, "metadata": {}, "source": text}
    if pictures:
        cell["attachments"] = {
            name: {"image/svg+xml": base64.b64encode(svg.encode()).decode()} for name, svg in pictures.items()
        }
    return cell


def _code(key: str, text: str) -> Cell:
    return {"cell_type": "code", "execution_count": None, "id": key, "metadata": {}, "outputs": [], "source": text}
