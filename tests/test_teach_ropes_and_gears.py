"""Lessons of ropes, gears and prescribed rates: they end in the formulas of books, in lowest terms and in plain words.

Atwood's machine: Taylor, Classical Mechanics, 7.4; planetary gears: J. Angeles, Fundamentals of Robotic Mechanical
Systems, 8; the bead on a turning hoop: Taylor, example 7.6.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from symdyn.scene import Scene
from symdyn.scene.toml import read_text
from symdyn.teach import languages, walkthrough
from symdyn.teach.render.markdown import markdown

LOADS = """
name = "atwood"
[parameters]
m_1 = {{ value = {m_1}, unit = "kg", positive = true }}
m_2 = {{ value = 2, unit = "kg", positive = true }}
l = {{ value = 3, unit = "m", positive = true }}
r = {{ value = 0.1, unit = "m", positive = true }}
[bodies.left]
mass = "m_1"
[bodies.right]
mass = "m_2"
[joints.a]
type = "prismatic"
parent = "ground"
child = "left"
axis = [0, 0, -1]
origin = [["Tx", "-r"]]
coordinate = "x_1"
drive = false
start = 1
[joints.b]
type = "prismatic"
parent = "ground"
child = "right"
axis = [0, 0, -1]
origin = [["Tx", "r"]]
coordinate = "x_2"
drive = false
start = "{start}"
"""

ROPE = """
[ropes.cord]
through = ["left", {{ body = "ground", at = [0, 0, 0], radius = "r", axis = [0, 1, 0], turn = "{turn}" }}, "right"]
length = "l"
"""

WOUND = """
[bodies]
pulley = { mass = 1, inertia = [0.02, 0.02, 0.02], inertia_about = "com" }
[joints]
axle = { type = "revolute", parent = "ground", child = "pulley", axis = [0, 1, 0], coordinate = "phi", drive = false }
[ropes.c1]
through = ["left", { body = "pulley", at = [0, 0, 0], radius = "r", axis = [0, 1, 0], turn = "left" }]
length = 1
[ropes.c2]
through = [{ body = "pulley", at = [0, 0, 0], radius = "r", axis = [0, 1, 0], turn = "left" }, "right"]
length = 1
"""

GEAR = """
name = "gear"
gravity = "none"
[parameters]
r_s = { value = 0.04, unit = "m", positive = true }
r_p = { value = 0.02, unit = "m", positive = true }
J_s = { value = 0.001, unit = "kg m^2", positive = true }
J_c = { value = 0.002, unit = "kg m^2", positive = true }
J_p = { value = 0.0001, unit = "kg m^2", positive = true }
m_p = { value = 0.3, unit = "kg", positive = true }
J_r = { value = 0.004, unit = "kg m^2", positive = true }
[bodies]
sun = { mass = 0.5, inertia = ["J_s", "J_s", "J_s"], inertia_about = "com" }
ring = { mass = 0.5, inertia = ["J_r", "J_r", "J_r"], inertia_about = "com" }
carrier = { mass = 0.4, inertia = ["J_c", "J_c", "J_c"], inertia_about = "com" }
planet = { mass = "m_p", inertia = ["J_p", "J_p", "J_p"], inertia_about = "com" }
[joints]
s = { type = "revolute", parent = "ground", child = "sun", axis = [0, 0, 1], coordinate = "sigma", drive = "T_s" }
r = { type = "revolute", parent = "ground", child = "ring", axis = [0, 0, 1], coordinate = "rho", drive = "T_r" }
[joints.c]
type = "revolute"
parent = "ground"
child = "carrier"
axis = [0, 0, 1]
mimic = { ratios = { s = "r_s/(2*r_s + 2*r_p)", r = "(r_s + 2*r_p)/(2*r_s + 2*r_p)" } }
[joints.p]
type = "revolute"
parent = "carrier"
child = "planet"
axis = [0, 0, 1]
origin = ["r_s + r_p", 0, 0]
[joints.p.mimic.ratios]
s = "-r_s*(r_s + 2*r_p)/(2*r_p*(r_s + r_p))"
r = "r_s*(r_s + 2*r_p)/(2*r_p*(r_s + r_p))"
"""

HOOP = """
name = "hoop"
[parameters]
a = { value = 0.2, unit = "m", positive = true }
m = { value = 0.1, unit = "kg", positive = true }
Omega = { value = 10, unit = "rad/s", positive = true }
[bodies]
hoop = { mass = 1, inertia = [0.01, 0.01, 0.01], inertia_about = "com" }
bead = { particles = [{ mass = "m", at = [0, 0, "-a"] }] }
[joints.shaft]
type = "revolute"
parent = "ground"
child = "hoop"
axis = [0, 0, 1]
coordinate = "phi"
drive = "T"
motion = "Omega*t"
[joints.wire]
type = "revolute"
parent = "hoop"
child = "bead"
axis = [0, -1, 0]
coordinate = "theta"
drive = false
start = 0.5
"""


def hung(m_1: int = 3, turn: str = "left") -> str:
    return (LOADS + ROPE).format(m_1=m_1, turn=turn, start="l - pi*r - 1")


SCENES = {
    "atwood": hung(),
    "level": hung(m_1=2),
    "one letter": hung().replace('mass = "m_2"', 'mass = "m_1"'),
    "crossing": hung(turn="right"),
    "wound": LOADS.format(m_1=3, start="1") + WOUND,
    "gear": GEAR,
    "hoop": HOOP,
}


@cache
def page(name: str, language: str = "en", detail: str = "brief") -> str:
    scene: Scene = read_text(SCENES[name])
    (text,) = (text for key, text in markdown(walkthrough(scene, language, detail)).items() if key.endswith(".md"))
    assert isinstance(text, str)
    return text


# Ropes


def test_atwood_s_machine_ends_in_its_acceleration_and_its_tension() -> None:
    text = page("atwood")
    assert r"\ddot x_1 = \frac{9.81 (m_1 - m_2)}{m_1 + m_2}" in text
    assert r"\lambda_1 = \frac{19.62 m_1 m_2}{m_1 + m_2}" in text  # 2 m_1 m_2 g
    assert r"$\lambda_1$ is the tension of rope cord, positive where it pulls." in text
    assert r"Wanted, too, is the tension of each rope: $\lambda_1$." in text


def test_the_wheel_s_inertia_stands_in_both_tensions() -> None:
    text = page("wound")
    assert r"\ddot{\phi} = \frac{9.81 r (m_2 - m_1)}{(m_1 + m_2) r^2 + 0.02}" in text
    assert text.count("is the tension of rope c") == 2


@pytest.mark.parametrize(
    ("name", "said"),
    [("atwood", "it rests nowhere"), ("level", "it can rest in every position"), ("one letter", "Every position is")],
)
def test_a_rope_over_a_wheel_rests_nowhere_or_everywhere(name: str, said: str) -> None:
    text = page(name)
    rests = text[text.index("## Equilibria and small oscillations") : text.index("## What is conserved")]
    assert said in rests
    assert "Newton's method" not in rests
    assert "−0.04472" not in text  # where the rope leaves the wheel another way than the page's equation says


def test_the_matrix_of_all_equations_has_its_right_side() -> None:
    assert r"b = \begin{bmatrix} -k_{G,1} \\ -k_{G,2} \\ 0 \end{bmatrix}" in page("atwood")


def test_the_rates_of_a_rope_that_crosses_are_short() -> None:
    text = page("crossing")
    assert r"\dot f_1 = \frac{(r - x_1) (r + x_1) \dot x_1}{r^2 + x_1^2}" in text
    assert "terms" not in text[: text.index("## Positions")]
    assert len(text) < 20_000


def test_a_rope_that_is_wound_up_does_not_slip_and_one_over_a_wheel_slides() -> None:
    assert page("wound").count("does not slip on it") == 1
    assert "slides without friction" in page("atwood")
    assert "slides without friction" not in page("wound")


# Gears


def test_a_constant_mass_matrix_is_solved_in_letters() -> None:
    text = page("gear")
    assert r"\Delta = k_{z,11} k_{z,22} - k_{z,12}^2" in text
    assert r"\ddot{\sigma} = \frac{T_s k_{z,22} - T_r k_{z,12}}{\Delta}" in text


def test_ratios_of_gears_are_in_lowest_terms() -> None:
    text = page("gear")
    assert (
        r"k_{z,11} = \frac{m_p r_s^2}{4} + J_s + \frac{J_c r_s^2}{4 (r_s + r_p)^2} + \frac{J_p r_s^2}{4 r_p^2}" in text
    )
    assert r"x_4 = (r_s + r_p) \cos" in text
    assert r"\frac{\mathrm{d}}{\mathrm{d}t} k_{z" not in text  # of constants it is zero


# Prescribed rates


def test_decimals_of_a_scene_are_decimals_of_its_lesson() -> None:
    text = page("hoop")
    assert r"\ddot{\theta} = \Bigl(\Omega^2 \cos \theta - \frac{9.81}{a}\Bigr) \sin \theta" in text
    assert r"$\cos \theta$ = $\frac{9.81}{a \Omega^2}$, from $\Omega^2$ \> $\frac{9.81}{a}$ on" in text
    assert "981" not in text.replace("9.81", "")


def test_what_is_wanted_is_not_given() -> None:
    text = page("hoop")
    assert r"The motion of $\phi$ is prescribed: find what keeps it, $T$." in text
    assert r"No drive acts on $\theta$: wanted is how the mechanism moves there by itself, $\ddot{\theta}$." in text


def test_without_the_prescribed_rate_the_hoop_is_a_pendulum() -> None:
    said = (
        "| $\\Omega$\u00a0→\u00a00 | "
        r"$\tfrac{1}{2} m a^2 \dot{\theta}^2$ | $-9.81 m a \cos \theta$ | $\phi$ stands still:"
    )
    assert said in page("hoop")


@pytest.mark.parametrize("name", ["atwood", "wound", "gear", "hoop"])
def test_formulas_are_the_same_in_both_languages(name: str) -> None:
    def shown(text: str) -> list[str]:
        return [part.replace("{,}", ".") for part in text.split("$$")[1::2]]

    assert shown(page(name)) == shown(page(name, "sk"))


def test_no_formula_knows_anything() -> None:
    words = (Path(languages.__code__.co_filename).parent / "en.toml").read_text(encoding="utf-8")
    for phrase in ("Lagrangian knows", "does not know", "knows no", "notices", "Seen by who", "its kin", "their kin"):
        assert phrase not in words
