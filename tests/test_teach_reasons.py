"""Reasons that lessons give are sentences of mechanics, and true: held against forces found by hand."""

from __future__ import annotations

from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest
from lessons import lesson_of

from symdyn.scene import read, read_text
from symdyn.scene.scene_files import Starter
from symdyn.table import Table
from symdyn.teach import Document, walkthrough
from symdyn.teach.document import Picture, Step, Words
from symdyn.teach.mathematics import Spelling

EXAMPLES = Path(__file__).parent.parent / "examples"


def steps(document: Document) -> dict[str, Step]:
    return {step.key: step for section in document.sections for step in section.steps}


def said(document: Document, key: str) -> str:
    """Return all prose of a step."""
    step, spell = steps(document)[key], Spelling(document)
    return " ".join(spell.words(x, str) for x in (step.claim, *step.blocks, step.reason) if isinstance(x, Words))


def reasons(document: Document, kind: str) -> dict[str, str]:
    """Return why each coefficient is there or not, by its name as it is printed."""
    spell = Spelling(document)
    tables = [block for block in steps(document)[f"meaning:{kind}"].opened() if isinstance(block, Table)]
    return {spell.words(name, str): spell.words(why, str) for table in tables for name, _, why in table.rows}


@pytest.mark.mends("5.4")
def test_a_lever_is_longer_only_where_it_is() -> None:
    """(5.52): about axis 1 the forces of q2'' have their moment about axis 2, and that of their resultant there."""
    m, h1, h2, q1, q2 = 1.6, 1.0, 0.8, 0.3, 0.8 * pi  # cos q2 < 0
    tip = np.array([h1 * sin(q1) + h2 * sin(q1 + q2), -h1 * cos(q1) - h2 * cos(q1 + q2)])
    elbow = np.array([h1 * sin(q1), -h1 * cos(q1)])
    force = m * h2 * np.array([cos(q1 + q2), sin(q1 + q2)])  # of q2'' = 1, at rest
    about_1, about_2 = (r[0] * force[1] - r[1] * force[0] for r in (tip, tip - elbow))

    assert about_1 == pytest.approx(m * h2**2 + m * h1 * h2 * cos(q2))
    assert about_1 < about_2
    assert about_1 - about_2 == pytest.approx(elbow[0] * force[1] - elbow[1] * force[0])
    text = said(lesson_of(read(EXAMPLES / "two_link.toml")), "meaning:k_z:1,2")
    assert "longer" not in text
    assert "that of their resultant placed on the second axis" in text


SKEW = """
name = "skew"
gravity = [0, 0, "-g"]
[parameters]
m = { positive = true }
h = { positive = true }
g = { positive = true }
[bodies]
first = {}
second = { particles = [{ mass = "m", at = [0, "h", "h"] }] }
[joints]
base = { type = "revolute", parent = "ground", child = "first", axis = [0, 0, 1] }
tilt = { type = "revolute", parent = "first", child = "second", axis = [1, 0, 0], origin = { xyz = ["h", 0, 0] } }
"""


@pytest.mark.long(0)
def test_axes_that_are_not_parallel_share_no_moment() -> None:
    text = said(walkthrough(read_text(SKEW, "skew")), "meaning:k_z:1,2")

    assert "minus" in text
    assert "resultant" not in text


@pytest.mark.wide(2)
@pytest.mark.heavy("rrr")
@pytest.mark.long
@pytest.mark.mends("5.4")
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "scara", "rrp", "rrr"])
def test_a_coefficient_is_absent_for_a_reason_of_mechanics(name: str) -> None:
    scene = (
        read_text(Starter(name).from_template(name), name) if name.startswith("rr") else read(EXAMPLES / f"{name}.toml")
    )
    document = walkthrough(scene)

    for kind in ("k_D", "k_C"):
        for why in reasons(document, kind).values():
            assert "coefficient" not in why
            assert any(word in why for word in ("force", "acceleration", "carries"))


@pytest.mark.mends("5.4")
def test_a_coriolis_force_along_the_link_meets_its_axis() -> None:
    """k_C,2,12 of a point mass on two links: 2 m q1' q2' h2 points along the second link, through axis 2."""
    found = reasons(lesson_of(read(EXAMPLES / "two_link.toml")), "k_C")

    assert "its line meets the axis" in found["$k_{C,2,12}$"]
    assert "has a moment about axis 1" in found["$k_{C,1,12}$"]


@pytest.mark.mends("5.4")
def test_a_slide_along_the_axis_of_a_turn_is_not_bent() -> None:
    """In a SCARA q3 slides along axes 1 and 2, so ω × v = 0."""
    found = reasons(lesson_of(read(EXAMPLES / "scara.toml")), "k_C")

    assert "give no mass a Coriolis acceleration" in found["$k_{C,1,13}$"]
    assert "give no mass a Coriolis acceleration" in found["$k_{C,2,23}$"]


APART = """
name = "apart"
[bodies]
a = { particles = [{ mass = 1, at = [1, 0, 0] }] }
b = { particles = [{ mass = 1, at = [1, 0, 0] }] }
[joints]
one = { type = "revolute", parent = "ground", child = "a", axis = [0, 0, 1] }
two = { type = "revolute", parent = "ground", child = "b", axis = [0, 0, 1] }
"""


def test_branches_do_not_act_on_each_other() -> None:
    document = walkthrough(read_text(APART, "apart"))

    assert "moves nothing that joint 2 carries" in reasons(document, "k_D")["$k_{D,21}$"]
    assert "move nothing that joint 1 carries" in reasons(document, "k_C")["$k_{C,1,12}$"]


@pytest.mark.long
@pytest.mark.mends("5.4")
@pytest.mark.parametrize("language", ["en", "sk"])
def test_potential_energy_is_explained_by_the_work_of_the_weight(language: str) -> None:
    text = said(lesson_of(read(EXAMPLES / "two_link.toml"), language), "potential:1")

    assert {"en": "work of the weight", "sk": "Práca tiaže"}[language] in text
    assert {"en": "scalar product", "sk": "skalárny súčin"}[language] in text


@pytest.mark.long(0)
@pytest.mark.mends("5.4")
def test_an_erratum_is_checked_by_energies_and_not_by_a_program() -> None:
    for language, words in (("en", "graph"), ("sk", "grafe")):
        document = lesson_of(read(EXAMPLES / "two_link.toml"), language)
        parts = [
            part for _, b in document.blocks() if isinstance(b, Words) for part in b.parts if isinstance(part, str)
        ]

        assert not [part for part in parts if words in part]


@pytest.mark.mends("5.3")
def test_the_couples_of_a_figure_are_those_of_the_formulas() -> None:
    """M^D of the formulas is about O_j, and so is that of the figure, where both points are marked."""
    document = lesson_of(read(EXAMPLES / "four_bar.toml"), formulation="dalembert")

    pictures = [block for _, block in document.blocks() if isinstance(block, Picture) and block.key.startswith("free-")]
    assert len(pictures) == 3
    for j, picture in enumerate(pictures, 1):
        assert {f"M{j}{j}D", f"F{j}{j}D", f"O{j}", f"T{j}"} <= set(labels_of(picture.svg))
    assert "moved to O1, with their moments about it" in said(document, "free:crank")


def labels_of(svg: str) -> set[str]:
    from xml.etree import ElementTree

    texts = ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")
    return {"".join(text.itertext()).replace(" ", "") for text in texts}


@pytest.mark.long(0)
@pytest.mark.mends("5.10")
def test_a_body_has_one_number_in_both_lessons() -> None:
    scene = read(EXAMPLES / "two_link.toml")

    energies, forces = (walkthrough(scene, formulation=formulation) for formulation in ("lagrange", "dalembert"))
    assert "point mass $m_1$" in said(energies, "kinetic:1")  # that of link1
    assert said(forces, "free:link1").startswith("Body 1, link 1")
    assert said(forces, "free:link2").startswith("Body 2, link 2")
