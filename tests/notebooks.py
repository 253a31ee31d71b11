"""Notebooks of docs: their cells are run, and what they show is compared with what stands below them, or written there.

python tests/notebooks.py docs/notebooks/derivatives.ipynb        writes what the cells show
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent

Shown = list[dict[str, Any]]


def shown(source: str, space: dict[str, Any], count: int) -> Shown:
    """Return what Jupyter would show below a cell: what it prints, and the value of its last expression."""
    tree, printed = ast.parse(source), io.StringIO()
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, f"cell {count}", "exec"), space)
        value = eval(compile(ast.Expression(last.value), f"cell {count}", "eval"), space) if last else None
    found: Shown = []
    if printed.getvalue():
        found.append({"name": "stdout", "output_type": "stream", "text": lines(printed.getvalue())})
    if value is not None:
        data = {"text/plain": lines(repr(value))}
        found.append({"data": data, "execution_count": count, "metadata": {}, "output_type": "execute_result"})
    return found


def lines(text: str) -> list[str]:
    """Return text as notebooks keep it."""
    return text.splitlines(keepends=True)


def run(path: Path) -> tuple[dict[str, Any], list[Shown]]:
    """Return a notebook, and what its code cells show, run in order in the root of the repository."""
    book = json.loads(path.read_text(encoding="utf-8"))
    space: dict[str, Any] = {}
    found, here = [], Path.cwd()
    os.chdir(ROOT)
    try:
        for cell in book["cells"]:
            if cell["cell_type"] == "code":
                found.append(shown("".join(cell["source"]), space, len(found) + 1))
    finally:
        os.chdir(here)
    return book, found


def main() -> None:
    """Write what cells show into the notebooks that are named."""
    for name in sys.argv[1:]:
        book, found = run(Path(name))
        cells = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
        for count, (cell, outputs) in enumerate(zip(cells, found, strict=True), start=1):
            cell["outputs"], cell["execution_count"] = outputs, count
        Path(name).write_text(json.dumps(book, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
