"""What verbs take stands in one table, made of the functions behind them: it is up to date, light, and not too long."""

from __future__ import annotations

import subprocess
import sys
from functools import cache

import pytest
from options_table import TABLE, made, text
from patience import HANG
from test_fronts import BUDGETS

from symdyn.cli import VERBS
from symdyn.cli.options import groups

LIGHT = {"symdyn"} | {f"symdyn.{name}" for name in ("cli", "errors", "resources", "rounding", "shell", "shown")}
"""What is imported for help, beside the files of the command line that all verbs need."""

HEAVY = ("dataclasses", "fractions", "html", "inspect", "numpy", "rich", "threading")
"""What takes longer to import than help may take."""


def test_the_table_is_what_functions_say(update_golden: bool) -> None:
    """`make golden` writes it anew."""
    if update_golden:
        TABLE.write_text(text(made()), encoding="utf-8")

    assert TABLE.read_text(encoding="utf-8") == text(made())


@pytest.mark.wide(4)
@pytest.mark.runs
@pytest.mark.parametrize("words", [["simulate", "--nothing"], *([verb, "--help"] for verb in VERBS), ["--help"]])
def test_help_and_messages_of_usage_import_nothing_heavy(words: list[str]) -> None:
    script = (
        "import sys\n"
        "before = set(sys.modules)\n"
        "from symdyn.cli import main\n"
        "try:\n    main(sys.argv[1:])\n"
        "except SystemExit: print('\\n--', *sorted(set(sys.modules) - before))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *words], capture_output=True, text=True, timeout=HANG, check=True
    )
    found = set(done.stdout.splitlines()[-1].split()[1:])

    assert {name for name in found if name.startswith("symdyn")} <= LIGHT | {"symdyn.cli.options", "symdyn.cli.talk"}
    assert found.isdisjoint(HEAVY)


@cache
def users() -> dict[str, set[str]]:
    """Return the verbs that take each group of options."""
    found: dict[str, set[str]] = {verb: {verb} for verb in VERBS}
    for name in (*VERBS, *groups()):  # a group comes behind the verbs, and may hold others
        for one in groups()[name]["options"]:
            if isinstance(one, str):
                found.setdefault(one, set()).update(found.get(name, ()))
    return found


def own(verb: str) -> list[str]:
    """Return the options that a verb alone takes: no places, none that verbs share, and no file that it writes."""
    options = [one for name, verbs in users().items() if verbs == {verb} for one in groups()[name]["options"]]
    flags = [one[0][-1] for one in options if not isinstance(one, str)]
    return [flag for flag in flags if flag.startswith("--") and flag != "--output"]


@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_has_few_options_of_its_own(verb: str) -> None:
    """Whoever wants one more says it by a word of one that is there."""
    most = BUDGETS["flags"].get(verb, BUDGETS["flags"]["most"])

    assert len(own(verb)) <= most, own(verb)
