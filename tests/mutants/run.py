"""Plant mutants one at a time, and run the tests that reach them, the fastest first.

    nice -n 19 python -m tests.mutants run --first 100       those of the first hundred that have no verdict yet
    nice -n 19 python -m tests.mutants run --whole           what was not found by then, against all tests

A line of the record is number, verdict, test or word, seconds. Verdicts: killed; slow (what ran before came to no end);
alive (no test that reaches it fails), survived (nor does any other); gone (there is no such line any more).
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from resource import RLIMIT_CPU, setrlimit

from . import Mutant

FIRST = 12
"""Tests that are tried before the others that reach a line: most mutants fail many."""

PATIENCE = 120
"""Seconds of processor time that a process of tests may take with one mutant; of which a whole run takes more."""


def judge(tree: Path, one: Mutant, tests: Sequence[str], whole: bool) -> tuple[str, str]:
    """Return verdict and what tells it, of one mutant in a tree that is left as it was.

    What no test reaches is left to the whole suite.
    """
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
        if whole:
            return run(tree, ["-n", "auto", "--maxprocesses", "4"], 10 * PATIENCE) or ("survived", "all")
        for words in (tests[:FIRST], tests[FIRST:]):
            if words and (found := run(tree, words, PATIENCE)):
                return found
        return "alive", f"{len(tests)} tests"
    finally:
        write(path, text, one.number * 2)


def write(path: Path, text: str, moment: int) -> None:
    """Write a file with a time of its own: compiled files are told apart by seconds."""
    path.write_text(text, encoding="utf-8")
    os.utime(path, (1e9 + moment, 1e9 + moment))


def run(tree: Path, words: Sequence[str], patience: int) -> tuple[str, str] | None:
    """Return what found a mutant, None if all tests pass; by the clock, tests may take ten times their patience."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--tb=no", "-p", "no:cacheprovider", *words]
    try:
        done = subprocess.run(
            command, cwd=tree, env=os.environ | {"PYTHONPATH": str(tree)}, capture_output=True, text=True,
            timeout=10 * patience, check=False, preexec_fn=partial(setrlimit, RLIMIT_CPU, (patience, patience)),
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "slow", words[0]
    if done.returncode == 0:
        return None
    if done.returncode < 0:
        return "slow", words[0]
    named = [line.split(" ", 2)[1] for line in done.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return "killed", named[0] if named else "import"


def record(tree: Path, mutants: Sequence[Mutant], tests: dict[int, list[str]], path: Path, whole: bool) -> None:
    """Judge mutants that have no verdict yet, or no last one, and write it down at once."""
    known = verdicts(path)
    for one in mutants:
        if known.get(one.number) == "alive" if whole else one.number not in known:
            begin = time.monotonic()
            verdict, told = judge(tree, one, tests.get(one.number, []), whole)
            with path.open("a", encoding="utf-8") as out:
                out.write(f"{one.number}\t{verdict}\t{told}\t{time.monotonic() - begin:.0f}\n")


def verdicts(path: Path) -> dict[int, str]:
    """Return the last verdict of each mutant of a record."""
    if not path.exists():
        return {}
    rows = [line.split("\t") for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return {int(number): verdict for number, verdict, *_ in rows}
