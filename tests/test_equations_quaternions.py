"""Equations of bodies that turn by quaternions, in quasi-velocities: against forward dynamics, and against books."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from test_formulations import group, number, plain, values_of

import symdyn
from symdyn.emit.print import Printable, printed_text
from symdyn.emit.print.formulations_page import PAGES
from symdyn.scene import Scene, bind, read_text
from symdyn.scene.values import acceleration_name

EULER = """
name = "euler"
gravity = [0, 0, "-g"]
[parameters]
A = { unit = "kg m^2", positive = true }
B = { unit = "kg m^2", positive = true }
C = { unit = "kg m^2", positive = true }
m = { unit = "kg", positive = true }
g = { unit = "m/s^2", positive = true }
l = { unit = "m", positive = true }
[bodies.top]
mass = "m"
com = [0, 0, "l"]
inertia = ["A", "B", "C"]
inertia_about = "frame"
[joints.point]
type = "spherical"
parent = "ground"
child = "top"
drive = false
"""
"""Of a body about a fixed point."""

BALL = """
name = "ball"
gravity = [0.3, 0, -9.81]
[parameters]
m = 1.2
[bodies.base]
mass = "m"
com = [0.1, 0.2, 0]
inertia = { xx = 0.3, yy = 0.4, zz = 0.5, xy = 0.05, xz = 0, yz = 0 }
inertia_about = "com"
[bodies.arm]
particles = [{ mass = 0.4, at = [0.1, 0, 0.2] }]
[joints.point]
type = "spherical"
parent = "ground"
child = "base"
armature = 0.2
damping = 0.05
[joints.elbow]
type = "revolute"
parent = "base"
child = "arm"
axis = [0, 1, 0]
origin = [0, 0.4, 0]
damping = 0.1
drive = "M"
[loads.wind]
body = "base"
at = [0, 0.1, 0]
force = [0.5, 0, 0.2]
couple = [0, 0.1, 0]
[loads.jet]
body = "arm"
at = [0, 0, 0.1]
force = [0, 0.6, 0]
frame = "body"
"""

SCENES = {"euler": EULER, "ball": BALL}


def scene_of(name: str) -> Scene:
    scene = read_text(SCENES[name]) if name in SCENES else symdyn.example(name)
    numbers = {one.name: f"1.{3 + k}" for k, one in enumerate(scene.free_parameters)}
    return bind(scene, numbers | ({"l": "0.3"} if name == "euler" else {}))


def motion(scene: Scene) -> tuple[dict[str, float], list[list[float]]]:
    """Return values of all letters along a motion; and q, u, tau, its accelerations."""
    drawn = np.random.default_rng(7)
    q, u = drawn.uniform(-1, 1, len(scene.coordinates)), drawn.uniform(-1, 1, len(scene.velocities))
    for joint in scene.moving:
        if joint.velocities:
            places = [scene.coordinates.index(one) for one in joint.coordinates[-4:]]
            q[places] /= np.linalg.norm(q[places])
    tau = [drawn.uniform(-1, 1) if drive else 0.0 for drive in scene.drives]
    a = symdyn.lambdify(scene, "forward_dynamics")(q, u, tau)
    more = {drive: x for drive, x in zip(scene.drives, tau, strict=True) if drive}
    more |= {acceleration_name(name): float(x) for name, x in zip(scene.velocities, a, strict=True)}
    return values_of(scene, q.tolist(), u.tolist(), more), [q.tolist(), u.tolist(), tau, a.tolist()]


@pytest.mark.heavy("ball")
@pytest.mark.parametrize("name", ["heavy_top", "free_body", "euler", "ball"])
def test_every_page_holds_along_a_motion(name: str) -> None:
    scene = scene_of(name)
    values, (q, u, *_) = motion(scene)
    page = Printable.of(scene)
    values |= {letter: number(form, values) for letter, form in page.definitions}
    for i in range(len(u)):
        assert number(page.left(i), values) == pytest.approx(number(page.driving(i), values), abs=1e-9)
    for rate, form in page.rates:
        known = dict(zip(scene.coordinates, symdyn.lambdify(scene, "coordinate_rates")(q, u), strict=True))
        assert number(form, values) == pytest.approx(known[rate.removesuffix("_dot")], abs=1e-12)
    for formulation in ("kane", "gibbs-appell"):
        for row in list(PAGES[formulation](scene))[-1].rows:
            assert number(row.form, values) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("name", ["heavy_top", "free_body", "euler", "ball"])
def test_canonical_equations_have_the_terms_of_lie_and_poisson(name: str) -> None:
    scene = scene_of(name)
    values, (q, u, tau, _) = motion(scene)
    groups = list(PAGES["port-hamiltonian"](scene))
    p = {row.name: number(row.form, values) for row in group(groups, "Momenta").rows}
    rates = symdyn.lambdify(scene, "canonical_rates")(q, list(p.values()), tau)

    assert list(p.values()) == pytest.approx(symdyn.lambdify(scene, "momentum")(q, u), abs=1e-12)
    told = dict(zip([*scene.velocities, *(f"{one}_dot" for one in p)], rates, strict=True))
    for row in group(groups, "Canonical equations").rows:
        assert number(row.form, values | p) == pytest.approx(told[row.name], rel=1e-9, abs=1e-9)

    (power,) = group(groups, "Power").rows
    slopes = np.ravel(symdyn.lambdify(scene, "hamiltonian_derivatives")(q, list(p.values())))
    change = slopes @ [*u, *rates[len(u) :]]
    assert number(power.form, values | p) == pytest.approx(change, rel=1e-9, abs=1e-9)


def test_the_structure_of_a_body_in_flight_is_that_of_its_momenta() -> None:
    """J of what flies is [0, p×; p×, l×]; of a body about a point l× alone."""
    rows = group(list(PAGES["port-hamiltonian"](symdyn.example("free_body"))), "Structure").rows
    of_p = {"J15": "-p3", "J16": "p2", "J24": "p3", "J26": "-p1", "J34": "-p2", "J35": "p1"}

    assert {row.name: str(row.form.to_sympy()) for row in rows} == of_p | {"J45": "-p6", "J46": "p5", "J56": "-p4"}


def test_eulers_equations_are_a_handful_of_lines_in_every_formulation() -> None:
    """A ω̇_x + (C - B) ω_y ω_z and its like, and the weight; momenta as in Marsden and Ratiu, 1.4."""
    scene = read_text(EULER)
    A, B, C, x, y, z = sympy.symbols("A B C point_wx point_wy point_wz")
    rates = sympy.symbols("point_wx_dot point_wy_dot point_wz_dot")
    m, g, arm, q0, q1, q2, q3 = sympy.symbols("m g l q1 q2 q3 q4")
    weight = [-2 * m * g * arm * (q0 * q1 + q2 * q3), 2 * m * g * arm * (q1 * q3 - q0 * q2), 0]
    euler = [A * rates[0] + (C - B) * y * z, B * rates[1] + (A - C) * z * x, C * rates[2] + (B - A) * x * y]
    page = Printable.of(scene)
    for i in range(3):
        assert sympy.expand(plain(page.left(i)) - euler[i] - weight[i]) == 0
    for row, one, k in zip(list(PAGES["kane"](scene))[-1].rows, euler, weight, strict=True):
        assert sympy.expand(plain(row.form) + one + k) == 0

    p1, p2, p3 = sympy.symbols("p1 p2 p3")
    found = {row.name: plain(row.form) for row in group(list(PAGES["hamilton"](scene)), "Canonical equations").rows}
    turned = [p2 * p3 * (1 / C - 1 / B), p3 * p1 * (1 / A - 1 / C), p1 * p2 * (1 / B - 1 / A)]
    for k, (one, w) in enumerate(zip(turned, weight, strict=True), 1):
        assert sympy.simplify(found[f"p{k}_dot"] - one + w) == 0
    for formulation in ("lagrange", "hamilton", "kane", "gibbs-appell", "port-hamiltonian"):
        assert len(printed_text(scene, "text", formulation=formulation).splitlines()) < 45


WHEEL = EULER.replace(
    "[joints.point]", '[bodies.wheel]\ninertia = ["W", "W", "W"]\ninertia_about = "frame"\n[joints.point]'
) + (
    '[joints.spin]\ntype = "revolute"\nparent = "top"\nchild = "wheel"\naxis = [0, 1, 0]\ncoordinate = "s"\n'
    "drive = false\n"
)


def test_routhian_of_a_body_with_a_wheel_is_that_of_a_gyrostat() -> None:
    """What is left after the wheel's momentum p is Euler's equations with p × ω (Gray 1918, Wittenburg 2008, 5.3)."""
    scene = read_text(WHEEL.replace("[parameters]", '[parameters]\nW = { unit = "kg m^2", positive = true }'))
    groups = list(PAGES["routh"](scene))
    assert [row.name for row in group(groups, "Constant momenta").rows] == ["p4"]
    p, W, A, B, C, x, y, z = sympy.symbols("p4 W A B C point_wx point_wy point_wz")
    rates = sympy.symbols("point_wx_dot point_wy_dot point_wz_dot")
    h = [(A + W) * x, B * y + p, (C + W) * z]  # the wheel turns about y alone
    turned = [y * h[2] - z * h[1], z * h[0] - x * h[2], x * h[1] - y * h[0]]
    for row, k in zip(group(groups, "Equations that are left").rows, range(3), strict=True):
        inertia = (A + W, B, C + W)[k]
        weightless = plain(row.form).subs("g", 0)
        assert sympy.simplify(weightless - inertia * rates[k] - turned[k]) == 0


def test_matrices_of_sympy_move_as_a_run_does() -> None:
    """x = [q; u], q̇ = H u; C is skew where M does not change; velocities of a ball are functions of their own."""
    equations = symdyn.equations(symdyn.example("heavy_top")).sympy()
    x, f = equations.state_space()
    start = [np.sqrt(0.5), np.sqrt(0.5), 0, 0, 0.3, 2.0, -1.0]
    found = equations.lambdify()(0.0, start)

    assert sympy.simplify(equations.C + equations.C.T) == sympy.zeros(3)
    assert sympy.simplify(equations.C * equations.qd - equations.c) == sympy.zeros(3, 1)
    assert found == pytest.approx([float(one) for one in f.subs(dict(zip(x, start, strict=True)))], abs=1e-14)
    a = symdyn.lambdify(symdyn.example("heavy_top"), "forward_dynamics")(start[:4], start[4:], [0, 0, 0])
    assert found[4:] == pytest.approx(a, rel=1e-12)
    moving = symdyn.equations(symdyn.example("heavy_top")).sympy(dynamic=True)
    assert str(moving.qd[0]) == "point_wx(t)"
    assert str(moving.rates[0]).startswith("-e1(t)*point_wx(t)/2")


@pytest.mark.long
def test_udwadia_and_kalaba_with_balls_in_a_loop() -> None:
    scene = symdyn.example("rssr")
    w = symdyn.dynamics.Workspace(scene)
    q = np.asarray(w.loops.decisions.assembly.q, float)
    u = np.asarray(symdyn.lambdify(scene, "velocities")(q, [0.7, 0.2]), float)
    tau = [0.3 if drive else 0.0 for drive in scene.drives]
    more = {drive: 0.3 for drive in scene.drives if drive}
    at = bind(scene, {one.name: "1.3" for one in scene.free_parameters})
    values, n = values_of(at, q.tolist(), u.tolist(), more), range(len(u))
    rows = {row.name: number(row.form, values) for one in PAGES["udwadia-kalaba"](at) for row in one.rows}
    M = np.array([[rows.get(f"M_cal{min(i, j) + 1}{max(i, j) + 1}", 0) for j in n] for i in n])
    Q = np.array([rows.get(f"Q{i + 1}", 0) for i in n])
    Q_c = symdyn.lambdify(at, "constraint_forces")(q, u, tau)
    a = symdyn.lambdify(at, "forward_dynamics")(q, u, tau)
    A = np.array([[rows.get(f"A{k + 1}{i + 1}", 0) for i in n] for k in range(len(n) - 2)])

    assert M @ a == pytest.approx(Q + Q_c, abs=1e-9)
    assert A @ a == pytest.approx([rows.get(f"b{k + 1}", 0) for k in range(len(A))], abs=1e-9)
