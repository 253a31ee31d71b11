"""Controllers in runs: linear gains, functions, samples with delay and saturation, and what is said of bad ones."""

from __future__ import annotations

import json
import math
import os
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sliding_block import BLOCK

import symdyn
from symdyn.cli import main
from symdyn.errors import SimulateError
from symdyn.scene import Scene, read, read_text
from symdyn.simulation import Feedback, Forces, read_feedback, simulate
from symdyn.simulation.equations.control_loop import Loop, lateness
from symdyn.simulation.equations.controller import placed
from symdyn.simulation.equations.implicit import Implicit, differences, slopes
from symdyn.simulation.equations.linear_feedback import Gains, state_names
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.initial import read_start
from symdyn.simulation.integrate import importable

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"
CART = read(EXAMPLES / "cart_pole.toml")
FOUR_BAR = read(EXAMPLES / "four_bar.toml")
BODY = read_text(
    'name = "body"\ngravity = "none"\n[bodies.b]\nmass = 1\ninertia = [1, 2, 3]\ninertia_about = "com"\n[joints.f]\n'
    'type = "free"\nparent = "ground"\nchild = "b"\ncoordinates = ["x", "y", "z", "e0", "e1", "e2", "e3"]\n'
    'drives = ["fx", "fy", "fz", "mx", "my", "mz"]\n'
)
STATES = ["x", "theta", "x_dot", "theta_dot"]
A_FINE_K = [[-3.162, 37.7, -5.2, 8.6]]


def gains(K: object = None, **more: object) -> dict[str, object]:
    return {"K": A_FINE_K if K is None else K, "states": STATES, "inputs": ["F"], **more}


METHODS = [
    "dop853", "radau", "lsoda",
    *(pytest.param(name, marks=pytest.mark.skipif(not importable("sksundae"), reason="needs the extra simulate"))
      for name in ("cvode", "ida")),
]  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_gains_are_the_formula_that_they_say(method: str) -> None:
    """u0 - K (x - x0), with every method, its Jacobian included."""
    K, start = [[3.0, -40.0, 5.0, -8.0]], {"theta": "0.2"}
    formula = "F=0.5-3*(x-0.1)+40*theta-5*x_dot+8*theta_dot"

    run = simulate(CART, until=0.5, start=start, feedback=gains(K, x0={"x": 0.1}, u0={"F": 0.5}), method=method)
    same = simulate(CART, forces=formula, until=0.5, start=start, method="dop853", rtol=1e-12)

    assert run.method == method
    assert run.complete
    assert np.abs(run.q - same.q).max() < 1e-6
    assert np.abs(run.tau - same.tau).max() < 1e-4
    assert np.abs(run.tau).max() > 1
    assert run.monitors["energy"] < 1e-5 * run.monitors["energy_scale"]


@pytest.mark.parametrize("periods", [1, 3, 6, 7])  # 0.3 and 0.6 are not 3 and 6 times 0.1 in doubles
def test_a_delay_of_whole_periods_is_whole(periods: int) -> None:
    def late(delay: float) -> tuple[int, float]:
        return lateness(Feedback(lambda t, q, u: 0, period=0.1, delay=delay))

    assert late(periods / 10) == (periods, 0.0)
    assert late(periods / 10 + 0.04) == (periods, pytest.approx(0.04))


def test_forces_beside_a_controller_are_added() -> None:
    run = simulate(BLOCK, forces="F=1", until=1.0, feedback=lambda t, q, u: -0.25)

    assert np.allclose(run["F"], 0.75, atol=1e-15)
    assert run.q[-1, 0] == pytest.approx(0.5 - 1 + 0.75 / 4, abs=1e-12)


@pytest.mark.parametrize(("force", "twice"), [("1", True), ("cos(theta) + x", True), ("1.1", False), ("cos(t)", False)])
def test_a_force_that_gains_hold_themselves_is_told(force: str, twice: bool) -> None:
    law = gains([[0, -40, 0, -8]], u0={"F": 1})
    run = simulate(CART, forces={"F": force}, until=0.01, feedback=law, start={"theta": 0.1})

    assert any("the gains add u0 = 1 N, together 2 N; leave it out of forces" in note for note in run.notes) == twice


def test_a_regulator_holds_the_pole_upright_all_the_time_and_sampled() -> None:
    system = symdyn.linearize(CART, start={"theta": "0"})

    for found, more in ((system.lqr(), {}), (system.lqr(period=0.02), {"delay": 0.005})):
        run = simulate(CART, until=10.0, start={"theta": "0.1"}, feedback={**found.gains(), **more})
        assert run.method == "dop853"
        assert run.complete
        assert np.abs(np.hstack([run.q, run.qd])[-1]).max() < 1e-3


def test_a_regulator_brings_a_free_body_and_a_four_bar_back() -> None:
    """Of states along velocities, and of independent ones of a closed mechanism; away from the point by little."""
    point = {"phi": "0.685937388", "psi": "0.297726118", "chi": "2.03412386"}
    start = {"phi": "0.7"}
    for scene, at, forces, begun in (
        (BODY, {"e0": "0.6", "e1": "0.8"}, {}, {"x": "0.1"}),
        (FOUR_BAR, point, "M=20", start),
    ):
        system = symdyn.linearize(scene, start=at, forces=forces)
        run = simulate(scene, until=15.0, start={**at, **begun}, feedback=system.lqr().gains())

        assert run.complete
        assert np.abs(run.q[-1] - system.point.q).max() < 1e-3


def exact_block(law, period: float, delay: float, until: float, most: float = math.inf, mass: float = 2.0) -> list:
    """Return times, positions and velocities at all samples: between changes of force the way is a parabola."""
    t, x, v, force, due, found = 0.0, 0.5, -1.0, 0.0, [], []
    times = sorted({k * period for k in range(round(until / period) + 1)}, key=float)
    marks = sorted([(round(one, 12), 0) for one in times] + [(round(one + delay, 12), 1) for one in times])
    for when, acts in marks:
        h = when - t
        x, v, t = x + v * h + force / (2 * mass) * h * h, v + force / mass * h, when
        if acts == 0:
            found.append((when, x, v))
            due.append(max(-most, min(most, law(x, v))))
        else:
            force = due.pop(0)
        if when >= until - 1e-12 and acts == 0:
            break
    return found


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.05, 0.1, 0.13], ids=str)
@pytest.mark.parametrize("method", ["dop853", METHODS[3]])
def test_a_sampled_controller_with_delay_and_saturation_is_its_difference_equation(delay: float, method: str) -> None:
    period, until = 0.05, 1.5
    control = Feedback(lambda t, q, u: -30 * q[0] - 8 * u[0], period=period, delay=delay, limits={"F": 4.0})

    run = simulate(BLOCK, until=until, every=period, feedback=control, method=method)
    expected = np.array(exact_block(lambda x, v: -30 * x - 8 * v, period, delay, until, 4.0))

    assert np.allclose(run.t, expected[:, 0])
    assert np.abs(run.q[:, 0] - expected[:, 1]).max() < 1e-7
    assert np.abs(run.qd[:, 0] - expected[:, 2]).max() < 1e-6
    assert np.abs(run.tau).max() == 4.0
    assert run.monitors["energy"] < 1e-6


def test_samples_are_taken_once_each_and_in_order_so_that_a_controller_may_remember() -> None:
    times: list[float] = []

    def integral(t: float, q: np.ndarray, u: np.ndarray) -> float:
        times.append(t)
        return -float(len(times))

    run = simulate(BLOCK, until=0.5, every=0.05, feedback=Feedback(integral, period=0.1, limits={"F": (-3, 10)}))

    assert times == [0.0, 0.1, 0.2, 0.1 * 3, 0.4]
    assert run["F"].tolist() == [-1.0, -1, -2, -2, -3, -3, -3, -3, -3, -3, -3]


def test_until_the_first_force_arrives_the_initial_one_acts() -> None:
    run = simulate(
        BLOCK, until=0.4, every=0.1, feedback=Feedback(lambda t, q, u: 5, period=0.1, delay=0.2, initial=[2])
    )

    assert run["F"].tolist() == [2, 2, 5, 5, 5]


def test_a_law_may_drive_some_of_several_velocities() -> None:
    double = read(EXAMPLES / "double_pendulum.toml")
    name = double.velocities[1]
    run = simulate(double, until=0.2, feedback=Feedback(lambda t, q, u: [-0.1 * u[1]], (name,)))

    assert np.array_equal(run.tau[:, 0], np.zeros(len(run.t)))
    assert np.allclose(run.tau[:, 1], -0.1 * run.qd[:, 1])


def test_without_names_a_law_drives_all_drives_but_those_of_prescribed_motions() -> None:
    text = (EXAMPLES / "double_pendulum.toml").read_text(encoding="utf-8")
    double = read_text(text)
    head = f"[joints.{double.joints[0].name}]\n"
    led = read_text(text.replace(head, f'{head}motion = "2*t**2"\n'))

    assert placed(double, Feedback(lambda t, q, u: 0), 1.0).places == (0, 1)
    assert placed(led, Feedback(lambda t, q, u: 0), 1.0).places == (1,)
    assert placed(double, Feedback(lambda t, q, u: 0, double.drives[1]), 1.0).places == (1,)  # type: ignore[arg-type]
    one = Gains(double, np.zeros((1, 1)), ("q1",), (str(double.drives[1]),), np.zeros(2), np.zeros(2), (0.0,))
    assert placed(double, Feedback(one), 1.0).places == (1,)


# Balls and free bodies


def test_the_difference_on_the_group_is_the_rotation_vector_and_the_way_in_the_moved_frame() -> None:
    a, b = Rotation.from_rotvec([0.3, -1.1, 0.4]), Rotation.from_rotvec([-0.5, 0.2, 2.0])
    p0, p = np.array([1.0, 2.0, 3.0]), np.array([0.5, -1.0, 2.0])

    def coordinates(at: np.ndarray, turn: Rotation) -> np.ndarray:
        x, y, z, w = turn.as_quat()
        return np.array([*at, w, x, y, z])

    one = Gains(BODY, np.zeros((1, 1)), ("x",), ("fx",), coordinates(p0, a), np.zeros(6), (0.0,))

    for sign in (1.0, -1.0):  # a quaternion and its negative are one rotation
        q = coordinates(p, b) * np.array([1, 1, 1, sign, sign, sign, sign])
        assert np.allclose(one.away(q), [*a.inv().apply(p - p0), *(a.inv() * b).as_rotvec()], atol=1e-14)
    assert np.array_equal(one.away(one.q0), np.zeros(6))
    every = replace(one, K=np.eye(6), states=state_names(BODY)[:6], inputs=BODY.drives, initial=(0.0,) * 6)
    q, small = coordinates(p, b), 1e-3 * np.eye(7)
    ahead, far = (
        [every(0.0, q + k * d, np.zeros(6)) - every(0.0, q - k * d, np.zeros(6)) for d in small] for k in (1, 2)
    )
    slope = (8 * np.array(ahead) - np.array(far)).T / 12e-3  # of fourth order
    assert np.allclose(every.slope(0.0, q, np.zeros(6))[:, :7], slope, atol=1e-8)
    upright = replace(one, q0=np.array([0, 0, 0, 1.0, 0, 0, 0]))
    assert upright.away(np.array([0, 0, 0, 1.0, 1e-200, 0, 0]))[3] == 2e-200


def test_gains_bring_a_free_body_back_from_any_turn() -> None:
    names = state_names(BODY)
    K = np.hstack([4 * np.eye(6), 4 * np.eye(6)])
    said = {"K": K.tolist(), "states": names, "inputs": list(BODY.drives), "x0": {"x": 1.0, "e0": 0.0, "e3": 2.0}}

    run = simulate(BODY, until=12.0, start={"e0": "0.6", "e1": "0.8"}, start_rates={names[9]: "1"}, feedback=said)

    assert names[:6] == [f"along {u}" for u in BODY.velocities]
    assert np.allclose(run.q[-1, :3], [1, 0, 0], atol=1e-3)
    assert abs(abs(run.q[-1, 6]) - 1) < 1e-3
    with pytest.raises(SimulateError, match=r"states: e1 is part of a quaternion, .* give along f_vx"):
        read_feedback(BODY, {**said, "states": [*names[:-1], "e1"]})
    with pytest.raises(SimulateError, match="x0: along f_vx is a displacement from x0, 0 there; give x, y, z, e0"):
        read_feedback(BODY, {**said, "x0": {"along f_vx": 1.0, "along f_vy": 0}})


# Derivatives for implicit methods


@pytest.mark.parametrize("scene", [CART, BODY, FOUR_BAR], ids=lambda scene: scene.name)
def test_derivatives_under_a_controller_are_those_of_the_whole(scene: Scene) -> None:
    def law(t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.array([math.sin(t + k) * q[0] ** 2 - 2 * u[-1] for k in range(len(control.places))])

    names = tuple(name for name in scene.drives if name)
    control = placed(scene, Feedback(law, names or (scene.velocities[0],)), 1.0)
    nq, nv = len(scene.coordinates), len(scene.velocities)
    system = state_equations(scene, Forces(fed=control.places))
    system.__dict__["loop"] = loop = Loop(control, nq, nv, 1.0, nv)
    start = read_start(scene)
    x = np.concatenate([start.q, start.u + (0.0 if scene.is_constrained else 0.3), np.zeros(int(system.works))])

    assert np.allclose(slopes(system)(0.4, x), differences(system, 0.4, x, 1e-6), atol=2e-6 if nq != nv else 1e-7)
    equations = Implicit(system)
    y, rates = equations.start(0.4, x)
    found, c, h = equations.slope(0.4, y, rates, 2.0), 2.0, 1e-6
    for k, way in enumerate(np.eye(equations.size)):
        pair = [equations.residual(0.4, y + s * h * way, rates + s * c * h * way) for s in (1, -1)]
        assert np.allclose(found[:, k], (pair[0] - pair[1]) / (2 * h), atol=1e-5)
    assert loop.slope(0.4, start.q, start.u).any()


# Bad input


def fails(t: float, q: np.ndarray, u: np.ndarray) -> float:
    return 1.0 / (0 if t > 0.25 else 1)


@pytest.mark.parametrize("method", ["dop853", "radau", METHODS[3], METHODS[4]])
@pytest.mark.parametrize("period", [None, 0.1])
def test_a_controller_that_raises_ends_the_run_with_its_words(method: str, period: float | None) -> None:
    lines: list[str] = []
    run = simulate(BLOCK, until=1.0, feedback=Feedback(fails, period=period), method=method, say=lines.append)

    assert not run.complete
    assert run.stopped.startswith("feedback: the controller raised ZeroDivisionError: ")
    assert run.t[-1] <= (0.30001 if period else 0.26)
    assert np.all(np.isfinite(run.q))
    assert not period or run.t[-1] == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (lambda t, q, u: math.nan, "returned nan for F at t = 0 s"),
        (
            lambda t, q, u: [1.0, 2.0],
            r"returned \[1.0, 2.0\], numbers of shape \(2,\), at t = 0 s; give one number a force",
        ),
        (lambda t, q, u: "much", "returned 'much', which is no force, at t = 0 s"),
        (lambda t, q, u: None, "returned nan for F|returned None, which is no force"),
        (lambda t: 0.0, "raised|function takes 1 argument; a controller is a function of"),
    ],
)
@pytest.mark.parametrize("period", [None, 0.1])
def test_a_controller_that_returns_no_force_is_told_at_the_start(law, words: str, period: float | None) -> None:
    with pytest.raises(SimulateError, match=f"feedback: the (?:controller )?(?:{words})"):
        simulate(BLOCK, until=1.0, feedback=Feedback(law, period=period))


BAD = [
    ({"states": ["x", "thta", "x_dot", "theta_dot"]}, "states: thta is not known; did you mean theta?"),
    ({"states": ["x", "x", "x_dot", "theta_dot"]}, "states: x is named twice"),
    ({"states": "x"}, "states: is no list of names"),
    ({"inputs": ["f"]}, "f is neither a drive nor a coordinate; did you mean F?"),
    ({"inputs": ["theta"]}, "theta is passive"),
    ({"K": [[1, 2, 3]]}, "K: is 1 x 3; 1 inputs and 4 states need 1 x 4"),
    ({"K": [[1, 2, 3, float("nan")]]}, "K: has an entry that is not finite"),
    ({"K": [[1, 2, 3, "a"]]}, "K: is no matrix of numbers"),
    ({"x0": {"y": 1}}, "x0: y is not known"),
    ({"x0": [1]}, "x0: is no table of numbers by name"),
    ({"u0": {"G": 1}}, "u0: G is no input"),
    ({"u0": {"F": float("inf")}}, "u0: F = inf is no finite number"),
    ({"u0": {"F": 10**400}}, "is no finite number"),
    ({"K": [[1, 2, 3, 10**400]]}, "K: is no matrix of numbers"),
    ({"K": [], "inputs": []}, "inputs: names none"),
    ({"limits": {"F": [3, -3]}}, "limits: F: nothing lies between 3 and -3"),
    ({"k": 1}, "k: is not known"),
    ({"period": "soon"}, "period: 'soon' is no number of seconds"),
    ({"period": -1}, "-1 s is no period"),
    ({"period": 1e-12}, "more than 1e+07 samples"),
    ({"delay": 0.1}, "0.1 s without a period would be a differential equation with delay"),
    ({"delay": -1, "period": 1}, "-1 s is no delay"),
    ({"limits": {"F": 0}}, "limits: F: 0 is neither a size above 0"),
    ({"limits": {"F": -3}}, "limits: F: -3 is neither a size above 0"),
    ({"limits": {"G": 1}}, "limits: G: is no input"),
    ({"limits": {"F": "a"}}, 'limits: F: "a" uses a'),
    ({"limits": {"F": 10**400}}, "is neither a size above 0"),
    ({"limits": "3 m"}, "limits: F: 3 m is in m, and N is asked for"),
]


@pytest.mark.parametrize(("more", "words"), BAD, ids=[words for _, words in BAD])
def test_bad_gains_are_told(more: dict[str, object], words: str) -> None:
    with pytest.raises(SimulateError) as fault:
        simulate(CART, until=1.0, feedback={**gains(), **more})

    assert words in str(fault.value)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"limits": [3]}, "limits: the force: [3] is neither a size above 0"),
        ({"limits": {"F": "-3 N"}}, "limits: F: '-3 N' is neither a size above 0"),
        ({"period": "0.1 m"}, "period: 0.1 m is in m, and s is asked for"),
        ({"period": 0.1, "delay": None}, "delay: None is no number of seconds"),
    ],
)
def test_what_a_controller_cannot_have_is_told(more: dict[str, Any], words: str) -> None:
    with pytest.raises(SimulateError) as fault:
        simulate(CART, until=1.0, feedback=Feedback(lambda t, q, u: 1.0, **more))

    assert words in str(fault.value)


def test_a_limit_may_be_any_kind_of_number() -> None:
    feedback = Feedback(lambda t, q, u: 30.0, ("F",), limits={"F": np.int64(3)})  # type: ignore[dict-item]

    assert simulate(CART, until=0.1, feedback=feedback).tau[-1, 0] == 3.0


def test_what_is_no_controller_and_what_needs_another_method_are_told() -> None:
    with pytest.raises(SimulateError, match=r"feedback: 3 is no controller; give a function of \(t, q, u\)"):
        simulate(CART, until=1.0, feedback=3)
    if importable("heyoka"):
        with pytest.raises(SimulateError, match="method taylor does not apply: a controller is no formula"):
            simulate(CART, until=1.0, feedback=gains(), method="taylor")
    passive = read(EXAMPLES / "free_body.toml")
    with pytest.raises(SimulateError, match="free_body has no drive; give a joint one"):
        simulate(passive, until=1.0, feedback=lambda t, q, u: 0.0)


@pytest.mark.parametrize("what", ["bode", "nyquist", "step", "margins", "stability", "controllability", "root_locus"])
def test_what_a_linear_system_answers_is_neither_a_controller_nor_a_force(what: str) -> None:
    """Its call tells where the numbers are, and is no function for that."""
    lin, of = symdyn.linearize(CART), ("theta", "F") if what in ("margins", "root_locus") else ()
    answer = lin.stability if what == "stability" else getattr(lin, what)(*of)
    name = type(answer).__name__
    for given, told in (
        ({"feedback": answer}, r"is no controller; give a function of \(t, q, u\)"),
        ({"feedback": Feedback(answer, ("F",))}, r"is no controller; give a function of \(t, q, u\)"),
        ({"forces": answer}, f"^forces: {name} .* says no forces; give a formula"),
        ({"forces": {"F": answer}}, f"^forces: F: {name} .* is no course over time; give a formula"),
        ({"forces": {"F": 1, "t": answer}}, "^forces: t = a function is not what moves"),
    ):
        with pytest.raises(SimulateError, match=told):
            simulate(CART, until=0.1, **given)


def test_gains_of_a_file_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "gains.json", tmp_path / "run.npz"
    file.write_text(json.dumps(gains([[0, -40, 0, -8]], u0={"F": 1})))
    words = ["simulate", str(EXAMPLES / "cart_pole.toml"), "--until", "0.5", "--feedback", str(file), "-o", str(out)]

    assert main([*words, "--start", "theta=0.1"]) == 0
    held = np.load(out)
    assert main([*words, "--start", "theta=0.1", "--period", "0.05", "--delay", "0.05", "--limits", "F=2"]) == 0
    sampled = np.load(out)
    assert main([*words, "--start", "theta=0.1", "--period", "0.05", "--delay", "0.05", "--limits", "2 N"]) == 0
    of_one_force = np.load(out)
    assert main([*words, "--limits", "F=-2,G=1", "--delay", "0.1", "--method", "dopp"]) == 1
    told = capsys.readouterr().err
    assert main([*words[:4], "--period", "1"]) == 1
    alone = capsys.readouterr().err
    file.write_text("{")
    assert main(words) == 1
    broken = capsys.readouterr().err

    assert held["tau"][0, 0] == pytest.approx(5.0)
    assert np.ptp(held["tau"][:, 0]) > 1
    assert sampled["tau"][0, 0] == 1.0
    assert np.abs(sampled["tau"]).max() == 2.0
    assert np.array_equal(of_one_force["tau"], sampled["tau"])
    assert "G: is no input of the controller" in told
    assert "without a period" in told
    assert "dopp is not known" in told
    assert "--period: of --feedback, which is not given" in alone
    assert "gains.json: is no JSON: Expecting property name" in broken


SAIL = """
name = "sail"
gravity = [0, 0, 0]
[inputs.u]
[bodies.boat]
mass = 2
[joints.x]
type = "prismatic"
parent = "ground"
child = "boat"
axis = [1, 0, 0]
drive = false
[loads.wind]
body = "boat"
force = ["sqrt(u)", 0, 0]
"""


class WaitedError(Exception):
    """Nothing came in time."""


@pytest.mark.mends("30.also.runs")
@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("method", ["dop853", "rk45", "rk23", "radau", "bdf", "lsoda"])
def test_a_sample_that_leaves_no_accelerations_ends_the_run_there(method: str) -> None:
    def ring(*_: object) -> None:
        raise WaitedError

    law = Feedback(lambda t, q, u: [0.15 - t], period=0.1)
    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, 20.0)
    try:
        run = simulate(read_text(SAIL), until=1, feedback=law, method=method, say=lambda line: None)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert "cannot go on after t = 0.2 s: accelerations have no finite value there" in run.stopped
    assert run.t[-1] == pytest.approx(0.2)


def test_a_controller_that_keeps_something_is_told_beside_the_pace(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A filter of a rate, asked at every stage of every step, shrank the steps without a word of why."""
    monkeypatch.setattr("symdyn.simulation.integrate.integration.FIRST", 0.05)
    monkeypatch.setattr("symdyn.simulation.integrate.integration.LONG", 0.0)
    kept = [0.0]

    def filtered(_: float, q: Any, u: Any) -> float:
        kept[0] = 0.9 * kept[0] + 0.1 * float(u[1])
        return float(50 * q[1] + 8 * kept[0])

    with pytest.warns(RuntimeWarning, match=r"asked again at the same state.*takes a period, Feedback"):
        simulate(symdyn.example("cart_pole"), until=1e-4, start={"theta": 0.05}, feedback=filtered)


def test_a_controller_that_raises_when_it_is_asked_again_ends_no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """What looks for the reason of a slow run asks it twice more."""
    again = [False]

    def look(_: object, __: float, why: Callable[[], str]) -> None:
        again[0] = True
        assert why() == ""
        again[0] = False

    def law(_: float, q: Any, u: Any) -> float:
        if again[0]:
            raise ValueError("asked again")
        return float(50 * q[1])

    monkeypatch.setattr("symdyn.simulation.integrate.integration.Outlook.look", look)

    assert simulate(symdyn.example("cart_pole"), until=0.1, start={"theta": 0.05}, feedback=law).stopped == "end"
