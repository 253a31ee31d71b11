"""Inverse dynamics over time with states of one's own, which are integrated beside the motion.

References are SciPy's integration of equations by hand, and runs whose motion is given back.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import symdyn
from symdyn.cli import main
from symdyn.errors import SimulateError
from symdyn.scene import Scene, read_text

pytestmark = pytest.mark.runs("cc")

EXAMPLES = Path(__file__).parent.parent / "examples"

MOTOR = """
name = "motor"
gravity = [0, -9.81, 0]
[inputs.V]
value = 1
unit = "V"
[states.i]
rate = "(V - 1.2*i - 0.08*theta_dot)/0.02"
start = 0.1
unit = "A"
[bodies.bob]
mass = 0.5
com = [0, -0.3, 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "theta"
drive = "tau"
damping = 0.002
force = "0.08*i"
"""

TIMES = np.linspace(0, 0.5, 21)


@pytest.fixture(scope="module")
def motor() -> Scene:
    return read_text(MOTOR.replace('name = "motor"', 'name = "motor"\nunits = "none"'), "motor.toml")


def speed(t: Any) -> Any:
    return 1.8 * np.sin(3 * t) * np.cos(3 * t)


VOLTAGES: dict[str, Callable[[Any, Any], Any]] = {  # what is given, and the voltage by hand
    "V=2*sin(5*t) - 0.3*i - 0.1*theta_dot": lambda t, i: 2 * np.sin(5 * t) - 0.3 * i - 0.1 * speed(t),
    "function": lambda t, i: np.cos(t) + speed(t),
}


@pytest.mark.parametrize("given", VOLTAGES)
def test_states_and_forces_are_those_by_hand(motor: Scene, given: str) -> None:
    forces: Any = {"V": lambda t, q, u: np.cos(t) + u[0]} if given == "function" else given
    run = symdyn.inverse(motor, "theta=0.3*sin(3*t)**2", TIMES, forces=forces)
    voltage = VOLTAGES[given]

    def rate(t: float, s: np.ndarray) -> list[Any]:
        return [(voltage(t, s[0]) - 1.2 * s[0] - 0.08 * speed(t)) / 0.02]

    by_hand = solve_ivp(rate, (0, 0.5), [0.1], method="Radau", t_eval=TIMES, rtol=1e-11, atol=1e-12).y[0]
    q, u, a = run["theta"], run["theta_dot"], 1.8 * 3 * np.cos(6 * TIMES)

    np.testing.assert_allclose(run["i"], by_hand, atol=2e-9)
    np.testing.assert_allclose(run["V"], voltage(TIMES, by_hand), atol=1e-9)
    taken = 0.045 * a + 0.5 * 9.81 * 0.3 * np.sin(q) + 0.002 * u - 0.08 * by_hand
    np.testing.assert_allclose(run["tau"], taken, atol=1e-9)
    assert run.names == ("t", "theta", "theta_dot", "theta_ddot", "tau", "V", "i", "drive_power")


def test_the_motion_of_a_run_takes_the_forces_of_the_run(motor: Scene) -> None:
    run = symdyn.simulate(motor, forces=["V=12*sin(4*t)", "tau=0.1*t"], until=0.5, every=0.005)
    back = symdyn.inverse(motor, run, run.t, forces="V=12*sin(4*t)")

    np.testing.assert_allclose(back["i"], run["i"], atol=1e-6)
    np.testing.assert_allclose(back["tau"], run["tau"], atol=2e-5)


def test_of_a_loop_states_see_what_follows() -> None:
    """The load of a state on the rocker is what drives take beside those without it; the state is SciPy's."""
    text = (EXAMPLES / "four_bar.toml").read_text()
    plain = read_text(text, "four_bar.toml")
    coordinates, drive = plain.coordinates, next(filter(None, plain.drives))
    first, last = coordinates[0], coordinates[-1]
    state = f'[states.s]\nrate = "{first}_dot*cos({last}) - 8*s"\nstart = 0.2\n[bodies.'
    scene = read_text(text.replace("[bodies.", state, 1), "four_bar.toml")
    motion, times = (
        f"{first}={float(symdyn.simulate(plain, until=0.1).q[0, 0])!r} + 0.3*sin(2*t)",
        np.linspace(0, 1, 21),
    )
    run, without = (symdyn.inverse(one, motion, times) for one in (scene, plain))
    fine = symdyn.inverse(plain, motion, np.linspace(0, 1, 201))
    pull = CubicSpline(fine.t, fine[f"{first}_dot"] * np.cos(fine[last]))
    by_hand = solve_ivp(lambda t, s: pull(t) - 8 * s, (0, 1), [0.2], t_eval=times, rtol=1e-10, atol=1e-10).y[0]

    np.testing.assert_allclose(run["s"], by_hand, atol=1e-6)
    np.testing.assert_allclose(run[drive], without[drive], atol=1e-9)
    np.testing.assert_allclose(run.q, without.q, atol=1e-9)


def test_a_state_jumps_where_the_motion_passes(motor: Scene) -> None:
    text = MOTOR.replace("[bodies.bob]", '[states.i.reset]\nwhen = "theta - 0.2"\nto = "0"\n[bodies.bob]')
    run = symdyn.inverse(read_text(text), "theta=t", TIMES)
    straight = symdyn.inverse(read_text(MOTOR), "theta=t", TIMES)
    level = (1 - 0.08) / 1.2

    before, after = TIMES < 0.19, TIMES > 0.21
    np.testing.assert_allclose(run["i"][before], straight["i"][before], atol=1e-8)
    np.testing.assert_allclose(run["i"][after], level * (1 - np.exp(-60 * (TIMES[after] - 0.2))), atol=1e-8)


def test_a_mass_that_burns_takes_its_thrust() -> None:
    rocket = read_text(
        """
name = "rocket"
gravity = [0, 0, -9.81]
[states.m]
rate = "-2"
start = 20
[bodies.hull]
mass = "m"
[joints.rail]
type = "prismatic"
parent = "ground"
child = "hull"
axis = [0, 0, 1]
coordinate = "z"
drive = "F"
[flows.gas]
body = "hull"
velocity = [0, 0, -300]
""".replace('name = "rocket"', 'name = "rocket"\nunits = "none"')
    )
    run = symdyn.inverse(rocket, "z=3*t**2", TIMES)

    np.testing.assert_allclose(run["m"], 20 - 2 * TIMES, rtol=1e-12)
    np.testing.assert_allclose(run["F"], (20 - 2 * TIMES) * (9.81 + 6) - 2 * 300, rtol=1e-10)


def test_a_passive_joint_says_what_its_state_does_not_give() -> None:
    passive = read_text(MOTOR.replace('drive = "tau"', "drive = false"))
    run = symdyn.inverse(passive, "theta=0", TIMES, forces="V=1.2*i")
    told = symdyn.inverse(passive, "theta=0.1", TIMES, forces="V=0").notes

    np.testing.assert_allclose(run["i"], 0.1, rtol=1e-9)
    assert told == (
        "theta has no drive, and the motion takes up to 0.147 N m there beside what i gives; for V that gives all of "
        "it ask collocation",
    )


def test_error_bars_are_those_of_the_states_too(motor: Scene) -> None:
    text = MOTOR.replace("[inputs.V]", "[parameters]\nR = { value = 1.2 }\n[inputs.V]").replace("1.2*i", "R*i")
    scene = read_text(text.replace("[parameters]", 'units = "none"\n[parameters]'), "motor.toml")
    found = symdyn.uncertainty(scene, {"R": 0.1}, motion="theta=t", times=[0, 0.1, 0.5], columns="tau")
    up, down = (symdyn.inverse(scene, "theta=t", found.run.t, values={"R": R})["tau"] for R in (1.2 + 1e-4, 1.2 - 1e-4))
    np.testing.assert_allclose(found["sd_tau"], np.abs(up - down) / 2e-4 * 0.1, atol=1e-6)


def test_a_shell_gives_states_and_inputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, motor: Scene) -> None:
    monkeypatch.chdir(tmp_path)
    Path("motor.toml").write_text(MOTOR, encoding="utf-8")
    words = ["--motion", "theta=0.1*t", "--start", "i=0.5", "--forces", "V=2 V", "--until", "1", "-o", "out.csv"]

    assert main(["inverse", "motor.toml", *words]) == 0
    assert Path("out.csv").read_text(encoding="utf-8").splitlines()[1].split(",")[6] == "0.5"


@pytest.mark.parametrize("times", [[0.5, 1], [0]])
def test_states_start_at_zero(times: list[float], motor: Scene) -> None:
    told = "times: states start at t = 0 and are integrated from there; give 0, and times behind it"
    with pytest.raises(SimulateError, match=f"^{re.escape(told)}$"):
        symdyn.inverse(motor, "theta=t", times)


def test_a_state_that_ends_says_when() -> None:
    scene = read_text(MOTOR.replace("(V - 1.2*i", "(V/sqrt(0.48 - theta) - 1.2*i"))
    with pytest.warns(RuntimeWarning, match="states: .*; the rows until then are kept"):
        run = symdyn.inverse(scene, "theta=t", TIMES)
    assert 0.4 < run.t[-1] < 0.5
    assert len(run["i"]) == len(run.t)
