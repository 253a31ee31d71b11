"""Units on the command line: times, limits, and forces of inputs that their scene has in another unit than SI's."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from test_values_with_units import PENDULUM, RUNS

from symdyn.cli import main

TIMES = [
    ("simulate", "--until", "--every", "--period", "--delay"),
    ("inverse", "--until", "--every"),
    ("sweep", "--until", "--every"),
    ("identify", "--period", "--every"),
    ("linearize", "--dt"),
]


@pytest.mark.parametrize(("verb", "option"), [(verb, option) for verb, *options in TIMES for option in options])
def test_a_time_on_a_command_line_may_say_its_unit(verb: str, option: str, capsys: pytest.CaptureFixture[str]) -> None:
    from symdyn.cli import parser

    always = ["--until", "9"] if verb == "simulate" and option != "--until" else []

    def read(text: str) -> object:
        return getattr(parser().parse_args([verb, "p.toml", *always, option, text]), option.removeprefix("--"))

    assert [read(text) for text in ("0.1", "100 ms", "100ms", "1 min", "1/4", "1e-3 s")] == [
        0.1,
        0.1,
        0.1,
        60,
        0.25,
        1e-3,
    ]
    for text, words in (
        ("3 mm", "3 mm is in mm, and s is asked for"),
        ("3 Hz", "3 Hz is in Hz, and s is asked for"),
        ("soon", "soon is no number"),
        ("3 furlongz", "furlongz is no unit"),
    ):
        with pytest.raises(SystemExit):
            read(text)
        assert words in capsys.readouterr().err


MOTOR = 'force = "2*V"\n[inputs]\nV = { value = 20, unit = "mV" }'


@RUNS
def test_a_limit_in_bare_numbers_of_an_input_that_is_not_in_si_is_asked_about(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "p.toml").write_text(PENDULUM.format(m=1, l="1", more=MOTOR))
    gains = {"K": [[1, 1]], "states": ["phi", "phi_dot"], "inputs": ["V"], "x0": {"phi": 0}, "u0": {"V": 0}}
    (tmp_path / "k.json").write_text(json.dumps(gains))
    words = ["simulate", str(tmp_path / "p.toml"), "--until", "0.1", "--feedback", str(tmp_path / "k.json")]

    assert main([*words, "--limits", "V=20"]) == 1
    assert "--limits: V is given in mV: write V=20mV or V=20V" in capsys.readouterr().err
    main([*words, "--limits", "V=20mV"])
    assert "say V=" not in capsys.readouterr().err


@RUNS
@pytest.mark.parametrize(
    ("force", "noted"), [("V=20*sin(3*t)", True), ("V=20 mV", False), ("tau1=20*sin(3*t)", False), ("V=0", False)]
)
def test_a_formula_for_an_input_that_is_not_in_si_is_noted_to_be_in_si(
    force: str, noted: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "p.toml").write_text(PENDULUM.format(m=1, l="1", more=MOTOR))

    assert main(["simulate", str(tmp_path / "p.toml"), "--until", "0.1", "--forces", force]) == 0
    assert ("V is in V here, its file says mV" in capsys.readouterr().err) == noted
