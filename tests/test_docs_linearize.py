"""What docs say of linearising runs: the page's commands and examples, and the notebook beside it."""

from __future__ import annotations

import doctest
import json
import re
import shlex
from pathlib import Path

import notebooks
import pytest

from symdyn.cli import main

ROOT = Path(__file__).parent.parent
PAGE, BOOK = ROOT / "docs" / "linearize.md", ROOT / "docs" / "notebooks" / "linearize.ipynb"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]\d+)?")


def commands() -> list[tuple[str, str]]:
    """Return the commands of the page and what stands below each."""
    found = []
    for block in re.split(r"^    \$ ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        command, _, below = block.partition("\n")
        shown = re.match(r"(?:    .*\n|\n(?=    ))*", below)
        assert shown
        found.append((command, re.sub(r"^    ", "", shown[0], flags=re.MULTILINE).rstrip("\n")))
    return found


@pytest.mark.parametrize(("command", "shown"), commands(), ids=lambda text: text[:60])
def test_a_command_of_the_page_prints_what_stands_there(
    command: str, shown: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    main(shlex.split(command)[1:])
    out = capsys.readouterr()
    told = (out.err + out.out).rstrip("\n")
    told = told[: len(shown)] if "--at rest" in command else told  # the first of them stands there
    assert NUMBER.split(told) == NUMBER.split(shown)
    numbers = [[float(one) for one in NUMBER.findall(text)] for text in (told, shown)]
    assert numbers[0] == pytest.approx(numbers[1], rel=1e-4, abs=1e-7)


def test_the_examples_of_the_page_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testfile(str(PAGE), module_relative=False)
    assert found.failed == 0
    assert found.attempted > 8


def text_of(outputs: notebooks.Shown) -> str:
    """Return what stands below a cell as one text."""
    return "\n".join("".join(one.get("text") or one["data"]["text/plain"]) for one in outputs)


@pytest.mark.long
def test_the_notebook_shows_what_its_cells_find() -> None:
    book, found = notebooks.run(BOOK)
    written = [cell["outputs"] for cell in book["cells"] if cell["cell_type"] == "code"]
    for before, now in zip(map(text_of, written), map(text_of, found), strict=True):
        assert NUMBER.split(before) == NUMBER.split(now)
        numbers = [[float(one) for one in NUMBER.findall(text)] for text in (before, now)]
        assert numbers[0] == pytest.approx(numbers[1], rel=1e-5, abs=1e-6)


def test_the_notebook_is_one() -> None:
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (extra dev)")
    nbformat.validate(json.loads(BOOK.read_text(encoding="utf-8")))
