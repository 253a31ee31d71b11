"""Variants by seed are other mechanisms, as their first section says; sheets hold the task, questions and room."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import pytest
from test_teach_practice import EXAMPLES, lesson

import symdyn
from symdyn.algebra.form import Number, Symbol
from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.dynamics.mechanism.kinematics import centre_of_mass
from symdyn.dynamics.mechanism.lagrange import Energies
from symdyn.errors import TeachError
from symdyn.graph import Expr, Graph, Op, evaluate, reachable
from symdyn.scene import Scene, read, read_text, write_text
from symdyn.scene.values.quantity import Quantity
from symdyn.teach import rendered, walkthrough
from symdyn.teach.document import Questions, Room
from symdyn.teach.notation import NUMBERS
from symdyn.teach.practice.exercises import with_exercises
from symdyn.teach.practice.questions import sheet
from symdyn.teach.practice.variants import CHANGES, Change, variant, with_changes

NAMES = ("two_link", "cart_pole", "spatial_3r", "heavy_top", "pendulum", "slider_crank", "four_bar", "rolling_disc")


def values(*nodes: Expr) -> list[float]:
    symbols = [x for x in reachable(nodes) if x.op is Op.SYMBOL]
    point = {x: random.Random(str(x.value)).uniform(0.3, 1.3) for x in symbols}
    return [float(x) for x in evaluate(nodes, Floats(), point)]


@pytest.mark.wide(2)
@pytest.mark.heavy("spatial_3r", "slider_crank", "cart_pole", "heavy_top")
@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_a_seed_draws_one_variant_that_can_be_read_and_another_seed_another(name: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    drawn = [variant(scene, seed) for seed in range(12)]

    assert [one.scene for one in drawn] == [variant(scene, seed).scene for seed in range(12)]
    assert len({frozenset((x.key, *x.places.items()) for x in one.changes) for one in drawn}) >= (
        3 if name == "rolling_disc" else 8
    )
    for one in drawn:
        assert read_text(write_text(one.scene, "toml").text) == one.scene
        assert 1 <= len(one.changes) <= 3


def single(scene: Scene, key: str) -> tuple[Scene, Change]:
    """Return the first variant by one change alone."""
    for row in CHANGES:
        for seed in range(20):
            drawn = row(scene, random.Random(seed))
            if drawn is not None and drawn[1].key == key:
                return drawn
    raise AssertionError(f"no change of {scene.name} is called {key}")


def number(change: Change, place: str) -> float:
    value = change.places[place]
    assert isinstance(value, Number)
    return float(value.value)


@pytest.mark.parametrize("name", ["two_link", "cart_pole", "spatial_3r"])
def test_what_is_said_of_masses_and_lengths_is_true(name: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")

    heavier, said = single(scene, "variant.mass")
    (before,), (after,) = (values(Energies.of(one, Graph()).K) for one in (scene, heavier))
    gone = {"mass": Quantity.ZERO, "inertia": (Quantity.ZERO,) * 6, "particles": ()}
    bodies = (replace(one, **gone) if one.name == said.places["body"] else one for one in scene.bodies)  # type: ignore[arg-type]
    light = replace(scene, bodies=tuple(bodies))
    (without,) = values(Energies.of(light, Graph()).K)
    assert after - without == pytest.approx(number(said, "factor") * (before - without))

    longer, said = single(scene, "variant.length" if name == "two_link" else "variant.length.spun")
    body = str(said.places["body"])
    graph = Graph()
    arms = [values(*centre_of_mass(one, body, graph)) for one in (scene, longer)]
    assert arms[1] == pytest.approx([number(said, "factor") * x for x in arms[0]])
    spins = [values(*(x.express(graph) for x in one.bodies[k].inertia))
             for one in (scene, longer) for k, b in enumerate(one.bodies) if b.name == body]  # fmt: skip
    assert spins[1] == pytest.approx([number(said, "square") * x for x in spins[0]])


def test_what_is_said_of_axes_gravity_and_springs_is_true() -> None:
    scene, graph = read(EXAMPLES / "spatial_3r.toml"), Graph()
    for key in ("variant.sense", "variant.direction"):
        turned, said = single(scene, key)
        joint = next(one for one in turned.joints if one.name == said.places["joint"])
        old = next(one for one in scene.joints if one.name == joint.name)
        axis = values(*(x.express(graph) for x in joint.axis))
        assert axis == [number(said, letter) for letter in "xyz"]
        was = values(*(x.express(graph) for x in old.axis))
        assert sum(a * b for a, b in zip(axis, was, strict=True)) == pytest.approx(-1 if key.endswith("sense") else 0)
    falling, said = single(scene, "variant.gravity")
    shown = [said.places[x].express(graph) for x in "xyz"]  # type: ignore[arg-type]
    assert values(*shown) == values(*(x.express(graph) for x in falling.gravity))
    assert falling.gravity != scene.gravity
    sprung, said = single(scene, "variant.spring")
    k, q = said.places["k"], said.places["q"]
    assert isinstance(k, Symbol)
    assert isinstance(q, Symbol)
    assert k.name not in {one.name for one in scene.parameters}
    E = Energies.of(sprung, graph).P - Energies.of(scene, graph).P
    assert values(E) == pytest.approx(values(graph.symbol(k.name) * graph.symbol(q.name) ** 2 / 2))


@pytest.mark.long
def test_a_variant_of_the_textbook_has_none_of_its_numbers_and_says_what_is_new() -> None:
    drawn = variant(symdyn.example("two_link"), 7)
    document = with_changes(walkthrough(drawn.scene), drawn)

    text = rendered(document, "md")["two_link_7.md"]
    assert isinstance(text, str)
    assert document.sections[0].steps[0].key == "variant"
    assert len(document.sections[0].steps[0].blocks) == len(drawn.changes)
    assert not any(rf"\tag{{{number}}}" in text for number in NUMBERS.values())
    assert not any(step.key.startswith("errata") for section in document.sections for step in section.steps)


def test_a_cart_called_k_takes_another_letter_for_its_spring() -> None:
    text = write_text(symdyn.example("pendulum"), "toml").text.replace('"l"', '"k"').replace("l = {", "k = {")
    scene = read_text(text.replace("-l", "-k"), "k.toml")
    assert "k" in {one.name for one in scene.parameters}

    assert single(scene, "variant.spring")[1].places["k"] == Symbol("k_s")


def test_what_cannot_be_varied_is_said() -> None:
    held = "gravity = [0, 0, 0]\n[bodies.a]\n[joints.j]\ntype = 'revolute'\nparent = 'ground'\nchild = 'a'\n"
    still = read_text(f"{held}axis = [0, 0, 1]\nmotion = '2*t'\n", "still.toml")

    with pytest.raises(TeachError, match="nothing of it can be varied"):
        variant(still, 1)


@pytest.mark.long
@pytest.mark.parametrize("grade", [1, 2, 3])
def test_a_sheet_asks_in_order_with_room_or_with_solutions(grade: int) -> None:
    document = with_exercises(lesson("two_link"), grade)
    questions = [block for _, block in document.blocks() if isinstance(block, Questions)]
    asked, solved = sheet(document), sheet(document, solutions=True)

    steps = asked.sections[-1].steps
    assert [step.key for step in steps] == [f"question:{blank.key}" for blank in questions]
    assert [step.claim.parts[0].split(".")[0] for step in steps if isinstance(step.claim.parts[0], str)] == [
        str(k + 1) for k in range(len(steps))
    ]
    assert all(isinstance(step.blocks[-1], Room) for step in steps)
    assert not any(isinstance(block, Room) for _, block in solved.blocks())
    for blank, step in zip(questions, solved.sections[-1].steps, strict=True):
        assert step.blocks[-len(blank.solution) :] == blank.solution
    for format in ("md", "latex", "html", "notebook"):
        assert "question" in str(next(iter(rendered(asked, format).values()))).lower()


@pytest.mark.long
def test_the_verb_draws_a_variant_and_writes_a_sheet(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = str(EXAMPLES / "cart_pole.toml")

    assert main(["walkthrough", scene, "--seed", "3", "--sheet", "solutions", "--grade", "3", "-o", str(tmp_path)]) == 0
    text = (tmp_path / "cart_pole_3.md").read_text(encoding="utf-8")
    assert "A variant of cart\\_pole" in text
    assert text.count("\n**4. ") == 1
    assert main(["walkthrough", scene, "--ask", "speed", "-o", str(tmp_path)]) == 1
    assert "speed cannot be asked for here; give some of position" in capsys.readouterr().err


def test_sliders_are_of_the_variant_and_ask_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = str(EXAMPLES / "pendulum.toml")

    assert main(["walkthrough", scene, "--format", "sliders", "--seed", "3", "-o", str(tmp_path)]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["pendulum_3.html"]
    assert main(["walkthrough", scene, "--format", "sliders", "--ask", "rate", "-o", str(tmp_path)]) == 1
    assert "--format html for exercises" in capsys.readouterr().err
