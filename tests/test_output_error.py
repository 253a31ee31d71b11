"""Output error: what was put into a simulated run is found again from a part of its columns, within stated errors."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

import symdyn
from symdyn.errors import IdentifyError, SimulateError
from symdyn.identification import OutputFit, output_error, shooting
from symdyn.scene.toml import read_text
from symdyn.simulation.trajectory import Trajectory

pytestmark = pytest.mark.runs("cc")

ROD = Path(__file__).parent / "data" / "options" / "rod.urdf"

SCATTER = 1e-3
"""Of measured columns, rad or m."""


def noisy(run: Trajectory, *names: str, seed: int = 0) -> dict[str, object]:
    draw = np.random.default_rng(seed)
    columns = {name: run[name] + SCATTER * draw.standard_normal(len(run.t)) for name in names}
    return {"t": run.t, **columns}


def swing(until: float = 5.0) -> Trajectory:
    values = {"l": 0.55, "b": 0.02}
    return symdyn.simulate(symdyn.example("pendulum"), until=until, every=0.02, start={"q1": 1}, values=values)


def test_a_search_of_more_than_a_minute_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules["symdyn.identification.output_error"]  # which the function hides
    monkeypatch.setattr(module, "perf_counter", iter(range(0, 10**6, 50)).__next__)
    run, said = swing(1.0), list[str]()
    output_error(symdyn.example("pendulum"), {"t": run.t, "q1": run["q1"]}, ["l", "b"], say=said.append)
    assert said[0].startswith("pendulum: the search goes on after 100 s, ")
    assert said[1].startswith("pendulum: the search goes on after 400 s, ")
    with pytest.warns(RuntimeWarning, match="the search goes on after"):
        output_error(symdyn.example("pendulum"), {"t": run.t, "q1": run["q1"]}, ["l", "b"])


SLED = """
parameters.c = { value = 2, unit = "N" }
bodies.sled.mass = 1
[joints.rail]
type = "prismatic"
parent = "ground"
child = "sled"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
friction = { coulomb = "c", smoothing = 0.002 }
"""


def test_steep_friction_is_followed_and_what_is_too_steep_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, forces = read_text(SLED), {"F": "6*sin(9*t)"}
    run = symdyn.simulate(scene, forces=forces, until=0.5, every=0.05, values={"c": 2.5})
    log = {"t": run.t, "x": run["x"]}
    found = output_error(scene, log, "c", forces=forces)
    assert found["c"] == pytest.approx(2.5)
    assert found.to_pandas().loc["c", "standard_error"] == found.standard_errors[0]
    monkeypatch.setattr("symdyn.identification.shooting.MOST_STEPS", 64)
    with pytest.raises(IdentifyError, match=r"64 steps .* or a wider smoothing, which moves what is found"):
        output_error(scene, log, "c", forces=forces)


def within(found: OutputFit, truth: dict[str, float], errors: float = 4.0) -> bool:
    places = [found.names.index(name) for name in truth]
    missed = np.abs(found.estimate[places] - np.array(list(truth.values())))
    return bool(np.all(missed < errors * found.standard_errors[places]))


@pytest.mark.long
def test_a_pendulum_tells_its_length_and_friction_by_its_angle_alone() -> None:
    found = output_error(symdyn.example("pendulum"), noisy(swing(), "q1"), ["l", "b"])

    assert within(found, {"l": 0.55, "b": 0.02, "start q1": 1.0, "start q1_dot": 0.0})
    assert found.noise[0] == pytest.approx(SCATTER, rel=0.2)
    assert abs(found.correlation[0]) < 0.2
    assert found.units == ("m", "N m s/rad", "rad", "rad/s")
    assert symdyn.simulate(found.scene, until=1, start={"q1": 1})["q1"][-1] == pytest.approx(
        symdyn.simulate(symdyn.example("pendulum"), until=1, start={"q1": 1}, values={"l": 0.55, "b": 0.02})["q1"][-1],
        abs=1e-3,
    )


def test_two_parameters_that_are_hardly_told_apart_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    pendulum, true = symdyn.example("pendulum"), {"m": 1.2, "l": 0.55, "b": 0.03}
    run = symdyn.simulate(pendulum, forces="tau1=2*sin(2*t)", until=0.6, every=0.01, values=true)
    data = {"t": run.t, "q1": run["q1"] + 2e-3 * np.random.default_rng(0).normal(size=len(run.t)), "tau1": run["tau1"]}
    found = output_error(pendulum, data, ["m", "l", "b"])
    (a, b, r), *_ = found.alike

    assert (a, b) == ("m", "l")
    assert -1 < r < -0.99
    assert any(f"m and l are hardly told apart (correlation of their errors {r:.4f})" in note for note in found.notes)
    assert repr(found).endswith(f"; m and l hardly told apart (r = {r:.4f})>")
    assert not any("settled" in note for note in found.notes)
    assert output_error(pendulum, data, "l").alike == ()

    monkeypatch.setattr(shooting, "MOST_RUNS", 2)
    assert any("ended before it had settled" in note for note in output_error(pendulum, data, ["m", "l"]).notes)


@pytest.mark.long
def test_searches_end_where_weights_are_those_of_the_residuals(monkeypatch: pytest.MonkeyPatch) -> None:
    weights, once = list[np.ndarray](), shooting._best

    def seen(search: shooting.Search, *given: np.ndarray) -> np.ndarray:
        weights.append(search.sigma)
        return once(search, *given)

    monkeypatch.setattr(shooting, "_best", seen)
    output_error(symdyn.example("pendulum"), noisy(swing(), "q1", "q1_dot"), ["l", "b"])

    first, last = weights[len(shooting.PARTS) - 1 :]
    assert np.abs(last / first - 1).max() > shooting.SETTLED
    np.testing.assert_allclose(last, SCATTER, rtol=0.1)


@pytest.mark.long
def test_without_names_all_identifiable_parameters_are_estimated() -> None:
    found = output_error(symdyn.example("pendulum"), noisy(swing(), "q1"))

    assert len(found.values) == 2  # of m, l and b: l, and one of b and m
    assert any("identifiable in combination with" in note for note in found.notes)


@pytest.mark.long
def test_parameters_that_stand_for_each_other_are_named() -> None:
    with pytest.raises(IdentifyError, match=r"identify (b and m|m and b|b, m|m, b) in combination only"):
        output_error(symdyn.example("pendulum"), noisy(swing(), "q1"), ["m", "l", "b"])


@pytest.mark.long
def test_a_cart_tells_of_its_pole_that_nobody_measures() -> None:
    truth = {"mp": 0.2, "l": 0.6, "b": 0.15}
    cart = symdyn.example("cart_pole")
    run = symdyn.simulate(cart, forces="F=2*cos(3*t)", until=6, every=0.02, start={"theta": 3.0}, values=truth)
    data = {**noisy(run, "x"), "F": run["F"]}

    found = output_error(cart, data, list(truth), start={"theta": 3.14})

    assert within(found, truth | {"start theta": 3.0})
    assert found.measured == ("x",)


@pytest.mark.slow
@pytest.mark.long
def test_a_four_bar_tells_masses_by_the_angle_of_its_rocker() -> None:
    truth = {"m2": 2.5, "m3": 4.0}
    bar = symdyn.example("four_bar")
    run = symdyn.simulate(bar, forces="M=30+20*sin(2*t)", until=1.5, every=0.02, values=truth)
    data = {**noisy(run, "chi"), "M": run["M"]}

    found = output_error(bar, data, list(truth))

    assert within(found, truth)
    assert {name for name in found.names if name.startswith("start")} == {"start phi", "start phi_dot"}


@pytest.mark.long
def test_each_log_has_a_start_of_its_own() -> None:
    pendulum = symdyn.example("pendulum")
    runs = [
        symdyn.simulate(pendulum, until=2, every=0.02, start={"q1": angle}, values={"l": 0.55, "b": 0.02})
        for angle in (1, -0.5)
    ]

    found = output_error(pendulum, [noisy(run, "q1", seed=k) for k, run in enumerate(runs)], ["l", "b"])

    assert within(found, {"l": 0.55, "b": 0.02, "start 1 q1": 1.0, "start 2 q1": -0.5})


@pytest.mark.slow
def test_a_motion_that_forgets_its_start_is_cut_into_pieces() -> None:
    double = symdyn.example("double_pendulum")
    truth = {"m1": 1.0, "m2": 1.0, "l1": 1.0, "l2": 1.1, "g": 9.81}
    run = symdyn.simulate(double, until=20, every=0.02, start={"q1": 2, "q2": 1}, values=truth)
    data, guess = noisy(run, "q1", "q2"), truth | {"l2": 1.0}

    with pytest.raises(IdentifyError, match="pieces"):
        output_error(double, data, "l2", values=guess)

    assert within(output_error(double, data, "l2", values=guess, pieces=5), {"l2": 1.1})


@pytest.mark.long
def test_a_scene_that_lacks_something_is_doubted() -> None:
    found = output_error(symdyn.example("pendulum"), noisy(swing(), "q1"), "l", values={"b": 1e-6})

    assert any("residuals of q1 are correlated" in note for note in found.notes)


@pytest.mark.parametrize(
    ("data", "options", "words"),
    [
        ({"t": np.arange(20.0), "w": np.zeros(20)}, {}, "has no column of q1, q1_dot"),
        ({"t": np.arange(5.0), "q1": np.zeros(5)}, {}, "has 5 rows; 10 a piece"),
        ({"t": np.arange(20.0), "q1": np.zeros(20)}, {"measured": "q2"}, "q2 is no coordinate"),
        ({"t": np.arange(20.0), "q1": np.zeros(20)}, {"parameters": "k"}, "k is not known"),
        ({"t": np.arange(20.0)[::-1], "q1": np.zeros(20)}, {}, "does not come after"),
        ({"t": np.arange(20.0), "q1": np.zeros(20)}, {"start": "q1=1"}, "start: the log has q1.*: leave out start$"),
        ({"q1": "sin(t)"}, {}, "measure nothing"),
        ([], {}, "there is no log"),
    ],
)
def test_what_does_not_fit_is_said(data: object, options: dict[str, str], words: str) -> None:
    with pytest.raises((SimulateError, IdentifyError), match=words):
        output_error(symdyn.example("pendulum"), data, **options)  # type: ignore[arg-type]


@pytest.mark.long
def test_the_same_data_give_the_same_bytes() -> None:
    data = noisy(swing(2.0), "q1")

    first, second = (output_error(symdyn.example("pendulum"), data, ["l", "b"]) for _ in range(2))

    assert first.estimate.tobytes() == second.estimate.tobytes()
    assert first.covariance.tobytes() == second.covariance.tobytes()


@pytest.mark.mends("30.also.nothing_to_look_for")
def test_a_scene_of_numbers_alone_is_told_that_nothing_is_looked_for() -> None:
    rod = symdyn.read(ROD)

    with pytest.raises(IdentifyError, match=r"rod: parameters: none is to be estimated; .* all by symdyn.scene.w"):
        output_error(rod, {"t": np.linspace(0, 2, 41), "q1": np.ones(41), "tau1": np.ones(41)})


def coloured(count: int, seed: int, pole: float) -> np.ndarray:
    """Return noise of scatter one that a filter of first order has passed, shape (count,)."""
    white = np.random.default_rng(seed).standard_normal(count + 1000)
    return np.asarray(lfilter([np.sqrt(1 - pole**2)], [1, -pole], white)[1000:])


@pytest.mark.long
def test_errors_tell_of_coloured_noise_as_of_white() -> None:
    """Taken as independent from sample to sample they were 5 to 12 times too small."""
    run, sizes = swing(), list[np.ndarray]()
    for pole in (0.0, 0.95):
        data = {"t": run.t, "q1": run["q1"] + 10 * SCATTER * coloured(len(run.t), 3, pole)}
        found = output_error(symdyn.example("pendulum"), data, ["l", "b"])
        assert within(found, {"l": 0.55, "b": 0.02}, 3)
        assert (found.errors == found.standard_errors).all()
        sizes.append(found.errors)
    assert 2 < (sizes[1] / sizes[0])[:2].max() < np.sqrt((1 + 0.95) / (1 - 0.95)) * 1.2


@pytest.mark.slow
@pytest.mark.parametrize("pole", [0.0, 0.9])
def test_intervals_hold_the_truth_of_200_logs_with_coloured_noise(pole: float) -> None:
    run, truth = swing(10), np.array([0.55, 0.02, 1.0, 0.0])
    off = []
    for seed in range(200):
        data = {"t": run.t, "q1": run["q1"] + 5 * SCATTER * coloured(len(run.t), seed, pole)}
        found = output_error(symdyn.example("pendulum"), data, ["l", "b"])
        off.append((found.estimate - truth) / found.errors)
    assert 0.88 < np.mean(np.abs(off) < 1.96) < 0.98
