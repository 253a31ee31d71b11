"""Which tests reach the line of which mutant: a probe stands before each such line while tests run once.

    python -m tests.mutants reach -- --quick      writes build/mutants/reach.txt: seconds, test, numbers of mutants

A line of a function is reached when its statement begins, one in a lambda when that is called; what stands in neither
is reached by importing the file, and no test is better than another.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

from . import Mutant

PLUGIN = """
import os, time, pytest
import probes
@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    probes.found.clear()
    begin, failed = time.process_time(), item.session.testsfailed
    result = yield
    if item.session.testsfailed > failed:
        return result
    with open(os.environ["REACHED"], "a", encoding="utf-8") as out:
        numbers = " ".join(map(str, sorted(probes.found)))
        out.write(f"{time.process_time() - begin:.3f}\\t{item.nodeid}\\t{numbers}\\n")
    return result
"""


def reach(tree: Path, mutants: Sequence[Mutant], words: Sequence[str], out: Path) -> None:
    """Run tests in a copy of the tree, and write which of them reach what; those that fail tell nothing."""
    lines: dict[Path, dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
    for one in mutants:
        if (found := one.place(tree)) is not None:
            lines[found[0]][found[1] + 1].append(one.number)
    for path, numbers in lines.items():
        module = Probes(numbers).visit(ast.parse(path.read_text(encoding="utf-8")))
        at = next(k for k, node in enumerate(module.body) if not _stays_first(node))
        module.body.insert(at, ast.parse("from probes import reached as _reached").body[0])
        path.write_text(ast.unparse(ast.fix_missing_locations(module)), encoding="utf-8")
    (tree / "probes.py").write_text("found = set()\nreached = found.update\n", encoding="utf-8")
    (tree / "reaching.py").write_text(PLUGIN, encoding="utf-8")
    out.parent.mkdir(parents=True, exist_ok=True)
    out.unlink(missing_ok=True)
    command = [sys.executable, "-m", "pytest", "-p", "reaching", "-p", "no:cacheprovider", *words]
    places = {"PYTHONPATH": str(tree), "REACHED": str(out.resolve())}
    subprocess.run(command, cwd=tree, env=os.environ | places, check=False)


def _stays_first(node: ast.stmt) -> bool:
    text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return text or (isinstance(node, ast.ImportFrom) and node.module == "__future__")


class Probes(ast.NodeTransformer):
    """Put a probe before each statement of a function, and into each lambda, that has a mutant in its own lines."""

    def __init__(self, lines: dict[int, list[int]]) -> None:
        self.lines = lines
        self.depth = 0

    def probe(self, begin: int, end: int) -> ast.expr | None:
        numbers = [n for line in range(begin, end + 1) for n in self.lines.get(line, ())]
        return ast.parse(f"_reached({numbers})", mode="eval").body if numbers else None

    def generic_visit(self, node: ast.AST) -> ast.AST:
        self.depth += isinstance(node, ast.FunctionDef)
        super().generic_visit(node)
        for name in ("body", "orelse", "finalbody"):
            block = getattr(node, name, None)
            if self.depth and isinstance(block, list):
                setattr(node, name, [new for old in block for new in self.probed(old)])
        self.depth -= isinstance(node, ast.FunctionDef)
        return node

    def probed(self, node: ast.stmt) -> list[ast.stmt]:
        inner = [
            one.lineno for name in ("body", "cases") for one in getattr(node, name, ())[:1] if hasattr(one, "lineno")
        ]
        found = self.probe(node.lineno, max(node.lineno, inner[0] - 1) if inner else node.end_lineno or node.lineno)
        return [ast.Expr(found), node] if found else [node]

    def visit_Lambda(self, node: ast.Lambda) -> ast.AST:
        found = self.probe(node.lineno, node.end_lineno or node.lineno)
        self.generic_visit(node)
        if found:
            node.body = ast.Subscript(ast.Tuple([found, node.body], ast.Load()), ast.Constant(1), ast.Load())
        return node


def reached(path: Path) -> dict[int, list[str]]:
    """Return the tests that reach each mutant, the fastest first."""
    tests: dict[int, list[str]] = defaultdict(list)
    rows = [line.split("\t") for line in path.read_text(encoding="utf-8").splitlines()]
    for _, test, numbers in sorted(rows, key=lambda row: float(row[0])):
        for number in numbers.split():
            tests[int(number)].append(test)
    return tests
