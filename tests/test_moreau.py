"""Moreau's time stepping: its order beside runs by events, percussions, energy, and what it refuses in words."""

from __future__ import annotations

from functools import cache
from math import cos
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contact_scenes import BELT, ROD

import symdyn
from symdyn.errors import MethodError, SimulateError
from symdyn.scene import read_text
from symdyn.simulation import Trajectory

pytestmark = pytest.mark.runs("cc")

SCENES = Path(__file__).parent / "data" / "impacts" / "scenes"

BALL = (SCENES / "ball.toml").read_text(encoding="utf-8")


@cache
def scene(name: str, restitution: str = "") -> symdyn.Scene:
    text = (SCENES / f"{name}.toml").read_text(encoding="utf-8")
    return read_text(text.replace('"0.8"', f'"{restitution}"') if restitution else text)


def stepped(which: symdyn.Scene, step: float, **asked: Any) -> Trajectory:
    return symdyn.simulate(which, method=f"moreau:{step}", **asked)


@pytest.mark.parametrize(
    ("which", "height", "weight", "told"),
    [(scene("ball", "0.5"), "z", 9.81, "z"), (scene("brick"), "y", 9.81 * cos(0.3), "x")],
    ids=["a ball bounces", "a brick thrown on an incline"],
)
def test_half_the_step_is_half_the_error(which: symdyn.Scene, height: str, weight: float, told: str) -> None:
    """Of impacts at four places within a step, root mean square; the run by events is exact."""
    errors = []
    for step in (5e-3, 2.5e-3):
        off = []
        for part in np.arange(4) / 4 + 1 / 8:
            start = {height: weight * (0.4 + part * step) ** 2 / 2}
            exact = symdyn.simulate(which, until=0.6, every=0.3, start=start, method="dop853")
            off.append(stepped(which, step, until=0.6, every=0.3, start=start)[told][-1] - exact[told][-1])
        errors.append(np.sqrt(np.mean(np.square(off))))
    assert errors[1] > 1e-4
    assert 0.9 < np.log2(errors[0] / errors[1]) < 1.1


def test_a_ball_comes_to_rest_after_flights_without_end() -> None:
    run = stepped(scene("ball", "0.5"), 5e-3, until=3)
    assert run.complete
    assert not run.impacts
    assert run["z_dot"][-1] == pytest.approx(0.0, abs=1e-14)
    assert run["normal_floor"][-1] == pytest.approx(9.81, rel=1e-12)  # percussion over step
    assert run["normal_floor"].max() > 300  # an impact in one step
    assert run["mode_floor"][-1] == 1.0
    assert 0 < run.monitors["penetration floor"] < 5e-3 * 5
    energy = run["kinetic_energy"] + run["potential_energy"]
    assert np.diff(energy).max() < (5e-3 * 9.81) ** 2  # what leaves below the plane is held back
    assert energy[-1] < 0
    assert run.monitors["energy"] < 1e-12 * energy[0]  # of a constant mass the steps themselves change nothing


def test_a_brick_on_an_incline_stops_where_the_run_by_events_does() -> None:
    exact = symdyn.simulate(scene("brick"), until=2, method="dop853")
    run = stepped(scene("brick"), 1e-2, until=2)
    assert np.abs(run["x"] - exact["x"]).max() < 1e-5
    assert run["x_dot"][-1] == 0.0
    for name in ("normal_plane", "friction_plane"):
        assert run[name][-1] == pytest.approx(exact[name][-1], rel=1e-12)
    assert [run["mode_plane"][k] for k in (0, 20, -1)] == [2.0, 2.0, 1.0]
    assert run.monitors["contact_laws plane"] < 1e-14


BOWL = """
gravity = [0, 0, -9.81]
[bodies.ball]
mass = 2
inertia = [0.02, 0.02, 0.02]
[joints.free]
type = "free"
parent = "ground"
child = "ball"
start = [0, 0, "0.3", 1, 0, 0, 0]
start_rates = [1, 0, 0, 2, "0.5", 0]
[contacts.floor]
type = "ball"
body = "ball"
radius = 0.1
friction = 0.2
restitution = 0.3
"""

STOP = """
[bodies.a]
mass = 1
inertia = [1, 1, 1]
[bodies.b]
mass = 1
inertia = [1, 1, 2]
[joints.turn]
type = "revolute"
parent = "ground"
child = "a"
axis = [0, 0, 1]
start_rates = 10
[joints.clutch]
type = "revolute"
parent = "a"
child = "b"
axis = [0, 0, 1]
friction = { coulomb = 3 }
limits = { lower = -2, upper = 2, restitution = "0.5" }
"""


@pytest.mark.parametrize(
    ("which", "slope", "drift"),
    [(read_text(BOWL), 3, 10), (read_text(STOP), 10, 1e-12), (read_text(BELT), 0.3, 0.02)],
    ids=["in space", "dry friction and a stop", "a belt that holds more than it rubs"],
)
def test_runs_by_steps_come_to_runs_by_events(which: symdyn.Scene, slope: float, drift: float) -> None:
    """Errors and what the steps themselves change of the energy are below a constant times the step."""
    exact = symdyn.simulate(which, until=0.5, method="dop853")
    for step in (1e-2, 5e-3):
        run = stepped(which, step, until=0.5)
        assert np.abs(run.q - exact.q).max() < slope * step
        assert np.abs(run["energy_error"]).max() < drift * step
        assert np.diff(run["work"]).max(initial=0.0) < 1e-12 or which.prescribed_velocities
        assert max(value for name, value in run.monitors.items() if name.startswith("contact_laws")) < 1e-9
        modes = [name for name in run.extra if name.startswith("mode")]
        assert [run[name][-1] for name in modes] == [exact[name][-1] for name in modes]
    between = run(np.array([0.1234]))
    assert between.q == pytest.approx(exact(np.array([0.1234])).q, abs=slope * step)


@pytest.mark.parametrize(
    ("which", "asked", "words"),
    [
        (symdyn.example("pendulum"), {}, "there are no contacts"),
        (read_text(BALL + 'active = "z"\n'), {}, "floor may strike only where active"),
        (scene("ball"), {"stops": "z - 0.5"}, "it looks for no events"),
        (read_text(STOP), {"feedback": lambda t, q, u: [0.0, 0.0]}, "a controller or a function is at work"),
        (read_text(BALL + '[states.s]\nrate = "1"\n'), {}, "states of its own"),
    ],
)
def test_what_it_cannot_do_is_told(which: symdyn.Scene, asked: dict[str, Any], words: str) -> None:
    with pytest.raises(MethodError, match=words):
        stepped(which, 1e-3, until=0.1, **asked)


@pytest.mark.parametrize(
    ("method", "words"),
    [
        ("moreau:", "nothing is no length of a step"),
        ("moreau:-1", "-1 is no length of a step; give it in s, moreau:1e-3"),
        ("dop853:3", "method dop853:3 is not known; did you mean dop853"),
        ("moro:1", "did you mean moreau"),
    ],
)
def test_a_step_that_is_none_is_told(method: str, words: str) -> None:
    with pytest.raises(SimulateError, match=words):
        symdyn.simulate(scene("ball"), until=0.1, method=method)


def test_newtons_law_that_would_add_energy_ends_the_run() -> None:
    """A rod falls on its end with e = 0.9: slip turns round in the impact."""
    rod = read_text(ROD.replace('friction = "0.36"', 'friction = 1.2\nrestitution = "0.9"'))
    start, rates = {"x": 0, "y": 1.1, "theta": 0.936}, {"x_dot": -1.171, "y_dot": -2.682, "theta_dot": -2.803}
    with pytest.warns(RuntimeWarning, match="Newton's law of foot would add 0.25"):
        run = stepped(rod, 1e-3, until=0.5, start=start, start_rates=rates)
    assert run.t[-1] == pytest.approx(0.18, abs=5e-3)


def test_the_method_is_told_with_its_order_and_its_step() -> None:
    lines: list[str] = []
    stepped(scene("ball"), 0.01, until=0.1, rtol=1e-9, say=lines.append)
    assert lines[:2] == [
        "method: moreau:0.01 (time stepping), steps of 0.01 s at most, of first order: no events are located, "
        "impacts by Newton's law",
        "tolerances have no effect: moreau:0.01 has steps of one length",
    ]
