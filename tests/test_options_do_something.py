"""An option of a verb that is read does something: the answer, what is said of it, files or the status are others."""

from __future__ import annotations

from pathlib import Path

import pytest
from options_changed import ELSEWHERE, NOTHING, TRIED, lines, options_of, outcome

SHARE = 33
"""Of so many options one is tried always."""

VALUES = {"--digits": "2", "--quiet": ""}

ROWS = [(verb, option) for verb, one in TRIED.items() for option in one.options]


@pytest.mark.parametrize("verb", TRIED)
def test_every_option_has_a_row_or_a_reason(verb: str) -> None:
    elsewhere = [option for one, option in ELSEWHERE if one == verb]
    nothing = [option for option, verbs in NOTHING.items() if verb in verbs]
    assert sorted([*TRIED[verb].options, *elsewhere, *nothing]) == sorted(options_of(verb))


@pytest.mark.parametrize("test", sorted({*ELSEWHERE.values()}))
def test_another_test_of_an_option_is_there(test: str) -> None:
    assert (Path(__file__).parent.parent / test.rsplit(maxsplit=1)[-1]).is_file()


def check(verb: str, option: str, folder: Path) -> None:
    without, given = lines(verb, option)
    called = ((without, "1"), (without, "again"), (given, "2"))
    first, again, second = (outcome(line, folder / name, TRIED[verb].before) for line, name in called)
    assert first == again, f"{without}: differs each time"
    assert 0 in (first[0], second[0]), second[2]
    assert first != second, f"{given}: nothing differs from {without}"


@pytest.mark.heavy("--digits-doctor", "--quiet-doctor")
@pytest.mark.long(0)
@pytest.mark.runs("cc")
@pytest.mark.parametrize(("option", "verb"), [(option, verb) for option, verbs in NOTHING.items() for verb in verbs])
def test_an_option_that_has_nothing_to_do_changes_nothing(option: str, verb: str, tmp_path: Path) -> None:
    line = " ".join([verb, TRIED[verb].line])
    first, second = (
        outcome(one, tmp_path / name) for one, name in ((line, "1"), (f"{line} {option} {VALUES[option]}", "2"))
    )
    assert first == second


@pytest.mark.heavy("bench---no-snap")
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
