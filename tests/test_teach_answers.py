"""A student's answer is judged by what it says: however it is spelled if it is right, and never if it says nothing."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from symdyn.algebra import Floats
from symdyn.errors import TeachError
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.resources import folder
from symdyn.scene import Scene, read
from symdyn.scene.toml import read_text
from symdyn.teach.practice.questions import questions_of
from symdyn.teach.student.answer import in_words
from symdyn.teach.student.derivation_check import check_derivation
from symdyn.teach.student.grammar import FUNCTIONS, LETTERS, SHORT
from symdyn.teach.student.statements import read_formula
from symdyn.verdict import Verdict

EXAMPLES = Path(__file__).parent.parent / "examples"
ARM, CART = read(EXAMPLES / "two_link.toml"), read(EXAMPLES / "cart_pole.toml")

SECOND = "m2/2*(h1**2*q1'^2 + h2**2*(q1'+q2')^2 + 2*h1*h2*q1'*(q1'+q2')*cos(q2))"
REST = "m2*h1*h2*sin(q2)*q1'^2 + m2*g*h2*sin(q1+q2)"
SPELLINGS = [
    r"k_z12 = m_2 h_2^2 + m_2 h_1 h_2 \cos(q_2(t))",
    "k_z12 = m2*h2**2 + m2*h1*h2*cos(q2(t))",
    r"k_{z,12} = h_{1} h_{2} m_{2} \cos{\left(q_{2}{\left(t \right)} \right)} + h_{2}^{2} m_{2}",
    r"k_z12 = m2*h2**2 + m2*h1*h2*\cos{\left(\operatorname{q_{2}}{\left(t \right)} \right)}",
    rf"K = m_1/2 h_1^2 (\frac{{d}}{{dt}} q_1)^2 + {SECOND}",
    rf"K = m_1/2 h_1^2 (\frac{{d}}{{d t}} q_{{1}}{{\left(t \right)}})^{{2}} + {SECOND}",
    rf"K = m_1/2 h_1^2 \left(\frac{{\mathrm{{d}} q_1}}{{\mathrm{{d}} t}}\right)^2 + {SECOND}",
    rf"K = m_1/2 h_1^2 \left(\frac{{dq_1(t)}}{{dt}}\right)^2 + {SECOND}",
    f"K = m1/2*h1**2*Derivative(q1(t), t)**2 + {SECOND}",
    f"K = m1/2*h1**2*diff(q1, t)**2 + {SECOND}",
    f"K = m1/2*h1**2*(dq1/dt)^2 + {SECOND}",
    "K = m_1/2 h_1^2 q\u03071² + m2/2*(h1**2*q\u03071² + h2**2*(q\u03071+q\u03072)^2"
    " + 2*h1*h2*q\u03071*(q\u03071+q\u03072)*cos(q2))",
    r"M_2 = (m2*h2^2 + m2*h1*h2*cos(q2))*\frac{d^2}{dt^2} q_1 + m2*h2^2*\frac{d^{2} q_2}{d t^{2}} + " + REST,
    f"M_2 = (m2*h2^2 + m2*h1*h2*cos(q2))*Derivative(q1(t), (t, 2)) + m2*h2^2*Derivative(q2(t), t, t) + {REST}",
    "x1 = h1*sin(q1)",
    "y1 = -h1*cos(q1)",
    r"x_2 = h_1 \sin q_1 + h_2 \sin(q_1+q_2)",
]


@pytest.mark.mends("5.7")
@pytest.mark.parametrize("text", SPELLINGS)
def test_a_right_answer_is_right_however_it_is_spelled(text: str) -> None:
    assert [answer.right for answer in check_derivation(text, ARM)] == [True]


@pytest.mark.long(0)
@pytest.mark.mends("5.7")
@pytest.mark.parametrize(
    "text",
    [
        "x_ddot = ({22}*{r1} + {12}*{r2})/(({11})*{22} - {12}^2)",
        "theta_ddot = (({11})*{r2} + {12}*{r1})/(({11})*{22} - {12}^2)",
    ],
)
def test_an_equation_may_be_solved_for_an_acceleration(text: str) -> None:
    parts = {"{11}": "mc + mp", "{12}": "(mp*l*cos(theta)/2)", "{22}": "(mp*l**2/3)"}
    parts |= {"{r1}": "(F - b*x_dot - mp*l/2*sin(theta)*theta_dot^2)", "{r2}": "(mp*g*l/2*sin(theta))"}
    for name, formula in parts.items():
        text = text.replace(name, formula)

    assert [answer.right for answer in check_derivation(text, CART)] == [True]
    assert not check_derivation(text.replace("mp*g", "2*mp*g").replace("F -", "F +"), CART)[0].right


@pytest.mark.mends("5.7")
@pytest.mark.parametrize(
    "text",
    ["K = K", "tau1 = M_1", "M_1 = tau_1", "L = T - V", "L = K - P", "P = V", "K = K + m1 - m1", "k_z12 = k_z21",
     "K = L + P", "K = L + P + m1 - m1", "k_z12 = k_z21 + m1 - m1"],
)  # fmt: skip
def test_an_answer_that_says_nothing_is_not_right(text: str) -> None:
    assert not any(answer.right for answer in check_derivation(text, ARM))


@pytest.mark.parametrize(
    "text",
    [
        "k_z21 = m2*h2**2 + m2*h1*h2*cos(q2)",
        "P = -m1*g*h1*cos(q1) - m2*g*(h1*cos(q1) + h2*cos(q1+q2)) + (m1 + m2)*g*h1",
    ],
)
def test_an_answer_with_another_zero_or_in_the_other_order_is_right(text: str) -> None:
    assert check_derivation(text, ARM)[0].right
    assert not check_derivation("tau1 = 2*M_1 - M_1", ARM)[0].right


def test_quantities_that_are_written_out_may_be_named() -> None:
    text = f"P = -m1*g*h1*cos(q1) - m2*g*(h1*cos(q1) + h2*cos(q1+q2))\nK = m1/2*h1^2*q1'^2 + {SECOND}\nL = K - P\n"
    text += "k_z12 = m2*h2**2 + m2*h1*h2*cos(q2)\nk_z21 = k_z12\n"
    text += "M_1 = k_z11*q1'' + k_z12*q2'' + k_C1*q1'*q2' + k_D12*q2'^2 + k_G1"

    assert all(answer.right for answer in check_derivation(text, ARM))


def test_an_acceleration_that_no_mass_gives_is_an_answer_like_others() -> None:
    spindle = read_text(
        'name = "spindle"\n[joints.a]\ntype = "revolute"\nparent = "ground"\nchild = "b"\naxis = [0, 0, 1]\n'
        'coordinate = "q1"\n[bodies.b]\nparticles = [{ mass = 1, at = [0, 0, 0.5] }]\n'
    )

    answers = check_derivation("q1_ddot = 2*q1\nK = 0", spindle)

    assert [answer.verdict for answer in answers] == [Verdict.DIFFERENT, Verdict.PROVED]


@pytest.mark.mends("5.7")
def test_an_equation_that_is_divided_and_wrong_is_told_its_one_fault() -> None:
    told = in_words(check_derivation("theta_ddot = 3/(2*l)*(g*sin(theta) - x_ddot*cos(theta))", CART)[0])

    assert len(told) == 2
    assert "wrong sign" in told[1]


@pytest.mark.wide(2)
@pytest.mark.long(0)
@pytest.mark.mends("5.7")
@pytest.mark.parametrize("text", ["M_2 = {}", "{} = M_2"])
def test_the_slope_of_the_kinetic_energy_that_was_forgotten_is_named(text: str) -> None:
    without = "m2*h2^2*q2'' + (m2*h2^2 + m2*h1*h2*cos(q2))*q1'' - m2*h1*h2*sin(q2)*q1'*q2' + m2*g*h2*sin(q1+q2)"

    told = in_words(check_derivation(text.format(without), ARM)[0])

    assert "dK/dq2" in " ".join(told)


# The shell and a page read one grammar

ALIKE = [
    ("h1⁻¹", "1/h1"),
    ("q1’ q1′ q1''", "q1'*q1'*q1''"),
    ("m1\u3000h1\u2009g", "m1*h1*g"),
    ("m1  /  2  h1", "m1*h1/2"),
    (r"\frac{1}{2} \ m_1 \ast \mathbf{h}_1 \nonumber", "0.5*m1*h1"),
    (r"\lvert -m_1 \rvert + \cfrac12 + \underbrace{h_1}_{arm}", "m1 + 1/2 + h1"),
    ("m1/(2) h1 + m1/(-2) h1", "0*m1"),
    ("h1**0.5 + h1^{1/2} + h1**-0.5", "2*sqrt(h1) + 1/sqrt(h1)"),
    ("h1^{1+1} + h1^[2]", "2*h1*h1"),
    ("S q_1 + C q_1 + s q_1 c_{12}", "sin(q1) + cos(q1) + sin(q1)*cos(q1 + q2)"),
    ("ϑ₁ + θ̇₂ + q̈₁ - q̈₁", "q1 + q2'"),
    (r"\operatorname{h}_{\mathrm{1}} m_{\operatorname{2}}", "h1*m2"),
    (r"2|q_1 - 1|q_2 + |q_1||q̇₂|^2", "2*abs(q1 - 1)*q2 + abs(q1)*q2'*q2'"),
    (
        r"\left|q_1\right| + \vert q_2\vert + \lvert q_1 - \lvert q_2\rvert\rvert",
        "abs(q1) + abs(q2) + abs(q1 - abs(q2))",
    ),
    (r"\sin|q_1|/\|q_2\| + ∣h_1∣ + Abs(q_1)", "sin(abs(q1))/abs(q2) + h1 + abs(q1)"),
    *((f"{name}(q_1/3)", f"{function}(q1/3)") for name, function in FUNCTIONS.items()),
    *((rf"\{name}^2 q_1", f"{function}(q1)*{function}(q1)") for name, function in FUNCTIONS.items()),
    *((f"{letter}_1", f"{function}(q1)") for letter, function in SHORT.items()),
]
"""Spellings that one of both read in another way, or not at all, and rows of their tables."""

CAR = read_text(
    "[parameters]\nm = {}\na = {}\nb = {}\nDelta_x = {}\nv0 = {}\nNf = { value = 'm*a/(a + b)' }\n"
    "[inputs.front]\nrates = 1\n[states.i]\nrate = '(front - a*i - b*zf_dot)/m'\n"
    "[joints.ride]\ntype = 'prismatic'\nparent = 'ground'\nchild = 'body'\naxis = [0, 0, 1]\ncoordinate = 'z'\n"
    "[joints.swing]\ntype = 'revolute'\nparent = 'body'\nchild = 'arm'\naxis = [0, 1, 0]\ncoordinate = 'theta'\n"
    "[joints.axle]\ntype = 'prismatic'\nparent = 'ground'\nchild = 'wheel'\naxis = [0, 0, 1]\ncoordinate = 'zf'\n"
    "force = 'i + Delta_x*front_dot + Nf'\n[bodies.body]\nmass = 'm'\n[bodies.arm]\nmass = 'v0'\n"
    "inertia = [0, 'a', 'b']\n[bodies.wheel]\nmass = 'm'\n",
    "car",
)
OF_CAR = [
    ("Nf a + N_f + N_{f}", "m*a/(a + b)*(a + 2)"),
    ("m i' + i_dot + di/dt", "(m + 2)*(front - a*i - b*zf_dot)/m"),
    (r"\dot i + \frac{d i}{d t}", "2*(front - a*i - b*zf_dot)/m"),
    ("d/dt (a i² z + Nf)", "a*(2*i*z*(front - a*i - b*zf_dot)/m + i**2*z_dot)"),
    ("front' + dfront/dt", "2*front_dot"),
    ("z̈f + żf² + m żf a", "zf_ddot + zf_dot**2 + m*zf_dot*a"),
    ("żsinθ + żθ̇ + mża + żf(t)", "z_dot*sin(theta) + z_dot*theta_dot + m*z_dot*a + zf_dot"),
    (r"\dot{z}f + \dot{z}_f + \dot z_{f} + \ddot{z_f} + z_f'' + zf'", "4*zf_dot + 2*zf_ddot"),
    ("dzf/dt + d zf/dt + (dz_f/dt)²", "2*zf_dot + zf_dot**2"),
    (r"d²θ/dt² + d²zf/dt² + d²/dt² z_f + \frac{d^2 z_f}{dt^2} + dθ/dt", "theta_ddot + 3*zf_ddot + theta_dot"),
    ("m {a + b} + √[a² + b²] + √{a} + a {b [a + 2]}", "m*(a + b) + sqrt(a**2 + b**2) + sqrt(a) + a*b*(a + 2)"),
    ("Δx + Δ_x + \\Delta x m + \\Delta_{x}", "(3 + m)*Delta_x"),
    ("v_0 + v₀ + m(t) + front(t)", "2*v0 + m + front"),
    ("sin²θ + sin^2(θ)/2 + 1/2mv0^2", "3/2*sin(theta)**2 + m*v0**2/2"),
    ("e^{-z} + m e^(-a z)", "exp(-z) + m*exp(-a*z)"),
    ("|z - zf| m + |a|", "abs(z - zf)*m + abs(a)"),
    ("a∗b", "a*b"),
    (r"m g a - mga/3 + ɡ \mathrm{g} + 𝑔²", "9.81*m*a*2/3 + 2*9.81**2"),
    ("a sin 2mt + cos^2 b t z", "a*sin(2*m*t) + cos(b*t)**2*z"),
]
"""Names of several letters, names that the scene gives a formula, and g where gravity is a number."""


def _by_page(asked: object, way: str, texts: Sequence[str]) -> list[Any]:
    """Return what the program of a page with these questions makes of texts, in a way written as its program is."""
    scripts = (folder("templates") / "teach" / name for name in ("formulas.js", "terms.js", "answers.js"))
    checker = "\n".join(one.read_text(encoding="utf-8") for one in scripts)
    program = f"const QUESTIONS={json.dumps(asked)};\n{checker}\n"
    program += f"console.log(JSON.stringify({json.dumps(texts)}.map({way})));"
    done = subprocess.run(["node", "-"], input=program, text=True, capture_output=True, check=True)
    found: list[Any] = json.loads(done.stdout)
    return found


@pytest.mark.runs("node")
@pytest.mark.skipif(shutil.which("node") is None, reason="the page's program runs in node")
@pytest.mark.parametrize(("scene", "rows"), [(ARM, ALIKE), (CAR.as_parameters(), OF_CAR)], ids=["arm", "car"])
def test_a_page_reads_every_spelling_as_the_shell_does(scene: Scene, rows: Sequence[tuple[str, str]]) -> None:
    asked = questions_of(scene, {"K:": ("K:", read_formula("1", scene))}, "en")
    read_there = "text => { const read = Formulas.formula(text); return QUESTIONS.points.map(read); }"

    values_there = _by_page(asked, read_there, [text for text, _ in rows])

    for (text, plain), there in zip(rows, values_there, strict=True):
        same = read_formula(plain, scene).express(Graph())
        node = read_formula(text, scene).express(Graph())
        for point, value in zip(asked["points"], there, strict=True):
            values = [
                evaluate([one], Floats(), {x: point[str(x.value)] for x in reachable([one]) if x.op is Op.SYMBOL})[0]
                for one in (same, node)
            ]
            assert values == pytest.approx([value, value], rel=1e-9, abs=1e-12), text


LEG = """
gravity = [0, 0, -9.81]
[parameters]
m = {}
a = {}
[joints.hip]
type = "revolute"
parent = "ground"
child = "leg"
axis = [0, 1, 0]
coordinate = "q"
[bodies.leg]
mass = "m"
com = ["a", 0, 0]
"""


@pytest.mark.runs("node")
@pytest.mark.skipif(shutil.which("node") is None, reason="the page's program runs in node")
def test_both_doors_judge_answers_with_g_where_gravity_is_a_number() -> None:
    scene = read_text(LEG, "leg")
    asked = questions_of(scene, {"P:": ("P:", read_formula("-9.81*m*a*sin(q)", scene))}, "en")
    answers = {
        "-m g a sin q": True,
        "-mga sin(q)": True,
        "-9.81 m a sin q": True,
        "m g a sin q": False,
        "-m a sin q": False,
    }

    there = _by_page(asked, "text => Answers.judge('P:', text).right", list(answers))

    assert there == list(answers.values())
    assert [check_derivation(f"P = {text}", scene)[0].right for text in answers] == there
    assert check_derivation(r"m a^2 \ddot q - m g a \cos q = \tau_1", scene)[0].right


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("-9.81]", "'-9.81*a']", None),
        ("[0, 0, -9.81]", "[0, 6, -8]", None),
        ("[0, 0, -9.81]", "'none'", None),
        ("a = {}", "a = { latex = 'g' }", "a"),
        ("m = {}", "m = {}\ng = { value = 'm/a' }", "m/a"),
        ("0, 0, -9.81", "0, 4, 0", "4"),
    ],
)
def test_g_is_what_the_scene_calls_so_or_gravity_along_one_axis(old: str, new: str, same: str | None) -> None:
    scene = read_text(LEG.replace(old, new), "leg")

    if same:
        assert read_formula("m*g", scene) == read_formula(f"m*({same})", scene)
    else:
        with pytest.raises(TeachError, match="g is no symbol of leg"):
            read_formula("m*g", scene)


@pytest.mark.parametrize(("text", "at"), {"m1*|q_9|": 5, "|q1": 1, "||q1| - q2|": 1, "|q1 - |q2||": 1}.items())
def test_bars_that_do_not_close_and_names_between_bars_are_told_where_they_stand(text: str, at: int) -> None:
    with pytest.raises(TeachError, match=rf"answer:1:{at}: "):
        read_formula(text, ARM)


RUNS = read_text(
    "[parameters]\nk = {}\ng_c = {}\nm_2 = {}\n[joints.a]\ntype = 'prismatic'\nparent = 'ground'\nchild = 'b'\n"
    "axis = [1, 0, 0]\ncoordinate = 'x'\n[bodies.b]\nmass = 'm_2*g_c/k'\n",
    "runs",
)
NO_NAMES = {
    **dict.fromkeys(["k_x", "k_x x", "k_{x}", r"\mathrm{k_x} x", r"k_\mathrm{x}", "3 k_x^2"], "k_x"),
    "2k_xx": "k_xx",
    "m_2g_k": "m_2g_k",
    "kx_kx": "kx_kx",
}
"""What is written with an index that no symbol has, though its letters are symbols, and the name that is refused."""


@pytest.mark.parametrize("text", NO_NAMES)
def test_a_letter_and_its_index_are_one_name_and_no_product(text: str) -> None:
    with pytest.raises(TeachError, match=f" {NO_NAMES[text]} is no symbol of runs; "):
        read_formula(text, RUNS)


@pytest.mark.parametrize("text", ["m_2g_ckx", "m_2g_c k x", "m_{2}g_{c}kx"])
def test_names_with_indices_may_stand_side_by_side(text: str) -> None:
    assert read_formula(text, RUNS) == read_formula("m_2*g_c*k*x", RUNS)


@pytest.mark.runs("node")
@pytest.mark.skipif(shutil.which("node") is None, reason="the page's program runs in node")
def test_a_page_refuses_an_index_that_no_symbol_has_by_the_same_name() -> None:
    told = "text => { try { Formulas.formula(text); return text; } catch (fault) { return [fault.key, fault.text]; } }"
    asked = questions_of(RUNS, {"K:": ("K:", read_formula("k", RUNS))}, "en")

    said = _by_page(asked, told, [*NO_NAMES, "m_2g_ckx"])

    assert said == [*(["fault.name", name] for name in NO_NAMES.values()), "m_2g_ckx"]


def test_every_letter_is_read_as_its_command() -> None:
    names = sorted({f"{name}_0" for name in LETTERS.values()})
    greek = read_text(
        f"[parameters]\n{chr(10).join(f'{name} = {{}}' for name in names)}\n[joints.a]\ntype = 'revolute'\n"
        f"parent = 'ground'\nchild = 'b'\naxis = [0, 0, 1]\n[bodies.b]\nmass = '{' + '.join(names)}'\n",
        "greek",
    )

    for letter, name in LETTERS.items():
        assert read_formula(f"{letter}₀ + {letter}_{{0}}", greek) == read_formula(rf"\{name}_0 + {name}0", greek)
