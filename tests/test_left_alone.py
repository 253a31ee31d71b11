"""What a gain leaves alone, transfer functions in symbols, and lines that name what to type at linear systems."""

import re

import numpy as np
import pytest

import symdyn
from symdyn.errors import LinearizeError
from symdyn.frozen import replace
from symdyn.linear import Linearization, StateSpace, root_locus
from symdyn.scene import body, prismatic, revolute, scene

Q, R, W, V = {"theta": 100, "theta_dot": 1, "phi_dot": 1e-4}, {"M": 100}, {"M": 1e-4}, {"theta": 3e-6, "phi": 3e-4}


def wheel(*outputs: str) -> Linearization:
    """A pendulum that a wheel holds upright; nothing depends on the wheel's angle."""
    disc = body("disc", mass=0.2, inertia=[1e-4, "J", 1e-4], about="com")
    return symdyn.linearize(
        scene(
            "wheel", gravity=[0, 0, -9.81], parameters={"m": 0.5, "J": 2e-4, "l": 0.2},
            bodies=[body("arm", mass="m", com=[0, 0, "l/2"]), disc],
            joints=[
                revolute("pivot", "ground", "arm", axis=[0, 1, 0], coordinate="theta", damping=1e-3, drive=False),
                revolute("axle", "arm", "disc", axis=[0, 1, 0], coordinate="phi", drive="M", origin=[0, 0, "l"]),
            ],
        ),
        outputs=outputs,
    )  # fmt: skip


@pytest.mark.parametrize("period", [None, 0.005, 0.01, 0.02])
def test_a_drift_that_weights_leave_alone_counts_for_no_verdict(period: float | None) -> None:
    """The verdict went by the rounding of the pole: 0.99999999999988 was stable and 1.0000000000003 was not."""
    lin = wheel("theta", "phi")
    lqg, lqr = lin.lqg(Q, R, W, V, period), lin.lqr(Q, R, period)
    own = np.linalg.eigvals(lqg.closed_loop.A)
    size = own.real if period is None else abs(own) - 1
    edge = 0.0 if period is None else 1.0
    assert np.sort(size)[-2] < -1e-3
    assert abs(np.sort(size)[-1]) < 1e-9
    assert np.count_nonzero(lqg.closed_loop.poles == edge) == 1

    words = "marginally stable: phi does not decay"
    for found in (lqg.margins(), lqr.margins()):
        assert (found.verdict, found.left_alone) == (words, ("phi",))
    assert lqr.closed_loop.verdict == "marginally stable: phi does not decay"
    assert lqg.closed_loop.verdict == "marginally stable: phi, phi_estimate do not decay"
    assert repr(lqg.margins()).startswith(f"<Margins of a loop that is {words}: gain ")
    assert lqr.notes == (f"{words}, as Q gives no weight to it",)
    assert f"{words}, as Q" in repr(lqr)
    assert f"{words}, as Q" in repr(lqg)
    assert lqg.margins().stable
    with pytest.raises(AttributeError, match="it is verdict, in words, and stable"):
        _ = lqg.closed_loop.stability
    with pytest.raises(AttributeError, match=r"its .closed_loop has them"):
        _ = lqr.verdict  # type: ignore[attr-defined]
    assert not lqg.closed_loop.stable  # its poles are not all inside
    assert lqg.margins().as_json()["left_alone"] == ["phi"]
    theta, phi = (lqg.closed_loop.step(name, "M").final[0, 0] for name in ("theta", "phi"))
    assert theta == pytest.approx(0, abs=1e-9)
    assert np.isnan(phi)
    weighed = lin.lqg(Q | {"phi": 1e-5}, R, W, V, period)
    assert weighed.margins().verdict == weighed.closed_loop.verdict == "asymptotically stable"


def test_the_margins_beside_what_is_left_alone_are_those_of_python_control() -> None:
    control = pytest.importorskip("control")
    loop = wheel("theta", "phi").lqg(Q, R, W, V).loop
    gain, phase, crossover, crossing = control.margin(loop.to_control())

    found = loop.margins()
    assert [found.gain, found.phase] == pytest.approx([gain, phase], rel=1e-4)
    assert [found.phase_crossover, found.gain_crossover] == pytest.approx([crossover, crossing], rel=1e-4)


@pytest.mark.parametrize("period", [None, 0.1])
def test_a_pole_at_the_edge_that_the_loop_needs_is_told_by_margins_as_by_the_closed_loop(period: float | None) -> None:
    """-1 + 1/(1 + s) is 0 at s = 0: the closed loop has a pole there, which its output shows: it was "unstable"."""
    edge = StateSpace([[-1.0]], [[1.0]], [[-1.0]])
    swings = StateSpace([[0.0, 1.0], [-1.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]])
    integrates = StateSpace([[0.0]], [[1.0]], [[1.0]])
    hidden = StateSpace(np.diag([-1.0, 0.0]), [[1.0], [0.0]], [[1.0, 0.0]], states=["v", "x"])
    beside = StateSpace([[-1, 0, 0], [0, 0, 2], [0, -2, 0]], [[1], [0], [0]], [[1, 0, 0]], states=["v", "a", "b"])
    said = {
        edge: "marginally stable: x1 does not decay", swings: "marginally stable: x1, x2 do not decay",
        integrates: "asymptotically stable",
        hidden: "marginally stable: x does not decay", beside: "marginally stable: a, b do not decay",
    }  # fmt: skip
    for one, words in said.items():
        if one is swings and period:
            continue  # held between samples it grows, and so says another test
        loop = one if period is None else one.discretize(period)
        found, closed = loop.margins(), replace(loop, A=loop.A - loop.B @ loop.C / (1 + loop.D[0, 0]))
        assert found.verdict == closed.verdict == words
        assert found.stable is (one not in (edge, swings))


def test_a_double_pole_at_one_is_no_growth() -> None:
    """Rounding parts it to 1 ± 1e-8, of which one grew; its end was that of what grows."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    A = turn @ np.array([[0, 1, 0], [0, 0, 0.3], [0, 0, -2.0]]) @ turn.T
    for period in (1e-3, 0.02, 0.5):
        held = StateSpace(A, np.eye(3), np.eye(3)).discretize(period)
        assert np.count_nonzero(held.poles == 1) == 2
        assert [round(one.value.real, 6) for one in held.modes] == [-2]
        assert not held.growth.growing
        assert not held.stable
    with pytest.raises(LinearizeError, match="a root locus is of a system without a period"):
        root_locus("k", [0, 1], lambda k: held)


@pytest.mark.parametrize("period", [None, 0.01])
def test_what_moves_on_for_ever_is_no_stable_system(period: float | None) -> None:
    """It was "stable, but for x1", and a double pair on the edge, of t sin t, "stable, but for x1, x2"."""
    swings = [[0, 1], [-1, 0]]
    once, twice = np.zeros((4, 4)), np.kron(np.eye(2), swings)
    twice[0, 2] = 1  # one drives the other
    once[0, 1] = 1
    once[2:, 2:] = swings
    said = {
        "marginally stable: x1, x2 drift": [[0, 1], [0, 0]], "marginally stable: x1, x2, x3 drift": np.diag([1, 2], 1),
        "marginally stable: x1, x2 do not decay": np.zeros((2, 2)),
    }  # fmt: skip
    said |= {"marginally stable: x1, x2 drift ": once, "marginally stable: x1, x2, x3, x4 drift": twice}
    for words, A in said.items():
        one = StateSpace(A, np.eye(len(A)), np.eye(len(A)))
        one = one if period is None else one.discretize(period)
        assert (one.verdict, one.stable) == (words.strip(), False)
    two = StateSpace(np.kron(np.eye(2), swings), np.eye(4), np.eye(4))
    assert two.verdict == "marginally stable: x1, x2, x3, x4 do not decay"  # of two shapes


@pytest.mark.runs("cc")
@pytest.mark.parametrize("period", [None, 0.01])
def test_a_drift_that_a_gain_leaves_alone_has_one_name_everywhere(period: float | None) -> None:
    rails = [
        prismatic(f"j{k}", "ground", k, axis=[1, 0, 0], coordinate=k, drive={"x": "F", "z": False}[k]) for k in "xz"
    ]
    lin = symdyn.linearize(scene("two", gravity="none", bodies=[body(k, mass=1) for k in "xz"], joints=rails))
    assert lin.verdict == "marginally stable: x, z, x_dot, z_dot drift"
    assert lin.stability.words == f"{lin.verdict}; all eigenvalues are zero"
    found, words = lin.lqr({"x": 1}, {"F": 1}, period), "marginally stable: z, z_dot drift"
    assert found.notes == (f"{words}, as Q gives no weight to them",)
    assert found.closed_loop.verdict == found.margins().verdict == words
    assert found.closed_loop.left_alone == found.margins().left_alone == ("z", "z_dot")
    assert found.margins().as_json()["drifting"] == ["z", "z_dot"]
    assert found.margins().stable
    run = symdyn.simulate(lin.scene, until=10, start_rates={"z": 1}, feedback=found)
    assert run.q[-1, list(run.scene.coordinates).index("z")] == pytest.approx(10)


@pytest.mark.parametrize("damping", [1e5, 1e6])
def test_a_slow_pole_beside_a_fast_one_decays(damping: float) -> None:
    """Of 1 kg and d, least ∫ x² + F²: s⁴ - d² s² + 1 is 0 at the poles and at their mirror images."""
    rail = prismatic("j", "ground", "b", axis=[1, 0, 0], coordinate="x", damping=damping, drive="F")
    lin = symdyn.linearize(scene("stiff", gravity="none", bodies=[body("b", mass=1)], joints=[rail]))
    slow, fast = lin.lqr({"x": 1}, {"F": 1}).poles
    assert (slow, fast) == (pytest.approx(-1 / damping, rel=1e-4), pytest.approx(-damping, rel=1e-9))
    held = lin.lqr({"x": 1}, {"F": 1}, period=0.001)
    assert 1 - abs(held.poles).max() == pytest.approx(0.001 / damping, rel=1e-3)


# A motor: 500 w' = 0.05 i, 1e-3 i' = u - i - 0.05 w, and its angle beside it, which drifts; w ends at 20.
MOTOR = StateSpace([[0, 1, 0], [0, 0, 1e-4], [0, -50, -1e3]], [[0], [0], [1e3]], [[0, 1, 0]])


@pytest.mark.parametrize("period", [None, 1e-4, 1e-2])
@pytest.mark.parametrize(
    ("one", "final"),
    [
        (StateSpace([[0, 0, 1], [0, -1e-2, 1e-4], [0, 0, -1e4]], [[0], [0], [1e4]], [[0, 1, 0]]), 0.01),
        (MOTOR, 20.0),
    ],
)
def test_a_slow_response_beside_a_fast_pole_and_a_drift_ends(
    one: StateSpace, final: float, period: float | None
) -> None:
    """The slow pole, -1e-2 beside -1e4, or -5e-6 beside -1e3, was rounded to zero, and the end was nan."""
    held = one if period is None else one.discretize(period)
    assert held.step(until=1.0).final[0, 0] == pytest.approx(final, rel=1e-6)


@pytest.mark.parametrize("inductance", [1e-3, 1e-6, 1e-9])
def test_a_step_response_ends_at_the_static_gain_however_slow_its_pole(inductance: float) -> None:
    """Beside 1e6 1/s the pole -5e-6 was rounded to zero, and the speed ended at nan, the angle, an integral, at 0."""
    A = [[0, 1, 0], [0, 0, 1e-4], [0, -0.05 / inductance, -1 / inductance]]
    motor = StateSpace(A, [[0], [0], [1 / inductance]], np.eye(3), outputs=["angle", "speed", "current"])
    angle, speed, current = motor.step(until=1.0).final[:, 0]
    assert np.isnan(angle)
    assert (speed, current) == (pytest.approx(20, rel=1e-9), pytest.approx(0, abs=1e-9))
    grows = StateSpace([[1e-6, 1], [0, -1e6]], [[0], [1e6]], [[1, 0]])
    assert np.isnan(grows.step(until=1.0).final[0, 0])
    assert StateSpace([[-3e-10, 1], [0, -1]], [[0], [1]], [[1, 0]]).step(until=1.0).info()["final"] == pytest.approx(
        1 / 3e-10
    )


@pytest.mark.parametrize("period", [None, 1e-3])
@pytest.mark.parametrize(
    "one",
    [
        StateSpace([[0, 1, 0], [-2000, -1e-6, 0.03], [0, 0, 1e-4]], [[0], [0], [1]], [[0, 1, 0]]),
        StateSpace(
            [[0, 1, 0, 0], [-5e7, -0.01, 0.02, 0], [0, 0, 0, 1], [0, 0, 0, -0.02]], np.eye(4)[:, 3:], [[0, 1, 0, 0]]
        ),
    ],
)
def test_no_final_value_is_told_of_less_than_the_whole_system(one: StateSpace, period: float | None) -> None:
    """It was 1.5e-5 of what grows by a pole at 1e-4, and 0 of what ends at 2e-8: a weak part was taken out."""
    held = one if period is None else one.discretize(period)
    assert np.isnan(held.step(until=1.0).final[0, 0])


@pytest.mark.parametrize("outputs", [["theta"], ["theta", "phi_dot"], ["theta_dot"]])
def test_a_filter_names_the_outputs_that_show_what_it_misses(outputs: list[str]) -> None:
    with pytest.raises(LinearizeError, match=r"no output shows the mode 0, of phi.* and it does not decay") as told:
        wheel(*outputs).lqg(Q, R, W)
    written = re.search(r"linearize with outputs=(\[.*\])$", str(told.value))
    assert written is not None
    named = [name.strip(' "') for name in written[1].strip("[]").split(",")]
    assert named == [*outputs, "phi"]
    assert wheel(*named).lqg(Q, R, W).margins().stable


def test_a_filter_names_all_outputs_that_it_needs() -> None:
    """Two carts that nothing holds, none of them measured: the positions show velocities, too."""
    rails = [prismatic(f"j{k}", "ground", k, axis=[1, 0, 0], coordinate=k, drive=f"F{k}") for k in "ab"]
    carts = scene("carts", gravity="none", bodies=[body(k, mass=1) for k in "ab"], joints=rails)
    with pytest.raises(LinearizeError, match=r'outputs=\["a_dot", "a", "b"\]'):
        symdyn.linearize(carts, outputs=["a_dot"]).kalman()
    assert symdyn.linearize(carts, outputs=["a_dot", "a", "b"]).kalman().poles.real.max() < 0


def test_a_gain_that_cannot_reach_a_mode_says_what_would() -> None:
    spring = prismatic("j", "ground", "b", axis=[1, 0, 0], coordinate="b", drive=False, force="-4*b")
    rails = [prismatic("i", "ground", "a", axis=[1, 0, 0], coordinate="a", drive="F"), spring]
    lin = symdyn.linearize(scene("two", gravity="none", bodies=[body(k, mass=1) for k in "ab"], joints=rails))
    with pytest.raises(
        LinearizeError, match=r"no input moves the mode ±2i, of b, b_dot, .* or leave b, b_dot out of Q"
    ):
        lin.lqr()
    found = lin.lqr({"a": 1})
    assert found.notes == ("marginally stable: b, b_dot do not decay, as Q gives no weight to them",)
    assert found.margins().verdict == "marginally stable: b, b_dot do not decay"
    assert found.closed_loop.verdict == "marginally stable: b, b_dot do not decay"
    with pytest.raises(LinearizeError, match=r"poles: no input moves .* or take lqr, which leaves alone"):
        lin.place([-1, -2, -3, -4])


def test_frequencies_beside_hertz_true_are_asked_which_they_are() -> None:
    """They were taken as rad/s and drawn in Hz, without a word."""
    lin = wheel("theta")
    with pytest.raises(
        LinearizeError, match=r"hertz=\[1, 2, 5, \.\.\.\] if they are in Hz; if they are in rad/s leave"
    ):
        lin.nyquist("theta", "M", np.array([1, 2, 5, 13.0]), hertz=True)
    with pytest.raises(LinearizeError, match=r"or give hertz=\[0.159155, 0.31831\], to see them in Hz"):
        lin.bode("theta", "M", omega=[1, 2], hertz=True)
    with pytest.raises(LinearizeError, match=r"hertz: frequencies must be a list of them, such as hertz=\[1\]"):
        lin.bode("theta", "M", hertz=1)  # type: ignore[arg-type]
    found = lin.bode("theta", "M", hertz=[1, 2, 5, 13.0])
    for G, f in zip(found.response[:, 0, 0], found.hertz, strict=True):
        own = (lin.C @ np.linalg.solve(2j * np.pi * f * np.eye(4) - lin.A, lin.B))[0, 0]
        assert abs(G / own - 1) < 1e-10
    assert repr(found).endswith("1 to 13 Hz, 4 frequencies>")
    assert repr(lin.bode("theta", "M", [1, 2])).endswith("1 to 2 rad/s, 2 frequencies>")
    assert len(lin.bode("theta", "M", [1, 2], hertz=False).omega) == 2


def test_a_transfer_function_in_symbols_has_the_numbers_of_the_system() -> None:
    from sympy import Poly, Symbol, fraction, gcd

    s, lin = Symbol("s"), wheel("theta", "phi_dot")
    for output in ("theta", "phi_dot"):
        G = lin.formulas.transfer(output, "M")
        assert {str(one) for one in G.free_symbols} == {"s", "m", "l", *["J"] * (output == "phi_dot")}
        assert gcd(*fraction(G)) == 1
        assert Poly(fraction(G)[1], s).degree() == (2 if output == "theta" else 3)
        at = complex(G.xreplace(lin.formulas.point).subs(s, 1j))
        assert at == pytest.approx(lin.transfer(output, "M").at(1j), rel=1e-12)
    with pytest.raises(AttributeError, match=r'lin.formulas.transfer\("theta", "M"\) is it in SymPy'):
        _ = lin.transfer("theta", "M").sympy  # type: ignore[attr-defined]
    with pytest.raises(LinearizeError, match="output: tetha is not known; did you mean theta"):
        lin.formulas.transfer("tetha", "M")


def test_a_transfer_function_in_symbols_takes_the_rates_of_its_input() -> None:
    """A mass on a spring and a damper whose foot is moved: (d s + k)/(m s² + d s + k); s is the scene's own letter."""
    from sympy import Symbol

    text = """
        gravity = "none"
        [parameters]
        s = 2
        d = 3
        k = 50
        [inputs.road]
        unit = "m"
        rates = 1
        [bodies.car]
        mass = "s"
        [joints.up]
        type = "prismatic"
        parent = "ground"
        child = "car"
        axis = [0, 0, 1]
        coordinate = "z"
        drive = false
        force = "k*(road - z) + d*(road_dot - z_dot)"
    """
    lin = symdyn.linearize(symdyn.scene.read_text(text, "toml"), outputs=["z"])
    G = lin.formulas.transfer("z", "road")
    own = (3j + 50) / (-2 + 3j + 50)
    told = lin.formulas.transfer.__doc__
    assert told is not None
    assert '`Symbol("s_")` where the scene has a letter s' in told
    assert complex(G.xreplace({**lin.formulas.point, Symbol("s_"): 1j})) == pytest.approx(own, rel=1e-12)
    assert lin.transfer("z", "road").at(1j) == pytest.approx(own, rel=1e-9)
    assert lin.margins("z", "road").verdict == "asymptotically stable"
    assert lin.root_locus("z", "road", [0, 1]).growing.tolist() == [0, 0]  # neither took an input with rates


def test_a_state_in_the_place_of_an_input_is_told_apart() -> None:
    lin = wheel("theta")
    for asked in (lin.bode, lin.transfer, lin.step, lin.margins, lin.root_locus, lin.formulas.transfer):
        with pytest.raises(LinearizeError, match=r"^input: phi is a state, and no input; inputs are M$"):
            asked("theta", "phi")
    with pytest.raises(LinearizeError, match=r'input: l is no input; .* it is symdyn.linear.root_locus\("l", values'):
        lin.root_locus("theta", "l")
    for one in ("theta", "nothing"):
        with pytest.raises(LinearizeError, match=f"^input: {one} is ") as told:
            lin.root_locus("theta", one)
        assert "parameter" not in str(told.value)
