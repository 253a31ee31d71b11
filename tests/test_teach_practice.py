"""Exercises: three grades, any step of a derivation by its name, and nothing that follows before it is found."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from browser import opened
from lessons import blanks, lesson_of

from symdyn.algebra.form import Symbol
from symdyn.cli import main
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import TeachError
from symdyn.scene import read
from symdyn.teach import rendered
from symdyn.teach.document import ERRATA, Blank, Choice, Document, Questions, Step
from symdyn.teach.languages import language_of, languages
from symdyn.teach.practice.exercises import APART, GRADES, OF_ONE, with_exercises, written_out
from symdyn.teach.practice.questions import questions, sheet, solutions_last
from symdyn.teach.render.html import html_page

EXAMPLES = Path(__file__).parent.parent / "examples"
FINDINGS = Path(__file__).parent / "data" / "findings"


@cache
def lesson(name: str, language: str = "en", formulation: str = "lagrange") -> Document:
    return lesson_of(read(EXAMPLES / f"{name}.toml"), language, formulation=formulation)


def questions_in(document: Document) -> list[Blank | Choice]:
    return [block for _, block in document.blocks() if isinstance(block, Questions)]


def kinds(document: Document) -> set[str]:
    return {blank.key.partition(":")[0] for blank in blanks(document)}


@pytest.mark.long
def test_a_sheet_counts_its_questions_from_one() -> None:
    asked = with_exercises(lesson("two_link"), 2)
    steps = sheet(asked).sections[-1].steps

    assert [step.claim.parts[0] for step in steps] == [f"{k}. " for k in range(1, len(questions_in(asked)) + 1)]


@pytest.mark.long
def test_grades_ask_for_every_step_for_results_and_for_energies_and_equations_alone() -> None:
    every, results, alone = (with_exercises(lesson("two_link"), grade) for grade in GRADES)

    assert kinds(results) == {"square", "potential", "momentum", "rate", "slope", "equation", "coefficients"}
    assert kinds(every) == kinds(results) | {"position", "velocity", "kinetic", "energies", "lagrangian", "explicit"}
    asked = ["energies:K:", "energies:P:", "lagrangian", "equation:1", "equation:2"]
    assert [blank.key for blank in blanks(alone)] == asked
    shown = {section.key for section in alone.sections if any(not step.needs for step in section.steps)}
    assert shown == {"scene", "principle", "energies", "lagrangian", "equations", "physics"}


@pytest.mark.slow
@pytest.mark.long
def test_who_derives_alone_is_told_where_everything_is() -> None:
    for language in languages():
        text = rendered(with_exercises(lesson("spatial_3r", language), 3), "md")["spatial_3r.md"]
        assert r"| joint2 | ($0$, $0$, $h$) | ($0$, $-1$, $0$) |" in text
        assert r"| ($l_2 + \tfrac{1}{2} l_3$, $0$, $h$) |" in text
        assert r"| ($0$, $\tfrac{1}{12} m_3 l_3^2$, $\tfrac{1}{12} m_3 l_3^2$, $0$, $0$, $0$) |" in text


@pytest.mark.wide("dalembert")
@pytest.mark.long
@pytest.mark.parametrize("formulation", ["lagrange", "dalembert"])
def test_every_step_can_be_asked_for_by_its_name(formulation: str) -> None:
    known = lesson("two_link", formulation=formulation)
    steps = {step.key for step, block in with_exercises(known, 1).blocks() if isinstance(block, Blank)}
    assert len(steps) >= 3
    for key in steps:
        asked = blanks(with_exercises(known, ask=[key]))
        assert asked
        assert all(blank.key.startswith(key) for blank in asked)


@pytest.mark.parametrize("name", ["slider_crank", "pendulum"])
def test_a_page_asks_for_formulas_with_roots_and_for_a_drive_by_its_name(name: str) -> None:
    asked = with_exercises(lesson(name, formulation="dalembert"))

    assert "bivectors" in kinds(asked)
    assert questions(asked)["values"].keys() == {blank.key for blank in blanks(asked)}


def test_what_cannot_be_asked_for_is_said_with_what_can() -> None:
    with pytest.raises(TeachError, match=r"two_link: squares cannot be asked for here; give some of position, .*equat"):
        with_exercises(lesson("two_link"), ask=["squares", "momentum"])
    with pytest.raises(TeachError, match="there is no grade 4; give one of 1, 2, 3"):
        with_exercises(lesson("two_link"), 4)


def tells(document: Document, step: Step) -> bool:
    """Whether a step shows more than names: a product, a sum or a function of the scene's symbols."""
    own = {k for k, x in document.names.items() if x.node is None}
    own |= {*document.scene.coordinates, *document.scene.velocities, *(p.name for p in document.scene.parameters)}
    own |= {f"{q}_ddot" for q in document.scene.coordinates}
    forms = [form for part in (step.claim, *step.blocks, step.reason) for form in written_out(part)]
    written = (form for form in forms if not isinstance(form.split_sign()[1], Symbol))
    return any(form.symbols and set(form.symbols) <= own for form in written)


def apart(key: str, asked: str) -> bool:
    """Whether a step is about another mass than what is asked, or says what the one asked does not know."""
    (kind, _, of), (source, _, other) = key.removeprefix(ERRATA).partition(":"), asked.partition(":")
    return (kind in OF_ONE and source in OF_ONE and of != other.split(":")[0]) or source in APART.get(kind, ())


def told(document: Document) -> Iterator[str]:
    """Yield the steps that are seen at once and tell something after what is asked."""
    asked: list[str] = []
    for section in document.sections:
        for step in section.steps:
            if not step.needs and any(not apart(step.key, key) for key in asked) and tells(document, step):
                yield step.key
            asked += [block.key for block in step.blocks if isinstance(block, Blank)]


@pytest.mark.long
@pytest.mark.mends("5.8")
@pytest.mark.parametrize("grade", GRADES)
@pytest.mark.parametrize(
    ("name", "formulation"),
    [("two_link", "lagrange"), ("cart_pole", "lagrange"), ("two_link", "dalembert"), ("four_bar", "dalembert")],
)
def test_nothing_that_follows_is_seen_before_it_is_found(name: str, formulation: str, grade: int) -> None:
    assert list(told(with_exercises(lesson(name, formulation=formulation), grade))) == []


@pytest.mark.long(0)
@pytest.mark.parametrize("language", languages())
def test_texts_tell_answers_and_what_follows_after_the_last_question_only(language: str) -> None:
    document = with_exercises(lesson("two_link", language))
    last = language_of(language).lesson["section.solutions"]

    for format, heading in (("md", f"## {last}"), ("latex", f"lessonpart{{{last}}}"), ("notebook", f"## {last}")):
        text = str(next(iter(rendered(document, format).values())))
        before, found, after = text.partition(heading)
        assert found, format
        assert format != "notebook" or not any(text_of(blank.answer) in before for blank in blanks(document))
        assert before.count("m_{2}") + before.count("m_2") < after.count("m_{2}") + after.count("m_2")


def test_solutions_at_the_end_hold_every_answer_and_every_hidden_step() -> None:
    document = with_exercises(lesson("two_link"))
    last = solutions_last(document)

    keys = [step.key for step in last.sections[-1].steps]
    assert last.sections[-1].key == "solutions"
    assert {f"solution:{blank.key}" for blank in blanks(document)} <= set(keys)
    hidden = [step.key for section in document.sections for step in section.steps if step.needs]
    assert {f"follows:{key}" for key in hidden} <= set(keys)
    assert "follows:errata:potential:2" in keys
    assert not any(step.needs for section in last.sections for step in section.steps)


@pytest.mark.long
def test_a_page_shows_what_follows_when_all_that_it_needs_is_found_or_given_up(browser: Any, tmp_path: Path) -> None:
    document = with_exercises(lesson("two_link"))
    path = tmp_path / "lesson.html"
    path.write_text(html_page(document), encoding="utf-8")
    answers = {blank.key: text_of(blank.answer) for blank in blanks(document)}
    seen = "() => [...document.querySelectorAll('article')].filter(x => x.offsetParent).map(x => x.id)"

    with opened(browser, path) as page:
        assert not {"step-kinetic-1", "step-lagrangian", "step-state"} & set(page.evaluate(seen))
        form = page.locator('form[data-key="square:1"]')
        form.locator("input").fill("m1")
        form.locator("input").press("Enter")
        assert "step-kinetic-1" not in page.evaluate(seen)
        assert not form.locator(".solution math").first.is_visible()
        form.locator("input").fill(answers["square:1"])
        form.locator("input").press("Enter")
        page.wait_for_selector("#step-kinetic-1")
        assert form.locator(".solution math").first.is_visible()
        assert "step-kinetic-2" not in page.evaluate(seen)
        for key in ("potential:1", "square:2", "potential:2"):  # given up
            page.locator(f'form[data-key="{key}"] .solution summary').first.click()
        page.wait_for_selector("#step-lagrangian")
        assert "step-state" not in page.evaluate(seen)
        assert page.locator("#part-numbers .waits").is_visible()
        page.evaluate("document.querySelectorAll('.solution').forEach(x => x.open = true)")
        page.wait_for_selector("#step-state")
        assert not page.locator("#part-numbers .waits").is_visible()
        assert page.evaluate("document.querySelectorAll('article[hidden]').length") == 0


@pytest.mark.wide("gimbal", "rod")
@pytest.mark.parametrize("name", sorted(one.stem for one in FINDINGS.glob("*.toml")))
def test_every_scene_of_the_findings_has_a_page_of_exercises(name: str, tmp_path: Path) -> None:
    """A in place of C in 1/(C - A) is no number, and a free body has equations of no one joint."""
    page = tmp_path / "page.html"
    assert (
        main(["walkthrough", str(FINDINGS / f"{name}.toml"), "--exercises", "--format", "html", "-o", str(page)]) == 0
    )
    assert "QUESTIONS" in page.read_text(encoding="utf-8")
