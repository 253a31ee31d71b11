"""Notebooks: valid, the same in every run, and they execute."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

import symdyn
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import TeachError
from symdyn.scene import read
from symdyn.teach import rendered, walkthrough
from symdyn.teach.document import Blank, Document
from symdyn.teach.practice.exercises import judge, with_exercises

nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (extra dev)")
EXAMPLES = Path(__file__).parent.parent / "examples"


def document(name: str, exercises: bool, language: str = "en") -> Document:
    found = walkthrough(read(EXAMPLES / f"{name}.toml"), language)
    return with_exercises(found) if exercises else found


def book(name: str, exercises: bool, language: str = "en") -> str:
    text = rendered(document(name, exercises, language), "notebook")[f"{name}.ipynb"]
    assert isinstance(text, str)
    return text


@pytest.mark.long
@pytest.mark.parametrize("exercises", [False, True])
@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
def test_a_notebook_is_valid_and_the_same_in_every_run(name: str, exercises: bool) -> None:
    text = book(name, exercises)

    nbformat.validate(json.loads(text))
    assert book(name, exercises) == text
    assert len(text) < 1_500_000


def run_cells(text: str) -> list[str]:
    """Run the cells in this process and return what each prints or shows."""
    import ast
    import contextlib
    import io

    space: dict[str, Any] = {}
    shown = []
    for cell in json.loads(text)["cells"]:
        if cell["cell_type"] == "code":
            printed = io.StringIO()
            tree = ast.parse(cell["source"])
            last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
            with contextlib.redirect_stdout(printed):
                exec(compile(tree, cell["id"], "exec"), space)
                value = eval(compile(ast.Expression(last.value), cell["id"], "eval"), space) if last else None
            shown.append(printed.getvalue() + (str(value) if value is not None else ""))
    return shown


def test_the_cells_of_a_lesson_find_their_own_formulas_right() -> None:
    shown = "\n".join(run_cells(book("two_link", False)))

    lines = [line for line in shown.splitlines() if line]
    assert len(lines) >= 7
    assert all(": right" in line for line in lines)


def test_the_cells_of_exercises_wait_for_an_answer() -> None:
    shown = run_cells(book("two_link", True, "sk"))

    assert set(filter(None, shown)) == {"Nič tu nie je napísané."}


@pytest.mark.long
def test_a_typed_answer_is_judged() -> None:
    lesson = document("two_link", True)
    for _, blank in lesson.blocks():
        if isinstance(blank, Blank):
            assert judge(lesson, blank.key, f"x = {text_of(blank.answer)}") == "Right."
            assert (
                judge(lesson, blank.key, f"-({text_of(blank.answer)})") == "Not yet: all of it has the opposite sign."
            )
            assert judge(lesson, blank.key, "m1") == "Not yet: it has another value."
            assert "did you mean" in judge(lesson, blank.key, "m3 h1")
    with pytest.raises(TeachError, match="there is no exercise"):
        judge(lesson, "none", "m1")


@pytest.mark.runs
@pytest.mark.slow
@pytest.mark.parametrize("exercises", [False, True])
def test_a_notebook_executes_in_jupyter(exercises: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    client = pytest.importorskip("nbclient", reason="nbclient is not installed (extra dev)")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed (extra dev)")
    root = str(Path(symdyn.__file__).parent.parent)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH", "")])))
    found = nbformat.reads(book("cart_pole", exercises), as_version=4)

    client.NotebookClient(found, timeout=120, kernel_name="python3").execute()

    outputs = [output for cell in found.cells if cell.cell_type == "code" for output in cell.outputs]
    assert outputs
    assert all(output.output_type != "error" for output in outputs)
