"""Joints that follow several others, planetary and differential gears; angles that are a parameter times q."""

import numpy as np
import pytest
import sympy
from lessons import lesson_of

import symdyn
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import SceneError
from symdyn.scene import bind, lock
from symdyn.scene.scene_files import write_text
from symdyn.scene.toml import read_text

PLANETARY = """
name = "planetary"
gravity = [0, 0, 0]
[parameters]
zs = { value = 20, positive = true, unit = "1" }
zr = { value = 60, positive = true, unit = "1" }
Is = { value = 0.001, unit = "kg m^2" }
Ir = { value = 0.02, unit = "kg m^2" }
Ic = { value = 0.01, unit = "kg m^2" }
[bodies]
sun = { inertia = ["Is/2", "Is/2", "Is"], inertia_about = "com" }
ring = { inertia = ["Ir/2", "Ir/2", "Ir"], inertia_about = "com" }
arm = { inertia = ["Ic/2", "Ic/2", "Ic"], inertia_about = "com" }
[joints]
s = { type = "revolute", parent = "ground", child = "sun" }
r = { type = "revolute", parent = "ground", child = "ring" }
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
[bodies]
arm = { mass = "m", com = ["l", 0, 0] }
hand = { mass = "m", com = ["l", 0, 0] }
[joints]
a = { type = "revolute", parent = "ground", child = "arm" }
b = { type = "revolute", parent = "arm", child = "hand", origin = ["2*l", 0, 0], mimic = { joint = "a", ratio = "n" } }
"""

ATWOOD = """
name = "double_atwood"
gravity = [0, 0, "-g"]
[parameters]
g = { unit = "m/s^2" }
R = { unit = "m" }
r = { unit = "m" }
I1 = { unit = "kg m^2" }
I2 = { unit = "kg m^2" }
M = { unit = "kg" }
m1 = { unit = "kg" }
m2 = { unit = "kg" }
m3 = { unit = "kg" }
[bodies]
drum = { inertia = ["I1/2", "I1/2", "I1"], inertia_about = "com" }
first = { mass = "m1" }
block = { mass = "M" }
pulley = { inertia = ["I2/2", "I2/2", "I2"], inertia_about = "com" }
second = { mass = "m2" }
third = { mass = "m3" }
[joints]
fall = { type = "prismatic", axis = [0, 0, -1], parent = "ground", child = "first", coordinate = "x", drive = false }
[joints.drum]
type = "revolute"
axis = [0, 0, 1]
origin = { rpy = ["pi/2", 0, 0] }
parent = "ground"
child = "drum"
mimic = { joint = "fall", ratio = "1/R" }
[joints.rise]
type = "prismatic"
axis = [0, 0, 1]
parent = "ground"
child = "block"
mimic = { joint = "fall" }
[joints.lower]
type = "prismatic"
axis = [0, 0, -1]
parent = "block"
child = "second"
coordinate = "y"
drive = false
[joints.turn]
type = "revolute"
axis = [0, 0, 1]
origin = { rpy = ["pi/2", 0, 0] }
parent = "block"
child = "pulley"
mimic = { joint = "lower", ratio = "1/r" }
[joints.upper]
type = "prismatic"
axis = [0, 0, 1]
parent = "block"
child = "third"
mimic = { joint = "lower" }
"""


@pytest.mark.runs
def test_drums_of_a_double_atwood_turn_by_symbolic_ratios():
    """Lagrange's equations in SymPy: an axisymmetric rotor follows a thread, θ = x/R, and no angle is in them."""
    t = sympy.Symbol("t")
    g, R, r, I1, I2, M, m1, m2, m3 = sympy.symbols("g R r I1 I2 M m1 m2 m3")
    x, y = sympy.Function("x")(t), sympy.Function("y")(t)
    heights = ((m1, -x), (M, x), (m2, x - y), (m3, x + y))
    turning = I1 * (x.diff(t) / R) ** 2 + I2 * (y.diff(t) / r) ** 2
    L = turning / 2 + sum(m * (z.diff(t) ** 2 / 2 - g * z) for m, z in heights)
    by_hand = [sympy.expand(L.diff(q.diff(t)).diff(t) - L.diff(q)) for q in (x, y)]
    scene = read_text(ATWOOD)

    printed = symdyn.equations(scene).text().replace(" = 0", "").splitlines()

    names = {f"{q.func}_ddot": q.diff(t, 2) for q in (x, y)}
    known = {str(one): one for one in (g, R, r, I1, I2, M, m1, m2, m3)}
    assert [
        sympy.simplify(sympy.sympify(row, names | known) - one) for row, one in zip(printed, by_hand, strict=True)
    ] == [0, 0]
    assert symdyn.certify(scene, ("inverse_dynamics", "mass_matrix"), targets=["numpy"]).passed


def test_threads_over_light_drums_fall_as_in_morin():
    """Introduction to Classical Mechanics, 3.2: a₁ = g (4 m₂ m₃ - m₁ (m₂ + m₃))/(4 m₂ m₃ + m₁ (m₂ + m₃)), upwards."""
    m1, m2, m3 = 4.0, 1.0, 2.0
    light = bind(
        read_text(ATWOOD), {"g": 9.81, "R": 0.2, "r": 0.1, "I1": 0, "I2": 0, "M": 0, "m1": m1, "m2": m2, "m3": m3}
    )

    fall = symdyn.lambdify(light, "forward_dynamics")([0.3, 0.1], [0, 0], [0, 0])[0]

    assert -fall == pytest.approx(9.81 * (4 * m2 * m3 - m1 * (m2 + m3)) / (4 * m2 * m3 + m1 * (m2 + m3)), rel=1e-14)


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
        ('{ ratios = { s = 0, r = "0*zr" } }', 'joints.c: mimic: ratios are all zero, and the joint follows nothing; '
         'write type = "fixed", or mimic = { ratios = { left = "1/2", right = "1/2" } }'),
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
