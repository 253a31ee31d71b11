"""Notebooks of docs are small, complete and load nothing; the shortest show today what is stored in them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (extra dev)")
import notebooks  # noqa: E402

import symdyn  # noqa: E402

LARGEST = 200_000
"""Bytes of a notebook with what its cells show."""

SHORTEST = [path for path in notebooks.BOOKS if path.stem in ("derivatives", "linearize")]
"""The two that take the least time: the others import SymPy, or draw."""

LOADED = re.compile(r"""(?:src|href|data)\s*=\s*["']?\s*(?:https?:)?//|@import|url\(\s*["']?(?:https?:)?//""")


@pytest.mark.parametrize("path", notebooks.BOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_complete_and_small(path: Path) -> None:
    book = notebooks.stored(path)
    nbformat.validate(book)
    assert path.stat().st_size < LARGEST
    cells = notebooks.code(book)
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [one for cell in cells for one in cell.outputs]
    assert outputs
    assert not [one for one in outputs if one.output_type == "error" or one.get("name") == "stderr"]
    for one in outputs:
        assert set(one.get("data", {})) <= {"text/plain", "text/html", "text/latex", "text/markdown", "image/svg+xml"}
        assert not LOADED.search(str(one.get("data", {}).get("text/html", "")))


@pytest.mark.parametrize(
    "path", [path for path in notebooks.BOOKS if path.parent.name == "gallery"], ids=lambda path: path.stem
)
def test_the_gallery_shows_every_notebook_by_its_picture(path: Path) -> None:
    drawn = path.with_suffix(".svg").read_text(encoding="utf-8")
    assert drawn.strip() == notebooks.picture(notebooks.stored(path)).strip()
    page = (path.parent / "README.md").read_text(encoding="utf-8")
    assert f"]({path.stem}.svg)" in page
    assert f"]({path.name})" in page


def test_two_notebooks_are_run_in_every_test() -> None:
    assert len(SHORTEST) == 2


def marks(path: Path) -> list[pytest.MarkDecorator]:
    """Return when a notebook is run: all of them in `make targets`, but the two of every test."""
    if path in SHORTEST:
        return []
    return [pytest.mark.targets, *([] if path.stem in notebooks.TOOLS else [pytest.mark.slow])]


def test_the_gallery_begins_with_scenes_that_come_with_the_package() -> None:
    for path in notebooks.BOOKS:
        if path.parent.name == "gallery":
            code = "".join(cell.source for cell in notebooks.code(notebooks.stored(path)))
            (name,) = re.findall(r'symdyn\.example\("(\w+)"', code)[:1]
            assert name in symdyn.scene.examples()
            assert "symdyn.read(" not in code


@pytest.mark.heavy("linearize")
@pytest.mark.runs
@pytest.mark.long(0)
@pytest.mark.parametrize("path", [pytest.param(one, marks=marks(one)) for one in notebooks.BOOKS], ids=lambda p: p.stem)
def test_a_notebook_shows_what_is_stored_in_it(path: Path) -> None:
    pytest.importorskip("nbclient", reason="nbclient is not installed (extra dev)")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed (extra dev)")
    pairs = zip(notebooks.code(notebooks.stored(path)), notebooks.code(notebooks.run(path)), strict=True)
    for before, now in (tuple(map(notebooks.shown, pair)) for pair in pairs):
        assert notebooks.NUMBER.split(before) == notebooks.NUMBER.split(now)
        numbers = [[float(one) for one in notebooks.NUMBER.findall(text)] for text in (before, now)]
        assert numbers[0] == pytest.approx(numbers[1], rel=1e-5, abs=2e-6)
