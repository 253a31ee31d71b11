"""The door `equations`: the same equations to be read and to be worked on with SymPy."""

from __future__ import annotations

import pickle
import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import sympy
import sympy.physics.mechanics
from calls import counted

import symdyn
from symdyn.emit.print.sympy_equations import SympyEquations
from symdyn.scene import bind, body, prismatic, read_text, spring
from symdyn.scene.scene_files import Starter

MOTOR = """
name = "motor"
[inputs.u]
unit = "V"
[bodies.rotor]
mass = 1
inertia = [1, 1, 1]
com = [0, 0, 0]
inertia_about = "com"
[joints.shaft]
type = "revolute"
parent = "ground"
child = "rotor"
axis = [0, 0, 1]
drive = false
force = "3*u - 2*q1_dot"
"""

TREES = ["pendulum", "two_link", "cart_pole", "scara"]
CLOSED = ["four_bar", "slider_crank", "spatial_slider_crank", "rsup", "cart_with_wheel"]


def valued(name: str) -> symdyn.Scene:
    """Return an example in which every parameter has a value."""
    scene = symdyn.example(name)
    return bind(scene, {one.name: 1 + k / 3 for k, one in enumerate(scene.free_parameters)})


def state(found: SympyEquations, seed: int = 4) -> dict[object, float]:
    """Return numbers for coordinates, velocities, accelerations and drives."""
    rng = np.random.default_rng(seed)
    names = [*found.q, *found.qd, *found.qdd, *filter(None, (found.symbols.get(d) for d in found.scene.drives if d))]
    return dict(zip(names, rng.uniform(-1, 1, len(names)), strict=True))


def numbers(matrix: object, found: SympyEquations, at: dict[object, float]) -> np.ndarray:
    return np.array(sympy.Matrix(matrix).subs(found.values).subs(at).evalf(), dtype=float)


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.parametrize("name", [*TREES, *CLOSED])
def test_matrices_have_the_values_of_generated_code(name: str) -> None:
    scene = valued(name)
    found = symdyn.equations(scene).sympy()
    at = state(found)
    q, qd, qdd = (np.array([at[x] for x in column]) for column in (found.q, found.qd, found.qdd))
    forces = "tree_forces" if scene.is_constrained else "inverse_dynamics"
    M, g, tau = symdyn.lambdify(scene, ("mass_matrix", "gravity_forces", forces))

    assert numbers(found.M, found, at) == pytest.approx(M(q), abs=1e-12)
    assert numbers(found.g, found, at)[:, 0] == pytest.approx(g(q), abs=1e-12)
    left = found.M * found.qdd + found.C * found.qd + found.g + found.k_E - found.tau
    drives = numbers(left, found, at | {x: 0.0 for x in at if str(x) in map(str, scene.drives)})
    assert drives[:, 0] == pytest.approx(tau(q, qd, qdd), abs=1e-11)


@pytest.mark.long
@pytest.mark.parametrize("name", ["two_link", "scara", "four_bar"])
def test_c_is_c_qd_and_mdot_less_two_c_is_skew(name: str) -> None:
    found = symdyn.equations(symdyn.example(name)).sympy()
    rate = sum((found.M.diff(q) * u for q, u in zip(found.q, found.qd, strict=True)), sympy.zeros(*found.M.shape))
    skew = rate - 2 * found.C

    assert sympy.simplify(found.C * found.qd - found.c).is_zero_matrix
    assert sympy.simplify(skew + skew.T).is_zero_matrix
    assert any(skew)


@pytest.mark.heavy("rsup")
@pytest.mark.long
@pytest.mark.parametrize("name", CLOSED)
def test_rows_of_loops_are_the_derivatives_of_what_closes_them(name: str) -> None:
    found = symdyn.equations(symdyn.example(name)).sympy()
    held = found.residual.rows

    assert found.G.shape == (len(found.multipliers), len(found.q)) == (len(found.bias), len(found.q))
    slopes = found.residual.jacobian(found.q) if held else sympy.zeros(0, len(found.q))
    assert sympy.simplify(slopes - found.G[:held, :]).is_zero_matrix
    bias = (found.G * found.qd).jacobian(found.q) * found.qd
    at = state(found)
    assert numbers(bias - found.bias, found, at) == pytest.approx(0, abs=1e-12)


@pytest.mark.long
def test_rows_without_a_closed_form_are_exact_as_they_were_derived() -> None:
    text = Path(symdyn.example("rolling_disc").source).read_text(encoding="utf-8")
    text = text.replace(
        '["x", "y", "z", "e0", "e1", "e2", "e3"]', '["x", "y", "z", "a", "b", "c"]\norientation = "zyx"'
    )
    text = re.sub(r"start = .*\nstart_rates.*", 'start = [0, 0, "r*cos(pi/12)", 0, 0, "pi/12"]', text)
    scene = read_text(text, "disc.toml")
    found = symdyn.equations(scene).sympy()
    at = state(found)
    q, qd = (np.array([at[x] for x in column]) for column in (found.q, found.qd))
    jacobian, bias = symdyn.lambdify(scene, ("constraint_jacobian", "constraint_bias"))
    values = sympy.lambdify([*found.q, *found.qd], [found.G.subs(found.values), found.bias.subs(found.values)])(*q, *qd)

    assert "no trigonometric polynomial" in found.unsimplified
    assert values[0] == pytest.approx(jacobian(q), abs=1e-12)
    assert values[1][:, 0] == pytest.approx(bias(q, qd), abs=1e-12)
    assert found.residual.shape == (1, 1)


def test_inputs_are_symbols_and_functions_of_time_on_request() -> None:
    motor = symdyn.scene.read_text(MOTOR, "motor.toml")
    plain, moving = (symdyn.equations(motor).sympy(dynamic) for dynamic in (False, True))

    assert plain.tau[0] == 3 * plain["u"] - 2 * plain["q1_dot"]
    assert moving.tau[0] == 3 * moving["u"] - 2 * moving["q1_dot"]
    assert moving["u"] == sympy.physics.mechanics.dynamicsymbols("u")


def test_loops_are_closed_where_the_scene_starts() -> None:
    found = symdyn.equations(symdyn.example("four_bar")).sympy()
    start = dict(zip(found.q, (0.8, 0.1420089234527959928, 2.0260131545490214846), strict=True))  # as the file has it

    assert numbers(found.residual, found, start) == pytest.approx(0, abs=1e-14)


def test_dynamicsymbols_are_those_of_sympy_and_obey_lagrange() -> None:
    from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

    found = symdyn.equations(symdyn.example("two_link")).sympy(dynamic=True)
    q = dynamicsymbols("q1 q2")
    assert tuple(found.q) == tuple(q)
    assert tuple(found.qd) == tuple(x.diff() for x in q)

    lagrange = LagrangesMethod(found.K - found.P, q)
    wanted = lagrange.form_lagranges_equations()
    left = found.M * found.qdd + found.c + found.g
    assert sympy.simplify(sympy.Matrix(wanted) - left).is_zero_matrix


def test_what_is_given_substitutes_simplifies_and_lambdifies() -> None:
    found = symdyn.equations(symdyn.example("two_link")).sympy()
    m1, q2 = found["m1"], found["q2"]

    assert found.M.subs({m1: 0, q2: sympy.pi / 2})[0, 1] == found["h2"] ** 2 * found["m2"]
    assert m1.is_positive
    assert q2.is_real
    function = sympy.lambdify([list(found.q), found["m1"], found["m2"], found["h1"], found["h2"]], found.M)
    assert function(np.array([0.3, 0.4]), 1, 2, 0.5, 0.25).shape == (2, 2)
    with pytest.raises(KeyError, match="there is no 'm9'; there are m1, m2"):
        found["m9"]


@pytest.mark.parametrize("whole", [np.int64, np.uint8, sympy.Integer])
def test_every_matrix_takes_indices_of_any_library(whole: type) -> None:
    equations = symdyn.equations(symdyn.example("two_link"))
    found = equations.sympy()

    for i, j in product((0, 1), repeat=2):
        assert found.M[whole(i), whole(j)] == found.M[i, j] == equations.closed.sympy("k_z", whole(i), whole(j))
        assert found.g[whole(i)] == equations.closed.sympy("k_G", whole(i))


def test_numbers_are_exact_and_matrices_do_not_change() -> None:
    found = symdyn.equations(symdyn.example("puma560")).sympy()

    assert not found.M.atoms(sympy.Float)
    with pytest.raises(TypeError):
        found.M[0, 0] = 1
    again = pickle.loads(pickle.dumps(found))
    assert again.M == found.M


def test_springs_dampers_and_prescribed_motions_have_their_places() -> None:
    led = prismatic("led", "ground", "table", axis=[1, 0, 0], coordinate="y", motion="b*sin(3*t)")
    rail = prismatic("rail", "table", "cart", axis=[1, 0, 0], coordinate="x", drive="F", damping="d")
    one = symdyn.scene.scene(
        "one",
        parameters={"k": 3, "d": 2, "b": None},
        bodies=[body("table", mass=1), body("cart", mass=2)],
        joints=[led, rail],
        springs=[spring("pull", joint="rail", stiffness="k")],
    )
    found, moving = (symdyn.equations(one).sympy(dynamic) for dynamic in (False, True))
    x, v, F, k, d, b, t = (found[name] for name in ("x", "x_dot", "F", "k", "d", "b", "t"))

    assert found.k_E[1] == k * x
    assert found.tau[1] == F - d * v
    assert found.values == {k: 3, d: 2}
    assert found.equations[1] == sympy.Eq(2 * found["y_ddot"] + 2 * found["x_ddot"] + k * x, F - d * v)
    assert found.motions == {found["y"]: b * sympy.sin(3 * t)}
    assert moving.motions == {moving["y"]: b * sympy.sin(3 * moving["t"])}


@pytest.mark.long(0)
def test_a_six_axis_arm_takes_no_long() -> None:
    with counted() as calls:
        found = symdyn.equations(symdyn.example("puma560")).sympy()

    assert found.C.shape == (6, 6)
    assert calls.number < 5_000_000


@pytest.mark.long
def test_what_would_take_minutes_is_refused_in_seconds_with_a_way_out() -> None:
    chain = symdyn.equations(read_text(Starter("chain").from_template("chain", 60), "chain.toml"))
    with counted() as calls, pytest.raises(symdyn.SymdynError, match=r"too long to be of use.*symdyn generate writes"):
        chain.sympy()
    assert calls.number < 100_000


def test_the_door_takes_paths_and_tells_what_has_no_closed_form(tmp_path) -> None:
    from symdyn.scene import write_text

    path = tmp_path / "arm.toml"
    path.write_text(write_text(symdyn.example("two_link"), "toml").text, encoding="utf-8")
    assert symdyn.equations(path).text() == symdyn.equations(symdyn.example("two_link")).text()
    with path.open(encoding="utf-8") as file:
        assert "sin" in symdyn.equations(file).latex()
    with pytest.raises(symdyn.SymdynError, match="k_C alone has 106200 entries"):
        symdyn.equations(read_text(Starter("chain").from_template("chain", 60), "chain.toml")).sympy()
