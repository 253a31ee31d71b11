"""Linear systems next to a point: against differences of the equations, and against what books print."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.algebra.numeric import Array, Floats
from symdyn.dynamics import derive_one
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import LinearizeError, SimulateError
from symdyn.graph import evaluate
from symdyn.linear import Linearization, linearize_at_rest
from symdyn.linear.equilibrium import FAMILY
from symdyn.linear.prepared import prepared
from symdyn.linear.steady import settled
from symdyn.linear.symbolic import symbolic
from symdyn.linear.system import csv_text
from symdyn.scene import bind, read_text
from symdyn.simulation import Problem
from symdyn.simulation.equations.compiled_routines import opened

pytestmark = pytest.mark.long

EXAMPLES = Path(__file__).parent.parent / "examples"


def example(name: str) -> symdyn.Scene:
    return symdyn.read(EXAMPLES / f"{name}.toml")


PLAIN = {
    "cart_pole": ({"theta": "0.4", "x": "1"}, {"x": "0.5", "theta": "-1"}),
    "double_pendulum": ({"q1": "0.3", "q2": "-1"}, {"q1": "1", "q2": "-0.4"}),
    "four_bar": ({"phi": "0.9"}, {"phi": "2"}),
    "slider_crank": ({"phi": "0.7"}, {"phi": "-3"}),
    "governor": ({}, {"phi": "11", "alpha": "0.5"}),
    "cart_with_wheel": ({"x": "0.3", "phi": "0.2"}, {"phi": "1.5"}),
    "gripper2": ({}, {}),
}


class Moving:
    """The equations of a scene, and their accelerations next to a point on the manifold."""

    def __init__(self, linear: Linearization) -> None:
        scene, self.point = linear.scene, linear.point
        self.w, self.numbers = Workspace(scene), opened(scene).numbers()
        self.entries = derive_one(self.w, "forward_dynamics").entries
        names = linear.states.names
        self.velocities = [scene.velocities.index(name) for name in names[linear.positions :]]
        self.positions = [scene.velocities.index(f"{name}_dot") for name in names[: linear.positions]]

    def rates(self, x: Array, tau: Array) -> Array:
        """Return the rates of independent positions and velocities that are by x from the point."""
        q = self.point.q.copy()
        q[self.positions] += x[: len(self.positions)]
        others = [k for k in range(len(q)) if k not in self.positions]
        for _ in range(8 if others else 0):
            R = self.numbers.residual_rates(q)[:, others]
            q[others] -= np.linalg.lstsq(R, self.numbers.residual(q), rcond=None)[0]
        u = self.point.u.copy()
        u[self.velocities] += x[len(self.positions) :]
        others = [k for k in range(len(u)) if k not in self.velocities]
        if others:
            G = self.numbers.jacobian(q)
            u[others] = -np.linalg.lstsq(G[:, others], G[:, self.velocities] @ u[self.velocities], rcond=None)[0]
        state = self.w.state
        values = self.w.graph
        known = dict(zip([*state.q, *state.qd, *state.tau], [*q, *u, *tau], strict=True))
        known |= {values.symbol(name): x for name, x in parameters(self.w.scene).items()}
        a = np.array(evaluate(self.entries, Floats(), known))
        return np.concatenate([u[self.positions], a[self.velocities]])


def parameters(scene: symdyn.Scene) -> dict[str, float]:
    from symdyn.simulation.equations.compiled_routines import opened

    return dict(opened(scene).values)


@pytest.mark.heavy("governor")
@pytest.mark.parametrize("name", PLAIN)
def test_a_and_b_are_what_differences_of_the_equations_tend_to(name: str) -> None:
    scene = example(name)
    at, rates = PLAIN[name]
    linear = symdyn.linearize(scene, start=at, start_rates=rates, anywhere=True)
    moving, step = Moving(linear), 1e-6
    columns = []
    for x in np.eye(len(linear.states)):
        there, here = (moving.rates(sign * step * x, linear.point.tau) for sign in (1, -1))
        columns.append((there - here) / (2 * step))
    size = np.abs(linear.A).max()
    assert pytest.approx(np.stack(columns, axis=1), abs=2e-8 * max(1.0, size)) == linear.A
    for k, drive in enumerate(linear.inputs.names):
        push = np.zeros(len(scene.velocities))
        push[scene.drives.index(drive)] = 1.0
        nothing = np.zeros(len(linear.states))
        more = moving.rates(nothing, linear.point.tau + push) - moving.rates(nothing, linear.point.tau)
        assert linear.B[:, k] == pytest.approx(more, abs=1e-9 * max(1.0, np.abs(linear.B).max()))


def held_hoop(motion: str) -> symdyn.Scene:
    """Return a bead on a hoop of 0.5 m that is turned about the vertical."""
    return read_text(f"""
name = "hoop"
gravity = [0, 0, -9.81]
[bodies.ring]
mass = 0
[bodies.bead]
particles = [{{ mass = 0.1, at = [0, 0, -0.5] }}]
[joints.spin]
type = "revolute"
parent = "ground"
child = "ring"
axis = [0, 0, 1]
coordinate = "phi"
motion = "{motion}"
[joints.slide]
type = "revolute"
parent = "ring"
child = "bead"
axis = [0, -1, 0]
coordinate = "theta"
drive = false
""")


def test_a_hoop_that_is_turned_has_steady_motions_and_no_position_of_rest() -> None:
    turned = symdyn.linearize(held_hoop("6*t"))
    np.testing.assert_allclose(turned.A, [[0, 1], [36 - 9.81 / 0.5, 0]], atol=1e-12)
    with pytest.raises(LinearizeError, match="no position of rest: a prescribed motion goes on, phi_dot = 6"):
        linearize_at_rest(held_hoop("6*t"))
    for motion in ("2*t**2", "sin(2*t)"):  # it does not turn on as it does now
        with pytest.raises(LinearizeError, match="phi_ddot"):
            symdyn.linearize(held_hoop(motion))
    (systems, _), size = linearize_at_rest(held_hoop("0.3")), 9.81 / 0.5
    assert sorted(round(float(one.A[1, 0]), 9) for one in systems) == [-size, size]


@pytest.mark.parametrize("force", ["-10*t", "-x*t"])
def test_what_balances_at_one_instant_is_no_equilibrium(force: str) -> None:
    cart = example("cart_pole")
    with pytest.raises(LinearizeError, match=r"no equilibrium at this point: at t = 0\.37 s"):
        symdyn.linearize(cart, forces={"F": force})
    with pytest.raises(LinearizeError, match=r"no equilibrium at this point: at t = 0\.37 s"):
        linearize_at_rest(cart, forces={"F": force})
    assert symdyn.linearize(cart, forces={"F": force}, anywhere=True).kind == "moving"


def test_steady_motion_ends_where_a_force_grows() -> None:
    governor, at = example("governor"), {"alpha": "0.695903503"}
    assert symdyn.linearize(governor, start=at).kind == "steady"
    with pytest.raises(LinearizeError, match=r"no steady motion: at t = .* would not be zero any more"):
        symdyn.linearize(governor, start=at, forces={str(next(filter(None, governor.drives))): "t"})


def test_an_arm_whose_weight_is_compensated_stays_where_it_is_put() -> None:
    arm, free = example("scara"), {"tau3": "-14.715"}
    weighed = symdyn.linearize(arm, forces=free)
    assert set(weighed.cyclic) == {"q1", "q2", "q3", "q4"}
    links = bind(example("two_link"), {"m1": 1, "m2": 2, "h1": 0.4, "h2": 0.3, "g": 9.81})
    at = {"q1": "0.7", "q2": "-0.4"}
    with pytest.raises(LinearizeError) as told:
        symdyn.linearize(links, start=at)
    given = ast.literal_eval(str(told.value).partition("it is held there by forces=")[2].partition("}")[0] + "}")
    assert symdyn.linearize(links, start=at, forces=given).kind == "rest"
    weight = {
        "M1": "g*(m1 + m2)*h1*sin(q1) + g*m2*h2*sin(q1 + q2)",
        "M2": "g*m2*h2*sin(q1 + q2)",
    }
    held = symdyn.linearize(links, start=at, forces=weight)
    assert np.abs(held.A[2:]).max() < 1e-12
    assert held.stability.zeros == {"cyclic": 2, "drifting": 2}


def test_formulas_of_a_compensated_weight_are_zero_where_numbers_are() -> None:
    links = bind(example("two_link"), {"m1": 1, "m2": 2, "h1": 0.4, "h2": 0.3, "g": 9.81})
    weight = {"M1": "9.81*(1.2*sin(q1) + 0.6*sin(q1 + q2))", "M2": "9.81*0.6*sin(q1 + q2)"}
    asked = prepared(Problem(links, weight))
    found = settled(asked, asked.at(np.array([0.7, -0.4]), np.zeros(2)))
    formulas = symbolic(asked, found)
    assert formulas is not None
    assert {entry for row in formulas.A[2:] for entry in row} == {formulas.A[0][0]}
    assert not found.spectrum.modes


def test_units_of_rows_in_a_csv_file_are_those_of_rates() -> None:
    rows = [line.split(",")[:4] for line in csv_text([symdyn.linearize(example("cart_pole"))]).splitlines()[1:5]]
    assert [row[3] for row in rows] == ["m/s", "rad/s", "m/s^2", "rad/s^2"]


def test_outputs_are_given_once() -> None:
    with pytest.raises(SimulateError, match="outputs: x is given twice"):
        symdyn.linearize(example("cart_pole"), outputs=["x", "x"])


@pytest.mark.parametrize("axis", [0, 2])
def test_a_free_body_that_spins_about_its_least_or_largest_axis_is_not_unstable(axis: int) -> None:
    rates = {f"flight_w{name}": "3" if k == axis else "0" for k, name in enumerate("xyz")}
    spun = symdyn.linearize(example("free_body"), start_rates=rates)
    assert spun.stability.verdict == "marginally stable"
    inertia = (
        1,
        2,
        3,
    )  # its place and momentum turn by 3 rad/s in its own axes, twice and with one shape; and it nutates
    first, second, third = inertia[axis], *(one for k, one in enumerate(inertia) if k != axis)
    nutation = 3 * np.sqrt((first - second) * (first - third) / (second * third))
    found = sorted(mode.value.imag for mode in spun.modes)
    np.testing.assert_allclose(found, sorted([nutation, 3, 3, 3]), rtol=1e-6)
    assert all(mode.value.real == pytest.approx(0, abs=3e-9) for mode in spun.modes)


def test_a_free_body_that_spins_about_its_middle_axis_turns_over() -> None:
    spun = symdyn.linearize(example("free_body"), start_rates={"flight_wx": "0", "flight_wy": "3", "flight_wz": "0"})
    (growing,) = spun.spectrum.growing
    assert growing.value == pytest.approx(3 / np.sqrt(3))


CIRCLE = """
name = "circle"
gravity = "none"
[bodies.slide]
mass = 3
[bodies.point]
mass = 1
[joints.x]
type = "prismatic"
parent = "ground"
child = "slide"
axis = [1, 0, 0]
[joints.y]
type = "prismatic"
parent = "slide"
child = "point"
axis = [0, 1, 0]
[springs.s]
from = "point"
to = { body = "ground", at = [2, 0, 0] }
stiffness = 100
free = 1
"""


def test_of_rests_on_a_curve_along_which_frequencies_change_a_dozen_is_told_and_the_others_are_counted():
    """A lesson listed 171 of 200, and took half a minute to linearise at each."""
    systems, found = linearize_at_rest(read_text(CIRCLE))
    assert len(systems) == FAMILY
    assert found.more > 100
    assert found.more + found.lost + sum(place.starts for place in found.places) == found.starts
    assert all(abs(sum((place.q - [2, 0]) ** 2) - 1) < 1e-9 for place in found.places)
