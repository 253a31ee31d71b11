"""Examples with states of their own, against equations that are written here by hand and integrated by SciPy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import exp, sin, sqrt, tanh
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symdyn
from symdyn.scene import read_text

Rates = Callable[[float, Any], list[float]]


def dc_motor(t: float, x: Any) -> list[float]:
    theta, w, i, n = x
    voltage = 24 * tanh((2 * (5 - i) + 400 * n) / 24)
    turn = 0.08 * i - 0.002 * w - 0.5 * 9.81 * 0.3 * sin(theta)
    return [w, turn / (0.5 * 0.3**2), (voltage - 1.2 * i - 0.08 * w) / 0.004, 5 - i]


def servo(t: float, x: Any) -> list[float]:
    _, v, z = x
    raw = 12 * (1 - v) + z
    push = min(max(raw, -6.0), 6.0)
    return [v, (push - 0.8 * v) / 2, 40 * (1 - v) + (push - raw) / 0.1]


def lugre(t: float, x: Any) -> list[float]:
    x, v, z = x
    bending = v - 1e5 * abs(v) / (1 + 0.5 * exp(-((v / 0.001) ** 2))) * z
    return [v, 2 * (0.1 * t - x) - 1e5 * z - sqrt(1e5) * bending - 0.4 * v, bending]


def actuator(t: float, x: Any) -> list[float]:
    q, w, a = x
    return [w, (12 * a - 0.1 * w - 2 * 9.81 * 0.4 * sin(q)) / (0.03 + 2 * 0.4**2), (1 - a) / 0.05]


def muscle(t: float, x: Any) -> list[float]:
    q, w, a = x
    stretch = (0.2 - 0.04 * q) / 0.2 - 1
    pull = 800 * a * exp(-((stretch / 0.45) ** 2)) * (1 - tanh(0.04 * w / 1.6))
    turn = 0.04 * pull - 0.2 * w - 1.5 * 9.81 * 0.16 * sin(q)
    return [w, turn / (0.02 + 1.5 * 0.16**2), (0.3 - a) / 0.04]


def caster(t: float, x: Any) -> list[float]:
    psi, w, alpha = x
    return [w, (-0.15 * 3e4 * alpha - 20 * w) / 1.2, 12 / 0.6 * (psi - alpha) + 0.15 / 0.6 * w]


def cylinder(t: float, x: Any) -> list[float]:
    x, v, p1, p2 = x
    flow = [1.2e-4 * 0.3 * p / sqrt(1e7 * sqrt(p**2 + 1e8)) for p in (1e7 - p1, p2)]
    rates = [8e8 * (flow[0] - 8e-4 * v) / (2e-4 + 8e-4 * x), 8e8 * (8e-4 * v - flow[1]) / (2e-4 - 8e-4 * x)]
    return [v, (8e-4 * (p1 - p2) - 300 * v) / 50, *rates]


def pneumatic(t: float, x: Any) -> list[float]:
    """ISO 6358: C p ρ ψ, sonic below 0.3, 0.4 open; no pressure gets near that behind its port here."""
    x, v, p1, p2 = x

    def volume(above: float, below: float) -> float:
        over = max(below / above - 0.3, 0) / 0.7
        return 0.4 * 4e-8 * above * sqrt(1 - over**2)

    rates = (1e5 * volume(7e5, p1) - 8e-4 * p1 * v, 8e-4 * p2 * v - 1e5 * volume(p2, 1e5))
    return [
        v,
        (8e-4 * (p1 - p2) - 5e3 * x - 50 * v) / 5,
        1.2 * rates[0] / (3e-4 + 8e-4 * x),
        1.2 * rates[1] / (3e-4 - 8e-4 * x),
    ]


def dahl(t: float, x: Any) -> list[float]:
    _, v, F = x
    return [v, (15 * sin(10 * t) - F) / 2, 1e4 * (v - abs(v) * F / 10)]


def delay(t: float, x: Any) -> list[float]:
    """Padé's quotient as it is written: y = z - T z'/2 + T² z''/12 where u = z + T z'/2 + T² z''/12."""
    x, v, z, dz = x
    u, T = 20 * (0.5 - x) - 10 * v, 0.1
    ddz = (u - z - T * dz / 2) * 12 / T**2
    return [v, (z - T * dz / 2 + T**2 * ddz / 12) / 2, dz, ddz]


def warm_motor(t: float, x: Any) -> list[float]:
    _, w, warm, housing = x
    R = 0.8 * (1 + 0.0039 * warm)
    i = (12 - 0.09 * w) / R
    flow = (warm - housing) / 0.6
    turn = (0.09 * i - 3 * 9.81 * 0.02) / (4e-4 + 3 * 0.02**2)
    return [w, turn, (R * i**2 - flow) / 60, (flow - housing / 1.8) / 900]


def worm(t: float, x: Any) -> list[float]:
    phi, theta, w, v = x
    T = 2e4 * (phi / 30 - theta) + 40 * (w / 30 - v)
    return [w, v, (3.5 - T / 30 - abs(T / 30) * (1 / 0.7 - 1) * tanh(w / 0.5)) / 2e-4, (T - 60) / 0.05]


HAND: Mapping[str, tuple[Rates, list[float], float]] = {
    "dc_motor": (dc_motor, [0, 0, 0, 0], 0.2),
    "servo": (servo, [0, 0, 0], 2.0),
    "lugre": (lugre, [0, 0, 0], 0.2),
    "actuator": (actuator, [0, 0, 0], 0.5),
    "muscle": (muscle, [0, 0, 0.05], 0.5),
    "caster": (caster, [0.01, 0, 0], 0.5),
    "cylinder": (cylinder, [0, 0, 5e6, 5e6], 0.05),
    "pneumatic": (pneumatic, [0, 0, 4e5, 4e5], 0.1),
    "dahl": (dahl, [0, 0, 0], 1.0),
    "delay": (delay, [0, 0, 0, 0], 1.0),
    "warm_motor": (warm_motor, [0, 0, 0, 0], 2.0),
    "worm": (worm, [0, -0.003, 0, 0], 0.1),
}


@pytest.mark.wide(3)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", HAND)
def test_an_example_runs_as_its_equations_by_hand(name: str) -> None:
    rates, start, until = HAND[name]
    scene = symdyn.example(name)
    method: Any = "LSODA" if name == "lugre" else "DOP853"
    found = solve_ivp(rates, (0, until), start, method, rtol=1e-11, atol=1e-12)
    run = symdyn.simulate(scene, until=until, rtol=1e-11, method="lsoda" if name == "lugre" else "dop853")
    names = (*scene.coordinates, *scene.velocities, *(one.name for one in scene.states))
    end = np.array([run[one][-1] for one in names])
    np.testing.assert_allclose(end, found.y[:, -1], rtol=2e-7, atol=2e-9)
    assert run.monitors["energy"] <= 1e-7 * run.monitors["energy_scale"] + 1e-9


def test_a_caster_shimmies_from_the_speed_on_that_routh_and_hurwitz_say() -> None:
    scene, (J, a, C, s, d) = symdyn.example("caster"), (1.2, 0.15, 3e4, 0.6, 20.0)

    def margin(V: float) -> float:  # of J p³ + (d + J V/s) p² + (d V + C a²)/s p + C a V/s
        return (d + J * V / s) * (d * V + C * a**2) / s - J * C * a * V / s

    critical = next(V for V in np.linspace(0.1, 200, 20000) if margin(V) < 0)
    for V, stable in ((critical - 0.1, True), (critical + 0.1, False)):
        system = symdyn.linearize(scene, start={"psi": 0}, values={"V": V})
        assert (system.poles.real.max() < 0) == stable
        expected = np.roots([J, d + J * V / s, (d * V + C * a**2) / s, C * a * V / s])
        np.testing.assert_allclose(np.sort_complex(system.poles), np.sort_complex(expected), rtol=1e-9)


@pytest.mark.runs("cc")
def test_a_piston_rests_where_the_spring_holds_what_the_supply_pushes() -> None:
    run = symdyn.simulate(symdyn.example("pneumatic"), until=1, forces={"y": -1}, method="lsoda", rtol=1e-5)
    assert run["x"][-1] == pytest.approx(-8e-4 * (7e5 - 1e5) / 5e3, rel=1e-3)


@pytest.mark.runs("cc")
def test_friction_follows_dahl_s_loop() -> None:
    """F = ±Fc + (F₀ ∓ Fc) exp(∓s (x - x₀)/Fc) from where the block turned, whatever the time that it takes."""
    run = symdyn.simulate(symdyn.example("dahl"), until=1.0, every=1e-3, method="dop853", rtol=1e-12)
    x, v, F = (run[name] for name in ("x", "x_dot", "F"))
    turns = [0, *(k for k in range(1, len(v)) if v[k - 1] * v[k] < 0)]
    assert len(turns) > 3
    for k, end in zip(turns, [*turns[1:], len(x)], strict=True):
        way = np.sign(v[k + 1])
        closed = 10 * way + (F[k] - 10 * way) * np.exp(-1e3 * way * (x[k:end] - x[k]))
        np.testing.assert_allclose(F[k:end], closed, atol=1e-6)


@pytest.mark.parametrize("n", [1.0, 1.4])
def test_air_in_a_shut_cylinder_is_a_spring(n: float) -> None:
    """2 n p A²/V: its stiffness, air on both sides of a piston in the middle."""
    poles = symdyn.linearize(symdyn.example("pneumatic"), values={"n": n, "c": 0}, forces={"y": 0}, anywhere=True).poles
    omega = sqrt((5e3 + 2 * n * 4e5 * 8e-4**2 / 3e-4) / 5)
    np.testing.assert_allclose(np.sort(poles.imag), [-omega, 0, 0, omega], rtol=1e-9, atol=1e-9)


def test_a_delay_has_the_poles_of_pade_s_quotient() -> None:
    m, kp, kd, T = 2, 20, 10, 0.1
    above, below = [T**2 / 12, -T / 2, 1], [T**2 / 12, T / 2, 1]
    expected = np.roots(np.polyadd(np.polymul([m, 0, 0], below), np.polymul([kd, kp], above)))
    found = symdyn.linearize(symdyn.example("delay"), start={"x": 0.5}).poles

    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected), rtol=1e-9)
    late = np.polyval(above, 5j) / np.polyval(below, 5j)  # half a radian late, to the fifth order
    assert abs(late - np.exp(-0.5j)) < 0.5**5 / 700


@pytest.mark.runs("cc")
def test_an_actuator_follows_as_that_of_mujoco_does() -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string("""
    <mujoco><compiler angle="radian"/><option timestep="2e-4" integrator="RK4" gravity="0 0 -9.81"/>
      <worldbody><body><joint name="hinge" type="hinge" axis="0 1 0" damping="0.1"/>
        <inertial pos="0 0 -0.4" mass="2" diaginertia="0.03 0.03 0.001"/></body></worldbody>
      <actuator><general joint="hinge" dyntype="filter" dynprm="0.05" gainprm="12"/></actuator>
    </mujoco>""")
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.0
    for _ in range(2500):
        mujoco.mj_step(model, data)
    run = symdyn.simulate(symdyn.example("actuator"), until=0.5, method="dop853")
    np.testing.assert_allclose(run["q"][-1], data.qpos[0], atol=1e-9)
    np.testing.assert_allclose(run["act"][-1], data.act[0], atol=1e-9)


STORED = {  # MuJoCo's actuators with a state of their own, and the same as a scene says it
    "dcmotor": (
        '<dcmotor joint="hinge" motorconst="0.08" resistance="1.2" inductance="0.01"/>',
        "(u - 1.2*s - 0.08*q_dot)/0.01",
        "0.08*s",
    ),
    "muscle": (
        '<general joint="hinge" dyntype="muscle" dynprm="0.01 0.04 0" gainprm="12"/>',
        "if(u > s, (u - s)/(0.01*(0.5 + 1.5*s)), (u - s)*(0.5 + 1.5*s)/0.04)",
        "12*s",
    ),
}


@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", STORED)
def test_rates_of_actuators_are_those_of_mujoco(name: str) -> None:
    """At random states: a motor's current acts there as it is at the end of a step, which is short."""
    mujoco = pytest.importorskip("mujoco")
    actuator, rate, force = STORED[name]
    model = mujoco.MjModel.from_xml_string(f"""
    <mujoco><compiler angle="radian"/><option timestep="1e-13" gravity="0 0 -9.81"/>
      <worldbody><body><joint name="hinge" type="hinge" axis="0 1 0" damping="0.1"/>
        <inertial pos="0 0 -0.4" mass="2" diaginertia="0.03 0.03 0.001"/></body></worldbody>
      <actuator>{actuator}</actuator></mujoco>""")
    scene = read_text(f"""
name = "arm"
units = "none"
gravity = [0, 0, -9.81]
[inputs.u]
[states.s]
rate = "{rate}"
[bodies.arm]
mass = 2
com = [0, 0, -0.4]
inertia = [0.03, 0.03, 0.001]
inertia_about = "com"
[joints.hinge]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 1, 0]
coordinate = "q"
drive = false
force = "{force}"
damping = 0.1
""")
    rates, data = symdyn.load(scene, ["state_rates"]).state_rates, mujoco.MjData(model)
    for q, qd, s, u in np.random.default_rng(5).uniform(0, 1, (20, 4)):
        data.qpos[0], data.qvel[0], data.act[0], data.ctrl[0] = q, qd, s, u
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(rates([q], [qd], [0], [u], [s]), [qd, data.qacc[0], data.act_dot[0]], rtol=1e-9)


MANUTEC = """
name = "manutec_axis"
units = "none"
[parameters]
n = 210
c = 8
d = 0.01
J = 0.0013
k = 1.1616
w = 5500
D = 0.6
kp = 5
ks = 0.5
Ts = 0.05
[signals]
speed = "10*min(t, 0.3)"
angle = "if(t < 0.3, 5*t**2, 0.45 + 3*(t - 0.3))"
miss = "n*speed + kp*(n*angle - motor) - motor_dot"
wanted = "ks*(x + miss)"
torque = "c*(n*load - motor) + d*(n*load_dot - motor_dot)"
[states.x]
rate = "miss/Ts"
[states.v]
rate = "(i - wanted)*w/(0.04*D)"
[states.i]
rate = "(-5*v - 250*i - k*motor_dot)*2*D*w/250"
[bodies.rotor]
mass = 1
inertia = ["J", "J", "J"]
[bodies.arm]
mass = 1
inertia = [19.5, 19.5, 19.5]
[joints.motor]
type = "revolute"
parent = "ground"
child = "rotor"
axis = [1, 0, 0]
coordinate = "motor"
drive = false
force = "k*i + torque - motor_dot/1300"
friction = { coulomb = 0.5, smoothing = 0 }
[joints.load]
type = "revolute"
parent = "ground"
child = "arm"
axis = [1, 0, 0]
coordinate = "load"
drive = false
force = "-n*torque"
"""
"""The second axis of the Manutec r3 with a load, as Otter (1995) has it: P-PI servo, current loop of operational
amplifiers, motor, bearing with Coulomb friction, elastic gear."""

PUBLISHED = """
0.00032 0.0021515476770808 0 0 -10.332140401658 0.0971096205819714
0.00064 0.00861077583707569 0 0 -29.5258758817557 0.416236157005563
0.00096 0.019284408106044 -4.99685395837094e-06 4.35350128547168e-11 -47.1565957665899 0.779962456166086
0.0064 0.488074027271519 -0.0176077030374979 6.20931523845722e-06 -145.906456037212 2.86156228836732
0.032 3.4529807669699 -0.180830333421991 0.00349533952693701 -226.480419203434 4.24329188582867
0.288 7.80373058449551 -0.115330947024325 0.413551504671269 -339.294838718794 3.97320632067059
0.304 7.63934259997888 -0.110184458861892 0.460942826748529 -241.262122085328 1.9101119466075
0.3072 7.36761873037733 -0.0890400362877511 0.470716158676927 -220.249578778731 1.46927952958281
"""
"""t, s; x; twist of the gear, rad; load, rad; v, V; i, A: Modelica Association, MAP-LIB_ReferenceResults,
Modelica.Mechanics.MultiBody.Examples.Systems.RobotR3.oneAxis, by Dymola."""


@pytest.mark.long
@pytest.mark.runs("cc")
def test_an_axis_of_the_manutec_r3_moves_as_published() -> None:
    """It sticks for 0.65 ms, slides, and at 0.3 s the path bends: the reference has about seven digits."""
    table = np.array([[float(x) for x in line.split()] for line in PUBLISHED.split("\n") if line])
    run = symdyn.simulate(read_text(MANUTEC), until=0.3072, every=0.00032, rtol=1e-10, method="dop853")
    found = run(table[:, 0])[["x", "motor", "load", "v", "i"]]
    found[:, 1] = 210 * found[:, 2] - found[:, 1]
    assert np.all(np.abs(found - table[:, 1:]) <= [1e-7, 1e-8, 1e-10, 5e-5, 2e-6])
    assert abs(found[1, 1]) < 1e-20  # it sticks


@pytest.mark.runs("cc")
def test_the_motor_of_the_tutorials_of_system_identification_answers_a_step_in_closed_form() -> None:
    """IDNLGREY's DC motor, ẋ1 = x2, ẋ2 = (k u - x2)/τ: states alone beside a cart that nothing moves."""
    scene = read_text("""
name = "step"
units = "none"
[inputs.u]
[parameters]
tau = 1
k = 0.28
[states.angle]
rate = "speed"
[states.speed]
rate = "(k*u - speed)/tau"
[bodies.cart]
mass = 1
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "q"
""")
    run = symdyn.simulate(scene, until=3, forces={"u": 10}, rtol=1e-11)
    t = run.t
    np.testing.assert_allclose(run["angle"], 2.8 * (t - 1 + np.exp(-t)), atol=1e-9)
    lin = symdyn.linearize(scene, outputs=["angle"])
    np.testing.assert_allclose(np.sort(lin.poles.real), [-1, 0, 0, 0], atol=1e-12)
