"""Mechanisms, motions and measures as a newcomer writes them, and what comes."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.emit import emit, write
from symdyn.errors import IdentifyError, SimulateError, SymdynError
from symdyn.linear import Linearization, root_locus
from symdyn.scene import revolute
from symdyn.scene.toml import read_text
from symdyn.simulation import Trajectory
from symdyn.simulation.initial import read_start

pytestmark = pytest.mark.runs("cc")

CART, ROOT = symdyn.example("cart_pole"), Path(__file__).parent.parent

FOUR_BAR = """
parameters = { a = 0.1, b = 0.3, c = 0.25, d = 0.3 }
bodies.crank.particles = [{ mass = 0.5, at = ["a/2", 0, 0] }]
bodies.coupler.particles = [{ mass = 0.8, at = ["b/2", 0, 0] }]
bodies.rocker.particles = [{ mass = 0.6, at = ["c/2", 0, 0] }]
joints.A = { type = "revolute", parent = "ground", child = "crank", coordinate = "phi", start = 1 }
joints.B = { type = "revolute", parent = "crank", child = "coupler", origin = ["a", 0, 0], drive = false }
joints.C = { type = "revolute", parent = "coupler", child = "rocker", origin = ["b", 0, 0], drive = false }
[joints.D]
type = "revolute"
parent = "rocker"
child = "ground"
origin = ["c", 0, 0]
tip = ["-d", 0, 0]
drive = false
"""


def test_a_motion_that_begins_where_the_start_does_not_close_is_found_from_other_guesses(tmp_path: Path) -> None:
    (tmp_path / "four_bar.toml").write_text(FOUR_BAR, encoding="utf-8")
    run = symdyn.inverse(tmp_path / "four_bar.toml", "phi=10*t", until=0.6)
    assert run.complete
    assert "the loops do not close from the start; one of random guesses is taken: start={" in run.notes[0]
    assert max(abs(run["q2"]).max(), abs(run["q3"]).max()) < 7


def test_motions_that_contradict_are_refused_after_other_guesses() -> None:
    with pytest.raises(SimulateError, match=r"the loops cannot be closed .* and no less from 30 random guesses; give"):
        symdyn.inverse(symdyn.example("four_bar"), {"phi": "2*pi*t", "psi": "t"}, until=1)


def test_a_problem_without_a_solution_warns() -> None:
    pytest.importorskip("casadi", reason="needs IPOPT")
    problem = symdyn.collocation(CART, until=0.2, cost="F**2", end={"x": 1}, bounds={"F": (-1, 1)}, intervals=4)
    with pytest.warns(RuntimeWarning, match="no solution was found: .*Infeasible"):
        assert not problem.solve().success


def test_what_a_problem_leaves_open_at_its_end_is_shown() -> None:
    given = symdyn.collocation(CART, until=2, cost="F**2", end={"x": 1}, intervals=4)
    assert repr(given).endswith("at the end x = 1, x_dot = 0; not given: theta, theta_dot>")
    assert "the end" not in repr(symdyn.collocation(CART, until=2, intervals=4))
    whole = symdyn.collocation(CART, until=2, end={"x": 1, "theta": 0}, intervals=4)
    assert repr(whole).endswith("at the end x = 1, theta = 0, x_dot = 0, theta_dot = 0>")
    pytest.importorskip("casadi", reason="needs IPOPT")
    assert repr(given.solve()).endswith("; not given at the end: theta, theta_dot>")


MIRRORED = "tip is the child's frame seen from the joint, child_origin the joint seen from that"


def test_a_tip_that_was_meant_as_a_child_origin_is_told_where_the_start_shows_it() -> None:
    right, wrong = 'tip = ["-c", 0, 0]', 'tip = ["c", 0, 0]'
    text = symdyn.scene.write_text(symdyn.example("four_bar"), "toml").text
    assert right in text
    bar = read_text(text.replace(right, wrong))
    for notes in (symdyn.inverse(bar, {"phi": "2*pi*t"}, until=0.1).notes, Numbers(bar).closed_position().notes):
        assert any(
            "the loop hinge open: its gap along y is 6.19 m" in note and note.endswith(MIRRORED) for note in notes
        )
    (moved, told) = Numbers(read_text(text.replace(right, ""))).closed_position().notes
    assert "had to move" in moved
    assert told.endswith("the joint hinge is at the origin of rocker's frame: if it is not, write child_origin")
    for meant in (text, text.replace(right, wrong.replace("tip", "child_origin"))):
        assert Numbers(read_text(meant)).closed_position().notes == ()


CRANK = """
parameters = { a = 0.1, b = 0.3 }
bodies.crank.particles = [{ mass = 0.5, at = ["a/2", 0, 0] }]
bodies.rod.particles = [{ mass = 0.8, at = ["b/2", 0, 0] }]
bodies.slider.mass = 1
joints.A = { type = "revolute", parent = "ground", child = "crank", coordinate = "phi", start = 1 }
joints.B = { type = "revolute", parent = "crank", child = "rod", origin = ["a", 0, 0], drive = false, start = -1 }
joints.C = { type = "prismatic", parent = "ground", child = "slider", axis = [1, 0, 0], drive = false }
[[loop]]
name = "cut"
type = "revolute"
parent = "rod"
child = "slider"
origin = ["b", 0, 0]
"""


def test_a_start_that_leaves_a_loop_open_is_told_with_what_closes_it() -> None:
    start = -np.arcsin(np.sin(1) / 3)
    (note,) = read_start(read_text(CRANK)).notes
    assert "the start leaves the loop cut open: its gap along x is 0.354 m; the start was moved so that" in note
    assert "child_origin" not in note
    moved = dict(re.findall(r"(\w+) by [\d.]+ to ([-\d.]+)", note))
    assert float(moved["q2"]) == pytest.approx(start - 1, abs=1e-5)
    assert float(moved["q3"]) == pytest.approx(0.1 * np.cos(1) + 0.3 * np.cos(start), abs=1e-5)


def test_a_drive_keeps_its_start_where_another_guess_closes_the_loops() -> None:
    other = read_text(CRANK.replace(", start = -1", ""))  # from zeros Newton's method ends at a folded place
    found = read_start(other)
    assert found.q[0] == 1
    assert found.notes[0] == "the loops close from other guesses of the start alone"
    short = Numbers(read_text(CRANK.replace("b = 0.3", "b = 0.05"))).closed_position().notes
    assert "which had to move" in short[0]
    assert short[1].endswith("the joint cut is at the origin of slider's frame: if it is not, write child_origin")


LED = """
gravity = [0, -9.81, 0]
[bodies.trolley]
[bodies.bob]
particles = [{ mass = 1, at = [0, -1, 0] }]
[joints.rail]
type = "prismatic"
parent = "ground"
child = "trolley"
axis = [1, 0, 0]
coordinate = "x"
motion = "0.3*sin(2*t)"
[joints.pin]
type = "revolute"
parent = "trolley"
child = "bob"
coordinate = "phi"
drive = false
"""


def test_what_a_motion_prescribes_may_be_without_mass() -> None:
    light, heavy = (read_text(LED.replace("trolley]", f"trolley]{mass}", 1)) for mass in ("", "\nmass = 2"))
    one, other = (symdyn.simulate(scene, until=1, every=0.1, method="dop853") for scene in (light, heavy))
    assert one["phi"] == pytest.approx(other["phi"], abs=1e-9)
    assert one["tau1"] == pytest.approx(other["tau1"] - 2 * other["x_ddot"], abs=1e-7)
    with pytest.raises(SymdynError, match=r"bob, moves no mass.*a mass off the axis \[0, 0, 1\] \(that of a joint"):
        symdyn.simulate(read_text(LED.replace("mass = 1", "mass = 0")), until=1, method="dop853")


def test_the_scene_of_an_identification_is_the_one_that_was_found() -> None:
    pendulum = symdyn.example("pendulum")
    log = symdyn.inverse(pendulum, "q1=sin(t)+0.4*sin(2.7*t)", np.linspace(0, 10, 501), values={"m": 1.2, "b": 0.03})
    found = symdyn.identify(pendulum, log)
    declared, identified, true = (
        symdyn.simulate(one, until=1, start={"q1": 1})["q1"] for one in (found.declared, found.scene, log.scene)
    )

    assert found.declared == pendulum
    assert np.abs(identified - true).max() < 1e-4 < np.abs(declared - true).max()


SPRUNG = """
[bodies.block]
mass = 1
[joints.rail]
type = "prismatic"
axis = [1, 0, 0]
parent = "ground"
child = "block"
coordinate = "x"
drive = "F"
damping = "c"
[springs.coil]
joint = "rail"
stiffness = 100
[parameters]
c = 1
"""


def test_peaks_are_those_between_samples_and_settling_times_those_of_the_step_response() -> None:
    block, measures = read_text(SPRUNG), ["max(x)", "when_max(x)", "min(-abs(x)/2)", "settling_time(x)"]
    asked: dict[str, Any] = {"forces": "F=100", "until": 6}
    found = symdyn.sweep(block, "c=[5,8]", measures, every=0.02, **asked)
    coarse = symdyn.ensemble(block, values={"c": [5, 8]}, measures=measures[:3], every=0.1, **asked)
    single = symdyn.ensemble(block, values={"c": [5, 8]}, measures=measures[:3], every=0.1, method="radau", **asked)
    series = symdyn.ensemble(block, values={"c": [5, 8]}, measures="max(x)", every=0.05, method="taylor", **asked)

    z = np.array([0.25, 0.4])
    exact = 1 + np.exp(-np.pi * z / np.sqrt(1 - z * z))
    for one, near in ((found, 1e-5), (coarse, 1e-7), (single, 1e-5)):
        assert not any("peaks" in note for note in one.notes)
        assert one["max(x)"] == pytest.approx(exact, rel=near)
        assert one["min(-abs(x)/2)"] == pytest.approx(-exact / 2, rel=near)
        assert one["when_max(x)"] == pytest.approx(np.pi / (10 * np.sqrt(1 - z * z)), rel=2e-3)
    assert any("max(x) of one of the runs is 1.4" in note and "give every=" in note for note in series.notes)
    settled = [symdyn.linearize(block, values={"c": c}).step("x", "F").info()["settling_time"] for c in (5.0, 8.0)]
    assert found["settling_time(x)"] == pytest.approx(settled, rel=2e-3)
    short = symdyn.sweep(block, "c=[0.1,8]", "settling_time(x)", every=0.02, **asked)
    assert np.isnan(short["settling_time(x)"]).tolist() == [True, False]
    assert repr(short.table()).split()[:3] == ["c", "settling_time(x)", "ended"]
    assert symdyn.sweep(block, "c=[5]", "settling_time(2)", until=1)["settling_time(2)"] == 0


def test_a_saturated_force_has_no_peak_above_its_limit() -> None:
    asked: dict[str, Any] = {"forces": {"F": "if(30*cos(7*t)>6, 6, 30*cos(7*t))"}, "until": 3}
    for more in ({}, {"method": "radau"}):
        found = symdyn.ensemble(read_text(SPRUNG), measures="max(F)", **asked, **more)  # type: ignore[arg-type]
        assert found["max(F)"] == 6


def late(run: symdyn.Trajectory) -> float:
    """Return when a run is last off its end by more than a fiftieth."""
    return float(run.t[abs(run["x"] - 1) > 0.02][-1])


def test_a_function_of_a_run_is_a_measure(tmp_path: Path) -> None:
    block, asked = read_text(SPRUNG), {"forces": "F=100", "until": 6, "every": 0.02}
    found = symdyn.sweep(block, "c=[5,8]", {"peak": "max(x)", "late": late}, **asked)  # type: ignore[arg-type]
    own = symdyn.sweep(block, "c=[5,8]", ["max(x)", "settling_time(x)"], **asked)  # type: ignore[arg-type]
    assert found["peak"] == pytest.approx(own["max(x)"], rel=1e-5)
    assert found["late"] == pytest.approx(own["settling_time(x)"], abs=0.04)
    each = symdyn.ensemble(block, values={"c": [5, 8]}, measures=late, **asked)  # type: ignore[arg-type]
    assert (each["late"] == found["late"]).all()

    wrong = {"wrong": lambda run: "1.5" if run["x"].max() < found["peak"].mean() else 1}
    failed = symdyn.sweep(block, "c=[5,8]", wrong, **asked)  # type: ignore[arg-type]
    assert "a function takes a run and returns a number" in failed.reasons[1]
    assert "2 runs (1 failed: measure " in repr(failed)
    told = {
        r'measure=\{"peak": f\}': lambda: symdyn.sweep(block, "c=[5,8]", wrong["wrong"]),  # type: ignore[arg-type]
        "in Python a measure may be a function of a run": lambda: symdyn.sweep(block, "c=[5,8]", "overshoot(x)"),
        "is a function of a run, and there is none": lambda: symdyn.sweep(
            block, "m=[5,8]", late, function="mass_matrix", at="x=0"
        ),
    }
    for words, call in told.items():
        with pytest.raises(SimulateError, match=words):
            call()


def test_a_log_without_forces_is_sent_to_output_error() -> None:
    t = np.linspace(0, 1, 50)
    with pytest.raises(IdentifyError, match="output_error finds parameters where forces are not measured"):
        symdyn.identify(symdyn.example("pendulum"), {"t": t, "q1": np.sin(t)})


@pytest.mark.parametrize("forces", ["tau1=atan2(t, 2),tau2=cos(3*t)", ["tau1=atan2(t, 2)", "tau2=cos(3*t)"]])
def test_one_text_says_several_forces_or_laws(forces: str | list[str]) -> None:
    arm, options = symdyn.example("double_pendulum"), {"until": 0.1, "every": 0.05, "start": "q1=0.3"}
    each = {"tau1": "atan2(t, 2)", "tau2": "cos(3*t)"}
    assert (
        symdyn.simulate(arm, forces=forces, **options).q.tolist()
        == symdyn.simulate(arm, forces=each, **options).q.tolist()
    )
    assert symdyn.inverse(CART, "x=max(t, 0), theta=0", [0, 1])["x"][1] == 1
    for wrong, words in {
        "tau1=1;tau2=2": "';' has no place",
        "tau1=1,5": '"5" is neither a file nor name=formula',
    }.items():
        with pytest.raises(SimulateError, match=words):
            symdyn.simulate(arm, forces=wrong, **options)


def test_a_road_may_step_where_no_rate_of_it_acts() -> None:
    lone = """
inputs.road = { unit = "m", rates = 2 }
[bodies.wheel]
mass = 40
[joints.up]
type = "prismatic"
axis = [0, 0, 1]
parent = "ground"
child = "wheel"
coordinate = "z"
[springs.tyre]
from = { body = "ground", at = [0, 0, "road"] }
to = "wheel"
stiffness = 4000
free = 0.3
"""
    start: dict[str, Any] = {"start": "z=0.3", "until": 1, "every": 0.01}
    bare = read_text('gravity = "none"\n' + lone)
    run = symdyn.simulate(bare, forces="road=if(t>0.5, 0.05, 0)", **start)
    late = run.t > 0.5
    assert run["z"][late] == pytest.approx(0.35 - 0.05 * np.cos(10 * (run.t[late] - 0.5)), abs=1e-9)
    assert [note for note in run.notes if "has a step at t = 0.5 s" in note and "energy balance" in note]
    damped = lone + lone[lone.index("[springs.tyre]") :].replace("springs", "dampers").replace(
        "stiffness = 4000\nfree = 0.3", "damping = 1"
    )
    with pytest.raises(SimulateError, match="at t = 0.5 s, where road_dot acts".replace(".", "[.]")):
        symdyn.simulate(read_text(damped), forces="road=if(t>0.5, 0.05, 0)", **start)
    with pytest.raises(SimulateError, match="road, road_dot, road_ddot; of a formula or a table the rates"):
        symdyn.simulate(bare, forces={"road": lambda t: 0.1 * t}, **start)


def test_a_path_is_a_list_of_formulas_and_numbers() -> None:
    arm = symdyn.example("two_link")
    asked: dict[str, Any] = {"until": 1, "values": {"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": 9.81}}
    text = symdyn.inverse(arm, path={"tool": "1.2, 0.2*t, _"}, **asked)
    for path in ([1.2, "0.2*t", "_"], ("1.2", "0.2*t", "_")):
        assert (symdyn.inverse(arm, path={"tool": path}, **asked).q == text.q).all()


ROLLS = """
gravity = [0, 0, -9.81]
[bodies.disc]
mass = 3
inertia = [0.02, 0.03, 0.02]
[joints.plane]
type = "planar"
parent = "ground"
child = "disc"
axis = [0, -1, 0]
coordinates = ["x", "z", "th"]
[constraints.track]
type = "rolling"
body = "disc"
axis = [0, 1, 0]
radius = 0.15
"""


def test_a_wheel_that_falls_through_its_plane_is_told_and_one_that_is_held_is_not() -> None:
    free = symdyn.simulate(read_text(ROLLS), until=1)
    held = symdyn.simulate(read_text(ROLLS + 'components = ["along", "normal"]'), until=1, start={"z": 0.15})

    assert free["z"][-1] == pytest.approx(-9.81 / 2)
    assert 'contact track: disc falls by 4.91 m across its plane in this run; "normal" among' in " ".join(free.notes)
    assert held["z"][-1] == pytest.approx(0.15)
    assert "across its plane" not in " ".join(held.notes)


BALL = """
bodies.ball.mass = 1
[joints.up]
type = "prismatic"
axis = [0, 0, 1]
parent = "ground"
child = "ball"
coordinate = "z"
drive = "F"
[contacts.floor]
body = "ball"
at = [0, 0, -0.05]
normal = [0, 0, 1]
restitution = 0.7
"""


def test_a_corner_between_samples_is_a_peak_as_any_other() -> None:
    ball = read_text(BALL)
    found = symdyn.ensemble(ball, start={"z": [0.5, 0.7]}, measures=["min(z)", "max(z)"], until=1.5)
    assert found["min(z)"] == pytest.approx(0.05, abs=1e-6)
    assert found["max(z)"] == pytest.approx([0.5, 0.7])


def test_what_comes_back_settles_by_its_peak() -> None:
    block = read_text(SPRUNG)
    info = symdyn.linearize(block, outputs=["x_dot"]).step("x_dot", "F").info()
    kept = symdyn.sweep(block, "c=[1]", "settling_time(x)", forces="F=if(t<0.5, 100, 0)", until=20, every=0.01)

    assert info["final"] == 0
    assert info["settling_time"] == pytest.approx(np.log(50) / 0.5, rel=0.1)  # of exp(-c t/2m)
    assert 0.5 < kept["settling_time(x)"][0] < 0.9 * 20


EQUATIONS = symdyn.equations(CART)


@cache
def _lin() -> Linearization:
    return symdyn.linearize(CART)


@cache
def _run() -> Trajectory:
    return symdyn.simulate(CART, until=0.1)


OTHERWISE: dict[str, Callable[[], object]] = {
    "q = [0.1, 0.2, 0.3] is no position; give a number for each of x, theta": (
        lambda: symdyn.picture(CART, [0.1, 0.2, 0.3])
    ),
    "feedback: initial: is the force before the first sample; give a period too": (
        lambda: symdyn.simulate(CART, until=0.1, feedback=symdyn.Feedback(lambda t, q, u: 0.0, initial=[1.0]))
    ),
    "drives F>: give a function of 1 argument; root_locus(": (
        lambda: root_locus("mp", [1, 2], CART)  # type: ignore[arg-type]
    ),
    "rates() takes 2 positional arguments but 3 were given; call it as rates(t, x)": (
        lambda: EQUATIONS.lambdify()(1, 2, 3)  # type: ignore[call-arg, arg-type]
    ),
    "drives F>: give a Program; of a scene, symdyn generate SCENE": lambda: emit(CART),  # type: ignore[arg-type]
    "drives F>: give contents by name; of a scene, symdyn generate": lambda: write(CART, "x"),  # type: ignore[arg-type]
    "unexpected keyword argument 'bind'; symdyn.scene.bind(scene, {'NAME': 0.1}) gives values": (
        lambda: symdyn.read("a.toml", bind={"m": 1})  # type: ignore[call-arg]
    ),
    "write_text(equations.latex()) keeps it": lambda: EQUATIONS.save,  # type: ignore[attr-defined]
    'a system has it, lin["x", "F"].to_control()': (
        lambda: _lin().transfer("x", "F").to_control()  # type: ignore[attr-defined]
    ),
    'lin.transfer("x", "F").at(0) has it': lambda: _lin().dcgain,  # type: ignore[attr-defined]
    "lin.to_control() and lin.latex() have it": lambda: _lin().save,  # type: ignore[attr-defined]
    "for x, theta, x_dot, theta_dot; it has the shape (3, 3)": lambda: _lin().lqr(np.eye(3)),
    "symdyn.identification.output_error(scene, data, parameters) fits by": (
        lambda: symdyn.identify(CART, "x", by="output-error")  # type: ignore[call-arg]
    ),
    "run[NAME][-1] is the last number of one": lambda: _run()[-1],  # type: ignore[call-overload]
    "run(run.t[-1]) has all columns at the end": lambda: _run().final,  # type: ignore[attr-defined]
    "has no attribute 'thetta'; did you mean [\"theta\"]?": lambda: _run().thetta,  # type: ignore[attr-defined]
    "; brackets take t, x, theta, x_dot, ...": lambda: _run().zwiebel,  # type: ignore[attr-defined]
    "3 positional arguments but 4 were given; call it as revolute(name, parent, child, axis=,": (
        lambda: revolute("j", "ground", "a", [0, 0, 1])  # type: ignore[call-arg, arg-type]
    ),
    "all 2 runs failed; the first: measure builtins.max: TypeError": (
        lambda: symdyn.sweep(CART, "mp=[1,2]", max, until=0.1)
    ),
    "'title'; it returns a figure of matplotlib": lambda: _run().plot(title="a"),  # type: ignore[call-arg]
    "symdyn.load(scene, backend=...) has it": lambda: symdyn.lambdify(CART, "mass_matrix", target="jax"),
}


@pytest.mark.parametrize("told", OTHERWISE)
def test_what_one_tries_first_is_answered_in_words(told: str) -> None:
    with pytest.raises((symdyn.SymdynError, AttributeError), match=re.escape(told)):
        OTHERWISE[told]()


def test_values_stand_in_equations_as_bind_puts_them_in_a_shell(capsys: pytest.CaptureFixture[str]) -> None:
    bound = symdyn.equations(CART, values={"mp": 0.2})
    assert main(["equations", str(ROOT / "examples" / "cart_pole.toml"), "--bind", "mp=0.2", "--format", "text"]) == 0
    assert capsys.readouterr().out.strip() == bound.text()
    assert "(mc + 0.2)*x_ddot" in bound.text()
    assert bound.sympy().M == EQUATIONS.subs(mp="0.2").M == EQUATIONS.sympy().subs({"mp": "0.2"}).M


def test_text_is_a_path_for_films_of_modes_and_a_scene_a_problem(tmp_path: Path) -> None:
    (first, _), *_ = symdyn.linear.animate_modes(_lin(), str(tmp_path / "mode.svg"))
    assert first.read_text().startswith("<svg")
    assert symdyn.linear.systems(CART, "mp")(0.2).poles == pytest.approx(
        symdyn.linearize(CART, values={"mp": 0.2}).poles
    )
