"""Lessons of contacts and impact: formulas by value, the run, series and sweet spot, and what is refused."""

from __future__ import annotations

import random
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import opened
from lessons import lesson_of

import symdyn
from symdyn.algebra import Floats, Form
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import EmitError
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.scene import Scene, read_text
from symdyn.table import Table
from symdyn.teach import rendered, walkthrough
from symdyn.teach.document import Document, Formula, Section
from symdyn.teach.languages import languages
from symdyn.teach.practice.variants import variant
from symdyn.teach.render.html import html
from symdyn.teach.render.markdown import markdown

pytestmark = pytest.mark.runs

SCENES = Path(__file__).parent / "data" / "impacts" / "scenes"
BALL = symdyn.read(SCENES / "bouncing_ball.toml")
ROD = """
name = "falling_rod"
gravity = [0, "-g", 0]
[parameters]
m = 1
l = 0.5
I = "1/12"
mu = 0.36
g = 9.81
[bodies]
slide = {}
lift = {}
rod = { mass = "m", inertia = ["I", "I", "I"], inertia_about = "com" }
[joints]
px = { type = "prismatic", parent = "ground", child = "slide", axis = [1, 0, 0], coordinate = "x", drive = false }
[joints.py]
type = "prismatic"
parent = "slide"
child = "lift"
axis = [0, 1, 0]
coordinate = "y"
drive = false
start = 1
[joints.turn]
type = "revolute"
parent = "lift"
child = "rod"
axis = [0, 0, 1]
coordinate = "theta"
drive = false
start = 0.3
[contacts.foot]
type = "point"
body = "rod"
at = [0, "-l", 0]
plane = { normal = [0, 1, 0] }
friction = "mu"
restitution = 0.5
law = "newton"
"""
BAT = """
name = "bat"
gravity = [0, 0, 0]
[parameters]
m = 0.9
l = 0.55
I = 0.05
d = 0.7
[bodies]
bat = { mass = "m", com = [0, "-l", 0], inertia = ["I", "I/10", "I"], inertia_about = "com" }
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bat"
axis = [0, 0, 1]
coordinate = "phi"
drive = false
start = 0.5
start_rates = -2
[contacts.post]
type = "point"
body = "bat"
at = [0, "-d", 0]
plane = { normal = [1, 0, 0] }
restitution = 0.5
"""


PAIR = """
name = "pair"
[parameters]
m_1 = 1
m_2 = 2
l_1 = 0.5
l_2 = 0.4
mu = 0.3
[bodies]
upper = { particles = [{ mass = "m_1", at = ["l_1", 0, 0] }] }
lower = { particles = [{ mass = "m_2", at = ["l_2", 0, 0] }] }
[joints]
shoulder = { type = "revolute", parent = "ground", child = "upper", axis = [0, 0, 1], coordinate = "phi", start = -1 }
[joints.elbow]
type = "revolute"
parent = "upper"
child = "lower"
origin = ["l_1", 0, 0]
axis = [0, 0, 1]
coordinate = "psi"
start = 0.4
[contacts.wall]
body = "lower"
at = ["l_2", 0, 0]
plane = { normal = [0, 1, 0], at = [0, -0.75, 0] }
restitution = 0.6
friction = "mu"
"""


def contacts(document: Document) -> Section:
    (found,) = (one for one in document.sections if one.key == "contacts")
    return found


def values(document: Document, seed: int = 1) -> dict[str, float]:
    rng = random.Random(seed)
    scene = document.scene
    return {
        name: rng.uniform(0.3, 1.2)
        for name in (*(p.name for p in scene.parameters), *scene.coordinates, *scene.velocities)
    }


def number(node: Expr | None, given: dict[str, float]) -> float:
    assert node is not None
    known = {x: given[str(x.value)] for x in reachable([node]) if x.op is Op.SYMBOL}
    return float(evaluate([node], Floats(), known)[0])


@pytest.mark.parametrize("text", [BAT, ROD], ids=["bat", "rod"])
def test_formulas_are_worth_what_their_names_are(text: str) -> None:
    document = lesson_of(read_text(text))
    given, seen = values(document), 0
    for step in contacts(document).steps:
        for block in step.opened():
            if not isinstance(block, Formula) or not block.left:
                continue
            node = document.names[block.left].node
            if node is not None:
                assert number(document.value(block.form), given) == pytest.approx(number(node, given))
                seen += 1
    assert seen >= 5


@pytest.mark.parametrize("seed", range(6))
def test_the_table_of_an_impact_is_the_output(seed: int) -> None:
    """By Newton's law there is one phase: the line that holds first is what `impact:foot` gives."""
    scene = read_text(ROD)
    document = lesson_of(scene)
    given = values(document, seed) | {"y_dot": -3.0, "x_dot": 2.0 * (-1) ** seed * seed}
    (table, *_) = next(one for one in contacts(document).steps if one.key.startswith("impact:foot")).blocks
    assert isinstance(table, Table), "the modes are a table"
    speed = number(document.names["slip:"].node, given)
    D = {key: number(document.names[f"{key}:"].node, given) for key in ("Dnn", "Dnt", "Dtt")}
    for k, (_, normal, along, _) in enumerate(table.rows):
        first, second = normal.parts[0], along.parts[0]
        assert isinstance(first, Form), "each force is a formula"
        assert isinstance(second, Form), "each force is a formula"
        forces = [number(document.value(first), given)]
        given["percussionn:"] = forces[0]
        forces.append(number(document.value(second), given))
        steep = D["Dnn"] > given["mu"] * D["Dnt"]
        slip = speed + D["Dnt"] * forces[0] + D["Dtt"] * forces[1]
        if (abs(forces[1]) <= given["mu"] * forces[0], slip > 0 and steep, True)[k]:
            break
    w = Workspace(scene)
    found = evaluate(derive_one(w, "impact:foot").entries, Floats(), {w.graph.symbol(x): y for x, y in given.items()})
    assert found[-2:] == pytest.approx(forces, rel=1e-9)


def test_reaction_percussions_are_what_the_momentum_of_all_beyond_changes_by() -> None:
    document = lesson_of(read_text(PAIR))
    given = values(document) | {"jump:1": 0.7, "jump:2": -1.3, "percussionn:": 2.1, "percussiont:": 0.4}
    phi, both = given["phi"], given["phi"] + given["psi"]
    first = 0.7 * given["l_1"] * np.array([-np.sin(phi), np.cos(phi)])
    second = first + (0.7 - 1.3) * given["l_2"] * np.array([-np.sin(both), np.cos(both)])
    outer = given["m_2"] * second - np.array([0.4, 2.1])
    wanted = dict(zip(("0:1", "1:1", "0:2", "1:2"), (*(given["m_1"] * first + outer), *outer), strict=True))
    (step,) = (one for one in contacts(document).steps if one.key == "contacts:joints:wall")
    found = {
        block.left: number(document.value(block.form), given) for block in step.blocks if isinstance(block, Formula)
    }
    assert found == pytest.approx({f"felt:{key}:": x for key, x in wanted.items()})
    assert step.reference == "(5.18)"


def test_newtons_law_gains_what_the_lesson_says() -> None:
    """Where the contact sticks, at the slip of the largest gain, in a run of the output beside the formula."""
    scene = read_text(PAIR.replace('friction = "mu"', 'friction = "mu"\nlaw = "newton"'))
    document = lesson_of(scene)
    (step,) = (one for one in contacts(document).steps if one.key == "contacts:gains:wall")
    formula, _, _, table, worst = step.blocks
    assert isinstance(formula, Formula)
    assert isinstance(table, Table)
    newton, poisson = (int("".join(map(str, row[1].parts))) for row in table.rows)
    assert newton > 0
    assert poisson == 0
    assert "2.56 m/s" in str(worst)
    given = values(document) | {"phi": 1.23, "psi": 0.0596, "m_1": 1, "m_2": 2, "l_1": 0.5, "l_2": 0.4}
    w, e = Workspace(scene), 0.6
    W, C, after = (derive_one(w, f"{name}:wall").entries for name in ("gap_jacobian", "impact_matrix", "impact"))
    at = {w.graph.symbol(x): y for x, y in given.items()}
    W, C = (np.array([float(x) for x in evaluate(x, Floats(), at)]) for x in (W, C))
    W, C = W.reshape(3, 2)[:2], C.reshape(2, 3)[:, :2]
    (a, b), (_, c) = D = W @ C
    least = e * abs(b) * a / ((1 + e) * a * c - b * b)
    u = C @ np.linalg.solve(D, [-1.0, -b / a])
    at |= {w.graph.symbol(x): y for x, y in zip((*scene.velocities, "mu"), (*u, 1.01 * least), strict=True)}
    *moved, normal, along = (float(x) for x in evaluate(after, Floats(), at))
    assert abs(along) == pytest.approx(least * normal), "it sticks, with as much friction as the lesson asks for"
    gained = np.array([normal, along]) @ (W @ (u + moved)) / 2
    told = number(document.value(formula.form), {str(x.value): float(y) for x, y in at.items()})
    assert told == pytest.approx(gained)
    assert gained == pytest.approx((b * b / a - (1 - e * e) * c) / (a * c - b * b) / 2)
    assert (gained > 0) == (b * b > (1 - e * e) * a * c)


def test_painleves_places_begin_where_genot_and_brogliato_have_them() -> None:
    section = contacts(lesson_of(read_text(ROD)))
    (step,) = (one for one in section.steps if one.key == "contacts:painleve:foot")
    assert [(one.name, pytest.approx(4 / 3)) for one in step.tries] == [("mu", step.tries[0].threshold)]
    page = str(next(iter(rendered(lesson_of(read_text(ROD)), "html").values())))
    assert "data-try=" in page
    assert re.search(r'class="[^"]* level"', page)


def test_a_contact_that_one_freedom_ties_says_so() -> None:
    text = BAT.replace("restitution = 0.5", "restitution = 0.5\nfriction = 0.3")
    section = contacts(lesson_of(read_text(text)))
    assert "with one freedom" in str(next(one for one in section.steps if one.key == "contacts:impact:post").claim)
    assert not [one for one in section.steps if one.key.startswith(("contacts:gains", "contacts:painleve"))]


def test_a_ball_rests_when_its_series_says() -> None:
    for language in languages():
        text = str(next(iter(markdown(lesson_of(BALL, language)).values())))
        assert r"\Delta t = \frac{2 \dot{\delta}^{+}}{g (1 - e)}" in text
        assert "4.064" in text or "4,064" in text


def test_the_sweet_spot_is_the_centre_of_percussion() -> None:
    text = str(next(iter(markdown(lesson_of(read_text(BAT))).values())))
    assert r"d = \frac{I}{l m} + l" in text
    rod = (
        BAT.replace("I = 0.05\n", "")
        .replace("l = 0.55", "l = 1")
        .replace('"-l"', '"-l/2"')
        .replace('"I"', '"m*l**2/12"')
    )
    text = str(next(iter(markdown(lesson_of(read_text(rod.replace('"I/10"', '"m*l**2/120"')))).values())))
    assert r"d = \tfrac{2}{3} l" in text


def test_loops_with_contacts_are_refused_in_words() -> None:
    scene: Scene = symdyn.example("four_bar")
    text = symdyn.scene.write_text(scene, "toml").text
    body = scene.bodies[-1].name
    with pytest.raises(EmitError, match=r"a lesson of loops, rows or quaternions knows no contacts .* floor; take"):
        walkthrough(read_text(f'{text}\n[contacts.floor]\nbody = "{body}"\n'))


def test_variants_leave_planes_and_what_strikes_them() -> None:
    for seed in range(6):
        assert {one.key for one in variant(BALL, seed).changes} <= {"variant.mass", "variant.spring"}


def test_dry_friction_of_a_joint_has_its_modes() -> None:
    text = """
gravity = [0, 0, 0]
[bodies]
rotor = { inertia = [2, 2, 2], inertia_about = "com" }
[joints.shaft]
type = "revolute"
parent = "ground"
child = "rotor"
axis = [0, 0, 1]
coordinate = "phi"
drive = false
start_rates = 3
friction = { coulomb = 3 }
"""
    shown = str(next(iter(markdown(lesson_of(read_text(text))).values())))
    assert "| sticks | $s$ = 0 | the amount of $\\lambda_t$ is" in shown
    assert "| 2 s | shaft\\_friction sticks |" in shown


def test_what_a_page_plays_is_a_run_whose_forces_balance_inside_their_cone() -> None:
    shown = lesson_of(symdyn.read(SCENES / "brick.toml"))
    step = next(one for x in shown.sections for one in x.steps if one.key.startswith("contacts:laws"))
    assert shown.played is not None
    assert "cone" in step.show
    _, x, _, speed, _, *qdd, missed, _, _, _, along, up, _, _, n, _, mode = np.array(shown.played.rows).T
    gravity = 9.81 * np.array([np.sin(0.3), -np.cos(0.3)])

    assert np.transpose(qdd) == pytest.approx(np.stack([along, up], axis=1) + gravity, abs=1e-4)  # mass 1, six digits
    assert np.all(np.abs(along) <= 0.5 * up + 1e-4)
    assert np.all(n == 1)
    assert np.all(along[mode == 2] == pytest.approx(-0.5 * up[mode == 2], rel=1e-4))
    assert {*mode} == {1, 2}
    assert x[-1] == pytest.approx(2**2 / 2 / (9.81 * (0.5 * np.cos(0.3) - np.sin(0.3))), 1e-4)
    assert speed[-1] == 0
    assert np.abs(missed).max() < 1e-9


@pytest.mark.slow
def test_a_page_plays_impacts_and_moves_on_without_once_it_is_changed(browser: Any, tmp_path: Path) -> None:
    place = tmp_path / "ball.html"
    place.write_text(html(lesson_of(BALL))["bouncing_ball.html"])
    run = symdyn.simulate(BALL, until=2, every=0.04)

    with opened(browser, place) as page:

        def stepped() -> float:
            page.evaluate("document.querySelector('[data-do=step]').click()")
            return float(page.evaluate("symdyn.bouncing_ball.state().q[0]"))

        played = [stepped() for _ in range(48)]
        page.evaluate("symdyn.bouncing_ball.set(0, 0.3)")
        changed = [stepped() for _ in range(30)]
    assert min(played) >= 0 > min(changed)
    assert played == pytest.approx(run["z"][1:49], abs=1e-2)  # straight between rows
