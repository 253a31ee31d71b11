"""Packages meet at their fronts: no import passes one, and the numbers of `packages.toml` may only fall."""

from __future__ import annotations

import ast
import inspect
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
from test_layers import ROOT, arrows, modules, offered

from symdyn.simulation import Problem, Run

BUDGETS = tomllib.loads((Path(__file__).parent / "packages.toml").read_text(encoding="utf-8"))
FRONTS = {f"symdyn.{name}": most for name, most in BUDGETS["names"].items()}


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
    for node in ast.walk(tree):
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

    assert len(found) <= FRONTS[front], f"{len(found)} names"
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


def test_files_are_few_and_of_one_idea() -> None:
    paths = [path for path in ROOT.rglob("*.py") if path.name != "__init__.py"]
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in ROOT.rglob("*.py")}
    users = Counter(target for targets in arrows().values() for target in targets)
    small = [
        path
        for path in paths
        if lines[path] < 120 and users[".".join(("symdyn", *path.relative_to(ROOT).with_suffix("").parts))] == 1
    ]

    assert len(lines) <= BUDGETS["files"]
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

    assert not over
    assert lines.keys() == BUDGETS["lines"].keys()
