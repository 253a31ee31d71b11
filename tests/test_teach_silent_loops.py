"""Lessons of mechanisms with loops that tie nothing: a door on two hinges, a table on two slides, a top in two balls.

Their equations are those of the mechanism without the loop, which is derived by itself.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from lessons import lesson_of

from symdyn.algebra.form import Form
from symdyn.cli import main
from symdyn.graph import Graph
from symdyn.scene import Scene, read, read_text
from symdyn.teach import Document, rendered, walkthrough
from symdyn.teach.practice.exercises import with_exercises
from symdyn.teach.render.handout import usual_formulation
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove

HERE = Path(__file__).parent
HINGES = """
name = "door"
gravity = [0, 0, -9.81]
[bodies]
leaf = { mass = 20, com = [0.4, 0, 0], inertia = [1, 2, 2], inertia_about = "com" }
[joints]
lower = { type = "revolute", parent = "ground", child = "leaf", axis = [0, 0, 1] }
upper = { type = "revolute", parent = "ground", child = "leaf", axis = [0, 0, 1], origin = [0, 0, 2], tip = [0, 0, -2] }
"""
SLIDES = """
name = "slides"
gravity = [0, 0, -9.81]
parameters = { m = 2, l = 1 }
bodies.table.mass = "m"
bodies.arm = { mass = 1, com = ["l/2", 0, 0] }
[joints]
left = { type = "prismatic", parent = "ground", child = "table", axis = [1, 0, 0] }
[joints.right]
type = "prismatic"
parent = "ground"
child = "table"
axis = [1, 0, 0]
origin = [0, 1, 0]
tip = [0, -1, 0]
[joints.hang]
type = "revolute"
parent = "table"
child = "arm"
axis = [0, 1, 0]
drive = false
"""
BALLS = """
name = "balls"
gravity = [0, 0, -9.81]
[bodies]
top = { mass = 2, com = [0, 0, 1], inertia = [1, 1, 2], inertia_about = "com" }
[joints]
one = { type = "spherical", parent = "ground", child = "top" }
two = { type = "spherical", parent = "ground", child = "top" }
"""
SECOND_PIVOT = """
[[loop]]
name = "second"
type = "revolute"
parent = "ground"
child = "crank"
axis = [0, 0, 1]
origin = [0, 0, 0.1]
tip = [0, 0, -0.1]
"""
FOUR_BAR = (HERE.parent / "examples" / "four_bar.toml").read_text(encoding="utf-8") + SECOND_PIVOT
SCENES = {"hinges": HINGES, "slides": SLIDES, "balls": BALLS, "four_bar": FOUR_BAR}
FORMATS = ("md", "html", "latex", "notebook")


def scene(name: str) -> Scene:
    return read(HERE / "data" / "door.toml") if name == "leaning" else read_text(SCENES[name], f"{name}.toml")


@pytest.mark.mends("30.attacks.2")
@pytest.mark.long
@pytest.mark.parametrize("more", [[], ["--exercises"], ["--language", "sk", "--detail", "brief"]], ids=" ".join)
@pytest.mark.parametrize("ending", ["md", "html"])
def test_a_door_on_two_hinges_has_a_lesson(tmp_path: Path, ending: str, more: list[str]) -> None:
    file = tmp_path / "door.toml"
    file.write_text(HINGES, encoding="utf-8")

    assert main(["walkthrough", str(file), *more, "-o", str(tmp_path / f"lesson.{ending}")]) == 0

    assert "upper" in (tmp_path / f"lesson.{ending}").read_text(encoding="utf-8")


@pytest.mark.wide("hinges-en")
@pytest.mark.long(0)
@pytest.mark.parametrize("language", ["en", pytest.param("sk", marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", [*SCENES, pytest.param("leaning", marks=pytest.mark.slow)])
def test_what_ties_nothing_is_named_in_every_format(name: str, language: str) -> None:
    document = lesson_of(scene(name), language)

    (silent,) = [step for section in document.sections for step in section.steps if step.key == "ties.silent"]
    assert {"hinges": "upper", "slides": "right", "balls": "two", "four_bar": "second", "leaning": "upper"}[
        name
    ] in str(silent.claim)
    for one in (document, with_exercises(document, 1), with_exercises(document, 3)):
        for format in FORMATS:
            assert all(rendered(one, format).values())


@pytest.mark.long
@pytest.mark.heavy("leaning")
@pytest.mark.parametrize("name", ["hinges", "slides", "leaning"])
def test_its_equations_are_those_without_the_loop(name: str) -> None:
    closed = scene(name)
    opened = replace(closed, loops=())
    own, right = walkthrough(closed), walkthrough(opened)
    assert usual_formulation(closed) == usual_formulation(opened) == "lagrange"

    graph = Graph()
    for drive in filter(None, closed.drives):
        mine, other = (_value(one, drive).express(graph) for one in (own, right))
        assert prove([Claim(drive, "with", "without", (mine,), (other,))])[1][0].verdict == Verdict.PROVED


def _value(document: Document, name: str) -> Form:
    node = document.names[name].node
    assert node is not None
    return Form.of(node)


def test_the_formulation_with_multipliers_says_that_there_are_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "door.toml"
    file.write_text(HINGES, encoding="utf-8")

    assert main(["walkthrough", str(file), "--formulation", "multipliers"]) == 1

    assert "nothing ties the coordinates" in capsys.readouterr().err
