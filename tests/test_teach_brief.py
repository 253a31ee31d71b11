"""A brief lesson: what it keeps, what each format does with the rest, and letters that are said once."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from browser import opened
from lessons import lesson_of

from symdyn.scene import read, read_text
from symdyn.teach import rendered, walkthrough
from symdyn.teach.document import Document, Fold
from symdyn.teach.mathematics import Spelling
from symdyn.teach.practice.exercises import with_exercises
from symdyn.teach.render.handout import with_letters
from symdyn.teach.render.html import html_page

EXAMPLES = Path(__file__).parent.parent / "examples"
HELD = ("lagrangian", "equation", "explicit", "equilibria", "near", "limits", "power")


@pytest.fixture(scope="module")
def pendulum() -> Document:
    return walkthrough(read(EXAMPLES / "pendulum.toml"))


def text_of(document: Document, format: str) -> str:
    return str(next(iter(rendered(document, format).values())))


def test_paper_keeps_the_way_from_task_to_checks(pendulum: Document) -> None:
    steps = [step.key for section in pendulum.kept().sections for step in section.steps]
    order = [steps.index(next(key for key in steps if key.partition(":")[0] == kind)) for kind in ("task", *HELD)]
    assert order == sorted(order)
    assert not any(key.startswith(("velocity", "momentum", "kane", "phase", "meaning")) for key in steps)


def test_what_is_folded_in_text_says_all_that_a_full_lesson_says(pendulum: Document) -> None:
    full = lesson_of(pendulum.scene)
    brief, whole = (text_of(one, "md") for one in (pendulum, full))
    assert brief.count("<details>") > whole.count("<details>")
    assert {line for line in whole.splitlines() if line.startswith(("$$", "|", "\\"))} <= set(brief.splitlines())
    assert len(text_of(pendulum, "latex")) < len(text_of(full, "latex")) / 2


def test_a_result_alone_is_bold_and_framed(pendulum: Document) -> None:
    page, tex, text = html_page(pendulum), text_of(pendulum, "latex"), text_of(pendulum, "md")
    results = [step for section in pendulum.sections for step in section.steps if step.is_result]
    assert page.count('<div class="frame">') == tex.count(r"\begin{result}") == len(results) == 3
    assert len(re.findall(r"^\*\*", text, re.MULTILINE)) == len(results)
    for step in results:
        assert step.blocks[step.framed]


def test_a_question_in_text_is_never_folded(pendulum: Document) -> None:
    asked = with_exercises(pendulum)
    inside = [block for section in asked.sections for step, _ in asked.in_folds(section) for block in step.blocks]
    folds = [block for block in inside if isinstance(block, Fold)]
    assert folds
    assert not any(hasattr(one, "ask") for fold in folds for one in fold.blocks)


@pytest.mark.runs
def test_the_next_question_opens_its_fold_and_print_has_what_is_open(
    pendulum: Document, browser: Any, tmp_path: Path
) -> None:
    path = tmp_path / "lesson.html"
    path.write_text(html_page(with_exercises(pendulum)), encoding="utf-8")
    shut = "document.querySelectorAll('.more:not([open])').length"
    with opened(browser, path) as page:
        before = page.evaluate(shut)
        page.locator(".progress button").click()
        assert page.evaluate("document.activeElement.closest('.more').open")
        assert page.evaluate(shut) == before - 1
        page.locator('nav a[href="#part-positions"]').click()
        assert page.locator("#step-position-1").is_visible()
        numbered = page.evaluate(
            "[...document.querySelectorAll('.text h2')].filter(one => one.checkVisibility()).length"
        )
        assert numbered == page.locator("nav li").count()
        page.emulate_media(media="print")
        assert page.locator("#step-position-1").is_visible()
        assert not page.locator("#part-velocities h2").is_visible()
        assert page.locator("#part-lagrangian h2").is_visible()


ROD = """
[parameters]
L = { value = 0.5, positive = true, text = "length of the rod" }
Lp = 0.1
[bodies.rod]
particles = [{ mass = "1 + Lp", at = ["L", 0, 0] }]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 0, 1]
coordinate = "q"
"""


def test_a_letter_of_every_textbook_stays_and_the_scenes_gets_an_index() -> None:
    document = walkthrough(read_text(ROD, "rod"))
    symbols = Spelling(document).symbols
    assert (symbols["L:"], symbols["L"], symbols["Lp"]) == ("L", "L_{pp}", "L_p")
    assert text_of(document, "md").count("length of the rod; L in the scene") == 1


def test_equal_moments_of_inertia_of_a_body_are_one_letter() -> None:
    top = with_letters(read(EXAMPLES / "heavy_top.toml"))
    (body,) = top.bodies
    assert body.inertia[0] == body.inertia[2] != body.inertia[1]
    assert {one.name for one in top.parameters} == {"m1", "my1", "Ixx1", "Iyy1", "g"}
