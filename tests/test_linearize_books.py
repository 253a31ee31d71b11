"""Linear systems against closed forms that books print, and against SymPy's own linearizer."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mechanisms import TREES

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.dynamics.outputs.derive import derive_one
from symdyn.errors import LinearizeError
from symdyn.graph import evaluate
from symdyn.linear import Axis, Linearization, linearize_along, linearize_at_rest
from symdyn.linear.equilibrium import equilibria
from symdyn.linear.linearized import complete
from symdyn.linear.prepared import prepared
from symdyn.linear.symbolic import symbolic
from symdyn.scene import bind
from symdyn.scene.values.letters import Input
from symdyn.simulation import Problem
from symdyn.simulation.initial import read_start

pytestmark = pytest.mark.long

EXAMPLES = Path(__file__).parent.parent / "examples"


def scene(tmp_path: Path, text: str) -> symdyn.Scene:
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return symdyn.read(path)


def frequencies(found: Linearization) -> list[float]:
    """Return the angular frequencies of what oscillates, ascending, rad/s."""
    return sorted(mode.value.imag for mode in found.modes if mode.oscillates)


PENDULUM_ON_A_CART = """
name = "inverted"
gravity = [0, "-g", 0]
[parameters]
M = 2
m = 0.1
l = 0.5
g = 9.81
[bodies.cart]
mass = "M"
[bodies.rod]
particles = [{ mass = "m", at = [0, "l", 0] }]
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
drive = "u"
[joints.hinge]
type = "revolute"
parent = "cart"
child = "rod"
axis = [0, 0, -1]
coordinate = "theta"
drive = false
"""


def test_an_inverted_pendulum_on_a_cart_is_what_ogata_prints(tmp_path: Path) -> None:
    """Ogata, Modern Control Engineering (5th edition, 2010), example 3-6, pages 70 to 72: a point mass on a rod."""
    found = symdyn.linearize(scene(tmp_path, PENDULUM_ON_A_CART))
    M, m, l, g = 2.0, 0.1, 0.5, 9.81  # noqa: E741  the book's letter
    A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, -m / M * g, 0, 0], [0, (M + m) / (M * l) * g, 0, 0]]
    assert pytest.approx(np.array(A), abs=1e-12) == found.A
    assert found.B[:, 0] == pytest.approx([0, 0, 1 / M, -1 / (M * l)], abs=1e-12)
    assert found.cyclic == ("x",)
    assert found.stability.zeros == {"cyclic": 1, "drifting": 1}


TWO_MASSES = """
name = "two_masses"
gravity = [0, -9.81, 0]
[parameters]
m1 = 1.5
m2 = 0.7
l1 = 0.6
l2 = 0.4
[bodies.upper]
particles = [{ mass = "m1", at = [0, "-l1", 0] }]
[bodies.lower]
particles = [{ mass = "m2", at = [0, "-l2", 0] }]
[joints.a]
type = "revolute"
parent = "ground"
child = "upper"
axis = [0, 0, 1]
coordinate = "q1"
[joints.b]
type = "revolute"
parent = "upper"
child = "lower"
axis = [0, 0, 1]
coordinate = "q2"
origin = [0, "-l1", 0]
"""


def test_a_double_pendulum_has_the_frequencies_of_landau_and_lifshitz(tmp_path: Path) -> None:
    """Landau and Lifshitz, Mechanics (3rd edition, 1976), section 23, problem 2.

    Also Kibble and Berkshire, Classical Mechanics (5th edition, 2004), page 260, (11.21).
    """
    found = symdyn.linearize(scene(tmp_path, TWO_MASSES))
    m1, m2, l1, l2, g = 1.5, 0.7, 0.6, 0.4, 9.81
    whole = (m1 + m2) * (l1 + l2)
    root = math.sqrt((m1 + m2) * ((m1 + m2) * (l1 + l2) ** 2 - 4 * m1 * l1 * l2))
    squares = [g / (2 * m1 * l1 * l2) * (whole + sign * root) for sign in (-1, 1)]
    assert np.square(frequencies(found)) == pytest.approx(squares, rel=1e-12)
    share = (m1 + m2) / m1
    polynomial = [1, -share * (g / l1 + g / l2), share * g**2 / (l1 * l2)]
    assert np.sort(np.roots(polynomial)) == pytest.approx(squares, rel=1e-12)
    assert found.stability.verdict == "marginally stable"


@pytest.mark.parametrize(("share", "verdict"), [(0.999, "unstable"), (1.001, "marginally stable")])
def test_a_top_sleeps_upright_where_it_spins_fast_enough(share: float, verdict: str) -> None:
    """Kibble and Berkshire, Classical Mechanics (5th edition, 2004), page 288, (12.26): ω₃² = 4 I₁ M g R / I₃²."""
    spin = share * math.sqrt(4 * (0.234375 + 15) * 15 * 9.81) / 0.46875
    upright = {"e0": "cos(pi/4)", "e1": "sin(pi/4)", "e2": "0", "e3": "0"}
    rates = {"point_wx": "0", "point_wy": repr(spin), "point_wz": "0"}
    found = symdyn.linearize(symdyn.read(EXAMPLES / "heavy_top.toml"), start=upright, start_rates=rates)
    assert found.kind == "steady"
    assert found.stability.verdict == verdict


HOOP = """
name = "hoop"
gravity = [0, 0, "-g"]
[parameters]
R = 0.4
g = 9.81
w = 7
[bodies.hoop]
mass = 1
inertia = [1, 1, 1]
inertia_about = "com"
[bodies.bead]
particles = [{ mass = 0.3, at = [0, 0, "-R"] }]
[joints.axle]
type = "revolute"
parent = "ground"
child = "hoop"
axis = [0, 0, 1]
coordinate = "psi"
motion = "w*t"
[joints.ring]
type = "revolute"
parent = "hoop"
child = "bead"
axis = [0, -1, 0]
coordinate = "theta"
drive = false
"""


def test_a_bead_on_a_turning_hoop_swings_as_taylor_says(tmp_path: Path) -> None:
    """Taylor, Classical Mechanics (2005), examples 7.6 and 7.7, pages 260 to 264: Ω'² = ω² - (g/ωR)²."""
    hoop = scene(tmp_path, HOOP)
    R, g, w = 0.4, 9.81, 7.0
    up = math.acos(g / (w**2 * R))
    found = symdyn.linearize(hoop, start={"theta": repr(up)})
    assert found.kind == "steady"
    assert found.states.names == ("theta", "theta_dot")
    assert frequencies(found) == pytest.approx([math.sqrt(w**2 - (g / (w * R)) ** 2)], rel=1e-9)
    lowest = symdyn.linearize(hoop)
    assert lowest.modes[0].value.real == pytest.approx(math.sqrt(w**2 - g / R))
    assert lowest.stability.verdict == "unstable"
    slow = symdyn.linearize(hoop, values={"w": 3})
    assert frequencies(slow) == pytest.approx([math.sqrt(g / R - 9)])


FOUCAULT = """
name = "foucault"
gravity = [0, 0, 0]
[parameters]
k = 30
m = 2
w = 0.8
[bodies.table]
mass = 1
inertia = [1, 1, 1]
inertia_about = "com"
[bodies.slide]
mass = 0
inertia = [0, 0, 0]
inertia_about = "com"
[bodies.bob]
mass = "m"
[joints.earth]
type = "revolute"
parent = "ground"
child = "table"
axis = [0, 0, 1]
coordinate = "psi"
motion = "w*t"
[joints.east]
type = "prismatic"
parent = "table"
child = "slide"
axis = [1, 0, 0]
coordinate = "x"
drive = false
force = "-k*x + m*w**2*0"
[joints.north]
type = "prismatic"
parent = "slide"
child = "bob"
axis = [0, 1, 0]
coordinate = "y"
drive = false
force = "-k*y"
"""


def test_a_plane_of_swing_turns_against_a_turning_table(tmp_path: Path) -> None:
    """Taylor, Classical Mechanics (2005), section 9.9, pages 354 to 357: ω₀ ± Ω seen from what turns by Ω."""
    found = symdyn.linearize(scene(tmp_path, FOUCAULT))
    assert found.kind == "steady"
    assert frequencies(found) == pytest.approx([math.sqrt(15) - 0.8, math.sqrt(15) + 0.8], rel=1e-12)


@pytest.mark.parametrize("spin", [3.0, 3.3015148, 3.5, 6.0])
def test_a_disc_rolls_upright_beyond_the_critical_spin(spin: float) -> None:
    """Neimark and Fufaev, Dynamics of Nonholonomic Systems (1972): stable where ω² > g/3r; λ² = 4g/5r - 12ω²/5."""
    disc = symdyn.read(EXAMPLES / "rolling_disc.toml")
    found = symdyn.linearize(
        disc, start={"z": "r", "e0": "1", "e1": "0"}, start_rates={"flight_wx": "0", "flight_wy": repr(spin)}
    )
    square = 4 * 9.81 / (5 * 0.3) - 12 / 5 * spin**2
    assert found.kind == "steady"
    values = np.sort_complex(found.poles**2)
    assert min(abs(values - square)) < 1e-6 * 26
    if abs(square) > 1e-3:
        assert found.stability.verdict == ("marginally stable" if square < 0 else "unstable")


def test_a_wheel_that_stands_has_zeros_of_rolling_and_they_are_not_unstable() -> None:
    wheel = symdyn.linearize(symdyn.read(EXAMPLES / "cart_with_wheel.toml"))
    told = wheel.stability
    assert wheel.positions == 2
    assert len(wheel.states) == 3
    assert told.zeros == {"cyclic": 1, "rolling": 1}
    assert told.words == "marginally stable: x, phi do not decay; all other eigenvalues have negative real parts"


def test_a_top_that_hangs_may_turn_about_the_vertical_and_tips_when_it_stands() -> None:
    systems, places = linearize_at_rest(symdyn.read(EXAMPLES / "heavy_top.toml"))
    assert [one.stability.verdict for one in systems] == ["unstable", "marginally stable"]
    assert all(place.family for place in places.places)
    assert systems[1].stability.zeros == {"cyclic": 1, "drifting": 1}
    assert systems[1].cyclic == ("along point_wy",)


def test_a_spring_at_its_limit_is_undecided_and_not_cyclic(tmp_path: Path) -> None:
    text = TWO_MASSES.split("[bodies.lower]", maxsplit=1)[0] + "\n".join(
        ["[joints.a]", 'type = "revolute"', 'parent = "ground"', 'child = "upper"', "axis = [0, 0, 1]",
         'coordinate = "q1"', "drive = false", 'force = "-m1*9.81*l1*q1"']
    )  # fmt: skip
    upright = symdyn.linearize(scene(tmp_path, text.replace('"-l1", 0]', '"l1", 0]')))
    assert upright.cyclic == ()
    assert upright.stability.verdict == "marginally stable"


def test_positions_of_rest_are_found_and_singular_ones_are_none() -> None:
    bar = linearize_at_rest(symdyn.read(EXAMPLES / "four_bar.toml"))[0]
    assert [one.stability.verdict for one in bar] == ["marginally stable", "marginally stable", "unstable", "unstable"]
    none, places = linearize_at_rest(symdyn.read(EXAMPLES / "governor.toml"))
    assert none == ()
    assert sum(place.starts for place in places.crossings) > 100  # arms straight down, where branches meet


def test_no_equilibrium_is_told_with_the_nearest_one() -> None:
    cart = symdyn.read(EXAMPLES / "cart_pole.toml")
    nearest = r'theta_ddot = 9\.27\d* rad/s\^2; the nearest equilibrium is at start=\{"x": 0, "theta": 0\}; or give'
    with pytest.raises(LinearizeError, match=f"{nearest} forces that hold it, or anywhere=True"):
        symdyn.linearize(cart, start={"theta": "0.3"})
    assert symdyn.linearize(cart, start={"theta": "0.3"}, anywhere=True).kind == "moving"
    governor = symdyn.read(EXAMPLES / "governor.toml")
    with pytest.raises(LinearizeError, match=r"the nearest steady motion is at start=\{.*\"alpha\": 0\.69590"):
        symdyn.linearize(governor)
    steady = symdyn.linearize(governor, start={"alpha": "0.695903503"})
    assert steady.dropped == ("phi",)
    assert steady.kind == "steady"


def test_forces_hold_a_place_and_may_name_inputs_of_the_scene() -> None:
    arm = replace(symdyn.read(EXAMPLES / "pendulum.toml"), inputs=(Input("r"),))
    held = symdyn.linearize(arm, start={"q1": "pi/2"}, forces="tau1 = m*g*l + 3*r - 2*(q1 - pi/2)")
    assert held.inputs.names == ("tau1", "r")
    assert pytest.approx(np.array([[0, 1], [-2 / 0.25, -0.01 / 0.25]])) == held.A
    assert pytest.approx(np.array([[0, 0], [4, 12]])) == held.B
    assert held.point.tau == pytest.approx([9.81 * 0.5])


def test_outputs_are_points_reactions_multipliers_and_formulas() -> None:
    arm = symdyn.read(EXAMPLES / "pendulum.toml")
    found = symdyn.linearize(arm, outputs=["point_tip_x", "reaction_hinge_fx", "tau1*q1_dot + 2*q1", "q1_ddot"])
    assert found.C[[0, 2, 3]] == pytest.approx(np.array([[0.5, 0], [2, 0], [-19.62, -0.04]]))
    assert found.D[[0, 2, 3], 0] == pytest.approx([0, 0, 4])
    assert found.C[1] == pytest.approx([0, -0.02])  # across the rod m (l q̈ + g sin q) = -b q̇/l
    assert found.outputs.units == ("m", "N", "W", "rad/s^2")


@pytest.mark.runs("cc")
def test_along_a_run_the_systems_are_those_at_its_points() -> None:
    arm = symdyn.read(EXAMPLES / "double_pendulum.toml")
    run = symdyn.simulate(arm, forces=("tau1=sin(t)",), until=0.5, every=0.25, start={"q1": "0.4"})
    systems = linearize_along(arm, run)
    assert len(systems) == 3
    last = systems[-1]
    at = {name: repr(float(x)) for name, x in zip(arm.coordinates, run.q[-1], strict=True)}
    rates = {name: repr(float(x)) for name, x in zip(arm.velocities, run.qd[-1], strict=True)}
    same = symdyn.linearize(arm, start=at, start_rates=rates, forces="tau1=sin(0.5)", anywhere=True)
    assert pytest.approx(same.A, abs=1e-9) == last.A
    assert last.point.udot == pytest.approx(run.qdd[-1], rel=1e-6)


def test_unbound_parameters_are_told(tmp_path: Path) -> None:
    open_one = scene(tmp_path, PENDULUM_ON_A_CART.replace("m = 0.1", "m = {}"))
    with pytest.raises(symdyn.SymdynError, match=r'values=\{"m": 1\}'):
        symdyn.linearize(open_one)


@pytest.mark.long(0)
def test_sympy_finds_the_same_system(tmp_path: Path) -> None:
    """SymPy's mechanics linearizer on the cart with its rod, from Lagrange's equations of its own."""
    import sympy as sp
    from sympy.physics.mechanics import LagrangesMethod, Lagrangian, Particle, Point, ReferenceFrame, dynamicsymbols

    M, m, l, g = sp.symbols("M m l g", positive=True)  # noqa: E741
    x, theta, F = dynamicsymbols("x theta F")
    N = ReferenceFrame("N")
    O = Point("O")  # noqa: E741
    O.set_vel(N, 0)
    C = O.locatenew("C", x * N.x)
    C.set_vel(N, x.diff() * N.x)
    P = C.locatenew("P", l * sp.sin(theta) * N.x + l * sp.cos(theta) * N.y)
    P.set_vel(N, P.pos_from(O).dt(N))
    cart, bob = Particle("cart", C, M), Particle("bob", P, m)
    bob.potential_energy = m * g * l * sp.cos(theta)
    made = LagrangesMethod(Lagrangian(N, cart, bob), [x, theta], forcelist=[(C, F * N.x)], frame=N)
    made.form_lagranges_equations()
    A, B, _ = made.linearize(q_ind=[x, theta], qd_ind=[x.diff(), theta.diff()], A_and_B=True,
                             op_point={x: 0, theta: 0, x.diff(): 0, theta.diff(): 0})  # fmt: skip
    numbers = {M: 2.0, m: 0.1, l: 0.5, g: 9.81}
    found = symdyn.linearize(scene(tmp_path, PENDULUM_ON_A_CART))
    assert pytest.approx(np.array(A.subs(numbers), dtype=float), abs=1e-9) == found.A
    assert pytest.approx(np.array(B.subs(numbers), dtype=float), abs=1e-9) == found.B


def test_python_control_takes_it() -> None:
    pytest.importorskip("control")
    system = symdyn.linearize(symdyn.read(EXAMPLES / "cart_pole.toml")).to_control()
    assert system.state_labels == ["x", "theta", "x_dot", "theta_dot"]
    assert system.input_labels == ["F"]


def test_all_positions_are_known_where_real_solutions_are_counted(tmp_path: Path) -> None:
    asked = prepared(Problem(scene(tmp_path, TWO_MASSES)))
    found = equilibria(asked)
    assert len(found.places) == 4
    assert complete(found)
    assert not complete(replace(found, places=found.places[:3]))
    spring = TWO_MASSES + 'drive = false\nforce = "-3*q2"\n'  # angle and sine: no polynomial
    other = prepared(Problem(scene(tmp_path, spring)))
    assert not complete(equilibria(other))


@pytest.mark.parametrize("name", ["governor", "rolling_disc", "slider_crank", "heavy_top"])
def test_rows_of_the_equations_give_the_same_matrices(name: str) -> None:
    """`state_matrices` eliminates on the graph, linearize in numbers."""
    one = symdyn.read(EXAMPLES / f"{name}.toml")
    asked, start = prepared(Problem(one)), read_start(one)
    found, w = asked.at(start.q, start.u), asked.functions.w
    function = derive_one(w, "state_matrices")
    names = [row.removeprefix("rate of ") for row in function.labels[0]]
    if {*names} != {*found.states.names}:  # of the same number, chosen otherwise
        found = asked.at(start.q, start.u, like=replace(found, states=Axis(tuple(names), found.states.units)))
    order = [names.index(name) for name in found.states.names]
    values = dict(asked.place(start.q, start.u).values)
    AB = np.array(evaluate(function.entries, Floats(), values)).reshape(function.shape)[order]
    n = len(names)
    AB[:, :n] = AB[:, order]
    size = max(1.0, float(np.abs(found.A).max()))
    assert AB[:, :n] == pytest.approx(found.A, abs=1e-9 * size)
    assert AB[:, n:][:, asked.drives] == pytest.approx(found.B, abs=1e-9 * size)


def test_formulas_of_what_is_not_small_are_given_up_soon() -> None:
    """The third random tree took minutes."""
    tree = bind(TREES[3], {"m0": 1, "beta": 1})
    asked = prepared(Problem(tree))
    assert symbolic(asked, equilibria(asked).systems[0]) is None


def test_a_loop_whose_rows_say_nothing_is_linearised_as_a_tree() -> None:
    door = symdyn.read(Path(__file__).parent / "data" / "door.toml")
    asked = prepared(Problem(door))
    assert asked.functions.multipliers == ()
    systems = equilibria(asked).systems
    assert systems
    assert symbolic(asked, systems[0]) is not None
