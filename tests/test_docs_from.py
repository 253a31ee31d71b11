"""Pages for those who come from another tool: each does a small job on both sides; what can be run is run."""

from __future__ import annotations

import doctest
import re
from importlib.util import find_spec
from pathlib import Path

import pages
import pytest

PAGES = ["from-sympy", "from-control", "from-simulink", "from-matlab-robotics", "from-pinocchio"]
IMPORT = re.compile(r"(?m)^>>> (?:import|from) (\w+)")


def sections(page: Path) -> list[str]:
    """Return the sections of a page that have examples."""
    return [text for text in page.read_text(encoding="utf-8").split("\n## ") if ">>> " in text]


@pytest.mark.runs("cc")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", PAGES)
def test_both_sides_of_a_page_run_and_agree(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sections end where what one of them imports is not installed (extras `control`, `bench`)."""
    monkeypatch.chdir(pages.ROOT)
    known: dict[str, object] = {}
    missing = ""
    for text in sections(pages.DOCS / f"{name}.md"):
        missing = missing or next((one for one in IMPORT.findall(text) if find_spec(one) is None), "")
        if not missing:
            example = doctest.DocTestParser().get_doctest(text, known, name, None, 0)
            runner = doctest.DocTestRunner(verbose=False)
            assert runner.run(example, clear_globs=False).failed == 0, text.partition("\n")[0]
            known = example.globs
    if missing:
        pytest.skip(f"{missing} is not installed")


@pytest.mark.parametrize("name", ["from-simulink", "from-matlab-robotics"])
def test_a_side_that_cannot_be_run_says_so_and_cites_its_manual(name: str) -> None:
    text = (pages.DOCS / f"{name}.md").read_text(encoding="utf-8")
    there = text.partition("## There (not run)")[2].partition("\n## ")[0]
    assert "Not run:" in there
    assert "```matlab" in there
    assert "https://www.mathworks.com/help/" in text


@pytest.mark.parametrize("name", PAGES)
def test_a_page_compares_no_figures(name: str) -> None:
    """Speed is measured in one place, by one rule: docs/performance.md."""
    text = (pages.DOCS / f"{name}.md").read_text(encoding="utf-8")
    assert not re.search(r"\b\d+(\.\d+)? ?(times as fast|ms|µs|ns)\b|faster than", text)
    assert f"\n{name}\n" in (pages.DOCS / "index.md").read_text(encoding="utf-8")
