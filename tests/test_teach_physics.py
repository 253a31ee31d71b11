"""Questions of physics: their answers against SymPy and by hand, judged by shell and page, before what tells them."""

from __future__ import annotations

from functools import cache
from math import sqrt
from pathlib import Path
from typing import Any

import pytest
import sympy as sp
from browser import opened
from lessons import lesson_of

from symdyn.emit.print.formula_text import text_of
from symdyn.scene import Scene, read, read_text
from symdyn.teach import rendered
from symdyn.teach.document import Blank, Choice, Document, Questions
from symdyn.teach.languages import language_of, languages
from symdyn.teach.practice.exercises import judge, with_exercises
from symdyn.teach.practice.physics import MOST
from symdyn.teach.practice.questions import sheet
from symdyn.teach.render.html import html_page

EXAMPLES = Path(__file__).parent.parent / "examples"

PENDULUM = """
name = "plain_pendulum"
gravity = [0, "-g", 0]
[parameters]
m = { value = 1, unit = "kg", positive = true }
l = { value = 2, unit = "m", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies]
bob = { particles = [{ mass = "m", at = [0, "-l", 0] }] }
[joints]
hinge = { type = "revolute", parent = "ground", child = "bob", axis = [0, 0, 1], coordinate = "theta", drive = false }
"""

HOOP = """
name = "hoop"
gravity = [0, 0, "-g"]
[parameters]
m = { value = 0.1, unit = "kg", positive = true }
R = { value = 0.4, unit = "m", positive = true }
Omega = { value = 8, unit = "rad/s", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies.hoop]
[bodies.bead]
particles = [{ mass = "m", at = [0, 0, "-R"] }]
[joints.spindle]
type = "revolute"
parent = "ground"
child = "hoop"
axis = [0, 0, 1]
coordinate = "psi"
motion = "Omega*t"
drive = "T"
[joints.wire]
type = "revolute"
parent = "hoop"
child = "bead"
axis = [0, -1, 0]
coordinate = "theta"
drive = false
"""

WEIGHT = """
name = "weight"
gravity = [0, 0, "-g"]
[parameters]
m = { value = 2, unit = "kg", positive = true }
k = { value = 50, unit = "N/m", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies]
block = { mass = "m" }
[joints]
slide = { type = "prismatic", parent = "ground", child = "block", axis = [0, 0, 1], coordinate = "z", drive = false }
[springs.spring]
joint = "slide"
stiffness = "k"
"""

HUNG = (
    WEIGHT.replace('"weight"', '"hung"')
    .replace(
        "[joints]",
        """cage = { mass = "m" }
[joints]
shaft = { type = "prismatic", parent = "ground", child = "cage", axis = [0, 0, 1], coordinate = "s", drive = "F" }""",
    )
    .replace('parent = "ground", child = "block"', 'parent = "cage", child = "block"')
)


TUBE = """
name = "tube"
gravity = "none"
[parameters]
m = { value = 2, unit = "kg", positive = true }
k = { value = 50, unit = "N/m", positive = true }
R = { value = 0.5, unit = "m", positive = true }
Omega = { value = 3, unit = "rad/s", positive = true }
[bodies]
tube = {}
ball = { mass = "m" }
[joints.shaft]
type = "revolute"
parent = "ground"
child = "tube"
axis = [0, 0, 1]
coordinate = "psi"
motion = "Omega*t"
drive = "T"
[joints.bore]
type = "prismatic"
parent = "tube"
child = "ball"
axis = [1, 0, 0]
coordinate = "r"
drive = false
[springs.coil]
joint = "bore"
stiffness = "k"
free = "R"
"""


def scene(name: str) -> Scene:
    texts = {"pendulum": PENDULUM, "hoop": HOOP, "weight": WEIGHT, "hung": HUNG, "tube": TUBE}
    if name == "spherical":
        return read(Path(__file__).parent / "data/lessons/spherical.toml")
    return read_text(texts[name], "toml") if name in texts else read(EXAMPLES / f"{name}.toml")


@cache
def asked(name: str, language: str = "en", formulation: str = "") -> Document:
    return with_exercises(lesson_of(scene(name), language, formulation), ask=["physics"])


def question(name: str, kind: str, formulation: str = "") -> Any:
    every = {block.key: block for _, block in asked(name, formulation=formulation).blocks()
             if isinstance(block, Questions)}  # fmt: skip
    return every[f"physics:{kind}"]


def chosen(name: str, kind: str) -> dict[str, bool]:
    """Return what may be chosen, formulas in plain text, and whether it is right."""

    def plain(option: Any) -> str:
        return "".join(x if isinstance(x, str) else text_of(x) for x in option.text.parts)

    return {plain(option): option.right for option in question(name, kind).options}


def symbolic(block: Blank) -> sp.Expr:
    return sp.sympify(text_of(block.answer), {name: sp.Symbol(name, positive=True) for name in block.answer.symbols})


m, mc, mp, length, g, k, R, Omega, w = sp.symbols("m mc mp l g k R Omega theta_dot", positive=True)


def test_a_pendulum_rests_swings_and_pulls_as_by_hand() -> None:
    assert chosen("pendulum", "rest") == {"theta = 0": True, "theta = pi": True, "theta = 0.5*pi": False,
                                          "theta = -0.5*pi": False}  # fmt: skip
    assert [text for text, right in chosen("pendulum", "stable").items() if right] == ["theta = 0"]
    assert sp.simplify(symbolic(question("pendulum", "frequency")) ** 2 - g / length) == 0
    assert [text for text, right in chosen("pendulum", "conserved").items() if right] == ["the energy K: + P:"]
    assert [text for text, right in chosen("pendulum", "sense").items() if right] == ["negative"]
    assert [text for text, right in chosen("pendulum", "unit").items() if right] == ["kg m²"]
    for formulation in ("lagrange", "dalembert"):
        pull = symbolic(question("pendulum", "reaction", formulation))
        assert sp.expand(pull - (m * g + m * length * w**2)) == 0


def test_a_cart_with_a_pole_swings_as_its_determinant_says() -> None:
    """θ from the lower vertical: inertia of a rod about its end, coupled to the cart by half of its length."""
    square, J, c = sp.Symbol("s"), mp * length**2 / 3, mp * length / 2
    roots = sp.solve(((mc + mp) * (-square)) * (mp * g * length / 2 - J * square) - (c * square) ** 2, square)
    (swing,) = [root for root in roots if root != 0]

    assert sp.simplify(symbolic(question("cart_pole", "frequency")) ** 2 - swing) == 0
    assert [text for text, right in chosen("cart_pole", "stable").items() if right] == ["theta = pi"]
    assert [text for text, right in chosen("cart_pole", "conserved").items() if right] == ["none of these"]
    assert [text for text, right in chosen("cart_pole", "unit").items() if right] == ["kg m"]
    assert chosen("cart_pole", "limit")["The mechanism without pole is left."]


def test_two_links_rest_where_the_potential_energy_is_level() -> None:
    q1, q2, m1, m2, h1, h2 = sp.symbols("q1 q2 m1 m2 h1 h2", positive=True)
    P = -g * ((m1 + m2) * h1 * sp.cos(q1) + m2 * h2 * sp.cos(q1 + q2))
    for text, right in chosen("two_link", "rest").items():
        at = {
            sp.Symbol(q, positive=True): sp.sympify(x, rational=True)
            for q, x in (part.split(" = ") for part in text.split(", "))
        }
        assert right == all(sp.diff(P, q).subs(at) == 0 for q in (q1, q2))
        H = sp.hessian(P, (q1, q2)).subs(at)
        least = all(sp.factor(minor).is_positive for minor in (H[1, 1], H.det()))
        assert chosen("two_link", "stable")[text] == (right and least)
    assert [text for text, right in chosen("two_link", "sense").items() if right] == ["positive"]
    assert chosen("two_link", "limit")["The mechanism without link 2 is left."]


def test_a_bead_on_a_turning_hoop_stays_aside_and_keeps_jacobis_integral() -> None:
    level, swing = question("hoop", "steady"), question("hoop", "frequency")

    assert sp.simplify(symbolic(level) - g / (R * Omega**2)) == 0
    known = sqrt(8**2 - 9.81**2 / (0.4 * 8) ** 2)
    assert float(symbolic(swing)) == pytest.approx(known, rel=1e-5)
    for text, right in ((f"{known:.3g}", True), (f"{known * 1.02:.3g}", False),
                        ("sqrt(Omega^2 - g^2/(R Omega)^2)", True), ("Omega", False)):  # fmt: skip
        assert (judge(asked("hoop"), swing.key, text) == "Right.") == right
    (kept,) = [text for text, right in chosen("hoop", "conserved").items() if right]
    th = sp.Symbol("theta", real=True)
    names = {"theta": th, "theta_dot": w, "m": m, "R": R, "g": g, "Omega": Omega}
    whole = m * R**2 * w**2 / 2 - m * R**2 * Omega**2 * sp.sin(th) ** 2 / 2 - m * g * R * sp.cos(th)
    assert sp.simplify(sp.sympify(kept, names) - whole) == 0


def test_a_point_that_stays_aside_on_its_circle_is_asked_for_the_force_that_holds_it() -> None:
    t, up = sp.Symbol("t"), sp.Matrix([0, 0, 1])
    cosine = symbolic(question("hoop", "steady"))
    round_ = sp.sqrt(1 - cosine**2) * sp.Matrix([sp.cos(Omega * t), sp.sin(Omega * t), 0])
    force = m * (R * (round_ - cosine * up)).diff(t, 2) + m * g * up
    held = question("hoop", "reaction")

    assert sp.simplify(force.dot(force) - symbolic(held) ** 2) == 0
    for text, right in (
        ("m*R*Omega^2", True),
        ("|m*R|*Omega^2", True),
        ("m*g", False),
        ("m*R*Omega^2*sin(theta)", False),
    ):
        assert (judge(asked("hoop"), held.key, text) == "Right.") == right
    assert asked("hoop").names[held.key].look.letter == "N"  # R is the radius
    assert asked("pendulum").names[held.key].look.letter == "R"
    assert "physics:reaction" not in {block.key for _, block in asked("tube").blocks() if isinstance(block, Questions)}
    cone = text_of(question("spherical", "reaction").answer)
    assert cone == "l*m*phi_dot**2"  # g/cos(theta) is l times the square of the rate


def test_a_spring_whose_stiffness_vanishes_is_asked_for_beside_a_mass() -> None:
    right = [text for text, yes in chosen("weight", "limit.spring").items() if yes]
    assert right == ["The mechanism without the spring spring is left."]  # the weight still pulls


def test_a_spring_holds_a_weight_and_a_loop_says_where_it_grows() -> None:
    assert sp.simplify(symbolic(question("weight", "place")) + m * g / k) == 0
    assert sp.simplify(symbolic(question("weight", "frequency")) ** 2 - k / m) == 0
    keys = [block.key for _, block in asked("hung").blocks() if isinstance(block, Questions)]
    assert "physics:sense" in keys
    assert "physics:place" not in keys  # a cage that nothing holds rests nowhere
    right = [text for text, right in chosen("four_bar", "stable").items() if right]
    assert [float(text.split()[2].replace("\u2212", "-")) < 0 for text in right] == [True, True]  # the crank hangs
    assert [text for text, right in chosen("cart_with_wheel", "unit").items() if right] == ["N"]


def test_a_loop_is_asked_what_stays_and_which_way_its_drive_holds_it() -> None:
    right = {kind: [x for x, yes in chosen("slider_crank", kind).items() if yes] for kind in ("conserved", "sense")}
    assert right == {"conserved": ["none of these"], "sense": ["positive"]}  # the load takes energy
    reason = next(one.reason for one in question("slider_crank", "sense").options if not one.right)
    value = 0.6 * 9.81 * 0.05 * 0.5 / 2  # the middle of the rod is at r sin(phi) / 2, with phi = pi/3
    assert float(reason.parts[-1].split()[1]) == pytest.approx(value, rel=1e-3)
    assert [x for x, yes in chosen("four_bar", "conserved").items() if yes] == ["the energy K: + P:"]


RULES = language_of("en").mistakes
WRONG = (
    ("g/l", "root"),
    ("2*pi*sqrt(l/g)", "period"),
    ("0.3525", "hertz"),
    ("sqrt(l/g)", "overturned"),
    ("2.837", "period"),
)
PULLED = (
    ("m*g", "centripetal"),
    ("m*(g - l*theta'^2)", "centripetal"),
    ("m*g + m*l*theta'^2/2", "arm"),
    ("m*g + m*l*theta'", "dimension"),
)


def test_a_wrong_frequency_and_a_wrong_reaction_are_told_what_they_are() -> None:
    document = asked("pendulum")
    for key, rows in (("frequency", WRONG), ("reaction", PULLED)):
        for text, rule in rows:
            assert RULES[rule] in judge(document, f"physics:{key}", text), text


def test_a_ball_in_a_turning_tube_and_a_forced_mass_are_asked_by_their_own_letters() -> None:
    """k a/(k - m Ω²) and √(k/m), by hand: no coordinate turns, and a force in time hides the rest."""
    forced = WEIGHT.replace("drive = false", 'drive = false, force = "m*g*cos(w*t)"').replace("[0, 0, 1]", "[1, 0, 0]")
    forced = forced.replace("g = {", 'w = { value = 3, unit = "rad/s", positive = true }\ng = {')
    told = {}
    for name, text in (("tube", TUBE), ("forced", forced)):
        blocks = with_exercises(lesson_of(read_text(text, "toml")), ask=["physics"]).blocks()
        told |= {f"{name}{block.key}": symbolic(block) for _, block in blocks if isinstance(block, Blank)}
    assert sp.simplify(told["tubephysics:steady"] - k * R / (k - m * Omega**2)) == 0
    assert float(told["tubephysics:frequency"]) == pytest.approx(4.0)  # the root of 50/2 - 9
    assert sp.simplify(told["forcedphysics:frequency"] ** 2 - k / m) == 0


@pytest.mark.parametrize("language", languages())
def test_letters_are_judged_with_reasons(language: str) -> None:
    document, words = asked("pendulum", language), language_of(language).lesson

    assert judge(document, "physics:stable", "a") == words["answer.right"]
    assert judge(document, "physics:rest", "(b), a") == words["answer.right"]
    assert judge(document, "physics:rest", "a") == words["answer.more"]
    told = judge(document, "physics:stable", "a, b")
    assert told.startswith(words["answer.chosen"] + " b) ")
    assert "-m l g" in told
    assert judge(document, "physics:stable", "x").endswith("a, b, c, d.")
    assert judge(document, "physics:stable", " ") == words["fault.empty"]


def test_physics_comes_last_is_asked_alone_and_hides_what_answers_it() -> None:
    whole, alone = with_exercises(lesson_of(scene("cart_pole"))), asked("cart_pole")
    keys = [block.key for _, block in whole.blocks() if isinstance(block, Questions)]
    physics = [key for key in keys if key.startswith("physics:")]

    assert 0 < len(physics) <= MOST
    assert keys[-len(physics) :] == physics
    assert [block.key for _, block in alone.blocks() if isinstance(block, Questions)] == physics
    for document in (whole, alone):
        after = [step for part in document.sections if part.key.startswith(("after", "numbers")) for step in part.steps]
        assert after
        assert all(set(physics) <= set(step.needs) for step in after)
    (part,) = [part for part in alone.sections if part.key == "equations"]
    assert not any(step.needs for step in part.steps)


@pytest.mark.parametrize("language", languages())
def test_every_format_shows_what_may_be_chosen_and_the_reasons_behind(language: str) -> None:
    document, words = asked("pendulum", language), language_of(language).lesson
    for format, heading in (("md", "## {}"), ("latex", "lessonpart{{{}}}"), ("notebook", "## {}")):
        text = str(next(iter(rendered(document, format).values())))
        before, found, after = text.partition(heading.format(words["section.solutions"]))
        assert found
        assert "d) " in before
        reason = words["physics.conserved.some"]
        assert reason not in before
        assert reason in after
    assert 'judge(lesson, "physics:rest", answer)' in text.replace('\\"', '"').replace("'", '"')
    solved = str(rendered(sheet(document, solutions=True), "md")["plain_pendulum.md"])
    assert words["physics.right"].format(letters="a, b") in solved
    assert words["physics.right"].format(letters="a, b") not in str(rendered(sheet(document), "md"))


@pytest.mark.long
def test_a_page_counts_judges_choices_and_jumps_by_the_keyboard(browser: Any, tmp_path: Path) -> None:
    document = asked("pendulum")
    path = tmp_path / "lesson.html"
    path.write_text(html_page(document), encoding="utf-8")
    every = [block for _, block in document.blocks() if isinstance(block, Questions)]
    count = f"{len(every)} questions done"

    with opened(browser, path) as page:
        told = page.locator(".progress output")
        assert told.inner_text() == f"0 of {count}"
        assert told.get_attribute("aria-live") == "polite"
        page.locator(".progress button").focus()
        page.keyboard.press("Enter")
        held = "() => document.activeElement.closest('form').dataset.key"
        assert page.evaluate(held) == "physics:rest"
        page.keyboard.press("Space")  # the first option
        page.keyboard.press("Enter")
        verdict = page.locator('form[data-key="physics:rest"] .verdict')
        assert verdict.inner_text() == "Not yet: what you chose is right, and something is missing."
        for box in page.locator('form[data-key="physics:rest"] input').all():
            box.check()
        page.keyboard.press("Enter")
        assert "nothing balances" in verdict.inner_text()
        assert verdict.locator("math").count() > 0
        for block in every:
            form = page.locator(f'form[data-key="{block.key}"]')
            if isinstance(block, Choice):
                for letter, option in block.lettered.items():
                    form.locator(f'input[value="{letter}"]').set_checked(option.right)
            else:
                for text, rule in WRONG if block.key == "physics:frequency" else PULLED:
                    form.locator("input").fill(text)
                    form.locator("button").click()
                    assert RULES[rule] in form.locator(".verdict").inner_text(), text
                form.locator("input").fill("2.215" if block.key == "physics:frequency" else text_of(block.answer))
            assert (
                page.locator("#part-after-rests article:not([hidden]), #part-numbers article:not([hidden])").count()
                == 0
            )
            form.locator("button").click()
            assert form.locator(".verdict").inner_text() == "Right."
        whole = "text => document.querySelector('.progress output').innerText === text"
        page.wait_for_function(whole, arg=f"{len(every)} of {count}")  # a fold tells that it has opened a little later
        assert page.locator(".progress button").is_disabled()
        assert page.evaluate("document.querySelectorAll('article[hidden]').length") == 0
