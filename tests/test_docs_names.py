"""Every dotted name that docs and messages tell the user can be imported."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

import symdyn

ROOM = Path(symdyn.__file__).parent
ROOT = ROOM.parent
NAME = re.compile(r"\bsymdyn(?:\.[A-Za-z_]+)+")
IMPORT = re.compile(r"from (symdyn[\w.]*) import ([\w, ]+)")


def told() -> list[str]:
    """Return the names in docs, and those that messages end a sentence's part with, as in `symdyn.scene`."""
    found = set()
    for path in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        text = path.read_text(encoding="utf-8")
        found |= set(NAME.findall(text))
        found |= {f"{room}.{name.strip()}" for room, names in IMPORT.findall(text) for name in names.split(",")}
    for path in ROOM.rglob("*.py"):
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.lstrip().startswith(('"', 'f"')):
                found |= set(NAME.findall(line))
    return sorted(name for name in found if not name.endswith((".py", ".git", ".md", ".fish")))


@pytest.mark.parametrize("name", told())
def test_a_name_that_is_told_can_be_imported(name: str) -> None:
    room, _, last = name.rpartition(".")
    try:
        found = getattr(import_module(room), last, None)
    except ImportError:
        found = None
    assert found is not None or import_module(name)


def test_the_door_of_reactions_at_one_position_is_told() -> None:
    assert "symdyn.dynamics.reactions_at" in told()
