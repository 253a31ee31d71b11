"""No option of any verb, given a second time, forgets in silence what it was given first."""

from __future__ import annotations

import pytest
from options_changed import actions_of

from symdyn.cli import VERBS, VerbParser


def parsed(verb: str, words: list[str]) -> object:
    needed = [one for one in actions_of(verb) if one.required and not {*one.option_strings} & {*words}]
    before = [one.choices[0] if one.choices else "1" for one in needed if one.nargs is None]  # type: ignore[index]
    options = [option for one in needed for option in one.option_strings[:1]]
    return VerbParser(prog=f"symdyn {verb}").parse_known_args([*options, *before, *words])[0]


@pytest.mark.parametrize("verb", VERBS)
def test_an_option_given_twice_holds_both_or_is_refused(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    for action in [one for one in actions_of(verb) if one.option_strings and one.nargs != 0]:
        option = action.option_strings[-1]
        values = ("html", "md") if (verb, option) == ("walkthrough", "--format") else ("1", "2")
        values = (str(action.choices[0]),) * 2 if action.choices else values
        words = [word for value in values for word in (option, value)]
        if "LIST" in str(action.metavar) or action.nargs in ("+", "*") or "_Append" in type(action).__name__:
            held = str(getattr(parsed(verb, words), action.dest))
            assert all(value in held for value in values), option
        else:
            with pytest.raises(SystemExit):
                parsed(verb, words)
            assert f"{option} is given twice: {values[0]} and {values[1]}; give one" in capsys.readouterr().err


def test_sizes_without_a_value_are_given_once_too(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        parsed("generate", ["--stack", "--stack"])
    assert "--stack is given twice; give one" in capsys.readouterr().err
