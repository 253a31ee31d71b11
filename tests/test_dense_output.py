"""A run between its rows: as exact as these, under the forces that acted, and refused where nothing is known."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.errors import SimulateError
from symdyn.scene import read
from symdyn.simulation import Feedback, Trajectory, inverse, linear_law, simulate

EXAMPLES = Path(__file__).parents[1] / "examples"
ARM = EXAMPLES / "cart_pole.toml"
BETWEEN = np.linspace(0.0, 2.0, 257)


def pushed(method: str | None = None, rtol: float | None = None, **more: object) -> Trajectory:
    return simulate(ARM, forces="F=0.5*cos(3*t)", until=2.0, start="theta=0.2", method=method, rtol=rtol, **more)


@pytest.fixture(scope="module")
def truth() -> Trajectory:
    """Every time that is asked for is a row of its own."""
    return pushed("dop853", 1e-13, every=2.0 / 256)


@pytest.mark.runs("cc")
@pytest.mark.parametrize("method", ["dop853", "rk45", "radau", "bdf", "lsoda", "taylor", "cvode", "ida"])
def test_between_rows_a_run_is_as_exact_as_at_its_rows(truth: Trajectory, method: str) -> None:
    if not symdyn.simulation.METHODS[method].installed:
        pytest.skip("it is not installed")
    run = pushed(method, every=0.125)
    found = run(BETWEEN)

    assert np.array_equal(found.t, BETWEEN)
    assert np.array_equal(found.q[::16], run.q)
    assert np.array_equal(found["energy_error"][::16], run["energy_error"])
    worst = np.abs(run.q - truth.q[::16]).max(), np.abs(run.qdd - truth.qdd[::16]).max()
    assert np.abs(found.q - truth.q).max() < 1.5 * worst[0] + 1e-12
    assert np.abs(found.qdd - truth.qdd).max() < 1.5 * worst[1] + 1e-10
    assert found.names == run.names
    assert np.allclose(found["F"], 0.5 * np.cos(3 * BETWEEN), atol=1e-15, rtol=0)


@pytest.mark.runs("cc")
def test_times_stand_in_any_order_and_one_gives_a_row(truth: Trajectory) -> None:
    run = pushed("dop853")
    asked = [1.5, 0.003, 1.5, 2.0, 0.0]
    found = run(asked)
    assert np.array_equal(found.t, asked)
    assert np.array_equal(found.q[0], found.q[2])
    assert np.array_equal(found.q[[3, 4]], run.q[[-1, 0]])
    assert run(0.7)["theta"].shape == (1,)
    assert run(np.empty(0)).q.shape == (0, 2)
    assert np.allclose(run(asked)(0.003).q[0], found.q[1], atol=0)
    assert found.monitors == run.monitors
    for wrong in (-1e-9, 2.1, np.nan):
        with pytest.raises(SimulateError, match=r"^cart_pole: t = \S+ s is outside of the run, 0 … 2 s; nothing"):
            run([0.1, wrong])
    with pytest.raises(SimulateError, match="t = 'now': give a number"):
        run("now")  # type: ignore[arg-type]


@pytest.mark.runs("cc")
def test_loops_are_closed_and_reactions_told_between_rows() -> None:
    bars = read(EXAMPLES / "four_bar.toml")
    run = simulate(bars, until=1.0, every=0.1, reactions=True)
    exact = simulate(bars, until=1.0, every=0.01, reactions=True, method="dop853", rtol=1e-13)
    found = run(exact.t)
    assert found["loop_error"].max() < 1e-13
    force = next(name for name in run.names if name.startswith("reaction_"))
    assert np.abs(found[force] - exact[force]).max() < 1e-9 * np.abs(exact[force]).max() + 1e-9


@pytest.mark.runs("cc")
def test_samples_of_a_controller_are_not_taken_twice() -> None:
    """A law with noise, whose forces change between the rows that are kept and at their times."""
    random, asked = np.random.default_rng(0), []

    def law(t: float, q: np.ndarray, u: np.ndarray) -> float:
        asked.append(t)
        return float(-20 * q[1] - 3 * u[1] + random.normal())

    noisy = Feedback(law, ("F",), period=0.05, delay=0.02, limits={"F": 3.0})
    run = simulate(ARM, until=1.0, every=0.125, start="theta=0.2", feedback=noisy)
    count, saturations = len(asked), run.saturations
    times = np.arange(0.0, 1.0, 0.01) + 0.005
    found = run(times)
    assert len(asked) == count
    assert run.saturations == saturations
    forces = found["F"]
    assert len(np.unique(forces)) > 10
    acted = Feedback(lambda t, q, u: forces[min(round(t / 0.01), len(forces) - 1)], ("F",), period=0.01)
    exact = simulate(ARM, until=1.0, every=0.005, start="theta=0.2", feedback=acted, rtol=1e-12)
    assert np.abs(exact.q[1:-1:2] - found.q).max() < 1e-8


@pytest.mark.runs("cc")
@pytest.mark.parametrize("period", [None, 0.05])
def test_states_of_a_controller_go_on_between_rows(period: float | None) -> None:
    law = linear_law(
        -20 if period is None else 0.4, 1 if period is None else 0.03, -340, 20, "theta", "F", period=period
    )
    options = {"until": 1.0, "start": {"theta": "0.1"}, "feedback": law}
    exact = simulate(ARM, every=0.01, rtol=1e-12, **options)
    found = simulate(ARM, every=0.25, **options)(exact.t)
    assert found.names == exact.names
    assert np.abs(found.q - exact.q).max() < 1e-8
    for name in ("controller_x1", "F", "command_F"):
        assert np.abs(found[name] - exact[name]).max() < 1e-6 * np.abs(exact[name]).max()


@pytest.mark.runs("cc")
def test_runs_with_31_digits_are_asked_in_doubles() -> None:
    rod = EXAMPLES / "pendulum.toml"
    options = {"values": {"g": 9.81, "l": 0.7, "m": 1}, "start": "q1=0.3", "until": 1.0}
    run = simulate(rod, rtol=1e-25, every=0.25, **options)
    exact = simulate(rod, rtol=1e-25, every=0.125, **options)
    found = run(exact.t)
    assert found.low is None
    assert np.abs(found.q - exact.q).max() < 1e-14


@pytest.mark.runs("cc")
def test_a_motion_without_equations_at_hand_says_so() -> None:
    run = pushed("dop853")
    given = inverse(ARM, {"x": "0.1*t", "theta": 0.1}, [0, 1])
    for one in (given, pickle.loads(pickle.dumps(run))):
        with pytest.raises(SimulateError, match="no equations at hand that go on between the rows of this motion"):
            one(0.5)
