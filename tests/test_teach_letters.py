"""Letters of lessons: each means one thing, and what a scene calls its own stays the scene's."""

from __future__ import annotations

from pathlib import Path

import pytest
from lessons import lesson_of, step_of

from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.emit.print.equations_text import equations_text
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.graph import Op, evaluate, reachable
from symdyn.scene import Scene, read, read_text
from symdyn.teach import Document
from symdyn.teach.document import Matrix, Picture
from symdyn.teach.lesson import Lesson
from symdyn.teach.mathematics import Spelling

ROOT = Path(__file__).parent
EXAMPLES = ROOT.parent / "examples"
COLLIDE = ROOT / "data/found/collide.toml"

GREEDY = """
name = "greedy"
gravity = [0, "-G1", 0]
[parameters]
K = { value = 30, positive = true }
T = { value = 0.2, positive = true }
P_1 = { value = 2, positive = true }
L = { value = 0.5, positive = true }
v1 = { value = 0.3, positive = true }
r11 = { value = 0.1, positive = true }
I1 = { value = 0.02, positive = true }
J1 = { value = 0.02, positive = true }
N12 = { value = 0.1, positive = true }
k_z11 = { value = 1, positive = true }
G1 = { value = 9.81, positive = true }
m_1 = { value = 1, positive = true }
[bodies]
first = { mass = "P_1 + m_1", com = ["L", 0, 0], inertia = ["I1", "I1", "J1 + I1"], inertia_about = "com" }
second = { particles = [{ mass = "k_z11", at = ["v1", "r11", "N12 + T"] }] }
[joints]
hinge = { type = "revolute", parent = "ground", child = "first", axis = [0, 0, 1], coordinate = "y_1", drive = "M_z11" }
slide = { type = "prismatic", parent = "first", child = "second", axis = [0, 1, 0], coordinate = "E", drive = false }
[springs.s]
joint = "slide"
stiffness = "K"
"""


GROWTH = """
name = "growth"
gravity = [0, "-g", 0]
parameters = { g = { value = 9.81 }, l = { value = 1, latex = '\\lambda', unit = "m", positive = true } }
[bodies]
bob = { particles = [{ mass = 1, at = [0, "-l", 0] }] }
[joints]
hinge = { type = "revolute", parent = "ground", child = "bob", axis = [0, 0, 1], coordinate = "q", drive = false }
"""


@pytest.mark.parametrize(("length", "letter"), [("lambda", "κ"), ("ell", "λ")])
def test_a_growth_has_a_letter_that_the_scene_has_not(length: str, letter: str) -> None:
    said = Lesson(read_text(GROWTH.replace("lambda", length), "growth"), "en").say("near.negative")
    assert f"exp {letter}t, {letter}² being" in str(said.parts[0])


def scenes() -> dict[str, Scene]:
    return {
        "collide": read(COLLIDE),
        "greedy": read_text(GREEDY, "greedy"),
        "two_link": read(EXAMPLES / "two_link.toml"),
    }


@pytest.mark.long
@pytest.mark.mends("5.1")
@pytest.mark.parametrize("formulation", ["lagrange", "dalembert"])
@pytest.mark.parametrize("name", ["collide", "greedy"])
def test_no_letter_of_a_lesson_is_a_symbol_of_the_scene(name: str, formulation: str) -> None:
    document = lesson_of(scenes()[name], formulation=formulation)

    own = latex_symbols(document.scene)
    introduced = {key: text for key, text in Spelling(document).symbols.items() if key not in own}
    assert len(introduced) > 20
    assert {key: text for key, text in introduced.items() if text in own.values()} == {}


@pytest.mark.long
@pytest.mark.heavy("two_link")
@pytest.mark.mends("5.1")
@pytest.mark.parametrize("name", ["collide", "greedy", "two_link"])
def test_one_letter_of_a_lesson_has_one_value(name: str) -> None:
    document = lesson_of(scenes()[name])

    values: dict[str, set[float]] = {}
    for key, text in Spelling(document).symbols.items():
        named = document.names.get(key)
        if named is not None and named.node is not None:
            values.setdefault(text, set()).add(round(at_a_place(document, key), 9))
    assert {text: found for text, found in values.items() if len(found) > 1} == {}


def at_a_place(document: Document, key: str) -> float:
    node = document.names[key].node
    assert node is not None
    symbols = [x for x in reachable([node]) if x.op is Op.SYMBOL]
    return float(evaluate([node], Floats(), {x: 0.3 + (sum(map(ord, str(x.value))) % 97) / 97 for x in symbols})[0])


@pytest.mark.mends("5.1")
def test_a_quantity_is_never_said_to_be_itself_and_more() -> None:
    """m_1 = m_1 + m_2 stood there, x_1 = x_1, and E = 1/2 E x_1^2."""
    document = lesson_of(read(COLLIDE))
    spell = Spelling(document)

    said = [
        (spell.symbols[b.left], spell.inline(b.form))
        for _, b in document.blocks()
        if getattr(b, "left", "") in spell.symbols and not isinstance(b, Matrix)
    ]
    assert len(said) > 20
    assert [
        pair
        for pair in said
        if pair[0] in pair[1].replace(" ", "\n").split("\n") and pair[0] in latex_symbols(document.scene).values()
    ] == []


@pytest.mark.mends("5.1")
def test_the_energy_of_all_is_no_watt() -> None:
    document = lesson_of(read(EXAMPLES / "two_link.toml"))

    step = step_of(document, "power.numbers")
    said = " ".join(
        Spelling(document).words(block, str) for block in (step.claim, *step.blocks) if hasattr(block, "parts")
    )
    assert " W," in said
    assert r"\mathrm{d}t} W$" not in said


@pytest.mark.mends("5.1")
def test_weights_in_a_picture_have_no_letter_of_the_scene() -> None:
    document = lesson_of(scenes()["greedy"])

    (weights,) = [block for _, block in document.blocks() if isinstance(block, Picture) and block.key == "weights"]
    assert "G_1" in latex_symbols(document.scene).values()
    assert weights.svg.count(">G<") == 1  # what gravity is called beside its arrow
    assert weights.svg.count(">W<") == 2


@pytest.mark.mends("5.1")
def test_printed_energies_take_the_same_letters(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    scene = tmp_path / "greedy.toml"
    scene.write_text(GREEDY)

    assert main(["equations", str(scene), "--document"]) == 0
    assert "\n  K &=" not in capsys.readouterr().out
    assert "\n  K &=" in equations_text(read(EXAMPLES / "two_link.toml"), document=True)
