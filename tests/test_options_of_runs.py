"""Every option of `simulate` does something: with it and without it something that is told or computed differs."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

import pytest

from symdyn.cli import main
from symdyn.cli.options import add_options

pytestmark = pytest.mark.runs()

SCENE = """
name = "block"
gravity = "none"
parameters = { m = 2 }
[bodies.block]
mass = "m"
[joints.slide]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
start = 0.5
start_rates = -1
limits = { lower = -5 }
[springs.s]
joint = "slide"
stiffness = 300
"""

FED = "--feedback gains.json"
FILM = "--animate film.svg"

CASES = {  # option: what stands beside it, without it and with it
    "until": ("", "--until 0.2", "--until 0.3"),
    "forces": ("", "", "--forces F=1"),
    "feedback": ("", "", FED),
    "period": (FED, "", "--period 0.01"),
    "delay": (f"{FED} --period 0.01", "", "--delay 0.01"),
    "limits": (FED, "", "--limits F=1e6"),
    "start": ("", "", "--start x=0.4"),
    "start_rates": ("", "", "--start-rates x=2"),
    "stop": ("", "", "--stop x-0.45"),
    "report": ("", "", "--report x-0.45"),
    "ignore_limits": ("--start-rates x=-100", "", "--ignore-limits"),
    "method": ("", "--method dop853", "--method rk45"),
    "rtol": ("--method dop853", "", "--rtol 1e-5"),
    "atol": ("--method dop853", "", "--atol 1e-5"),
    "every": ("", "", "--every 0.1"),
    "reactions": ("", "", "--reactions"),
    "output": ("", "", "-o run.csv"),
    "plot": ("", "", "--plot run.svg --plot-columns x"),
    "plot_columns": ("--plot run.svg", "--plot-columns x", "--plot-columns x_dot"),
    "animate": ("", "", FILM),
    "fps": (FILM, "", "--fps 10"),
    "size": (FILM, "", "--size 400"),
    "once": (FILM, "", "--once"),
    "bind": ("", "", "--bind m=3"),
    "no_units": ("--stop x-x_dot", "", "--no-units"),
}

READING = {
    "json",
    "quiet",
    "digits",
    "symbolic",
    "snap",
    "allow_invalid_inertia",
    "spanning_tree",
    "floating_base",
    "scene",
    "help",
}
"""Options of all verbs, and of those that read a scene, most of them about robot files."""


def answer(words: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[object, ...]:
    """Return all that a command tells and writes, but for how long it took."""
    for old in folder.glob("[rf]*.*"):
        old.unlink()
    status = main(["simulate", "block.toml", *words.split()])
    told = capsys.readouterr()
    said = re.sub(r"[\d.e-]+ s(?= to prepare|, [\d.e-]+ s to prepare)", "", told.err)
    files = {one.name: one.read_bytes() for one in sorted(folder.glob("[rf]*.*"))}
    return status, told.out, said, files


def test_every_option_has_a_case() -> None:
    verb = argparse.ArgumentParser()
    add_options(verb, "simulate")

    assert {one.dest for one in verb._actions} == {*CASES, *READING}


@pytest.mark.parametrize("option", CASES)
def test_an_option_changes_what_is_told(
    option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("block.toml").write_text(SCENE, encoding="utf-8")
    Path("gains.json").write_text(json.dumps({"K": [[9, 4]], "states": ["x", "x_dot"], "inputs": ["F"]}))
    beside, without, with_it = CASES[option]
    usual = "" if option == "until" else "--until 0.2"
    usual += "" if option == "method" or "--method" in beside else " --method dop853"

    first, other = (answer(f"{usual} {beside} {one}", tmp_path, capsys) for one in (without, with_it))

    assert first != other
    if option in ("forces", "animate"):
        assert other == answer(f"{usual} {beside} {with_it}", tmp_path, capsys), "else anything would do"


@pytest.mark.mends("30.class.ignored")
def test_limits_that_are_not_there_cannot_be_ignored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("block.toml").write_text(SCENE.replace("limits = { lower = -5 }", "limits = { velocity = 9 }"))

    told = answer("--until 0.1 --method dop853 --ignore-limits", tmp_path, capsys)[2]
    usual = answer("--until 0.1 --method dop853", tmp_path, capsys)[2]

    assert told != usual
    assert "no joint of block has a limit of its position" in str(told)
