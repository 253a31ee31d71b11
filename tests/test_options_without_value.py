"""No option of any verb takes `--` as its value: argparse would drop it and leave a list of nothing."""

from __future__ import annotations

import pytest
from options_changed import options_of

from symdyn.cli import VERBS, main


@pytest.mark.parametrize("verb", VERBS)
def test_two_strokes_are_no_value_of_any_option(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    for option in sorted(options_of(verb)):
        with pytest.raises(SystemExit) as ended:
            main([verb, f"{option}=--"])
        assert ended.value.code == 2
        assert f"{option}=--: -- is no value" in capsys.readouterr().err
