"""Friction along two directions, and contacts that hold the same: closed forms, laws, and what rests."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan, cos, pi, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.errors import DerivationError
from symdyn.scene import Scene, read_text
from symdyn.simulation import Trajectory
from symdyn.simulation.equations.complementarity import FREE, SLIP, STICK, Case, Laws

pytestmark = pytest.mark.runs("cc")

G = 9.81

FREE_BODY = """
gravity = ["9.81*sin(slope)", 0, "-9.81*cos(slope)"]
[parameters]
slope = 0
mu = 0.3
e = 0
cx = 0
cy = 0
[bodies.b]
mass = 2
com = ["cx", "cy", 0]
inertia = [INERTIA]
inertia_about = "com"
[joints.free]
type = "free"
parent = "ground"
child = "b"
"""

LAW = """body = "b"
friction = "mu"
restitution = "e"
plane = { normal = [0, 0, 1] }
"""

BALL = FREE_BODY.replace("INERTIA", "0.2, 0.2, 0.2") + f'[contacts.floor]\ntype = "ball"\nradius = 0.5\n{LAW}'
"""A ball of radius 0.5 m, J = 2/5 m r²."""


def on_feet(places: dict[str, tuple[float, float]]) -> str:
    feet = (f"[contacts.{name}]\nat = [{x!r}, {y!r}, -0.1]\n{LAW}" for name, (x, y) in places.items())
    return FREE_BODY.replace("INERTIA", "0.05, 0.06, 0.07") + "".join(feet)


BOX = read_text(on_feet({"a": (-0.3, -0.2), "b": (-0.3, 0.2), "c": (0.3, -0.2), "d": (0.3, 0.2)}))


LEVEL = (0, 0, 0.1, 1, 0, 0, 0)


def moved(scene: Scene, place: Sequence[float], rates: Sequence[float], **asked: Any) -> Trajectory:
    start, start_rates = (
        dict(zip(names, values, strict=True))
        for names, values in ((scene.coordinates, place), (scene.velocities, rates))
    )
    return symdyn.simulate(scene, start=start, start_rates=start_rates, **asked)


def box(rates: Sequence[float], until: float, place: Sequence[float] = LEVEL, **values: float) -> Trajectory:
    return moved(BOX, place, rates, until=until, values=values)


def ball(rates: Sequence[float], until: float, height: float = 0.5, e: float = 0, **asked: Any) -> Trajectory:
    return moved(read_text(BALL), (0, 0, height, 1, 0, 0, 0), rates, until=until, values={"e": e}, **asked)


def point(slope: float, across: float) -> str:
    text = f"gravity = [{G * sin(slope)}, 0, {-G * cos(slope)}]\n[bodies.b]\nmass = 1\n"
    parent = "ground"
    for name, axis, rate in (("x", [1, 0, 0], 0), ("y", [0, 1, 0], across), ("z", [0, 0, 1], 0)):
        child = "b" if name == "z" else name
        text += f'[joints.{name}]\ntype = "prismatic"\nparent = "{parent}"\nchild = "{child}"\naxis = {axis}\n'
        text += f'coordinate = "{name}"\nstart_rates = {rate}\n' + (f"[bodies.{name}]\n" if name != "z" else "")
        parent = name
    return f'{text}[contacts.c]\nbody = "b"\nfriction = {tan(slope)!r}\nplane = {{ normal = [0, 0, 1] }}\n'


@pytest.mark.heavy("radau")
@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_ball_that_slides_with_spin_rolls_when_its_closed_form_says(method: str) -> None:
    """The slip s decreases along a line by 7/2 μ g; see Hopkins and Patterson, Bowling frames (1977)."""
    run = ball([1, 2, 0, 6, 8, 10], 1, method=method)
    slip = np.array([1 - 0.5 * 8, 2 + 0.5 * 6])  # v + ω × (-r e_z)
    rolls = 2 * np.linalg.norm(slip) / (7 * 0.3 * G)
    (sticks,) = run.impacts
    assert sticks.what == "sticks"
    assert sticks.t == pytest.approx(rolls, abs=1e-8)
    moved = np.array([1, 2]) * rolls - 0.5 * 0.3 * G * rolls**2 * slip / np.linalg.norm(slip)
    later = np.array([1, 2]) - 2 / 7 * slip  # what is left when it rolls
    assert [run["q1"][-1], run["q2"][-1]] == pytest.approx(moved + later * (1 - rolls), abs=1e-7)
    assert run["mode_floor"][[0, -1]].tolist() == [2, 1]
    assert run["friction_along_floor"][0] == pytest.approx(-0.3 * 2 * G * slip[0] / np.linalg.norm(slip))
    assert np.abs(run["energy_error"]).max() < 1e-7


def test_a_ball_that_strikes_with_spin_takes_the_impulse_of_its_closed_form() -> None:
    """It slips through the whole impact where μ (1 + e) |v_z| is less than 2/7 of its slip."""
    run = ball([3, 4, 0, 0, 0, 0], 0.6, 1.5, e=0.5)
    fast, strikes = sqrt(2 * G), run.impacts[0]
    size = 2 * 1.5 * fast
    share = min(0.3 * size, 2 / 7 * 2 * 5)
    assert strikes.impulse == pytest.approx([size, -0.6 * share, -0.8 * share], rel=1e-8)
    lost = 2 * (1 - 0.5**2) * fast**2 / 2 + share * 5 - share**2 * (1 / 2 + 0.25 / 0.2) / 2
    assert strikes.lost == pytest.approx(lost, rel=1e-8)


def test_a_point_on_a_slope_as_steep_as_its_friction_ends_with_half_its_speed() -> None:
    """v (1 + cos ψ) is kept where μ = tan α, ψ between velocity and the way down."""
    run = symdyn.simulate(read_text(point(0.4, 1.0)), until=12, rtol=1e-10)
    speed = np.hypot(run["x_dot"], run["y_dot"])
    assert speed + run["x_dot"] == pytest.approx(1.0, abs=1e-7)
    assert speed[-1] == pytest.approx(0.5, abs=1e-6)


def test_a_box_on_four_corners_rests() -> None:
    for mu in (0.3, 0.0):
        run = box([0] * 6, 3, mu=mu)
        assert not run.impacts
        assert max(np.abs(run[f"gap_{name}"]).max() for name in "abcd") < 1e-12
        assert [run[f"normal_{name}"][-1] for name in "abcd"] == pytest.approx([G / 2] * 4, rel=1e-8)
        assert np.abs(run["free_vz"]).max() < 1e-12


@pytest.mark.heavy("0.4", "0.299")
@pytest.mark.parametrize("slope", [0.299, 0.301, 0.4])
def test_a_box_on_a_slope_sticks_or_slides_as_one_block(slope: float) -> None:
    """Corners above carry less, and friction is what their load lets it be."""
    run = box([0] * 6, 1, slope=atan(slope))
    pull = G * (slope - 0.3) / sqrt(1 + slope**2) if slope > 0.3 else 0.0
    assert run["q1"][-1] == pytest.approx(pull / 2, abs=2e-8)
    assert run["normal_a"][0] < run["normal_c"][0]
    assert sum(run[f"friction_along_{name}"][-1] for name in "abcd") == pytest.approx(
        2 * (pull - G * slope / sqrt(1 + slope**2))
    )


@pytest.mark.wide("0.2-0.12")
@pytest.mark.parametrize(("x", "y"), [(0, 0), (0.2, 0.12)])
def test_a_box_slides_and_stops_with_the_load_where_it_is(x: float, y: float) -> None:
    run = box([1, 0.5, 0, 0, 0, 0], 1, cx=x, cy=y)
    stops = sqrt(1.25) / (0.3 * G)
    assert {one.what for one in run.impacts} == {"sticks"}
    assert run.impacts[0].t == pytest.approx(stops, abs=1e-8)
    assert [run["q1"][-1], run["q2"][-1]] == pytest.approx([stops / 2, stops / 4], abs=1e-8)
    loads = [run[f"normal_{name}"][-1] for name in "abcd"]
    assert min(loads) >= 0
    assert sum(loads) == pytest.approx(2 * G)


def test_a_stool_that_spins_stops_when_its_closed_form_says() -> None:
    """J ω / (μ m g R)."""
    feet = {f"c{k}": (0.3 * cos(2 * pi * k / 3), 0.3 * sin(2 * pi * k / 3)) for k in range(3)}
    run = moved(read_text(on_feet(feet)), LEVEL, [0, 0, 0, 0, 0, 5], until=1)
    assert run.impacts[0].t == pytest.approx(0.07 * 5 / (0.3 * 2 * G * 0.3), abs=1e-8)
    assert np.abs(run["free_wz"][-1]) < 1e-12


@pytest.mark.wide("0.5")
@pytest.mark.parametrize("restitution", [0, 0.5])
def test_a_box_dropped_flat_strikes_with_all_its_corners(restitution: float) -> None:
    run = box([0] * 6, 2, (0, 0, 0.3, 1, 0, 0, 0), e=restitution)
    first = sqrt(0.4 / G)
    assert [one.contact for one in run.impacts[:4]] == list("abcd")
    assert [one.impulse[0] for one in run.impacts[:4]] == pytest.approx([(1 + restitution) * G * first / 2] * 4)
    hits = sorted({round(one.t, 9) for one in run.impacts})[:5]
    flights = [first * (1 + 2 * sum(restitution**i for i in range(1, k + 1))) for k in range(len(hits))]
    assert hits == pytest.approx(flights, abs=1e-8)
    assert run["q3"][-1] == pytest.approx(0.1, abs=1e-9)
    assert [run[f"mode_{name}"][-1] for name in "abcd"] == [1] * 4
    assert np.abs([run["q5"][-1], run["q6"][-1]]).max() < 1e-10


def test_a_box_that_falls_askew_comes_to_rest_and_never_gains_energy() -> None:
    run = box([1, 0.5, 0, 1, 2, 3], 1.5, (0, 0, 0.6, 0.9, 0.1, 0.2, 0.3))
    assert min(one.lost for one in run.impacts) >= 0
    assert min(run[f"gap_{name}"].min() for name in "abcd") > -1e-8
    assert [run[f"mode_{name}"][-1] for name in "abcd"] == [1] * 4
    assert run["kinetic_energy"][-1] < 1e-20
    assert np.abs(run["energy_error"]).max() < 1e-7


@pytest.mark.parametrize("mass", [1e-9, 1e9])
def test_what_is_heavy_or_light_strikes_as_anything_else(mass: float) -> None:
    """Rows of forces and of velocities have one scale."""
    run = moved(
        read_text(BALL.replace("mass = 2", f"mass = {mass}").replace("0.2, 0.2, 0.2", ", ".join([f"{mass / 10}"] * 3))),
        (0, 0, 1.5, 1, 0, 0, 0),
        [3, 4, 0, 0, 0, 0],
        until=0.6,
        values={"e": 0.5},
        method="dop853",
    )
    strikes = run.impacts[0]
    assert strikes.impulse[0] == pytest.approx(1.5 * mass * sqrt(2 * G), rel=1e-9)
    assert np.linalg.norm(strikes.impulse[1:]) == pytest.approx(mass * min(0.45 * sqrt(2 * G), 10 / 7), rel=1e-8)


def test_four_legs_share_a_load_as_equal_springs_do() -> None:
    """Forces of least size, which do not depend on where the mass is beside their balance."""
    run = box([0] * 6, 0.1, cx=0.12, cy=0.05)
    balance = np.array([[1, 1, 1, 1], [-0.3, -0.3, 0.3, 0.3], [-0.2, 0.2, -0.2, 0.2]])
    shares = np.linalg.lstsq(balance, 2 * G * np.array([1, 0.12, 0.05]), rcond=None)[0]
    assert [run[f"normal_{name}"][-1] for name in "abcd"] == pytest.approx(shares, rel=1e-7)


@pytest.mark.wide("0.2-0.12")
@pytest.mark.parametrize(("x", "y"), [(0.2, 0.12), (-0.25, 0.15)])
def test_a_box_that_is_loaded_askew_sticks_as_long_as_all_of_it_does(x: float, y: float) -> None:
    run = box([0] * 6, 0.5, slope=atan(0.2999), cx=x, cy=y)
    assert not run.impacts
    assert abs(run["q1"][-1]) < 1e-12
    loads, forces = ([run[f"{word}_{name}"][0] for name in "abcd"] for word in ("normal", "friction_along"))
    assert forces == pytest.approx(-0.2999 * np.array(loads), rel=1e-7, abs=1e-9)


@pytest.mark.slow
def test_a_box_that_is_loaded_askew_slips_and_stops_by_all_methods_alike() -> None:
    """Which corners press is not unique: several motions keep the laws, of which that of least forces is taken."""
    asked = {"until": 0.5, "values": {"cx": 0.2, "cy": 0.12}}
    one, other = (moved(BOX, LEVEL, (1, 0.5, 0, 0, 0, 2), method=name, **asked) for name in ("taylor", "dop853"))

    assert one.t[-1] == other.t[-1] == 0.5
    np.testing.assert_allclose(one.q[-1], other.q[-1], atol=1e-8)
    assert np.abs(one.qd[-1]).max() < 1e-9
    assert max(value for name, value in one.monitors.items() if name.startswith("contact_laws")) < 1e-6


@pytest.mark.wide("0.003")
@pytest.mark.parametrize("apart", [0.1, 0.003])
def test_feet_that_are_close_to_each_other_hold_what_they_hold(apart: float) -> None:
    """Their rows are nearly the same, and the body does not turn."""
    text = on_feet({"a": (-apart, -0.1), "b": (apart, -0.1), "c": (0, 0.1)}).replace("0.05, 0.06, 0.07", "1, 1, 1")
    feet = read_text(text + '[loads.turns]\nbody = "b"\ncouple = [0, M, 0]\n'.replace("M", repr(-apart * G / 2)))
    run = moved(feet, LEVEL, [0] * 6, until=3, method="dop853")
    assert max(np.abs(run[f"gap_{name}"]).max() for name in "abc") < 1e-11


def drawn(rng: np.random.Generator, k: int) -> tuple[Laws, np.ndarray]:
    B, W = rng.normal(size=(12, 12)), rng.normal(size=(3 * k, 12))
    D = W @ np.linalg.solve(B @ B.T + 0.1 * np.eye(12), W.T)
    mu, tangents = rng.uniform(0, 1, k), tuple((3 * i + 1, 3 * i + 2) for i in range(k))
    return Laws(D, tuple(range(0, 3 * k, 3)), tangents, mu, mu, np.full(k, rng.uniform(0, 1))), W @ rng.normal(size=12)


def test_cases_and_projections_find_impulses_that_keep_all_laws() -> None:
    rng, count = np.random.default_rng(5), 0
    for k in (1, 2, 2, 3) * 3:
        laws, v = drawn(rng, k)
        options = [(FREE, *laws.slips(i)) for i in range(k)]
        none = np.zeros(k)
        every = [found for _, found in laws.solutions(v, options)]
        chosen = [found for _, found in laws.by_projection(v, options, none, np.zeros(3 * k))]
        assert every
        for found in (*every, *chosen):
            xi = laws.D @ found + v
            for n, along, mu in zip(laws.normals, laws.tangents, laws.friction, strict=True):
                force, slip = found[list(along)], xi[list(along)]
                assert found[n] >= -1e-9
                assert xi[n] >= -1e-8
                assert min(found[n], xi[n]) == pytest.approx(0, abs=1e-8)
                assert np.linalg.norm(force) <= mu * found[n] + 1e-8
                if np.linalg.norm(slip) > 1e-7:
                    assert force == pytest.approx(-mu * found[n] * slip / np.linalg.norm(slip), abs=1e-6)
        count += bool(chosen)
        lost = -laws.impact(v, [True] * k) @ (v + laws.D @ laws.impact(v, [True] * k) / 2)
        assert lost >= -1e-12
    assert count >= 11


def test_a_ball_rolls_along_a_corner() -> None:
    """Floor and wall could squeeze it by friction as much as they like; a = g / (1 + 2 J/(m r²)) along the corner."""
    text = BALL.replace('gravity = ["9.81*sin(slope)", 0, "-9.81*cos(slope)"]', "gravity = [-3, -2, -9.81]")
    wall = text[text.index("[contacts.floor]") :].replace("floor", "wall").replace("[0, 0, 1]", "[1, 0, 0]")
    run = moved(read_text(text + wall), (0.5, 0.9, 0.5, 1, 0, 0, 0), [0] * 6, until=0.5, method="dop853")
    assert not run.impacts
    assert run["q2"][-1] == pytest.approx(0.9 - 2 / (1 + 2 * 0.2 / (2 * 0.25)) * 0.125, abs=1e-9)
    for name in ("floor", "wall"):
        assert run[f"mode_{name}"][-1] == 1
        rubs = np.hypot(run[f"friction_along_{name}"], run[f"friction_across_{name}"])
        assert np.all(rubs < 0.3 * run[f"normal_{name}"])


def test_a_pendulum_that_hangs_just_above_its_floor_swings_and_rests() -> None:
    """The floor touches it where its gap has no slope, so that nothing presses."""
    text = """
    gravity = [0, 0, -9.81]
    [bodies.p]
    mass = 1
    com = [0, 0, -1]
    [joints.a]
    type = "revolute"
    parent = "ground"
    child = "p"
    axis = [0, 1, 0]
    coordinate = "a"
    [contacts.c]
    body = "p"
    at = [0, 0, -1]
    friction = 0.2
    plane = { at = [0, 0, -1], normal = [0, 0, 1] }
    """
    assert not np.any(symdyn.simulate(read_text(text), until=1)["a"])
    free = text.split("[contacts", maxsplit=1)[0]
    fast, still = (symdyn.simulate(read_text(one), until=1, start_rates={"a_dot": 2}) for one in (text, free))
    assert fast["a"] == pytest.approx(still["a"], abs=1e-9)


def test_the_dynamics_of_a_mode_slip_along_the_direction_that_is_given() -> None:
    text = BALL.replace('"free"', '"free"\norientation = "zyx"')
    call = symdyn.load(read_text(text), ["contact_dynamics", "gap_jacobian:floor", "gap_jdot:floor"])
    q, u, tau = np.array([0.1, 0.2, 0.5, 0.3, 0.2, 0.1]), np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), np.zeros(6)
    found = np.asarray(call.contact_dynamics(q, u, tau, np.array([1.0]), np.array([0.6, 0.8])))
    n, *t = found[6:]
    assert np.array(t) == pytest.approx(-0.3 * n * np.array([0.6, 0.8]))
    assert (call.gap_jacobian_floor(q) @ found[:6] + call.gap_jdot_floor(q, u))[0] == pytest.approx(0, abs=1e-12)
    sticks = np.asarray(call.contact_dynamics(q, u, tau, np.array([1.0]), np.zeros(2)))
    assert call.gap_jacobian_floor(q) @ sticks[:6] + call.gap_jdot_floor(q, u) == pytest.approx(np.zeros(3), abs=1e-12)


def test_an_impact_along_two_directions_has_no_formula() -> None:
    with pytest.raises(DerivationError) as fault:
        symdyn.load(read_text(BALL), ["impact:floor"])
    assert "it can slip along two directions, and no formula says how" in str(fault.value)


def test_what_slips_already_keeps_its_direction() -> None:
    laws, v = drawn(np.random.default_rng(6), 1)
    way = tuple((v[1:3] / np.linalg.norm(v[1:3])).tolist())
    ((cases, found),) = laws.solutions(np.array([-1.0, 0, 0]), [(Case(True, SLIP, way, True),)])
    assert found[1:] == pytest.approx(-laws.friction[0] * found[0] * np.array(way))
    assert cases[0].numbers == (1, 0, 1, 1)
    assert Case(True, STICK).numbers == (1, 1, 0, 1)
