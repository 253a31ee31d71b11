"""Answers in two dimensions: a page of exercises with MathLive in it; what it gives is judged as text is."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from browser import pictured, window
from npm_packages import packages

from symdyn.cli import main
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import EmitError
from symdyn.scene import read
from symdyn.teach import Handout
from symdyn.teach.document import Blank, Document
from symdyn.teach.mathematics import Spelling
from symdyn.teach.practice.exercises import judge

EXAMPLES = Path(__file__).parent.parent / "examples"
FIRST = "form.blank math-field"
VALUE = "document.querySelector('form.blank input[type=text]').value"
ROUND = """([key, latex]) => {
  const field = document.querySelector("math-field");
  field.value = latex;
  return [field.value, Answers.judge(key, field.value).right];
}"""
KEEN = 15  # ms from one key to the next


@pytest.mark.parametrize("name", ["two_link", "cart_pole", "heavy_top", "four_bar"])
@pytest.mark.playground
def test_what_a_field_gives_is_judged_as_what_is_typed(name: str, tmp_path: Path, browser: Any) -> None:
    """Every right answer as LaTeX, the first four typed; nothing is fetched; text again by a button."""
    lesson = Handout(read(EXAMPLES / f"{name}.toml"), exercises=True, math_editor=str(packages() / "mathlive"))
    (text,) = lesson.files(["html"], lambda _: None).values()
    path = tmp_path / "page.html"
    path.write_text(str(text), encoding="utf-8")
    page, said = window(browser), list[str]()
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda fault: said.append(str(fault)))
    page.on("request", lambda request: said.append(request.url) if not request.url.startswith("blob:") else None)
    page.goto(path.as_uri())
    page.wait_for_selector("math-field", state="attached")

    document = lesson.document()
    spell, asked = Spelling(document), [block for _, block in document.blocks() if isinstance(block, Blank)]
    for blank in asked:
        latex = spell.inline(blank.answer)
        given, right = page.evaluate(ROUND, [blank.key, latex])
        assert right, (latex, given)
        assert judge(document, blank.key, given).startswith("Right"), given  # the command line reads it, too
    assert len(asked) > 3
    assert said == [path.as_uri()]

    page.evaluate("document.querySelectorAll('details.more').forEach(one => { one.open = true; })")
    page.locator(FIRST).first.click()
    page.keyboard.type("x")  # the first key after the focus may be lost
    pictured(page, 3)
    page.evaluate(f"document.querySelector('{FIRST}').value = ''")
    page.keyboard.type("2/", delay=KEEN)  # and nothing below the line
    pictured(page, 3)
    given = page.evaluate(VALUE)
    assert "frac" in given
    assert "placeholder" not in given
    for blank in asked[:4]:
        typed = text_of(blank.answer).replace("_", "").replace("**", "^")
        page.evaluate(f"document.querySelector('{FIRST}').value = ''")
        page.keyboard.type(typed, delay=KEEN)
        pictured(page, 3)
        given = page.evaluate(VALUE)
        assert judge(document, blank.key, given).startswith("Right"), (typed, given)
    page.keyboard.press("Enter")
    page.locator("form.blank .entry button[type=button]").first.click()  # as text
    box = page.locator("form.blank input[type=text]").first
    assert box.evaluate("box => box === document.activeElement")
    assert box.input_value() == given
    page.evaluate((packages() / "axe-core" / "axe.min.js").read_text(encoding="utf-8"))
    assert page.evaluate("axe.run('form.blank').then(found => found.violations.map(one => one.id))") == []
    page.context.close()


@cache
def exercises() -> Document:
    return Handout(read(EXAMPLES / "two_link.toml"), exercises=True).document()


@pytest.mark.parametrize("text", ["q_1^{\\doubleprime}", "q_1^{\\prime\\prime}", "q_1^\\doubleprime", "q_1''"])
def test_primes_of_latex_are_dots(text: str) -> None:
    lesson = exercises()

    given = [judge(lesson, "rate:1", f"{text} - q_1^{{\\prime}}") for text in (text, "\\ddot{q}_1")]

    assert "no symbol" not in given[0]
    assert given[0] == given[1]


def test_a_folder_without_mathlive_and_a_page_that_asks_nothing_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = str(EXAMPLES / "pendulum.toml")

    with pytest.raises(EmitError, match=re.escape(f"{tmp_path}: mathlive-fonts.css is not there; npm install")):
        Handout(read(scene), exercises=True, math_editor=str(tmp_path)).files(["html"], lambda _: None)
    assert main(["walkthrough", scene, "--math-editor", str(tmp_path), "-o", str(tmp_path / "a.html")]) == 1
    assert "--math-editor is for a page that asks" in capsys.readouterr().err


LINES = {
    "sqrt(h1/g)": r"\sqrt{(\frac{h_1}{g})}",
    "(m1-m2*sin(q1)*q1'^2)/(2*g)": r"\frac{(m_1-m_2\cdot\sin(q_1)\cdot\dot{q}_1^2)}{(2\cdot g)}",
    "cos(q1-(q2))/2": r"\frac{\cos(q_1-(q_2))}{2}",
    "m1/(m1+m2)": r"\frac{m_1}{(m_1+m_2)}",
}
"""What is typed as in a line of text, and the formula that it is."""


@pytest.mark.playground
def test_brackets_are_typed_as_in_a_line_of_text(tmp_path: Path, browser: Any) -> None:
    """A closing one ended in the denominator, and the numerator began at the first bracket within brackets."""
    lesson = Handout(read(EXAMPLES / "two_link.toml"), exercises=True, math_editor=str(packages() / "mathlive"))
    (text,) = lesson.files(["html"], lambda _: None).values()
    path = tmp_path / "page.html"
    path.write_text(str(text), encoding="utf-8")
    page = window(browser)
    page.goto(path.as_uri())
    page.wait_for_selector("math-field", state="attached")
    page.evaluate("document.querySelectorAll('details.more').forEach(one => { one.open = true; })")
    page.locator(FIRST).first.click()
    page.keyboard.type("x")
    pictured(page, 3)
    found = {}
    for line in LINES:
        page.evaluate(f"document.querySelector('{FIRST}').value = ''")
        page.keyboard.type(line, delay=KEEN)
        pictured(page, 3)
        found[line] = page.evaluate(VALUE)
    page.context.close()

    assert found == LINES
