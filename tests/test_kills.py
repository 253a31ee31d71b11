"""Killed at any moment, a verb leaves no half file, a cache that works, and nothing that grows."""

from __future__ import annotations

import os

import pytest
from kills import VERBS, kills

pytestmark = [pytest.mark.runs("cc"), pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")]


def whole(verb: str, times: int) -> None:
    found = kills(verb, times)
    assert found.halves == ()
    assert found.behind == ()
    assert verb == "load" or found.tracebacks == ()  # a script of the user's shows its own
    assert "again" not in found.talk


def test_a_load_that_is_killed_spoils_nothing():
    whole("load", 2)


@pytest.mark.slow
@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_that_is_killed_spoils_nothing(verb):
    whole(verb, 100)
