"""States of one's own in identification: rates as rows beside driving forces, states and inputs as measured columns.

Logs are SciPy's integration of a pendulum on a motor by hand.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symdyn
from symdyn.cli import main
from symdyn.errors import IdentifyError, SimulateError
from symdyn.identification import identified, output_error
from symdyn.scene import read_text

pytestmark = pytest.mark.runs("cc")

TRUE = {"m": 0.5, "l": 0.3, "R": 1.2, "L": 0.01, "k": 0.08, "b": 0.002}

MOTOR = """
name = "motor"
gravity = [0, -9.81, 0]
[parameters]
m = { value = 0.6, unit = "kg" }
l = { value = 0.25, unit = "m" }
R = { value = 2, unit = "ohm" }
L = { value = 7, unit = "mH" }
k = { value = 0.05, unit = "N m/A" }
b = { value = 0.001, unit = "N m s" }
[inputs.u]
unit = "V"
[signals]
back = "k*theta_dot"
[states.i]
rate = "(u - R*i - back)/L"
unit = "A"
[bodies.bob]
mass = "m"
com = [0, "-l", 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "theta"
drive = false
force = "k*i - b*theta_dot"
"""


PLAIN = MOTOR.replace('name = "motor"', 'name = "motor"\nunits = "none"')


def voltage(t: Any) -> Any:
    return 6 * np.sin(3 * t) + 5 * np.sin(7.3 * t) + 3 * np.sin(1.1 * t + 1)


@pytest.fixture(scope="module")
def log() -> dict[str, Any]:
    m, length, R, L, k, b = TRUE.values()

    def rate(t: float, x: Any) -> list[Any]:
        torque = k * x[2] - b * x[1] - m * 9.81 * length * np.sin(x[0])
        return [x[1], torque / (m * length**2), (voltage(t) - R * x[2] - k * x[1]) / L]

    t = np.arange(0, 6, 0.0025)
    x = solve_ivp(rate, (0, 6), [0, 0, 0], method="LSODA", t_eval=t, rtol=1e-11, atol=1e-12).y
    return {"t": t, "theta": x[0], "u": voltage(t), "i": x[2]}


BASE = {"mxR1": 0, "myR1": -0.15, "JxxR1 + JyyR1": 0.045, "k": 0.08, "b": 0.002, "R": 1.2, "L": 0.01}

FORMS = ("(u - R*i - back)/L", "u/L - R*i/L - back/L", "-(R*i + back - u)/L")
"""Of one rate."""


@pytest.mark.parametrize("form", FORMS)
def test_parameters_of_forces_and_rates_are_found_together(log: dict[str, Any], form: str) -> None:
    found = symdyn.identify(read_text(MOTOR.replace("(u - R*i - back)/L", form)), log)

    assert found.names == tuple(BASE)
    assert found.units == ("kg m", "kg m", "kg m^2", "N m/A", "N m s", "ohm", "H")
    np.testing.assert_allclose(found.before[2:], [0.0375, 0.05, 0.001, 2, 0.007])
    np.testing.assert_allclose(found.after, list(BASE.values()), rtol=1e-5, atol=1e-8)
    assert [(one.drive, one.unit) for one in found.fits] == [("tau_theta", "N m"), ("rate of i", "H A/s")]


def test_noise_is_within_standard_errors(log: dict[str, Any]) -> None:
    random = np.random.default_rng(4)
    noisy = {
        name: log[name] + random.normal(size=len(log["t"])) * size
        for name, size in (("t", 0), ("theta", 1e-4), ("u", 1e-2), ("i", 1e-2))
    }
    found = symdyn.identify(read_text(MOTOR), noisy)

    assert np.all(np.abs(found.after - list(BASE.values())) < 4 * found.errors)
    assert np.all(found.errors[3:] < [1e-3, 1e-3, 1e-3, 1e-4])


def test_a_scene_takes_what_was_found(log: dict[str, Any]) -> None:
    found = identified(symdyn.identify(read_text(MOTOR), log))
    bodies = MOTOR.replace('mass = "m"\ncom = [0, "-l", 0]', "mass = 0.6\ncom = [0, -0.25, 0]")
    numbers = identified(symdyn.identify(read_text(re.sub(r"(?m)^[ml] = .*\n", "", bodies)), log))

    assert found.values == pytest.approx(TRUE, rel=1e-5)
    assert {name: numbers.values[name] for name in "RLkb"} == pytest.approx({n: TRUE[n] for n in "RLkb"}, rel=1e-5)
    assert [float(p.value.at({}) or 0) for p in found.scene.parameters if p.value] == pytest.approx(
        [*TRUE.values()], rel=1e-5
    )


def test_a_run_and_other_units_are_logs(log: dict[str, Any]) -> None:
    scene = read_text(MOTOR)
    run = symdyn.simulate(scene, forces="u=6*sin(3*t) + 5*sin(7.3*t)", until=3, every=0.0025)
    scaled = {**log, "i": 1000 * log["i"], "u": 1000 * log["u"]}

    np.testing.assert_allclose(symdyn.identify(scene, run)["L"], 0.007, rtol=1e-5)
    assert symdyn.identify(scene, scaled, units={"i": "mA", "u": "mV"})["L"] == pytest.approx(0.01, rel=1e-5)


def test_a_rate_without_a_factor_has_its_derivative_for_known(log: dict[str, Any]) -> None:
    """Of ṡ = a x - c s + t/10 with a known t/10, SciPy's s is measured."""
    t = log["t"]
    s = solve_ivp(lambda t, s: 2 * voltage(t) - 5 * s + t / 10, (0, 6), [0.5], t_eval=t, rtol=1e-10, atol=1e-11).y[0]
    more = 'a = 1\nc = 1\n[states.s]\nrate = "a*u - c*s + t/10"\n[inputs.u]'
    found = symdyn.identify(read_text(PLAIN.replace("[inputs.u]", more)), {**log, "s": s})

    assert (found["a"], found["c"]) == pytest.approx((2, 5), rel=1e-4)
    assert found["R"] == pytest.approx(1.2, rel=1e-5)


def test_a_shell_finds_them_too(
    log: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("motor.toml").write_text(MOTOR, encoding="utf-8")
    np.savetxt("log.csv", np.stack([*log.values()], axis=1), delimiter=",", header=",".join(log), comments="")

    assert main(["identify", "motor.toml", "log.csv", "-o", "found.toml"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"(?m)^ L +0\.007 +0\.01 ", said)
    assert re.search(r"(?m)^ rate of i +H A/s ", said)
    assert symdyn.simulate(symdyn.read("found.toml"), until=0.1).complete


SLOW = PLAIN.replace("value = 7, ", "value = 150, ").replace("value = 0.25", "value = 0.3").replace("0.6", "0.5")
"""With a coil that runs follow by few steps, and the pendulum of the log."""


def test_a_current_that_nobody_measured_is_fitted_too() -> None:
    """Of SciPy's angle alone: what the coil and its start were, by output error."""
    t = np.linspace(0, 1, 51)
    voltage = 6 * np.sin(5 * t)

    def rate(t: float, x: Any) -> list[Any]:
        torque = 0.08 * x[2] - 0.002 * x[1] - 0.15 * 9.81 * np.sin(x[0])
        return [x[1], torque / 0.045, (6 * np.sin(5 * t) - 1.2 * x[2] - 0.08 * x[1]) / 0.1]

    theta, _, i = solve_ivp(rate, (0, 1), [0, 0, 0.3], method="DOP853", t_eval=t, rtol=1e-11, atol=1e-12).y
    scene, log = read_text(SLOW.replace("value = 0.001", "value = 0.002")), {"t": t, "theta": theta, "u": voltage}
    found = output_error(scene, log, ["R", "L", "k"], start={"i": 0.2})
    both = output_error(scene, {**log, "i": i}, ["R", "L", "k"])

    assert found.names[-3:] == ("start theta", "start theta_dot", "start i")
    for one in (found, both):
        assert [one[name] for name in "RLk"] == pytest.approx([1.2, 0.1, 0.08], rel=2e-3)
        assert one["start i"] == pytest.approx(0.3, abs=2e-3)
    assert both.measured == ("theta", "i")


def test_output_error_refuses_jumps_and_names_what_is_measured(log: dict[str, Any]) -> None:
    told = "motor: output error knows no states that jump, and there is i; take the resets out"
    with pytest.raises(SimulateError, match=f"^{told}$"):
        output_error(read_text(JUMPS), log)
    with pytest.raises(SimulateError, match=r"^measured: j is no coordinate, velocity or state; known are theta, "):
        output_error(read_text(MOTOR), log, measured="j")


JUMPS = MOTOR.replace("[bodies.bob]", '[states.i.reset]\nwhen = "theta"\nto = "0"\n[bodies.bob]')
RATED = PLAIN.replace('unit = "V"', 'unit = "V"\nrates = 1').replace("- back)", "- back - 0.1*u_dot)")
ROTOR = PLAIN.replace("drive = false", 'drive = false\narmature = "b"').replace(' - b*theta_dot"', '"')


@pytest.mark.parametrize(
    ("text", "lacks", "told"),
    [
        (MOTOR, "i", "data: has no column i; motor needs t, theta, u, i, and it has t, theta, u"),
        (MOTOR, "u", "data: has no column u; motor needs t, theta, u, i, and it has t, theta, i"),
        (JUMPS, "", "motor: i: states that jump are not identified with; take the resets out, and give logs "
            "between jumps"),
        (RATED, "",
            "motor: u: inputs with rates are not identified with; bind numbers in place"),
        (ROTOR.replace("R*i - back", "R*i*b - back"), "",
            "motor: b: forces know it in JxxR1 + JyyR1 + b alone, and the rate of a state by itself; make it a number, "
            "or leave the others out"),
        (PLAIN.replace("R*i", "sin(R*i)").replace("value = 2, ", ""),
            "", "motor: R: without a value, and rates of states are not linear in it; give it one"),
    ],
)  # fmt: skip
def test_what_is_not_identified_with_says_so(log: dict[str, Any], text: str, lacks: str, told: str) -> None:
    given = {name: x for name, x in log.items() if name != lacks}
    given |= {"u_dot": log["u"]} if "u_dot" in text else {}
    with pytest.raises(IdentifyError, match=f"^{re.escape(told)}$"):
        symdyn.identify(read_text(text, "motor.toml"), given)
