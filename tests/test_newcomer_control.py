"""Controllers and weights as one writes them who knows another tool, and what comes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import (
    LinearizeError,
    SimulateError,
)
from symdyn.linear.weights import read_weights
from symdyn.scene.toml import read_text
from symdyn.simulation import read_feedback

pytestmark = pytest.mark.runs("cc")

CART = symdyn.example("cart_pole")


def test_rows_are_kept_up_to_where_a_controller_has_no_value() -> None:
    with pytest.warns(RuntimeWarning, match="rows until t = 1 s are kept"):
        run = symdyn.simulate(CART, until=2, feedback=lambda t, q, u: float("nan") if t > 1 else 0.0)
    assert 1 - 1e-6 < run.t[-1] <= 1
    assert len(run.t) >= 100
    assert "at t = 1" in run.stopped


def test_gains_act_on_an_ensemble_as_on_each_of_its_runs() -> None:
    loop = symdyn.linearize(CART).lqr({"x": 1, "theta": 10}, {"F": 0.1})
    starts, given = [0.1, 0.2], {"until": 1, "measures": ("end(x)", "max(abs(F))")}
    runs = symdyn.ensemble(CART, start={"theta": starts}, feedback=loop, **given)  # type: ignore[arg-type]
    assert "lockstep" in runs.notes[0]
    limited = symdyn.ensemble(CART, start={"theta": starts}, feedback=symdyn.Feedback(loop, limits=100), **given)  # type: ignore[arg-type]
    for k, theta in enumerate(starts):
        one = symdyn.simulate(CART, until=1, start={"theta": theta}, feedback=loop)
        assert runs["end(x)"][k] == pytest.approx(one["x"][-1], abs=1e-7)
        assert limited["end(x)"][k] == pytest.approx(one["x"][-1], abs=1e-7)


def test_a_sweep_takes_a_controller_and_its_store_knows_it(tmp_path: Path) -> None:
    pytest.importorskip("zarr", reason="needs a store")
    given = {"over": "mp=[0.1,0.2]", "measure": "end(theta)", "until": 0.1, "start": {"theta": 0.1}}
    law, other = (symdyn.pid("theta", "F", kp=kp) for kp in (-20, -30))
    runs = symdyn.sweep(CART, feedback=law, output=tmp_path / "a.zarr", **given)  # type: ignore[arg-type]
    assert runs["end(theta)"][0] != runs["end(theta)"][1]
    with pytest.raises(SimulateError, match="feedback"):
        symdyn.sweep(CART, feedback=other, output=tmp_path / "a.zarr", **given)  # type: ignore[arg-type]


@pytest.mark.parametrize("reference", [0.3, "0.3*(1 - exp(-t))", lambda t: 0.3])
def test_a_reference_of_gains_is_another_set_point(reference: object) -> None:
    loop = symdyn.linearize(CART).lqr({"x": 1, "theta": 10}, {"F": 0.1})
    run = symdyn.simulate(CART, until=15, feedback=symdyn.Feedback(loop, reference={"x": reference}))
    assert run["x"][-1] == pytest.approx(0.3, abs=1e-4)


def test_gains_over_time_hold_before_and_behind_their_times() -> None:
    loop = symdyn.linearize(CART).lqr({"x": 1, "theta": 10}, {"F": 0.1})
    said = {**loop.gains(), "t": [1, 2], "K": [loop.K, 2 * loop.K], "x0": {"x": [0.1, 0.3]}}
    law = read_feedback(CART, said).law
    at, still = np.array([0.2, 0.1]), np.zeros(2)
    for t, K, x0 in ((0, loop.K, 0.1), (1.5, 1.5 * loop.K, 0.2), (3, 2 * loop.K, 0.3)):
        assert law(t, at, still) == pytest.approx(-K @ [at[0] - x0, at[1], 0, 0])
    with pytest.raises(SimulateError, match="with t, 2 times, K takes as many matrices"):
        read_feedback(CART, {**said, "K": [loop.K]})
    with pytest.raises(SimulateError, match="t: give two times or more that rise"):
        read_feedback(CART, {**said, "t": [2, 1]})


def test_a_motion_that_is_tracked_is_come_back_to() -> None:
    run = symdyn.simulate(CART, until=2, forces="F=0.1*sin(t)", start={"theta": "pi"}, every=0.05)
    follows = symdyn.linear.track(run, {"x": 10, "theta": 100}, {"F": 0.1})
    off = symdyn.simulate(CART, until=2, start={"theta": "pi+0.3"}, feedback=follows)
    assert abs(off["theta"][-1] - run["theta"][-1]) < 0.02
    along = symdyn.simulate(CART, until=2, start={"theta": "pi"}, feedback=follows)
    assert abs(along["x"][-1] - run["x"][-1]) < 1e-4


WRONG_CONTROLLERS: dict[str, tuple[object, dict[str, object]]] = {
    "a controller is a function of (t, q, u)": (lambda t, x: 0, {}),
    "these are 2 controllers, and a run has one; join them": ([symdyn.pid("x", "F", kp=1)] * 2, {}),
    "reference: xx is not among x, theta, x_dot, theta_dot; did you mean x?": (
        [[1, 1, 1, 1]],
        {"reference": {"xx": 1}},
    ),
    "0.1 is one number for 4": ([[1, 1, 1, 1]], {"reference": 0.1}),
}


@pytest.mark.parametrize("told", WRONG_CONTROLLERS)
def test_controllers_that_cannot_act_are_told_what_would(told: str) -> None:
    law, settings = WRONG_CONTROLLERS[told]
    with pytest.raises(SimulateError, match=re.escape(told)):
        read_feedback(CART, symdyn.Feedback(law, **settings))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"limits": {"F": -0.5}}, "limits: F: -0.5 is neither a size above 0"),
        ({"limits": -0.5}, "limits: the force: -0.5 is neither a size above 0"),
        ({"period": 0}, "period: 0 s is no period; give one above 0"),
        ({"delay": 0.01}, "0.01 s without a period would be"),
    ],
)
def test_times_and_limits_of_no_controller_are_refused_where_it_is_made(settings: dict[str, object], told: str) -> None:
    gains = symdyn.linearize(CART).lqr()
    for law in (gains, lambda t, q, u: 0.0):
        with pytest.raises(SimulateError, match=re.escape(told)):
            symdyn.Feedback(law, **settings)  # type: ignore[arg-type]
    assert symdyn.Feedback(symdyn.linearize(CART).lqr(period=0.01), delay=0.01).delay == 0.01


def test_one_input_takes_its_limit_as_a_number() -> None:
    run = symdyn.simulate(CART, until=0.5, feedback=symdyn.Feedback(lambda t, q, u: 100 * t, limits=3))
    assert abs(run["F"]).max() == 3


WEIGHED = {"Q": ("x", "theta", "x_dot", "theta_dot"), "R": ("F",)}


def test_weights_as_one_would_write_them_are_told_how() -> None:
    with pytest.raises(LinearizeError, match="write Q=x:1;theta:10;x_dot:0;theta_dot:0, or"):
        read_weights("--lqr", ["Q=diag(1,10,0,0)"], WEIGHED)


def test_complex_weights_are_no_real_ones() -> None:
    """The imaginary part was left out with no word of ours."""
    lin = symdyn.linearize(CART)
    for given, told in (({"N": 1j * np.ones((4, 1))}, "N: is no matrix of 4 x 1"), ({"Q": 1j * np.eye(4)}, "Q: is no")):
        with pytest.raises(LinearizeError, match=told):
            lin.lqr(**given)  # type: ignore[arg-type]


def test_a_regulator_with_a_cross_term_is_that_of_python_control_and_costs_what_it_says() -> None:
    lin = symdyn.linearize(CART)
    rng = np.random.default_rng(1)
    both = rng.normal(size=(5, 5))
    both = both @ both.T
    Q, N, R = both[:4, :4], both[:4, 4:], both[4:, 4:]
    K, S, E = found = lin.lqr(Q, R, N=N)
    A = lin.A - lin.B @ K
    assert np.allclose(found.closed_loop.poles, E)
    assert np.allclose(A.T @ S + S @ A, -(Q - N @ K - K.T @ N.T + K.T @ R @ K), atol=1e-8 * abs(S).max())  # Lyapunov
    assert np.allclose(K, np.linalg.solve(R, lin.B.T @ S + N.T))
    control = pytest.importorskip("control", reason="the reference")
    theirs = control.lqr(lin.A, lin.B, Q, R, N)
    assert np.allclose(K, theirs[0])
    assert np.allclose(S, theirs[1])


@pytest.mark.parametrize("period", [None, 0.05])
def test_integrals_are_those_of_python_control_and_hold_against_a_push(period: float | None) -> None:
    lin = symdyn.linearize(CART)
    Q = np.diag([10.0, 100, 0, 0, 10])
    K, S, E = found = lin.lqr(Q, 0.1, period, integral="x")
    assert np.allclose(np.sort_complex(found.closed_loop.poles), np.sort_complex(E))
    push = read_text(
        symdyn.scene.write_text(CART, "toml").text + '\n[loads.wind]\nbody = "cart"\nforce = [0.4, 0, 0]\n'
    )
    given = {"until": 25, "feedback": symdyn.Feedback(found, reference={"x": 0.3})}
    assert symdyn.simulate(push, **given)["x"][-1] == pytest.approx(0.3, abs=1e-5)  # type: ignore[arg-type]
    off = symdyn.simulate(
        push, until=40, feedback=symdyn.Feedback(lin.lqr(Q[:4, :4], 0.1, period), reference={"x": 0.3})
    )
    assert abs(off["x"][-1] - 0.3) > 0.01
    control = pytest.importorskip("control", reason="the reference")
    if period is None:
        theirs = control.lqr(lin.A, lin.B, Q, [[0.1]], integral_action=lin.C[[0]])
        assert np.allclose(S, theirs[1])
        assert np.allclose(K, theirs[0])
        return
    step, scale = lin.discretize(period), np.diag([1, 1, 1, 1, period])  # it sums x, and not x dt
    theirs = control.dlqr(step.A, step.B, scale @ Q @ scale, [[0.1]], integral_action=lin.C[[0]])
    assert np.allclose(K @ scale, theirs[0])


def test_a_filter_of_an_accelerometer_keeps_the_poles_of_its_parts() -> None:
    found = symdyn.linearize(CART, outputs=["x", "x_ddot"]).lqg()
    assert found.regulator.system.D[1, 0] != 0
    parts = np.concatenate([found.regulator.poles, found.observer.poles])
    assert np.allclose(np.sort_complex(found.closed_loop.poles), np.sort_complex(parts), atol=1e-6)


def test_what_python_control_unpacks_is_the_same_here() -> None:
    control = pytest.importorskip("control", reason="the reference")
    loop = symdyn.linearize(CART).lqr()
    (mag, phase, omega), theirs = loop.loop.bode(), loop.loop.to_control()
    expected = control.frequency_response(theirs, omega)
    assert np.allclose(mag, expected.magnitude)
    assert np.allclose(np.exp(1j * phase), np.exp(1j * expected.phase))
    assert np.allclose([*loop.loop.margins()], control.margin(theirs))
    t, y = loop.closed_loop.step()
    assert np.allclose(y, control.step_response(loop.closed_loop.to_control(), t).outputs, atol=1e-9)


def test_a_motion_that_ends_at_rest_is_held_there_by_the_forces_of_rest() -> None:
    pendulum = symdyn.example("pendulum")
    motion = symdyn.inverse(pendulum, "q1=0.5*(1-cos(pi*t))", np.linspace(0, 1, 21))  # which stops at once, at 1 rad
    run = symdyn.simulate(
        pendulum, until=4, start={"q1": 0}, feedback=symdyn.linear.track(motion, {"q1": 10}, {"tau1": 1})
    )
    rest = float(symdyn.inverse(pendulum, "q1=1", [0.0])["tau1"][0])

    assert abs(motion["tau1"][-1] - rest) > 0.1
    assert run["q1"][-1] == pytest.approx(1, abs=1e-5)
    assert run["tau1"][-1] == pytest.approx(rest, abs=1e-4)
    assert not run.notes


def test_a_motion_that_does_not_end_at_rest_tells_what_holds_behind_it() -> None:
    fall = symdyn.simulate(CART, until=0.5, every=0.05, start={"theta": "0.1"})
    follows = symdyn.linear.track(fall, {"x": 10, "theta": 100}, {"F": 0.1})
    (note,) = symdyn.simulate(CART, until=0.6, start={"theta": "0.1"}, feedback=follows).notes

    assert note.startswith("feedback: the motion that is followed ends at t = 0.5 s, not at rest")


def test_a_regulator_of_two_drives_has_the_margins_of_each_loop(capsys: pytest.CaptureFixture[str]) -> None:
    values = {"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": 9.81}
    lin = symdyn.linearize(symdyn.example("two_link"), values=values)
    reg, lqg = lin.lqr(), lin.lqg()
    for k, drive in enumerate(reg.inputs):
        j, found = 1 - k, reg.margins(drive)
        b, c = lin.B[:, [k]], reg.K[[k]]
        A = lin.A - lin.B[:, [j]] @ reg.K[[j]]
        w = np.geomspace(1e-2, 1e3, 20001)
        loop = (c @ np.linalg.solve(1j * w[:, None, None] * np.eye(len(A)) - A, b))[:, 0, 0]
        near = np.abs(loop) - 1
        crossed = np.flatnonzero(near[1:] * near[:-1] < 0)
        assert found.stable
        assert abs(found.phase) == pytest.approx(min(abs(np.degrees(np.angle(-loop[crossed])))), abs=0.1)
        assert abs(found.phase) > 60  # Kalman's inequality holds for each loop where R is diagonal
        assert lqg.margins(drive).stable
    with pytest.raises(LinearizeError, match=r'margins\("M1"\) of the regulator cuts one open'):
        reg.loop.margins()
    path, bound = (
        str(Path(symdyn.__file__).parents[1] / "examples" / "two_link.toml"),
        ",".join(f"{k}={x}" for k, x in values.items()),
    )
    assert main(["linearize", path, "--bind", bound, "--lqr", "--show", "margins"]) == 0
    assert (
        f"cut open at M2 and closed at the other drives, asymptotically stable: {reg.margins('M2').words}"
        in capsys.readouterr().out
    )
