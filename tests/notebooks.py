"""Notebooks of docs, run as Jupyter runs them: in a kernel, in the folder where they stand.

python tests/notebooks.py docs/gallery/*.ipynb        writes what the cells show
"""

from __future__ import annotations

import os
import re
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unittest.mock import patch

import nbformat
from kernels import executed

ROOT = Path(__file__).resolve().parent.parent
BOOKS = sorted(path for folder in ("notebooks", "gallery", "teaching") for path in ROOT.glob(f"docs/{folder}/*.ipynb"))

TOOLS = {"casadi": "casadi", "hopper": "casadi", "fmu": "fmpy", "jax": "jax", "torch": "torch"}
"""Those that run a tool of others, which the environment of `make targets` has, and what they import of it."""

NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]\d+)?")


def stored(path: Path) -> Any:
    """Return a notebook as it stands in docs."""
    return nbformat.read(path, as_version=4)


def run(path: Path) -> Any:
    """Return a notebook with what its cells show today."""
    given = {
        "PATH": os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"])),  # of symdyn's commands
        "MATPLOTLIBRC": str(ROOT / "docs" / "site" / "matplotlibrc"),
        "SOURCE_DATE_EPOCH": "0",
        "OPENBLAS_NUM_THREADS": "1",  # as in tests: in how many parts sums are taken decides last digits
        "OPENBLAS_CORETYPE": "Haswell",  # and in which order; searches end elsewhere by it, and most processors have it
    }
    book = stored(path)
    for cell in book.cells:
        cell.metadata = {}
    where = {"metadata": {"path": str(path.parent)}}
    with patch.dict(os.environ, given):
        executed(book, kernel_name="python3", resources=where, record_timing=False, coalesce_streams=True)
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    book.metadata = {"kernelspec": kernel, "language_info": {"name": "python", "pygments_lexer": "ipython3"}}
    return book


def code(book: Any) -> list[Any]:
    """Return the cells that compute."""
    return [cell for cell in book.cells if cell.cell_type == "code"]


def shown(cell: Any) -> str:
    """Return what stands below a cell, as text; of a picture or a page that it is one."""
    kinds = [set(one.get("data", {})) - {"text/plain"} for one in cell.outputs]
    texts = ["".join(one.get("text") or one["data"]["text/plain"]) for one in cell.outputs]
    return "\n".join(f"{text} {sorted(kind)}" for text, kind in zip(texts, kinds, strict=True))


def picture(book: Any) -> str:
    """Return the first picture that a notebook shows, "" for none."""
    shown = (one.get("data", {}).get("image/svg+xml") for cell in code(book) for one in cell.outputs)
    return next((text for text in shown if text), "")


def main() -> None:
    """Write what cells show into the notebooks that are named; beside those of the gallery their first picture."""
    for path in map(Path, sys.argv[1:]):
        if path.stem in TOOLS and find_spec(TOOLS[path.stem]) is None:
            print(f"{path} stays as it is: {TOOLS[path.stem]} is not installed")
            continue
        print(path, flush=True)
        book = run(path)
        nbformat.write(book, path)
        if path.parent.name == "gallery":
            path.with_suffix(".svg").write_text(picture(book) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
