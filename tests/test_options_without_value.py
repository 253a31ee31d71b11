"""No option of any verb takes `--`, which argparse would drop, or "" as its value, of which nothing would come."""

from __future__ import annotations

import pytest
from options_changed import options_of

from symdyn.cli import EMPTY, VERBS, main


@pytest.mark.parametrize("verb", VERBS)
def test_two_strokes_are_no_value_of_any_option(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    for option in sorted(options_of(verb)):
        with pytest.raises(SystemExit) as ended:
            main([verb, f"{option}=--"])
        assert ended.value.code == 2
        assert f"{option}=--: -- is no value" in capsys.readouterr().err


@pytest.mark.parametrize("verb", VERBS)
def test_an_empty_text_is_refused_where_help_does_not_say_what_it_means(
    verb: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for option in sorted(options_of(verb, valued=True)):
        with pytest.raises(SystemExit) as ended:
            main([verb, option, " ", "--help"])
        told = capsys.readouterr()
        meant = option.removeprefix("--") in EMPTY
        assert (ended.value.code, f"{option}: is empty" in told.err) == ((0, False) if meant else (2, True)), option
        assert not meant or f"{option} ''" in told.out, option


def test_inputs_are_no_option_and_it_is_said_what_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["linearize", "cart.toml", "--input", "tau"])
    assert "--input is no option; inputs are all drives and inputs of the scene" in capsys.readouterr().err
