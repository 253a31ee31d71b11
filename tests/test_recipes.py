"""What comes as one file from outside: nothing in symdyn knows its name, and everything works on it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from symdyn.scene.joints import JOINTS

RECIPES = Path(__file__).parent / "recipes"

NAMES = {
    "rack_and_pinion": "pinion",
    "gas_spring": "gas_spring",
    "fung_rope": "fung",
    "awk_target": "awk",
    "energy_integral": "energy_integral",
    "momentum_law": "momentum_law",
}
"""What is checked by `check_<name>.py`, and a word of it that symdyn does not hold."""


@pytest.mark.wide("momentum_law")
@pytest.mark.runs
@pytest.mark.parametrize("recipe", NAMES)
def test_a_new_row_is_one_file(recipe: str) -> None:
    """In a fresh process, so that no other test sees the row, nor the row another test."""
    checks = ["-m", "pytest", "-q", "-p", "no:cacheprovider", f"check_{recipe}.py"]
    done = subprocess.run([sys.executable, *checks], cwd=RECIPES, capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]


@pytest.mark.parametrize("word", NAMES.values())
def test_symdyn_does_not_know_its_name(word: str) -> None:
    root = RECIPES.parent.parent
    texts = [path for room in ("symdyn", "templates") for path in (root / room).rglob("*") if path.suffix != ".pyc"]
    known = [path for path in texts if path.is_file() and word in path.read_text("utf8", "replace")]

    assert known == []


@pytest.mark.parametrize("recipe", NAMES)
def test_a_new_row_takes_nothing_from_another_joint_type(recipe: str) -> None:
    text = (RECIPES / f"{recipe}.py").read_text("utf8")

    assert [kind for kind in JOINTS if f"symdyn.scene.joints.{kind}" in text] == []


def test_every_check_is_run() -> None:
    assert {path.stem.removeprefix("check_") for path in RECIPES.glob("check_*.py")} == set(NAMES)
