"""Packages meet at their fronts: no import passes one; numbers of `packages.toml` fall, but for what new rows take."""

from __future__ import annotations

import ast
import inspect
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pages
import pytest
from reference import GROUPS
from test_layers import ROOT, arrows, modules, offered, statements

import symdyn
from symdyn.simulation import Problem, Run

BUDGETS = tomllib.loads((Path(__file__).parent / "packages.toml").read_text(encoding="utf-8"))
FRONTS = {f"symdyn.{name}": most for name, most in BUDGETS["names"].items()}

RAISE = "if a new row takes them, raise the number of tests/packages.toml by what it takes; else make room"


def package(module: str) -> str:
    return ".".join(module.split(".")[:2])


@cache
def taken() -> tuple[tuple[str, str, str], ...]:
    """Return what modules import of other packages, for type checkers too: module, from where, name."""
    return tuple(
        (module, source, name)
        for module, tree in modules().items()
        if "." in module
        for source, name in _imports(tree)
        if package(source) != package(module)
    )


def _imports(tree: ast.Module) -> Iterator[tuple[str, str]]:
    for node in statements(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("symdyn."):
            yield from ((node.module, one.name) for one in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module == "symdyn":
            yield from ((f"symdyn.{one.name}", "") for one in node.names)
        elif isinstance(node, ast.Import):
            yield from ((one.name, "") for one in node.names if one.name.startswith("symdyn."))


def test_no_import_passes_a_front() -> None:
    files = {f"symdyn.{path.stem}" for path in ROOT.glob("*.py")}
    past = [
        f"{module} imports {name} of {source}" for module, source, name in taken() if source not in {*FRONTS, *files}
    ]

    assert not past, "\n".join(past)


def test_what_is_taken_is_offered() -> None:
    missing = [
        f"{module} imports {name} of {source}"
        for module, source, name in taken()
        if name and source in FRONTS and source != "symdyn.cli" and name not in offered(source)
    ]

    assert not missing, "\n".join(missing)


def test_a_front_is_one_list() -> None:
    stubs = {".".join(path.parent.relative_to(ROOT.parent).parts) for path in ROOT.rglob("__init__.pyi")}

    assert stubs - {"symdyn"} == FRONTS.keys() - {"symdyn.cli"}
    assert len(FRONTS) <= BUDGETS["fronts"]


@pytest.mark.parametrize("front", sorted(FRONTS.keys() - {"symdyn.cli"}))
def test_a_name_that_is_offered_is_there_and_says_what_it_is(front: str) -> None:
    known = import_module(front)
    found = {name: getattr(known, name) for name in offered(front)}

    assert len(found) <= FRONTS[front], f"{front} offers {len(found)} names; {RAISE}"
    assert [
        name for name, one in found.items() if inspect.isfunction(one) or inspect.isclass(one) if not one.__doc__
    ] == []


def parameters(function: Callable[..., object]) -> int:
    """Return how many parameters a function has beside those that are a problem's or a run's."""
    shared = {"scene", *Problem.Fields.__annotations__, *Run.Fields.__annotations__}
    return len([name for name in inspect.signature(function).parameters if name not in shared])


@pytest.mark.parametrize("front", sorted(FRONTS.keys() - {"symdyn.cli"}))
def test_a_public_function_has_few_parameters(front: str) -> None:
    """Nine, or as many as it has today."""
    found = {name: getattr(import_module(front), name) for name in offered(front)}
    most = BUDGETS["parameters"]
    many = {
        name: count
        for name, one in found.items()
        if inspect.isfunction(one)
        if (count := parameters(one)) > most.get(f"{front.removeprefix('symdyn.')}.{name}", most["others"])
    }

    assert many == {}


def test_fewer_names_cross_packages() -> None:
    names = {(source, name) for _, source, name in taken()}

    assert len(names) <= BUDGETS["crossing"], f"{len(names)} names"


def parts(annotation: Any) -> set[type]:
    """Return the classes that an annotation is made of."""
    found = {annotation} if inspect.isclass(annotation) and not get_args(annotation) else set()
    return found.union(*map(parts, get_args(annotation)))


def named_in_docs() -> set[type]:
    """Return the classes of ours that pages, notebooks and listings of functions call by name."""
    paths = [pages.ROOT / "README.md", *pages.DOCS.rglob("*.md"), *pages.DOCS.rglob("*.ipynb")]
    text = "\n".join(path.read_text(encoding="utf-8") for path in paths)
    names = set(re.findall(r"\b(symdyn(?:\.\w+)*)\.([A-Z]\w*)", text))
    for module, several in re.findall(r"from (symdyn[\w.]*) import ([\w, ]+)", text):
        names |= {(module, name.strip()) for name in several.split(",")}
    names |= {tuple(f"symdyn.{name}".rsplit(".", 1)) for group in GROUPS for name in group.more}
    return {one for module, name in names if inspect.isclass(one := getattr(import_module(module), name, None))}


def glossary() -> list[str]:
    page = (pages.DOCS / "architecture.md").read_text(encoding="utf-8").partition("## Words")[2]
    return re.findall(r"(?m)^\| \*\*(.+?)\*\* \| .+ \| .+ \|$", page)


def test_users_meet_few_nouns_and_words() -> None:
    """A noun is a class that `symdyn` offers, that one of its functions returns, or that docs name; errors are one.

    A word is a row of the glossary in `docs/architecture.md`: ours on purpose, at most fifteen, each with the reason.
    """
    every = [getattr(symdyn, name) for name in offered("symdyn")]
    offers = [one for one in every if callable(one) and not inspect.ismodule(one)]
    met = named_in_docs().union(
        *(parts(one if inspect.isclass(one) else get_type_hints(one)["return"]) for one in offers)
    )
    ours = {one for one in met if one.__module__.startswith("symdyn.") and not issubclass(one, symdyn.SymdynError)}
    nouns, words = sorted(one.__name__ for one in {*ours, symdyn.SymdynError}), glossary()

    assert 0 < len(words) <= 15
    assert len(nouns) + len(words) <= BUDGETS["nouns"], f"{nouns}, {words}"


def test_nouns_that_go_between_packages_are_offered() -> None:
    """The table of `docs/architecture.md` names what a front offers, each in the package that it is from."""
    page = (pages.DOCS / "architecture.md").read_text(encoding="utf-8").partition("| noun |")[2].partition("\n\n")[0]
    rows = re.findall(r"(?m)^\| (`.+?`) \| `(.+?)` \|", page)
    missing = [
        name
        for names, where in rows
        for name in re.findall(r"`(\w+)`", names)
        if not any(inspect.isclass(getattr(one, name, None)) for one in map(import_module, _around(where)))
    ]

    assert len(rows) > 20
    assert missing == []


def _around(folder: str) -> list[str]:
    """Return the modules that may offer what is in a folder: its package, and itself where it is a front."""
    top, inner = f"symdyn.{folder.partition('/')[0]}", f"symdyn.{folder.replace('/', '.')}"
    return [top, *({inner} & FRONTS.keys())]


def test_files_are_few_and_of_one_idea() -> None:
    paths = [path for path in ROOT.rglob("*.py") if path.name != "__init__.py"]
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in ROOT.rglob("*.py")}
    users = Counter(target for targets in arrows().values() for target in targets)
    small = [
        path
        for path in paths
        if lines[path] < 120 and users[".".join(("symdyn", *path.relative_to(ROOT).with_suffix("").parts))] == 1
    ]

    assert len(lines) <= BUDGETS["files"], f"{len(lines)} files; {RAISE}"
    assert max(lines.values()) <= BUDGETS["longest"]
    assert len(small) <= BUDGETS["small"], small


def test_no_package_grows_beyond_its_budget() -> None:
    lines = Counter[str]()
    for path in ROOT.rglob("*.py*"):
        if path.suffix in (".py", ".pyi"):
            lines[path.relative_to(ROOT).parts[0].removesuffix(".py").removesuffix(".pyi")] += len(
                path.read_text(encoding="utf-8").splitlines()
            )
    over = {name: count for name, count in lines.items() if count > BUDGETS["lines"].get(name, 0)}

    assert not over, f"{over} lines; {RAISE}"
    assert lines.keys() == BUDGETS["lines"].keys()
