"""Springs on one line: lessons take their ends to keep their order, generated code does not."""

from __future__ import annotations

from pathlib import Path

import pytest
from lessons import lesson_of

from symdyn import equations
from symdyn.algebra.numeric import Floats
from symdyn.dynamics import closed_form
from symdyn.graph import Graph, evaluate
from symdyn.scene import read, read_text
from symdyn.teach import Document, check_derivation, rendered
from symdyn.teach.notation import in_order, ordered_ways
from symdyn.teach.student.diagnosis import Diagnosis
from symdyn.verdict import Verdict

SCENE = Path(__file__).parent / "data/found/coupled.toml"
SAID = {
    "en": "That holds as long as $l + q_1$ \\> 0, $q_2 + l - q_1$ \\> 0, $l - q_2$ \\> 0.",
    "sk": "Platí to, kým $l + q_1$ \\> 0, $q_2 + l - q_1$ \\> 0, $l - q_2$ \\> 0.",
}


@pytest.mark.parametrize("language", SAID)
def test_the_coupled_oscillator_is_linear_and_says_how_long(language: str) -> None:
    document: Document = lesson_of(read(SCENE), language)
    text = rendered(document, "md")["coupled.md"]

    assert "sqrt" not in text
    assert SAID[language] in text
    for shown in (
        r"\ddot q_1 + \underbrace{(k_1 q_1 - k (q_2 - q_1))}_{k_{E,1}}",
        r"\ddot q_2 + \underbrace{(k (q_2 - q_1) + k_2 q_2)}_{k_{E,2}}",
        r"K_s = \begin{bmatrix} k_1 + k & -k \\ -k & k + k_2 \end{bmatrix}",
        r"b_s = \frac{m_1 k + m_1 k_2 + m_2 k_1 + m_2 k}{m_2 m_1}",
        r"d_s = \frac{k_1 k + k_1 k_2 + k k_2}{m_2 m_1}",
    ):
        assert shown in text


def test_equal_masses_swing_together_and_against_each_other() -> None:
    """ω² = k₁/m together, (k₁ + 2 k)/m against each other."""
    text = SCENE.read_text(encoding="utf-8")
    for two, one in (('mass = "m2"', 'mass = "m1"'), ('stiffness = "k2"', 'stiffness = "k1"')):
        text = text.replace(two, one)
    lines = (line for line in text.splitlines() if not line.startswith(("m2 =", "k2 =")))
    shown = rendered(lesson_of(read_text("\n".join(lines))), "md")["coupled.md"]

    assert r"determinant of $K_s - \omega_s^2 M_s$ is zero" in shown
    assert r"\omega_{s,1}^2 = \frac{k_1}{m_1}" in shown
    assert r"\omega_{s,2}^2 = \frac{k_1 + 2 k}{m_1}" in shown


def test_a_cubic_spring_has_one_power_of_its_stretch() -> None:
    text = SCENE.read_text(encoding="utf-8").replace('stiffness = "k"', 'stiffness = ["k", 0, "k3"]')
    scene = read_text(text.replace("[parameters]", "[parameters]\nk3 = {}"))
    shown = rendered(lesson_of(scene), "md")["coupled.md"]

    for power in (r"+ \tfrac{1}{4} k_3 (q_2 - q_1)^4 +", r"k_{E,2} = k (q_2 - q_1) + k_3 (q_2 - q_1)^3 + k_2 q_2"):
        assert power in shown
    assert "(q_2 - q_1) (q_2 - q_1)" not in shown
    found, stretch = equations(scene), r"(s_{\mathrm{middle}} - l)"
    assert f"k_3 {stretch}^3" in found.latex()
    assert f"{stretch} {stretch}" not in found.latex()
    assert "k3*(s_middle - l)**3" in found.text()


@pytest.mark.parametrize(
    ("answer", "verdict"),
    [
        ("m1*q1_ddot + k1*q1 = k*(q2 - q1)", Verdict.PROVED),
        ("m2*q2_ddot + k2*q2 - k*(q1 - q2) = 0", Verdict.PROVED),
        ("P = k1*q1**2/2 + k*(q2 - q1)**2/2 + k2*q2**2/2", Verdict.PROVED),
        ("m1*q1_ddot + k1*q1 = k*(q1 - q2)", Verdict.DIFFERENT),
        ("m1*q1_ddot + k1*q1 = 0", Verdict.DIFFERENT),
    ],
)
def test_an_answer_in_differences_is_judged(answer: str, verdict: Verdict) -> None:
    assert [one.verdict for one in check_derivation(answer, read(SCENE))] == [verdict]


def test_equations_hold_on_both_sides() -> None:
    """Printed equations and code know no order: there a length is an amount, and its force turns where ends pass."""
    scene = read(SCENE)
    text = equations(scene).text()

    assert "s_middle = abs(l - q1 + q2)" in text
    assert "sqrt" not in text


RAIL = """
name = "rail"
gravity = "none"
[bodies.m]
mass = 2
[joints.x]
type = "prismatic"
parent = "ground"
child = "m"
axis = [1, 0, 0]
coordinates = ["x"]
start = START
drive = false
[springs.s]
from = { body = "ground", at = [1, HIGH, 0] }
to = "m"
stiffness = 3
free = 0.4
"""


@pytest.mark.parametrize(
    ("start", "high", "rests"), [("0", "0", 0.6), ("2", "0", 1.4), ("1", "0", None), ("0", "1", None)]
)
def test_the_branch_is_that_of_the_start(start: str, high: str, rests: float | None) -> None:
    """It rests 0.4 behind the point or 0.4 before it; off the line, or where both meet at the start, the root stays."""
    scene = in_order(read_text(RAIL.replace("START", start).replace("HIGH", high)))

    assert scene.struts[0].is_ordered == (rests is not None)
    if rests is not None:
        force = closed_form(scene).form("k_E", 0).express(Graph())
        for x in (-3.0, 0.3, 2.5):
            assert evaluate([force], Floats(), {force.graph.symbol("x"): x}) == [pytest.approx(3 * (x - rests))]


def test_a_root_or_an_amount_of_a_distance_is_the_distance() -> None:
    energy = "P = k_1 q_1^2/2 + k/2 ({} - l)^2 + k_2/2 q_2^2"
    for length in ("sqrt((l + q_2 - q_1)^2)", "sqrt((q_1 - q_2 - l)^2)", "abs(l + q_2 - q_1)", "(l + q_2 - q_1)"):
        (answer,) = check_derivation(energy.format(length), read(SCENE))
        assert answer.right, length
    (answer,) = check_derivation(energy.format("sqrt((l + q_2 + q_1)^2)"), read(SCENE))
    assert answer.verdict == Verdict.DIFFERENT


@pytest.mark.parametrize("text", [SCENE.read_text(), RAIL.replace("START", "2").replace("HIGH", "0")])
def test_answers_are_judged_where_ends_keep_their_order(text: str) -> None:
    """A root of a distance is what the lesson shows at all points that a page compares at."""
    scene = in_order(read_text(text))
    ways = [way.express(Graph()) for way in ordered_ways(scene)]
    diagnosis = Diagnosis(scene)

    assert ways
    for point in (*diagnosis.points.at, *diagnosis.motions.along):
        for way in ways:
            assert evaluate([way], Floats(), {way.graph.symbol(x): y for x, y in point.items()})[0] > 0


def test_ends_that_meet_at_zero_are_a_lesson() -> None:
    """There the root has no slope, which ended the lesson with a traceback."""
    scene = read_text(RAIL.replace("[1, HIGH, 0]", "[0, 0, 0]").replace("START", "0"))

    assert "sqrt" in rendered(lesson_of(scene), "md")["rail.md"]
