"""Every option of every verb with a value that is not the usual one: another answer, other files, or another status.

A row is what stands before an option, and its value; rows are in `options_tried.py` and `options_of_checks.py`.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import re
from itertools import dropwhile, takewhile
from pathlib import Path

from options_of_checks import CHECKED, ELSEWHERE, NOTHING
from options_tried import MOVED, Verb

from symdyn.cli import VERBS, VerbParser, main

TRIED: dict[str, Verb] = {**MOVED, **CHECKED}

__all__ = ["ELSEWHERE", "NOTHING", "TRIED", "lines", "options_of", "outcome"]


def options_of(verb: str, valued: bool = False) -> set[str]:
    """Return all options that a verb takes, by their long names; or those that have a value."""
    return {one.option_strings[-1] for one in actions_of(verb) if one.option_strings and (one.nargs != 0 or not valued)}


def actions_of(verb: str) -> list[argparse.Action]:
    """Return all that a verb takes, but for --help."""
    return [one for one in VerbParser(prog=f"symdyn {verb}").made._actions if one.dest != "help"]


def outcome(line: str, folder: Path, before: tuple[str, ...] = ()) -> tuple[int, str, str, dict[str, bytes]]:
    """Return status, answer, what is said beside it and files of a line, after others in the same folder, timeless."""
    folder.mkdir()
    told, said, here = io.StringIO(), io.StringIO(), Path.cwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(said):
            for one in before:
                main(one.split())
            told.truncate(told.seek(0))
            said.truncate(said.seek(0))
            status = main(line.split())
    except SystemExit as ended:
        status = int(str(ended.code))
    finally:
        os.chdir(here)
    timed = line.startswith("bench ")
    files = {
        str(path.relative_to(folder)): b""
        if timed
        else re.sub(rb"symdyn [^\n]*", b"", path.read_bytes())  # the command
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    if status == 2 and "\nsee: symdyn" in said.getvalue():
        raise AssertionError(f"{line}: {said.getvalue()[-300:]}")
    return status, (_measured if timed else _timeless)(told.getvalue()), _timeless(said.getvalue()), files


def _timeless(text: str) -> str:
    """Return what is told without times and what the cache holds, which are others each time."""
    text = re.sub(r"\d+ files, [\d.]+ \w+ *|\"(entries|bytes)\": \d+", "", text)
    return re.sub(r"[\d.e-]+ s(?= to prepare|, )", "", text)


def _measured(text: str) -> str:
    """Return what `bench` tells but for times, and what depends on them: of a table its title."""
    if not text.startswith("{"):
        return text.partition("\n")[0].strip()
    told = json.loads(text)
    result = told["result"] or {"measured": (), "motion": None}
    measured = [
        {name: one[name] for name in ("function", "variant", "real", "formulation", "operations", "relative", "errors")}
        for one in result["measured"]
    ]
    precise = None if result["motion"] is None else sorted(result["motion"])
    return json.dumps([told["errors"], measured, precise])


def lines(verb: str, option: str) -> tuple[str, str]:
    """Return command lines without an option and with it."""
    one = TRIED[verb]
    value, _, beside = (part.strip() for part in one.options[option].partition("|"))
    usual, words = one.line.split(), beside.split()
    files = [*takewhile(lambda word: not word.startswith("-"), words)]
    files = files or [*takewhile(lambda word: not word.startswith("-"), usual)]
    options = [*dropwhile(lambda word: not word.startswith("-"), words)]
    rest = [*dropwhile(lambda word: not word.startswith("-"), usual)]
    plain = [verb, *files, *_without(rest, [*options, *[option] * (not value)]), *options]
    return " ".join(plain), " ".join([*_without(plain, [option]), option, value]).strip()


def _without(words: list[str], options: list[str]) -> list[str]:
    """Return words without options that are said again, and their values."""
    found: list[str] = []
    skip = False
    for word in words:
        named = {"-o": "--output"}.get(word, word)
        if skip and not word.startswith("-"):
            skip = False
            continue
        skip = named.startswith("--") and not {word, named}.isdisjoint(options)
        if not skip:
            found.append(word)
    return found


assert set(TRIED) == set(VERBS)
