"""What a lesson by Lagrange's formulation says before it derives: the task, zeros and senses, (5.21) and (5.22)."""

from __future__ import annotations

from functools import cache
from math import pi
from pathlib import Path

import numpy as np
import pytest
from lessons import lesson_of, step_of

from symdyn.algebra.form import Symbol
from symdyn.algebra.numeric import Floats
from symdyn.draw.places import places
from symdyn.dynamics.mechanism.state import State
from symdyn.graph import Expr, Graph, Op, evaluate, gradient, reachable, substitute, tangents
from symdyn.scene import read, read_text
from symdyn.table import Table
from symdyn.teach import Document, rendered, walkthrough
from symdyn.teach.derivations.dalembert.laws import ERRORS
from symdyn.teach.derivations.lagrange import ANY
from symdyn.teach.document import Box, Formula, Matrix, Picture, Words
from symdyn.teach.mathematics import Spelling
from symdyn.teach.notation import READS
from symdyn.teach.shown_state import choose_state, picture_letters

ROOT = Path(__file__).parent.parent
SCENES = {name: ROOT / f"examples/{name}.toml" for name in ("two_link", "cart_pole", "spatial_3r", "pendulum")}
SCENES |= {
    name: ROOT / f"tests/data/found/{name}.toml" for name in ("heavy_top_zyx", "hoop_driven", "elastic_pendulum")
}


@cache
def lesson(name: str, language: str = "en") -> Document:
    return lesson_of(read(SCENES[name]), language)


def floats(nodes: list[Expr]) -> list[float]:
    symbols = [x for x in reachable(nodes) if x.op is Op.SYMBOL]
    return evaluate(nodes, Floats(), {x: 0.4 + sum(map(ord, str(x.value))) % 83 / 61 for x in symbols})


@pytest.mark.long
@pytest.mark.heavy("spatial_3r", "heavy_top_zyx")
@pytest.mark.parametrize("name", SCENES)
def test_the_principle_holds_for_every_coordinate(name: str) -> None:
    document = lesson(name)
    g, K, P = document.graph, document.names["K:"].node, document.names["P:"].node
    assert K is not None
    assert P is not None
    formulas = [
        b for key in ("principle", "principle:L") for b in step_of(document, key).blocks if isinstance(b, Formula)
    ]
    assert [block.number for block in formulas][:2] == ["5.21", "5.22"]
    q = [g.symbol(x) for x in document.scene.coordinates]
    u = [g.symbol(f"{x}_dot") for x in document.scene.coordinates]
    a = [g.symbol(f"{x}_ddot") for x in document.scene.coordinates]
    moving = dict(zip([*q, *u], [*u, *a], strict=True))
    for i, (qi, ui) in enumerate(zip(q, u, strict=True), 1):
        rates = {of: tangents(gradient(x, [ui]), moving)[0] for of, x in (("K", K), ("L", K - P))}
        slopes = {of: gradient(x, [qi])[0] for of, x in (("K", K), ("P", P), ("L", K - P))}
        known = {f"d{of}:/dq:i": x for of, x in slopes.items()} | {
            f"d/dt d{of}:/dq_dot:i": x for of, x in rates.items()
        }
        known |= {"QA:i": rates["L"] - slopes["L"], "Q:i": rates["K"] - slopes["K"], "K:": K, "P:": P, "L:": K - P}
        for block in formulas:
            assert block.left in ("", "L:")
            sides = [block.form, block.right or Symbol(block.left)]
            assert set(sides[0].symbols) <= set(known)
            nodes = [side.express(g) for side in sides]
            left, right = floats(substitute(nodes, {g.symbol(key): x for key, x in known.items()}))
            assert left == pytest.approx(right, rel=1e-9, abs=1e-9)
        force, whole = document.names[f"QA:{i}"].node, document.names[f"tau:{i}"].node
        if document.scene.drives[i - 1]:
            assert force is not None
            assert whole is not None
            assert floats([force])[0] == pytest.approx(floats([whole])[0])


def test_any_coordinate_is_no_letter_of_the_scene() -> None:
    one = read_text((ROOT / "examples/two_link.toml").read_text().replace('"q1"', '"q_i"').replace("q1", "q_i"), "two")
    document = walkthrough(one)
    shown = Spelling(document).symbols
    assert shown["q_i"] not in [shown[key] for key in ANY]


@pytest.mark.heavy("spatial_3r")
@pytest.mark.parametrize("name", SCENES)
def test_the_product_rule_is_carried_out_term_by_term(name: str) -> None:
    document = lesson(name)
    for i, q in enumerate(document.scene.coordinates, 1):
        blocks = [b for s, b in document.blocks() if s.key == f"rate:{i}"]
        (table,) = (b for b in blocks if isinstance(b, Table))
        cells = [[document.value(cell.parts[0]) for cell in row] for row in table.rows]
        total, whole = [x for row in cells for x in row[1:]], document.names[f"d/dt dL:/d{q}_dot"].node
        assert whole is not None
        found = floats([*total, whole])
        assert sum(found[:-1]) == pytest.approx(found[-1], rel=1e-9, abs=1e-9)
        g = document.graph
        moving = {g.symbol(f"{x}{dots}"): g.symbol(f"{x}{more}") for x in document.scene.coordinates
                  for dots, more in (("", "_dot"), ("_dot", "_ddot"))}  # fmt: skip
        for term, *parts in cells:  # each row by itself is a derivative
            (rate,) = tangents([term], moving)
            first, second, third = floats([rate, *parts])
            assert first == pytest.approx(second + third, rel=1e-9, abs=1e-9)


ZEROS = {
    "two_link": (["link 1 points down", "link 2 continues link 1 in a straight line"], ["along z", "along z"]),
    "cart_pole": (["cart is at the origin of joint rail", "pole points up"], ["along x", "along z"]),
    "pendulum": (["points down"], ["along z"]),
    "elastic_pendulum": (["points down", "bob is at the origin of joint slide"], ["along z", "down"]),
    "hoop_driven": (["the frame of hoop lies", "bead points down"], ["points up", "along y"]),
}


@pytest.mark.parametrize("name", ZEROS)
def test_zeros_and_senses_are_those_of_the_scene(name: str) -> None:
    (table,) = step_of(lesson(name), "coordinates").blocks
    assert isinstance(table, Table)
    where, way = ([str(row[k].parts[0]) for row in table.rows] for k in (1, 2))
    for said, words in zip([*where, *way], [*ZEROS[name][0], *ZEROS[name][1]], strict=True):
        assert words in said


def test_a_positive_turn_goes_where_the_lesson_says() -> None:
    """Right-handed about +z from down is towards +x: an arm that hangs moves to the right."""
    scene = read(ROOT / "examples/two_link.toml")
    found = places(scene, np.array([[0.0, 0.0], [pi / 6, 0.0]]), {p.name: 1.0 for p in scene.parameters})
    hangs, turned = found.bodies[0].particles[0][1]
    assert hangs == pytest.approx([0, -1, 0])
    assert turned[0] > 0


@pytest.mark.long(0)
def test_what_is_reasoned_is_reasoned_once() -> None:
    for name in SCENES:
        document = lesson(name)
        spell = Spelling(document)
        told = [spell.words(s.reason, str) for section in document.sections for s in section.steps if s.reason.parts]
        long = [text for text in told if len(text) > 60]
        assert len(long) == len(set(long)) > 5


def test_errata_stand_in_an_appendix_with_one_mark_at_each_place() -> None:
    document = lesson("two_link")
    *others, last = document.sections
    assert last.key == "errata"
    assert not any(s.key.startswith("errata:") for section in others for s in section.steps)
    marked = {s.key: s.reference.rpartition("see erratum ")[2] for section in others for s in section.steps
              if "see erratum" in s.reference}  # fmt: skip
    assert [f"errata:{key}" for key in marked] == [s.key for s in last.steps]
    boxes = [[block.title.parts[0] for block in s.blocks if isinstance(block, Box)] for s in last.steps]
    assert [", ".join(str(title).split(".")[0] for title in titles) for titles in boxes] == list(marked.values())
    table = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8").rpartition("\n## ")[2]
    numbers = [one.number for one in READS] + [x for some in ERRORS.values() for x in some] + ["5.16"]
    assert all(f"({x})" in table for one in numbers for x in one.split(", "))
    assert all("erratum" not in words for s in lesson("cart_pole").sections for words in [s.key, s.title])


@pytest.mark.long
@pytest.mark.parametrize("language", ["en", "sk"])
def test_the_task_comes_first(language: str) -> None:
    document = lesson("cart_pole", language)
    assert [s.key for s in document.sections[0].steps][:3] == ["scene", "task", "coordinates"]
    assert document.sections[1].key == "principle"
    known, *wanted = (block for block in step_of(document, "task").blocks if isinstance(block, Words))
    assert set(symbols_of_words(known)) == {"mc", "mp", "l", "b", "g"}
    assert [sorted(symbols_of_words(words)) for words in wanted] == [["F", "x"], ["theta", "theta_ddot"]]
    (text,) = (text for name, text in rendered(document, "md").items() if name.endswith(".md"))
    assert r"\tag{5.21}" in str(text)


def symbols_of_words(words: Words) -> list[str]:
    return [name for part in words.parts if not isinstance(part, str) for name in part.symbols]


@pytest.mark.long(0)
def test_a_scene_of_numbers_keeps_letters_in_its_lesson() -> None:
    bare = read(SCENES["heavy_top_zyx"])
    assert not bare.parameters
    document = lesson("heavy_top_zyx")
    values = {p.name: p.value for p in document.scene.parameters}
    assert {"m1", "Iyy1", "g"} <= set(values)
    assert None not in values.values()
    assert not walkthrough(
        read(ROOT / "examples/puma560.toml"), until="energies"
    ).scene.parameters  # six axes stay short


@pytest.mark.long(0)
def test_steps_say_what_the_figure_shows() -> None:
    known = {"frames", "angles", "places", "velocities", "accelerations", "weights", "forces", "inertia", "coriolis"}
    known |= {"names", "centrifugal", "momenta", "energies", "plots", "body:column", "body:upper_arm", "body:forearm"}
    document = lesson("spatial_3r")
    shown = {
        s.key: s.show for section in document.sections if not section.key.startswith("after") for s in section.steps
    }
    assert shown["position:3"] == ("places", "body:forearm")
    assert shown["meaning:k_C"] == ("coriolis",)
    assert {word for words in shown.values() for word in words} <= known
    assert sum(not words for words in shown.values()) <= 8


@pytest.mark.parametrize(
    ("name", "count"), [("spatial_3r", 3), ("heavy_top_zyx", 1), ("two_link", 0), ("cart_pole", 0)]
)
def test_rotation_matrices_come_before_what_is_read_from_them(name: str, count: int) -> None:
    document = lesson(name)
    keys = [section.key for section in document.sections]
    matrices = [b for s, b in document.blocks() if s.key.startswith("rotation:") and isinstance(b, Matrix)]
    assert len(matrices) == count == keys.count("rotations") * count
    if not count:
        return
    assert keys.index("principle") < keys.index("rotations") < keys.index("velocities")
    for matrix in matrices:
        entries = [document.value(entry) for entry in matrix.entries]
        truth = [document.names[key].node for key in matrix.names]
        found = np.reshape(floats([*entries, *truth]), (2, 3, 3))  # type: ignore[list-item]
        assert found[0] == pytest.approx(found[1], abs=1e-12)
        assert found[0].T @ found[0] == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(found[0]) == pytest.approx(1)
    last = step_of(document, "turning:3" if name == "spatial_3r" else "turning:1")
    read = [block for block in last.blocks if isinstance(block, Formula) and block.right is not None]
    assert len(read) == 3
    for block in read:
        left = document.names[block.left].node
        assert left is not None
        assert block.right is not None
        first, second, third = floats([left, document.value(block.form), document.value(block.right)])
        assert first == pytest.approx(second) == pytest.approx(third)


PARTED = """
name = "parted"
[bodies]
fan = { inertia = ["J", "J", "J"], inertia_about = "com" }
cart = { mass = "3*J", inertia = ["J", "J", "J"], inertia_about = "com" }
[joints]
rail = { type = "prismatic", parent = "ground", child = "cart" }
hub = { type = "revolute", parent = "ground", child = "fan" }
[parameters]
J = {}
"""


def test_what_nothing_turns_is_said_to_stand() -> None:
    document = walkthrough(read_text(PARTED, "parted"))
    said = {s.key: str(s.reason.parts[0]) for section in document.sections for s in section.steps if "turning" in s.key}
    assert sorted(text[:20] for text in said.values()) == ["Nothing turns it.", "The joints that turn"]


def test_masses_and_lengths_have_their_letters_in_the_picture() -> None:
    def lettered(name: str) -> dict[str, list[float]]:
        scene, graph = read(SCENES[name]), Graph()
        chosen = choose_state(scene, State.of(scene, graph), graph)
        return {one.latex: list(one.at) for one in picture_letters(scene, graph, chosen)}

    arm = lettered("two_link")
    assert list(arm) == ["m_1", "m_2", "h_1", "h_2"]
    assert arm["h_1"] == pytest.approx([x / 2 for x in arm["m_1"]])
    assert arm["h_2"] == pytest.approx([(x + y) / 2 for x, y in zip(arm["m_1"], arm["m_2"], strict=True)])
    assert set(lettered("spatial_3r")) == {"m_1", "m_2", "m_3", "h", "l_2", "l_3"}
    picture = next(block for s, block in lesson("two_link").blocks() if s.key == "scene" and isinstance(block, Picture))
    assert picture.svg.count("label-letter-") == 4
