"""SymPy's LagrangesMethod as an independent witness: other software, other authors, the same scenes read from pictures.

Positions and angular velocities are written by hand for SymPy; nothing of symdyn's kinematics is used.
"""

from __future__ import annotations

import random

import pytest
import sympy as sp
from arms import cart_pole, spatial_arm, two_link
from oracles import BIG
from running import call, random_fractions
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from symdyn.dynamics import derive, formulations_of

T = dynamicsymbols._t
DIGITS = 45


def rates(entries):
    return sp.Matrix(entries).diff(T)


def point_mass(m, r):
    v = rates(r)
    return m * v.dot(v) / 2


def two_link_lagrangian(q, p):
    q1, q2 = q
    r1 = sp.Matrix([p["h1"] * sp.sin(q1), -p["h1"] * sp.cos(q1)])
    r2 = r1 + sp.Matrix([p["h2"] * sp.sin(q1 + q2), -p["h2"] * sp.cos(q1 + q2)])
    K = point_mass(p["m1"], r1) + point_mass(p["m2"], r2)
    return K - p["g"] * (p["m1"] * r1[1] + p["m2"] * r2[1])


def cart_pole_lagrangian(q, p):
    x, phi = q
    bob = sp.Matrix([x + p["l"] * sp.sin(phi), -p["l"] * sp.cos(phi)])
    K = p["mc"] * x.diff(T) ** 2 / 2 + point_mass(p["mp"], bob) + p["I"] * phi.diff(T) ** 2 / 2
    return K - p["mp"] * p["g"] * bob[1]


def spatial_arm_lagrangian(q, p):
    """Turn about z; tilt about (0, 3, 4)/5 through (a, 0, 1/2); reach along the tilted x."""
    turn, tilt, reach = q
    R1 = sp.Matrix([[sp.cos(turn), -sp.sin(turn), 0], [sp.sin(turn), sp.cos(turn), 0], [0, 0, 1]])
    e = sp.Matrix([0, sp.Rational(3, 5), sp.Rational(4, 5)])
    across = sp.Matrix([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    R2 = R1 * (sp.eye(3) + sp.sin(tilt) * across + (1 - sp.cos(tilt)) * across * across)
    elbow = R1 * sp.Matrix([p["a"], 0, sp.Rational(1, 2)])
    slide = elbow + R2 * sp.Matrix([reach, sp.Rational(1, 4), 0])
    inertia = sp.Matrix([[20, 1, -2], [1, 30, sp.Rational(5, 2)], [-2, sp.Rational(5, 2), 25]]) / 10
    w1 = sp.Matrix([0, 0, turn.diff(T)])  # in link 1
    w2 = R2.T * R1 * w1 + e * tilt.diff(T)  # in links 2 and 3
    centres = {
        "m1": R1 * sp.Matrix([1, -2, 3]) / 10,
        "m2": elbow + R2 * sp.Matrix([sp.Rational(1, 2), sp.Rational(1, 7), 0]),
        "m3": slide + R2 * sp.Matrix([0, sp.Rational(1, 9), sp.Rational(1, 3)]),
    }
    spin = (w1.dot(inertia * w1) + 2 * w2.dot(inertia * w2)) / 2
    K = sum((point_mass(p[m], r) for m, r in centres.items()), spin)
    return K - p["g"] * sum(p[m] * r[2] for m, r in centres.items())


WITNESSES = {
    "two_link": (two_link(), two_link_lagrangian),
    "cart_pole": (cart_pole(), cart_pole_lagrangian),
    "spatial_arm": (spatial_arm(), spatial_arm_lagrangian),
}


@pytest.fixture(scope="module", params=["two_link", "cart_pole", pytest.param("spatial_arm", marks=pytest.mark.slow)])
def witness(request):
    """Return a scene, a state in rationals, and SymPy's M and right-hand side there."""
    one, lagrangian = WITNESSES[request.param]
    rng, n = random.Random(request.param), len(one.coordinates)
    state = {name: random_fractions(rng, n) for name in ("q", "qd", "qdd", "tau")}
    state["params"] = [abs(x) for x in random_fractions(rng, len(one.free_parameters))]
    q = dynamicsymbols(f"q1:{n + 1}")
    names = {p.name: sp.Symbol(p.name) for p in one.free_parameters}
    method = LagrangesMethod(lagrangian(q, names), q)
    method.form_lagranges_equations()
    values = dict(zip([x.diff(T) for x in q], map(rational, state["qd"]), strict=True))
    values |= dict(zip(q, map(rational, state["q"]), strict=True))
    values |= dict(zip(names.values(), map(rational, state["params"]), strict=True))
    M, force = (numeric(side, values) for side in (method.mass_matrix, method.forcing))
    return one, {name: [BIG.constant(x) for x in entries] for name, entries in state.items()}, M, force


def rational(x):
    return sp.Rational(x.numerator, x.denominator)


def numeric(entries, values):
    """Return SymPy's entries as big floats; velocities are replaced before coordinates."""
    return [BIG.number(str(sp.N(entry.subs(values), DIGITS))) for entry in entries]


def close(found, expected):
    scale = max(abs(x) for x in expected)
    return all(abs(a - b) < 1e-38 * scale for a, b in zip(found, expected, strict=True))


@pytest.mark.wide(3)
@pytest.mark.long(0)
@pytest.mark.parametrize("formulation", formulations_of("mass_matrix"))
def test_mass_matrix_is_what_sympy_finds(witness, formulation):
    one, state, M, _ = witness

    assert close(call(derive(one, ["mass_matrix"], formulation), "mass_matrix", BIG, **state), M)


@pytest.mark.long(0)
@pytest.mark.parametrize("formulation", formulations_of("inverse_dynamics"))
def test_driving_forces_are_what_sympy_finds(witness, formulation):
    one, state, M, force = witness
    n = len(force)
    expected = [sum(M[n * i + j] * state["qdd"][j] for j in range(n)) - force[i] for i in range(n)]

    assert close(call(derive(one, ["inverse_dynamics"], formulation), "inverse_dynamics", BIG, **state), expected)


@pytest.mark.long(0)
@pytest.mark.parametrize("formulation", formulations_of("forward_dynamics"))
def test_accelerations_solve_sympys_equations(witness, formulation):
    one, state, M, force = witness
    n = len(force)
    qdd = call(derive(one, ["forward_dynamics"], formulation), "forward_dynamics", BIG, **state)

    reached = [sum(M[n * i + j] * qdd[j] for j in range(n)) for i in range(n)]

    assert close(reached, [f + t for f, t in zip(force, state["tau"], strict=True)])
