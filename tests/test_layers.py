"""The rooms import downwards only."""

from __future__ import annotations

import ast
from pathlib import Path

import symdyn

ROOT = Path(symdyn.__file__).parent

ROOMS = {  # room: the rooms it may import
    "errors": [],
    "resources": ["errors"],
    "graph": ["errors"],
    "algebra": ["graph"],
    "spatial": ["graph"],
    "scene": ["spatial", "resources"],
    "dynamics": ["scene", "algebra"],
    "program": ["dynamics"],
    "emit": ["program"],
    "build": ["emit"],
    "draw": ["emit"],
    "verify": ["build"],
    "simulation": ["verify", "draw"],
    "bench": ["simulation"],
    "teach": ["simulation"],
    "cli": ["bench", "teach"],
}


def below(room: str) -> set[str]:
    found = {room}
    for lower in ROOMS[room]:
        found |= below(lower)
    return found


def test_every_import_points_down() -> None:
    wrong = []
    for path in sorted(ROOT.rglob("*.py")):
        room = path.relative_to(ROOT).parts[0].removesuffix(".py")
        if room in ("__init__", "__main__"):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, (ast.Import, ast.ImportFrom)):
                continue
            names = [node.module] if isinstance(node, ast.ImportFrom) else [alias.name for alias in node.names]
            for name in names:
                if name and name.startswith("symdyn.") and name.split(".")[1] not in below(room):
                    wrong.append(f"{path.relative_to(ROOT)} imports {name}")
    assert not wrong, "\n".join(wrong)


def test_every_room_is_in_the_table() -> None:
    rooms = {p.name.removesuffix(".py") for p in ROOT.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}

    assert rooms - {"__init__", "__main__"} == set(ROOMS)
