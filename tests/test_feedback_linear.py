"""Linear controllers with states in runs: against loops by hand and python-control, columns, noise, and bad ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from symdyn.errors import SimulateError
from symdyn.scene import read
from symdyn.simulation import linear_law, simulate
from symdyn.simulation.integrate import importable

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"
CART = read(EXAMPLES / "cart_pole.toml")
LEAD = (-20.0, 1.0, -1020.0, 60.0)
METHODS = [
    "dop853", "radau", "lsoda",
    *(pytest.param(name, marks=pytest.mark.skipif(not importable("sksundae"), reason="needs the extra simulate"))
      for name in ("cvode", "ida")),
]  # fmt: skip


def accelerations(x: np.ndarray, F: float) -> np.ndarray:
    """Return those of cart and pole, written by hand, from (x, theta, x_dot, theta_dot)."""
    mc, mp, length, b, g = 1.0, 0.1, 0.5, 0.1, 9.81
    c, s = np.cos(x[1]), np.sin(x[1])
    M = np.array([[mc + mp, -mp * length / 2 * c], [-mp * length / 2 * c, mp * length**2 / 3]])
    forces = [F - b * x[2] - mp * length / 2 * s * x[3] ** 2, mp * g * length / 2 * s]
    return np.linalg.solve(M, forces)


def by_hand(
    command: Callable[..., float], moved: Callable[..., list[float]], n: int, until: float = 1.0, theta: float = 0.1
) -> np.ndarray:
    """Return (x, theta, x_dot, theta_dot, z) at 101 times under F = command(t, x, z), ż = moved(t, x, z)."""

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[2:4], accelerations(x, command(t, x[:4], x[4:])), moved(t, x[:4], x[4:])])

    start = [0.0, theta, 0.0, 0.0, *(0.0,) * n]
    return solve_ivp(rates, (0, until), start, "DOP853", np.linspace(0, until, 101), rtol=1e-12, atol=1e-13).y.T


@pytest.mark.parametrize("method", METHODS)
def test_a_lead_is_the_loop_that_one_writes_by_hand(method: str) -> None:
    A, B, C, D = LEAD
    expected = by_hand(lambda t, x, z: C * z[0] - D * x[1], lambda t, x, z: [A * z[0] - B * x[1]], 1)

    run = simulate(
        CART, until=1.0, every=0.01, start={"theta": "0.1"}, feedback=linear_law(*LEAD, "theta", "F"), method=method
    )

    exact = 1e-8 if method == "dop853" else 2e-6
    found = np.column_stack([run.q, run.qd, run["controller_x1"]])
    assert np.abs(found - expected).max() < exact
    assert np.abs(run["command_F"] - (C * expected[:, 4] - D * expected[:, 1])).max() < 1e3 * exact
    assert np.array_equal(run["command_F"], run["F"])
    assert run.monitors["energy"] < 1e-6 * run.monitors["energy_scale"]


def test_a_law_of_a_point_begins_at_its_operating_point_and_follows_its_reference() -> None:
    """u0 + C z + D (r - y) of a formula of two signals, one of them led."""
    law = linear_law(
        [[-1, 2], [0, -3]], np.eye(2), [[1, -2]], [[30, 0.5]], ["x - point_tip_x", "x"], ["F"],
        y0={"x": 0.2}, u0=[0.3], reference={"x": "0.1*sin(5*t)"}, states=["p", "s"],
    )  # fmt: skip

    def error(t: float, x: np.ndarray) -> np.ndarray:
        return np.array([-0.5 * np.sin(x[1]), 0.1 * np.sin(5 * t) - x[0]])

    expected = by_hand(
        lambda t, x, z: 0.3 + float(np.dot([1, -2], z) + np.dot([30, 0.5], error(t, x))),
        lambda t, x, z: list(np.array([[-1, 2], [0, -3]]) @ z + error(t, x)),
        2,
    )
    for method in ("dop853", "radau"):
        run = simulate(CART, until=1.0, every=0.01, start={"theta": "0.1"}, feedback=law, method=method, rtol=1e-10)

        assert np.abs(np.column_stack([run.q, run.qd, run["p"], run["s"]]) - expected).max() < 1e-8
        assert np.allclose(run["reference_x"], 0.1 * np.sin(5 * run.t), atol=1e-15)


@pytest.mark.parametrize("delay", [0.0, 0.005])
def test_a_sampled_law_keeps_its_states_from_sample_to_sample(delay: float) -> None:
    """Against a loop by hand that integrates from change to change of the force."""
    A, B, C, D = 0.8, 0.01, -1020.0, 60.0
    period, x, z, F, told = 0.01, np.array([0, 0.1, 0, 0]), 0.0, 0.5, list[tuple[float, ...]]()
    for _ in range(60):
        asked = 0.5 + C * z - D * x[1]
        told.append((*x, z, asked))
        z = A * z - B * x[1]
        held, F = F, asked
        for length, force in ((delay, held), (period - delay, asked)):
            if length:
                way = solve_ivp(
                    lambda t, x, F: np.concatenate([x[2:], accelerations(x, np.clip(F, -4, 4))]), (0, length), x,
                    "DOP853", rtol=1e-12, atol=1e-13, args=(force,),
                )  # fmt: skip
                x = way.y[:, -1]
    law = linear_law(A, B, C, D, ["theta"], ["F"], period=period, u0={"F": 0.5})
    run = simulate(
        CART, until=0.6, every=period, start={"theta": "0.1"}, feedback=replace(law, delay=delay, limits={"F": 4})
    )

    found = np.column_stack([run.q, run.qd, run["controller_x1"], run["command_F"]])[:-1]
    assert np.abs(found[:, :5] - np.array(told)[:, :5]).max() < 1e-8
    assert np.abs(found[:, 5] - np.array(told)[:, 5]).max() < 1e-6
    assert {"command_F", "controller_x1"} <= set(run.held)


BAD = [
    ((np.eye(2), 1, 1, 0, "theta", "F"), {}, "B: is a number; 2 states, 1 measured signal (theta) and 1 command (F) "
     "need 2 x 1"),
    ((0, 1, [1, 2], 0, "theta", "F"), {}, "C: is 2; 1 state"),
    (([[0, 1]], 1, 1, 0, "theta", "F"), {}, "A: is 1 x 2; 1 state"),
    ((0, 1, 1, "a", "theta", "F"), {}, "D: 'a' is no matrix of real numbers"),
    ((0, 1, np.nan, 0, "theta", "F"), {}, "C: has an entry that is not finite"),
    ((0, 1, 1, 0, "theta", "F"), {"y0": {"x": 1}}, "y0: x is not among theta"),
    ((0, 1, 1, 0, "theta", "F"), {"u0": [1, 2]}, "u0: [1, 2] has 2 entries for 1: F"),
    ((0, 1, 1, 0, "theta", "F"), {"y0": "a"}, "y0: theta = 'a' is no finite number"),
    ((0, 1, 1, 0, "theta", "F"), {"states": ["a", "b"]}, "states: a, b are not 1 different names"),
    ((0, 1, 1, 0, "thta", "F"), {}, '"thta" uses thta, which is not known here; did you mean theta?'),
    ((0, 1, 1, 0, "theta_ddot", "F"), {}, "theta_ddot depends on theta_ddot, which forces make at once"),
    ((0, 1, 1, 0, "theta", "G"), {}, "feedback: inputs: G is neither a drive nor a coordinate"),
    ((0, 1, 1, 0, "theta", "F"), {"reference": {"theta": "sin(s)"}}, "uses s, which is not known here"),
    ((0, 1, 1, 0, "theta", "F"), {"reference": {"x": 1}}, "feedback: reference: x is not among theta"),
    ((0, [1, 1], 1, [1, 1], ["x", "x"], "F"), {}, "feedback: measures: x is named twice"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "more", "words"), BAD, ids=[words for *_, words in BAD])
def test_what_no_linear_law_can_be_is_told(given: tuple[object, ...], more: dict[str, object], words: str) -> None:
    with pytest.raises(SimulateError) as fault:
        simulate(CART, until=0.1, feedback=linear_law(*given, **more))  # type: ignore[arg-type]

    assert words in str(fault.value)


def test_a_law_without_states_is_gains() -> None:
    law = linear_law([], [], [], [[36, 6]], ["theta", "theta_dot"], "F", y0=[0.02, 0], u0={"F": 0.1})
    found = simulate(CART, until=0.5, start={"theta": "0.1"}, feedback=law)
    same = simulate(CART, forces="F=0.1-36*(theta-0.02)-6*theta_dot", until=0.5, start={"theta": "0.1"})

    assert np.abs(found.q - same.q).max() < 1e-8
    assert not any("controller" in name for name in found.names)


def test_references_are_of_their_signals_in_any_order() -> None:
    law = linear_law([], [], [], [[1, 10]], ["x", "theta"], "F", reference={"theta": "0.1*t", "x": "0.3*t"})
    run = simulate(CART, until=0.5, start={"theta": "0.1"}, feedback=law, method="radau")

    assert np.allclose(run["reference_theta"], 0.1 * run.t)
    assert np.allclose(run["reference_x"], 0.3 * run.t)
    assert np.allclose(run["F"], 0.3 * run.t - run["x"] + 10 * (0.1 * run.t - run["theta"]), atol=1e-12)
