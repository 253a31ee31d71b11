"""What docs say of derivatives runs: the page's examples and counts, and the notebook beside it."""

from __future__ import annotations

import doctest
import json
import re
from pathlib import Path

import notebooks
import pytest

from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.roads.count import state_dependent_counts
from symdyn.scene import read

ROOT = Path(__file__).parent.parent
PAGE, BOOK = ROOT / "docs" / "derivatives.md", ROOT / "docs" / "notebooks" / "derivatives.ipynb"
NUMBER = re.compile(r"-?\d+\.\d*(?:e[-+]\d+)?")


def test_the_examples_of_the_page_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testfile(str(PAGE), module_relative=False)
    assert found.failed == 0
    assert found.attempted > 20


@pytest.mark.parametrize("name", ["two_link", "puma560", "arm7"])
def test_the_counts_of_the_page_are_those_of_today(name: str) -> None:
    w = Workspace(read(ROOT / "examples" / f"{name}.toml"))
    (row,) = (line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith(f"| {name} |"))
    asked = [of + word for of in ("inverse_dynamics", "forward_dynamics") for word in ("", "_jvp", "_vjp")]
    counted = [state_dependent_counts(derive_one(w, one)).multiplications for one in asked]
    assert [int(cell) for cell in row.split("|")[2:-1]] == counted


def test_contracted_hessians_cost_what_the_page_says() -> None:
    w = Workspace(read(ROOT / "examples" / "arm7.toml"))
    for name in ("inverse_dynamics", "forward_dynamics"):
        count = state_dependent_counts(derive_one(w, f"{name}_hessian")).multiplications
        assert f"{count:,}" in PAGE.read_text(encoding="utf-8")


def text_of(outputs: notebooks.Shown) -> str:
    """Return what stands below a cell as one text."""
    return "\n".join("".join(one.get("text") or one["data"]["text/plain"]) for one in outputs)


def test_the_notebook_shows_what_its_cells_find() -> None:
    book, found = notebooks.run(BOOK)
    written = [cell["outputs"] for cell in book["cells"] if cell["cell_type"] == "code"]
    for before, now in zip(map(text_of, written), map(text_of, found), strict=True):
        assert NUMBER.split(before) == NUMBER.split(now)
        numbers = [[float(one) for one in NUMBER.findall(text)] for text in (before, now)]
        assert numbers[0] == pytest.approx(numbers[1], abs=2e-6)
        assert "False" not in now


def test_the_notebook_is_one() -> None:
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (extra dev)")
    nbformat.validate(json.loads(BOOK.read_text(encoding="utf-8")))


@pytest.mark.runs
@pytest.mark.slow
def test_the_notebook_executes_in_jupyter(monkeypatch: pytest.MonkeyPatch) -> None:
    client = pytest.importorskip("nbclient", reason="nbclient is not installed (extra dev)")
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (extra dev)")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed (extra dev)")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    book = nbformat.read(BOOK, as_version=4)
    where = {"metadata": {"path": str(ROOT)}}
    client.NotebookClient(book, timeout=300, kernel_name="python3", resources=where).execute()
