"""The packages import downwards only, folders inside packages too, and no two files import each other in a circle."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import symdyn
from tests.packages_picture import FOLDERS, PACKAGES, picture

ROOT = Path(symdyn.__file__).parent
NAMED = re.compile(rf"symdyn\.({'|'.join(map(re.escape, PACKAGES))})(\.[\w.:]*)?\Z")
EXTRAS = {
    "casadi",
    "clarabel",
    "control",
    "dask",
    "heyoka",
    "jax",
    "matplotlib",
    "sksundae",
    "torch",
    "trimesh",
    "zarr",
}
PICTURE = ROOT.parent / "docs" / "pictures" / "packages.svg"


def below(package: str) -> set[str]:
    found = {package}
    for lower in PACKAGES[package]:
        found |= below(lower)
    return found


@cache
def modules() -> dict[str, ast.Module]:
    """Return the syntax of every module by its name."""
    found = {}
    for path in sorted(ROOT.rglob("*.py")):
        parts = ("symdyn", *path.relative_to(ROOT).with_suffix("").parts)
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = ast.parse(path.read_text(encoding="utf-8"))
    return found


def statements(tree: ast.AST) -> Iterator[ast.stmt]:
    """Yield all statements, those inside others too; expressions hold none, and are most of a tree."""
    for kind in ("body", "orelse", "finalbody", "handlers", "cases"):
        for node in getattr(tree, kind, ()):
            if isinstance(node, ast.stmt):
                yield node
            yield from statements(node)


def imports(tree: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """Yield the imports that run, late ones too; those for type checkers alone do not."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.expr) or (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"):
            continue
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield node
        else:
            yield from imports(node)


@cache
def imports_of(module: str) -> tuple[ast.Import | ast.ImportFrom, ...]:
    return tuple(imports(modules()[module]))


@cache
def offered(package: str) -> dict[str, str]:
    """Return the names that a package offers to others, and the module that each is from."""
    stub = ROOT.joinpath(*package.split(".")[1:], "__init__.pyi")
    body = ast.parse(stub.read_text(encoding="utf-8")).body if stub.exists() else []
    return {
        one.name: f"{package}.{node.module}" if node.module else f"{package}.{one.name}"
        for node in body
        if isinstance(node, ast.ImportFrom)
        for one in node.names
    }


@cache
def home(module: str, name: str) -> str:
    """Return the module that a name is from, through the fronts of packages; "" for one of another package."""
    if name in offered(module):
        return offered(module)[name]
    if f"{module}.{name}" in modules():
        return f"{module}.{name}"
    for node in imports_of(module) if module in modules() else ():
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("symdyn"):
            for alias in node.names:
                if (alias.asname or alias.name) == name and (node.module, alias.name) != (module, name):
                    return home(node.module, alias.name)
    return module if module in modules() else ""


@cache
def arrows() -> dict[str, set[str]]:
    """Return the modules that each module imports, itself left out."""
    found: dict[str, set[str]] = {}
    for module in modules():
        targets = set()
        for node in imports_of(module):
            if isinstance(node, ast.ImportFrom) and node.module:
                targets |= {home(node.module, alias.name) for alias in node.names}
            elif isinstance(node, ast.Import):
                targets |= {alias.name for alias in node.names if alias.name in modules()}
        found[module] = targets - {"", module}
    return found


def test_every_import_points_down() -> None:
    wrong = []
    for module, targets in arrows().items():
        package = module.split(".")[1] if "." in module else ""
        if package not in ("", "__main__"):
            wrong += [f"{module} imports {target}" for target in targets if target.split(".")[1] not in below(package)]

    assert not wrong, "\n".join(wrong)


def at_once(tree: ast.Module) -> Iterator[ast.Import | ast.ImportFrom]:
    """Yield the imports that run when a module is imported."""
    late = {node for one in statements(tree) if isinstance(one, ast.FunctionDef) for node in imports(one)}
    yield from (node for node in imports(tree) if node not in late)


@pytest.mark.long(0)
def test_what_does_without_an_extra_imports_nothing_that_needs_it() -> None:
    needs: dict[str, set[str]] = {}
    targets: dict[str, set[str]] = {}
    for module, tree in modules().items():
        found = list(at_once(tree))
        names = {
            (node.module or "" if isinstance(node, ast.ImportFrom) else node.names[0].name).partition(".")[0]
            for node in found
        }
        needs[module] = names & EXTRAS
        targets[module] = {
            home(node.module or "", alias.name)
            for node in found
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }
    wrong = [
        f"{module} imports {target}, which needs {', '.join(more)}"
        for module in targets
        for target in targets[module] - {""}
        if (more := needs[target] - needs[module])
    ]

    assert not wrong, "\n".join(wrong)


def by_name(tree: ast.Module) -> Iterator[str]:
    """Yield our modules that texts of a file name, as `import_module` takes them, f-strings by their beginning."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and NAMED.match(node.value):
            yield node.value


def test_no_module_is_imported_by_a_name_that_points_up() -> None:
    wrong = []
    for module, tree in modules().items():
        package = module.split(".")[1] if "." in module else ""
        if package not in ("", "__main__"):
            wrong += [f"{module} names {one}" for one in by_name(tree) if one.split(".")[1] not in below(package)]

    assert not wrong, "\n".join(wrong)


def test_every_package_is_in_the_table() -> None:
    packages = {p.name.removesuffix(".py") for p in ROOT.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}

    assert packages - {"__init__", "__main__"} == set(PACKAGES)


def test_no_package_has_the_name_of_a_function() -> None:
    assert not set(PACKAGES) & set(symdyn.__all__)


def folder(module: str) -> tuple[str, str]:
    """Return package and folder of a file, which a folder's front page belongs to; "" is the package's own."""
    _, package, *rest = module.split(".")
    deep = len(rest) > 1 or (rest and any(one.startswith(f"{module}.") for one in modules()))
    return package, rest[0] if deep else ""


def test_folders_inside_packages_import_downwards() -> None:
    wrong = []
    for module, targets in arrows().items():
        for target in targets:
            if module.count(".") < 2 or target.count(".") < 2:
                continue  # a front page says what is behind it
            (package, mine), (other, theirs) = folder(module), folder(target)
            if package == other and package in FOLDERS and mine != theirs and theirs not in FOLDERS[package][mine]:
                wrong.append(f"{module} imports {target}")

    assert not wrong, "\n".join(wrong)


def test_every_folder_is_in_the_table() -> None:
    for package, folders in FOLDERS.items():
        found = {path.name for path in (ROOT / package).iterdir() if (path / "__init__.py").exists()}

        assert found == set(folders) - {""}, package


def test_no_files_import_each_other_in_a_circle() -> None:
    left = {module: set(targets) for module, targets in arrows().items() if module != "symdyn"}
    while True:
        used = set().union(*left.values())
        inner = {module: targets & left.keys() for module, targets in left.items() if module in used}
        inner = {module: targets for module, targets in inner.items() if targets}
        if inner == left:
            break
        left = inner

    assert not left, "\n".join(f"{module} imports {', '.join(sorted(targets))}" for module, targets in left.items())


def bound(module: ast.Module) -> Iterator[str]:
    """Yield the names that a module's own statements give a value, a function or a class."""
    for node in module.body:
        if isinstance(node, ast.Assign):
            names = (name for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name))
            yield from (name.id for name in names if isinstance(name.ctx, ast.Store))  # not that of Number.ZERO = …
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            yield ast.unparse(node.target)
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.decorator_list:  # overloads have one
            yield node.name


def test_no_name_of_a_module_is_bound_twice() -> None:
    """A constant that another of the same name hides further down is a fault that no other tool tells."""
    for module, tree in modules().items():
        twice = [name for name, count in Counter(bound(tree)).items() if count > 1]

        assert not twice, f"{module}: {twice}"


def test_the_picture_of_the_packages_is_that_of_the_table() -> None:
    assert PICTURE.read_text(encoding="utf-8") == picture(), "python tests/packages_picture.py draws it again"


def test_what_reads_files_knows_nothing_of_what_writes_them() -> None:
    """A proof by the printer's own tables would prove its faults along with it."""
    package = {module for module in modules() if module.startswith("symdyn.verify.written")}
    reached, fresh = set(package), set(package)
    while fresh:
        fresh = set().union(*(arrows()[module] for module in fresh if module in arrows())) - reached
        reached |= fresh

    assert not [module for module in sorted(reached) if module.startswith(("symdyn.emit", "symdyn.runtime"))]
