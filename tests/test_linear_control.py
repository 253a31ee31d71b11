"""Transfer functions, reach, gains, sampled systems, root loci: against python-control, the bicycle's paper, and laws.

tests/data/control.json is what `python tests/control_reference.py` printed with python-control 0.10.2; the bicycle's
numbers are of Meijaard, Papadopoulos, Ruina and Schwab (Proc. R. Soc. A 463, 2007), evaluated in 50 digits.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from symdyn.cli import main
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.errors import LinearizeError
from symdyn.linear import linearize
from symdyn.linear.evolution import along_a_step
from symdyn.linear.linearized import complete, systems
from symdyn.linear.locus import CROSSINGS, read_values, root_locus
from symdyn.linear.modes import Mode, animate_modes, motion
from symdyn.linear.prepared import prepared
from symdyn.linear.search import Search
from symdyn.linear.transfer import invariant_zeros
from symdyn.linear.weights import read_weights
from symdyn.scene import bind, read, read_text
from symdyn.scene.values.letters import Input
from symdyn.simulation import Problem, simulate
from symdyn.simulation.variations import sensitivity

pytestmark = pytest.mark.long

ROOT = Path(__file__).parent.parent
DATA = ROOT / "tests" / "data"
CONTROL = json.loads((DATA / "control.json").read_text(encoding="utf-8"))
PAPER = json.loads((DATA / "bicycle_benchmark.json").read_text(encoding="utf-8"))
STATES = {
    "cart_pole": ("x", "theta", "x_dot", "theta_dot"),
    "bicycle": ("phi", "delta", "phi_dot", "delta_dot"),
}
WEIGHTS = {"cart_pole": ({"x": 10, "theta": 100}, {"F": 0.1}), "bicycle": ({"phi": 10, "delta": 1}, {"T": 1})}


def example(name):
    return read(ROOT / "examples" / f"{name}.toml")


@cache
def system(name, *outputs):
    return linearize(example(name), outputs=outputs or STATES[name][:2])


def found(name, key):
    return np.array(CONTROL[name][key])


def pairs(values):
    return sorted([float(z.real), float(z.imag)] for z in values)


def columns(name):
    return [system(name).states.names.index(one) for one in STATES[name]]


def close(values, wanted, tolerance=1e-9):
    """Whether two sets of complex numbers are one, each next to its own."""
    wanted = [complex(*one) for one in wanted]
    assert len(values) == len(wanted)
    for value in values:
        nearest = min(wanted, key=lambda one: abs(one - value))
        assert abs(nearest - value) <= tolerance * max(1.0, abs(value))
        wanted.remove(nearest)


# The benchmark bicycle

DRIVES = 'drives = [false, false, false, "lean", false]'


def test_a_mass_that_is_pushed_and_whose_place_is_seen_has_no_zeros():
    A, B, C, D = np.eye(2, k=1), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), np.zeros((1, 1))

    assert not invariant_zeros(A, B, C, D, 1.0).size
    assert_allclose(invariant_zeros(A, B, np.array([[1.0, 0.5]]), D, 1.0), [-2.0])  # a place and half its rate


def test_the_bicycle_has_the_matrices_of_its_paper():
    """M, C1, K0 and K2 out of A and B, with a torque on the lean and one on the handlebars as inputs."""
    text = (ROOT / "examples" / "bicycle.toml").read_text(encoding="utf-8")
    passive = 'units = ["m", "m", "rad", "rad", "rad"]\ndrive = false'
    assert passive in text
    scene = read_text(text.replace(passive, passive.replace("drive = false", DRIVES)), "bicycle.toml")
    M, C, K = {}, {}, {}
    for v in (0, 7):
        one = linearize(scene, values={"v": v})
        names = list(one.states.names)
        p, u = [[names.index(name) for name in group] for group in (("phi", "delta"), ("phi_dot", "delta_dot"))]
        inverse = one.B[np.ix_(u, [one.inputs.names.index(name) for name in ("lean", "T")])]
        M[v] = np.linalg.inv(inverse)
        C[v], K[v] = -M[v] @ one.A[np.ix_(u, u)], -M[v] @ one.A[np.ix_(u, p)]
    paper = {name: np.array(PAPER[name], dtype=float) for name in ("M", "C1", "K0", "K2")}

    for v in (0, 7):
        assert_allclose(M[v], paper["M"], rtol=1e-13)
        assert_allclose(C[v], v * paper["C1"], rtol=2e-12, atol=2e-12)
        assert_allclose(K[v], 9.81 * paper["K0"] + v**2 * paper["K2"], rtol=2e-12, atol=2e-11)


@pytest.mark.slow
@pytest.mark.long
def test_the_bicycle_has_the_eigenvalues_and_the_critical_speeds_of_its_paper():
    make = systems(Problem(example("bicycle")), "v")
    speeds = np.arange(0.0, 11.0)
    locus = root_locus("v", speeds, make)

    for v, row in zip(speeds, locus.poles, strict=True):
        wanted = [[float(x) for x in pair] for pair in PAPER["eigenvalues_re_im_by_speed"][f"{v:.0f}"]]
        close(row[row != 0], wanted, 1e-12)
    weave, capsize = locus.critical
    assert weave.value == pytest.approx(float(PAPER["v_weave"]), rel=1e-12)
    assert capsize.value == pytest.approx(float(PAPER["v_capsize"]), rel=1e-11)
    assert (weave.frequency > 0.5, weave.grows, capsize.frequency, capsize.grows) == (True, False, 0.0, True)
    assert [count for _, _, count in locus.ranges] == [2, 0, 1]
    assert locus.lines()[3] == "v = 4.29238 ... 6.02426: nothing grows"


# Against python-control


@pytest.mark.parametrize("name", STATES)
def test_a_and_b_are_those_that_books_write(name):
    one, k = system(name), columns(name)

    assert_allclose(one.A[np.ix_(k, k)], found(name, "A"), rtol=1e-12, atol=1e-12)
    assert_allclose(one.B[k], found(name, "B"), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("name", STATES)
def test_poles_and_zeros_are_those_of_python_control(name):
    for one, wanted in zip(system(name).transfer(), CONTROL[name]["channels"], strict=True):
        poles, found_zeros = wanted["poles"], wanted["zeros"]
        if one.output == "theta":  # where a pole and a zero of x cancel, python-control keeps both
            poles, found_zeros = [p for p in poles if p != [0, 0]], [[0.0, 0.0]]
        close(one.poles, poles)
        close(one.zeros, found_zeros)


@pytest.mark.parametrize("name", STATES)
def test_responses_are_those_of_python_control_and_of_the_transfer_functions(name):
    answer = system(name).bode(hertz=CONTROL[name]["hertz"])
    wanted = found(name, "response_real") + 1j * found(name, "response_imaginary")

    assert_allclose(answer.response[:, :, 0].T, wanted, rtol=1e-10)
    for k, one in enumerate(system(name).transfer()):
        assert_allclose([one.at(2j * np.pi * f) for f in answer.hertz], answer.response[:, k, 0], rtol=1e-10)
        s = 2j * np.pi * answer.hertz
        assert_allclose(
            np.polyval(one.numerator, s) / np.polyval(one.denominator, s), answer.response[:, k, 0], rtol=1e-9
        )


@pytest.mark.parametrize("name", STATES)
def test_gains_are_those_of_python_control(name):
    one, k, (Q, R) = system(name), columns(name), WEIGHTS[name]
    regulator, period = one.lqr(Q, R), CONTROL[name]["period"]

    assert_allclose(regulator.K[:, k], found(name, "lqr"), rtol=1e-8, atol=1e-10)
    close(regulator.poles, CONTROL[name]["lqr_poles"], 1e-8)
    assert_allclose(one.lqr(Q, R, period).K[:, k], found(name, "dlqr"), rtol=1e-7, atol=1e-9)


def test_the_gain_of_the_filter_is_that_of_python_control():
    observer = system("cart_pole").kalman({"F": 1}, {"x": 1e-4, "theta": 1e-4})

    assert_allclose(observer.L, found("cart_pole", "lqe"), rtol=1e-8)
    close(observer.poles, CONTROL["cart_pole"]["lqe_poles"], 1e-8)


@pytest.mark.parametrize("name", STATES)
def test_a_sampled_system_is_that_of_python_control(name):
    answer, k = system(name).discretize(CONTROL[name]["period"]), columns(name)

    assert_allclose(answer.A[np.ix_(k, k)], found(name, "zoh_A"), rtol=1e-12, atol=1e-12)
    assert_allclose(answer.B[k], found(name, "zoh_B"), rtol=1e-11, atol=1e-13)


# Laws


@pytest.mark.parametrize(("name", "period"), [("cart_pole", 0.05), ("cart_with_wheel", 0.02)])
def test_both_formulations_to_a_sampled_system_meet_where_the_motion_is_steady(name, period):
    scene = example(name)
    one = linearize(scene)
    exact, stepped = one.discretize(period), along_a_step(prepared(Problem(scene)), one, period)

    assert_allclose(stepped.A, exact.A, atol=1e-9 * np.abs(exact.A).max())
    assert_allclose(stepped.B, exact.B, atol=1e-9)


@pytest.mark.runs
@pytest.mark.parametrize("name", ["heavy_top", "four_bar"])
def test_along_a_motion_a_step_is_what_sensitivities_of_a_run_are(name):
    """Two ways that share no derivative: A and B along the motion, and the flow of the run's own equations."""
    scene = example(name)
    one = linearize(scene, anywhere=True)
    stepped, run = along_a_step(prepared(Problem(scene)), one, 0.05), sensitivity(scene, until=0.05, parameters=[])
    rows, columns = ([names.index(state) for state in one.states.names] for names in (run.rows, run.columns))

    assert_allclose(stepped.A, run.matrix[np.ix_(rows, columns)], atol=1e-10)
    assert np.abs(one.discretize(0.05).A - stepped.A).max() > 1e-2  # A of the beginning would not do


@pytest.mark.runs
def test_the_pole_is_held_upright_by_its_gains():
    """A run with the feedback: it comes to rest from 0.3 rad, in the end as fast as the slowest pole says."""
    scene = example("cart_pole")
    regulator = system("cart_pole").lqr(*WEIGHTS["cart_pole"])
    run = simulate(scene, until=8, start={"theta": "0.3"}, feedback=regulator.gains(), method="dop853")
    free = simulate(scene, until=2, start={"theta": "0.3"}, method="dop853")

    assert abs(run.q[-1]).max() < 1e-3
    assert abs(free.q[-1, 1]) > 1
    slowest = max(regulator.poles.real)
    ends = [np.linalg.norm(run.q[run.t >= t][0]) for t in (5, 7)]
    assert np.log(ends[1] / ends[0]) / 2 == pytest.approx(slowest, rel=0.5)


def test_gains_drive_the_drives_and_no_disturbance():
    one = linearize(replace(example("cart_pole"), inputs=(Input("gust"),)), forces={"F": "gust"})

    assert one.inputs.names == ("F", "gust")
    assert one.lqr().gains()["inputs"] == ["F"]
    with pytest.raises(LinearizeError, match="R: gust disturbs, as there is a drive to control by: F"):
        one.lqr(R={"gust": 1})
    assert_allclose(one.kalman({"gust": 1}, {"x": 1, "theta": 1}).L, one.kalman({"F": 1}).L, rtol=1e-9)


def test_what_no_input_moves_is_named():
    """A wheel's own speed: no torque on the handlebars changes it to first order."""
    reach = system("bicycle").controllability()

    assert (reach.rank, reach.order) == (6, 7)
    assert [(mark.value, mark.states) for mark in reach.hidden] == [(0j, ("theta_R_dot",))]
    assert 1e-3 < reach.margin < 1
    assert "theta_R_dot" not in {name for mark in reach.marks if not mark.hidden for name in mark.states}


def test_what_no_output_shows_is_named():
    reach = system("cart_pole", "theta").observability()

    assert (reach.rank, reach.order) == (3, 4)
    assert [mark.states for mark in reach.hidden] == [("x",)]
    assert system("cart_pole", "x").observability().hidden == ()


def test_ranks_are_those_of_python_control():
    for name, states in STATES.items():
        more = len(system(name).states) - len(states)  # y and psi, which the steering moves, and the speed
        hidden = len(system(name).controllability().hidden)
        assert system(name).controllability().rank == CONTROL[name]["controllability_rank"] + more - hidden


def test_symmetric_arms_hide_what_they_do_against_each_other():
    """Two equal pendulums on a driven cart: the force moves their sum, and their difference swings by itself."""
    arm = """
    [bodies.{n}]
    mass = 1
    com = [0, -0.5, 0]
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
    one = linearize(read_text(cart + arm.format(n="a") + arm.format(n="b"), "two.toml"))
    (hidden,) = one.controllability().hidden

    assert abs(hidden.value) == pytest.approx(np.sqrt(9.81 / 0.5))
    assert set(hidden.states) == {"a", "b", "a_dot", "b_dot"}
    with pytest.raises(LinearizeError, match=r"no input moves the mode ±4\.42945i, of a, b, a_dot, b_dot"):
        one.lqr()
    assert len(one.transfer()[0].poles) == 4  # two of six cancel
    assert [len(one.transfer()[k].denominator) for k in range(3)] == [5, 3, 3]
    close(one.transfer()[0].zeros, [[0, np.sqrt(9.81 / 0.5)], [0, -np.sqrt(9.81 / 0.5)]])


def test_zeros_of_several_inputs_and_outputs_are_those_of_the_whole():
    """G = [1/(s+1), 2/(s+3); 1/(s+1), 1/(s+1)] has the zero 1 that none of its entries has (Maciejowski)."""
    A, B = np.diag([-1.0, -3.0, -1.0]), np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
    C, D = np.array([[1.0, 2.0, 0.0], [1.0, 0.0, 1.0]]), np.zeros((2, 2))

    close(invariant_zeros(A, B, C, D, 3.0), [[1.0, 0.0]])
    close(invariant_zeros(A[:1, :1], B[:1, :1], C[:1, :1], np.array([[2.0]]), 1.0), [[-1.5, 0.0]])  # 2 + 1/(s + 1)


def test_a_place_of_rest_is_followed_as_a_torque_grows():
    """sin θ = P/(m g l): ω² = (g/l) cos θ, until it can hold no more."""
    scene = read_text(PENDULUM, "pendulum.toml")
    locus = root_locus("P", np.linspace(0, 9, 7), systems(Problem(scene, {"T": "P"}), "P"))
    omega = np.sqrt(9.81 * np.cos(np.arcsin(locus.values / 9.81)))

    assert_allclose(np.abs(locus.poles[:, 0]), omega, rtol=1e-9)
    assert not locus.critical
    with pytest.raises(LinearizeError, match="no equilibrium"):
        systems(Problem(scene, {"T": "P"}), "P")(9.82)


PENDULUM = """
gravity = [0, -9.81, 0]
[bodies.bob]
particles = [{ mass = 1, at = [0, -1, 0] }]
[joints.pin]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "theta"
drive = "T"
"""


def test_a_hoop_holds_its_bead_below_until_it_turns_at_the_root_of_g_over_r():
    """A driven turn Ω = w t: θ = 0 is stable for Ω² < g/r."""
    text = PENDULUM.replace('drive = "T"', "drive = false").replace('parent = "ground"', 'parent = "spindle"')
    text = text.replace("[bodies.bob]", "[parameters]\nw = 1\n[bodies.spindle]\n[bodies.bob]")
    text += '[joints.shaft]\ntype = "revolute"\nparent = "ground"\nchild = "spindle"\naxis = [0, 1, 0]\n'
    text += 'coordinate = "turn"\nmotion = "w*t"\n'
    locus = root_locus("w", np.linspace(1, 5, 9), systems(Problem(read_text(text, "hoop.toml")), "w"))

    assert [one.value for one in locus.critical] == [pytest.approx(np.sqrt(9.81), rel=1e-6)]


def test_the_arms_of_a_governor_are_followed_as_it_turns_faster():
    """Nothing grows, and at each speed the system is the one at the arms' own steady angle."""
    scene = example("governor")
    make = systems(Problem(scene, start_rates={"phi": "w"}), "w")
    found = [make(w) for w in (9.0, 10.0, 11.0)]
    angles = [one.point.q[scene.coordinates.index("alpha")] for one in found]

    assert angles == sorted(angles)
    assert angles[-1] - angles[0] > 0.05
    for one in found:
        assert np.abs(one.point.udot).max() < 1e-6
        assert one.dropped == ("phi",)


def test_a_disc_rolls_upright_where_it_is_fast_enough():
    """C (C + m r²) ω² > A m g r, which is ω² > g/(3 r) of a thin disc; the letter of the speed is no parameter."""
    disc = read(DATA / "found" / "rolling_disc_zxy.toml")
    upright = {"q1": "0", "q2": "0", "q3": "0", "z": "r"}
    locus = root_locus(
        "s", np.linspace(1, 8, 8), systems(Problem(disc, (), upright, {"q3": "s", "q1": "0", "q2": "0"}), "s")
    )

    assert [(one.value, one.grows) for one in locus.critical] == [
        (pytest.approx(np.sqrt(9.81 / (3 * 0.26)), rel=1e-10), False)
    ]


@pytest.mark.wide("four_bar")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", ["bicycle", "four_bar"])
def test_a_mode_is_drawn_with_its_loops_closed_and_comes_back(name, tmp_path):
    scene = example(name)
    one = linearize(scene, **({} if name == "bicycle" else {"anywhere": True}))
    t, q = motion(one, one.modes[0])

    assert_allclose(q[0], q[-1], atol=1e-12)
    assert 0.05 < np.abs(q - one.point.q).max() < 0.7
    numbers = prepared(Problem(scene)).functions.w.loops.numbers
    assert max(np.abs(numbers.residual(row)).max() for row in q) < 1e-9
    written = animate_modes(one, tmp_path / "mode.svg")
    assert len(written) == len([mode for mode in one.modes if np.abs(mode.shape[: one.positions]).max() > 1e-6])
    assert all("<animate" in path.read_text(encoding="utf-8") for path, _ in written)
    assert len(t) == len(q)


def test_weights_and_variances_say_their_units():
    lin = system("cart_pole")
    assert lin.lqr({"x": "1 1/cm^2"}, {"F": "4 1/N^2"}).K.tolist() == lin.lqr({"x": 1e4}, {"F": 4}).K.tolist()
    for unit, period in (("", 0.01), (" s", None)):
        told = lin.kalman({"F": f"4 N^2{unit}"}, {"x": f"1 mm^2{unit}"}, period)
        assert told.L.tolist() == lin.kalman({"F": 4}, {"x": 1e-6}, period).L.tolist()


# What is refused


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"Q": {"tetha": 1}}, "Q: tetha is not known; did you mean theta"),
        ({"Q": {"x": -1}}, "Q: x: -1 is no weight; give one of 0 or more"),
        ({"R": {"F": 0}}, "R: F: 0 is no weight; give one above zero"),
        ({"R": {"F": "0"}}, "R: F: '0' is no weight; give one above zero"),
        ({"Q": {"x": float("nan")}}, "Q: x: nan is no weight"),
        ({"Q": np.diag([1, -2, 1, 1])}, "Q: is not positive semidefinite: it has the eigenvalue -2, mostly of theta"),
        (
            {"Q": np.ones((2, 2))},
            "Q: is no weight of 4 x 4 finite numbers, a diagonal of 4 or one for all, for x, theta, x_dot, theta_dot",
        ),
        ({"Q": np.triu(np.ones((4, 4)))}, "Q: is not symmetric"),
        ({"R": [[0.0]]}, "R: is not positive definite"),
        ({"period": 0.0}, "dt 0: a period is finite and above zero"),
        ({"period": 1e6}, "grows beyond all numbers"),
    ],
)
def test_weights_that_are_none_are_told(given, message):
    with pytest.raises(LinearizeError, match=message):
        system("cart_pole").lqr(**given)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (["Q=x:10;theta"], 'Q: "theta" has no weight; write theta:1'),
        (["x:10"], '"x:10" is no Q=NAME:1'),
        (["Q=x:1/0"], "Q: x: .*divides by zero"),
        (["Q=x:m"], 'Q: x: "m" uses m, which is not known here; give a number'),
        (["Q=x:1;x:2"], "Q: x is named twice"),
        (["Q=x:1", "Q=x:2"], "Q is given twice"),
        (["none.npz"], "none.npz: cannot be read"),
    ],
)
def test_weights_are_read_or_told(said, message):
    with pytest.raises(LinearizeError, match=message):
        read_weights("--lqr", said, {"Q": (), "R": ()})


def test_weights_are_read_by_name_and_from_a_file(tmp_path):
    np.savez(tmp_path / "w.npz", Q=np.eye(4), other=np.ones(2))

    assert read_weights("--lqr", ["Q=x:10; theta:2*50", "R=F:1e-1"], {"Q": (), "R": ()}) == {
        "Q": {"x": 10.0, "theta": 100.0},
        "R": {"F": 0.1},
    }
    assert list(read_weights("--lqr", [str(tmp_path / "w.npz")], {"Q": (), "R": ()})) == ["Q"]
    with pytest.raises(LinearizeError, match="has no array W or V"):
        read_weights("--kalman", [str(tmp_path / "w.npz")], {"W": (), "V": ()})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v", '"v" names nothing; write "NAME=linspace'),
        ("v=0..10", '"0..10" is no range'),
        ("v=linspace(0,10)", "wants a beginning, an end and how many"),
        ("v=linspace(0,10,2.5)", "wants a beginning, an end and how many"),
        ("v=geomspace(0,10,5)", "same side of zero"),
        ("v=linspace(0,x,5)", "x, which is not known here; give a number"),
        ("v=linspace(0,10,1e9)", "2 to 20000"),
    ],
)
def test_ranges_are_read_or_told(text, message):
    with pytest.raises(LinearizeError, match=message):
        read_values(text)


def test_ranges_are_those_of_numpy():
    assert read_values("v = linspace(0, pi, 5)")[1].tolist() == np.linspace(0, np.pi, 5).tolist()
    assert read_values("v=[1, 2, 5/2]")[1].tolist() == [1, 2, 2.5]
    assert_allclose(read_values("k=geomspace(0.1,10,3)")[1], [0.1, 1, 10])


def test_a_name_that_changes_nothing_is_told():
    with pytest.raises(LinearizeError, match=r"speed is no parameter \(they are: mc, mp, l, b, g\) and in no formula"):
        systems(Problem(example("cart_pole")), "speed")
    with pytest.raises(LinearizeError, match="x moves; a range is of a parameter"):
        systems(Problem(example("cart_pole"), {"F": "-x"}), "x")
    with pytest.raises(LinearizeError, match="values must be finite and increase"):
        root_locus("b", [1.0, 0.5], systems(Problem(example("cart_pole")), "b"))


def test_a_system_without_inputs_has_no_responses_and_no_gains():
    one = linearize(example("rolling_disc"), anywhere=True)

    with pytest.raises(LinearizeError, match="nothing drives it"):
        one.bode()
    with pytest.raises(LinearizeError, match="nothing drives it"):
        one.lqr()
    with pytest.raises(LinearizeError, match="frequencies must be finite and above zero"):
        system("cart_pole").bode(hertz=[0.0])


def test_a_table_of_responses_has_a_column_for_what_follows():
    head, first, *_ = system("cart_pole").bode(hertz=[1.0]).table().csv().splitlines()

    assert head == "frequency_Hz,x / F dB,x / F deg,theta / F dB,theta / F deg"
    assert len(first.split(",")) == 5


# The verb


def test_rows_print_what_they_find_and_write_their_files(tmp_path, capsys):
    scene, gains = str(ROOT / "examples" / "cart_pole.toml"), tmp_path / "gains.json"
    words = ["--show", "transfer,reach", "--dt", "0.02", "--lqr", "Q=x:10;theta:100", "R=F:0.1", "--gains", str(gains)]
    words += ["--bode", str(tmp_path / "r.csv"), "--hertz", "geomspace(0.1,10,5)", "--kalman", "W=F:1", "V=x:1e-4"]

    assert main(["linearize", scene, *words]) == 0
    told = capsys.readouterr().out
    for line in (
        "theta / F: gain 2.92683", "controllability: rank 4 of 4", "  poles: 5.61664, -0.0909073, -5.62329, 0",
        "by variational equations along the step the same to", "closed-loop poles: 0.97", "filter poles: 0.896918",
    ):  # fmt: skip
        assert line in told
    said = json.loads(gains.read_text(encoding="utf-8"))
    assert_allclose(said["K"], found("cart_pole", "dlqr"), rtol=1e-7)
    assert (said["states"], said["inputs"], said["period"]) == (list(STATES["cart_pole"]), ["F"], 0.02)
    assert len((tmp_path / "r.csv").read_text(encoding="utf-8").splitlines()) == 6
    assert main(["linearize", scene, *words, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["result"]
    assert {"transfer", "reach", "bode", "dt", "lqr", "kalman"} <= set(data)


def test_a_range_prints_critical_values_and_writes_the_locus(tmp_path, capsys):
    disc = str(DATA / "found" / "rolling_disc_zxy.toml")
    words = ["--start", "q1=0,q2=0,q3=0,z=r", "--over", "s=linspace(3,4,3)", "--speed", "q3=s"]

    assert main(["linearize", disc, *words, "--locus", str(tmp_path / "l.csv"), str(tmp_path / "l.svg")]) == 0
    assert "s = 3.5463957868" in capsys.readouterr().out
    head, first, *_ = (tmp_path / "l.csv").read_text(encoding="utf-8").splitlines()
    assert head == "s,re1,im1,re2,im2,growing"
    assert first.endswith(",1")
    assert "<svg" in (tmp_path / "l.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["rssr", "free_body", "pendulum"])
def test_rows_serve_scenes_with_multipliers_quaternions_or_one_state(name, capsys):
    words = ["--anywhere", "--show", "transfer,reach", "--dt", "0.01"]

    assert main(["linearize", str(ROOT / "examples" / f"{name}.toml"), *words]) == 0
    assert "observability: rank" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--hertz [1]", "--hertz: belongs to --show bode, which is not given"),
        ("--show reach,tranfer", '--show: there is no "tranfer"; did you mean transfer?'),
        ("--bode", "--bode: names no file; --show bode prints the responses"),
        ("--gains g.json", "--gains: belongs to --lqr, which is not given"),
        ("--lqr --gains g.txt --bode r.csv", "--gains: g.txt is no .json file"),
        ("--bode r.txt", "--bode: r.txt is no .csv or .svg or .pdf or .png file"),
        ("--bode nowhere/r.csv", "nowhere/r.csv: there is no folder nowhere"),
        ("--over b=[1,2] --show transfer", "--show transfer: is of one system, and --over makes many"),
        ("--over b=[1,2] --start rest", "--start: rest may be many places"),
        ("--over b=[1,2] --locus l.txt", "--locus: l.txt is no .csv or .svg or .pdf or .png file"),
        ("--over b=[-1,1]", "parameters.b: value = -1 is not positive"),
        ("--start rest --animate m.svg", "--animate: there are 2 systems; give the place of one"),
        ("--animate m.avi", "--animate: m.avi is no .html or .svg or .gif or .glb or .mp4 file"),
        ("--dt 0", "--dt 0: a period is finite and above zero"),
    ],
)
def test_flags_that_cannot_be_are_told(words, message, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)

    assert main(["linearize", str(ROOT / "examples" / "cart_pole.toml"), *words.split()]) == 1
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_python_control_agrees_where_it_is_installed():
    control = pytest.importorskip("control")
    one = system("cart_pole")
    K, _, _ = control.lqr(one.A, one.B, np.diag([10.0, 100.0, 0.0, 0.0]), [[0.1]])

    assert_allclose(one.lqr(*WEIGHTS["cart_pole"]).K, K, rtol=1e-8)
    assert_allclose(one.to_control().A, one.A)


@pytest.mark.runs("cc")
def test_gains_act_beside_forces_that_compensate_weight() -> None:
    arm = bind(read(ROOT / "examples" / "two_link.toml"), {"m1": 1, "m2": 2, "h1": 0.4, "h2": 0.3, "g": 9.81})
    at = {"q1": "0.7", "q2": "-0.4"}
    weight = {"M1": "9.81*(1.2*sin(q1) + 0.6*sin(q1 + q2))", "M2": "9.81*0.6*sin(q1 + q2)"}
    regulator = linearize(arm, start=at, forces=weight).lqr()
    assert regulator.gains()["u0"] == {"M1": 0.0, "M2": 0.0}
    assert any("formulas of forces depend" in note for note in regulator.notes)
    start = {"q1": "0.8", "q2": "-0.3"}
    run = simulate(arm, until=25, start=start, forces=weight, feedback=regulator.gains(), method="dop853")
    assert_allclose(run.q[-1], [0.7, -0.4], atol=1e-4)
    constant = {"M1": "9.81*(1.2*sin(0.7) + 0.6*sin(0.3))", "M2": "9.81*0.6*sin(0.3)"}
    held = linearize(arm, start=at, forces=constant).lqr()
    assert not held.notes
    run = simulate(arm, until=25, start=start, feedback=held.gains(), method="dop853")
    assert_allclose(run.q[-1], [0.7, -0.4], atol=1e-4)


def test_gains_at_an_instant_of_a_motion_say_so() -> None:
    cart = read(ROOT / "examples" / "cart_pole.toml")
    (note,) = linearize(cart, start={"theta": "0.3"}, anywhere=True).lqr().notes
    assert note.startswith("the point is neither of rest nor of a steady motion")


@pytest.mark.parametrize("word", ["transfer", "reach"])
def test_a_flag_that_became_a_word_is_told(word, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["linearize", "cart_pole.toml", f"--{word}"])

    assert f"--{word} is no option; it is called --show {word} now" in capsys.readouterr().err


def test_as_many_crossings_as_are_promised_are_found_between_two_values() -> None:
    at = np.linspace(0.1, 0.9, CROSSINGS)

    def system(x: float) -> Any:
        growing = [SimpleNamespace(oscillates=False)] * int((x > at).sum())
        return SimpleNamespace(poles=(x - at).astype(complex), spectrum=SimpleNamespace(growing=growing))

    found = root_locus("k", [0.0, 1.0], system)
    assert_allclose([one.value for one in found.critical], at, rtol=1e-9)
    assert all(one.grows for one in found.critical)


def test_with_inputs_nothing_is_proved_of_all_positions_of_rest() -> None:
    functions = SimpleNamespace(multipliers=(), inputs=("u",))
    given: Any = SimpleNamespace(
        prepared=SimpleNamespace(scene=SimpleNamespace(is_constrained=False, given=("u",)), functions=functions),
        singular=0,
    )
    assert not complete(given)


def test_both_quaternions_of_an_attitude_are_one_position() -> None:
    scene = example("free_body")
    n = len(scene.coordinates)
    search: Any = SimpleNamespace(scene=scene, turns=[False] * n, idle=[False] * n)
    q = np.zeros(n)
    first = list(scene.coordinates).index(quaternions(scene)[0][0])
    q[first : first + 4] = [-0.5, 0.5, 0.5, -0.5]
    assert_allclose(Search.wrapped(search, q)[first : first + 4], [0.5, -0.5, -0.5, 0.5])
    assert_allclose(Search.wrapped(search, -q), Search.wrapped(search, q))


def test_a_mode_of_an_eigenvalue_zero_has_no_damping() -> None:
    assert Mode(0j, np.ones(1, dtype=complex)).damping == 0
