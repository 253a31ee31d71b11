"""States of one's own and signals: a pendulum on a motor with a coil, whose current is a state.

A second formulation writes the current as the velocity of a mass L on a rail of its own, as had to be done before.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from placeless import placeless
from scipy.integrate import solve_ivp

import symdyn
from symdyn.emit.print import printed_text
from symdyn.errors import DerivationError, LinearizeError, SceneError, TeachError
from symdyn.linear import linearize_at_rest
from symdyn.scene import Scene, body, input_signal, parse, read_text, revolute, scene, signal, state
from symdyn.scene.toml import write_text
from symdyn.scene.values.letters import Reset
from symdyn.teach import Handout, walkthrough

ROOT = Path(__file__).parent.parent

MOTOR = """
name = "motor"
gravity = [0, -9.81, 0]
[parameters]
m = { value = 0.5, unit = "kg" }
l = { value = 0.3, unit = "m" }
R = { value = 1.2, unit = "ohm" }
L = { value = 10, unit = "mH" }
k = { value = 0.08, unit = "N m/A" }
b = { value = 0.002, unit = "N m s" }
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
force = "torque - b*theta_dot"
[inputs.u]
unit = "V"
[states.i]
rate = "(u - drop)/L"
start = 0.1
unit = "A"
text = "current"
[signals]
drop = "R*i + back"
back = { formula = "k*theta_dot", unit = "V" }
torque = "k*i"
[outputs.power]
formula = "u*i - torque*theta_dot"
"""

PUSH = "u=2*cos(3*t)"


@pytest.fixture(scope="module")
def motor() -> Scene:
    return read_text(MOTOR, "motor.toml")


def by_hand(t: float, x: Any, u: float | None = None, R: float = 1.2) -> list[float]:
    theta, w, i = x
    turn = 0.08 * i - 0.002 * w - 0.5 * 9.81 * 0.3 * np.sin(theta)
    return [w, turn / (0.5 * 0.3**2), ((2 * np.cos(3 * t) if u is None else u) - R * i - 0.08 * w) / 0.01]


# Scenes


def test_what_is_written_is_read_again(motor: Scene) -> None:
    text = write_text(motor).text
    assert read_text(text, "motor.toml") == motor
    assert 'rate = "(u - (R*i + k*theta_dot))/L"' in text


def test_python_declares_the_same(motor: Scene) -> None:
    made = scene(
        "motor",
        parameters={"m": "0.5 kg", "l": "0.3 m", "R": "1.2 ohm", "L": "10 mH", "k": "0.08 N m/A", "b": "0.002 N m s"},
        gravity=[0, -9.81, 0],
        bodies=[body("bob", mass="m", com=[0, "-l", 0])],
        joints=[
            revolute("hinge", "ground", "bob", axis=[0, 0, 1], coordinate="theta", drive=False,
                     force="torque - b*theta_dot"),
        ],
        inputs=[input_signal("u", unit="V")],
        states=[state("i", "(u - drop)/L", start=0.1, unit="A", text="current")],
        signals=[signal("drop", "R*i + back"), signal("back", "k*theta_dot", unit="V"), signal("torque", "k*i")],
        outputs={"power": "u*i - torque*theta_dot"},
    )  # fmt: skip
    assert (made.states, made.signals, made.joints) == (motor.states, motor.signals, motor.joints)


LOOP = "which follows from forces: an algebraic loop; use coordinates, velocities, states, inputs, t"


@pytest.mark.parametrize(
    ("there", "wrong", "told"),
    [
        ("(u - drop)/L", "theta_ddot/L", f"states.i: rate = theta_ddot/L uses theta_ddot, {LOOP}"),
        ('"k*i"', '"reaction_hinge_mz"', f"signals.torque: formula = reaction_hinge_mz uses reaction_hinge_mz, {LOOP}"),
        (
            '"R*i + back"',
            '"R*i + back + drop"',
            "signals.drop: formula = R*i + back + drop depends on itself: drop -> drop; make one of them a state, or "
            "solve it by hand",
        ),
        (
            'formula = "k*theta_dot"',
            'formula = "torque + drop"',
            "signals.back: formula = torque + drop depends on itself: drop -> back -> drop; make one of them a state, "
            "or solve it by hand",
        ),
        (
            "(u - drop)/L",
            "u - drop",
            "states.i: rate = u - (R*i + k*theta_dot) is in V, and A/s is asked for; correct it, write the factor that "
            'is left out as a parameter with its unit, or write units = "none" at the top',
        ),
        (
            'mass = "m"',
            'mass = "m*i"',
            "bodies.bob: mass or inertia changes with i, and nothing tells what leaves or arrives; write [flows.jet] "
            'with body = "bob", velocity = [0, 0, 0]',
        ),
        (
            "(u - drop)/L",
            "(u - drop)/(L - L)",
            "states.i: rate = (u - (R*i + k*theta_dot))/(L - L) divides by zero; check the denominator",
        ),
        ("start = 0.1", 'start = "0.1 V"', 'states.i: start = "0.1 V" is in V, and A is asked for'),
        (
            'unit = "A"',
            'unit = "mA"',
            'states.i: unit = "mA" is of numbers that are not in SI, and what is computed is; write "A"',
        ),
        (
            "start = 0.1",
            "reset = { to = 0 }",
            'states.i: reset: when is missing; write a formula that passes zero, such as when = "s - 1"',
        ),
        ("[signals]", "[signals]\nu = 2", 'signals.u: "u" is already the name of inputs.u; choose another name'),
    ],
)
def test_a_fault_is_told_where_it_is(there: str, wrong: str, told: str) -> None:
    assert there in MOTOR
    with pytest.raises(SceneError) as fault:
        read_text(MOTOR.replace(there, wrong, 1), "motor.toml")
    assert f"motor.toml: {told}" in placeless(fault.value).splitlines()


# Equations


def test_rates_stand_below_the_equations(motor: Scene) -> None:
    found = symdyn.equations(motor)
    assert found.text().splitlines()[1] == "i_dot = (u - R*i - k*theta_dot)/L"
    assert r"\dot i &= \frac{u - R i - k \dot{\theta}}{L}" in found.latex()
    x, f = found.sympy().state_space()
    assert [str(one) for one in x] == ["theta", "theta_dot", "i"]
    assert str(f[2]) == "(-R*i - k*theta_dot + u)/L"
    point: Any = np.array([0.3, 1, 0.5])
    np.testing.assert_allclose(found.lambdify({"u": 2})(0, point), np.array(by_hand(0, point, 2)))


def test_a_reset_that_never_comes_is_a_fault() -> None:
    text = 'name = "clock"\n[states.s]\nrate = 1\nreset = { when = 1, to = 0 }\n'
    with pytest.raises(SceneError, match=r"states\.s: reset: when = 1 never passes zero; write a formula that does"):
        read_text(text)


@pytest.mark.runs("cc")
@pytest.mark.parametrize("target", ["numpy", "c"])
def test_functions_take_states_behind_inputs(motor: Scene, target: str) -> None:
    names = ("state_rates", "state_rates_by_states", "forward_dynamics_by_i", "state_rates_by_L")
    rates, slopes, by_i, by_L = symdyn.lambdify(motor, names, target=target)
    x, tau, u = np.array([0.3, 1.0, 0.5]), np.zeros(1), np.array([2.0])
    np.testing.assert_allclose(rates(x[:1], x[1:2], tau, u, x[2:]), by_hand(0, x, 2), rtol=1e-13)
    np.testing.assert_allclose(slopes(x[:1], x[1:2], tau), np.array([[0], [0.08 / 0.045], [-120]]), rtol=1e-13)
    np.testing.assert_allclose(by_i(x[:1], x[1:2], tau), [[0.08 / 0.045]], rtol=1e-13)
    np.testing.assert_allclose(by_L(x[:1], x[1:2], tau, u, x[2:])[2], -by_hand(0, x, 2)[2] / 0.01, rtol=1e-12)


@pytest.mark.usefixtures("numpy_alone")
def test_rates_are_proved(motor: Scene) -> None:
    names = [
        "state_rates",
        *(f"state_rates_{one}" for one in ("derivatives", "by_states", "jvp", "vjp", "hessian_vector")),
    ]
    assert symdyn.certify(motor, names).passed


def test_derivatives_of_rates_go_along_states_too(motor: Scene) -> None:
    scene = read_text('units = "none"' + MOTOR.replace('"(u - drop)/L"', '"(u - drop*i)/L"'))
    rates, jvp, vjp = symdyn.lambdify(scene, ("state_rates", "state_rates_jvp", "state_rates_vjp"))
    rng, h = np.random.default_rng(2), 1e-5
    q, qd, tau, i, u, dq, dqd, dtau, di = rng.uniform(-1, 1, (9, 1))
    ahead, behind = (rates(q + s * dq, qd + s * dqd, tau + s * dtau, u, i + s * di) for s in (h, -h))
    found = jvp(q, qd, tau, dq, dqd, dtau, di, i)
    np.testing.assert_allclose(found, (ahead - behind) / (2 * h), rtol=1e-8)
    weights = rng.uniform(-1, 1, 3)
    slopes = vjp(q, qd, tau, weights, i)
    np.testing.assert_allclose(slopes @ np.concatenate([dq, dqd, dtau, di]), weights @ found, rtol=1e-12)


# Runs


ENDS = ("theta", "theta_dot", "i")


@pytest.mark.heavy("gauss")
@pytest.mark.runs("cc")
@pytest.mark.parametrize("method", ["taylor", "dop853", "ida", "gauss"])
def test_a_run_is_that_of_equations_by_hand(motor: Scene, method: str) -> None:
    if not symdyn.simulation.METHODS[method].installed:
        pytest.skip(f"{method} is not installed")
    found = solve_ivp(by_hand, (0, 1), [0.4, 0, 0.1], "DOP853", rtol=1e-12, atol=1e-12)
    run = symdyn.simulate(motor, forces=PUSH, start="theta=0.4", until=1, method=method)
    np.testing.assert_allclose([run[name][-1] for name in ENDS], found.y[:, -1], atol=1e-6)
    assert run.monitors["energy"] < 1e-6  # what the current does is work
    power = run["u"] * run["i"] - 0.08 * run["i"] * run["theta_dot"]
    np.testing.assert_allclose(run["power"], power, atol=1e-12)


@pytest.mark.runs("cc")
def test_a_controller_sees_states(motor: Scene) -> None:
    lin = symdyn.linearize(motor, start="i=0")
    gains = lin.lqr()
    slow = symdyn.simulate(motor, feedback=gains, start="theta=0.01,i=0", until=1, method="dop853")
    K, (A, B) = gains.K, (lin.A, lin.B)
    linear = solve_ivp(lambda t, x: (A - B @ K) @ x, (0, 1), [0.01, 0, 0], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose([slow[name][-1] for name in ENDS], linear.y[:, -1], atol=2e-6)
    law = symdyn.simulate(motor, feedback=lambda t, q, u: -0.5 * u[1], until=0.1, method="dop853")
    np.testing.assert_allclose(law["u"], -0.5 * law["i"], atol=1e-12)
    held = symdyn.simulate(
        motor, feedback=symdyn.pid("i", "u", kp=3, ki=20, reference=0.5), until=1, method="radau",
    )  # fmt: skip
    np.testing.assert_allclose(held["i"][-1], 0.5, atol=2e-2)


def as_coordinate(name: str, drive: str, rate: str, force: str) -> tuple[Scene, Scene]:
    """Return an example with a coil, its current a state, and the velocity of a mass."""
    text = (ROOT / "examples" / f"{name}.toml").read_text(encoding="utf-8")
    own = f'[states.i]\nrate = "(12 - 3*i - 2*{rate})/0.5"\nstart = 0.2\n'
    coil = f"""
        [bodies.coil]
        mass = 0.5
        [joints.coil]
        type = "prismatic"
        parent = "ground"
        child = "coil"
        axis = [1, 0, 0]
        coordinate = "y"
        drive = false
        force = "12 - 2*{rate}"
        damping = 3
        start_rates = 0.2
    """
    scenes = (text.replace(drive, f"{drive}\n{force.format(i)}", 1) + more for i, more in (("i", own), ("y_dot", coil)))
    first, second = (read_text(one, f"{name}.toml") for one in scenes)
    return first, second


CASES: Mapping[str, tuple[str, str, str]] = {
    "four_bar": ('drive = "M"', "phi_dot", 'force = "2*{}"'),
    "heavy_top": ("drive = false", "point_wx", 'force = ["2*{}", 0, 0]'),
}


@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", CASES)
def test_a_state_is_what_the_velocity_of_a_mass_was(name: str) -> None:
    one, other = as_coordinate(name, *CASES[name])
    runs = [symdyn.simulate(some, until=0.2, method="dop853") for some in (one, other)]
    names = (*one.coordinates, *one.velocities)
    np.testing.assert_allclose(runs[0][names][-1], runs[1][names][-1], atol=1e-9)
    np.testing.assert_allclose(runs[0]["i"], runs[1]["y_dot"], atol=1e-9)
    lin, more = (symdyn.linearize(some, anywhere=True) for some in (one, other))
    kept = [more.states.names.index({"i": "y_dot"}.get(x, x)) for x in lin.states.names]
    np.testing.assert_allclose(lin.A, more.A[np.ix_(kept, kept)], atol=1e-12)
    np.testing.assert_allclose(lin.B, more.B[kept], atol=1e-12)
    found, second = (symdyn.sensitivity(some, until=0.2, parameters=()) for some in (one, other))
    rows, columns = (
        [names.index({"i": "y_dot"}.get(x, x)) for x in own]
        for own, names in ((found.rows, second.rows), (found.columns, second.columns))
    )
    np.testing.assert_allclose(found.matrix, second.matrix[np.ix_(rows, columns)], atol=1e-9)


@pytest.mark.runs("cc")
def test_a_rest_is_found_with_the_states_there(motor: Scene) -> None:
    scene = read_text(MOTOR.replace('[inputs.u]\nunit = "V"', "[inputs.u]\nvalue = 2\nunit = 'V'"))
    with pytest.raises(LinearizeError) as fault:
        symdyn.linearize(scene)
    i = 2 / 1.2
    theta = np.arcsin(0.08 * i / (0.5 * 9.81 * 0.3))
    near = re.search(r'start=\{"theta": ([\d.]+), "i": ([\d.]+)\}', str(fault.value))
    assert near is not None
    np.testing.assert_allclose([float(x) for x in near.groups()], [theta, i], rtol=1e-8)
    (down, up), _ = linearize_at_rest(scene)
    assert {round(float(one.point.q[0]), 6) for one in (down, up)} == {round(theta, 6), round(np.pi - theta, 6)}
    assert str(symdyn.linearize(motor, start="i=0").formulas.A[2, 2]) == "-R/L"


@pytest.mark.runs("cc")
@pytest.mark.parametrize("by", ["forward", "adjoint"])
def test_sensitivities_are_differences(motor: Scene, by: str) -> None:
    found = symdyn.sensitivity(motor, until=0.5, forces=PUSH, start="theta=0.4", parameters="R", by=by)
    h = 1e-5

    def end(i: float = 0.1, R: float = 1.2) -> Any:
        run = solve_ivp(lambda t, x: by_hand(t, x, R=R), (0, 0.5), [0.4, 0, i], "DOP853", rtol=1e-12, atol=1e-13)
        return run.y[:, -1]

    for name, slope in (("i", end(0.1 + h) - end(0.1 - h)), ("R", end(R=1.2 + h) - end(R=1.2 - h))):
        np.testing.assert_allclose([found[row, name] for row in ENDS], slope / (2 * h), atol=1e-8)


@pytest.mark.runs("cc")
def test_ensembles_vary_where_states_start(motor: Scene) -> None:
    found = symdyn.ensemble(motor, start={"i": np.array([0.0, 1.0])}, until=0.05, measures="end(i)")
    alone = symdyn.simulate(motor, start="i=1", until=0.05, rtol=1e-9)
    np.testing.assert_allclose(found["end(i)"][1], alone["i"][-1], atol=1e-8)


@pytest.mark.runs("cc")
def test_measures_take_signals_as_they_take_outputs() -> None:
    driven = symdyn.read("examples/states/dc_motor.toml")
    texts = ("end(missing)", "end(wanted - i)")
    found = symdyn.ensemble(driven, start={"theta": np.array([0.1, 0.2])}, until=0.05, measures=texts)
    np.testing.assert_array_equal(*(found[one] for one in texts))


def test_what_does_not_know_states_says_so(motor: Scene) -> None:
    told = "knows no states of one's own, and there is i; take them out"
    with pytest.raises(DerivationError, match=f"^motor: state_matrices {told}$"):
        symdyn.dynamics.derive(motor, ["state_matrices"])


def test_lessons_tell_rates_and_leave_out_what_holds_for_states_that_stay() -> None:
    scene = symdyn.example("dc_motor")
    lesson = walkthrough(scene)
    keys = [section.key for section in lesson.sections]
    (step,) = next(section.steps for section in lesson.sections if section.key == "states")

    assert [key for key in keys if key.startswith("after")] == ["after.rests"]  # of mechanism and states together
    assert len(step.blocks) == len(scene.states)
    assert "There are no sliders" not in Handout(scene).files(("html",), print)["dc_motor.html"]


def test_the_page_with_sliders_knows_no_resets(motor: Scene) -> None:
    scene = replace(motor, states=(replace(motor.states[0], reset=Reset(parse("i - 1"))),))
    with pytest.raises(TeachError, match=r"^motor: the page with sliders knows no resets, and there is i; take them"):
        Handout(scene).page()


@pytest.mark.parametrize("formulation", ["lagrange", "dalembert", "hamilton", "kane", "gibbs-appell"])
@pytest.mark.parametrize("format", ["latex", "text"])
def test_every_printed_formulation_has_the_rates(formulation: str, format: str) -> None:
    text = printed_text(symdyn.example("dc_motor"), format, formulation=formulation)
    assert "wanted - i" in text if format == "text" else r"\dot n &= \mathit{wanted} - i" in text
