"""A, B, C, D as SymPy matrices: against the numbers of every example, and against `sympy.physics.mechanics`."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from engine.trials.cases import draw
from engine.trials.code import told
from engine.trials.options import choice
from sympy import Matrix, simplify, symbols
from sympy.physics.mechanics import KanesMethod, Particle, Point, ReferenceFrame, RigidBody, dynamicsymbols, inertia

import symdyn
from symdyn.errors import LinearizeError
from symdyn.linear import Formulas, Linearization
from symdyn.scene import bind, read_text

EXAMPLES = Path(__file__).parent.parent / "examples"

Values = dict[str, float | str]

MOVING: dict[str, tuple[Values, Values]] = {
    "arm7": ({"q1": 0.3, "q2": -0.8, "q4": 1.1, "q6": 0.4}, {"q1": 0.5, "q3": -1}),
    "double_pendulum": ({"q1": 0.3, "q2": -1}, {"q1_dot": 1, "q2_dot": -0.4}),
    "four_bar": ({"phi": 0.9}, {"phi_dot": 2}),
    "governor": ({}, {"phi_dot": 11, "alpha_dot": 0.5}),
    "bicycle": ({}, {"x_dot": 5}),
}
SPINNING: dict[str, tuple[Values, Values]] = {
    "rolling_disc": ({"z": "r", "e0": "1", "e1": "0"}, {"flight_wx": "0", "flight_wy": "3.3"}),
    "heavy_top": (
        {"e0": "cos(pi/4)", "e1": "sin(pi/4)", "e2": "0"},
        {"point_wx": "0", "point_wy": "100", "point_wz": "0"},
    ),
}


def example(name: str) -> symdyn.Scene:
    scene = symdyn.read(EXAMPLES / f"{name}.toml")
    return bind(scene, {one.name: 1.0 + k / 7 for k, one in enumerate(scene.free_parameters)})


def assert_same(found: Formulas, system: Linearization) -> None:
    for one, number in zip(found.evaluated(), (system.A, system.B, system.C, system.D), strict=True):
        assert one.shape == number.shape
        assert np.abs(one - number).max(initial=0) <= 1e-12 * max(1, np.abs(number).max(initial=0))
    M, A, B = (np.array(one.xreplace(found.point).tolist(), dtype=float).reshape(one.shape) for one in found.implicit)
    right = np.hstack([system.A, system.B])
    assert np.hstack([A, B]) == pytest.approx(M @ right, rel=1e-9, abs=1e-10 * max(1, np.abs(right).max(initial=0)))


@pytest.mark.wide(2)
@pytest.mark.heavy("quadruped")
@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.toml")))
def test_formulas_have_the_numbers_as_values_at_the_point(name: str) -> None:
    system = symdyn.linearize(example(name), anywhere=True)
    assert_same(system.formulas, system)


@pytest.mark.wide(2)
@pytest.mark.parametrize("name", MOVING)
def test_formulas_hold_in_motion_and_where_coordinates_have_no_exact_form(name: str) -> None:
    start, rates = MOVING[name]
    system = symdyn.linearize(example(name), start=start, start_rates=rates, anywhere=True)
    assert_same(system.formulas, system)


@pytest.mark.parametrize("name", SPINNING)
def test_formulas_hold_in_axes_that_do_not_spin_with_a_body(name: str) -> None:
    start, rates = SPINNING[name]
    system = symdyn.linearize(example(name), start=start, start_rates=rates)
    assert system.kind == "steady"
    assert system.spin.any()
    assert_same(system.formulas, system)


@pytest.mark.wide(2)
@pytest.mark.parametrize("seed", [2, 5, 6, 11, 12, 13, 15, 19, 78])
def test_formulas_hold_of_mechanisms_of_all_kinds(seed: int) -> None:
    scene, values = told(draw(seed, choice(seed)))
    rates = dict.fromkeys(scene.velocities[: seed % 2], 0.37)
    system = symdyn.linearize(bind(scene, values), start_rates=rates, anywhere=True)
    assert_same(system.formulas, system)


def test_formulas_are_of_the_states_that_a_system_has() -> None:
    cart = symdyn.linearize(example("cart_pole"))
    bar = symdyn.linearize(example("four_bar"), start={"phi": 1.23736964})
    for system in (cart.without([0]), bar.without([0])):
        assert_same(system.formulas, system)


def test_small_systems_have_the_formulas_that_are_printed() -> None:
    found = symdyn.linearize(example("cart_pole")).formulas
    assert str(found.A[3, 1]) == "6*g*(mc + mp)/(l*(4*mc + mp))"
    assert not found.definitions
    assert np.array(found.A.subs(found.point).tolist(), dtype=float) == pytest.approx(found.evaluated()[0])
    assert [str(one) for one in found.states] == ["x", "theta", "x_dot", "theta_dot"]


def kane_cart_pole() -> tuple[Matrix, Matrix]:
    """Return A and B of a cart with a uniform rod, upright, by Kane's method and its linearization."""
    x, theta, v, w = dynamicsymbols("x theta v w")
    F = dynamicsymbols("F")
    mc, mp, length, g, b = symbols("mc mp l g b")
    N, origin = ReferenceFrame("N"), Point("O")
    origin.set_vel(N, 0)
    P = origin.locatenew("P", x * N.x)
    P.set_vel(N, v * N.x)
    R = N.orientnew("R", "Axis", [-theta, N.y])
    R.set_ang_vel(N, -w * N.y)
    G = P.locatenew("G", length / 2 * R.z)
    G.v2pt_theory(P, N, R)
    rod = RigidBody("rod", G, R, mp, (inertia(R, mp * length**2 / 12, mp * length**2 / 12, 0), G))
    kane = KanesMethod(N, [x, theta], [v, w], [x.diff() - v, theta.diff() - w])
    kane.kanes_equations([Particle("cart", P, mc), rod], [(P, (F - b * v) * N.x), (G, -mp * g * N.z)])
    A, B, inputs = kane.linearize(A_and_B=True, op_point={x: 0, theta: 0, v: 0, w: 0}, new_method=True)
    assert list(inputs) == [F]
    return A, B


def kane_half_car() -> tuple[Matrix, Matrix]:
    """Return A and B of a half-car on two wheels, its roads as inputs, likewise."""
    q, u, roads = dynamicsymbols("z pitch zu zv"), dynamicsymbols("uz up uu uv"), dynamicsymbols("zf zr")
    ms, Jy, mf, mr, a, b, kf, kr, cf, cr, kt = symbols("ms Jy mf mr a b kf kr cf cr kt")
    N, origin = ReferenceFrame("N"), Point("O")
    origin.set_vel(N, 0)
    C = origin.locatenew("C", q[0] * N.z)
    C.set_vel(N, u[0] * N.z)
    R = N.orientnew("R", "Axis", [q[1], N.y])
    R.set_ang_vel(N, u[1] * N.y)
    bodies, loads = [RigidBody("chassis", C, R, ms, (inertia(R, 0, Jy, 0), C))], []
    for k, x, m, stiffness, damping in ((2, a, mf, kf, cf), (3, -b, mr, kr, cr)):
        corner, wheel = C.locatenew(f"P{k}", x * R.x), origin.locatenew(f"W{k}", x * N.x + q[k] * N.z)
        corner.v2pt_theory(C, N, R)
        wheel.set_vel(N, u[k] * N.z)
        force = -stiffness * (corner.pos_from(wheel).dot(N.z)) - damping * (corner.vel(N) - wheel.vel(N)).dot(N.z)
        bodies.append(Particle(f"wheel{k}", wheel, m))
        loads += [(corner, force * N.z), (wheel, (kt * (roads[k - 2] - q[k]) - force) * N.z)]
    kane = KanesMethod(N, list(q), list(u), [one.diff() - rate for one, rate in zip(q, u, strict=True)])
    kane.kanes_equations(bodies, loads)
    point = dict.fromkeys((*q, *u), 0)
    A, B, _ = kane.linearize(A_and_B=True, op_point=point, new_method=True)
    return A, B


HALF_CAR = """
name = "half_car"
gravity = "none"
[parameters]
ms = 600
Jy = 900
mf = 40
mr = 45
a = 1.2
b = 1.5
kf = 18000
kr = 22000
cf = 1300
cr = 1500
kt = 180000
[inputs.zf]
unit = "m"
[inputs.zr]
unit = "m"
[bodies]
hub = {}
chassis = { mass = "ms", inertia = ["Jy", "Jy", "Jy"], inertia_about = "com" }
front = { mass = "mf" }
rear = { mass = "mr" }
[joints]
heave = { type = "prismatic", parent = "ground", child = "hub", axis = [0, 0, 1], coordinate = "z", drive = false }
pitch = { type = "revolute", parent = "hub", child = "chassis", axis = [0, 1, 0], coordinate = "pitch", drive = false }
[joints.fw]
type = "prismatic"
parent = "ground"
child = "front"
axis = [0, 0, 1]
origin = ["a", 0, -0.5]
coordinate = "zu"
force = "kt*(zf - zu)"
drive = false
[joints.rw]
type = "prismatic"
parent = "ground"
child = "rear"
axis = [0, 0, 1]
origin = ["-b", 0, -0.5]
coordinate = "zv"
force = "kt*(zr - zv)"
drive = false
[springs.sf]
from = { body = "chassis", at = ["a", 0, 0] }
to = "front"
stiffness = "kf"
free = 0.5
[springs.sr]
from = { body = "chassis", at = ["-b", 0, 0] }
to = "rear"
stiffness = "kr"
free = 0.5
[dampers.df]
from = { body = "chassis", at = ["a", 0, 0] }
to = "front"
damping = "cf"
[dampers.dr]
from = { body = "chassis", at = ["-b", 0, 0] }
to = "rear"
damping = "cr"
"""

KANE: dict[str, tuple[Callable[[], symdyn.Scene], Callable[[], tuple[Any, Any]]]] = {
    "cart_pole": (lambda: example("cart_pole"), kane_cart_pole),
    "half_car": (lambda: read_text(HALF_CAR), kane_half_car),
}


@pytest.mark.parametrize("name", KANE)
def test_kanes_method_linearizes_to_the_same(name: str) -> None:
    """`sympy.physics.mechanics`, which shares nothing with this, gives the same A and B, in symbols."""
    scene, kane = KANE[name]
    found, other = symdyn.linearize(scene()).formulas, kane()
    for ours, theirs in zip((found.A, found.B), other, strict=True):
        plain = ours.subs({one: symbols(str(one)) for one in ours.free_symbols})
        apart: Any = plain - theirs
        assert all(simplify(x) == 0 for x in apart)


def test_a_function_of_named_parameters_gives_the_matrices() -> None:
    scene = example("arm7")
    start = {name: 0.2 * k - 0.5 for k, name in enumerate(scene.coordinates)}
    system = symdyn.linearize(scene, start=start, anywhere=True)
    A, _, _, _ = system.formulas.lambdify("q2")(start["q2"] + 0.1)
    moved = symdyn.linearize(scene, start=start | {"q2": start["q2"] + 0.1}, anywhere=True)
    assert system.formulas.lambdify()()[0] == pytest.approx(system.A, rel=1e-9, abs=1e-9)
    assert np.abs(A - moved.A).max() > 1e-3
    with pytest.raises(LinearizeError, match="no formula of A, B, C, D has q9"):
        system.formulas.lambdify("q9")


def test_formulas_of_a_system_that_was_pickled_are_derived_again() -> None:
    system = symdyn.linearize(example("cart_pole"))
    assert pickle.loads(pickle.dumps(system)).formulas.A == system.formulas.A


def test_formulas_are_written_in_latex_with_what_they_define() -> None:
    text = symdyn.linearize(example("four_bar"), start={"phi": 1.23736964}, anywhere=True).formulas.latex()
    assert text.startswith(r"\begin{align*}")
    assert r"m_{\phi} &= " in text
    assert text.count("&=") == 8
