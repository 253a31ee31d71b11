"""A bead on a wire, a ball in a bowl: a custom joint whose motion is a curve or a surface."""

import numpy as np
import pytest
from scipy.optimize import brentq

import symdyn
from symdyn.scene import bind
from symdyn.scene.toml import read_text

CYCLOID = """
name = "cycloid"
gravity = [0, "-g", 0]
[parameters]
m = { value = 0.1, unit = "kg", positive = true }
a = { value = 0.5, unit = "m", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies.bead]
particles = [{ mass = "m", at = [0, 0, 0] }]
[joints.wire]
type = "custom"
parent = "ground"
child = "bead"
coordinate = "u"
units = ["rad"]
steps = [["Tx", "a*(u + sin(u))"], ["Ty", "-a*cos(u)"]]
drive = false
"""

LOOP = """
name = "roller_coaster"
gravity = [0, "-g", 0]
[parameters]
m = { value = 400, unit = "kg", positive = true }
R = { value = 6, unit = "m", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies.car]
particles = [{ mass = "m", at = [0, 0, 0] }]
[joints.rail]
type = "custom"
parent = "ground"
child = "car"
coordinate = "u"
units = ["rad"]
steps = [["Tx", "R*sin(u)"], ["Ty", "R*(1 - cos(u))"]]
drive = false
[outputs]
normal = "-reaction_rail_fx_ground*sin(u) + reaction_rail_fy_ground*cos(u)"
"""

BOWL = """
name = "bowl"
gravity = [0, 0, "-g"]
[parameters]
m = { value = 0.1, unit = "kg", positive = true }
k = { value = 2, unit = "1/m", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies.ball]
particles = [{ mass = "m", at = [0, 0, 0] }]
[joints.bowl]
type = "custom"
parent = "ground"
child = "ball"
coordinates = ["x", "y"]
units = ["m", "m"]
steps = [["Tx", "x"], ["Ty", "y"], ["Tz", "k*(x**2 + y**2)/2"]]
drive = false
"""


@pytest.mark.runs
@pytest.mark.parametrize("start", [0.1, 1.0, 2.5])
def test_a_cycloid_is_huygens_tautochrone(start):
    """From any height the bottom is reached after a quarter of 4 π √(a/g)."""
    run = symdyn.simulate(read_text(CYCLOID), until=2, start={"u": start}, stops=["u"])

    assert run.t[-1] == pytest.approx(np.pi * np.sqrt(0.5 / 9.81), rel=1e-10)


@pytest.mark.runs
@pytest.mark.parametrize(("drop", "along"), [(0.3, 0.5), (1.0, 1.5), (0.2, 0.9)])
def test_the_brachistochrone_is_faster_than_lines_and_takes_the_time_of_bernoulli(drop, along):
    """From the cusp T = √(a/g) θ with a, θ of the cycloid through the end; a hair below it, where the run can begin."""
    theta = brentq(lambda x: drop * (x - np.sin(x)) - along * (1 - np.cos(x)), 0.1, 2 * np.pi - 0.01)
    a, g = drop / (1 - np.cos(theta)), 9.81
    late = 0.01  # rad of the cycloid, passed at the speed of a fall from the cusp
    speed = np.sqrt(g / a)  # of u, everywhere

    run = symdyn.simulate(
        bind(read_text(CYCLOID), {"a": a, "m": 0.1, "g": g}), until=2, start={"u": late - np.pi},
        start_rates={"u": speed}, stops=[f"u - {theta - np.pi}"],
    )  # fmt: skip

    taken = run.t[-1] + late / speed
    assert taken == pytest.approx(theta * np.sqrt(a / g), rel=1e-7)
    assert taken < np.sqrt(2 * (drop**2 + along**2) / (g * drop))  # down a straight wire
    assert np.allclose(run["u_dot"], speed, rtol=1e-6)


@pytest.mark.runs
@pytest.mark.parametrize(("height", "holds"), [(2.5, True), (2.4, False), (4.0, True)])
def test_a_roller_coaster_stays_in_its_loop_from_two_and_a_half_radii(height, holds):
    """N = m g (2 h/R - 2 + 3 cos u), zero on top where h = 5/2 R, and six weights more at the bottom."""
    m, g, R = 400, 9.81, 6

    run = symdyn.simulate(read_text(LOOP), until=2, start_rates={"u": np.sqrt(2 * g * height / R)}, stops=["u - pi"])

    closed = m * g * (2 * height - 2 + 3 * np.cos(run["u"]))
    assert run["u"][-1] == pytest.approx(np.pi)
    assert np.allclose(run["normal"], closed, rtol=1e-7, atol=1e-4 * m * g)
    assert (closed.min() >= -1e-6 * m * g) == holds


@pytest.mark.parametrize("u", [0.0, 0.7, -2.0])
def test_the_reaction_is_the_normal_force_of_a_curve(u):
    """N = m g cos α + m v² / ρ, with ρ = 4 a cos(u/2) and the slope α = u/2 of the cycloid."""
    scene, v = read_text(CYCLOID), 1.3
    a, reactions = symdyn.lambdify(scene, ("forward_dynamics", "reactions:ground"))
    speed = v / (2 * 0.5 * np.cos(u / 2))

    force = reactions([u], [speed], a([u], [speed], [0])).reshape(-1)[:3]

    along, normal = (np.cos(u / 2), np.sin(u / 2), 0), (-np.sin(u / 2), np.cos(u / 2), 0)
    assert np.dot(force, along) == pytest.approx(0, abs=1e-14)
    assert np.dot(force, normal) == pytest.approx(0.1 * (9.81 * np.cos(u / 2) + v**2 / (2 * np.cos(u / 2))), rel=1e-12)


@pytest.mark.runs
def test_a_ball_rounds_a_paraboloid_at_one_speed():
    """ω² = g k at every height."""
    radius, omega = 0.6, np.sqrt(9.81 * 2)

    run = symdyn.simulate(read_text(BOWL), until=2, start={"x": radius}, start_rates={"y": radius * omega})

    assert np.allclose(np.hypot(run["x"], run["y"]), radius, rtol=1e-9)
    assert run["x"][-1] == pytest.approx(radius * np.cos(2 * omega), rel=1e-7)


@pytest.mark.parametrize("text", [CYCLOID, LOOP, BOWL])
def test_formulations_agree(text):
    assert symdyn.certify(read_text(text), ("inverse_dynamics", "mass_matrix"), targets=["numpy"]).passed


def test_the_wire_is_drawn():
    svg = symdyn.picture(read_text(CYCLOID), q=[0.5])

    assert str(svg).count("rail") > 0
