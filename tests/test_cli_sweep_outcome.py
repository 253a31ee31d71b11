"""`symdyn sweep` tells what came of it: Sobol's indices, error bars to first order, pictures."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from symdyn.cli import main

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long]

PENDULUM = [
    "sweep",
    "examples/pendulum.toml",
    "--until",
    "0.5",
    "--over",
    "q1=normal(0.5,0.01)",
    "--over",
    "l=normal(0.5,0.01)",
]


def test_first_order_stands_beside_the_runs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "found.svg"
    asked = [
        "--measure",
        "end(q1)",
        "--measure",
        "top=max(q1_dot)",
        "--count",
        "200",
        "--first-order",
        "--plot",
        str(file),
    ]
    assert main([*PENDULUM, *asked, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["result"]

    told = found["first_order"]["end(q1)"]
    assert told["near"]
    assert told["runs"] == pytest.approx(told["first_order"], rel=0.2)
    assert sum(told["shares"].values()) == pytest.approx(1)
    assert set(found["first_order"]) == {"end(q1)", "top"}
    assert file.read_text(encoding="utf-8").startswith("<?xml")
    assert main([*PENDULUM, *asked]) == 0
    assert "variance is due to" in capsys.readouterr().out


def test_it_is_said_where_first_order_is_not_what_runs_do(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--measure", "end(q1)**2", "--count", "200", "--first-order", "--start-rates", "q1=0"]
    assert main(["sweep", "examples/pendulum.toml", "--until", "0.5", "--over", "q1=normal(0,0.1)", *asked]) == 0
    assert "it is not linear over what varies; trust the runs" in capsys.readouterr().err


def test_indices_are_told_for_their_design(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*PENDULUM, "--measure", "end(q1)", "--design", "saltelli", "--count", "8"]) == 0
    assert "Sobol's indices" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (["--plot", "found.bmp"], "plots are written to .svg, .pdf, .png, .html files"),
        (["--plot-kind", "heat"], "of --plot FILE, which is not given"),
        (["--plot", "found.svg", "--plot-kind", "heet"], "did you mean heat"),
        (["--first-order", "--function", "inverse_dynamics"], "--function makes none"),
    ],
)
def test_what_could_not_be_told_is_refused_before_any_run(
    asked: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*PENDULUM, "--measure", "end(q1)", *asked]) == 1
    assert words in capsys.readouterr().err
