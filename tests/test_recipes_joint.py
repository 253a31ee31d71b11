"""A joint type that comes as one file from outside: nothing in symdyn knows its name, and everything works on it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

RECIPES = Path(__file__).parent / "recipes"


def test_a_joint_type_is_one_file() -> None:
    """In a fresh process, so that no other test sees the type, nor the type another test."""
    checks = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "check_rack_and_pinion.py"]
    done = subprocess.run([sys.executable, *checks], cwd=RECIPES, capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]


def test_symdyn_does_not_know_its_name() -> None:
    root = RECIPES.parent.parent
    texts = [path for room in ("symdyn", "templates") for path in (root / room).rglob("*") if path.suffix != ".pyc"]
    known = [path for path in texts if path.is_file() and "pinion" in path.read_text("utf8", "replace")]

    assert known == []
