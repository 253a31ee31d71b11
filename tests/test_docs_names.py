"""What docs, docstrings and messages name is there: names of Python can be imported, files of this checkout exist."""

from __future__ import annotations

import ast
import builtins
import re
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
from pages import DOCS, ROOT
from test_layers import statements
from typed_pages import code

import symdyn

PACKAGE = ROOT / "symdyn"
NAME = re.compile(r"\bsymdyn(?:\.[A-Za-z_]+)+")
IMPORT = re.compile(r"from (symdyn[\w.]*) import ([\w, ]+)")
JAVASCRIPT = {"symdyn.two_link.mass_matrix", "symdyn.NAME.named"}
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *DOCS.rglob("*.md"), *(ROOT / "tests").rglob("*.md")]

PATH = re.compile(r"`([\w.-]+(?:/[\w.-]+)*(?:/|\.(?:py|pyi|jinja|js|cu|md|svg)))`")
"""A file, or a folder with a slash behind it."""


@cache
def docstrings(path: Path) -> tuple[str, ...]:
    """Return the docstrings of a module, those of constants too."""
    nodes = (node for node in statements(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Expr))
    texts = (node.value.value for node in nodes if isinstance(node.value, ast.Constant))
    return tuple(text for text in texts if isinstance(text, str))


@cache
def told() -> list[str]:
    """Return the names in docs and docstrings, and those that messages end a sentence's part with."""
    found = set()
    for path in [*PAGES, *DOCS.rglob("*.ipynb")]:
        text = path.read_text(encoding="utf-8")
        found |= set(NAME.findall(text))
        found |= {f"{package}.{name.strip()}" for package, names in IMPORT.findall(text) for name in names.split(",")}
    for path in PACKAGE.rglob("*.py"):
        found |= {name for text in docstrings(path) for name in NAME.findall(text)}
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.lstrip().startswith(('"', 'f"')):
                found |= set(NAME.findall(line))
    return sorted(name for name in found - JAVASCRIPT if not name.endswith((".py", ".git", ".md", ".fish")))


def test_every_name_that_is_told_can_be_imported() -> None:
    assert [name for name in told() if not _is_there(name)] == []


def _is_there(name: str) -> bool:
    package, _, last = name.rpartition(".")
    for module, attribute in ((package, last), (name, "__name__")):
        try:
            if getattr(import_module(module), attribute, None) is not None:
                return True
        except ImportError:
            continue
    return False


@pytest.mark.parametrize("page", [ROOT / "README.md", *sorted(DOCS.glob("*.md"))], ids=lambda page: page.name)
def test_every_name_of_a_snippet_is_imported_or_made_on_its_page(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert unbound(code(text)) == []
    bare = set(re.findall(r"`(\w+)\(", re.sub(r"(?ms)^ *```.*?^ *```", "", text))) & {*inside()} - {"table"}
    assert [one for one in sorted(bare) if not re.search(rf"\.{one}\b|import [\w, ]*\b{one}\b", text)] == []


def test_a_name_that_nobody_has_made_is_seen() -> None:
    assert unbound("import a.b as c, d.e\nz = along(c, d, [k for k in z], lambda q: q + p)") == ["along", "p"]
    assert "along" in inside()


def unbound(source: str) -> list[str]:
    """Return the names that a text uses, and neither imports nor makes."""
    nodes = [*ast.walk(ast.parse(source))]
    names = [node for node in nodes if isinstance(node, ast.Name)]
    made = {*dir(builtins), *(node.id for node in names if isinstance(node.ctx, ast.Store))}
    made |= {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    made |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    made |= {(node.asname or node.name).partition(".")[0] for node in nodes if isinstance(node, ast.alias)}
    return sorted({node.id for node in names} - made)


@cache
def inside() -> frozenset[str]:
    """Return the names that packages offer and `symdyn` does not; a formula's table(x) is one, too."""
    fronts = [import_module(f"symdyn.{path.parent.name}") for path in PACKAGE.glob("*/__init__.pyi")]
    return frozenset(name for front in fronts for name in front.__all__) - {*symdyn.__all__}


def test_the_door_of_reactions_at_one_position_is_told() -> None:
    assert "symdyn.dynamics.reactions_at" in told()


ROOTS = {path.name for path in ROOT.iterdir()}


@cache
def there() -> frozenset[str]:
    """Return the files and folders of the checkout, and every end of their paths."""
    folders = ("symdyn", "docs", "tests", "benchmarks", "templates", "examples", "generated", ".ci", ".github")
    paths = [path.relative_to(ROOT).as_posix() for folder in folders for path in (ROOT / folder).rglob("*")]
    paths += folders
    return frozenset(path[k:] for path in paths for k in (0, *(m.end() for m in re.finditer("/", path))))


def lost(text: str) -> list[str]:
    """Return the paths in a text that lead nowhere; a file without a folder stands beside one named before it."""
    found = []
    for part in re.split(r"\n(?=\n|\|| *[-*\d])", text):
        beside = [""]
        for path in (one.rstrip("/") for one in PATH.findall(part)):
            alone = "/" not in path and "." in path and len(beside) > 1
            if not any(f"{one}{path}" in there() for one in (beside[1:] if alone else beside)) and path not in ROOTS:
                found.append(path)
            elif "." not in path:
                beside.append(f"{path}/")
            elif "/" in path:
                beside.append(f"{path.rpartition('/')[0]}/")
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_file_that_a_page_names_is_there(page: Path) -> None:
    found = lost(re.sub(r"(?ms)^ *```.*?^ *```", "", page.read_text(encoding="utf-8")))
    assert [path for path in found if "/" in path or page.name in ("architecture.md", "CONTRIBUTING.md")] == []


def test_a_file_that_a_docstring_names_is_there() -> None:
    wrong = {path.name: found for path in PACKAGE.rglob("*.py") if (found := lost("\n\n".join(docstrings(path))))}

    assert wrong == {}


def test_a_file_that_is_not_there_is_seen() -> None:
    text = (
        "`symdyn/table.py`, `none/table.py` and `tests/none/`\n\n`scene/toml.py`, `build.py`, `table.py`\n\n`none.py`"
    )
    assert lost(text) == ["none/table.py", "tests/none", "table.py", "none.py"]
