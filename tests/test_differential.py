"""Joints that follow several others, planetary and differential gears; angles that are a parameter times q."""

import numpy as np
import pytest
import sympy

import symdyn
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import SceneError
from symdyn.scene import lock
from symdyn.scene.scene_files import write_text
from symdyn.scene.toml import read_text
from tests.lessons import lesson_of

PLANETARY = """
name = "planetary"
gravity = [0, 0, 0]
[parameters]
zs = { value = 20, positive = true, unit = "1" }
zr = { value = 60, positive = true, unit = "1" }
Is = { value = 0.001, unit = "kg m^2" }
Ir = { value = 0.02, unit = "kg m^2" }
Ic = { value = 0.01, unit = "kg m^2" }
[bodies.sun]
inertia = ["Is/2", "Is/2", "Is"]
inertia_about = "com"
[bodies.ring]
inertia = ["Ir/2", "Ir/2", "Ir"]
inertia_about = "com"
[bodies.arm]
inertia = ["Ic/2", "Ic/2", "Ic"]
inertia_about = "com"
[joints.s]
type = "revolute"
parent = "ground"
child = "sun"
[joints.r]
type = "revolute"
parent = "ground"
child = "ring"
[joints.c]
type = "revolute"
parent = "ground"
child = "arm"
mimic = { ratios = { s = "zs/(zs + zr)", r = "zr/(zs + zr)" } }
damping = 0.3
"""

GEARED = """
name = "geared"
gravity = [0, "-g", 0]
[parameters]
n = { unit = "1" }
m = { unit = "kg" }
l = { unit = "m" }
g = { unit = "m/s^2" }
[bodies.arm]
mass = "m"
com = ["l", 0, 0]
[bodies.hand]
mass = "m"
com = ["l", 0, 0]
[joints.a]
type = "revolute"
parent = "ground"
child = "arm"
[joints.b]
type = "revolute"
parent = "arm"
child = "hand"
origin = ["2*l", 0, 0]
mimic = { joint = "a", ratio = "n" }
"""


def test_a_planetary_gear_has_the_equations_of_its_energies_by_hand():
    zs, zr, Is, Ir, Ic = 20.0, 60.0, 0.001, 0.02, 0.01
    ratios = np.array([zs, zr]) / (zs + zr)
    M = np.diag([Is, Ir]) + Ic * np.outer(ratios, ratios)
    u, tau = np.array([3.0, -1.0]), np.array([0.4, -0.2])

    a, closed, drives = symdyn.lambdify(read_text(PLANETARY), ("forward_dynamics", "mass_matrix", "inverse_dynamics"))

    by_hand = np.linalg.solve(M, tau - 0.3 * ratios * (ratios @ u))
    assert np.allclose(closed([0.3, 0.7]), M, rtol=1e-14)
    assert np.allclose(a([0.3, 0.7], u, tau), by_hand, rtol=1e-13)
    assert np.allclose(drives([0.3, 0.7], u, by_hand), tau, rtol=1e-12)


@pytest.mark.parametrize(("speeds", "carrier"), [((4, 0), 1), ((0, 4), 3), ((2, 2), 2), ((0, 0), 0)])
def test_the_carrier_turns_as_willis_says(speeds, carrier):
    """With the ring held 20/80 of the sun's speed, with the sun held 60/80 of the ring's."""
    assert np.allclose(symdyn.lambdify(read_text(PLANETARY), "jacobian:arm")([0, 0])[-1] @ speeds, carrier)


@pytest.mark.runs
def test_every_formulation_of_a_planetary_gear_is_proved_equal():
    assert symdyn.certify(read_text(PLANETARY), ("inverse_dynamics", "reactions:joint")).passed


@pytest.mark.runs
def test_a_damped_carrier_slows_down_as_by_hand():
    run = symdyn.simulate(read_text(PLANETARY), until=0.2, start_rates={"q1": 1, "q2": 2})

    ratios, M = np.array([0.25, 0.75]), np.diag([0.001, 0.02])
    M += 0.01 * np.outer(ratios, ratios)
    decay = 0.3 * ratios @ np.linalg.solve(M, ratios)  # of the carrier's speed, by hand
    carrier = run["q1_dot"] * 0.25 + run["q2_dot"] * 0.75
    assert np.allclose(carrier, 1.75 * np.exp(-decay * run.t), atol=1e-9)


def test_the_lesson_prints_willis():
    steps = [step for section in lesson_of(read_text(PLANETARY)).sections for step in section.steps]
    (table,) = next(step for step in steps if step.key == "acting").blocks

    relative, _, ratio = next(row[1].parts for row in table.rows if "Willis" in str(row[0].parts[0]))
    assert (text_of(relative), text_of(ratio)) == ("(omega_s - omega_c)/(omega_r - omega_c)", "-zr/zs")


def test_ratios_are_written_as_they_are_read():
    scene = read_text(PLANETARY)

    assert read_text(write_text(scene, "toml").text) == scene


def test_urdf_has_no_such_joint():
    with pytest.raises(SceneError, match=r"joints\.c: URDF has no joint that follows several; give it a coordinate"):
        write_text(read_text(PLANETARY), "urdf")


def test_a_locked_leader_leaves_the_other():
    scene = lock(read_text(PLANETARY), {"r": "pi/3"})

    (joint,) = (one for one in scene.joints if one.name == "c")
    assert joint.coupling.coordinates == ("q1",)
    assert float(joint.coupling.offset.at({"zs": 20, "zr": 60})) == pytest.approx(np.pi / 4)


RATIOS = '{ ratios = { s = "zs/(zs + zr)", r = "zr/(zs + zr)" } }'


@pytest.mark.parametrize(
    ("mimic", "message"),
    [
        ('{ ratios = { s = 1, ring = 1 } }', 'mimic.ratios.ring is neither a joint nor a coordinate; known are'),
        ('{ ratios = { s = 1, c = 1 } }', "mimic: the joint follows itself: c -> c; give one a coordinate"),
        ('{ ratios = {} }', "ratios names no joint; write mimic = { ratios ="),
        ('{ ratios = 2 }', "ratios = 2 is not a table; write mimic = { ratios ="),
        ('{ joint = "s", ratios = { r = 1 } }', "ratios names all that it follows; leave joint out"),
        ('{ ratios = { s = "1 m", r = 1 } }', "mimic"),
        ('{ ratios = { s = "zx", r = 1 } }', "mimic.ratios.q1 = zx uses the undefined symbol zx"),
    ],
)  # fmt: skip
def test_a_mistake_in_ratios_is_told(mimic, message):
    with pytest.raises(SceneError) as caught:
        read_text(PLANETARY.replace(RATIOS, mimic))

    assert message in str(caught.value)


def test_a_gear_of_any_ratio_has_a_closed_form():
    """sin(n q) is a generator of its own: Lagrange's equation of two bars by hand in SymPy."""
    t = sympy.Symbol("t")
    n, m, length, g, q, u, a = sympy.symbols("n m l g q1 q1_dot q1_ddot")
    angle = sympy.Function("q")(t)
    first = length * sympy.Matrix([sympy.cos(angle), sympy.sin(angle)])
    second = 2 * first + length * sympy.Matrix([sympy.cos((1 + n) * angle), sympy.sin((1 + n) * angle)])
    K = sum(m * (p.diff(t).T * p.diff(t))[0] / 2 for p in (first, second))
    L = K - m * g * (first[1] + second[1])
    by_hand = L.diff(angle.diff(t)).diff(t) - L.diff(angle)
    by_hand = by_hand.subs(angle.diff(t, 2), a).subs(angle.diff(t), u).subs(angle, q)

    ours = symdyn.equations(read_text(GEARED)).sympy()
    ours = (ours.M * ours.qdd + ours.c + ours.g)[0]

    at = {n: 1.7, m: 2, length: 0.4, g: 9.81, q: 0.6, u: 1.3, a: -0.2}
    names = {str(symbol): value for symbol, value in at.items()}
    assert float(by_hand.subs(at)) == pytest.approx(
        float(ours.subs({symbol: names[str(symbol)] for symbol in ours.free_symbols})), rel=1e-12
    )
