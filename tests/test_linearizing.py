"""Feedback linearisation, zero dynamics, rates of outputs: against Spong's and Furuta's formulas, and by proof."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from running import agreements

import symdyn
from symdyn.dynamics import Workspace, derive_one
from symdyn.emit import TARGETS, emit
from symdyn.errors import DerivationError
from symdyn.program import Program, formulate, lower
from symdyn.scene import Scene, read_text
from symdyn.scene.values.formula import parse
from symdyn.scene.values.letters import Signal, StateVariable
from symdyn.verdict import Verdict
from symdyn.verify.certificate import on_unit_sphere
from symdyn.verify.equality import prove
from symdyn.verify.laws import laws

LED = ("linearizing_forces", "zero_dynamics")
ALL = (*LED, *(f"{name}:passive" for name in LED))

ACROBOT = """
name = "acrobot"
gravity = [0, "-g", 0]
[parameters]
g = 9.8
m1 = 1.1
m2 = 0.9
l1 = 1.2
c1 = 0.5
c2 = 0.8
I1 = 0.2
I2 = 0.7
[bodies]
upper = { mass = "m1", com = ["c1", 0, 0], inertia = [0, "I1", "I1"], inertia_about = "com" }
lower = { mass = "m2", com = ["c2", 0, 0], inertia = [0, "I2", "I2"], inertia_about = "com" }
[joints]
bar = { type = "revolute", parent = "ground", child = "upper", axis = [0, 0, 1], coordinate = "q1", drive = false }
[joints.hip]
type = "revolute"
parent = "upper"
child = "lower"
axis = [0, 0, 1]
origin = ["l1", 0, 0]
coordinate = "q2"
"""

APART = """
name = "apart"
[bodies]
one = { mass = 1 }
other = { mass = 2 }
[joints]
a = { type = "prismatic", parent = "ground", child = "one", axis = [1, 0, 0], coordinate = "x", drive = "F" }
b = { type = "prismatic", parent = "ground", child = "other", axis = [0, 1, 0], coordinate = "y", drive = false }
[outputs.free]
formula = "y"
[outputs.pushed]
formula = "x_ddot"
"""

LED_BY = """
g = 9.8
a = { value = 0.3, unit = "m" }
w = { value = 2, unit = "rad/s" }
"""

LED_AS_WELL = (
    ACROBOT.replace('parent = "ground"', 'parent = "cart"').replace("g = 9.8", LED_BY)
    + """
[bodies.cart]
mass = 1
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "s"
motion = "a*sin(w*t)"
"""
)


def value(scene: Scene, name: str, *given: object) -> list[float]:
    return [float(x) for x in np.ravel(symdyn.lambdify(scene, name)(*given))]


def with_outputs(scene: Scene, **formulas: str) -> Scene:
    return replace(scene, outputs=tuple(Signal(name, parse(one)) for name, one in formulas.items()))


# Papers


STATES = [([0.0, 0.0], [0.0, 0.0]), ([math.pi / 2, 0.0], [0.3, -0.2]), ([0.7, 0.7], [1.0, -2.0])]


@pytest.mark.parametrize(("q", "u"), STATES)
def test_the_acrobot_of_spong(q: list[float], u: list[float]) -> None:
    """The swing up control problem for the acrobot (1995), (1)-(16): both forms, and their zero dynamics."""
    scene = read_text(ACROBOT)
    g, m1, m2, l1, c1, c2, I1, I2 = 9.8, 1.1, 0.9, 1.2, 0.5, 0.8, 0.2, 0.7
    cos, sin = math.cos(q[1]), math.sin(q[1])
    d11 = m1 * c1**2 + m2 * (l1**2 + c2**2 + 2 * l1 * c2 * cos) + I1 + I2
    d22, d12 = m2 * c2**2 + I2, m2 * (c2**2 + l1 * c2 * cos) + I2
    k = m2 * l1 * c2 * sin
    phi2 = m2 * c2 * g * math.cos(q[0] + q[1])
    phi1 = (m1 * c1 + m2 * l1) * g * math.cos(q[0]) + phi2
    h1, h2 = -k * u[1] ** 2 - 2 * k * u[1] * u[0], k * u[0] ** 2
    v = 0.7

    collocated = (d22 - d12**2 / d11) * v + h2 + phi2 - d12 / d11 * (h1 + phi1)
    assert value(scene, "linearizing_forces", q, u, [5.0, v]) == pytest.approx([0, collocated], rel=1e-12)
    assert value(scene, "zero_dynamics", q, u) == pytest.approx([-phi1 / d11], rel=1e-12)
    other = (d12 - d22 * d11 / d12) * v + h2 + phi2 - d22 / d12 * (h1 + phi1)
    assert value(scene, "linearizing_forces:passive", q, u, [v, 5.0]) == pytest.approx([0, other], rel=1e-12)
    held = (k * u[1] ** 2 - phi1) / d12
    assert value(scene, "zero_dynamics:passive", q, u) == pytest.approx([held], rel=1e-12)


def test_furutas_pendulum_on_an_arm_that_is_held() -> None:
    """Cazzolato and Prime (2011): (J2 + m2 l2²) θ̈2 = -b2 θ̇2 - m2 g l2 sin θ2; and the arm that keeps it inclined."""
    scene = symdyn.example("furuta")
    L1, l2, m2, J2, b2, g = 0.278, 0.148, 0.075, 0.00386, 0.00028, 9.81
    inertia, weight = J2 + m2 * l2**2, m2 * g * l2
    for angle in (0.0, 0.4, 3.0):
        swing = (-b2 * 0.6 - weight * math.sin(angle)) / inertia
        assert value(scene, "zero_dynamics", [0.3, angle], [9.0, 0.6]) == pytest.approx([swing], rel=1e-12)
        turned = (inertia * 2.0**2 * math.sin(2 * angle) / 2 - weight * math.sin(angle)) / (
            m2 * L1 * l2 * math.cos(angle)
        )
        assert value(scene, "zero_dynamics:passive", [0.3, angle], [2.0, 9.0]) == pytest.approx([turned], rel=1e-12)


def test_the_pole_on_a_cart_that_is_held_falls_as_a_pendulum_does() -> None:
    scene = symdyn.example("cart_pole")
    for angle in (0.0, 0.5, math.pi):
        falls = 3 * 9.81 / (2 * 0.5) * math.sin(angle)
        assert value(scene, "zero_dynamics", [1.0, angle], [2.0, 3.0]) == pytest.approx([falls], rel=1e-12)


# Proofs


def proved(scene: Scene, names: tuple[str, ...]) -> set[str]:
    w = Workspace(scene)
    claims = [*laws(w, (*names, "forward_dynamics")), *agreements(w, list(names))]
    findings = prove(on_unit_sphere(scene, claims))[1]
    assert {one.verdict for one in findings} == {Verdict.PROVED}
    return {one.claim.partition(":")[0] for one in findings}


@pytest.mark.parametrize("text", [ACROBOT, LED_AS_WELL])
def test_forces_lead_what_they_should(text: str) -> None:
    """Of a tree, and where another joint is led by a formula in time."""
    said = proved(read_text(text), ALL)
    assert {"forces that lead what is driven", "forces that lead what is passive", *LED} <= said


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("cart_pole", ("drift", "F")),
        ("four_bar", ("drift", "M")),
        ("heavy_top", ("drift", *(f"force on point_w{axis}" for axis in "xyz"))),
    ],
)
def test_outputs_move_along_the_motion_as_the_state_does(name: str, columns: tuple[str, ...]) -> None:
    """Of a tree, a loop, a ball without drives; one output holds time, one has degree 1, one 2."""
    scene = symdyn.example(name)
    first, u = scene.coordinates[-1], scene.velocities[-1]
    scene = with_outputs(scene, slow=f"{first}**2 + t", fast=f"{u}*{first} + t")
    found = derive_one(Workspace(scene), "decoupling_matrix")

    assert {"rates of outputs", "relative degree"} <= proved(scene, ("outputs", "output_rates", "decoupling_matrix"))
    assert found.labels[0] == ("second rate of slow", "rate of fast")
    assert found.labels[1] == columns
    assert derive_one(Workspace(scene), "decoupling_row:slow").text.endswith("; relative degree 2")
    assert derive_one(Workspace(scene), "decoupling_row:fast").text.endswith("; relative degree 1")


PENDULUM = "m*l**2*q1_dot**2/2 - m*g*l*cos(q1)"


def test_energy_as_an_output_has_the_power_of_drives_and_losses_for_its_rate() -> None:
    scene = with_outputs(symdyn.example("pendulum"), V=PENDULUM)
    for q, u, tau in ((0.0, 0.0, 0.0), (0.4, -0.3, 0.02), (math.pi, 1.0, -0.1)):
        assert value(scene, "output_rate:V", [q], [u], [tau]) == pytest.approx(
            [tau * u - 0.01 * u**2], rel=1e-12, abs=1e-15
        )


def test_states_of_ones_own_move_too() -> None:
    scene = replace(symdyn.example("pendulum"), states=(StateVariable("z", parse("q1 - z")),))
    rate = value(with_outputs(scene, y="z*q1"), "output_rate:y", [0.3], [0.7], [0.1], [2.0])
    assert rate == pytest.approx([(0.3 - 2.0) * 0.3 + 2.0 * 0.7])


# Messages, letters, targets


@pytest.mark.parametrize(
    ("scene", "name", "said"),
    [
        ("two_link", "linearizing_forces", "two_link: every joint is driven; inverse_dynamics at the wanted"),
        ("heavy_top", "zero_dynamics", "heavy_top: no joint has a drive that could linearise it; name one"),
        ("four_bar", "linearizing_forces", "linearizing_forces is about trees; loops or rows close four_bar"),
        ("cart_pole", "linearizing_forces:hinge", "write linearizing_forces or linearizing_forces:passive"),
        ("cart_pole", "output_rate:y", "cart_pole has no outputs; declare one"),
        ("cart_pole", "decoupling_matrix", "cart_pole has no outputs; declare one"),
        ("APART", "linearizing_forces:passive", "apart: forces cannot lead what is passive: no inertia couples"),
        ("APART", "decoupling_row:free", "apart: output free has no relative degree of 1 or 2: no driving force is in"),
        ("APART", "output_rate:pushed", "apart: output pushed depends on driving forces, directly or by accelerations"),
        ("APART", "output_rate:z", r"apart: there is no output 'z' in \[outputs\]"),
        ("INPUT", "output_rate:y", "acrobot: output y depends on the input w, directly or"),
        ("ALONE", "zero_dynamics:passive", "driven: q2_dot; passive: s_dot, q1_dot; linearizing_forces leads what"),
    ],
)
def test_what_there_is_not_says_why(scene: str, name: str, said: str) -> None:
    one = read_text(MISTAKEN[scene]) if scene.isupper() else symdyn.example(scene)
    with pytest.raises(DerivationError, match=said):
        derive_one(Workspace(one), name)


MISTAKEN = {
    "APART": APART,
    "INPUT": ACROBOT + '\n[inputs.w]\nvalue = 0\n[outputs.y]\nformula = "q1*w"\n',
    "ALONE": LED_AS_WELL.replace('motion = "a*sin(w*t)"', "drive = false"),
}


@cache
def clashing() -> Program:
    """Return a program of a coordinate aB, a mass tau without a value, and an output dy."""
    text = ACROBOT.replace('"q1"', '"aB"').replace("m1 = 1.1", 'tau = { unit = "kg" }').replace('"m1"', '"tau"')
    wanted = (*LED, "zero_dynamics:passive", "output_rates", "output_rate:dy", "decoupling_matrix", "decoupling_row:dy")
    scene = with_outputs(read_text(text), dy="aB_dot**2 + q2")
    return lower(formulate(scene, (*wanted, "linearizing_forces_by_qdd")))


@pytest.mark.parametrize("target", [name for name, row in TARGETS.items() if row.functions is None])
def test_every_target_writes_them_for_a_scene_with_their_letters(target: str) -> None:
    assert emit(clashing(), target)
