"""Optimal control of mechanisms with states of their own: a motor whose voltage is found over time.

Without gravity the motor is linear, and the least ∫V² from rest to rest is that of the Gramian of controllability,
which SciPy's matrix exponential gives (Lewis, Vrabie, Syrmos, Optimal Control, 2012, section 3.3).
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import symdyn
from symdyn.errors import SimulateError
from symdyn.scene import Scene, read_text
from symdyn.transcription import METHODS, Collocation, Solution, along
from symdyn.transcription.solution import lagrangian

J, b, k, R, L = 0.045, 0.002, 0.08, 1.2, 0.1
T, TURN = 0.8, 1.5

MOTOR = f"""
name = "motor"
gravity = "none"
[parameters]
k = {{ value = {k}, unit = "N m/A" }}
L = {{ value = {L}, unit = "H" }}
[inputs.V]
value = 2
unit = "V"
[signals]
back = "k*theta_dot"
[states.i]
rate = "(V - {R}*i - back)/L"
unit = "A"
[bodies.rotor]
inertia = [0, 0, {J}]
inertia_about = "com"
allow_invalid_inertia = true
[joints.shaft]
type = "revolute"
parent = "ground"
child = "rotor"
axis = [0, 0, 1]
coordinate = "theta"
drive = false
damping = {b}
force = "k*i"
"""


def turned(scene: Scene, intervals: int, method: str = "hermite_simpson") -> Collocation:
    return symdyn.collocation(
        scene, T, intervals, method, cost="V**2", free="V", end={"theta": TURN, "i": 0}, end_rates={"theta": 0}
    )


def solved(problem: Collocation) -> Solution:
    """Return the optimum of linear equations and a cost of squares: one linear solve (Karush, Kuhn, Tucker)."""
    z, of = np.where(problem.given, problem.lower, 0.0), lagrangian(problem)
    free, rows = ~problem.given, problem.binding
    H = np.zeros((problem.size, problem.size))
    H[of.rows, of.columns] = H[of.columns, of.rows] = of.values(z, 1.0, np.zeros(problem.rows))
    A = problem.jacobian(z).toarray()[rows][:, free]
    right = -np.concatenate([problem.gradient(z)[free], problem.residual(z)[rows]])
    whole = np.block([[H[free][:, free], A.T], [A, np.zeros((len(A), len(A)))]])
    z[free] += np.linalg.solve(whole, right)[: int(free.sum())]
    return Solution(problem, z, np.zeros(problem.rows), problem.objective(z), 0.0, True, "", 0, 0.0)


def least() -> float:
    """Return the least ∫V²: x·W⁻¹x, W from the exponential of van Loan's matrix."""
    A = np.array([[0, 1, 0], [0, -b / J, k / J], [0, -k / L, -R / L]])
    B = np.array([[0], [0], [1 / L]])
    grown = expm(np.block([[-A, B @ B.T], [np.zeros((3, 3)), A.T]]) * T)
    W = grown[3:, 3:].T @ grown[:3, 3:]
    x = np.array([TURN, 0, 0])
    return float(x @ np.linalg.solve(W, x))


@pytest.fixture(scope="module")
def motor() -> Scene:
    return read_text(MOTOR, "motor.toml")


@pytest.mark.runs("cc")
@pytest.mark.parametrize("method", METHODS)
def test_the_least_voltage_is_that_of_the_gramian(motor: Scene, method: str) -> None:
    errors = [abs(solved(turned(motor, count, method)).objective / least() - 1) for count in (10, 20)]

    assert errors[1] < {2: 0.05, 4: 6e-6}[METHODS[method].order]
    assert np.log2(errors[0] / errors[1]) > METHODS[method].order - 0.3


@pytest.mark.runs("cc")
def test_a_run_with_the_voltage_that_was_found_repeats_the_motion(motor: Scene) -> None:
    found = solved(turned(motor, 40))
    again, given = found.simulated(rtol=1e-10, every=T / 80), symdyn.simulate(motor, forces=found.run, until=T)

    assert found.run.names[-2:] == ("V", "i")
    for run in (again, given):
        assert run["theta"][-1] == pytest.approx(TURN, abs=1e-6)
        assert (run["theta_dot"][-1], run["i"][-1]) == pytest.approx((0, 0), abs=2e-4)
    np.testing.assert_allclose(again["i"], found.run["i"], atol=3e-4)
    np.testing.assert_allclose(along(found.problem, again), found.z, atol=0.02)


@pytest.mark.runs("cc")
def test_a_voltage_begins_as_the_scene_has_it_and_keeps_within_bounds(motor: Scene) -> None:
    problem = symdyn.collocation(
        motor, T, 4, cost="back*i - 2*V*i", free=("V", "L"), start={"i": 0.5}, end={"i": "1500 mA"},
        bounds={"V": (-24, 24), "i": (None, 3), "L": (0.05, 0.2)}, path={"back": (0, 1)},
    )  # fmt: skip
    force, i = problem.place["force"], problem.place["s"][:, 0]

    assert (problem.free, problem.drives, problem.notes) == (("L",), ("V",), ())
    assert set(problem.guess[force].flat) == {2.0}
    assert (set(problem.lower[force].flat), set(problem.upper[force].flat)) == ({-24.0}, {24.0})
    np.testing.assert_allclose(problem.guess[i], np.linspace(0.5, 1.5, len(i)))
    assert problem.upper[i].tolist() == [0.5, *[3.0] * (len(i) - 2), 1.5]
    assert np.isfinite(problem.residual(problem.guess)).all()


RESET = MOTOR.replace("[bodies.rotor]", '[states.i.reset]\nwhen = "theta"\nto = "0"\n[bodies.rotor]')
RATED = MOTOR.replace("value = 2", "value = 2\nrates = 1").replace(
    "- back)", "- back - 0.1*V_dot*1s)".replace("1s", "1")
)


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("text", "given", "told"),
    [
        (MOTOR, {"cost": "V**2"}, 'cost: "V**2" uses V, which is not known here; known are t, theta, theta_dot, i, k, '
            "L, back, theta_ddot, and no inputs, V: they keep their values; what is to be found are drives, and inputs "
            'that are free: free="V"'),
        (MOTOR, {"free": "W"}, "free: W is not known; known are k, L, V"),
        (MOTOR, {"bounds": {"V": (0, 1)}}, "bounds: V is not known; known are theta, i, theta_dot, theta_ddot"),
        (MOTOR, {"bounds": {"i": (1, 2)}}, "start: i = 0 is beyond its bounds 1 … 2"),
        (MOTOR, {"end": {"j": 1}}, "end: j is not known; known are theta, i"),
        (MOTOR, {"end": {"i": "1 V"}}, "end: i: 1 V is in V, and A is asked for"),
        (MOTOR, {"end_rates": {"i": 1}}, "end rates: i is not known; known are theta_dot"),
        (MOTOR, {"cost": "i + back"}, "cost: i + k*theta_dot: i is in A, and k*theta_dot is in V; correct it, "
            'write the factor that is left out as a parameter with its unit, or write units = "none" at the top of the '
            "scene"),
        (RESET, {}, "motor: collocation knows no resets, and there is one of i: where a state jumps has to be known "
            "beforehand; take it out, or solve from jump to jump, each with its own start"),
        (RATED, {"free": "V"}, "free: V: an input with rates follows from its rates; declare it as a state with its "
            'rate as an input, such as [states.x] rate = "v", and let v be free'),
        (MOTOR.replace(f"value = {L}", 'value = "7*k"'), {"free": "L"}, "free: L is derived, L = 7*k; give k"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_is_told(text: str, given: dict[str, Any], told: str) -> None:
    with pytest.raises(SimulateError, match=f"^{re.escape(told)}$"):
        symdyn.collocation(read_text(text, "motor.toml"), 1, 2, **given)


@pytest.mark.runs("cc")
def test_ipopt_finds_the_same(motor: Scene) -> None:
    pytest.importorskip("casadi")
    problem = turned(motor, 10)
    np.testing.assert_allclose(problem.solve(tol=1e-10).z, solved(problem).z, atol=1e-6)
