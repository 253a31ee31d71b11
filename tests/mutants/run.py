"""Which tests come by the line of which mutant, and what becomes of it when they run, the fastest first.

    nice -n 12 python -m tests.mutants reach -- --quick      adds to build/mutants/reach.txt; `pip install coverage`
    nice -n 12 python -m tests.mutants run --first 100       those of the first hundred that have no verdict yet
    nice -n 12 python -m tests.mutants run --again           those that live, after `reach` looked at more tests

A statement of a function is reached when one of its lines runs, all others when any line of their file does. A line of
the record is number, verdict, test or how many, seconds. Verdicts: killed; slow (tests come to no end); alive (no test
that reaches it fails); gone (there is no such line any more).
"""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Sequence
from itertools import accumulate
from pathlib import Path
from resource import RLIMIT_CPU, RLIMIT_DATA, setrlimit

from . import Mutant

FIRST = 12
"""Tests that are tried before the others that reach a line: most mutants fail many."""

ENOUGH = 10.0
"""Seconds of tests that a mutant may live through."""

PATIENCE, ROOM = 45, 8 * 2**30
"""Seconds of processor time, and bytes, that a process of tests may take with one mutant."""

NONE_RUN = 5
"""What pytest ends with where all that was asked for is left out."""

PLUGIN = """
import json, os, time, coverage, pytest
spans = json.loads(os.environ["SPANS"])
cover = coverage.Coverage(data_file=None, include=sorted({file for file, _, _ in spans.values()}))
@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    begin, failed = time.process_time(), item.session.testsfailed
    cover.erase()
    cover.start()
    result = yield
    cover.stop()
    data = cover.get_data()
    lines = {file: data.lines(file) or () for file in data.measured_files()}
    found = [n for n, (file, first, last) in spans.items() if any(first <= k <= last for k in lines.get(file, ()))]
    if found and item.session.testsfailed == failed:
        with open(os.environ["REACHED"], "a", encoding="utf-8") as out:
            out.write(f"{time.process_time() - begin:.3f}\\t{item.nodeid}\\t{' '.join(found)}\\n")
    return result
"""


def reach(tree: Path, mutants: Sequence[Mutant], words: Sequence[str], out: Path) -> None:
    """Run tests of a tree, and add to a file which of them come by what; those that fail tell nothing."""
    spans = {}
    for one in mutants:
        if (found := one.place(tree)) is not None:
            spans[one.number] = (str(found[0]), *statement(found[0].read_text(encoding="utf-8"), found[1] + 1))
    (tree / "reaching.py").write_text(PLUGIN, encoding="utf-8")
    out.parent.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "pytest", "-p", "reaching", "-p", "no:cacheprovider", *words]
    places = {
        "PYTHONPATH": f"{tree}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
        "REACHED": str(out.resolve()),
        "SPANS": json.dumps(spans),
    }
    subprocess.run(command, cwd=tree, env=os.environ | places, check=False)


def statement(source: str, line: int) -> tuple[int, int]:
    """Return first and last line of what stands on a line of a function, of the whole file if it stands in none."""
    found = (1, len(source.splitlines()))
    for function in ast.walk(ast.parse(source)):
        if isinstance(function, ast.FunctionDef):
            for node in ast.walk(function):
                if isinstance(node, ast.stmt | ast.ExceptHandler) and node is not function:
                    inner = [one.lineno - 1 for one in getattr(node, "body", ())]
                    last = max(node.lineno, min(inner, default=node.end_lineno or node.lineno))
                    if node.lineno <= line <= last:
                        found = (node.lineno, last)
    return found


def reached(path: Path) -> dict[int, list[str]]:
    """Return the tests that reach each mutant, the fastest first, as many as take long enough."""
    seconds: dict[int, dict[str, float]] = defaultdict(dict)
    for text in path.read_text(encoding="utf-8").splitlines():
        took, test, numbers = text.split("\t")
        for number in numbers.split():
            seconds[int(number)][test] = float(took)
    found: dict[int, list[str]] = {}
    for one, tests in seconds.items():
        before = accumulate(sorted(tests.values()), initial=0.0)
        found[one] = [
            test for test, total in zip(sorted(tests, key=lambda x: tests[x]), before, strict=False) if total < ENOUGH
        ]
    return found


def judge(tree: Path, one: Mutant, tests: Sequence[str]) -> tuple[str, str]:
    """Return verdict and what tells it, of one mutant in a tree that is left as it was."""
    place = one.place(tree)
    if place is None:
        return "gone", "-"
    path, index = place
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    indent = lines[index][: len(lines[index]) - len(lines[index].lstrip())]
    lines[index] = f"{indent}{one.after}\n" if one.after else ""
    try:
        write(path, "".join(lines), one.number * 2 + 1)
        for words in (tests[:FIRST], tests[FIRST:]):
            if words and (found := run(tree, words)):
                return found
        return "alive", f"{len(tests)} tests"
    finally:
        write(path, text, one.number * 2)


def write(path: Path, text: str, moment: int) -> None:
    """Write a file with a time of its own: compiled files are told apart by seconds."""
    path.write_text(text, encoding="utf-8")
    os.utime(path, (1e9 + moment, 1e9 + moment))


def bound() -> None:
    """Bound what a process may take: a mutant may count to anything."""
    setrlimit(RLIMIT_CPU, (PATIENCE, PATIENCE))
    setrlimit(RLIMIT_DATA, (ROOM, ROOM))


def run(tree: Path, words: Sequence[str]) -> tuple[str, str] | None:
    """Return what found a mutant, None if all tests pass; by the clock, tests may take ten times their patience."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--tb=no", "-p", "no:cacheprovider", *words]
    try:
        done = subprocess.run(
            command, cwd=tree, env=os.environ | {"PYTHONPATH": str(tree)}, capture_output=True, text=True,
            timeout=10 * PATIENCE, check=False, preexec_fn=bound,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "slow", words[0]
    if done.returncode in (0, NONE_RUN):
        return None
    if done.returncode < 0:
        return "slow", words[0]
    named = [line.split(" ", 2)[1] for line in done.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return "killed", named[0] if named else "import"


def record(tree: Path, mutants: Sequence[Mutant], tests: dict[int, list[str]], path: Path, again: bool) -> None:
    """Judge mutants that tests reach and that have no verdict yet, or those that live, and write it down at once."""
    known = verdicts(path)
    for one in mutants:
        if one.number in tests and known.get(one.number) == ("alive" if again else None):
            begin = time.monotonic()
            verdict, told = judge(tree, one, tests[one.number])
            with path.open("a", encoding="utf-8") as out:
                out.write(f"{one.number}\t{verdict}\t{told}\t{time.monotonic() - begin:.0f}\n")


def verdicts(path: Path) -> dict[int, str]:
    """Return the last verdict of each mutant of a record."""
    if not path.exists():
        return {}
    rows = [line.split("\t") for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return {int(number): verdict for number, verdict, *_ in rows}
