"""An option of a verb that is read does something: the answer, what is said of it, files or the status are others."""

from __future__ import annotations

from pathlib import Path

import pytest
from options_changed import ELSEWHERE, TRIED, lines, options_of, outcome

SHARE = 33
"""Of so many options one is tried always."""

ROWS = [(verb, option) for verb, one in TRIED.items() for option in one.options]


@pytest.mark.parametrize("verb", TRIED)
def test_every_option_has_a_row_or_a_reason(verb: str) -> None:
    assert options_of(verb) - {*TRIED[verb].options} - {*ELSEWHERE} == set()
    assert {*TRIED[verb].options} <= options_of(verb)


def check(verb: str, option: str, folder: Path) -> None:
    without, given = lines(verb, option)
    called = ((without, "1"), (without, "again"), (given, "2"))
    first, again, second = (outcome(line, folder / name, TRIED[verb].before) for line, name in called)
    assert first == again, f"{without}: differs each time"
    assert 0 in (first[0], second[0]), second[2]
    assert first != second, f"{given}: nothing differs from {without}"


@pytest.mark.long(0)
@pytest.mark.runs("cc")
@pytest.mark.parametrize(("verb", "option"), ROWS[5::SHARE])
def test_an_option_changes_something(verb: str, option: str, tmp_path: Path) -> None:
    check(verb, option, tmp_path)


@pytest.mark.slow
@pytest.mark.runs("cc")
@pytest.mark.parametrize(("verb", "option"), ROWS)
def test_any_option_changes_something(verb: str, option: str, tmp_path: Path) -> None:
    check(verb, option, tmp_path)
