"""Controllers of other packages, PID, matrices and regulators in runs; noise, converters, and what is refused."""

from __future__ import annotations

import doctest
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import solve_ivp
from sliding_block import BLOCK
from test_feedback_linear import LEAD, accelerations, by_hand

import symdyn
from symdyn.errors import SimulateError
from symdyn.scene import read
from symdyn.simulation import Feedback, Forces, linear_law, pid, simulate
from symdyn.simulation.equations.control_loop import Loop
from symdyn.simulation.equations.controller import placed, read_feedback
from symdyn.simulation.equations.implicit import Implicit, differences, slopes
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.initial import read_start

ct = pytest.importorskip("control", reason="needs python-control")
pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"
CART = read(EXAMPLES / "cart_pole.toml")
DOUBLE = read(EXAMPLES / "double_pendulum.toml")
FOUR_BAR = read(EXAMPLES / "four_bar.toml")
START: dict[str, Any] = {"theta": "0.1"}


def last(feedback: object, scene: Any = CART, **more: Any) -> np.ndarray:
    run = simulate(scene, until=0.5, feedback=feedback, **({"start": START} | more if scene is CART else more))
    return np.concatenate([run.q[-1], run.qd[-1]])


# Linear systems of other packages


NUM, DEN = [60.0, 180.0], [1.0, 20.0]
LABELLED = ct.ss(ct.tf2ss(ct.tf(NUM, DEN)), inputs=["theta"], outputs=["F"])
SAME: dict[str, Callable[[], object]] = {
    "control.tf": lambda: Feedback(ct.tf(NUM, DEN), measures="theta"),
    "control.zpk": lambda: Feedback(ct.zpk([-3], [-20], 60), measures="theta"),
    "control.ss, named": lambda: LABELLED,
    "control.ss": lambda: Feedback(ct.tf2ss(ct.tf(NUM, DEN)), "F", measures="theta"),
    "control.interconnect": lambda: ct.interconnect(
        [ct.tf(NUM, DEN, inputs="theta", outputs="F", name="lead")], inputs=["theta"], outputs=["F"],
    ),
    "signal.TransferFunction": lambda: Feedback(signal.TransferFunction(NUM, DEN), measures="theta"),
    "signal.StateSpace": lambda: Feedback(signal.StateSpace(*signal.tf2ss(NUM, DEN)), measures=["theta"]),
    "signal.ZerosPolesGain": lambda: Feedback(signal.ZerosPolesGain([-3], [-20], 60), measures=["theta"]),
    "what has feedback()": lambda: Regulated(-1020.0),
}  # fmt: skip


class Regulated:
    """What another package may hold."""

    def __init__(self, C: float = -1020.0) -> None:
        self.C = C

    def feedback(self) -> Feedback:
        return linear_law(-20, 1, self.C, 60, "theta", "F")


@pytest.mark.parametrize("name", SAME)
def test_a_system_is_the_law_of_its_matrices(name: str) -> None:
    assert np.allclose(last(SAME[name]()), last(linear_law(*LEAD, "theta", "F")), atol=1e-9)


@pytest.mark.parametrize("period", [None, 0.01])
@pytest.mark.parametrize("made", ["control", "scipy"])
def test_a_system_of_states_keeps_them_however_much_it_measures(made: str, period: float | None) -> None:
    n, (p, m) = 4, (2, 1)
    A, B, C, D = np.diag([0.1, 0.2, 0.3, 0.4]), np.arange(8.0).reshape(n, p), np.ones((m, n)), np.zeros((m, p))
    step = {} if period is None else {"dt": period}
    system = ct.ss(A, B, C, D, *step.values()) if made == "control" else signal.StateSpace(A, B, C, D, **step)

    found = read_feedback(CART, Feedback(system, "F", measures=["x", "theta"]))

    assert found.period == period
    for kept, given in zip((found.law.A, found.law.B, found.law.C, found.law.D), (A, B, C, D), strict=True):
        assert np.array_equal(kept, given)


@pytest.mark.parametrize("kind", ["tf", "ss", "scipy"])
def test_a_sampled_system_is_the_law_of_its_matrices(kind: str) -> None:
    A, B, C, D = 0.8, 0.01, -1020.0, 60.0
    law = linear_law(A, B, C, D, "theta", "F", period=0.01)
    ss = ct.ss(A, B, C, D, dt=0.01)
    tf = ct.ss2tf(ss)
    scipys = signal.TransferFunction(tf.num[0][0], tf.den[0][0], dt=0.01)
    system: dict[str, object] = {"ss": ss, "tf": tf, "scipy": scipys}

    assert np.allclose(last(Feedback(system[kind], measures="theta")), last(law), atol=1e-9)


def test_several_signals_and_forces_by_transfer_functions_and_states() -> None:
    """What is not named are all coordinates and all drives."""
    entries = [[([-3, -40], [1, 9]), ([2], [1, 3, 2])], [([1], [1]), ([-5, -90, -9], [1, 30, 1])]]
    num, den = ([[one[k] for one in row] for row in entries] for k in (0, 1))
    system = ct.tf(num, den)
    blocks = [(j, *signal.tf2ss(*row[j])) for row in entries for j in (0, 1)]

    def rates(z: list[np.ndarray], e: np.ndarray) -> list[np.ndarray]:
        return [A @ x + B[:, 0] * e[j] for x, (j, A, B, _, _) in zip(z, blocks, strict=True)]

    def law(z: list[np.ndarray], e: np.ndarray) -> np.ndarray:
        each = [(C @ x)[0] + D[0, 0] * e[j] for x, (j, _, _, C, D) in zip(z, blocks, strict=True)]
        return np.array([each[0] + each[1], each[2] + each[3]])

    sizes = np.cumsum([len(one[1]) for one in blocks])[:-1]
    forward = symdyn.load(DOUBLE).forward_dynamics

    def whole(t: float, x: np.ndarray) -> np.ndarray:
        z, e = np.split(x[4:], sizes), -x[:2]
        return np.concatenate([x[2:4], forward(x[:2], x[2:4], law(z, e)), *rates(z, e)])

    expected = solve_ivp(whole, (0, 0.5), [0.3, -0.2] + [0] * 8, "DOP853", rtol=1e-11, atol=1e-12).y[:4, -1]
    found = last(system, DOUBLE, start={"q1": 0.3, "q2": -0.2})
    assert np.allclose(found, expected, atol=1e-8)


def test_small_deviations_are_those_of_the_linear_closed_loop() -> None:
    """The error of the linear system falls with the third power of the size, as a pole is alike on both sides."""
    lin, C = symdyn.linearize(CART, start={"theta": "0"}), ct.tf2ss(ct.tf(NUM, DEN))
    plant = ct.ss(lin.A, lin.B, np.eye(4)[1], 0)
    A = np.block([[plant.A - plant.B @ C.D @ plant.C, plant.B @ C.C], [-C.B @ plant.C, C.A]])
    loop, errors = ct.ss(A, np.zeros((5, 1)), np.eye(5), 0), []
    times = np.linspace(0, 1, 101)
    for size in (0.04, 0.02):
        y = ct.forced_response(loop, times, 0.0, [0, size, 0, 0, 0]).states
        run = simulate(
            CART, until=1, every=0.01, start={"theta": size}, feedback=Feedback(C, measures="theta"), rtol=1e-12
        )
        errors.append(np.abs(run["theta"] - y[1]).max())

    assert errors[0] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(8, rel=0.02)


# A matrix


def test_a_matrix_is_gains_of_coordinates_and_then_velocities() -> None:
    K = [[-3.162, 37.7, -5.2, 8.6]]
    said = {"K": K, "states": ["x", "theta", "x_dot", "theta_dot"], "inputs": ["F"]}

    for one in (K, K[0], np.array(K), np.array(K[0]), Feedback(np.array(K), "F")):
        assert np.array_equal(last(one), last(said))
    cut = simulate(CART, until=0.5, start=START, feedback=Feedback(K, limits={"F": 1}))
    assert np.abs(cut["F"]).max() == 1.0
    assert np.abs(cut["command_F"]).max() > 3


# PID


def saturated(v: float, most: float = 3.0) -> float:
    return float(max(-most, min(most, v)))


@pytest.mark.parametrize("antiwindup", [True, False, 0.05])
def test_a_pid_that_saturates_is_the_loop_that_one_writes_by_hand(antiwindup: bool | float) -> None:
    kp, ki, kd, T = 40.0, 60.0, 6.0, 0.02
    back = 0.0 if antiwindup is False else 1 / (np.sqrt(kd / ki) if antiwindup is True else antiwindup)

    def v(x: np.ndarray, z: np.ndarray) -> float:
        e = 0.02 - x[1]
        return float(
            kp * e + z[0] + kd * (e - (z[1] - 0.08)) / T
        )  # which begins at rest: its filter stands at e = -0.08

    expected = by_hand(
        lambda t, x, z: saturated(v(x, z)),
        lambda t, x, z: [ki * (0.02 - x[1]) + back * (saturated(v(x, z)) - v(x, z)), (0.02 - x[1] - z[1] + 0.08) / T],
        2,
    )
    law = pid("theta", "F", kp, ki, kd, reference=0.02, filter=T, limits=3, antiwindup=antiwindup)
    run = simulate(CART, until=1.0, every=0.01, start=START, feedback=law)

    found = np.column_stack([run.q, run.qd, run["pid_integral"], run["pid_filter"] + 0.08])
    assert np.abs(run["command_F"]).max() > 3.1
    assert np.abs(found - expected).max() < 1e-7
    assert run.monitors["energy"] < 1e-8
    assert any("F saturates at its limit" in note for note in run.notes)
    kinds = {one.name: (one.kind, one.unit) for one in run.columns}
    assert kinds["command_F"] == ("commands", "N")
    assert kinds["reference_theta"] == ("references", "rad")
    assert kinds["pid_integral"] == ("controller states", "")


def test_a_sampled_pid_is_its_difference_equations() -> None:
    kp, ki, kd, T, h = 40.0, 60.0, 6.0, 0.02, 0.01
    x, integral, derivative, before, told = np.array([0, 0.1, 0, 0]), 0.0, 0.0, -0.1, []
    for _ in range(60):
        e = -x[1]
        derivative = T / (T + h) * derivative + kd / (T + h) * (e - before)
        v = kp * e + integral + derivative
        told.append((*x, v, integral))
        integral += ki * h * e + h / np.sqrt(kd / ki) * (saturated(v) - v)
        before = e
        x = solve_ivp(
            lambda t, x, F: np.concatenate([x[2:], accelerations(x, F)]), (0, h), x, "DOP853", rtol=1e-12, atol=1e-13,
            args=(saturated(v),),
        ).y[:, -1]  # fmt: skip
    run = simulate(
        CART, until=0.6, every=h, start=START, feedback=pid("theta", "F", kp, ki, kd, filter=T, limits=3, period=h)
    )

    found = np.column_stack([run.q, run.qd, run["command_F"], run["pid_integral"]])[:-1]
    assert np.abs(found - np.array(told)).max() < 1e-6
    assert np.abs(found[:, 4]).max() > 3.1


def test_back_calculation_keeps_an_integral_from_winding_up() -> None:
    over, rest = [], {"x": 0}
    for one in (True, False):
        law = pid("x", "F", 20, 10, 15, reference=1, limits=1.5, antiwindup=one)
        over.append(simulate(BLOCK, until=5, start=rest, start_rates=rest, feedback=law, rtol=1e-6)["x"].max())

    assert over[0] < over[1] - 0.1


@pytest.mark.parametrize("parts", [(40, 0, 0), (40, 5, 0), (40, 0, 4), (0, 5, 0)])
@pytest.mark.parametrize("period", [None, 0.01])
def test_parts_of_a_pid_may_be_left_out(parts: tuple[float, ...], period: float | None) -> None:
    run = simulate(CART, until=0.2, start=START, feedback=pid("theta", "F", *parts, period=period))

    names = {"pid_integral": parts[1], "pid_filter": parts[2]}
    assert {name for name in run.names if name.startswith("pid")} == {name for name, one in names.items() if one}
    assert run["command_F"][0] == pytest.approx(-0.1 * parts[0])


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"kp": 0, "kd": 1}, "pid: filter: kd = 1 beside kp = 0 tells no time of a filter; give one, s"),
        ({"filter": -1, "kd": 1}, "pid: filter = -1: give a time above 0, s"),
        ({"period": 0}, "pid: period = 0: give a time above 0, s"),
        ({"antiwindup": -0.1}, "pid: antiwindup = -0.1: give a time above 0, s"),
        ({"kp": 0, "ki": 1, "limits": 3}, "pid: antiwindup: ki = 1 alone tells no time in which the integral is to"),
        ({"kp": np.inf}, "pid: kp = inf: give a finite number"),
        ({"kp": "much"}, "kp = 'much': give a number"),
        ({"inputs": "G"}, "G is neither a drive nor a coordinate"),
        ({"limits": -3}, "limits: F: -3 is neither a size above 0"),
    ],
)
def test_what_no_pid_can_be_is_told(more: dict[str, Any], words: str) -> None:
    with pytest.raises(SimulateError) as fault:
        simulate(CART, until=0.1, feedback=pid(**{"measures": "theta", "inputs": "F", "kp": 1, **more}))

    assert words in str(fault.value)


# Noise and converters


def observer(**more: Any) -> Feedback:
    """Return LQR of a Kalman predictor's estimates, sampled, from x and theta."""
    lin, h = symdyn.linearize(CART, start={"theta": "0"}), 0.01
    found = signal.cont2discrete((lin.A, lin.B, np.eye(2, 4), np.zeros((2, 1))), h)
    A, B, C = found[0], found[1], found[2]
    K = ct.dlqr(A, B, np.diag([10, 100, 1, 1.0]), np.array([[0.1]]))[0]
    L = ct.dlqe(A, np.eye(4), C, 1e-4 * np.eye(4), 1e-4 * np.eye(2))[0]
    L = A @ L
    names = [f"{name}_hat" for name in ("x", "theta", "x_dot", "theta_dot")]
    law = linear_law(A - B @ K - L @ C, -L, -K, 0 * np.ones((1, 2)), ["x", "theta"], "F", period=h, states=names)
    return replace(law, **more)


def test_an_observer_holds_the_pole_with_noise_a_delay_limits_and_a_converter() -> None:
    steps = {"theta": 1e-3, "x": 1e-3}
    law = observer(noise={"theta": 0.002}, quantisation=steps, delay=0.004, limits={"F": 5}, seed=7)
    run = simulate(CART, until=2, every=0.01, start=START, feedback=law, method="rk45")

    assert np.abs(run["theta"][-50:]).max() < 0.03
    assert np.abs(run["F"]).max() <= 5 < np.abs(run["command_F"]).max()
    assert np.std((run["measured_theta"] - run["theta"])[:-1]) == pytest.approx(0.002, rel=0.2)
    assert np.allclose(run["measured_x"][:-1], np.round(run["x"][:-1] / 1e-3) * 1e-3, atol=1e-12)
    assert np.abs(run["theta_hat"] - run["theta"])[100:].max() < 0.02
    kinds = {one.name: (one.kind, one.unit) for one in run.columns}
    assert kinds["theta_hat"] == ("estimates", "rad")
    assert kinds["theta_dot_hat"] == ("estimates", "rad/s")
    assert kinds["measured_theta"] == ("measurements", "rad")
    assert {"theta_hat", "measured_theta", "command_F"} <= set(run.held)


def test_the_same_seed_is_the_same_run() -> None:
    runs = [
        simulate(CART, until=0.2, start=START, feedback=observer(noise={"theta": 0.002}, seed=seed))
        for seed in (7, 7, 8)
    ]

    first, same, other = (run.table()[1] for run in runs)
    assert first.tobytes() == same.tobytes()
    assert np.abs(first - other).max() > 1e-4


def test_a_function_is_told_what_is_measured() -> None:
    heard: list[float] = []

    def law(t: float, q: np.ndarray, u: np.ndarray) -> float:
        heard.append(float(q[1]))
        return -40 * float(q[1])

    run = simulate(
        CART, until=0.2, every=0.01, start=START, feedback=Feedback(law, period=0.01, noise={"theta": 0.01}, seed=3)
    )

    assert np.array_equal(heard, run["measured_theta"][:-1])
    assert np.std(np.array(heard) - run["theta"][:-1]) == pytest.approx(0.01, rel=0.5)
    assert "measured_x" not in run.names


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"period": None}, "feedback: noise: is of a controller that takes samples; give it a period"),
        ({"period": None, "noise": {}, "quantisation": {"x": 1}}, "feedback: quantisation: is of a controller that"),
        ({"noise": {"thta": 1}}, "feedback: noise: thta is not among x, theta; did you mean theta?"),
        ({"noise": {"theta": -1}}, "feedback: noise: theta = -1 is below 0"),
        ({"noise": {"theta": "a"}}, 'feedback: noise: theta: "a" uses a'),
        ({"inputs": ("F", "x_dot")}, "the law makes 1 of 2 numbers, and 2 (F, x_dot) of 2 (x, theta) are asked for"),
    ],
)
def test_what_cannot_be_measured_is_told(more: dict[str, Any], words: str) -> None:
    with pytest.raises(SimulateError) as fault:
        simulate(CART, until=0.1, feedback=observer(**{"noise": {"x": 1e-3}, **more}))

    assert words in str(fault.value)


# Derivatives, closed mechanisms, forces beside


@pytest.mark.parametrize("scene", [CART, FOUR_BAR], ids=lambda scene: scene.name)
def test_derivatives_under_a_law_with_states_are_those_of_the_whole(scene: symdyn.Scene) -> None:
    names = list(scene.coordinates)
    drive = next(name for name in scene.drives if name)
    C = linear_law(
        [[-1, 0.3], [0.2, -2]], np.ones((2, 2)), [[0.7, -3]], [[3, 2]], [names[0], f"sin({names[1]})"], drive,
        reference={names[0]: f"{names[0]}*cos({names[1]}) + 0.1*sin(t)"},
    )  # fmt: skip
    for limit in (None, 1e-3):
        law = replace(C, law=replace(C.law, tracking=np.array([[2.0], [-1.0]])))
        control = placed(scene, replace(law, limits={} if limit is None else {drive: limit}), 1.0)
        system = state_equations(scene, Forces(fed=control.places))
        system.__dict__["loop"] = loop = Loop(control, system.nq, system.nv, 1.0, system.nv)
        start = read_start(scene)
        loop.start(start.q, start.u)
        x = np.concatenate([start.q, start.u, [0.4, -0.5], np.zeros(int(system.works))])

        assert loop.nz == 2
        assert np.allclose(slopes(system)(0.4, x), differences(system, 0.4, x, 1e-6), atol=2e-6)
        equations = Implicit(system)
        y, rates = equations.start(0.4, x)
        found, c, h = equations.slope(0.4, y, rates, 2.0), 2.0, 1e-6
        for k, way in enumerate(np.eye(equations.size)):
            pair = [equations.residual(0.4, y + s * h * way, rates + s * c * h * way) for s in (1, -1)]
            assert np.allclose(found[:, k], (pair[0] - pair[1]) / (2 * h), atol=1e-5)


def test_states_of_a_controller_of_a_closed_mechanism_are_left_alone_by_its_loops() -> None:
    law = linear_law(-2, 1, 3, 5, "phi", "M", reference={"phi": "0.5 + 0.2*sin(3*t)"})
    runs = [simulate(FOUR_BAR, until=0.5, feedback=law, method=name) for name in ("dop853", "radau")]
    run = runs[0]

    def moved(t: float, z: np.ndarray) -> np.ndarray:
        return np.asarray(-2 * z + 0.5 + 0.2 * np.sin(3 * t) - np.interp(t, run.t, run["phi"]))

    z = solve_ivp(moved, (0, 0.5), [0.0], max_step=0.01).y[0, -1]

    assert run.monitors["loops"] < 1e-9
    assert run["controller_x1"][-1] == pytest.approx(z, abs=1e-4)
    assert np.allclose(runs[0].q[-1], runs[1].q[-1], atol=1e-6)
    assert runs[0]["controller_x1"][-1] == pytest.approx(runs[1]["controller_x1"][-1], abs=1e-6)


def test_a_function_of_forces_acts_beside_a_law_with_states() -> None:
    law = linear_law(*LEAD, "theta", "F")
    both = simulate(CART, forces={"F": lambda t: 0.5}, until=0.5, start=START, feedback=law)
    same = simulate(CART, forces="F=0.5", until=0.5, start=START, feedback=law)

    assert np.allclose(both.q, same.q, atol=1e-8)
    assert np.allclose(both["F"] - both["command_F"], 0.5)


# Bad input


def test_a_signal_that_has_no_value_ends_the_run_with_its_name_and_time() -> None:
    for period in (None, 0.01):
        law = linear_law(-1, 1, 1, 1, "sqrt(0.3 - theta)", "F", period=period)
        run = simulate(CART, until=2, start=START, feedback=law, say=lambda line: None)

        assert "feedback: the measured signal sqrt(0.3 - theta) has no finite value at t = " in run.stopped
        assert 0.05 < run["theta"][-1] <= 0.35
        assert np.isfinite(run["theta"]).all()
    with pytest.raises(SimulateError, match="the measured signal sqrt"):
        simulate(CART, until=2, start={"theta": 1}, feedback=law)


REFUSED = [
    (ct.tf([1, 0, 0], [1, 1]), "feedback: the transfer function is improper, of degree 2 over 1"),
    (
        ct.tf([1], [1, 1]),
        "feedback: say which signals are the inputs of the system, 1 in all: Feedback(system",
    ),
    (ct.ss(ct.tf([1], [1, 1], dt=True)), "the system is sampled, but says not how often; give it a dt, or a period"),
    (ct.frd([1, 2], [1, 2]), "is no linear system; give transfer functions or A, B, C and D"),
    (ct.ss([[-1]], [[1]], [[1]], [[0]], inputs=["thta"], outputs=["F"]), "uses thta, which is not known here; did you"),
    (ct.ss([[-1]], [[1]], [[1]], [[0]], inputs=["theta"], outputs=["G"]), "G is neither a drive nor a coordinate"),
    (Feedback(LABELLED, period=0.1), "feedback: period: the system is continuous; discretise it"),
    (Feedback(ct.ss(0.5, 1, 1, 0, dt=1), "F", 2, measures="x"), "period: the system has samples every 1 s; leave it"),
    (np.eye(3), "feedback: K: is 3 x 3; 1 inputs and 4 states need 1 x 4"),
    (np.zeros((60, 60)), "feedback: K: is 60 x 60"),
    (np.array([["a"]]), "feedback: K: is no matrix of numbers"),
    ((np.ones((1, 4)), np.eye(4), np.ones(4)), "feedback: K: a tuple of several matrices, as K, S, E of a design"),
    (object, "is no controller; give a function of (t, q, u), a matrix K, gains"),
    (Feedback(3.0), "feedback: 3.0 is no controller"),
    (
        Feedback(lambda t, q, u: 0.0, measures=("x",)),
        "feedback: measures: is of linear systems; a function",
    ),
    (type("Own", (), {"feedback": lambda self: 3})(), "returned 3, which is no Feedback"),
    (
        Feedback({"K": [[1, 1]], "states": ["x", "x_dot"], "inputs": ["F"]}, period=0.1, noise={"theta": 0.1}),
        "feedback: noise: theta is none of the states of these gains, x, x_dot, so it acts on nothing",
    ),
]


@pytest.mark.parametrize(("what", "words"), REFUSED, ids=[words for _, words in REFUSED])
def test_what_is_no_controller_is_told_in_a_line(what: object, words: str) -> None:
    with pytest.raises(SimulateError) as fault:
        simulate(CART, until=0.1, feedback=what)

    assert words in str(fault.value)
    assert max(map(len, str(fault.value).splitlines())) < 400


def test_what_a_feedback_says_goes_before_what_its_system_says() -> None:
    found = read_feedback(CART, Feedback(Regulated(), limits={"F": 3}, measures=("x",)))

    assert (found.limits, found.measures, found.inputs) == ({"F": 3}, ("x",), ("F",))


@pytest.mark.long(0)
def test_what_the_page_says_of_controllers_runs() -> None:
    page = (Path(__file__).parent.parent / "docs" / "simulate.md").read_text(encoding="utf-8")
    text = page.partition("#### LQR, PID")[2].partition("\n### ")[0]
    found = doctest.DocTestRunner(verbose=False).run(doctest.DocTestParser().get_doctest(text, {}, "page", None, 0))

    assert found.attempted > 20
    assert found.failed == 0


def test_a_system_that_says_not_how_often_takes_the_period_that_is_given() -> None:
    system = ct.ss(0.5, 1, 1, 0, dt=True)
    found = read_feedback(CART, Feedback(system, "F", 0.02, measures="x"))

    assert found.period == 0.02
    assert read_feedback(CART, Feedback(ct.ss(0.5, 1, 1, 0, dt=1), "F", measures="x")).period == 1.0


def test_a_function_with_attributes_of_a_system_is_a_function() -> None:
    class Own:
        A = B = C = D = np.eye(1)
        dt = 0.01

        def __call__(self, t: float, q: np.ndarray, u: np.ndarray) -> float:
            return 40 * float(q[1])

    assert np.array_equal(last(Own()), last(lambda t, q, u: 40 * q[1]))


def test_a_controller_with_states_keeps_the_period_that_it_was_designed_for() -> None:
    cart = symdyn.example("cart_pole")
    law = symdyn.pid("theta", "F", 60, 20, 8)
    sampled = symdyn.pid("theta", "F", 60, 20, 8, period=0.02)

    for one, told in ((law, "is continuous"), (sampled, "has samples every 0.02 s")):
        with pytest.raises(symdyn.SymdynError, match=f"period = 0.01: the controller {told}"):
            symdyn.simulate(cart, until=0.1, feedback=Feedback(one, period=0.01))
    limited = symdyn.simulate(cart, until=0.1, start={"theta": 0.1}, feedback=Feedback(law, limits={"F": 5}))
    assert float(np.abs(limited["F"]).max()) == 5


def test_what_is_no_controller_is_told_as_what_it_is() -> None:
    cart = symdyn.example("cart_pole")

    with pytest.raises(symdyn.SymdynError, match=r"is the mechanism, and no controller; give lin\.lqr"):
        symdyn.simulate(cart, until=0.1, feedback=symdyn.linearize(cart, start={"theta": 0}))
    with pytest.raises(symdyn.SymdynError, match="returned None, which is no force, at t = 0 s"):
        symdyn.simulate(cart, until=0.1, feedback=Feedback(lambda t, q, u: None, period=0.05))
