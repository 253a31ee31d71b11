"""Runs with 31 digits: against closed forms and mpmath's Taylor method, exact starts, what is refused."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from arms import EXAMPLES
from scenes_in_time import block, pendulum

import symdyn
from symdyn.cli import main
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.errors import SimulateError
from symdyn.graph import Arithmetic, Op, evaluate
from symdyn.program import lower
from symdyn.scene import read_text
from symdyn.simulation import Trajectory, simulate
from symdyn.simulation.columns import in_full

pytestmark = pytest.mark.runs("cc")


def last(run: Trajectory) -> list[mpmath.mpf]:
    """Coordinates and velocities at the end, with all their digits."""
    assert run.low is not None
    return [mpmath.mpf(float(a)) + float(b) for a, b in zip([*run.q[-1], *run.qd[-1]], run.low[-1], strict=True)]


@pytest.fixture(autouse=True)
def digits():
    with mpmath.workdps(45):
        yield


@pytest.mark.long
def test_a_pendulum_swings_as_its_elliptic_function():
    run = simulate(pendulum(), until=3.0, start="q1=2/3", rtol=1e-28, every=1.0)
    k, w = mpmath.sin(mpmath.mpf(1) / 3), mpmath.sqrt(mpmath.mpf("9.81"))
    phase = mpmath.ellipk(k**2) - 3 * w
    wanted = 2 * mpmath.asin(k * mpmath.ellipfun("sn", phase, k=k))
    rate = -2 * k * w * mpmath.ellipfun("cn", phase, k=k)
    assert run.method == "gauss"
    assert max(abs(a - b) for a, b in zip(last(run), (wanted, rate), strict=True)) < 1e-28


@pytest.mark.long
@pytest.mark.parametrize(("rtol", "most"), [(1e-18, 1e-17), (1e-22, 1e-21), (1e-26, 1e-25)])
def test_an_error_is_about_its_tolerance(rtol, most):
    fine = simulate(pendulum(), until=3.0, start="q1=2/3", rtol=1e-30, every=3.0)
    coarse = simulate(pendulum(), until=3.0, start="q1=2/3", rtol=rtol, every=3.0)
    assert max(abs(a - b) for a, b in zip(last(fine), last(coarse), strict=True)) < most
    assert coarse.steps < fine.steps


@pytest.mark.long
def test_a_force_over_time_and_work_are_as_right():
    """2 x\" + 50 x = cos t, from x = 1/10 at rest."""
    run = simulate(block(start=0.1), forces="F=cos(t)", until=2.0, rtol=1e-28, every=0.5)
    a = 1 / mpmath.mpf(48)
    wanted = [
        a * mpmath.cos(2) + (mpmath.mpf(1) / 10 - a) * mpmath.cos(10),
        -a * mpmath.sin(2) - 5 * (mpmath.mpf(1) / 10 - a) * mpmath.sin(10),
    ]
    assert max(abs(a - b) for a, b in zip(last(run), wanted, strict=True)) < 1e-28


@pytest.mark.long
def test_a_row_at_three_tenths_is_at_three_tenths():
    """Not at the double next to it, 1e-17 earlier."""
    run = simulate(block(start=0.1), until=0.3, rtol=1e-28, every=0.1)
    t = mpmath.mpf(3) / 10
    assert run.to_csv().splitlines()[-1].startswith("0.3,")
    wanted = [mpmath.cos(5 * t) / 10, -mpmath.sin(5 * t) / 2]
    assert max(abs(a - b) for a, b in zip(last(run), wanted, strict=True)) < 1e-29


class Global(Arithmetic):
    """mpmath's own context, whose precision its Taylor method raises as it needs."""

    def constant(self, value):
        return mpmath.mpf(value.numerator) / value.denominator

    def pi(self):
        return +mpmath.pi

    def function(self, node, args):
        return {Op.SIN: mpmath.sin, Op.COS: mpmath.cos}[node.op](*args)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "start"), [("double_pendulum", "q1=3/10,q2=pi/3"), ("cart_pole", "theta=1/3")])
def test_it_agrees_with_the_taylor_method_of_mpmath(name, start):
    scene = symdyn.example(name)
    run = simulate(scene, until=0.5, start=start, rtol=1e-28, every=0.5)
    function = lower(symdyn.dynamics.derive(scene, ["forward_dynamics"])).routines[0].function
    symbols = {argument.name: argument.symbols for argument in function.arguments}
    begin = {"double_pendulum": [mpmath.mpf(3) / 10, mpmath.pi / 3, 0, 0], "cart_pole": [0, mpmath.mpf(1) / 3, 0, 0]}

    def rates(t, y):
        values = {one: mpmath.mpf(0) for group in symbols.values() for one in group}
        values |= dict(zip((*symbols["q"], *symbols["qd"]), y, strict=True))
        return [*y[2:], *evaluate(function.entries, Global(), values)]

    with mpmath.workdps(34):
        wanted = mpmath.odefun(rates, 0, [+mpmath.mpf(x) for x in begin[name]], tol=mpmath.mpf(10) ** -31)(0.5)
    assert max(abs(a - b) for a, b in zip(last(run), wanted, strict=True)) < 1e-27


@pytest.mark.long
def test_starts_and_parameters_are_the_numbers_that_were_written(tmp_path, capsys):
    out = tmp_path / "run.csv"
    words = ["--start", "q1=1/3", "--start-rates", "q2=0.1", "--until", "1", "--every", "1", "--rtol", "1e-28"]
    assert main(["simulate", str(EXAMPLES / "double_pendulum.toml"), *words, "-o", str(out)]) == 0
    names, first, end = (line.split(",") for line in out.read_text().splitlines())
    row = dict(zip(names, first, strict=True))
    assert row["q1"] == "0." + "3" * 32
    assert row["q2_dot"] == "0.1" + "0" * 31
    assert row["t"] == "0.0"
    assert len(end[1].lstrip("-0.")) >= 31
    assert "gauss (31 digits), tolerance 1e-28 (doubles have no such tolerance)" in capsys.readouterr().err
    again = tmp_path / "again.csv"
    assert main(["simulate", str(EXAMPLES / "double_pendulum.toml"), *words, "-o", str(again)]) == 0
    assert out.read_bytes() == again.read_bytes()


@pytest.mark.long
def test_all_rows_have_their_digits_and_the_first_is_the_start():
    run = simulate(symdyn.example("double_pendulum"), until=1.0, start="q1=1/3", rtol=1e-28, every=0.25)
    other = simulate(
        symdyn.example("double_pendulum"), until=1.0, start="q1=1/3", method="dop853", rtol=1e-12, every=0.25
    )
    assert run.low is not None
    assert run.low.shape == (5, 4)
    assert np.abs(run.low).max(axis=0).all()
    assert np.abs(run.q - other.q).max() < 1e-10
    assert run.q[0].tolist() == [1 / 3, 0]
    assert other.low is None


@pytest.mark.long
def test_a_quaternion_starts_with_length_one_and_keeps_it():
    scene = symdyn.example("free_body")
    (group,) = quaternions(scene)
    start = dict(zip(group, (1, 2, 2, 3), strict=True))
    run = simulate(scene, until=0.5, start=start, rtol=1e-28, every=0.5)
    first = scene.coordinates.index(group[0])
    assert run.low is not None
    for high, low in zip(run.q[:, first : first + 4], run.low[:, first : first + 4], strict=True):
        four = [mpmath.mpf(float(a)) + float(b) for a, b in zip(high, low, strict=True)]
        assert abs(mpmath.fsum(x * x for x in four) - 1) < 1e-29


def test_digits_are_those_of_the_sum():
    assert in_full(1.0, 0.0) == "1"
    assert in_full(1 / 3, float(mpmath.mpf(1) / 3 - 1 / 3)) == "0." + "3" * 32
    assert in_full(float("nan"), 0.0) == "nan"


@pytest.mark.parametrize(
    ("name", "more", "why"),
    [
        ("four_bar", {}, "method gauss does not apply: loops are closed"),
        ("cart_pole", {"stops": "x-1"}, "method gauss does not apply: it looks for no events"),
        ("cart_pole", {"forces": "F=tanh(x)"}, "there is no tanh of 31 digits in it"),
        ("cart_pole", {"forces": "F=abs(x)"}, "abs bends where it is zero, which its steps may go past unseen"),
        ("cart_pole", {"forces": "F=sign(x_dot)"}, "there is no sign of 31 digits in it"),
        ("cart_pole", {"forces": {"F": lambda t: 0.0}}, "a force comes from outside the equations"),
        ("cart_pole", {"method": "dop853"}, "method dop853 computes in doubles: give rtol=1e-16 or more"),
        ("cart_pole", {"rtol": 1e-31}, "rtol = 1e-31 is not a tolerance; give one between 1e-30 and 1"),
    ],
)
def test_what_it_is_not_for_is_refused_in_words(name, more, why):
    with pytest.raises(SimulateError, match=why):
        simulate(symdyn.example(name), until=1.0, **{"rtol": 1e-28, **more})


@pytest.mark.parametrize(
    ("more", "remedy"),
    [
        ({"method": "gauss"}, "take dop853"),
        ({"rtol": 1e-28}, "give rtol=1e-16 or more"),
        ({"method": "gauss", "rtol": 1e-28}, "take dop853 and give rtol=1e-16 or more"),
    ],
)
def test_a_refusal_says_what_would_do(more, remedy):
    with pytest.raises(SimulateError, match=f"no projection; {remedy}$"):
        simulate(symdyn.example("four_bar"), until=1.0, **more)


@pytest.mark.long
def test_limits_of_joints_are_refused_unless_they_are_to_be_ignored():
    scene = read_text(LIMITED)
    with pytest.raises(SimulateError, match="joints have limits, which end runs"):
        simulate(scene, until=1.0, rtol=1e-28)
    assert simulate(scene, until=0.1, rtol=1e-28, ignore_limits=True).complete


LIMITED = """
name = "limited"
gravity = [0, -9.81, 0]
[bodies.rod]
mass = 1
com = [0, -1, 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 0, 1]
start = "pi/3"
limits = { lower = -2, upper = 2 }
"""


@pytest.mark.long
def test_a_motion_without_bounds_ends_with_a_word():
    with pytest.warns(RuntimeWarning, match="the steps of the iteration get too short after t = "):
        run = simulate(symdyn.example("cart_pole"), forces="F=10*x_dot**2+1", until=60.0, rtol=1e-24)
    assert not run.complete


@pytest.mark.parametrize(
    ("start", "rates", "words"),
    [
        ("q1=1e7", "", r"^pendulum: q1 = 10000000 rad at t = 0 s is too large: .* below 2\^20 = 1048576 rad; "),
        ("q1=1048570", "q1=100", r"^pendulum: q1 = 104857\d.* rad at t = 0.0\d* s is too large: sines of 31 digits"),
    ],
)
def test_an_angle_that_is_too_large_for_its_sines_is_told(start, rates, words):
    """It was called stiff."""
    with pytest.warns(RuntimeWarning, match=words):
        run = simulate(pendulum(), until=1.0, start=start, start_rates=rates, rtol=1e-28)
    assert not run.complete


@pytest.mark.runs("cc")
def test_sweeps_take_31_digits_and_derivatives_of_runs_keep_to_doubles():
    cart = symdyn.example("cart_pole")
    swept = symdyn.sweep(cart, "mc=[1, 2]", "end(theta)", until=0.1, start="theta=0.2", rtol=1e-28)
    one = simulate(cart, until=0.1, start="theta=0.2", rtol=1e-28, values={"mc": 2})
    assert swept["end(theta)"][1] == one["theta"][-1]
    with pytest.raises(SimulateError, match="give one between 1e-16 and 1"):
        symdyn.sensitivity(cart, until=1.0, rtol=1e-28)
