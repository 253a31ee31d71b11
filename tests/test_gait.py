"""Periodic motions: fixed points and Floquet multipliers against closed forms and published figures."""

from __future__ import annotations

import json
from dataclasses import replace
from math import acos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contact_scenes import wheel

import symdyn
from symdyn.cli import main
from symdyn.errors import SimulateError
from symdyn.scene import read_text
from symdyn.simulation.return_map import ReturnMap
from symdyn.simulation.variations import state_covectors

DATA = Path(__file__).parent / "data" / "impacts"
WALKER = DATA / "scenes" / "walker.toml"
CASES = {
    one["id"]: one["values"] for one in json.loads((DATA / "references.json").read_text())["cases"] if "values" in one
}

pytestmark = pytest.mark.runs("cc")

LIMIT = """
units = "none"
[parameters]
slope = 0.009
[bodies.idle]
mass = 1
[joints.idle]
type = "prismatic"
parent = "ground"
child = "idle"
axis = [0, 0, 1]
coordinate = "idle"
damping = 20
[states.theta]
rate = "omega"
reset = { when = "phi - 2*theta", way = "up", to = "-theta" }
[states.omega]
rate = "sin(theta - slope)"
reset = { when = "phi - 2*theta", way = "up", to = "cos(2*theta)*omega" }
[states.phi]
rate = "nu"
reset = { when = "phi - 2*theta", way = "up", to = "-2*theta" }
[states.nu]
rate = "sin(phi)*(omega**2 - cos(theta - slope)) + sin(theta - slope)"
reset = { when = "phi - 2*theta", way = "up", to = "cos(2*theta)*(1 - cos(2*theta))*omega" }
"""


@pytest.mark.parametrize("which", ["long", "short"])
def test_the_simplest_walker_has_the_published_gaits(which: str) -> None:
    """Feet without mass: states that are reset where a foot strikes."""
    truth = CASES["simplest_walker"][which]
    theta, omega = round(truth["theta"], 4), round(truth["rate"], 4)
    start = {"theta": theta, "omega": omega, "phi": 2 * theta, "nu": (1 - np.cos(2 * theta)) * omega}
    found = symdyn.gait(read_text(LIMIT), section="phi - 2*theta", start=start)
    wanted = [complex(*np.atleast_1d(one)) for one in truth["multipliers"]]
    assert found.multipliers == pytest.approx(np.array(wanted), abs=1.5e-8)
    assert (found.start["theta"], found.start["omega"]) == pytest.approx((truth["theta"], truth["rate"]), abs=2e-9)
    assert found.period == pytest.approx(truth["T"], abs=1e-9)
    assert found.stable == (which == "long")
    assert found.errors.max() < 1e-8


@pytest.fixture(scope="module")
def walk() -> symdyn.simulation.Gait:
    found = symdyn.gait(WALKER, section="strikes foot_a", swap="a=b")
    return found.continued("m", [3e-3, 6e-3, 1e-2])[-1]


def test_saltation_matrices_agree_with_differences_of_the_return_map(walk: symdyn.simulation.Gait) -> None:
    returns = ReturnMap.of(walk.problem, walk.section, walk.swap, 0.0, walk.until, 1e-13)
    x, there = returns.fixed_point()
    returns = replace(returns, section=replace(returns.section, sooner=0.1))
    U, sizes, _ = np.linalg.svd(there.slope)
    basis = U[:, sizes > 1e-8]  # on the section, where a foot has struck
    rows = state_covectors(returns.flow, x)[returns._ways(x)[2]]
    moved, behind = np.zeros((2, *basis.shape))
    for k, way in enumerate(basis.T):
        for part, weight in ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12)):
            y = returns._moved(x, there, part * 5e-5 * way)
            moved[:, k] += weight / 5e-5 * (rows @ (y - x))
            behind[:, k] += weight / 5e-5 * (rows @ (y - x) + returns.missed(y, returns.at(y)))
    assert there.slope @ moved == pytest.approx(behind, abs=1e-8)
    by_differences = np.linalg.eigvals(np.linalg.lstsq(moved, behind)[0])
    for one in walk.multipliers:
        assert np.abs(by_differences - one).min() < 1e-8


def test_a_gait_is_a_motion_that_repeats_itself(walk: symdyn.simulation.Gait) -> None:
    step = walk.run
    assert step["a"][-1] == pytest.approx(walk.start["b"], abs=1e-7)
    assert step["x"][-1] - step["x"][0] == pytest.approx(walk.advances["x"], abs=1e-7)
    assert walk.stable
    assert len(walk.multipliers) == 2
    assert walk.missed < 1e-9


def test_slope_doubles_the_period_of_the_walker(walk: symdyn.simulation.Gait) -> None:
    found = walk.continued("slope", [0.012, 0.015, 0.017])
    assert [one.stable for one in found] == [True, False, False]
    assert min(found[-1].multipliers.real) < -1
    with pytest.raises(SimulateError, match=r"slope = 1: .* does not happen"):
        replace(walk, until=0.5).continued("slope", [1.0])


@pytest.mark.slow
def test_a_rimless_wheel_forgets_by_the_square_of_what_a_strike_leaves() -> None:
    values = CASES["rimless_wheel"]
    found = symdyn.gait(read_text(wheel(0.08)), section="strikes s1", until=20)
    assert found.start["theta_dot"] == pytest.approx(-values["fixed_point"], abs=1e-9)
    assert found.multipliers == pytest.approx([values["multiplier"] ** 8], abs=2e-9)
    assert found.advances["x"] == pytest.approx(16 * sin(pi / 8), abs=1e-9)


TABLE = """
gravity = [0, 0, -9.81]
[parameters]
e = 0.8
[bodies.table]
mass = 1
[bodies.ball]
mass = 1
[joints.table]
type = "prismatic"
parent = "ground"
child = "table"
axis = [0, 0, 1]
coordinate = "s"
motion = "0.05*sin(10*t)"
[joints.z]
type = "prismatic"
parent = "ground"
child = "ball"
axis = [0, 0, 1]
coordinate = "z"
[contacts.c]
body = "ball"
plane = { body = "table", normal = [0, 0, 1] }
restitution = "e"
"""


@pytest.mark.parametrize("sign", [1, -1])
def test_a_ball_on_a_vibrating_table_bounces_as_its_closed_form_says(sign: int) -> None:
    """It hits where 0.5 cos φ = g T (1 - e)/(2 (1 + e)); one of two such phases is stable."""
    w, g, e, period = 10.0, 9.81, 0.8, 2 * pi / 10
    phase = sign * acos(g * period * (1 - e) / (2 * (1 + e) * 0.05 * w))
    hit, v = (phase % (2 * pi)) / w, g * period / 2
    later = period / (0.05 * w * np.cos(phase) + v)  # ∂(next hit)/∂(v behind a hit)
    jerk = e * g - (1 + e) * 0.05 * w**2 * np.sin(phase)
    truth = np.linalg.eigvals([[1, later], [-e * g + jerk, -e + jerk * later]])
    flown = period - hit
    z, rate = 0.05 * sin(phase) + v * flown - g / 2 * flown**2, v - g * flown
    found = symdyn.gait(read_text(TABLE), period=period, start={"z": z + 1e-4}, start_rates={"z_dot": rate})
    assert (found.start["z"], found.start["z_dot"]) == pytest.approx((z, rate), abs=1e-8)
    assert sorted(found.multipliers, key=abs) == pytest.approx(sorted(truth.astype(complex), key=abs), abs=1e-8)
    assert found.stable == (sign == 1)
    for one, true in zip(sorted(found.multipliers, key=abs), sorted(truth, key=abs), strict=True):
        assert abs(abs(one) - abs(true)) <= found.errors.max()


def test_runs_have_derivatives_through_impacts() -> None:
    scene = read_text((DATA / "scenes" / "ball.toml").read_text().replace('"0.8"', '"e"') + "[parameters]\ne = 0.8\n")
    T, e, g = 1.3, 0.8, 9.81  # the second flight
    h = np.array([1.0])
    t1 = (2 * h / g) ** 0.5
    t2 = t1 * (1 + 2 * e)
    assert t1 < T
    assert t2 < T
    found, back = (symdyn.sensitivity(scene, until=T, by=by) for by in ("forward", "adjoint"))
    v = e**2 * g * t1  # behind the second hit
    dv = np.array([e**2 * g * t1 / (2 * h), 2 * e * g * t1])  # by h, by e
    dt = np.array([t2 / (2 * h), 2 * t1])
    rates = dv + g * dt
    places = dv * (T - t2) - dt * (v - g * (T - t2))
    assert found.matrix[:, [0, 2]] == pytest.approx(np.array([places[:, 0], rates[:, 0]]), abs=1e-8)
    assert back.matrix == pytest.approx(found.matrix, abs=1e-9)


def test_periodic_motions_without_contacts_are_found_too() -> None:
    swing = symdyn.gait(symdyn.example("pendulum"), section="q1", start="q1=0.3", values={"b": 0})
    assert swing.multipliers == pytest.approx([1], abs=1e-8)
    assert "neither stable nor unstable" in swing.words[0]
    forced = symdyn.gait(symdyn.example("pendulum"), forces="tau1=cos(t)", period=2 * pi)
    assert forced.stable
    assert np.prod(forced.multipliers).imag == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({}, "give section"),
        ({"section": "a", "period": 1}, "give section"),
        ({"period": -1}, "above zero"),
        ({"section": "strikes foot_c"}, "did you mean"),
        ({"section": "strikes foot_a", "swap": "a=c"}, "a would be c"),
        ({"section": "strikes foot_a", "swap": "u=v"}, "no name has such a part"),
        ({"section": "strikes foot_a", "swap": "a"}, "write a=b"),
        ({"section": "strikes foot_a", "until": 1}, "does not happen until t = 1 s"),
        ({"section": "slips foot_a"}, "does not happen"),
        ({"section": "a +"}, "section:"),
        ({"section": "strikes foot_a", "swap": {"a": 1}}, "is no name"),
    ],
)
def test_faults_say_what_would_work(asked: dict[str, Any], told: str) -> None:
    with pytest.raises(SimulateError) as fault:
        symdyn.gait(WALKER, **asked)
    assert told in str(fault.value)


def test_forces_in_time_ask_for_a_period() -> None:
    with pytest.raises(SimulateError, match="depend on time; give period"):
        symdyn.gait(symdyn.example("pendulum"), forces="tau1=cos(t)", section="q1", start="q1=0.1")


def test_an_impact_that_only_touches_has_no_derivative() -> None:
    scene = read_text((DATA / "scenes" / "ball.toml").read_text().replace("start = 1", "start = 1\nstart_rates = 0"))
    with pytest.raises(SimulateError, match="closed at the start"):
        symdyn.sensitivity(scene, until=1, start={"z": 0}, start_rates={"z_dot": 0})


def test_the_shell_tells_the_same(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["gait", str(WALKER), "--section", "strikes foot_a", "--swap", "a=b"]
    assert main([*words, "-o", str(tmp_path / "step.csv")]) == 0
    shown = capsys.readouterr().out
    assert "stable, period 3.88" in shown
    assert "multiplier -0.19" in shown
    assert (tmp_path / "step.csv").read_text().startswith("t,x,z,a,b,")
    assert main([*words, "--over", "slope=[0.009,0.012]", "--json"]) == 0
    table = json.loads(capsys.readouterr().out)["result"]
    assert [one["slope"] for one in table] == [0.009, 0.012]
    assert all(one["stable"] for one in table)


@pytest.mark.parametrize(
    ("scene", "option"), [("units/unlike.toml", "--no-units"), ("options/no_body.toml", "--allow-invalid-inertia")]
)
def test_scenes_with_faults_are_read_where_one_asks_for_it(scene: str, option: str) -> None:
    words = ["gait", str(DATA.parent / scene), "--period", "1", "--start", "theta=pi"]
    assert [main(words), main([*words, option])] == [1, 0]
