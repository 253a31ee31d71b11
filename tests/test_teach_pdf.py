"""A lesson as PDF has a title, a language, bookmarks, no page that is half empty, and few pages where it is brief."""

from __future__ import annotations

import re
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest

from symdyn.teach import rendered, walkthrough

EXAMPLES = Path(__file__).parent.parent / "examples"
FOOT = 0.93  # of a page: what is below is its number


def objects(pdf: bytes) -> str:
    """Return the dictionaries of a PDF, those in compressed streams too."""
    inflated = []
    for stream in re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.DOTALL):
        try:
            inflated.append(zlib.decompress(stream))
        except zlib.error:
            continue
    return b"\n".join([pdf, *inflated]).decode("latin-1")


def texts(found: str) -> list[str]:
    """Return the strings of two bytes a character, which titles are."""
    strings = re.findall(r"\((\\376\\377(?:\\[0-7]{3})*)\)", found)
    return [bytes(int(x, 8) for x in one.split("\\")[1:])[2:].decode("utf-16-be") for one in strings]


@pytest.mark.wide("two_link")
@pytest.mark.long
@pytest.mark.runs("pdflatex", "pdftoppm")
@pytest.mark.parametrize(
    ("name", "language", "formulation"), [("two_link", "sk", "lagrange"), ("four_bar", "en", "dalembert")]
)
def test_a_pdf_tells_what_it_is_and_fills_its_pages(tmp_path: Path, name: str, language: str, formulation: str) -> None:
    document = walkthrough(EXAMPLES / f"{name}.toml", language, "full", formulation=formulation)
    (pdf,) = rendered(document, "pdf").values()
    assert isinstance(pdf, bytes)

    found = objects(pdf)
    assert f"/Lang ({language})" in found
    assert sorted(texts(found)) == sorted([document.title, *(section.title for section in document.sections)])

    read = pytest.importorskip("matplotlib.image").imread
    (tmp_path / "lesson.pdf").write_bytes(pdf)
    subprocess.run(["pdftoppm", "-r", "30", "-gray", "-png", "lesson.pdf", "page"], cwd=tmp_path, check=True)
    pages = [read(path) for path in sorted(tmp_path.glob("page*.png"))]
    assert len(pages) > 3
    for number, page in enumerate(pages[:-1], 1):
        dark = np.flatnonzero(page[: int(FOOT * len(page))].min(axis=1) < 0.7)
        assert dark.max() > 0.5 * len(page), f"page {number}"


@pytest.mark.runs("pdflatex")
@pytest.mark.parametrize(
    ("name", "language", "most"), [("pendulum", "en", 2), ("pendulum", "sk", 2), ("two_link", "en", 6)]
)
def test_a_brief_pdf_has_few_pages(name: str, language: str, most: int) -> None:
    (pdf,) = rendered(walkthrough(EXAMPLES / f"{name}.toml", language), "pdf").values()
    assert isinstance(pdf, bytes)
    assert 0 < len(re.findall(r"/Type\s*/Page\b", objects(pdf))) <= most
