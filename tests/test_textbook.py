"""Every numbered equation (5.21)-(5.55) of the textbook, proved against the derived equations, misprints included.

Example 5.28, figure 5.40. Each row has the equation as it is right, typed by hand; where the text as transcribed says
otherwise, a row of `ERRATA` has it as it stands there, and the test shows that it is wrong.
"""

from __future__ import annotations

import re

import pytest
from textbook import Arm, verdict, with_friction

from symdyn.graph import gradient, substitute
from symdyn.verdict import Verdict


@pytest.fixture(scope="module", params=["lagrange", "recursive"])
def arm(request):
    return Arm(request.param)


ROW_1 = "((m1+m2)*h1**2 + m2*h2**2 + 2*m2*h1*h2*c2)*a1 + (m2*h2**2 + m2*h1*h2*c2)*a2"
VELOCITY_1 = "- 2*m2*h1*h2*s2*v1*v2 - m2*h1*h2*s2*v2**2"
GRAVITY_1 = "((m1+m2)*h1*s1 + m2*h2*s12)*g"

EQUATIONS = [  # number, what is derived, what the book says
    ("5.24", lambda arm: arm.energy("kinetic_energy", 1), "1/2*m1*h1**2*v1**2"),
    ("5.25", lambda arm: arm.energy("potential_energy", 1), "-m1*g*h1*c1"),
    ("5.28", lambda arm: arm.place("end2")[0], "h1*s1 + h2*s12"),
    ("5.29", lambda arm: arm.place("end2")[1], "-h1*c1 - h2*c12"),
    ("5.30", lambda arm: arm.twist("end2")[0], "h1*c1*v1 + h2*c12*(v1+v2)"),
    ("5.31", lambda arm: arm.twist("end2")[1], "h1*s1*v1 + h2*s12*(v1+v2)"),
    (
        "5.32",
        lambda arm: arm.twist("end2")[0] ** 2 + arm.twist("end2")[1] ** 2,
        "h1**2*v1**2 + h2**2*(v1**2 + 2*v1*v2 + v2**2) + 2*h1*h2*c2*(v1**2 + v1*v2)",
    ),
    ("5.33", lambda arm: arm.energy("potential_energy", 2), "m2*g*y2"),
    ("5.34", lambda arm: arm.energy("potential_energy", 2), "-m2*g*h1*c1 - m2*g*h2*c12"),
    (
        "5.35",
        lambda arm: arm.L,
        "1/2*(m1+m2)*h1**2*v1**2 + 1/2*m2*h2**2*(v1**2 + 2*v1*v2 + v2**2)"
        "+ m2*h1*h2*c2*(v1**2 + v1*v2) + (m1+m2)*g*h1*c1 + m2*g*h2*c12",
    ),
    (
        "5.37",
        lambda arm: arm.momentum(1),
        "(m1+m2)*h1**2*v1 + m2*h2**2*v1 + m2*h2**2*v2 + 2*m2*h1*h2*c2*v1 + m2*h1*h2*c2*v2",
    ),
    ("5.38", lambda arm: arm.rate(arm.momentum(1)), ROW_1 + VELOCITY_1),
    ("5.39", lambda arm: arm.slope(1), "-(m1+m2)*g*h1*s1 - m2*g*h2*s12"),
    ("5.40", lambda arm: arm.torque(1), f"{ROW_1} {VELOCITY_1} + {GRAVITY_1}"),
    ("5.40 k_z11", lambda arm: arm.k("z", 1, 1), "(m1+m2)*h1**2 + m2*h2**2 + 2*m2*h1*h2*c2"),
    ("5.40 k_z12", lambda arm: arm.k("z", 1, 2), "m2*h2**2 + m2*h1*h2*c2"),
    ("5.40 k_C1", lambda arm: -arm.k("C", 1), "2*m2*h1*h2*s2"),  # the book pulls the minus in front
    ("5.40 k_D12", lambda arm: -arm.k("D", 1, 2), "m2*h1*h2*s2"),
    ("5.40 k_G1", lambda arm: arm.k("G", 1), GRAVITY_1),
    ("5.41", lambda arm: arm.momentum(2), "m2*h2**2*v1 + m2*h2**2*v2 + m2*h1*h2*c2*v1"),
    (
        "5.42",
        lambda arm: arm.rate(arm.momentum(2)),
        "m2*h2**2*a1 + m2*h2**2*a2 + m2*h1*h2*c2*a1 - m2*h1*h2*s2*v1*v2",
    ),
    ("5.43", lambda arm: arm.slope(2), "-m2*h1*h2*s2*(v1**2 + v1*v2) - m2*g*h2*s12"),
    (
        "5.44",
        lambda arm: arm.torque(2),
        "(m2*h2**2 + m2*h1*h2*c2)*a1 + m2*h2**2*a2 + m2*h1*h2*s2*v1**2 + m2*h2*s12*g",
    ),
    ("5.44 k_z21", lambda arm: arm.k("z", 2, 1), "m2*h2**2 + m2*h1*h2*c2"),
    ("5.44 k_z22", lambda arm: arm.k("z", 2, 2), "m2*h2**2"),
    ("5.44 k_C2", lambda arm: -arm.k("C", 2), "0"),
    ("5.44 k_D21", lambda arm: -arm.k("D", 2, 1), "-m2*h1*h2*s2"),
    ("5.44 k_G2", lambda arm: arm.k("G", 2), "m2*h2*s12*g"),
    ("5.45", lambda arm: arm.k("z", 1, 1), "(m1+m2)*h1**2 + m2*h2**2 + 2*m2*h1*h2*c2"),
    ("5.46", lambda arm: arm.k("z", 1, 1), "m1*h1**2 + m2*(x2**2 + y2**2)"),
    ("5.47", lambda arm: arm.induced(1, "a1"), "((m1+m2)*h1**2 + m2*h2**2 + 2*m2*h1*h2*c2)*a1"),
    ("5.48", lambda arm: arm.induced(2, "a2"), "m2*h2**2*a2"),
    ("5.49", lambda arm: arm.k("z", 2, 2), "m2*h2**2"),
    ("5.50", lambda arm: arm.induced(1, "a2"), "(m2*h2**2 + m2*h1*h2*c2)*a2"),
    ("5.51", lambda arm: arm.k("z", 1, 2), "m2*h2**2 + m2*h1*h2*c2"),
    ("5.52", lambda arm: arm.k("z", 1, 2) - arm.k("z", 2, 2), "m2*h1*h2*c2"),
    ("5.53", lambda arm: arm.induced(2, "a1"), "(m2*h2**2 + m2*h1*h2*c2)*a1"),
    ("5.55", lambda arm: arm.induced(1, "v1"), "0"),
    ("5.55 k_D11", lambda arm: arm.k("D", 1, 1), "0"),
]


@pytest.mark.long
@pytest.mark.parametrize(("derived", "formula"), [row[1:] for row in EQUATIONS], ids=[row[0] for row in EQUATIONS])
def test_equation_of_the_textbook(arm, derived, formula):
    assert verdict(derived(arm), arm.typed(formula)) == Verdict.PROVED


ERRATA = [  # number, what is derived, what the transcribed text says
    ("5.33 sign", lambda arm: arm.energy("potential_energy", 2), "-m2*g*y2"),
    (
        "5.37 third term",
        lambda arm: arm.momentum(1),
        "(m1+m2)*h1**2*v1 + m2*h2**2*v1 + m2*h2**2*v2 + 2*m2*h1*h2*c2*v2 + m2*h1*h2*c2*v2",
    ),
    ("5.40 m1 in the coefficient of a2", lambda arm: arm.k("z", 1, 2), "m2*h2**2 + m1*h1*h2*c2"),
    ("5.40 coefficient of a2 called k_z22", lambda arm: arm.k("z", 2, 2), "m2*h2**2 + m2*h1*h2*c2"),
    ("5.40 cosine in k_D12", lambda arm: -arm.k("D", 1, 2), "m2*h1*h2*c2"),
    (
        "5.40 altogether",
        lambda arm: arm.torque(1),
        "((m1+m2)*h1**2 + m2*h2**2 + 2*m2*h1*h2*c2)*a1 + (m2*h2**2 + m1*h1*h2*c2)*a2"
        f"- 2*m2*h1*h2*s2*v1*v2 - m2*h1*h2*c2*v2**2 + {GRAVITY_1}",
    ),
    ("5.41 acceleration, square", lambda arm: arm.momentum(2), "m2*h2**2*a1 + m2*h2**2*v2**2 + m2*h1*h2*c2*v1"),
    (
        "5.42 square of v2",
        lambda arm: arm.rate(arm.momentum(2)),
        "m2*h2**2*a1 + m2*h2**2*v2**2 + m2*h1*h2*c2*a1 - m2*h1*h2*s2*v1*v2",
    ),
    ("5.43 lost square, m", lambda arm: arm.slope(2), "-m2*h1*h2*s2*v1*v2 - m*g*h2*s12"),
    ("5.43 lost square alone", lambda arm: arm.slope(2), "-m2*h1*h2*s2*v1*v2 - m2*g*h2*s12"),
    ("5.43 m alone", lambda arm: arm.slope(2), "-m2*h1*h2*s2*(v1**2 + v1*v2) - m*g*h2*s12"),
    ("5.44 k_C2", lambda arm: -arm.k("C", 2), "2*m2*h1*h2*s2"),
    ("5.44 k_D21", lambda arm: -arm.k("D", 2, 1), "m2*h1*h2*s2"),
    (
        "5.44 altogether",
        lambda arm: arm.torque(2),
        "(m2*h2**2 + m2*h1*h2*c2)*a1 + m2*h2**2*a2 - 2*m2*h1*h2*s2*v1*v2 - m2*h1*h2*s2*v1**2 + m2*h2*s12*g",
    ),
    ("5.55 velocity called an acceleration", lambda arm: arm.twist("end1")[5], "a1"),
]


@pytest.mark.parametrize(("derived", "formula"), [row[1:] for row in ERRATA], ids=[row[0] for row in ERRATA])
def test_transcribed_form_is_wrong(arm, derived, formula):
    assert verdict(derived(arm), arm.typed(formula)) == Verdict.DIFFERENT


# Definitions and equations without a formula of their own: identities between what was derived by different
# formulations


@pytest.fixture
def other(arm):
    return Arm({"lagrange": "recursive", "recursive": "lagrange"}[arm.formulation])


@pytest.mark.parametrize("i", [1, 2])
def test_equation_5_21_kinetic_energy_gives_the_generalized_force(arm, other, i):
    K = arm.entries("kinetic_energy")[0]
    left = arm.rate(gradient(K, arm.state.qd)[i - 1]) - gradient(K, arm.state.q)[i - 1]

    assert verdict(left, other.torque(i) - other.k("G", i)) == Verdict.PROVED


@pytest.mark.parametrize("i", [1, 2])
def test_equation_5_22_generalized_force_is_action_less_the_slope_of_potential_energy(arm, other, i):
    K, P = arm.entries("kinetic_energy")[0], arm.entries("potential_energy")[0]
    force = arm.rate(gradient(K, arm.state.qd)[i - 1]) - gradient(K, arm.state.q)[i - 1]
    friction = arm.graph.symbol("b") * arm.state.qd[i - 1]
    rubbing = Arm(other.formulation, with_friction())

    action = force + gradient(P, arm.state.q)[i - 1]  # Q^A = M - b q̇

    assert verdict(action, other.torque(i)) == Verdict.PROVED
    assert verdict(action + friction, rubbing.torque(i)) == Verdict.PROVED


def test_equation_5_23_lagrangian_is_kinetic_less_potential_energy(arm, other):
    assert verdict(arm.entries("kinetic_energy")[0] - arm.entries("potential_energy")[0], other.L) == Verdict.PROVED
    assert verdict(arm.entries("kinetic_energy")[0] + arm.entries("potential_energy")[0], other.L) == Verdict.DIFFERENT


def test_equation_5_26_kinetic_energy_of_the_second_mass(arm):
    v, half_m2 = arm.twist("end2"), arm.typed("m2/2")

    assert verdict(arm.energy("kinetic_energy", 2), half_m2 * (v[0] ** 2 + v[1] ** 2 + v[2] ** 2)) == Verdict.PROVED


def test_equation_5_27_speed_is_the_rate_of_the_place(arm):
    x, y = arm.place("end2")
    v = arm.twist("end2")

    assert verdict(v[0] ** 2 + v[1] ** 2, arm.rate(x) ** 2 + arm.rate(y) ** 2) == Verdict.PROVED


@pytest.mark.parametrize("i", [1, 2])
def test_equation_5_36_lagrange_equation_of_motion(arm, other, i):
    assert verdict(arm.rate(arm.momentum(i)) - arm.slope(i), other.torque(i)) == Verdict.PROVED
    assert verdict(arm.rate(arm.momentum(i)) + arm.slope(i), other.torque(i)) == Verdict.DIFFERENT


@pytest.mark.parametrize(("i", "of"), [(1, "m1*d1 + m2*d2"), (2, "m2*d2")])
def test_equations_5_46_and_5_48_coefficients_are_moments_of_inertia_about_the_axes_o1_and_o2(arm, i, of):
    (x, y), ends = arm.place(f"link{i}"), [arm.place("end1"), arm.place("end2")]
    squares = {arm.graph.symbol(f"d{k}"): (u - x) ** 2 + (v - y) ** 2 for k, (u, v) in enumerate(ends, start=1)}

    assert verdict(arm.k("z", i, i), substitute([arm.typed(of)], squares)[0]) == Verdict.PROVED


def test_equation_5_54_induced_torques_are_mutual(arm):
    of_a2_in_axis_1 = gradient(arm.torque(1), arm.state.qdd)[1]
    of_a1_in_axis_2 = gradient(arm.torque(2), arm.state.qdd)[0]

    assert verdict(of_a1_in_axis_2, of_a2_in_axis_1) == Verdict.PROVED


def test_equation_5_55_angular_velocity_of_the_first_link_is_the_rate_of_q1(arm):
    assert verdict(arm.twist("end1")[5], arm.typed("v1")) == Verdict.PROVED


def test_every_equation_from_5_21_to_5_55_has_a_test():
    named = {name for name in globals() if name.startswith("test_equation")}
    tested = {f"5.{number}" for name in named for number in re.findall(r"_5_(\d\d)", name)}
    tested |= {row[0].split()[0] for row in EQUATIONS}

    assert tested >= {f"5.{k}" for k in range(21, 56)}
