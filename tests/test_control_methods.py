"""What a linear system answers: against python-control, by its numbers in tests/data/control.json and by itself.

`python tests/control_reference.py` printed the numbers with python-control 0.10.2, so that a bare install is held to
them. Where python-control is installed, mechanisms of the examples are compared with it as they are.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

import symdyn
import symdyn.scene as declared
from symdyn.errors import LinearizeError
from symdyn.linear import Linearization, StateSpace
from symdyn.scene import bind
from symdyn.simulation import Feedback

CONTROL = json.loads((Path(__file__).parent / "data" / "control.json").read_text(encoding="utf-8"))
ANSWERS, TOGETHER = CONTROL["answers"], CONTROL["together"]
WEIGHTS: dict[str, tuple[Any, Any, Any, Any]] = {
    "cart_pole": ({"x": 10, "theta": 100}, {"F": 0.1}, {"F": 1}, {"x": 1e-4, "theta": 1e-4}),
    "arm": ({"q1": 10, "q2": 1}, {"M1": 0.1, "M2": 0.2}, {"M1": 1, "M2": 1}, {"q1": 1e-4, "q2": 1e-4}),
}


@cache
def answered(name: str) -> StateSpace:
    """Return a system of the file of numbers."""
    told = ANSWERS[name]
    return StateSpace(told["A"], told["B"], told["C"], told["D"], name=name)


@cache
def mechanism(name: str) -> Linearization:
    """Return a mechanism of the examples, next to a point."""
    if name != "arm":
        return symdyn.linearize(symdyn.example(name))
    arm = bind(symdyn.example("two_link"), {"m1": 1, "m2": 2, "h1": 0.4, "h2": 0.3, "g": 9.81})
    return symdyn.linearize(arm, forces={"M1": "-0.3*q1_dot", "M2": "-0.3*q2_dot"})


def same(values: Any, wanted: Any, tolerance: float = 1e-7) -> None:
    """Hold complex numbers to others, each to its nearest."""
    left = [complex(*one) if isinstance(one, list) else complex(one) for one in wanted]
    assert len(values) == len(left)
    for value in values:
        nearest = min(left, key=lambda one: abs(one - value))
        assert abs(nearest - value) <= tolerance * max(1.0, abs(value))
        left.remove(nearest)


@pytest.mark.parametrize("name", ANSWERS)
def test_poles_zeros_and_root_loci_are_those_of_python_control(name: str) -> None:
    one, told = answered(name), ANSWERS[name]
    square = StateSpace(one.A, one.B, one.C[: one.B.shape[1]], one.D[: one.B.shape[1]])

    same(one.poles, told["poles"])
    same(square.zeros, told["zeros"], 1e-6)
    locus = one.root_locus(one.outputs.names[0], one.inputs.names[0], [0.5, 2.0, 10.0])
    for row, wanted in zip(locus.poles, told["root_locus"], strict=True):
        same(row, wanted, 1e-6)


@pytest.mark.parametrize("name", ANSWERS)
def test_margins_are_those_of_python_control(name: str) -> None:
    """The distance takes in ω = 0 and ∞, where |1 + G| need not be least between its neighbours."""
    one, told = answered(name)["y1", "w1"], ANSWERS[name]
    found = one.margins()
    gain, phase, distance, phase_crossover, gain_crossover, _ = told["margins"]

    assert_allclose([found.gain, found.phase], [gain, phase], rtol=1e-6)
    assert_allclose([found.phase_crossover, found.gain_crossover], [phase_crossover, gain_crossover], rtol=1e-6)
    ends = [abs(1 + one.D[0, 0])]
    if not one.spectrum.zeros:
        ends.append(abs(1 + (one.D - one.C @ np.linalg.solve(one.A, one.B))[0, 0]))
    assert found.distance == pytest.approx(min(distance, *ends), rel=1e-6)
    if math.isfinite(phase):
        assert found.delay == pytest.approx(math.radians(phase % 360) / gain_crossover, rel=1e-6)
    closed = np.linalg.eigvals(one.A - one.B @ one.C / (1 + one.D[0, 0]))
    assert found.stable == bool(closed.real.max() < 0)


@pytest.mark.parametrize("name", ANSWERS)
def test_sampled_margins_are_those_of_python_control(name: str) -> None:
    """But for the pole upright python-control interpolates between frequencies, and is right to some digits."""
    told = ANSWERS[name]
    found = answered(name)["y1", "w1"].discretize(told["period"]).margins()
    gain, phase, _, phase_crossover, gain_crossover, _ = told["sampled_margins"]

    close = 1e-6 if name == "loop of cart_pole" else 2e-3
    assert_allclose([found.gain, found.phase], [gain, phase], rtol=close)
    assert_allclose([found.phase_crossover, found.gain_crossover], [phase_crossover, gain_crossover], rtol=close)


@pytest.mark.parametrize("name", ANSWERS)
def test_responses_over_time_are_those_of_python_control(name: str) -> None:
    one, told = answered(name), ANSWERS[name]
    sampled = one.discretize(told["period"])

    for kind, system, end, points, skip in (
        ("step", one, told["until"], 401, 50),
        ("impulse", one, told["until"], 401, 50),
        ("sampled_step", sampled, told["period"] * 7.5, None, 1),
        ("sampled_impulse", sampled, told["period"] * 7.5, None, 1),
    ):
        found = getattr(system, kind.removeprefix("sampled_"))(until=end, points=points)
        wanted = np.array(told[kind]).transpose(2, 0, 1)
        assert_allclose(found.values[::skip], wanted, rtol=1e-6, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize("name", ANSWERS)
def test_what_is_told_of_a_step_is_what_python_control_tells(name: str) -> None:
    one, told = answered(name)["y1", "w1"], ANSWERS[name]
    wanted, step = told["step_info"], told["until"] / 4000
    closed = StateSpace(one.A - one.B @ one.C, one.B, one.C)
    found = closed.step(until=told["until"], points=4001).info()

    for key, theirs in {"rise_time": "RiseTime", "settling_time": "SettlingTime", "peak_time": "PeakTime"}.items():
        assert_allclose(found[key], wanted[theirs], atol=1.001 * step)
    assert_allclose(found["final"], wanted["SteadyStateValue"], rtol=1e-9)
    assert_allclose(found["peak"], wanted["Peak"], rtol=1e-8)
    if wanted["Overshoot"]:
        assert_allclose(found["overshoot"], wanted["Overshoot"], rtol=1e-6)


@pytest.mark.parametrize("name", ["cart_pole", "arm"])
def test_regulator_and_filter_together_are_those_of_python_control(name: str) -> None:
    found, alone = mechanism(name).lqg(*WEIGHTS[name]), mechanism(name).lqr(*WEIGHTS[name][:2])

    same(found.closed_loop.poles, TOGETHER[name]["closed_poles"], 1e-6)
    same(found.closed_loop.poles, [*alone.poles, *found.observer.poles], 1e-6)  # they are separate
    same(alone.closed_loop.poles, alone.poles, 1e-8)
    assert found.inputs == mechanism(name).outputs
    same(np.linalg.eigvals(found.loop.A - found.loop.B @ found.loop.C), found.closed_loop.poles, 1e-6)


def test_poles_are_placed_as_python_control_places_them() -> None:
    wanted = [-2, -3, -4 + 1j, -4 - 1j]

    assert_allclose(mechanism("cart_pole").place(wanted).K[0], TOGETHER["cart_pole"]["place"], rtol=1e-9)
    same(mechanism("arm").place(wanted).poles, wanted)
    sampled = mechanism("arm").place(np.exp(0.01 * np.array(wanted)), 0.01)
    same(sampled.closed_loop.poles, np.exp(0.01 * np.array(wanted)))


@pytest.mark.parametrize("name", ["cart_pole", "arm", "four_bar", "furuta"])
def test_mechanisms_are_to_python_control_what_they_are_here(name: str) -> None:
    control = pytest.importorskip("control")
    one = mechanism(name) if name != "four_bar" else symdyn.linearize(symdyn.example(name), anywhere=True)
    theirs = one.to_control()

    assert theirs.name == one.scene.name
    assert (theirs.input_labels, theirs.output_labels) == (list(one.inputs.names), list(one.outputs.names))
    again = StateSpace.from_control(theirs)
    assert (again.A == one.A).all()
    assert again.states.names == one.states.names
    assert StateSpace.from_control(one.discretize(0.1).to_control()).period == 0.1
    omega = np.geomspace(0.1, 100, 17)
    assert_allclose(one.bode(omega=omega).response, np.moveaxis(theirs(1j * omega, squeeze=False), 2, 0), rtol=1e-9)
    damping = control.damp(theirs, doprint=False)
    mine = [(mode.frequency * 2 * np.pi, mode.damping) for mode in one.modes for _ in range(1 + mode.oscillates)]
    known = [(w, zeta) for w, zeta in zip(*damping[:2], strict=True) if w > 1e-3]
    assert_allclose(sorted(mine), sorted(known), rtol=1e-6, atol=1e-6)


def test_a_nyquist_plot_goes_through_the_same_points_as_python_control() -> None:
    control = pytest.importorskip("control")
    loop = answered("loop of cart_pole")
    theirs = control.nyquist_response(loop.to_control())
    omega = theirs.contour.imag[theirs.contour.imag > 0][::20]

    assert_allclose(loop.nyquist(omega=omega).response[:, 0, 0], loop.to_control()(1j * omega), rtol=1e-9)
    assert theirs.count == -1  # one turn against the clock about -1: the open loop has one pole that grows
    assert loop.margins().stable


def test_transfer_functions_of_python_control_become_systems() -> None:
    control = pytest.importorskip("control")
    found = StateSpace.from_control(control.tf([1, 2], [1, 3, 5, 0], name="G", inputs="u", outputs="y"))

    assert (found.name, found.inputs.names, found.outputs.names) == ("G", ("u",), ("y",))
    same(found.zeros, [-2])
    with pytest.raises(LinearizeError, match="system: the transfer function is improper"):
        StateSpace.from_control(control.tf([1, 2, 3], [1, 3]))
    with pytest.raises(LinearizeError, match="sampled with no period"):
        StateSpace.from_control(control.ss([[0.5]], [[1]], [[1]], 0, True))
    with pytest.raises(LinearizeError, match="str is no StateSpace or TransferFunction"):
        StateSpace.from_control("G")
    scipys = signal.StateSpace(-np.eye(2), np.eye(2), [[1.0, 2.0]], [[0.0, 0.0]], dt=0.1)
    assert (StateSpace.from_control(scipys).C == [[1, 2]]).all()
    assert StateSpace.from_control(scipys).period == 0.1


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("seen", "period"), [(["x", "theta"], None), (["x", "theta"], 0.02), (["point_tip_x"], None)], ids=str
)
def test_estimates_lie_on_what_they_estimate_where_there_is_a_reference(seen: list[str], period: float | None) -> None:
    """The tip led at 0.02 m/s is the cart there and the pole upright, to first order; the velocity follows, too."""
    lin = symdyn.linearize(symdyn.example("cart_pole"), outputs=seen)
    noise = dict.fromkeys(seen, 1e-4 if period is None else 1e-2)
    controller = lin.lqg({"x": 10, "theta": 100}, {"F": 0.1}, {"F": 1}, noise, period)
    led = Feedback(controller, reference={seen[0]: "0.02*t"})

    run = symdyn.simulate(lin.scene, until=8, every=0.1 if period is None else period, feedback=led)

    assert abs(run["x_dot"][-1] - 0.02) < 1e-4  # so it stands somewhere else than where it was designed
    for name in lin.states.names:
        assert abs(run[f"{name}_estimate"][-1] - run[name][-1]) < 3e-3


@pytest.mark.runs("cc")
def test_estimates_have_the_operating_point_in_them() -> None:
    lin = symdyn.linearize(symdyn.example("pendulum"), start={"q1": math.pi}, outputs=["q1"])

    run = symdyn.simulate(lin.scene, until=0.1, start={"q1": math.pi}, feedback=lin.lqg())

    assert_allclose(run["q1_estimate"], run["q1"], atol=1e-9)


def test_a_loop_is_stable_between_the_gains_that_its_margins_say() -> None:
    regulator = mechanism("cart_pole").lqr(*WEIGHTS["cart_pole"][:2])
    margins, locus = regulator.loop.margins(), regulator.loop.root_locus()

    critical = locus.critical[-1]
    assert critical.value == pytest.approx(margins.gain, rel=1e-9)
    assert not critical.grows
    assert critical.frequency * 2 * np.pi == pytest.approx(margins.phase_crossover, rel=1e-6)
    assert margins.phase > 60  # of every such regulator (Safonov and Athans 1977), and
    assert margins.gain < 0.5


def test_a_loop_that_stays_at_an_integrator_has_its_margins_at_a_finite_frequency() -> None:
    """1/(s (s + 1)²): |G| = 1/2 where its phase is -180°, at 1 rad/s."""
    A, B, C = np.array([[0, 1, 0], [0, -1, 1], [0, 0, -1.0]]), np.eye(3)[:, [2]], np.eye(3)[[0]]
    margins = StateSpace(A, B, C).margins()

    assert margins.gain == pytest.approx(2, rel=1e-12)
    assert margins.phase_crossover == pytest.approx(1, rel=1e-12)
    assert StateSpace([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]]).margins().gain == math.inf
    with pytest.raises(LinearizeError, match=r"1 \+ D = 0"):
        StateSpace([[-1.0]], [[1.0]], [[1.0]], [[-1.0]]).margins()


@pytest.mark.runs("cc")
@pytest.mark.parametrize("period", [None, 0.02])
def test_a_run_with_the_controller_is_the_loop_that_is_closed(period: float | None) -> None:
    """Next to the point the mechanism moves as its linear loop does, whose controller is a linear system in between."""
    one = mechanism("cart_pole")
    found = one.lqg(*WEIGHTS["cart_pole"], period)
    start = 1e-4 * np.eye(8)[one.states.names.index("theta")]
    run = symdyn.simulate(
        one.scene, until=1.0, start={"theta": 1e-4}, feedback=found, method="dop853", rtol=1e-11, atol=1e-15
    )
    A = found.closed_loop.A
    end = np.linalg.matrix_power(A, 50) if period else np.linalg.matrix_power(_exponential(A / 64), 64)

    assert_allclose(run.q[-1], (end @ start)[:2], atol=1e-11)


def _exponential(A: Any) -> Any:
    values, ways = np.linalg.eig(A)
    return (ways @ np.diag(np.exp(values)) @ np.linalg.inv(ways)).real


@pytest.mark.runs("cc")
def test_a_controller_acts_about_the_point_that_it_was_found_for() -> None:
    hanging = symdyn.linearize(symdyn.example("cart_pole"), start={"theta": "pi"})
    assert_allclose(hanging.point.outputs, [0, np.pi])
    run = symdyn.simulate(hanging.scene, until=40, start={"theta": 3.0}, feedback=hanging.lqg({"x": 1, "theta": 1}))
    assert_allclose(run.q[-1], [0, np.pi], atol=1e-3)


# What one sees


ALL: dict[str, Callable[[], Any]] = {
    "Linearization": lambda: mechanism("cart_pole"),
    "Regulator": lambda: mechanism("cart_pole").lqr(),
    "Observer": lambda: mechanism("cart_pole").kalman(),
    "Compensator": lambda: mechanism("arm").lqg(),
    "StateSpace": lambda: mechanism("arm").discretize(0.1),
    "FrequencyResponse": lambda: mechanism("cart_pole").bode("theta"),
    "TimeResponse": lambda: mechanism("arm").step(until=2),
    "RootLocus": lambda: mechanism("cart_pole").root_locus("theta"),
}
WORDS: dict[str, Callable[[], Any]] = {
    "Margins": lambda: mechanism("cart_pole").margins("theta"),
    "Transfer": lambda: mechanism("cart_pole").transfer("theta"),
    "Reach": lambda: mechanism("cart_pole").controllability(),
    "Stability": lambda: mechanism("cart_pole").stability,
}


@pytest.mark.parametrize("name", WORDS)
def test_what_has_no_plot_is_short_and_shows_itself(name: str) -> None:
    found = WORDS[name]()

    assert type(found).__name__ == name
    assert len(repr(found)) < 250
    assert "img" not in found._repr_mimebundle_()["text/html"].rpartition("</style>")[2]


def test_a_channel_is_chosen_by_name_everywhere() -> None:
    arm = mechanism("arm")

    for whole, one in ((arm.step(until=2), arm.step("q2", "M1", until=2)),
                       (arm.impulse(until=2), arm.impulse("q2", "M1", until=2))):  # fmt: skip
        assert_allclose(whole["q2", "M1"].values, one.values, rtol=1e-9, atol=1e-12)
        assert (one.outputs.names, one.inputs.names) == (("q2",), ("M1",))
    for ask in (arm.bode, arm.nyquist):
        assert_allclose(ask(omega=[1, 2])["q2", "M1"].response, ask("q2", "M1", [1, 2]).response)
    with pytest.raises(LinearizeError, match="output: q3 is not known"):
        arm.step()["q3", "M1"]


def test_frequencies_are_shown_in_one_unit_in_plots_and_notebooks() -> None:
    pytest.importorskip("matplotlib")
    for hertz, unit in ((False, "rad/s"), (True, "Hz"), ([1.0, 2.0], "Hz")):
        found = mechanism("cart_pole").bode(hertz=hertz)
        assert found.unit == unit
        assert (
            found._figure().figure(1).axes[-1].get_xlabel()
            == found.plot().axes[-1].get_xlabel()
            == f"frequency, {unit}"
        )


def test_what_was_meant_is_told() -> None:
    one = mechanism("cart_pole")

    with pytest.raises(AttributeError, match=r"Linearization has no attribute 'bod'; did you mean bode\?"):
        one.bod  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'eigenvalues'; it is poles"):
        one.eigenvalues  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"symdyn has no 'lqr'; it is symdyn\.linearize\(\.\.\.\)\.lqr"):
        symdyn.lqr  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'untill'; did you mean until\?"):
        one.step(untill=3)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="unexpected keyword argument 'of'; it is measures"):
        symdyn.pid(of="theta", inputs="F", kp=1)  # type: ignore[call-arg]
    with pytest.raises(LinearizeError, match=r"an observer estimates the state.* give lin\.lqg\(Q, R, W, V\)"):
        symdyn.simulate(one.scene, until=1, feedback=one.kalman())
    assert symdyn.Feedback is Feedback


@pytest.mark.parametrize("name", ALL)
def test_every_answer_is_short_in_print_has_a_plot_and_shows_itself(name: str) -> None:
    pytest.importorskip("matplotlib")
    found = ALL[name]()

    assert type(found).__name__ == name
    assert len(repr(found)) < 500
    assert found.plot().axes
    assert found.picture("svg") == found.picture("svg")
    with pytest.raises(LinearizeError, match="kind = 'gif': give one of svg, pdf, png"):
        found.picture("gif")
    assert "text/html" in found._repr_mimebundle_()


def test_plots_are_grids_as_those_of_python_control() -> None:
    pytest.importorskip("matplotlib")
    arm = mechanism("arm")

    bode = arm.bode().plot()
    assert len(bode.axes) == 2 * 4  # of two outputs sizes and phases, of two inputs
    assert [one.get_xlabel() for one in bode.axes[-2:]] == ["frequency, rad/s"] * 2
    assert arm.bode(hertz=True).plot().axes[-1].get_xlabel() == "frequency, Hz"
    assert_allclose(np.asarray(bode.axes[0].lines[0].get_xdata(), dtype=np.float64), 2 * np.pi * arm.bode().hertz)
    assert len(arm.nyquist().plot().axes) == len(arm.step().plot().axes) == 4
    assert arm.discretize(0.1).step().plot().axes[0].lines[0].get_drawstyle() == "steps-post"


def test_a_sampled_system_has_the_modes_of_the_one_it_comes_from() -> None:
    one = mechanism("arm")
    same([mode.value for mode in one.discretize(0.01).modes], [mode.value for mode in one.modes])
    assert one.discretize(0.01).damp().rows[0][1] == pytest.approx(one.modes[0].frequency)


def test_poles_of_what_stays_are_told_above_the_modes() -> None:
    one = symdyn.linearize(symdyn.example("furuta"))  # the arm can stand anywhere
    assert len(one.damp()) == len(one.poles) - 1
    assert one.damp().title == "modes; 1 pole more at 0"
    assert one.discretize(0.01).damp().title == "modes; 1 pole more at 1"
    assert mechanism("arm").damp().title == "modes"


# What is refused


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda one: one.place([-1, -2, -3]), "poles: give 4 finite numbers, one for each of x, theta, x_dot"),
        (lambda one: one.place([-1, -2, -3, -4 + 1j]), r"poles: -4\+1j comes without its conjugate -4-1j"),
        (lambda one: one.place([-1, -1, -3, -4]), "poles: -1 is asked for more than 1 times"),
        (lambda one: one.margins(), "output: name one of x, theta"),
        (lambda one: one.margins("tetha"), "output: tetha is not known; did you mean theta"),
        (lambda one: one["theta", "G"], "input: G is not known; known are F"),
        (lambda one: one.bode(omega=[0.0]), "omega: frequencies must be finite and above zero, in rad/s"),
        (lambda one: one.bode(omega=[1.0], hertz=[1.0]), "omega, hertz: give one of them"),
        (
            lambda one: one.discretize(0.1).bode(omega=[32.0]),
            "32 rad/s is beyond half the rate of samples, 31.4159 rad/s",
        ),
        (lambda one: one.discretize(0.1).discretize(0.1), "it is sampled already, every 0.1 s"),
        (lambda one: one.discretize(0.1).root_locus("x"), "a root locus is of a system without a period"),
        (lambda one: one.root_locus("x", gains=[1, 0]), "gains: values must be finite and increase"),
        (lambda one: one.step(until=-1), "until = -1: give a time above zero"),
        (lambda one: one.step(points=1), "points, until: 1 times; give 2 to"),
        (lambda one: one.impulse().info("x"), "info: is of a step response"),
        (lambda one: one.step(until=1e5), "until = 100000 s, points = 500: dt 200.401: something grows"),
        (lambda one: one.discretize(0.0), "dt 0: a period is finite and above zero"),
    ],
)
def test_what_has_no_answer_is_told(ask: Any, message: str) -> None:
    with pytest.raises(LinearizeError, match=message):
        ask(mechanism("cart_pole"))


def test_what_no_input_moves_cannot_be_placed() -> None:
    bicycle = symdyn.linearize(symdyn.example("bicycle"))
    asked = "poles: no input moves the mode 0, of theta_R_dot; it stays there: keep it among the poles \\(0\\), .*lqr"
    with pytest.raises(LinearizeError, match=asked):
        bicycle.place([-1, -2, -3, -4, -5, -6, -7])


@pytest.mark.parametrize("period", [None, 0.05])
def test_what_no_input_moves_stays_where_it_is_kept_among_the_poles(period: float | None) -> None:
    def poles(*s: complex) -> Any:
        return np.array(s) if period is None else np.exp(period * np.array(s))

    bicycle = symdyn.linearize(symdyn.example("bicycle"))
    law = bicycle.place(poles(-1, -2, 0, -3, -4, -5, -6), period)

    np.testing.assert_allclose(sorted(law.poles.real), sorted(poles(-1, -2, 0, -3, -4, -5, -6)), atol=1e-6)

    arm = """
    [bodies.{n}]
    particles = [{{ mass = 1, at = [0, -0.5, 0] }}]
    [joints.{n}]
    type = "revolute"
    parent = "cart"
    child = "{n}"
    axis = [0, 0, 1]
    coordinate = "{n}"
    drive = false
    """
    cart = 'gravity = [0, -9.81, 0]\n[bodies.cart]\nmass = 2\n[joints.rail]\ntype = "prismatic"\nparent = "ground"\n'
    cart += 'child = "cart"\naxis = [1, 0, 0]\ncoordinate = "x"\ndrive = "F"\n'
    twins = symdyn.linearize(symdyn.scene.read_text(cart + arm.format(n="a") + arm.format(n="b"), "twins.toml"))
    with pytest.raises(LinearizeError, match=r"mode ±4\.42945i, of a, b, a_dot, b_dot; it stays there: keep it"):
        twins.place(poles(-1, -2, -3, -4, -5, -6), period)
    swing = complex(0, np.sqrt(9.81 / 0.5).round(6))  # as it is typed, from what was shown
    law = twins.place(poles(-1, -2, -3, -4, swing, -swing), period)

    for pole in poles(-1, -2, -3, -4, swing, -swing):
        assert np.abs(law.poles - pole).min() < 1e-5

    slide = (
        '[bodies.{n}]\nmass = 1\n[joints.{n}]\ntype = "prismatic"\nparent = "ground"\nchild = "{n}"\naxis = [1, 0, 0]\n'
    )
    slide += 'coordinate = "{n}"\ndrive = {drive}\n'
    two = 'gravity = "none"\n' + slide.format(n="x", drive='"F"') + slide.format(n="y", drive="false")
    two += '[springs.s]\njoint = "y"\nstiffness = -4\n'  # y grows, and is kept outside the unit circle, too
    law = symdyn.linearize(symdyn.scene.read_text(two, "two.toml")).place(poles(-5, -6, 2, -2), period)
    np.testing.assert_allclose(sorted(law.poles.real), sorted(poles(-5, -6, 2, -2)), atol=1e-8)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (([[0, 1]], [[1]], [[1]]), "A is 1 x 2, and has to be 1 x 1"),
        (([[-1]], [[1, 2]], [[1]], [[0]]), "D is 1 x 1, and has to be 1 x 2"),
        (([[-1]], [1], [[1]]), "B is no matrix of finite numbers"),
        (([[math.nan]], [[1]], [[1]]), "A is no matrix of finite numbers"),
        (([[-1]], [[1]], [[1]], None, ["x", "v"]), "states: give 1 names, not 2"),
        (([[-1]], [[1, 1]], [[1]], None, None, ["u", "u"]), "inputs: u is named twice"),
        (([[-1]], [[1]], [[1]], None, None, None, None, -0.1), "period = -0.1: give seconds above zero"),
    ],
)
def test_matrices_that_do_not_fit_are_told(given: tuple[Any, ...], message: str) -> None:
    with pytest.raises(LinearizeError, match=message):
        StateSpace(*given)


def test_weights_are_matrices_diagonals_or_one_number() -> None:
    system = symdyn.linearize(symdyn.example("cart_pole"), start={"theta": 0})
    whole = system.lqr(np.diag([10, 100, 1, 1]), [[0.1]]).K

    assert np.array_equal(system.lqr([10, 100, 1, 1], 0.1).K, whole)
    assert np.array_equal(system.lqr(np.diag([10, 100, 1, 1]), {"F": 0.1}).K, whole)


@pytest.mark.runs("cc")
def test_a_compensator_runs_as_itself_and_by_python_control_about_its_point() -> None:
    cart = symdyn.example("cart_pole")
    law = symdyn.linearize(cart, start={"theta": "pi"}).lqg(period=0.02)
    theirs = Feedback(law.to_control(), reference={"theta": "pi"})
    own, other = (symdyn.simulate(cart, until=0.4, start={"theta": 3.1}, feedback=one).q for one in (law, theirs))

    assert_allclose(own, other, atol=1e-11)
    assert float(np.abs(own - np.pi).min()) < 0.05  # about the point, not about zero


def carriage() -> Linearization:
    """1/(s + 0.5) from force to speed; nothing depends on where it is."""
    body, rail = declared.body("b", mass=1), {"axis": [1, 0, 0], "coordinate": "x", "drive": "F", "damping": 0.5}
    joints = [declared.prismatic("j", "ground", "b", **rail)]
    scene = declared.scene("carriage", gravity="none", bodies=[body], joints=joints, outputs={"v": "x_dot"})
    return symdyn.linearize(scene, outputs=["v", "x"])


def test_a_position_that_nothing_depends_on_takes_no_part_in_what_does_not_show_it() -> None:
    """Its pole at zero made the final value the last one, 0.1 % off, and a stable loop an unstable one."""
    found = carriage()
    told = found.step("v", "F", points=4001).info()

    assert told["final"] == 2
    assert told["rise_time"] == pytest.approx(np.log(9) / 0.5, rel=1e-5)
    assert told["settling_time"] == pytest.approx(np.log(50) / 0.5, rel=1e-5)
    assert found.margins("v", "F").stable
    assert np.isnan(found.step("x", "F").final[0, 0])
    assert np.isnan(found.step().final).tolist() == [[False], [True]]


def test_what_grows_beside_a_loop_makes_it_unstable_and_what_drifts_does_not() -> None:
    for beside, stable in ((-1.0, True), (0.0, True), (1.0, False)):
        A = np.diag([-1.0, beside])
        for B, C in (([[1], [0]], [[1, 0]]), ([[1], [1]], [[1, 0]]), ([[1], [0]], [[1, 1]])):
            assert StateSpace(A, B, C).margins().stable is stable
            assert StateSpace(np.eye(2) + 0.1 * A, B, C, period=0.1).margins().stable is stable


def test_a_regulator_that_leaves_a_cyclic_angle_alone_is_stable() -> None:
    body, wheel = declared.body("arm", mass=1, com=[0, 0, 0.3]), declared.body("wheel", inertia=[0.01] * 3, about="com")
    joints = [
        declared.revolute("pivot", "ground", "arm", axis=[0, 1, 0], coordinate="theta", drive=False),
        declared.revolute("axle", "arm", "wheel", axis=[0, 1, 0], coordinate="phi", drive="M", origin=[0, 0, 0.3]),
    ]
    scene = declared.scene("reaction_wheel", gravity=[0, 0, -9.81], bodies=[body, wheel], joints=joints)
    regulator = symdyn.linearize(scene).lqr({"theta": 100, "theta_dot": 10, "phi_dot": 1e-5}, 1000)

    assert regulator.loop.margins().stable


def test_a_response_that_returns_to_zero_has_no_share_of_its_final_value() -> None:
    """Its overshoot was 166407 %, of a last value of -1e-5."""
    spring = StateSpace([[0, 1], [-4, -1]], [[0], [1]], [[0, 1]])

    told = spring.step().info()

    assert told["final"] == 0
    assert all(np.isnan(told[name]) for name in ("rise_time", "overshoot", "undershoot"))
    assert told["peak"] > 0.2
    assert told["settling_time"] > told["peak_time"]  # within 2 % of the peak


def test_an_unstable_response_has_no_final_value_and_one_that_rounding_keeps_from_zero_no_overshoot() -> None:
    """It settled at 161 after 0.5 s, and overshot by 3e16 %; python-control has nan of the first."""
    lin = symdyn.linearize(symdyn.example("furuta"))
    figures = ("rise_time", "settling_time", "overshoot", "undershoot")
    angle = lin.outputs.names[1]
    grows = lin.step(angle).info()
    held = lin.lqr({lin.outputs.names[0]: 1, angle: 10}, 100).closed_loop.step(angle).info()

    assert all(np.isnan(grows[name]) for name in (*figures, "final"))
    assert all(np.isnan(held[name]) for name in figures if name != "settling_time")
    assert held["final"] == 0 < held["peak"]
