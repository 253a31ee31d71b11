"""Wheels that mesh, racks, screws and worms: speeds and forces as textbooks have them, and what is told of mistakes."""

from __future__ import annotations

import re
from math import atanh, pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from placeless import placeless

import symdyn
from symdyn.draw.outlines import strings
from symdyn.draw.places import places
from symdyn.errors import SceneError
from symdyn.scene import body, prismatic, revolute, scene
from symdyn.scene.toml import read_text, write_text
from symdyn.simulation import Trajectory

PAIR = """
name = "pair"
gravity = "none"
[parameters]
r1 = { value = 0.05, unit = "m" }
r2 = { value = 0.2, unit = "m" }
J1 = { value = 0.01, unit = "kg m^2" }
J2 = { value = 0.5, unit = "kg m^2" }
[bodies.pinion]
inertia = ["J1", "J1", "J1"]
inertia_about = "com"
[bodies.wheel]
inertia = ["J2", "J2", "J2"]
inertia_about = "com"
[bodies.arm]
inertia = [1, 1, 1]
inertia_about = "com"
[joints.a]
type = "revolute"
parent = "ground"
child = "pinion"
[joints.b]
type = "revolute"
parent = "ground"
child = "wheel"
origin = ["r1 + r2", 0, 0]
mimic = { joint = "a", radii = ["r1", "r2"] }
[joints.c]
type = "revolute"
parent = "ground"
child = "arm"
[outputs]
tooth = "reaction_b_mz/r2"
"""

MESH = 'mimic = { joint = "a", radii = ["r1", "r2"] }'


@pytest.mark.parametrize(("mesh", "sign"), [("", -1), (', mesh = "internal"', 1), (', mesh = "external"', -1)])
def test_a_pair_of_wheels_turns_and_presses_its_teeth_as_by_hand(mesh: str, sign: int) -> None:
    pair = read_text(PAIR.replace('"r2"] }', f'"r2"]{mesh} }}'))
    r1, r2, J1, J2, tau = 0.05, 0.2, 0.01, 0.5, 3.0
    alpha = tau / (J1 + J2 * (r1 / r2) ** 2)

    accelerate, tooth, turns = symdyn.lambdify(pair, ("forward_dynamics", "output:tooth", "jacobian:wheel"))
    state = np.array([0.3, 0.1]), np.array([2.0, 0.4]), np.array([tau, 0.0])
    assert_allclose(accelerate(*state)[0], alpha, rtol=1e-14)
    assert_allclose(turns(state[0])[-1], [sign * r1 / r2, 0], rtol=1e-14)
    assert_allclose(tooth(*state), sign * (tau - J1 * alpha) / r1, rtol=1e-13)  # by the balance of the pinion


def test_radii_are_written_as_the_ratio_that_they_make() -> None:
    for text, ratio in ((PAIR, "-r1/r2"), (PAIR.replace('["r1", "r2"]', "[20, 60]"), "-1/3")):
        pair = read_text(text)
        assert f'ratio = "{ratio}"' in write_text(pair).text
        assert read_text(write_text(pair).text).joints == pair.joints


def test_wheels_are_declared_in_python_alike() -> None:
    bodies = [body("pinion", inertia=["J1"] * 3, about="com"), body("wheel", inertia=["J2"] * 3, about="com")]
    joints = [
        revolute("a", "ground", "pinion"),
        revolute("b", "ground", "wheel", origin=["r1 + r2", 0, 0], mimic={"joint": "a", "radii": ["r1", "r2"]}),
    ]
    made = scene("pair", bodies=bodies, joints=joints, parameters={"r1": 1, "r2": 2, "J1": 1, "J2": 1})
    assert made.joints == read_text(PAIR).joints[:2]


@pytest.mark.usefixtures("numpy_alone")
def test_formulations_of_a_pair_are_proved_equal() -> None:
    assert symdyn.certify(read_text(PAIR), ("inverse_dynamics", "forward_reactions")).passed


def test_a_planet_rolls_on_its_sun() -> None:
    """By the ratios that the message of two bodies names: both rims move alike where they touch."""
    rs, rp = 0.3, 0.1
    bodies = [body(name, mass=1, inertia=[1, 1, 1], about="com") for name in ("sun", "carrier", "planet")]
    joints = [
        revolute("sun", "ground", "sun", coordinate="s"),
        revolute("carrier", "ground", "carrier", coordinate="c"),
        revolute(
            "planet", "carrier", "planet", origin=["rs + rp", 0, 0],
            mimic={"ratios": {"sun": "-rs/rp", "carrier": "rs/rp"}},
        ),
    ]  # fmt: skip
    gear = scene("gear", bodies=bodies, joints=joints, parameters={"rs": rs, "rp": rp})
    found = symdyn.lambdify(gear, ("jacobian:sun", "jacobian:carrier", "jacobian:planet"))
    sun, carrier, planet = (one([0.2, 0.7])[-1] for one in found)

    assert_allclose(sun * rs, carrier * (rs + rp) - planet * rp, atol=1e-15)


def test_a_rack_and_a_screw_are_ratios() -> None:
    bodies = [body("shaft", inertia=[1, 1, 1], about="com", mass=1), body("table", mass=4)]
    for ratio, expected in (("r", 0.05), ("lead/(2*pi)", 0.01 / (2 * pi))):
        slides = prismatic("slide", "ground", "table", mimic={"joint": "turn", "ratio": ratio})
        drive = scene(
            "drive", bodies=bodies, joints=[revolute("turn", "ground", "shaft"), slides],
            parameters={"r": "5 cm", "lead": "1 cm"}, gravity="none",
        )  # fmt: skip
        alpha = symdyn.lambdify(drive, "forward_dynamics")([0.1], [0.3], [2.0])
        assert_allclose(alpha, 2 / (1 + 4 * expected**2), rtol=1e-14)


ADVICE = 'write mimic = { joint = "motor", radii = ["r1", "r2"] }, of that wheel and its own, or both numbers of teeth'

FAULTS = [
    ('radii = ["r1"]', f'mimic: radii = ["r1"] is no list of two; {ADVICE}'),
    ("radii = 2", f"mimic: radii = 2 is no list of two; {ADVICE}"),
    ("radii = [-1, 2]", "mimic: radii: -1 is that of no wheel; give two above zero, and mesh for the direction"),
    ("radii = [1, 0]", "mimic: radii: 0 is that of no wheel; give two above zero, and mesh for the direction"),
    ('radii = ["5 kg", 2]', 'mimic: radii = ["5 kg", 2] is in kg, and m is asked for'),
    ("ratio = 2, radii = [1, 2]", "mimic: radii and ratio both say how far it turns; write one of them"),
    ('mesh = "internal"', f"mimic: mesh is that of two wheels; {ADVICE}"),
    ('radii = [1, 2], mesh = "inside"', 'mimic: mesh = "inside" is not known; write "external" or "internal"'),
]


@pytest.mark.parametrize(("said", "told"), FAULTS)
def test_a_mistake_in_radii_is_told(said: str, told: str) -> None:
    with pytest.raises(SceneError) as refused:
        read_text(PAIR.replace('radii = ["r1", "r2"]', said))
    assert placeless(refused.value).split("\n")[0] == f"scene.toml: joints.b: {told}"


def test_wheels_on_two_bodies_and_slides_are_told() -> None:
    before, after = PAIR.split("[joints.b]")
    with pytest.raises(SceneError) as refused:
        read_text(before + "[joints.b]" + after.replace('parent = "ground"', 'parent = "arm"', 1))
    assert placeless(refused.value) == (
        "scene.toml: joints.b: mimic.radii: a turns on ground and b on arm, so that a third angle counts; write "
        'ratios, as of a planet on a carrier ratios = { sun = "-rs/rp", carrier = "rs/rp" }'
    )
    with pytest.raises(SceneError) as refused:
        read_text(before + "[joints.b]" + after.replace('"revolute"', '"prismatic"', 1))
    assert placeless(refused.value).split("\n")[0] == (
        "scene.toml: joints.b: mimic.radii are those of two wheels that turn, and b is a prismatic joint; of a rack "
        'write ratio = "r", of a screw ratio = "lead/(2*pi)"'
    )


# A worm, whose friction goes by the direction of its power


def slope(run: Trajectory, part: float = 0.5) -> float:
    """Return the acceleration of the worm over the last part of a run, after its teeth have come to rest."""
    late = run.t >= run.t[-1] * part
    return float(np.polyfit(run.t[late], run["phi_dot"][late], 1)[0])


@pytest.mark.runs("cc")
@pytest.mark.parametrize(("motor", "way"), [(3.5, 1), (-2.5, -1)])
def test_a_worm_loses_the_share_that_its_efficiency_says_in_both_directions(motor: float, way: int) -> None:
    """Jw a = motor - n T / η_up going up, motor - n T η_down going down, with η_down = 2 - 1/η_up; Jd n a = T - M."""
    n, Jw, Jd, M = 1 / 30, 2e-4, 0.05, 60.0
    share = {1: 1 / 0.7, -1: 2 - 1 / 0.7}[way]
    rates = {"phi": 30 * way, "theta": way}
    run = symdyn.simulate(symdyn.example("worm"), until=0.4, forces={"motor": motor}, start_rates=rates)
    expected = (motor - n * M * share) / (Jw + n * n * Jd * share)

    assert run["phi_dot"][-1] * way > 30
    assert slope(run) == pytest.approx(expected, rel=1e-3)
    bent = n * run["phi"] - run["theta"]
    kept = run["kinetic_energy"] + 2e4 * bent**2 / 2
    given = motor * run["phi_dot"] - M * run["theta_dot"]
    given = np.concatenate([[0], np.cumsum(np.diff(run.t) * (given[1:] + given[:-1]) / 2)])
    assert (np.diff(given - kept) > 0).all()  # what is lost only grows
    assert run.monitors["energy"] < 1e-7 * run.monitors["energy_scale"]


@pytest.mark.runs("cc")
def test_a_worm_below_one_half_is_not_turned_by_its_load() -> None:
    """It creeps, as tanh stands for the sign: n M = n M (1/η - 1) tanh(φ'/w0); above one half it runs away."""
    held, runs = (
        symdyn.simulate(symdyn.example("worm"), until=0.4, forces={"motor": 0}, values={"eta": eta})["phi_dot"][-1]
        for eta in (0.45, 0.6)
    )
    assert held == pytest.approx(-0.5 * atanh(0.45 / 0.55), rel=1e-6)
    assert runs < -1000


BELT = """
name = "fan"
gravity = [0, 0, 0]
[parameters]
d = { value = 0.5, unit = "m", positive = true }
[bodies.motor]
mass = 1
inertia = [1, 1, 1]
inertia_about = "com"
[bodies.fan]
mass = 1
inertia = [1, 1, 1]
inertia_about = "com"
[joints.shaft]
type = "revolute"
parent = "ground"
child = "motor"
axis = [0, 0, 1]
[joints.hub]
type = "revolute"
parent = "ground"
child = "fan"
axis = [0, 0, 1]
origin = ["d", 0, 0]
mimic = { joint = "shaft", radii = [0.1, 0.2], mesh = "internal" }
"""


@pytest.mark.parametrize(("mesh", "apart", "sign"), [("external", "r1 + r2", 1), ("internal", "r2 - r1", -1)])
def test_wheels_that_mesh_are_drawn_by_pitch_circles_that_touch(mesh: str, apart: str, sign: int) -> None:
    pair = read_text(PAIR.replace('"r2"] }', f'"r2"], mesh = "{mesh}" }}').replace("r1 + r2", apart))
    known = {"r1": 0.05, "r2": 0.2}
    (pinion, _, r), (wheel, _, s) = places(pair, np.zeros((2, 2)), known).wheels.values()
    assert (r, s) == (0.05, 0.2)
    assert_allclose(np.linalg.norm(wheel - pinion, axis=1), s + sign * r)
    assert not strings(pair), "no belt runs around them"
    apart_ones = read_text(PAIR.replace("r1 + r2", "r1 + r2 + 0.1"))
    assert not places(apart_ones, np.zeros((2, 2)), known).wheels, "an idler between them is not in the scene"
    drawn = re.findall(r'<g id="body-(\w+)">.*\n<ellipse class="link', str(symdyn.picture(pair)))
    assert drawn == ["pinion", "wheel"]


def test_a_belt_touches_both_wheels_and_a_ring_gear_has_none() -> None:
    drive = read_text(BELT, "fan.toml")
    (route,) = places(drive, np.array([[0.0], [1.3]]), {"d": 0.5}).routes.values()
    lean = -0.1 / 0.5  # of what stands across a straight part: (r1 - r2) / d
    across = [np.array([lean, side * np.sqrt(1 - lean**2), 0]) for side in (-1, 1)]
    for out, (near, far) in zip(across, (route[0][-2:], route[1][-2:][::-1]), strict=True):
        assert_allclose(near, np.tile(0.1 * out, (2, 1)), atol=1e-12)
        assert_allclose(far, np.tile(0.2 * out + [0.5, 0, 0], (2, 1)), atol=1e-12)
    assert 'class="rope"' in str(symdyn.picture(drive))
    for other in ('radii = [0.1, 0.6], mesh = "internal"', "radii = [0.1, 0.2]"):
        assert not strings(read_text(BELT.replace('radii = [0.1, 0.2], mesh = "internal"', other), "fan.toml"))
