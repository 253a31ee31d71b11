"""Computed motions against motions that others computed in higher precision, and against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from closed_mechanisms import n_four_bar
from oracles import oracle
from scenes_in_time import double_pendulum, free_top, heavy_top, pendulum

from symdyn.bench.stress.scenes import pinned
from symdyn.simulation import Trajectory, inverse, read_motion, simulate
from symdyn.simulation.equations.written import state_equations

pytestmark = pytest.mark.runs()

EPS = 2.3e-16


@pytest.fixture(autouse=True)
def _heyoka() -> None:
    pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")


def at(trajectory: Trajectory, time: str) -> int:
    k = int(np.argmin(np.abs(trajectory.t - float(time))))
    assert abs(trajectory.t[k] - float(time)) < 1e-12
    return k


@pytest.mark.parametrize(("case", "start"), [("dp0", ("pi/2", "pi/2")), ("dp1", ("3", "2.5")), ("dp2", ("0.5", "1"))])
def test_double_pendulum_keeps_all_digits_that_its_growth_of_error_leaves(case: str, start: tuple[str, str]) -> None:
    a, b = start
    run = {"until": 10.0, "method": "taylor", "rtol": EPS, "every": 1.0}
    found = simulate(double_pendulum(), start={"q1": a, "q2": f"{b} - ({a})"}, **run)  # type: ignore[arg-type]
    moved = simulate(double_pendulum(), start={"q1": f"{a} + 1e-10", "q2": f"{b} - ({a})"}, **run)  # type: ignore[arg-type]
    rows = [row for row in oracle("double_pendulum")["data"][case] if float(row["t"]) == 10]
    given = np.array([float(x) for x in rows[0]["abs_angles_and_rates"]])

    ours = np.array([found.q[-1, 0], found.q[-1].sum(), found.qd[-1, 0], found.qd[-1].sum()])
    growth = max(1.0, float(np.abs(moved.q - found.q).max()) / 1e-10)

    assert np.abs(ours - given).max() < 50 * growth * 2.2e-16
    assert found.monitors["energy"] < 1e-14 * found.monitors["energy_scale"]


@pytest.mark.parametrize(("method", "rtol", "error"), [("taylor", EPS, 1e-12), ("dop853", 1e-13, 1e-10)])
def test_heavy_top(method: str, rtol: float, error: float) -> None:
    found = simulate(heavy_top(), until=2.0, method=method, rtol=rtol, every=0.1)

    for row in oracle("heavy_top")["rows"]:
        k = at(found, row["t"])
        w, x, y, z = found.q[k]
        com = [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)]
        assert np.abs(np.array(com) - [float(one) for one in row["com"]]).max() < error
        assert np.abs(found.qd[k] - [float(one) for one in row["omega_body"]]).max() < error
    assert found.monitors["momenta"] < 1e-9
    assert "momentum_ball_Lz" in found.extra
    assert "momentum_ball_Lx" not in found.extra


def test_free_top_keeps_its_invariants_through_the_flips() -> None:
    found = simulate(free_top(), until=10.0, method="taylor", rtol=EPS, every=0.5)
    given = oracle("free_top_dzhanibekov")
    moments, w = np.array([1.0, 2.0, 3.0]), found.qd[:, 3:]

    for name, power in (("twoT", 1), ("H2", 2)):
        invariant = float(given["invariants"][name])
        assert np.abs((moments**power * w * w).sum(axis=1) - invariant).max() < 1e-13 * invariant
    for row in given["rows"][:2]:  # errors grow as exp(5.8 t) at the start
        assert np.abs(w[at(found, row["t"])] - [float(x) for x in row["w"]]).max() < 1e-9
    assert found.monitors["momenta"] < 1e-12
    assert {"momentum_body_Px", "momentum_body_Lz"} <= set(found.extra)


def test_pendulum_of_iftomm_a01() -> None:
    found = simulate(pendulum(), until=10.0, method="taylor", rtol=EPS, every=0.01)

    for row in oracle("iftomm_closed_form")["A01"]["rows"]:
        if float(row["t"]) <= 10:
            k = at(found, row["t"])
            assert abs(found.q[k, 0] - float(row["phi"])) < 2e-14
            assert abs(found.qd[k, 0] - float(row["phid"])) < 2e-14


@pytest.mark.parametrize("rtol", [1e-8, 1e-11, 1e-14])
def test_a_pendulum_of_a_free_body_and_a_pin_passes_where_its_independent_velocity_fails(rtol: float) -> None:
    """Its height is independent, and stands still at the lowest point: finer tolerances once met that more closely."""
    row = next(row for row in oracle("iftomm_closed_form")["A01"]["rows"] if row["t"] == "10")
    found = simulate(pinned(), until=10.0, method="dop853", rtol=rtol)

    assert state_equations(pinned()).dependent == (0, 2)
    assert np.abs(found.q[-1, :2] - [float(row["x_start_plus1"]), float(row["y"])]).max() < 100 * rtol + 1e-11
    assert found.monitors["energy"] < 200 * rtol + 1e-11
    assert found.monitors["loops"] < 0.05 * rtol + 1e-13
    inward = found.q[:, :2] * (found.qd[:, :2] ** 2).sum(axis=1)[:, None]
    assert np.abs(found.qdd[:, :2] + inward - _pull(found)).max() < 1e-4


def _pull(found: Trajectory) -> np.ndarray:
    """Return gravity's part along the circle."""
    along = np.stack([-found.q[:, 1], found.q[:, 0]], axis=1)
    return -9.81 * found.q[:, :1] * along


def test_the_motion_of_iftomm_a01_takes_no_force() -> None:
    """The inverse direction: the exact motion at each of its times, φ̈ = -g sin φ, is free."""
    for row in oracle("iftomm_closed_form")["A01"]["rows"]:
        phi, rate = float(row["phi"]), float(row["phid"])
        law = f"{phi!r} + {rate!r}*(t - 1) + {-9.81 * np.sin(phi) / 2!r}*(t - 1)**2".replace("np.float64", "")
        found = inverse(pendulum(), read_motion(pendulum(), [f"q1={law}"]), [1.0])

        assert abs(found.tau[0, 0]) < 1e-14 * 9.81 * 10
        assert abs(found.qd[0, 0] - rate) < 1e-14


def test_a_driven_motion_of_iftomm_a01_takes_what_the_formula_says() -> None:
    """m L² φ̈ + m g L sin φ along twice the amplitude of the exact motion, which is not free any more."""
    times = np.linspace(0, 2, 41)
    found = inverse(pendulum(), read_motion(pendulum(), ["q1=pi*cos(3*t)"]), times)
    phi = np.pi * np.cos(3 * times)

    assert found.tau[:, 0] == pytest.approx(-9 * phi + 9.81 * np.sin(phi), abs=1e-12)


def test_parallelogram_of_iftomm_a02_passes_its_change_points_on_the_right_branch() -> None:
    scene = n_four_bar(2)
    rates = {velocity: "-1" if velocity.startswith("q_A") else "1" for velocity in scene.velocities}
    found = simulate(scene, until=4.0, start_rates=rates, method="dop853", rtol=1e-10, every=0.5)

    for row in oracle("iftomm_closed_form")["A02_N2"]["rows"][:3]:
        k = at(found, row["t"])
        assert abs(np.cos(found.q[k, 0]) - float(row["B0x"])) < 2e-8
        assert abs(np.sin(found.q[k, 0]) - float(row["B0y"])) < 2e-8
