"""Lessons of, and answers about, five scenes of the seventh sealed set, as a teacher read them."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest
from lessons import lesson_of

from symdyn.algebra import Form, Number, Symbol
from symdyn.emit.print import Latex, Letters
from symdyn.graph import Graph
from symdyn.scene import Scene
from symdyn.scene.toml import read_text
from symdyn.teach import check_derivation, in_words
from symdyn.teach.languages import language_of
from symdyn.teach.render import rendered

SEALED = Path(__file__).parent / "data" / "answers" / "seventh.json.gz"


def scene_of(name: str, *changed: tuple[str, str]) -> Scene:
    text: str = json.loads(gzip.decompress(SEALED.read_bytes()))["scenes"][name]
    for old, new in changed:
        assert old in text
        text = text.replace(old, new)
    return read_text(text, f"{name}.toml")


SAID = (
    ("bead_hoop", "en", (r"$\omega_s^2$ = $\omega^2 -", "Neither energy depends on $\\psi$", "Above the potential $W$",
                         r"about ≈ 0.6684 rad", "$x_1$ = $y_1$ = $z_1$ = 0", "is the rate of an angular momentum"),
     ("seen from the ground:\n\n$$\nx_1", "Noether")),
    ("bead_hoop", "sk", ("Moment, ktorý udržiava predpísaný pohyb", "kmitá okolo nej",
                         r"mínus kinetická energia pri $\dot{\theta}$ = 0", "pretína os"), ("rôznobežn",)),
    ("ladder_person", "en", ("Joints of type custom", "nothing else without a potential", r"l \lvert \sin \phi \rvert",
                             r"P_E = \tfrac{1}{2} l^2 k \sin^2 \phi", "by D'Alembert", "shift along x by",
                             "is 0 W", "about 0 rad", "natural frequency", "integral of the force"),
     ("several degrees", "several parts")),
    ("ladder_person", "sk", ("integrál sily po dráhe", "posunutie pozdĺž x", "Spojenia typu custom"), ("sčítaná",)),
    ("geartrain", "en", ("Joints that others follow: motor", "inertia reduced to", "the holding torque",
                         r"\ddot{\phi} = \frac{r_2 \bigl((M - b \dot{\phi}) r_2 - m r_1 R g\bigr)}",
                         r"\frac{J_2 r_1^2 \dot{\phi}^2}{2 r_2^2}"), (r"\frac{\tfrac", "What multiplies squares")),
    ("geartrain", "sk", ("redukovaný na súradnicu", "prídržný moment"), ()),
    ("gimbal", "en", ("Each equation has one acceleration", "D_{01} =", "the mode shapes", "seen from the tip"),
     ("Cramer", "W_{01}", "an eye")),
    ("gimbal", "sk", ("V každej rovnici je jedno zrýchlenie", "vlastné tvary kmitania"), ("Cramer",)),
    ("incline", "en", (r"\Delta = 4 M + m \bigl(4 - 3 \cos^2(\alpha + \phi)\bigr)",
                       r"\cos(\alpha + \phi) \, \sin(\alpha + \phi)", r"along ($\cos \alpha$, $-\sin \alpha$, $0$)",
                       "the spring is relaxed"),
     (r"m l (\cos \alpha \, \cos \phi", "Noether", "0.9211")),
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("name", "language", "said", "unsaid"), SAID, ids=[f"{x[0]}-{x[1]}" for x in SAID])
def test_a_lesson_says_what_a_teacher_says(
    name: str, language: str, said: tuple[str, ...], unsaid: tuple[str, ...]
) -> None:
    text = str(rendered(lesson_of(scene_of(name), language), "md")[f"{name}.md"])

    assert not [one for one in said if one not in text]
    assert not [one for one in unsaid if one in text]


def test_letters_that_a_lesson_invents_are_none_of_the_scene() -> None:
    hoop = (("omega =", "omega_s ="), ('"omega*t"', '"omega_s*t"'))
    assert Letters(scene_of("bead_hoop"))["omega"] == "omega"
    assert Letters(scene_of("bead_hoop", *hoop))["omega"] == "Omega"
    assert Letters(scene_of("gimbal"))[Letters.COSINES] == "D"


def test_a_fraction_has_its_numbers_below_the_line() -> None:
    graph = Graph()
    form = Form.of(graph.symbol("a") / graph.symbol("b") / 2)
    assert Latex({})(form) == r"\frac{a}{2 b}"
    assert Latex({})(Form.product((Number.ONE, Symbol("a")))) == "a"


M = "(J_1 + (J_2 + m R^2)({0})^2) \\ddot\\phi + b \\dot\\phi + m g R {1}"
WRONG = (
    ("geartrain", "M = " + M.format("r_2/r_1", "r_2/r_1"), "ratio"),
    ("geartrain", "M = " + M.format("r_1/r_2", "r_2/r_1"), "ratio"),
    ("geartrain", "M = " + M.format("1", "r_1/r_2"), "ratio"),
    ("geartrain", "M = (J_1 + (J_2 + m R^2) r_1/r_2) \\ddot\\phi + b \\dot\\phi + m g R r_1/r_2", "ratio"),
    ("geartrain", "M - b \\dot\\phi = " + M.format("r_1/r_2", "r_1/r_2"), "extra"),
    ("incline", "(M+m) s'' + m l/2 φ'' cos(φ-α) - m l/2 φ'^2 sin(φ-α) + b s' + k s - (M+m) g sin α = 0", "clockwise"),
    ("backlash", "T = (J1 + J2) φ'' + J2 ψ''", "force"),
)


LONG = {"incline": pytest.mark.slow, "backlash": pytest.mark.slow}


@pytest.mark.parametrize(
    ("name", "text", "rule"),
    [pytest.param(*x, marks=LONG.get(x[0], ()), id=f"{x[0]}-{x[2]}-{k}") for k, x in enumerate(WRONG)],
)
@pytest.mark.parametrize("language", ["en", "sk"])
def test_a_cause_is_named_as_what_it_is(name: str, text: str, rule: str, language: str) -> None:
    (answer,) = check_derivation(text, scene_of(name), target="tau1")

    assert not answer.right
    assert answer.mistake is not None
    assert answer.mistake.rule == rule
    assert language_of(language).mistakes[rule] in " ".join(in_words(answer, language))
