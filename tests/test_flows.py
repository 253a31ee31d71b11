"""Matter that leaves or arrives: rockets, chains, belts, drops and wheels of water as the literature has them.

That the momentum of what is there and of what has left is conserved is summed up here, in numbers, from a motion alone.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from engine.balance import balance
from engine.mechanism import Mechanism
from numpy.testing import assert_allclose
from placeless import placeless
from scipy.integrate import cumulative_simpson, solve_ivp

import symdyn
import symdyn.scene as declared
from symdyn.errors import DerivationError, SceneError, SimulateError
from symdyn.scene import read_text, write_text as write_text_as
from symdyn.scene.toml import write_text
from symdyn.teach import walkthrough

pytestmark = pytest.mark.runs  # motions are compiled where there is a compiler

G, ROOT = 9.81, Path(__file__).parent.parent

ROCKET = """
name = "rocket"
[parameters]
c = { value = 10, unit = "kg/s" }
ve = { value = 2000, unit = "m/s" }
m0 = { value = 100, unit = "kg" }
[states.m]
rate = "-c"
start = "m0"
unit = "kg"
[bodies.rocket]
mass = "m"
[joints.rail]
type = "prismatic"
parent = "ground"
child = "rocket"
axis = [0, 0, 1]
coordinate = "z"
drive = false
[flows.jet]
body = "rocket"
velocity = [0, 0, "-ve"]
"""

CHAIN = """
name = "chain"
gravity = [0, 0, "-g"]
[parameters]
rho = { value = 0.7, unit = "kg/m" }
g = { value = 9.81, unit = "m/s^2" }
x0 = { value = 0.1, unit = "m" }
[states.m]
rate = "rho*x_dot"
start = "rho*x0"
unit = "kg"
[bodies.hanging]
mass = "m"
[joints.fall]
type = "prismatic"
parent = "ground"
child = "hanging"
axis = [0, 0, -1]
coordinate = "x"
drive = false
start = "x0"
[flows.heap]
body = "hanging"
velocity = [0, 0, 0]
frame = "ground"
"""

SLIDING = """
name = "sliding"
[parameters]
rho = { value = 0.7, unit = "kg/m" }
L = { value = 2, unit = "m" }
g = { value = 9.81, unit = "m/s^2" }
[bodies.chain]
mass = "rho*L"
[joints.edge]
type = "prismatic"
parent = "ground"
child = "chain"
axis = [1, 0, 0]
coordinate = "x"
drive = false
start = 0.1
force = "rho*x*g"
"""

WHEEL = """
name = "segner"
gravity = "none"
[parameters]
c = { value = 2, unit = "kg/s" }
u = { value = 5, unit = "m/s" }
r = { value = 0.5, unit = "m" }
J = { value = 0.8, unit = "kg m^2" }
[bodies.wheel]
mass = 3
inertia = ["J", "J", "J"]
inertia_about = "com"
[joints.axle]
type = "revolute"
parent = "ground"
child = "wheel"
axis = [0, 0, 1]
coordinate = "phi"
drive = false
[flows.hub]
body = "wheel"
at = [0, 0, 0]
rate = "c"
velocity = [0, 0, 0]
[flows.nozzle]
body = "wheel"
at = ["r", 0, 0]
velocity = [0, "-u", 0]
"""

DROP = """
name = "drop"
[parameters]
k = { value = 0.02, unit = "m/s" }
rho = { value = 1000, unit = "kg/m^3" }
[states.r]
rate = "k"
start = 0.01
unit = "m"
[bodies.drop]
mass = "4/3*pi*rho*r**3"
[joints.fall]
type = "prismatic"
parent = "ground"
child = "drop"
axis = [0, 0, -1]
coordinate = "y"
drive = false
[flows.mist]
body = "drop"
velocity = [0, 0, 0]
frame = "ground"
"""

BELT = """
name = "belt"
[parameters]
c = { value = 4, unit = "kg/s" }
[bodies.belt]
mass = 30
[joints.run]
type = "prismatic"
parent = "ground"
child = "belt"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
[flows.hopper]
body = "belt"
rate = "c"
velocity = [0, 0, 0]
frame = "ground"
[flows.end]
body = "belt"
velocity = [0, 0, 0]
"""

LINKS = """
name = "links"
[inputs.u]
unit = "m/s"
value = 3
[states.m]
rate = "-(1 + sin(a)/5)/3"
start = 3
unit = "kg"
[bodies.arm]
mass = 2
com = [0.3, 0.1, 0]
inertia = [0.1, 0.12, 0.13]
inertia_about = "com"
[bodies.tank]
mass = "m + 1"
com = [0.2, -0.1, 0.15]
inertia = { xx = "0.1*m", yy = "0.12*m + m**2/100", zz = "0.15", xy = "0.01*m" }
inertia_about = "com"
[joints.hinge]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 1, 0]
coordinate = "a"
[joints.elbow]
type = "revolute"
parent = "arm"
child = "tank"
axis = [0, 1, 1]
origin = [0.5, 0.1, 0]
coordinate = "b"
[flows.jet]
body = "tank"
at = [0.4, 0.3, -0.2]
velocity = ["u", 0.3, "0.1*a_dot"]
[flows.scoop]
body = "tank"
at = [-0.2, 0.1, 0]
rate = "0.05*u"
velocity = [0.1, "0.4*t", 0.2]
frame = "ground"
[flows.mist]
body = "arm"
rate = 0.2
velocity = [0, 0, 0]
frame = "ground"
[flows.drip]
body = "arm"
velocity = [0, 0, 0]
"""

TANK = """
name = "tank"
gravity = "none"
[states.m]
rate = "-3/10*(1 + a**2)"
start = 3
unit = "kg"
[states.a]
rate = "1 - a"
[bodies.tank]
mass = "m + 1"
com = [0.2, -0.1, 0.15]
inertia = { xx = "0.1*m", yy = "0.12*m + m**2/100", zz = "0.15", xy = "0.01*m" }
inertia_about = "com"
[joints.free]
type = "free"
parent = "ground"
child = "tank"
start_rates = [0.1, 0.2, -0.1, 0.5, -0.3, 0.9]
[flows.jet]
body = "tank"
at = [0.4, 0.3, -0.2]
velocity = [2, 0.3, -1]
[flows.scoop]
body = "tank"
at = [-0.2, 0.1, 0]
rate = 0.15
velocity = [0.1, 0.4, 0.2]
frame = "ground"
"""

STEADY = (
    TANK.replace("m + 1", "4").replace("0.1*m", "0.3").replace("0.12*m + m**2/100", "0.4").replace("0.01*m", "0.02")
)
STEADY = "\n[bodies".join([STEADY.split("\n[states")[0], STEADY.split("\n[bodies")[1]])
"""The same tank, which takes in as much as it loses."""


def told(text: str) -> str:
    return str(symdyn.equations(read_text(text)).text()).strip()


# What the literature says


def test_a_rocket_is_as_fast_as_tsiolkovsky_says() -> None:
    """v = ve ln(m0 / m) - g t; Tsiolkovsky (1903)."""
    run = symdyn.simulate(read_text(ROCKET), until=8.0)

    assert told(ROCKET) == "m*z_ddot + 9.81*m = c*ve\nm_dot = -c"
    assert_allclose(run.qd[:, 0], 2000 * np.log(100 / (100 - 10 * run.t)) - G * run.t, atol=1e-8)
    assert run.monitors["energy"] < 1e-11 * run.monitors["energy_scale"]
    total = run["kinetic_energy"] + run["potential_energy"]
    thrust, left = 20000 * run.qd[:, 0], -10 * (run.qd[:, 0] ** 2 / 2 + G * run.q[:, 0])
    assert_allclose(run["other_power"], thrust + left, rtol=1e-9, atol=1e-6)
    assert_allclose(np.gradient(total, run.t)[5:-5], (thrust + left)[5:-5], rtol=1e-3)


def test_a_chain_that_is_picked_up_from_rest_falls_with_a_third_of_g() -> None:
    """v² = 2 g (x - x0³/x²) / 3: a third of g, and energy lost; Love, Theoretical Mechanics (1897); Wong (2006)."""
    run = symdyn.simulate(read_text(CHAIN), until=2.0)
    x, v = run.q[:, 0], run.qd[:, 0]

    assert told(CHAIN) == "m*x_ddot - g*m = -rho*x_dot**2\nm_dot = rho*x_dot"
    assert_allclose(v**2, 2 * G * (x - 0.1**3 / x**2) / 3, atol=1e-9)
    assert_allclose(run.qdd[-1], G / 3, rtol=1e-3)
    assert run.monitors["energy"] < 1e-10 * run.monitors["energy_scale"]


def test_a_chain_that_slides_as_a_whole_needs_no_flow_and_keeps_its_energy() -> None:
    """x = x0 cosh(√(g/L) t): all of the chain moves, so that its mass is constant."""
    run = symdyn.simulate(read_text(SLIDING), until=1.0)

    assert_allclose(run.q[:, 0], 0.1 * np.cosh(np.sqrt(G / 2) * run.t), atol=1e-9)


def test_a_drop_that_gathers_mist_by_its_surface_falls_with_a_quarter_of_g() -> None:
    """v = g (r - r0⁴/r³) / (4 k), r = r0 + k t; Krane, Am. J. Phys. 49 (1981) 113."""
    run = symdyn.simulate(read_text(DROP), until=20.0)
    r = 0.01 + 0.02 * run.t

    assert_allclose(run.qd[:, 0], G * (r - 0.01**4 / r**3) / 0.08, atol=1e-8)


def test_a_belt_takes_the_force_that_sand_needs_to_move_with_it() -> None:
    """F = ṁ v, twice the power that becomes kinetic energy of the sand; Feynman's and any textbook's conveyor."""
    belt = symdyn.load(read_text(BELT))

    assert_allclose(belt.inverse_dynamics([0.3], [1.5], [0.0]), [4 * 1.5])
    assert told(BELT) == "30*x_ddot = F - c*x_dot"


def test_a_wheel_of_water_obeys_eulers_equation() -> None:
    """J φ̈ = c r (u - r φ̇), water entering at the hub; Segner's wheel, Euler (1754)."""
    run = symdyn.simulate(read_text(WHEEL), until=2.0)

    assert told(WHEEL) == "J*phi_ddot = c*u*r - c*r**2*phi_dot"
    assert_allclose(run.qd[:, 0], 10 * (1 - np.exp(-0.625 * run.t)), atol=1e-9)


def test_a_turn_of_a_rocket_is_damped_by_its_jet() -> None:
    """J ω̇ = -c (l² - κ²) ω, with J = m κ²; Thomson, Introduction to Space Dynamics (1961), section 7.5."""
    text = ROCKET.replace("prismatic", "revolute").replace('"m"', '"m"\ninertia = ["m*k2", "m*k2", 0]\n'
        'inertia_about = "com"').replace("axis = [0, 0, 1]", "axis = [1, 0, 0]\nstart_rates = 2")  # fmt: skip
    text = text.replace("m0 =", 'k2 = { value = 0.5, unit = "m^2" }\nm0 =').replace('"z"', '"z"\ndamping = 0')
    run = symdyn.simulate(read_text(text.replace("velocity", "at = [0, 0, -2]\nvelocity")), until=5.0)

    assert_allclose(run.qd[:, 0], 2 * ((100 - 10 * run.t) / 100) ** ((2**2 - 0.5) / 0.5), atol=1e-9)


# Balances


def test_momentum_of_what_is_there_and_of_what_left_is_conserved() -> None:
    """A free body, inside which matter flows from its centre of mass to its places: d/dt [p; L] is what passes."""
    run = symdyn.simulate(read_text(TANK), until=0.8, every=0.002, rtol=1e-12, atol=1e-12)
    c, places = np.array([0.2, -0.1, 0.15]), np.array([[0.4, 0.3, -0.2], [-0.2, 0.1, 0.0]])
    there, passed = [], []
    for q, u, m, a in zip(run.q, run.qd, run["m"], run["a"], strict=True):
        v, w = u[:3], u[3:]
        e, x = q[3], q[4:7]
        E = np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
        R = np.eye(3) + 2 * e * E + 2 * E @ E
        mu = np.array([-0.3 * (1 + a**2) - 0.15, 0.15])
        J = np.array([[0.1 * m, 0.01 * m, 0], [0.01 * m, 0.12 * m + m**2 / 100, 0], [0, 0, 0.15]])
        inside = -sum(k * (p - c) for k, p in zip(mu, places, strict=True))  # ∫ of the relative velocity
        centre, speed = q[:3] + R @ c, R @ (v + np.cross(w, c))
        p = (m + 1) * speed + R @ inside
        there.append([*p, *(np.cross(centre, p) + R @ J @ w)])
        exits = [R @ (v + np.cross(w, places[0]) + [2, 0.3, -1]), np.array([0.1, 0.4, 0.2])]
        through = [[*(k * s), *np.cross(q[:3] + R @ at, k * s)] for k, at, s in zip(mu, places, exits, strict=True)]
        unsteady = R @ (0.6 * a * (1 - a) * (places[0] - c))  # -d(inside)/dt, which steady flows leave out
        passed.append(np.sum(through, axis=0) + np.array([*unsteady, *np.cross(centre, unsteady)]))
    gained = cumulative_simpson(np.array(passed), x=run.t, axis=0, initial=0.0)

    assert_allclose(np.array(there) - there[0], gained, atol=2e-7)


def test_a_rocket_in_the_plane_moves_as_scipy_integrates_newtons_equations() -> None:
    text = ROCKET.replace("prismatic", "planar").replace('"z"\ndrive = false', "").replace("coordinate = ", "")
    planar = 'axis = [0, 0, 1]\ncoordinates = ["x", "y", "phi"]\ndrives = [false, false, false]'
    text = text.replace("axis = [0, 0, 1]", planar)
    text = text.replace('mass = "m"', 'mass = "m"\ninertia = [3, 3, 5]\ninertia_about = "com"')
    text = text.replace('velocity = [0, 0, "-ve"]', "at = [-1, 0.1, 0]\nvelocity = [-30, 0, 0]")
    text = text.replace('name = "rocket"', 'name = "rocket"\ngravity = [0, -9.81, 0]', 1)

    def rates(t: float, s: np.ndarray) -> list[float]:
        (phi, vx, vy, w), m = s[2:], 100 - 10 * t
        carried = w * np.array([-0.1, -1.0])  # ω × ρ with ρ = (-1, 0.1)
        ahead, aside = -10 * (np.array([-30.0, 0.0]) + 2 * carried)
        turn = -10 * (-1.0 * carried[1] - 0.1 * (carried[0] - 30))  # μ ρ × (u + ω × ρ)
        fx, fy = np.cos(phi) * ahead - np.sin(phi) * aside, np.sin(phi) * ahead + np.cos(phi) * aside
        return [vx, vy, w, fx / m, fy / m - G, turn / 5]

    run = symdyn.simulate(read_text(text), until=3.0)
    found = solve_ivp(rates, (0, 3), np.zeros(6), t_eval=run.t, rtol=1e-11, atol=1e-11)

    assert_allclose(run.q, found.y[:3].T, atol=1e-6)


def test_the_reference_of_the_tests_finds_the_same_forces() -> None:
    one = read_text(STEADY)
    rng = np.random.default_rng(1)
    q, u, du = rng.normal(size=7), rng.normal(size=6), rng.normal(size=6)
    q[3:] /= np.linalg.norm(q[3:])
    found = balance(Mechanism(one).at(q, u), du, np.full(6, np.nan))

    assert_allclose(symdyn.lambdify(one, "inverse_dynamics")(q, u, du), found.tau, rtol=1e-11)


def test_all_formulations_agree_on_bodies_that_hang_on_each_other(numpy_alone: None) -> None:
    """Lagrange, Kane, recursion; reactions by equilibria of every body; upright, stretched and at zero, too."""
    assert symdyn.certify(read_text(LINKS)).passed


def test_a_closed_loop_holds_matter_that_flows(numpy_alone: None) -> None:
    text = (ROOT / "examples" / "four_bar.toml").read_text()
    text = text.replace('"m2"', '"m2 + f"').replace('"m2*b**2/12"', '"(m2 + f)*b**2/12"')
    one = read_text(
        f'{text}\n[states.f]\nrate = "-1/2"\nstart = 2\nunit = "kg"\n[flows.leak]\nbody = "coupler"\n'
        'at = ["b/2", 0.1, 0]\nvelocity = [0.3, 0.2, 0]'
    )
    run = symdyn.simulate(one, until=1.0)

    assert run.monitors["energy"] < 1e-9 * run.monitors["energy_scale"]
    assert symdyn.certify(one, ["forward_dynamics", "multipliers", "reactions"]).passed


# Runs


def test_a_run_ends_where_a_mass_does() -> None:
    with pytest.warns(RuntimeWarning, match="lost its mass"):
        run = symdyn.simulate(read_text(ROCKET), until=12.0)

    assert run.stopped == "t = 9.99999 s: body rocket has lost its mass, m; let its flow end before"


@pytest.mark.parametrize(
    ("start", "told"),
    [
        ("0", "rocket: z_dot moves no mass at the start"),
        ("-1", "rocket: the mass matrix is singular at the start, a motion with z_dot moves no mass; give another "
               "start, or a mass or an inertia"),
    ],
)  # fmt: skip
def test_a_run_without_mass_does_not_begin(start: str, told: str) -> None:
    with pytest.raises(SimulateError) as refused:
        symdyn.simulate(read_text(ROCKET.replace('"m0"', start)), until=1.0)
    assert str(refused.value) == told


def test_a_stage_that_is_dropped_takes_its_energy_along() -> None:
    stage = 'unit = "kg"\nreset = { when = "m - 50", to = 30, way = "down" }\n[bodies'
    run = symdyn.simulate(read_text(ROCKET.replace('unit = "kg"\n[bodies', stage)), until=6.0)
    v = 2000 * (np.log(100 / 50) + np.log(30 / (30 - 10 * (run.t[-1] - 5)))) - G * run.t[-1]

    assert run.events[0].t == pytest.approx(5.0)
    assert run.qd[-1, 0] == pytest.approx(v, rel=1e-9)
    assert run.monitors["energy"] < 1e-10 * run.monitors["energy_scale"]


def test_no_momentum_is_called_conserved_that_leaves_with_matter() -> None:
    text = ROCKET.replace('name = "rocket"', 'name = "rocket"\ngravity = "none"', 1).replace('"-ve"', "0")
    run = symdyn.simulate(read_text(text.replace('"z"', '"z"\nstart_rates = 3')), until=1.0)

    assert_allclose(run.qd[:, 0], 3.0)
    assert "momenta" not in run.monitors


def test_derivatives_are_those_of_tsiolkovskys_formula() -> None:
    """∂v/∂m(0) = ve (1/m(0) - 1/m), ∂v/∂c = ve t/m, and of accelerations by mass -(thrust)/m²."""
    end = symdyn.sensitivity(read_text(ROCKET), until=8.0)
    one = symdyn.load(read_text(ROCKET), ["forward_dynamics_by_states", "forward_dynamics", "state_rates"])

    assert end["z_dot", "m"] == pytest.approx(2000 * (1 / 100 - 1 / 20), rel=1e-6)
    assert end["z_dot", "c"] == pytest.approx(2000 * 8 / 20, rel=1e-6)
    assert_allclose(one.forward_dynamics_by_states([0.0], [0.0], [0.0], [40.0]), [[-20000 / 40**2]])
    assert_allclose(one.state_rates([0.0], [3.0], [0.0], [40.0]), [3.0, 20000 / 40 - G, -10.0])


def test_a_sweep_varies_what_flows() -> None:
    runs = symdyn.sweep(read_text(ROCKET), over={"ve": [1000, 2000]}, measure="end(z_dot)", until=8.0)

    speeds = [ve * np.log(5) - 8 * G for ve in (1000, 2000)]
    assert_allclose(np.ravel(runs.measures["end(z_dot)"]), speeds, rtol=1e-8)


def test_a_rocket_that_hovers_is_linearized() -> None:
    """Thrust in balance with the weight: A has ∂z̈/∂m = -c ve/m² where its mass is held."""
    text = ROCKET.replace('"-c"', "0").replace('velocity = [0, 0, "-ve"]', 'at = [0, 0, 0]\nrate = "-c"\n'
        'velocity = [0, 0, "-ve"]\n[flows.feed]\nbody = "rocket"\nvelocity = [0, 0, 0]')  # fmt: skip
    one = symdyn.linearize(read_text(text), start={"m": 20000 / G})

    assert one.states.names == ("z", "z_dot", "m")
    assert one.A[1, 2] == pytest.approx(-(G**2) / 20000)


# Scenes


def test_what_is_written_is_read_again_and_python_declares_it() -> None:
    for text in (ROCKET, CHAIN, WHEEL, DROP, BELT, TANK, LINKS):
        one = read_text(text)
        assert read_text(write_text(one).text) == one
    made = declared.scene(
        "rocket",
        parameters={"c": "10 kg/s", "ve": "2000 m/s", "m0": "100 kg"},
        bodies=[declared.body("rocket", mass="m")],
        joints=[declared.prismatic("rail", "ground", "rocket", axis=[0, 0, 1], coordinate="z", drive=False)],
        states=[declared.state("m", "-c", start="m0", unit="kg")],
        flows=[declared.flow("jet", [0, 0, "-ve"], body="rocket")],
    )
    assert (made.elements, made.bodies, made.states) == (
        read_text(ROCKET).elements, read_text(ROCKET).bodies, read_text(ROCKET).states,
    )  # fmt: skip


RATE = "one of its flows has none, and takes what others leave of the rate of its mass"
CORRECT = (
    'correct it, write the factor that is left out as a parameter with its unit, or write units = "none" at the top'
)


@pytest.mark.parametrize(
    ("there", "wrong", "told"),
    [
        ('[0, 0, "-ve"]', "[0, 0]",
         "flows.jet: velocity = [0, 0] has 2 entries; three are needed, such as [0, 0, 1]"),
        ('[0, 0, "-ve"]', '[0, 0, "-c"]', f"flows.jet: velocity[2] = -c is in N s/m, and m/s is asked for; {CORRECT}"),
        ('rate = "-c"', 'rate = "-ve"', f"states.m: rate = -ve is in m/s, and kg/s is asked for; {CORRECT}"),
        ("velocity", 'rate = "-c"\nvelocity', f"flows.jet: rate is one too many for rocket; {RATE}"),
        ("[flows.jet]", '[flows.two]\nbody = "rocket"\nvelocity = [0, 0, 0]\n[flows.jet]',
         f"flows.jet: rate is missing, as of two; {RATE}"),
        ('mass = "m"', "mass = 3",
         'flows.jet: does nothing, as the mass of rocket, 3, has no state in it; a mass or an inertia changes by a '
         'state: write mass = "m_rocket" and [states.m_rocket] with rate = -0.1, start = 1, unit = "kg"'),
        ('mass = "m"', 'mass = "m*z"',
         "bodies.rocket: mass = m*z uses z; a mass or an inertia changes by a state: write "
         'mass = "m_rocket" and [states.m_rocket] with rate = -0.1, start = 1, unit = "kg"'),
        ('mass = "m"', 'mass = "m"\ncom = ["m", 0, 0]',
         "bodies.rocket: com[0] = m uses m, a state; only forces, loads, masses, rates, signals and outputs may depend "
         "on it"),
        ('mass = "m"', 'mass = "m"\nfirst_moment = [0, 0, 1]\ninertia_about = "frame"',
         'flows.jet: the centre of mass of rocket must be known; give com, and inertia_about = "com"'),
        ('[flows.jet]\nbody = "rocket"\nvelocity = [0, 0, "-ve"]', "",
         "bodies.rocket: mass or inertia changes with m, and nothing tells what leaves or arrives; write [flows.jet] "
         'with body = "rocket", velocity = [0, 0, 0]'),
        ('velocity = [0, 0, "-ve"]', "",
         "flows.jet: velocity is missing; write velocity = [0, 0, 0] of what leaves at rest in the body, or another "
         "one, m/s"),
        ('mass = "m"', 'mass = "m0*m/(m - m)"',
         "bodies.rocket: mass = m0*m/(m - m) divides by zero; check the denominator"),
        ('velocity', 'frame = "space"\nvelocity',
         'flows.jet: frame = "space" is not known; write "body" or "ground"'),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told(there: str, wrong: str, told: str) -> None:
    assert there in ROCKET
    with pytest.raises(SceneError) as refused:
        read_text(ROCKET.replace(there, wrong), "rocket.toml")
    assert placeless(refused.value) == f"rocket.toml: {told}"


@pytest.mark.parametrize(
    ("mass", "jets"),
    [("(m0 + m)**2/m - m0/m*m0 - 2*m0", 20000 / 40), ("m0*exp(m/m0)", 20000 / 100), ("sqrt(m*m0)", 20000 / 80)],
)
def test_a_mass_is_any_formula_in_states(mass: str, jets: float) -> None:
    """Of a mass M(m) the rate is M' m', and what accelerates the rocket is its logarithmic derivative."""
    one = read_text(ROCKET.replace('mass = "m"', f'mass = "{mass}"'))
    assert_allclose(symdyn.lambdify(one, "forward_dynamics")([0], [0], [0], [40.0]), [jets - G])


def test_a_robot_file_holds_numbers_only() -> None:
    with pytest.raises(SceneError, match="rocket: URDF holds numbers only, and m has no value; give each a value, or"):
        write_text_as(read_text(ROCKET), "urdf")


# Lessons


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("en", ("Matter that leaves or arrives", "masses are held fixed in all derivatives", "of jet damping")),
        ("sk", ("Hmota, ktorá odchádza alebo pribúda", "Meščerského rovnica", "ktorý otáčanie tlmí")),
    ],
)
def test_a_lesson_tells_what_matter_does(language: str, words: tuple[str, ...]) -> None:
    found = str(walkthrough(read_text(WHEEL), language=language))

    assert all(one in found for one in words)
    assert "Energy" in str(walkthrough(read_text(CHAIN)))


def test_names_for_numbers_change_nothing() -> None:
    rng = np.random.default_rng(3)
    q, u, du = rng.normal(size=7), rng.normal(size=6), rng.normal(size=6)
    q[3:] /= np.linalg.norm(q[3:])
    one, named = read_text(STEADY), declared.with_symbols(read_text(STEADY), "all")

    found, again = (symdyn.load(x, "inverse_dynamics").inverse_dynamics(q, u, du) for x in (one, named))
    assert len(named.parameters) > 20
    assert_allclose(again, found, rtol=1e-12)


def test_there_is_no_regressor_of_what_is_not_linear() -> None:
    with pytest.raises(DerivationError) as refused:
        symdyn.load(read_text(TANK), ["regressor"])
    assert str(refused.value) == (
        "tank: there is no regressor, as flows jet, scoop are not linear in masses and centres of mass; take them out, "
        "and what they change"
    )
