"""What docs say of linearising runs: the page's commands and examples."""

from __future__ import annotations

import doctest
import re
import shlex
from pathlib import Path

import pages
import pytest

from symdyn.cli import main

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "linearize.md"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]\d+)?")


@pytest.mark.parametrize(("command", "shown"), pages.commands(PAGE), ids=lambda text: text[:60])
def test_a_command_of_the_page_prints_what_stands_there(
    command: str, shown: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    main(shlex.split(command)[1:])
    out = capsys.readouterr()
    told = (out.err + out.out).rstrip("\n")
    told = told[: len(shown)] if "--start rest" in command else told  # the first of them stands there
    assert NUMBER.split(told) == NUMBER.split(shown)
    numbers = [[float(one) for one in NUMBER.findall(text)] for text in (told, shown)]
    assert numbers[0] == pytest.approx(numbers[1], rel=1e-4, abs=1e-7)


def test_the_examples_of_the_page_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testfile(str(PAGE), module_relative=False)
    assert found.failed == 0
    assert found.attempted > 8
