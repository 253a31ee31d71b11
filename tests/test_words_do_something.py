"""A word of a scene that is read does something: with another value something else is computed, or told."""

from __future__ import annotations

import pytest
from words_changed import ONLY_TOLD, SILENT, every, known, scenes, section_of
from words_looked_at import COMPUTED, differs

SHARE = 33
"""Of so many words one is tried always."""

ROWS = every()


def test_every_word_has_a_row_or_a_reason() -> None:
    links = {f"dh/links/{word.partition('/')[2]}" for word in SILENT if word.startswith(("joints", "bodies"))}
    silent = {*SILENT, *links, "dh/links/pitch", "dh/links/first_moment"}  # read by the readers of joints and bodies
    rows = {section_of(one) for one in ROWS}
    untold = sorted(known() - rows - silent - {"loop/steps/rpy", "loop/steps/xyz"})
    assert untold == [], "add a row for each to WORDS in tests/words_changed.py, of a loop too, or a reason to SILENT"
    assert sorted(rows - known()) == [], "WORDS in tests/words_changed.py has rows of words that no scene has"


def check(place: int) -> None:
    word, looked = section_of(ROWS[place]), differs(scenes(ROWS[place]))
    assert looked, f"{word}: nothing that is computed or told depends on it"
    told = any(word == one or word.startswith(f"{one}/") for one in ONLY_TOLD)
    assert told or looked in COMPUTED, f"{word}: {looked} alone depends on it"


@pytest.mark.long(0)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("place", range(4, len(ROWS), SHARE))
def test_another_value_of_a_word_changes_something(place: int) -> None:
    check(place)


@pytest.mark.slow
@pytest.mark.runs("cc")
@pytest.mark.parametrize("place", range(len(ROWS)), ids=lambda place: "-".join(ROWS[place][0]))
def test_another_value_of_any_word_changes_something(place: int) -> None:
    check(place)


@pytest.mark.mends("30.class.ignored")
@pytest.mark.runs("cc")
def test_a_unit_changes_what_is_computed() -> None:
    row = next(one for one in ROWS if one[0] == ("parameters", "k", "unit"))
    assert differs(scenes(row)) in COMPUTED
