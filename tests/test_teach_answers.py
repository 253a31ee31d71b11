"""A student's answer is judged by what it says: however it is spelled if it is right, and never if it says nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.scene import read
from symdyn.scene.toml import read_text
from symdyn.teach.student.answer import in_words
from symdyn.teach.student.derivation_check import check_derivation
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


@pytest.mark.mends("5.7")
@pytest.mark.parametrize("text", ["M_2 = {}", "{} = M_2"])
def test_the_slope_of_the_kinetic_energy_that_was_forgotten_is_named(text: str) -> None:
    without = "m2*h2^2*q2'' + (m2*h2^2 + m2*h1*h2*cos(q2))*q1'' - m2*h1*h2*sin(q2)*q1'*q2' + m2*g*h2*sin(q1+q2)"

    told = in_words(check_derivation(text.format(without), ARM)[0])

    assert "dK/dq2" in " ".join(told)
