"""docs/words.md has every word of a scene in the table where it belongs, and none that is not one."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import numpy as np
import pytest

from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.scene import read_text
from symdyn.scene.declaration import coupling, declare, declare as body_table, dh, joint_table
from symdyn.scene.forces import FORCES
from symdyn.scene.forces.force_table import sections
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.joint_table import own_keys
from symdyn.scene.values.names import CLOCK, FORMULA_NAMES

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "words.md"
WORD = re.compile(r"`(\w+)`")


def tables() -> dict[str, set[str]]:
    """Return the words in the first column of every table, by the header of that column below its section."""
    found: dict[str, set[str]] = {}
    section = header = ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            section = line[3:]
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if not cells:
            header = ""
        elif not header:
            header = cells[0]
        else:
            found.setdefault(f"{section}: {header}", set()).update(WORD.findall(cells[0]))
    return found


def keys_of(section: str) -> set[str]:
    """Return the keys of all kinds of element in one section of a file."""
    return {key for kind in FORCES.values() if kind.section == section for part in kind.parts for key in part.keys}


JOINT = {*joint_table.PLACE_KEYS, *own_keys(), *joint_table.OWN_KEYS, *joint_table.RATE_KEYS, *joint_table.LOCK_KEYS}

WORDS = {
    "Top level: word": {"name", "gravity", "units", *declare.TABLE_KEYS, *sections(), "loop", "dh"},
    "Parameters: word": set(declare.PARAMETER_KEYS),
    "Inputs: word": set(declare.INPUT_KEYS),
    "Outputs: word": set(declare.OUTPUT_KEYS),
    "Bodies: word": set(body_table.BODY_KEYS),
    "Joints: word": JOINT,
    "Joints: word of `mimic`": set(coupling.MIMIC_KEYS),
    "Joints: word of `friction`": keys_of("friction"),
    "Joints: word of `limits`": set(joint_table.LIMIT_KEYS),
    "Points: word": set(declare.POINT_KEYS),
    "Springs: word": keys_of("springs"),
    "Dampers: word": keys_of("dampers"),
    "Loads: word": keys_of("loads"),
    "Rows: word": keys_of("rows") | {"type"},
    "Denavit-Hartenberg tables: word of `dh`": set(dh.TABLE_KEYS),
    "Denavit-Hartenberg tables: word of a link": set(dh.LINK_KEYS) - {*dh.JOINT_KEYS, *dh.BODY_KEYS},
    "Formulas: word": set(FORMULA_NAMES),
}


@pytest.mark.parametrize("table", WORDS)
def test_a_table_holds_all_words_and_no_others(table: str) -> None:
    assert tables()[table] == WORDS[table]


def test_words_that_are_listed_in_sentences_are_all_of_them() -> None:
    text = PAGE.read_text(encoding="utf-8")
    loops = text.partition("## Loops")[2].partition("## Points")[0]
    assert set(joint_table.loop_keys()) <= set(WORD.findall(loops))
    links = text.partition("Every link takes")[2].partition("| convention")[0]
    assert set(WORD.findall(links)) - {"revolute"} == set(dh.JOINT_KEYS)
    assert f"`{CLOCK}`, which is the time" in text


@pytest.mark.parametrize("name", own_keys())
def test_what_a_type_takes_is_told_beside_its_words(name: str) -> None:
    lines = PAGE.read_text(encoding="utf-8").partition("What a type takes:")[2].partition("Coordinates, drives")[0]
    (row,) = (line.split("|") for line in lines.splitlines() if line.startswith(f"| `{name}` "))
    takers = {kind for kind, one in JOINTS.items() if any(key.name == name for key in one.keys)}
    assert set(WORD.findall(row[2])) == takers


def test_the_tip_of_a_loop_is_the_place_of_the_hinge_in_the_child_inverted() -> None:
    told = '[["Rz", "-a"], ["Tx", "-c"]]'
    page, bar = (ROOT / "docs/scenes.md").read_text(), (ROOT / "examples/four_bar.toml").read_text()
    own = 'tip = ["-c", 0, 0]'
    assert told in page
    assert own in page
    assert own in bar
    q = np.array([0.3, 1.1, 0.7])
    residuals = [
        Numbers(read_text(bar.replace(own, f"tip = {tip}"))).residual(q)
        for tip in ('["-c", 0, 0]', told.replace("-a", "-0.7"), '["c", 0, 0]')
    ]

    assert residuals[0] == pytest.approx(residuals[1], abs=1e-13)
    assert np.abs(residuals[0] - residuals[2]).max() > 1


def test_the_examples_of_the_page_run() -> None:
    found = doctest.testfile(str(PAGE), module_relative=False)
    assert found.failed == 0
    assert found.attempted > 3
