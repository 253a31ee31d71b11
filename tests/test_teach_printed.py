"""A page of exercises as Chromium prints it: no solution is on the paper, and no formula is parted from its line."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from browser import opened
from lessons import lesson_of

from symdyn.scene import read
from symdyn.teach.practice.exercises import with_exercises
from symdyn.teach.render.html import html_page

EXAMPLES = Path(__file__).parent.parent / "examples"
MARKED = """() => {
  const mark = (element, name, end) => {
    const word = document.createElement("span");
    word.textContent = `[${name}]`;
    word.style = "position:absolute;text-indent:0;font:1px monospace";
    element[end ? "append" : "prepend"](word);
  };
  [...document.querySelectorAll(".text .formula")].forEach((formula, k) => {
    const flow = formula.querySelector(".flow"), lead = formula.previousElementSibling;
    mark(flow, `a${k}`, false);
    mark(flow, `z${k}`, true);
    if (lead?.matches("p")) mark(lead, `l${k}`, true);
  });
  document.querySelectorAll(".solution").forEach((one, k) => mark(one, `s${k}`, true));
  document.querySelectorAll(".blank").forEach((one, k) => mark(one, `q${k}`, true));
}"""
"""Gives the ends of formulas, of what leads to them, of solutions and of questions names that a PDF has as text."""


PAPERS = [("pendulum", "en", 10), ("two_link", "en", 14), ("cart_pole", "sk", 14)]


@pytest.mark.wide("pendulum-en-10")
@pytest.mark.runs("chromium", "pdftotext")
@pytest.mark.parametrize(("name", "language", "most"), PAPERS)
def test_paper_has_questions_whole_formulas_and_no_solution(
    name: str, language: str, most: int, tmp_path: Path, browser: Any
) -> None:
    path, paper = tmp_path / "lesson.html", tmp_path / "lesson.pdf"
    path.write_text(html_page(with_exercises(lesson_of(read(EXAMPLES / f"{name}.toml"), language))), encoding="utf-8")
    with opened(browser, path) as page:
        page.evaluate(MARKED)
        asked = page.evaluate("document.querySelectorAll('.blank').length")
        page.emulate_media(media="print")
        paper.write_bytes(page.pdf(format="A4", margin=dict.fromkeys(("top", "bottom", "left", "right"), "15mm")))
    told = subprocess.run(["pdftotext", "-raw", str(paper), "-"], capture_output=True, text=True, check=True).stdout
    pages = told.rstrip("\f").split("\f")
    found = {mark: k for k, text in enumerate(pages, 1) for mark in re.findall(r"\[([azlsq]\d+)\]", text)}
    kinds = {kind: {int(mark[1:]): k for mark, k in found.items() if mark[0] == kind} for kind in "azlsq"}

    assert len(pages) <= most
    assert not kinds["s"], "a solution"
    assert len(kinds["q"]) == asked > 9
    assert len(kinds["a"]) > 10
    assert kinds["a"] == kinds["z"], "a formula that is parted"
    parted = {k: page for k, page in kinds["l"].items() if k in kinds["a"] and kinds["a"][k] != page}
    assert not parted, "a formula that is not where the line is that leads to it"


@pytest.mark.runs("chromium")
def test_what_vanishes_stands_in_one_line(tmp_path: Path, browser: Any) -> None:
    path = tmp_path / "lesson.html"
    path.write_text(html_page(lesson_of(read(EXAMPLES / "two_link.toml"))), encoding="utf-8")
    with opened(browser, path, 390) as page:
        page.emulate_media(media="print")
        page.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")
        high = page.evaluate("[...document.querySelectorAll('td .kept')].map(one => one.getClientRects().length)")
    assert high
    assert set(high) == {1}
