"""An ensemble is many runs of `simulate`: each of its lanes is one, whatever way it was run."""

from __future__ import annotations

import subprocess
import sys
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from patience import HANG

import symdyn
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.errors import MethodError, SimulateError, UnknownNameError
from symdyn.extras import EXTRAS
from symdyn.notebook import bundle
from symdyn.scene import bind, read_text
from symdyn.scene.values import velocity_name
from symdyn.simulation.measures import FOLDS, Sums
from symdyn.study.runs import ENDED, STOPPED

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long]

VALUES = {"m1": [1.0, 2.0, 3.0], "m2": 1.5, "h1": 1, "h2": "0.7", "g": 9.81}
START = {"q1": [0.1, 1.2, 3.0]}


def test_a_measure_is_that_of_the_rows_of_a_run() -> None:
    scene = symdyn.example("two_link")
    texts = ["max(abs(M2))", "end(q1) - 2*start(q2_dot)/m1", "when_max(q1)", "rms(q2)", "mean(q1_ddot)"]
    forces = "M2=-0.3*q2_dot+0.1*t"
    runs = symdyn.ensemble(
        scene,
        forces=forces,
        until=2.0,
        start=START,
        start_rates={"q2": 0.4},
        values=VALUES,
        measures=texts,
        method="taylor",
        workers=2,
    )
    for k in range(3):
        values = VALUES | {"m1": VALUES["m1"][k]}
        one = symdyn.simulate(
            scene, forces=forces, until=2.0, start={"q1": START["q1"][k]}, start_rates={"q2": 0.4}, values=values
        )
        np.testing.assert_allclose(runs.q[k], one.q[-1], atol=1e-7)
        span = np.trapezoid(np.ones_like(one.t), one.t)
        expected = [
            abs(one["M2"]).max(),
            one["q1"][-1] - 2 * one["q2_dot"][0] / values["m1"],
            one.t[one["q1"].argmax()],
            np.sqrt(np.trapezoid(one["q2"] ** 2, one.t) / span),
            np.trapezoid(one["q1_ddot"], one.t) / span,
        ]
        np.testing.assert_allclose([runs[text][k] for text in texts], expected, atol=1e-7)
    assert not runs.reasons
    assert runs.codes.tolist() == [ENDED] * 3


def test_all_faults_of_a_call_are_told_at_once() -> None:
    with pytest.raises(SimulateError) as told:
        symdyn.ensemble(
            symdyn.example("two_link"),
            start={"q1": [0.1, np.nan], "q9": 1, "q2": [[1]]},
            values={"m1": [1.0, -2.0, 3.0], "m2": 1, "h1": 1, "h2": 1, "g": [1.0, 2.0]},
            measures=["max(abs(M9))", "rms(max(q1))", "q1", "max(q1", "3"],
            workers=0,
        )
    words = "\n".join(told.value.faults)
    for part in (
        "q1: run 1 has nan", "q9 is not known", "shape (1, 1)", "values m1 has 3, values g has 2", "run 1 has -2",
        "uses M9", "takes a statistic of a number", "write max(q1), end(q1)", "bracket that is not closed",
        "takes no statistic", "workers = 0",
    ):  # fmt: skip
        assert part in words


def test_a_scene_whose_motion_needs_no_parameter_runs_in_lanes() -> None:
    text = """
    name = "idle"
    gravity = "none"
    [parameters]
    m = "2 kg"
    [bodies.arm]
    particles = [{mass = "m", at = [0.5, 0, 0]}]
    [joints.j]
    type = "revolute"
    parent = "ground"
    child = "arm"
    axis = [0, 1, 0]
    """
    scene = read_text(text)
    (name,) = scene.coordinates
    runs = symdyn.ensemble(scene, until=0.5, start_rates={name: 2.0}, values={"m": [1.0, 3.0]}, measures="end(t)")
    np.testing.assert_allclose(runs.q[:, 0], 1.0, rtol=1e-9)


TREES = [
    "arm7", "cart_pole", "double_pendulum", "free_body", "gripper2", "heavy_top", "pendulum", "puma560", "quadruped",
    "scara", "spatial_3r", "two_link",
]  # fmt: skip
LOOPS = ["bicycle", "cart_with_wheel", "four_bar", "governor", "rolling_disc", "rssr", "rsup", "slider_crank"]


def bound(name: str) -> symdyn.Scene:
    scene = symdyn.example(name)
    return bind(scene, {p.name: 9.81 if p.name == "g" else 1.0 for p in scene.free_parameters})


@pytest.mark.wide("free_body", "pendulum")
@pytest.mark.parametrize("name", TREES)
def test_a_lane_is_a_run_of_simulate(name: str) -> None:
    """Starts of the scene and off it, on every coordinate that is no quaternion and is not prescribed."""
    scene = bound(name)
    moved = {scene.velocities[k] for k in scene.prescribed_velocities}
    turned = {name for group in quaternions(scene) for name in group}
    free = [q for q in scene.coordinates if velocity_name(q) in scene.velocities and velocity_name(q) not in moved]
    names = [q for q in free if q not in turned]
    rng = np.random.default_rng(3)
    off = {q: np.concatenate([[0.0], rng.uniform(-0.3, 0.3, 2)]) for q in names}
    rates = {u: np.array([0.0, 0.1, -0.2]) for u in scene.velocities if u not in moved}
    measure = f"max({scene.coordinates[0]}) - 3*end(kinetic_energy)"
    runs = symdyn.ensemble(scene, until=0.5, start=off, start_rates=rates, measures=measure, samples=True, rtol=1e-10)
    assert runs.about["method"] == "lockstep"
    for k in range(3):
        start = {q: float(x[k]) for q, x in off.items()}
        speeds = {u: float(x[k]) for u, x in rates.items()}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            one = symdyn.simulate(scene, until=0.5, start=start, start_rates=speeds, rtol=1e-10, method="dop853")
        size = max(1.0, np.abs(one.qd).max())
        assert abs(runs.t[k] - one.t[-1]) < 1e-6
        np.testing.assert_allclose(
            np.hstack([runs.q[k], runs.qd[k]]), np.hstack([one.q[-1], one.qd[-1]]), atol=1e-6 * size
        )
        assert runs.samples is not None
        count = len(one.t) if runs.codes[k] == ENDED else len(one.t) - 1
        np.testing.assert_allclose(runs.samples[k, :count, : len(one.q[0])], one.q[:count], atol=1e-6 * size)
        expected = one[scene.coordinates[0]].max() - 3 * one["kinetic_energy"][-1]
        assert abs(runs[measure][k] - expected) < 1e-5 * max(1.0, abs(one["kinetic_energy"]).max())


@pytest.mark.wide("rolling_disc")
@pytest.mark.parametrize("name", LOOPS)
def test_a_closed_mechanism_is_run_one_by_one(name: str) -> None:
    scene = bound(name)
    runs = symdyn.ensemble(scene, until=0.2, values={}, measures="max(t)")
    one = symdyn.simulate(scene, until=0.2, rtol=1e-9)
    assert runs.about["method"] == "one by one"
    assert any("loops close" in note for note in runs.notes)
    np.testing.assert_array_equal(runs.q[0], one.q[-1])
    assert runs["max(t)"][0] == pytest.approx(0.2)


@pytest.mark.parametrize("count", [0, 1, 9, 65])
def test_any_number_of_runs(count: int) -> None:
    first = np.linspace(0.1, 0.5, count)
    texts = ["max(q1)", "when_min(q1)"]
    runs = symdyn.ensemble(bound("pendulum"), until=1.0, start={"q1": first}, measures=texts, samples=True)
    assert len(runs) == count
    assert runs.q.shape == (count, 1)
    assert runs["max(q1)"].shape == (count,)
    assert runs.samples is not None
    assert runs.samples.shape == (count, 201, 2)
    np.testing.assert_array_equal(runs.samples[:, 0, 0], first)
    np.testing.assert_allclose(runs["max(q1)"], runs.samples[:, :, 0].max(axis=1))
    assert repr(runs) == f"<Runs of pendulum: {count} runs over q1; max(q1), when_min(q1)>"


def test_runs_without_measures_say_what_they_are_over() -> None:
    runs = symdyn.ensemble(bound("pendulum"), until=0.1, start={"q1": [0.1, 0.2]})
    assert repr(runs) == "<Runs of pendulum: 2 runs over q1>"


def test_the_same_bytes_on_any_number_of_threads() -> None:
    first = np.random.default_rng(0).uniform(-3, 3, 9000)
    scene, found = bound("double_pendulum"), []
    name = scene.coordinates[0]
    for workers in (1, 3):
        runs = symdyn.ensemble(scene, until=0.2, start={name: first}, measures=f"rms({name})", workers=workers)
        found.append((runs.q.tobytes(), runs.qd.tobytes(), runs[f"rms({name})"].tobytes(), runs.codes.tobytes()))
    assert found[0] == found[1]


def test_a_run_that_stops_stops_alone_and_says_why() -> None:
    scene = bound("pendulum")
    first = np.array([0.1, 1.0, 0.2, 2.0])
    runs = symdyn.ensemble(scene, until=2.0, start={"q1": first}, stops="q1 + 0.5", measures="min(q1)")
    assert runs.codes.tolist() == [ENDED, STOPPED, ENDED, STOPPED]
    assert runs.reasons == {1: "q1 + 0.5", 3: "q1 + 0.5"}
    for k in (1, 3):
        one = symdyn.simulate(scene, until=2.0, start={"q1": float(first[k])}, stops="q1 + 0.5", rtol=1e-9)
        assert runs.t[k] == one.t[-1]
        np.testing.assert_array_equal(runs.q[k], one.q[-1])
    assert runs["min(q1)"][1] == pytest.approx(-0.5, abs=1e-9)
    one = symdyn.simulate(scene, until=2.0, start={"q1": 0.1}, stops="q1 + 0.5", rtol=1e-9)
    assert runs["min(q1)"][0] == pytest.approx(one(np.linspace(0, 2, 4001))["q1"].min(), abs=1e-7)


@pytest.mark.slow
def test_a_run_that_leaves_what_doubles_hold_does_not_end_the_others() -> None:
    scene = bound("pendulum")
    drive = next(one for one in scene.drives if one)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        runs = symdyn.ensemble(scene, forces=f"{drive}=1/(2-q1)", until=3.0, start={"q1": [0.1, 2.5, 0.2]})
    assert ENDED in runs.codes
    assert np.isfinite(runs.q[runs.codes == ENDED]).all()
    assert all(runs.reasons[k] for k in np.flatnonzero(runs.codes != ENDED).tolist())
    one = symdyn.simulate(scene, forces=f"{drive}=1/(2-q1)", until=3.0, start={"q1": 0.1}, rtol=1e-9, say=str)
    np.testing.assert_allclose(runs.q[0], one.q[-1], atol=1e-6)


def test_parameters_vary_whatever_value_the_scene_gives_them() -> None:
    """Equal and vanishing values of a run decide nothing about the equations of the others."""
    scene = symdyn.example("two_link")
    values = {"m1": [1.0, 2.0], "m2": [1.0, 1.0], "h1": 1, "h2": 1, "g": [0.0, 9.81]}
    scene = replace(scene, parameters=tuple(replace(p, positive=False) for p in scene.parameters))
    runs = symdyn.ensemble(scene, until=1.0, start={"q1": 0.3, "q2": "m1/10"}, values=values, rtol=1e-10)
    for k in range(2):
        at = {name: x[k] if isinstance(x, list) else x for name, x in values.items()}
        one = symdyn.simulate(scene, until=1.0, start={"q1": 0.3, "q2": "m1/10"}, values=at, rtol=1e-10)
        np.testing.assert_allclose(runs.q[k], one.q[-1], atol=1e-8)


def test_simulate_names_the_door_of_many_runs() -> None:
    with pytest.raises(SimulateError, match=r"q1 has 2 numbers.*symdyn\.ensemble"):
        symdyn.simulate(bound("pendulum"), start={"q1": [0.1, 0.2]})


def test_a_table_of_forces_is_followed_run_by_run() -> None:
    scene = bound("pendulum")
    drive = next(one for one in scene.drives if one)
    t = np.linspace(0, 1, 11)
    runs = symdyn.ensemble(scene, forces={drive: (t, np.sin(t))}, until=1.0, start={"q1": [0.0, 0.1]})
    assert runs.about["method"] == "one by one"
    one = symdyn.simulate(scene, forces={drive: (t, np.sin(t))}, until=1.0, start={"q1": 0.1}, rtol=1e-9)
    np.testing.assert_array_equal(runs.q[1], one.q[-1])


INTERRUPTED = """
import os, signal, sys, threading
import numpy as np
import symdyn
from symdyn.scene import bind
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it, and so would children
scene = symdyn.example("pendulum")
scene = bind(scene, {p.name: 9.81 if p.name == "g" else 1.0 for p in scene.free_parameters})
first, words, heard = np.linspace(0.1, 3, int(sys.argv[1])), [], []
kept = {"method": sys.argv[2]} if len(sys.argv) > 2 else {}
def hear(share):
    heard.append(share)
    if len(heard) == 2:
        os.kill(os.getpid(), signal.SIGINT)
runs = symdyn.ensemble(scene, until=20.0, start={"q1": first}, measures="max(q1)", workers=2, progress=hear, **kept)
done = runs.codes == 1
assert 0 < done.sum() < len(done), done.sum()
assert (runs.left, runs.reasons) == ((~done).sum(), {}), runs
assert np.isfinite(runs.q[done]).all() and np.isfinite(runs["max(q1)"][done]).all()
assert np.isnan(runs["max(q1)"][~done]).all()
print("kept")
"""


@pytest.mark.wide("words1")
@pytest.mark.parametrize("words", [["4000000"], ["100", "radau"]])
def test_an_interrupt_keeps_what_is_done(words: list[str]) -> None:
    """More runs than are done before the signal is heard, however fast the machine."""
    command = [sys.executable, "-c", INTERRUPTED, *words]
    found = subprocess.run(command, capture_output=True, text=True, timeout=HANG, check=False)
    assert found.stdout == "kept\n", found.stderr


def test_a_stiff_system_is_left_to_implicit_methods() -> None:
    scene = bound("pendulum")
    drive = next(one for one in scene.drives if one)
    runs = symdyn.ensemble(scene, forces=f"{drive}=-1e6*q1_dot", until=10.0, start={"q1": [0.1, 0.2]})
    assert runs.about["method"] == "one by one"
    assert any("stiff" in note for note in runs.notes)
    assert runs.codes.tolist() == [ENDED] * 2


@pytest.mark.wide(4)
@pytest.mark.parametrize("name", ["double_pendulum", "cart_pole", "two_link", "spatial_3r"])
def test_series_lockstep_are_runs_of_simulate(name: str) -> None:
    """At rest and level too, where the last orders of a series vanish."""
    scene = bound(name)
    first, other = scene.coordinates[:2]
    start = {first: np.array([0.0, np.pi / 2, 0.3, 1.0, 0.2, -0.7, 0.1, 0.9, 0.5]), other: 0.0}
    text = f"rms({first}) + 2*end({other})"
    taylor = {"method": "taylor", "rtol": 1e-13}
    runs = symdyn.ensemble(scene, until=2.0, start=start, measures=text, samples=True, **taylor)  # type: ignore[arg-type]
    same = symdyn.ensemble(scene, until=2.0, start=start, measures=text, method="dop853", rtol=1e-13)
    assert runs.about["method"] == "taylor lockstep"
    assert same.about["method"] == "lockstep"
    for k in range(9):
        at = {first: float(start[first][k]), other: 0.0}
        one = symdyn.simulate(scene, until=2.0, start=at, **taylor)  # type: ignore[arg-type]
        assert runs.samples is not None
        np.testing.assert_allclose(runs.samples[k], np.hstack([one.q, one.qd]), atol=1e-9)
        np.testing.assert_allclose(runs.q[k], one.q[-1], atol=1e-9)
        np.testing.assert_allclose(runs.qd[k], one.qd[-1], atol=1e-9)
    np.testing.assert_allclose(same.q, runs.q, atol=1e-9)
    np.testing.assert_allclose(same[text], runs[text], atol=1e-9)


def test_series_lockstep_need_no_measure(monkeypatch: pytest.MonkeyPatch) -> None:
    """The end alone is wanted: there is no sample at the start from which a grid of times could go on.

    No run is lost and run again by `simulate`.
    """
    again = "symdyn.simulation.read_ensemble.replaced"
    monkeypatch.setattr(again, lambda task, block, part, lost, runner: block)
    runs = symdyn.ensemble(bound("pendulum"), until=3.0, start={"q1": [0.0, 0.1, 1.0]}, method="taylor", rtol=1e-13)
    one = symdyn.simulate(bound("pendulum"), until=3.0, start={"q1": 1.0}, method="taylor", rtol=1e-13)
    assert runs.about["method"] == "taylor lockstep"
    np.testing.assert_allclose(runs.q[2], one.q[-1], atol=1e-11)


def test_an_ensemble_is_shown_and_is_a_table() -> None:
    runs = symdyn.ensemble(bound("pendulum"), until=1.0, start={"q1": [0.1, 0.2]}, measures="max(q1)")
    html = bundle(runs)["text/html"]
    assert "2 runs" in html
    assert "max(q1)" in html
    table = runs.to_pandas()
    assert list(table["ended"]) == ["end", "end"]
    assert table.attrs["units"]["end(q1)"] == "rad"
    np.testing.assert_array_equal(table["max(q1)"], runs["max(q1)"])
    with pytest.raises(UnknownNameError, match=r"max\(q1\)"):
        runs["max(q2)"]


def test_runs_of_an_ensemble_and_of_a_sweep_are_one_noun() -> None:
    """The same values give the same numbers under the same names; a sweep alone keeps no ends."""
    scene, q1 = bound("pendulum"), [0.1, 0.2, 0.3]
    given = symdyn.ensemble(scene, until=1.0, start={"q1": q1}, measures=["max(q1)", "end(q1)"])
    drawn = symdyn.sweep(scene, {"q1": q1}, ["max(q1)", "end(q1)"], until=1.0)
    assert type(given) is type(drawn)
    assert given.columns == ("q1", "max(q1)", "end(q1)", "end(q1_dot)")
    for name in drawn.columns:
        np.testing.assert_array_equal(given[name], drawn[name])
        assert given.units[name] == drawn.units[name]
    assert given.to_csv().splitlines()[0] == "q1,max(q1),end(q1),end(q1_dot),ended"
    assert given.quantiles("end(q1_dot)", [0.0])[0] == given.extremes("end(q1_dot)")[0]
    np.testing.assert_array_equal(given.table()[1][:, 3], given.qd[:, 0])
    if EXTRAS["plot"].there:
        assert given.drawn("svg") == given.drawn("svg")
        assert "image/svg+xml" in given.plot("end(q1_dot)")._repr_mimebundle_()  # type: ignore[attr-defined]
    with pytest.raises(SimulateError, match=r"a sweep keeps measures alone; measure such as end\(q1\)"):
        drawn.q  # noqa: B018


@pytest.mark.runs("cc")
@pytest.mark.parametrize("asked", [{"rtol": 1e-28}, {"method": "gauss"}])
def test_runs_of_31_digits_are_an_ensemble_of_doubles(asked: dict[str, Any]) -> None:
    scene = bound("double_pendulum")
    runs = symdyn.ensemble(scene, until=0.2, start={"q1": [0.1, 0.2]}, **asked)
    one = symdyn.simulate(scene, until=0.2, start={"q1": 0.2}, rtol=1e-28)
    assert runs.about["method"] == "one by one"
    assert runs.about["rtol"] == 1e-28
    np.testing.assert_array_equal(runs.q[1], one.q[-1])


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"method": "gauss"}, "method gauss does not apply: abs bends where it is zero"),
        ({"rtol": 1e-28}, "method gauss does not apply: abs bends where it is zero"),
        ({"method": "taylor"}, "method taylor does not apply: abs"),
        ({"method": "bdf", "rtol": 1e-20}, "method bdf computes in doubles"),
    ],
)
def test_a_method_that_applies_to_no_run_is_told_once(asked: dict[str, Any], words: str) -> None:
    with pytest.raises(MethodError, match=words):
        symdyn.ensemble(bound("double_pendulum"), forces="tau1=abs(q1)", until=1.0, start={"q1": [0.1, 0.2]}, **asked)


def test_the_mean_over_half_a_second_is_the_area_by_the_time() -> None:
    one, half, none = np.ones(1), np.array([0.5]), np.zeros(1)
    sums = Sums(one, one, one, one, none, none, area=one, squares=one, span=half, settled=none)
    assert FOLDS["mean"].of(sums) == 2.0
    assert FOLDS["mean"].of(replace(sums, span=none)) == 1.0


@pytest.mark.runs("cc")
def test_no_peak_is_missed_beside_the_end_of_a_step() -> None:
    """Steps are as long as a radian: of 400 frequencies some have a peak just before or behind an end."""
    mass = """
gravity = "none"
parameters = { k = "4 N/m" }
bodies.b.mass = 1
joints.j = { type = "prismatic", parent = "ground", child = "b", axis = [1, 0, 0], coordinate = "x", start = 1 }
springs.s = { joint = "j", stiffness = "k" }
"""
    runs = symdyn.sweep(read_text(mass), "k=linspace(1,9,400)", ["min(x)", "when_min(x)", "max(x_dot)"], until=3.3)
    frequency = np.sqrt(np.asarray(runs["k"]))
    first = 3 * np.pi / 2 / frequency < 3.3  # those that come back through the middle

    np.testing.assert_allclose(np.asarray(runs["min(x)"]), -1, atol=1e-8)
    np.testing.assert_allclose(np.asarray(runs["when_min(x)"]), np.pi / frequency, atol=1e-6)
    np.testing.assert_allclose(np.asarray(runs["max(x_dot)"])[first], frequency[first], rtol=1e-8)
    np.testing.assert_array_equal(runs[["k", "min(x)"]], np.transpose([runs["k"], runs["min(x)"]]))
    with pytest.raises(UnknownNameError, match="there is no column kk"):
        runs[["k", "kk"]]
