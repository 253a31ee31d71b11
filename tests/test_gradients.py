"""How ends of runs depend on starts and parameters: two doors, differences, closed forms."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import symdyn
from symdyn.errors import SimulateError
from symdyn.scene import Scene, bind, read, read_text
from symdyn.simulation import Sensitivity, sensitivity, simulate
from symdyn.simulation.equations.linear_feedback import Gains, state_names
from symdyn.simulation.initial import Start, read_start

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"


def example(name: str) -> Scene:
    return read(EXAMPLES / f"{name}.toml")


@pytest.mark.wide("cart_pole", "slider_crank")
@pytest.mark.parametrize("name", ["double_pendulum", "cart_pole", "governor", "heavy_top", "slider_crank"])
def test_the_two_doors_agree_to_rounding(name: str) -> None:
    scene, until = example(name), 0.2
    forward = sensitivity(scene, until=until, rtol=1e-9)
    back = sensitivity(scene, until=until, rtol=1e-9, by="adjoint")

    assert (forward.rows, forward.columns, forward.steps) == (back.rows, back.columns, back.steps)
    assert np.abs(forward.matrix - back.matrix).max() < 1e-12 * np.abs(forward.matrix).max()
    assert np.abs(forward.matrix).max() > 0.1


def test_a_pendulum_at_rest_has_the_exponential_of_its_linear_equations() -> None:
    """Steps chosen for a motion that does nothing would be far too long for what leaves it."""
    g, length, b = 9.81, 0.5, 0.01
    A = np.array([[0, 1], [-g / length, -b / length**2]])

    found = sensitivity(example("pendulum"), until=3.0, parameters=["m", "g"])

    assert found.columns == ("q1", "q1_dot", "m", "g")
    assert np.abs(found.matrix[:, :2] - expm(3.0 * A)).max() < 1e-11
    assert not found.matrix[:, 2:].any()


def test_a_small_swing_depends_on_its_length_as_the_cosine_of_its_phase_says() -> None:
    """q = q0 cos(√(g/l) t), so ∂q/∂l = q0 sin(√(g/l) t) √(g/l) t / 2 l, up to q0³."""
    t, q0, g, length = 2.0, 1e-4, 9.81, 0.5
    found = sensitivity(example("pendulum"), until=t, start={"q1": str(q0)}, values={"b": 1e-12})
    phase = np.sqrt(g / length) * t

    assert found["q1", "l"] / q0 == pytest.approx(np.sin(phase) * phase / (2 * length), rel=1e-6)
    assert found["q1", "q1"] == pytest.approx(np.cos(phase), rel=1e-6)


def ends(scene: Scene, start: Start, until: float, forces: str) -> np.ndarray:
    run = simulate(scene, forces=forces, until=until, every=until, start=start, method="dop853", rtol=1e-12)
    return np.concatenate([run.q[-1], run.qd[-1]])


@pytest.mark.parametrize(
    ("name", "forces", "parameter"),
    [("double_pendulum", "tau1=-q1*q2_dot", "l1"), ("cart_pole", "F=sin(3*t)-x*theta", "mp")],
)
def test_gradients_of_trees_are_differences_of_runs(name: str, forces: str, parameter: str) -> None:
    scene, until, h = example(name), 0.5, 1e-5
    names, n = state_names(scene), len(scene.velocities)
    start = Start(0.3 + 0.1 * np.arange(n), np.linspace(-1, 1, n))
    forces = forces.replace("tau1", next(filter(None, scene.drives), "tau1")) if forces else {}  # type: ignore[assignment]
    known = [p.name for p in scene.parameters]
    asked = [parameter] if parameter in known else known[:1]

    found = sensitivity(scene, forces=forces, until=until, start=start, parameters=asked)

    for column, key in enumerate(found.columns):
        pair = []
        for step in (h, -h):
            x = np.concatenate([start.q, start.u])
            varied = scene
            if key in asked:
                (value,) = (float(p.value.value) for p in scene.parameters if p.name == key)  # type: ignore
                varied = bind(scene, {key: f"{value + step:.17g}"})
            else:
                x[names.index(key)] += step
            pair.append(ends(varied, Start(x[:n], x[n:]), until, forces))
        assert np.allclose(found.matrix[:, column], (pair[0] - pair[1]) / (2 * h), rtol=2e-7, atol=2e-7)


def test_gradients_of_a_free_body_follow_each_other_as_runs_do() -> None:
    """From 0 to 2 is from 0 to 1, then from 1 to 2: in the axes of the moved frame, positions and velocities apart."""
    scene = example("free_body")
    start = read_start(scene, {"e0": "0.8", "e1": "0.6"}, {"flight_wx": "1"})
    first = sensitivity(scene, until=1.0, start=start)
    second = sensitivity(scene, until=1.0, start=Start(first.q, first.u))
    whole = sensitivity(scene, until=2.0, start=start)

    assert np.abs(second.matrix @ first.matrix - whole.matrix).max() < 1e-9 * np.abs(whole.matrix).max()
    step = 1e-6
    e = start.q.copy()
    e[3:] += step / 2 * np.array([-e[5], -e[6], e[3], e[4]])  # along flight_wy
    moved = sensitivity(scene, until=1.0, start=Start(e, start.u), of=["flight_wx"])
    away = Gains(scene, np.zeros((0, 0)), (), (), first.q, first.u, ()).away(moved.q) / step
    assert np.allclose(away, first.matrix[:6, first.columns.index("along flight_wy")], atol=1e-4)


LED = """
name = "led"
gravity = [0, "-g", 0]
[parameters]
A = 0.3
w = 4
l = 0.7
g = 9.81
[bodies.cart]
mass = 2
[bodies.pole]
particles = [{ mass = 1, at = [0, "-l", 0] }]
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
motion = "A*sin(w*t) + A"
[joints.hinge]
type = "revolute"
parent = "cart"
child = "pole"
axis = [0, 0, 1]
coordinate = "q1"
start = 0.4
"""


@pytest.mark.parametrize("by", ["forward", "adjoint"])
def test_what_a_prescribed_motion_says_follows_its_parameters_from_the_start_on(by: str) -> None:
    scene, h = read_text(LED), 1e-5

    found = sensitivity(scene, until=1.0, by=by)

    assert found.columns == ("q1", "q1_dot", "A", "w", "l", "g")
    for key, value in (("A", 0.3), ("w", 4.0), ("l", 0.7)):
        runs = [
            simulate(scene, until=1.0, every=1.0, values={key: value + s * h}, rtol=1e-12, method="dop853")
            for s in (1, -1)
        ]
        pair = [np.concatenate([run.q[-1], run.qd[-1]]) for run in runs]
        assert np.allclose(found.matrix[:, found.columns.index(key)], (pair[0] - pair[1]) / (2 * h), atol=1e-7)
    assert found["x", "A"] == pytest.approx(np.sin(4.0) + 1, abs=1e-12)


STIFF = """
name = "stiff"
gravity = "none"
[parameters]
k = 1e4
c = 1e5
[bodies.block]
mass = 1
[joints.slide]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
force = "-c*x_dot - k*x"
start = 1
"""


@pytest.mark.parametrize("by", ["forward", "adjoint"])
def test_a_stiff_system_is_integrated_implicitly_backward_too(by: str) -> None:
    scene, t, k, c = read_text(STIFF), 2.0, 1e4, 1e5

    found = sensitivity(scene, until=t, by=by, rtol=1e-9)

    exact = expm(t * np.array([[0, 1], [-k, -c]]))
    slope = (expm(t * np.array([[0, 1], [-k - 1, -c]])) - expm(t * np.array([[0, 1], [-k + 1, -c]]))) / 2
    assert found.method == "radau"
    assert np.abs(found.matrix[:, :2] - exact).max() < 1e-8
    assert found["x", "k"] == pytest.approx(slope[0, 0], rel=1e-5)


@pytest.mark.parametrize(
    ("scene", "until", "method"), [(example("cart_pole"), 1.0, "dop853"), (read_text(STIFF), 2.0, "radau")]
)
def test_every_sample_of_the_variations_of_a_run_is_a_sensitivity_to_its_end(
    scene: Scene, until: float, method: str
) -> None:
    """Samples lie inside of steps, but for the last one; error bars are made of them."""
    start = {scene.coordinates[0]: 0.3}
    whole = sensitivity(scene, until=until, start=start, rtol=1e-10)
    names = dict.fromkeys(whole.columns, 0.01)

    bars = symdyn.uncertainty(scene, names, until=until, start=start, every=until / 8, columns=whole.rows)

    assert whole.method == method
    assert bars.varied == whole.columns
    for k in (1, 3, 8):
        to_there = sensitivity(scene, until=float(bars.t[k]), start=start, rtol=1e-10).matrix
        np.testing.assert_allclose(bars.slopes[k], to_there, atol=1e-7 * max(1.0, float(np.abs(to_there).max())))


def test_what_is_asked_for_alone_is_the_same() -> None:
    scene = example("cart_pole")
    whole = sensitivity(scene, until=0.5, start={"theta": "0.3"})

    asked = {"parameters": "mp", "of": "theta_dot", "by": "adjoint"}
    part = symdyn.sensitivity(scene, until=0.5, start={"theta": "0.3"}, **asked)  # type: ignore[arg-type]

    assert isinstance(part, Sensitivity)
    assert part.rows == ("theta_dot",)
    assert part.columns[-2:] == ("theta_dot", "mp")
    assert part["theta_dot", "mp"] == pytest.approx(whole["theta_dot", "mp"], rel=1e-11)
    assert sensitivity(scene, until=0.5, parameters=["mp", "mp"]).columns[-2:] == ("theta_dot", "mp")
    assert sensitivity(scene, until=0.5, parameters=[]).matrix.shape == (4, 4)
    with pytest.raises(KeyError, match="theta_dt is not there; did you mean theta_dot"):
        whole["theta_dt", "l"]


def test_what_was_moved_so_that_loops_close_is_noted() -> None:
    found = sensitivity(example("four_bar"), until=0.05, start={"phi": "0.9"}, rtol=1e-16, parameters=[], by="adjoint")

    assert "the start was moved so that the loops close" in " ".join(found.notes)
    assert found.matrix.shape == (6, 2)


def test_what_has_no_gradient_is_told() -> None:
    cart, pendulum = example("cart_pole"), example("pendulum")
    with pytest.raises(SimulateError) as faults:
        sensitivity(cart, until=-1.0, start={"tehta": "1"}, parameters=["q"], of=["y"], by="bakward", rtol=2.0)
    for words in ("tehta is not known", "until", "by: bakward is not known", "of: y is no", "parameters: q is", "rtol"):
        assert words in str(faults.value)
    with pytest.raises(SimulateError, match=r"b = 0 decides which terms .* give a value next to that, such as 1e-9"):
        sensitivity(pendulum, until=1.0, values={"b": 0}, parameters=["b"])
    with pytest.raises(SimulateError, match=r"a force with sign jumps, .* write a steep tanh"):
        sensitivity(cart, forces="F=-sign(x_dot)", until=1.0)
    with pytest.raises(SimulateError, match=r"the run cannot go on after t = 0\.\d+ s|no finite value|cannot go on"):
        sensitivity(cart, forces="F=x_dot**3 + 10", until=10.0)


class WaitedError(Exception):
    """Nothing was said in time."""


@pytest.mark.mends("30.attacks.8")
@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("by", ["forward", "adjoint"])
def test_a_gradient_that_would_take_years_is_ended_in_words(by: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def ring(*_: object) -> None:
        raise WaitedError

    monkeypatch.setattr(
        "symdyn.simulation.integrate.integration.FIRST", 0.05
    )  # as a run is ended, by two looks at its pace
    sensitivity(example("pendulum"), until=0.1, by=by)  # compiled, and all that
    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, 10.0)
    try:
        with pytest.raises(
            SimulateError, match=r"at this pace t = 1e\+308 s takes about .* years, so the run ends here"
        ):
            sensitivity(example("pendulum"), until=1e308, start={"q1": "1"}, by=by)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_a_tolerance_of_a_gradient_that_is_not_taken_is_told() -> None:
    found = sensitivity(example("pendulum"), until=0.1, rtol=1e-16)

    assert "rtol = 1e-16 is finer than what dop853 works with; it takes 2.2e-14" in found.notes


def test_what_the_page_says_runs() -> None:
    page = (Path(__file__).parent.parent / "docs" / "simulate.md").read_text(encoding="utf-8")
    text = page[page.index("    from symdyn.simulation import sensitivity\n") :]
    lines = text[: text.index('\n`by="forward"` integrates')].splitlines()
    known: dict[str, object] = {"scene": example("cart_pole")}

    exec("\n".join(line.removeprefix("    ") for line in lines), known)

    found, back = known["found"], known["back"]
    assert found.columns[-2:] == ("l", "mp")  # type: ignore[attr-defined]
    assert back.rows == ("theta_dot",)  # type: ignore[attr-defined]


@pytest.mark.parametrize("by", ["forward", "adjoint"])
def test_progress_of_a_gradient_goes_from_zero_to_one(by: str) -> None:
    heard: list[float] = []
    sensitivity(example("cart_pole"), until=1, by=by, progress=heard.append)
    assert heard == sorted(heard)
    assert 0 < heard[0] < 0.5 < heard[-2] < heard[-1] == 1


def test_a_gradient_that_takes_long_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.simulation.integrate.integration.FIRST", 0.0)
    monkeypatch.setattr("symdyn.simulation.integrate.integration.LONG", 0.0)
    lines: list[str] = []
    sensitivity(example("cart_pole"), until=1, say=lines.append)
    assert any("at this pace the end at t = 1 s" in line for line in lines)
