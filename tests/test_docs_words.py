"""docs/words.md has every word of a scene in the table where it belongs, and none that is not one."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import numpy as np
import pytest

from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.scene import read_text
from symdyn.scene.declaration import coupling, declare, joint_table, scene_table, tables as declared_tables
from symdyn.scene.forces import FORCES
from symdyn.scene.forces.force_table import kinds_of, sections
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.joint_table import LIMITS, own_keys
from symdyn.scene.values.grammar import CLOCK, FORMULA_NAMES
from symdyn.scene.values.key import keys_of, needed_of

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "words.md"
PLACE = "in docs/words.md, "
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


def headed(section: str) -> str:
    """Return the heading of a section of a file."""
    return section.replace("_", " ").capitalize()


def of_elements(section: str) -> set[str]:
    """Return the keys of all kinds of element in one section of a file, and what tells several apart."""
    kinds = kinds_of(section).values()
    return {key for kind in kinds for key in keys_of(kind.parts)} | ({"type"} if len(kinds) > 1 else set())


WORDS = {
    "Top level: key": {*keys_of(scene_table.HEAD), *declare.SECTIONS, *sections(), "loop", "dh"},
    "Parameters: key": set(keys_of(scene_table.PARAMETER)),
    "Inputs: key": set(keys_of(scene_table.INPUT)),
    "Outputs: key": set(keys_of(scene_table.OUTPUT)),
    "Tables: key": set(keys_of(declared_tables.TABLE)),
    "Bodies: key": set(keys_of(scene_table.BODY)),
    "Joints: key": set(joint_table.joint_keys()),
    "Joints: key of `mimic`": set(keys_of(coupling.MIMIC)),
    "Joints: key of `friction`": of_elements("friction"),
    "Joints: key of `limits`": set(keys_of(LIMITS)),
    "Points: key": set(keys_of(scene_table.POINT)),
    **{f"{headed(section)}: key": of_elements(section) for section in sections()},
    "Denavit-Hartenberg tables: key of `dh`": {*keys_of(declare.CHAIN), "links"},
    "Denavit-Hartenberg tables: key of a link": {"name", *keys_of(declare.LINK)},
    "Formulas: key": set(FORMULA_NAMES),
}


NEEDED = {
    "Parameters": needed_of(scene_table.PARAMETER),
    "Inputs": needed_of(scene_table.INPUT),
    "Outputs": needed_of(scene_table.OUTPUT),
    "Tables": needed_of(declared_tables.TABLE),
    "Bodies": needed_of(scene_table.BODY),
    "Joints": [
        *needed_of(joint_table.place_keys()),
        *needed_of(key for kind in JOINTS.values() for key in kind.keys),
        *needed_of(joint_table.ROWS),
        *needed_of(FORCES["friction"].parts),
    ],
    "Points": needed_of(scene_table.POINT),
    **{
        headed(section): [word for kind in kinds_of(section).values() for word in needed_of(kind.parts)]
        for section in sections()
        if section != "constraints"  # each type of them needs other words
    },
    "Denavit-Hartenberg tables": [*needed_of(declare.CHAIN), "links", *needed_of(declare.LINK)],
}


@pytest.mark.parametrize("section", NEEDED)
def test_the_page_says_which_words_must_be_given(section: str) -> None:
    page = PAGE.read_text(encoding="utf-8").partition(f"\n## {section}\n")[2].partition("\n## ")[0]
    rows = [line for line in page.splitlines() if line.endswith("| must be given |")]
    found = {word for row in rows for word in WORD.findall(row.split("|")[1])}
    assert found == set(NEEDED[section]), f'write "must be given" there and nowhere else, {PLACE}{section}'


@pytest.mark.parametrize("table", WORDS)
def test_a_table_holds_all_words_and_no_others(table: str) -> None:
    assert tables().get(table) == WORDS[table], f"write a table of these words, a row each, {PLACE}{table}"


def test_words_that_are_listed_in_sentences_are_all_of_them() -> None:
    text = PAGE.read_text(encoding="utf-8")
    loops = text.partition("## Loops")[2].partition("## Points")[0]
    untold = set(joint_table.loop_keys()) - set(WORD.findall(loops))
    assert untold == set(), f"name them in the sentence {PLACE}Loops"
    links = text.partition("Every link takes")[2].partition("| convention")[0]
    named = set(WORD.findall(links)) - {"revolute"}
    assert named == set(declare.LINK_OF_JOINT), f"name them in the sentence {PLACE}Denavit-Hartenberg tables"
    assert f"`{CLOCK}`, which is the time" in text


@pytest.mark.parametrize("name", own_keys())
def test_what_a_type_takes_is_told_beside_its_words(name: str) -> None:
    lines = PAGE.read_text(encoding="utf-8").partition("What a type takes:")[2].partition("Coordinates, drives")[0]
    told = {
        word
        for line in lines.splitlines()
        if line.startswith(f"| `{name}` ")
        for word in WORD.findall(line.split("|")[2])
    }
    takers = {kind for kind, one in JOINTS.items() if any(key.name == name for key in one.keys)}
    assert told == takers, f"write a row of `{name}`, and which types take it, {PLACE}Joints: What a type takes"


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
