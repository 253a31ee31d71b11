"""A bead on a wire, a ball in a bowl: a custom joint whose motion is a curve or a surface."""

import numpy as np
import pytest

import symdyn
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


@pytest.mark.parametrize("text", [CYCLOID, BOWL])
def test_formulations_agree(text):
    assert symdyn.certify(read_text(text), ("inverse_dynamics", "mass_matrix"), targets=["numpy"]).passed


def test_the_wire_is_drawn():
    svg = symdyn.picture(read_text(CYCLOID), q=[0.5])

    assert str(svg).count("rail") > 0
