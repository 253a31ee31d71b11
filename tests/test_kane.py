"""Kane's equations as a third derivation: what it does without; exercises of Kane and Levinson's Dynamics (1985)."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable

import numpy as np
import pytest
import sympy
from running import agreements
from test_formulations import group, plain
from wide import everything

import symdyn
from symdyn.dynamics import Workspace, formulations_of
from symdyn.dynamics.mechanism import kane, lagrange
from symdyn.emit.print.formulations_page import PAGES
from symdyn.scene import Scene, body, damper, load, read_text, revolute, scene, spring
from symdyn.verdict import Verdict
from symdyn.verify.certificate import on_unit_sphere
from symdyn.verify.equality import prove

# A third derivation


def verdicts(one: Scene, output: str) -> dict[str, Verdict]:
    claims = agreements(Workspace(one), [output])
    return {claim.claim: claim.verdict for claim in prove(on_unit_sphere(one, claims))[1]}


def test_every_scene_has_it_in_its_proofs() -> None:
    assert all("kane" in formulations_of("inverse_dynamics", symdyn.example(name)) for name in ("arm7", "four_bar"))
    assert "kane" in formulations_of("tree_forces", symdyn.example("rolling_disc"))


@pytest.mark.slow
def test_it_is_proved_with_every_joint_and_force_there_is() -> None:
    found = verdicts(everything(), "tree_forces")

    assert found == dict.fromkeys(("tree_forces: rnea = lagrange", "tree_forces: rnea = kane"), Verdict.PROVED)


def test_it_takes_placements_and_laws_of_force_from_others_and_nothing_else() -> None:
    taken = {
        (node.module, one.name)
        for node in ast.walk(ast.parse(inspect.getsource(kane)))
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("symdyn.dynamics")
        for one in node.names
    }
    placed = {"State", "body_placements", "vector", "joint_of"}
    laws = {"carried", "declared_forces", "joint_resistance", "load_vectors", "pull"}
    assert {name for module, name in taken if module.endswith(".state")} == placed | laws
    assert {(module, name) for module, name in taken if not module.endswith(".state")} == {
        ("symdyn.dynamics.mechanism.ropes", "Taut")
    }


ENDS = ({"body": "ground", "at": [1, 2, 0]}, {"body": "arm", "at": [0, -1, 0]})


def pulled() -> Scene:
    return scene(
        "pulled",
        bodies=[body("arm", mass=2, com=[0, "-1/2", 0], inertia=[1, 0, 1], about="com")],
        joints=[revolute("hinge", "ground", "arm", axis=[0, 0, 1])],
        springs=[spring("coil", ends=ENDS, stiffness=30)],
        dampers=[damper("oil", ends=ENDS, damping=4)],
        loads=[load("wind", body="arm", at=[0, -1, 0], force=[1, 2, 0])],
    )


@pytest.mark.parametrize(
    ("place", "name", "wrong"),
    [
        (lagrange, "generalized_forces", "lagrange"),
        (lagrange, "elastic_slopes", "lagrange"),
        (kane, "load_vectors", "kane"),
        (kane, "pull", "kane"),
    ],
)
def test_what_one_derivation_has_wrong_the_others_show(
    place: object, name: str, wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Forces of struts and loads that are doubled in one of them alone."""
    right: Callable[..., object] = getattr(place, name)

    def doubled(*given: object) -> object:
        found = right(*given)
        return [x + x for x in found] if isinstance(found, list) else found + found  # type: ignore[operator]

    monkeypatch.setattr(place, name, doubled)
    other = "kane" if wrong == "lagrange" else "lagrange"
    assert verdicts(pulled(), "inverse_dynamics") == {
        f"inverse_dynamics: rnea = {wrong}": Verdict.DIFFERENT,
        f"inverse_dynamics: rnea = {other}": Verdict.PROVED,
    }


# Exercises


def equations_of(one: Scene) -> list[sympy.Expr]:
    return [plain(row.form) for row in group(list(PAGES["kane"](one)), "Kane's equations").rows]


def lagrange_of(K: sympy.Expr, P: sympy.Expr, names: list[str]) -> list[sympy.Expr]:
    """Return ∂(K - P)/∂q - d/dt ∂K/∂q̇ of symbols q, q_dot, q_ddot."""
    q, u, a = ([sympy.Symbol(f"{name}{dots}") for name in names] for dots in ("", "_dot", "_ddot"))
    return [
        sympy.diff(K - P, x)
        - sum(sympy.diff(K, v, y) * w + sympy.diff(K, v, w) * b for y, w, b in zip(q, u, a, strict=True))
        for x, v in zip(q, u, strict=True)
    ]


ROD = """
name = "rod"
gravity = [0, 0, 0]
[parameters]
m1 = { unit = "kg", positive = true }
m2 = { unit = "kg", positive = true }
L = { unit = "m", positive = true }
[bodies]
plane = {}
slide = {}
knife = { particles = [{ mass = "m1", at = [0, 0, 0] }] }
rod = { particles = [{ mass = "m2", at = ["L", 0, 0] }] }
[joints]
shaft = { type = "revolute", parent = "ground", child = "plane", axis = [0, 1, 0], coordinate = "q0" }
x = { type = "prismatic", parent = "plane", child = "slide", axis = [1, 0, 0], coordinate = "q1" }
y = { type = "prismatic", parent = "slide", child = "knife", axis = [0, 1, 0], coordinate = "q2" }
pin = { type = "revolute", parent = "knife", child = "rod", axis = [0, 0, 1], coordinate = "q3" }
"""


def test_two_particles_on_a_rod_in_a_plane_that_turns() -> None:
    """Exercise 10.1 has K in the plane and in space: F_r + F_r* are its Lagrange's equations."""
    m1, m2, L, q1, q3 = sympy.symbols("m1 m2 L q1 q3")
    turn, x, y, z = sympy.symbols("q0_dot q1_dot q2_dot q3_dot")
    sin, cos = sympy.sin(q3), sympy.cos(q3)
    in_plane = (m1 + m2) * (x**2 + y**2) / 2 - m2 * L * (x * sin - y * cos - L * z / 2) * z
    K = in_plane + turn**2 / 2 * (m1 * q1**2 + m2 * (q1 + L * cos) ** 2)
    by_book = lagrange_of(K, sympy.Integer(0), ["q0", "q1", "q2", "q3"])

    found = equations_of(read_text(ROD))
    drives = sympy.symbols("tau1:5")
    assert [sympy.simplify(one - tau - two) for one, tau, two in zip(found, drives, by_book, strict=True)] == [0] * 4


ARM = (
    """
name = "arm"
gravity = ["-g", 0, 0]
[parameters]
g = { unit = "m/s^2", positive = true }
LA = { unit = "m" }
LB = { unit = "m" }
LP = { unit = "m" }
p3 = { unit = "m" }
"""
    + "".join(
        f'm{X} = {{ unit = "kg", positive = true }}\n'
        + "".join(f'{X}{k} = {{ unit = "kg m^2", positive = true }}\n' for k in (1, 2, 3))
        for X in "ABCD"
    )
    + """
[joints]
base = { type = "revolute", parent = "ground", child = "A", axis = [1, 0, 0], coordinate = "q1" }
elbow = { type = "revolute", parent = "A", child = "B", axis = [0, 1, 0], origin = [0, 0, "LP"], coordinate = "q2" }
slide = { type = "prismatic", parent = "B", child = "C", axis = [0, 0, 1], origin = [0, 0, "LB"], coordinate = "q3" }
grip = { type = "fixed", parent = "C", child = "D" }
"""
    + "".join(
        f'[bodies.{X}]\nmass = "m{X}"\ncom = [0, 0, {place}]\n'
        f'inertia = ["{X}1", "{X}2", "{X}3"]\ninertia_about = "com"\n'
        for X, place in (("A", '"LA"'), ("B", '"LB"'), ("C", "0"), ("D", '"p3"'))
    )
)


def test_the_arm_whose_equations_come_apart() -> None:
    """Exercise 11.8: D* on the line B*C* and principal axes along it leave X_11, X_22 and X_33 alone."""
    LA, LB, LP, p3, g, q2, q3 = sympy.symbols("LA LB LP p3 g q2 q3")
    m, turning = ({X: sympy.symbols(name.format(X)) for X in "ABCD"} for name in ("m{}", "{}1:4"))
    u1, u2, u3 = sympy.symbols("q1_dot q2_dot q3_dot")
    sin, cos, out = sympy.sin(q2), sympy.cos(q2), {"B": LB, "C": LB + q3, "D": LB + q3 + p3}
    X11 = turning["A"][0] + m["A"] * LA**2 + sum(
        turning[X][0] * cos**2 + turning[X][2] * sin**2 + m[X] * (LP + way * cos) ** 2 for X, way in out.items()
    )  # fmt: skip
    X22 = sum(turning[X][1] + m[X] * way**2 for X, way in out.items())
    K = (X11 * u1**2 + X22 * u2**2 + (m["C"] + m["D"]) * u3**2) / 2
    P = g * sin * sum(m[X] * way for X, way in out.items())
    by_book = lagrange_of(K, P, ["q1", "q2", "q3"])

    found, drives = equations_of(read_text(ARM)), sympy.symbols("tau1:4")
    assert [sympy.simplify(one - tau - two) for one, tau, two in zip(found, drives, by_book, strict=True)] == [0] * 3
    X = sympy.Matrix(found).jacobian(sympy.symbols("q1_ddot q2_ddot q3_ddot"))
    assert X.is_diagonal()


def test_the_energy_of_a_disc_that_rolls() -> None:
    """Exercise 10.2: K = m R² (5 u_1² + u_2² + 6 u_3²) / 8, u_1 along the track, u_2 up the disc, u_3 its spin."""
    disc, (m, radius) = symdyn.example("rolling_disc"), (1, 0.3)
    for turn in ([1.0, 0.0, 0.0, 0.0], [0.8, 0.36, 0.48, 0.0], [0.5, -0.5, 0.1, 0.7]):
        q, w = np.array([0.2, -0.1, 0.25, *np.divide(turn, np.linalg.norm(turn))]), np.array([0.7, -1.1, 0.4])
        R = np.array(symdyn.lambdify(disc, "pose:disc")(q))[:, :3]
        along = np.cross([0, 0, 1], R[:, 1])
        along = R.T @ along / np.linalg.norm(along)
        up = np.cross([0, 1, 0], along) * np.sign(np.cross([0, 1, 0], along) @ R[2])
        K = m * radius**2 * (5 * (along @ w) ** 2 + (up @ w) ** 2 + 6 * w[1] ** 2) / 8

        rolls = np.concatenate([np.cross(w, radius * up), w])
        assert symdyn.lambdify(disc, "constraint_jacobian")(q) @ rolls == pytest.approx([0] * 3, abs=1e-14)
        assert float(symdyn.lambdify(disc, "kinetic_energy")(q, rolls)) == pytest.approx(K, rel=1e-13)
