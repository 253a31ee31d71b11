"""No test starts a process without saying so: what `make quick` runs needs nothing but Python."""

from __future__ import annotations

import os
import subprocess
import sys

import chosen
import programs
import pytest

from symdyn.runtime.compiler import CANDIDATES


def test_a_test_that_does_not_say_so_starts_no_process() -> None:
    for start in (
        lambda: subprocess.run(["cc", "--version"], check=False),
        lambda: subprocess.run([sys.executable, "--version"], check=False),
        lambda: os.system("true"),
        os.fork,
    ):
        with pytest.raises(AssertionError, match=r"is started: mark the test with @pytest\.mark\.runs"):
            start()


@pytest.mark.runs
def test_a_test_that_says_so_does() -> None:
    subprocess.run([sys.executable, "--version"], check=True, capture_output=True)


def test_the_compilers_of_tests_are_those_of_the_build() -> None:
    assert programs.PROGRAMS["cc"] == CANDIDATES


def test_a_quick_run_leaves_out_programs_and_takes_few_cases(request: pytest.FixtureRequest) -> None:
    if request.config.getoption("--quick"):
        assert not [item.nodeid for item in request.session.items if item.get_closest_marker("runs")]
        assert max(map(len, chosen.by_function(request.session.items).values())) == chosen.QUICK


def test_marks_name_cases_that_there_are(request: pytest.FixtureRequest) -> None:
    if not any("::" in word for word in request.config.args):
        assert request.config.stash[chosen.UNMET] == []


def test_every_mark_names_programs_of_the_table(request: pytest.FixtureRequest) -> None:
    marks = [mark for item in request.session.items for mark in item.iter_markers("runs")]

    assert {name for mark in marks for name in mark.args} <= set(programs.PROGRAMS)
