"""What one types who knows another tool, and what it is answered: the word that is meant, or how it is called."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.algebra.sympy_algebra import sympy_symbol
from symdyn.arguments import suggesting
from symdyn.cli import main
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.errors import (
    ArgumentError,
    DerivationError,
    DrawError,
    EmitError,
    IdentifyError,
    LinearizeError,
    SceneError,
    SimulateError,
    UnknownNameError,
    suggestion,
)
from symdyn.linear import root_locus
from symdyn.linear.weights import read_weights
from symdyn.scene import body, revolute, scene, spring, table
from symdyn.scene.toml import read_text
from symdyn.simulation import read_feedback
from symdyn.simulation.integrate import integration

pytestmark = pytest.mark.runs("cc")

CART = symdyn.example("cart_pole")

WRONG_CALLS: dict[str, Callable[[], object]] = {
    "body() got an unexpected keyword argument 'inertia_about'; did you mean about?": (
        lambda: body("bob", mass=1, inertia_about="com")  # type: ignore[call-arg]
    ),
    "spring() got an unexpected keyword argument 'from_'; did you mean ends?": (
        lambda: spring("s", from_="a", to="b")  # type: ignore[call-arg]
    ),
    "load() got an unexpected keyword argument 'values'; did you mean parameters?": (
        lambda: symdyn.load(CART, values={})  # type: ignore[call-arg]
    ),
    "simulate() takes 1 positional argument but 2 were given; call it as simulate(scene, forces=, start=": (
        lambda: symdyn.simulate(CART, (0, 3))  # type: ignore[arg-type, call-arg]
    ),
    "simulate() got an unexpected keyword argument 'period'; give it with the controller: feedback=symdyn.Feedback("
    "law, period=...)": lambda: symdyn.simulate(CART, period=0.1),  # type: ignore[call-arg]
    "simulate() got an unexpected keyword argument 'bind'; did you mean values?": (
        lambda: symdyn.simulate(CART, bind={"mc": 1})  # type: ignore[call-arg]
    ),
    "simulate() got an unexpected keyword argument 'controller'; did you mean feedback?": (
        lambda: symdyn.simulate(CART, controller=0)  # type: ignore[call-arg]
    ),
    "Feedback() got an unexpected keyword argument 'limit'; did you mean limits?": (
        lambda: symdyn.Feedback(0, limit=1)  # type: ignore[call-arg]
    ),
    "Problem() got an unexpected keyword argument 'bind'; did you mean values?": (
        lambda: symdyn.Problem(CART, bind={})  # type: ignore[call-arg]
    ),
    "example() missing 1 required positional argument: 'name'; call it as example(name, floating_base=)": (
        symdyn.example  # type: ignore[dict-item]
    ),
    "root_locus() got an unexpected keyword argument 'start'; system takes it": (
        lambda: root_locus("mp", [1, 2], CART, start={})  # type: ignore[call-arg, arg-type]
    ),
    "place() missing 1 required positional argument: 'poles'; call it as place(poles, period)": (
        lambda: symdyn.linearize(CART).place()  # type: ignore[call-arg]
    ),
}


@pytest.mark.parametrize("told", WRONG_CALLS)
def test_a_call_that_does_not_fit_is_told_how_it_is_made(told: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        WRONG_CALLS[told]()
    assert str(caught.value).startswith(told)


def test_an_error_from_inside_a_function_stays_what_it_is() -> None:
    @suggesting
    def outer(names: list[str]) -> str:
        return " ".join(names)

    with pytest.raises(TypeError, match="expected str instance") as caught:
        outer([1])  # type: ignore[list-item]
    assert not isinstance(caught.value, ArgumentError)


@pytest.mark.parametrize(
    ("word", "meant"), [("tf", "transfer"), ("c2d", "discretize"), ("eig", "poles"), ("ctrb", "controllability")]
)
def test_words_of_other_control_tools_are_known(word: str, meant: str) -> None:
    with pytest.raises(AttributeError, match=f"did you mean {meant}\\?"):
        getattr(symdyn.linearize(CART), word)


@pytest.mark.parametrize(("word", "meant"), [("to_df", "to_pandas"), ("time", "t"), ("to_excel", "to_csv")])
def test_words_of_tables_are_known(word: str, meant: str) -> None:
    with pytest.raises(AttributeError, match=f"did you mean {meant}\\?"):
        getattr(symdyn.simulate(CART, until=0.1), word)


def test_of_many_names_the_likest_are_told() -> None:
    many = [f"alpha{k}" for k in range(20)] + ["zeta_bits"]
    assert suggestion("bits_of_it", many).startswith("known are zeta_bits, ")
    assert suggestion("wave", ["c", "b", "a"]) == "known are c, b, a"


def test_rows_are_kept_up_to_where_a_controller_has_no_value() -> None:
    with pytest.warns(RuntimeWarning, match="rows until t = 1 s are kept"):
        run = symdyn.simulate(CART, until=2, feedback=lambda t, q, u: float("nan") if t > 1 else 0.0)
    assert 1 - 1e-6 < run.t[-1] <= 1
    assert len(run.t) >= 100
    assert "at t = 1" in run.stopped


def test_a_run_that_takes_long_warns_and_names_what_grows() -> None:
    said: list[str] = []
    outlook = integration.Outlook(1e6, said.append)
    outlook.last -= 10.0
    outlook.look(1e-3, lambda: "; x_dot has grown to 5e+03 in SI units, so look whether it is unstable")
    assert len(said) == 1
    assert said[0].endswith("x_dot has grown to 5e+03 in SI units, so look whether it is unstable")


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
    "0.1 has 1 entries": ([[1, 1, 1, 1]], {"reference": 0.1}),
}


@pytest.mark.parametrize("told", WRONG_CONTROLLERS)
def test_controllers_that_cannot_act_are_told_what_would(told: str) -> None:
    law, settings = WRONG_CONTROLLERS[told]
    with pytest.raises(SimulateError, match=re.escape(told)):
        read_feedback(CART, symdyn.Feedback(law, **settings))  # type: ignore[arg-type]


def test_one_input_takes_its_limit_as_a_number() -> None:
    run = symdyn.simulate(CART, until=0.5, feedback=symdyn.Feedback(lambda t, q, u: 100 * t, limits=3))
    assert abs(run["F"]).max() == 3


@pytest.mark.parametrize(
    ("formula", "written"),
    [
        ("step(t)", "write if(t > 1, 1, 0)"),
        ("1 if t > 1 else 0", "write if(x > y, a, b)"),
        ("t > 1", "write if(x > y, a, b)"),
        ("clip(t, -1, 1)", "write max(-1, min(x, 1))"),
        ("np.sin(t)", "write sin(x) alone"),
        ("0.1sin(t)", "write * before sin"),
        ("smoothstep(t)", "s**3*(10 - 15*s + 6*s**2)"),
        ("interp(t, d)", 'write table("NAME", x)'),
        ("hypot(t, 1)", "functions are sin, cos"),
    ],
)
def test_formulas_of_other_tools_are_told_how_they_are_written(formula: str, written: str) -> None:
    with pytest.raises(SimulateError, match=re.escape(written)):
        symdyn.simulate(CART, forces={"F": formula})


def _flat() -> symdyn.Scene:
    one = body("b", mass=1, inertia=(0, 0, "J"), about="com")
    return scene("flat", parameters={"J": 1}, bodies=[one], joints=[revolute("p", "ground", "b")])


BASE = """
units = "none"
gravity = "none"
parameters = {{ k = 3, c = 1 }}
inputs = {{ base = 0 }}
bodies.floor.mass = 1
joints.story = {{ type = "prismatic", parent = "ground", child = "floor", coordinate = "x", force = "{force}" }}
{more}
"""


TOLD: dict[str, tuple[type[Exception], Callable[[], object]]] = {
    "a unit stands behind a number alone: in a formula write SI": (
        SimulateError,
        lambda: symdyn.inverse(CART, {"x": "0 m", "theta": "1500 rpm*t"}, until=1),
    ),
    "it is symdyn.identification.excite": (AttributeError, lambda: symdyn.excite),  # type: ignore[attr-defined]
    "it is symdyn.linear.linearize_along": (AttributeError, lambda: symdyn.linearize_along),  # type: ignore[attr-defined]
    "symdyn.load has functions to call": (AttributeError, lambda: symdyn.generate),  # type: ignore[attr-defined]
    'symdyn.scene.write_text(scene, "toml").text is its file': (AttributeError, lambda: CART.save),  # type: ignore[attr-defined]
    "symdyn.Feedback(regulator, reference={...}) sets another point": (
        AttributeError,
        lambda: symdyn.linearize(CART).lqr().kr,  # type: ignore[attr-defined]
    ),
    'a list of names is one panel: plot([["x", "theta"]])': (
        UnknownNameError,
        lambda: symdyn.simulate(CART, until=0.1).plot("x+theta"),
    ),
    "a flat body has [J/2, J/2, J]": (SceneError, _flat),
    'linearize(..., outputs=["x_ddot"]) asks for others': (
        LinearizeError,
        lambda: symdyn.linearize(CART).transfer("x_ddot", "F"),
    ),
    "systems along a run are symdyn.linear.linearize_along(scene, run)": (
        ArgumentError,
        lambda: symdyn.linearize(CART, along=None),  # type: ignore[call-arg]
    ),
    "tau[1]: of what no drive moves, 0": (
        ArgumentError,
        lambda: symdyn.load(CART, "forward_dynamics").forward_dynamics([0, 0], [0, 0], [1]),
    ),
    "Scene has no attribute 'equations'; it is a function: symdyn.equations(scene)": (
        AttributeError,
        lambda: CART.equations,  # type: ignore[attr-defined]
    ),
    "'saturation'; did you mean feedback?": (
        ArgumentError,
        lambda: symdyn.simulate(CART, saturation=8),  # type: ignore[call-arg]
    ),
    "'measures'; did you mean measure?": (
        ArgumentError,
        lambda: symdyn.sweep(CART, "mp=[1,2]", measures="end(x)"),  # type: ignore[call-arg]
    ),
    "the function peak is not known; statistics are max, min,": (
        SimulateError,
        lambda: symdyn.sweep(CART, "mp=[1,2]", "peak(x)", until=1),
    ),
    "symdyn.identification.output_error(scene, data, parameters) takes it": (
        ArgumentError,
        lambda: symdyn.identify(CART, {}, parameters=["mp"]),  # type: ignore[call-arg]
    ),
    'the times of all arrays are called "t"': (
        IdentifyError,
        lambda: symdyn.identify(CART, {"time": np.arange(9.0), "x": np.zeros(9)}),
    ),
    "abs(lin.bode(output, input).response) has ratios": (
        AttributeError,
        lambda: symdyn.linearize(CART).transmissibility,  # type: ignore[attr-defined]
    ),
    "did you mean gravity_forces?": (AttributeError, lambda: symdyn.load(CART, "gravity_forces").gravity),
    "it makes a figure of its own": (
        ArgumentError,
        lambda: symdyn.linearize(CART).bode("x", "F").plot(ax=0),  # type: ignore[call-arg]
    ),
    'x_dot is a velocity; give it by end_rates={"x_dot": 0}': (
        SimulateError,
        lambda: symdyn.collocation(CART, until=1, end={"x": 1, "x_dot": 0}),
    ),
    "start rates: x_dot is given twice": (
        SimulateError,
        lambda: symdyn.simulate(CART, start={"x_dot": 1}, start_rates={"x": 1}),
    ),
    "'N'; did you mean intervals?": (
        ArgumentError,
        lambda: symdyn.collocation(CART, until=1, N=5),  # type: ignore[call-arg]
    ),
    "write rates = 1 in [inputs.base]": (SceneError, lambda: _on_a_base("-k*x - c*(x_dot - base_dot)", "")),
    "base disturbs, as there is a drive to control by: tau1; base controls where its joint has drive = false": (
        LinearizeError,
        lambda: symdyn.linearize(_on_a_base("base - k*x", "")).lqr({"x": 1}, {"base": 1}),
    ),
    'outputs come first, then inputs: ("theta", "F")': (
        LinearizeError,
        lambda: symdyn.linearize(CART).bode("F", "theta"),
    ),
    "gains are those of its parts, .regulator.K and .observer.L": (
        AttributeError,
        lambda: symdyn.linearize(CART).lqg().K,  # type: ignore[attr-defined]
    ),
    'film("a.gif") writes a file': (
        DrawError,
        lambda: symdyn.simulate(CART, until=0.1).animate("a.gif"),  # type: ignore[arg-type]
    ),
    "symdyn.picture(scene) draws it": (AttributeError, lambda: CART.plot),  # type: ignore[attr-defined]
    "did you mean pose:NAME?": (DerivationError, lambda: symdyn.load(CART, "fk")),
    "write pose:NAME, such as pose:tip": (DerivationError, lambda: symdyn.load(CART, "pose")),
    "limits: u: is no input of the controller; it has F": (
        SimulateError,
        lambda: symdyn.simulate(CART, until=0.1, feedback=symdyn.pid("theta", "F", kp=1, limits={"u": 8})),
    ),
    "write Q=theta:100;theta_dot:10": (LinearizeError, lambda: read_weights("--lqr", ["theta=100,theta_dot=10"], "QR")),
    "outputs are weighed by Q = lin.C.T @ W @ lin.C": (LinearizeError, lambda: symdyn.linearize(CART).lqr({"v": 1})),
    "which have a .closed_loop": (LinearizeError, lambda: symdyn.linearize(CART).feedback(0)),
    "give a name, values and a function": (LinearizeError, lambda: root_locus(CART, "mp", [1, 2])),  # type: ignore[arg-type]
    'symdyn.linear.root_locus("mp", values, system)': (
        LinearizeError,
        lambda: symdyn.linearize(CART).root_locus("theta", "mp"),
    ),
    "did you mean theta_dot?": (SimulateError, lambda: symdyn.simulate(CART, forces={"F": "-2*dtheta"})),
    "did you mean M?": (AttributeError, lambda: symdyn.equations(CART).sympy().mass_matrix),  # type: ignore[attr-defined]
    "it is tau - c - g - k_E": (AttributeError, lambda: symdyn.equations(CART).sympy().forcing),  # type: ignore[attr-defined]
    "run(0.5) has all columns at a time": (
        AttributeError,
        lambda: symdyn.simulate(CART, until=0.1).sol,  # type: ignore[attr-defined]
    ),
    'design="saltelli"': (AttributeError, lambda: symdyn.sobol),  # type: ignore[attr-defined]
    "of symdyn.load(scene), .mass_matrix(q, ...)": (AttributeError, lambda: symdyn.mass_matrix),  # type: ignore[attr-defined]
    "symdyn.scene.bind(scene, {...}) keeps them": (AttributeError, lambda: CART.replace),  # type: ignore[attr-defined]
    "'events'; did you mean stops?": (ArgumentError, lambda: symdyn.simulate(CART, events="x")),  # type: ignore[call-arg]
    "give a vector such as [0, 0, -9.81]": (SceneError, lambda: _with("gravity = 9.81")),
    "of a ball [J, J, J]": (SceneError, lambda: _with(body="inertia = 3")),
    "a flat body has [J/2, J, J/2]": (SceneError, lambda: _with(body="inertia = [0, 1, 0]")),
    '[springs.NAME] joint = "JOINT", stiffness': (SceneError, lambda: _with(joint="stiffness = 3")),
    "a place in space is its origin": (SceneError, lambda: _with(joint="position = [0, 0, 1]")),
    "stands in quotes": (SceneError, lambda: _with("g = 9,81")),
    "symdyn.draw is a package, and not called; symdyn.picture(scene) does it": (
        ArgumentError,
        lambda: symdyn.draw(CART),  # type: ignore[operator]
    ),
    "symdyn.verify is a package, and not called; symdyn.certify(scene) does it": (
        ArgumentError,
        lambda: symdyn.verify(CART),  # type: ignore[operator]
    ),
    "symdyn.linear.linearize_at_rest(scene) finds all": (AttributeError, lambda: symdyn.trim),  # type: ignore[attr-defined]
    "it is symdyn.linearize(...).poles": (AttributeError, lambda: symdyn.eigenvalues),  # type: ignore[attr-defined]
    "it is symdyn.simulate(scene, until=...)": (AttributeError, lambda: symdyn.solve_ivp),  # type: ignore[attr-defined]
    "every=0.01 spaces the rows; run(t) has": (ArgumentError, lambda: symdyn.simulate(CART, t_eval=[0])),  # type: ignore[call-arg]
    "a run begins at t = 0, and until= is": (ArgumentError, lambda: symdyn.simulate(CART, t_span=(0, 1))),  # type: ignore[call-arg]
    "run(t) has all columns between": (ArgumentError, lambda: symdyn.simulate(CART, dense_output=True)),  # type: ignore[call-arg]
    "steps are chosen for rtol=": (ArgumentError, lambda: symdyn.simulate(CART, max_step=0.1)),  # type: ignore[call-arg]
    "values={...} gives parameters": (ArgumentError, lambda: symdyn.simulate(CART, args=())),  # type: ignore[call-arg]
    "'q1_dot': 0} gives positions and": (ArgumentError, lambda: symdyn.simulate(CART, y0=[0])),  # type: ignore[call-arg]
    "forces={'NAME': 'formula in t'} drives": (ArgumentError, lambda: symdyn.simulate(CART, u=1)),  # type: ignore[call-arg]
    "known are A, B, C, D, bode,": (AttributeError, lambda: symdyn.linearize(CART).zz9),  # type: ignore[attr-defined]
    "it is symdyn.equations(scene).latex()": (AttributeError, lambda: symdyn.latex),  # type: ignore[attr-defined]
    "it is one of .sympy(), such as M": (AttributeError, lambda: symdyn.equations(CART).M),  # type: ignore[attr-defined]
    "its .closed_loop has them": (AttributeError, lambda: symdyn.linearize(CART).lqr().step),  # type: ignore[attr-defined]
    "did you mean pose_tip?": (AttributeError, lambda: symdyn.load(CART).forward_kinematics),
    "did you mean damp?": (AttributeError, lambda: symdyn.linearize(CART).natural_frequencies),  # type: ignore[attr-defined]
    "column energy; did you mean kinetic_energy?": (
        UnknownNameError,
        lambda: symdyn.simulate(CART, until=0.1)["energy"],
    ),
    "an integral time is ki = kp/Ti": (ArgumentError, lambda: symdyn.pid("x", "F", kp=1, Ti=1)),  # type: ignore[call-arg]
    "did you mean restitution?": (ArgumentError, lambda: symdyn.scene.contact("c", body="b", e=1)),  # type: ignore[call-arg]
    "did you mean hertz?": (ArgumentError, lambda: symdyn.linearize(CART).bode(Hz=True)),  # type: ignore[call-arg]
    "method ode45 is not known; did you mean rk45?": (SimulateError, lambda: symdyn.simulate(CART, method="ode45")),
    "depends on x_ddot, which forces make at once": (
        SimulateError,
        lambda: symdyn.simulate(
            CART, until=0.1, feedback=symdyn.linearize(CART, outputs=["theta", "x", "x_ddot"]).lqg()
        ),
    ),
    "integral: xx is no output or state; did you mean x?": (
        LinearizeError,
        lambda: symdyn.linearize(CART).lqr(integral="xx"),
    ),
    "N: is no matrix of 4 x 1": (LinearizeError, lambda: symdyn.linearize(CART).lqr(N=[[1.0]])),
    "N: is so large that": (LinearizeError, lambda: symdyn.linearize(CART).lqr(0.1, 1, N=[[9.0]] * 4)),
    "leave period out": (LinearizeError, lambda: symdyn.linearize(CART).lqr(N=[[0.1]] * 4, period=0.1)),
    "gains act on integrals, too": (LinearizeError, lambda: symdyn.linearize(CART).lqr(integral="x").gains()),
    "no input moves the mode 0, of theta_integral": (
        LinearizeError,
        lambda: symdyn.linearize(CART).lqr(integral="theta"),
    ),
    'scene.toml:3: column 9: quotes are missing around 2*m; write "2*m"': (
        SceneError,
        lambda: _with(body="mass = 2*m"),
    ),
    'quotes are missing around max(a, 2); write "max(a, 2)"': (SceneError, lambda: _with(body="mass = max(a, 2)")),
    'quotes are missing around l/2; write "l/2"': (SceneError, lambda: _with(body="mass = 1\ncom = [l/2, 0, 0]")),
    'quotes are missing around 3*k; write "3*k"': (SceneError, lambda: _with("parameters = { m = 3*k, n = 1 }")),
    'quotes are missing around 90 deg; write "90 deg"': (SceneError, lambda: _with(joint="start = 90 deg")),
    '“m1” stands in curly quotes; write "m1"': (SceneError, lambda: _with(body="mass = “m1”")),
    "decimals have a point; write 0.5": (SceneError, lambda: _with("parameters = { m = { value = 0,5 } }")),
    "write false in small letters": (SceneError, lambda: _with(joint="drive = False")),
    ".5 lacks a digit beside its point; write 0.5": (SceneError, lambda: _with(body="mass = .5")),
    "0 1: a comma stands between numbers": (SceneError, lambda: _with(joint="axis = [0, 0 1]")),
    'the text has no end; write " behind it': (SceneError, lambda: _with(joint='coordinate = "phi')),
    "is not valid TOML: Unclosed array": (SceneError, lambda: _with(joint="axis = [0, 0, 1\ndrive = false")),
    "where its ends meet, spring prop has no direction": (
        LinearizeError,
        lambda: symdyn.linearize(
            _on_a_base("-k*x", '[springs.prop]\nfrom = "floor"\nto = "ground"\nstiffness = 1\nfree = 1')
        ),
    ),
}


def _with(head: str = "", body: str = "mass = 1", joint: str = "") -> symdyn.Scene:
    kind = 'type = "revolute"\nparent = "ground"\nchild = "b"'
    return read_text(f"{head}\n[bodies.b]\n{body}\n[joints.j]\n{kind}\n{joint}\n")


def _on_a_base(force: str, more: str) -> symdyn.Scene:
    return read_text(BASE.format(force=force, more=more))


@pytest.mark.parametrize("told", TOLD)
def test_what_is_asked_in_another_place_is_told_where_it_is(told: str) -> None:
    error, asked = TOLD[told]
    with pytest.raises(error, match=re.escape(told)):
        asked()


WORKS: dict[str, Callable[[], object]] = {
    "poles()": lambda: np.array_equal(symdyn.linearize(CART).poles(), symdyn.linearize(CART).poles),
    "zeros()": lambda: len(symdyn.linearize(CART, outputs="x").zeros()) == 2,
    "abs(poles)": lambda: type(abs(symdyn.linearize(CART).poles)) is np.ndarray,
    "repr(poles)": lambda: repr(symdyn.linearize(CART).poles).startswith("array(["),
    "formulas()": lambda: symdyn.linearize(CART).formulas().A.rows == 4,
    "margins of LQG": lambda: (lqg := symdyn.linearize(CART).lqg()).margins() == lqg.loop.margins(),
    "limits by name": lambda: _largest(symdyn.pid("theta", "F", kp=900, limits={"F": 8})) == 8,
    "limits as a pair": lambda: _largest(symdyn.Feedback(lambda t, q, u: 99, limits=(-1, 8))) == 8,
    "a column of a solution": lambda: len(_reached()["F"]) > 4,
    "velocities at the start": lambda: symdyn.simulate(CART, until=0.1, start={"x": 0, "x_dot": 1})["x_dot"][0] == 1,
    "states of a run": lambda: symdyn.simulate(CART, until=0.1).states.shape[1] == 4,
    "the only measure": lambda: np.isfinite(symdyn.sweep(CART, "mp=[1,2]", "end(x)", until=0.1).mean()),
    "inertia without a centre of mass": lambda: _with(body="mass = 1\ninertia = [1, 1, 1]").bodies[0].about == "com",
    "K, S, E": lambda: [len(one) for one in symdyn.linearize(CART).lqr()] == [1, 4, 4],
    "L, P, E": lambda: [len(one) for one in symdyn.linearize(CART).kalman()] == [4, 4, 4],
    "mag, phase, omega": lambda: [one.shape for one in symdyn.linearize(CART).bode("x", "F")] == [(200,)] * 3,
    "t, y": lambda: [one.shape for one in symdyn.linearize(CART).step()] == [(500,), (2, 1, 500)],
    "gm, pm, wcg, wcp": lambda: len([*symdyn.linearize(CART).lqr().loop.margins()]) == 4,
    "forces as a dict of columns": lambda: (
        symdyn.simulate(CART, until=1, forces={"t": [0, 1], "F": [0, 2]})["F"][-1] == 2
    ),
    "times of a motion given as columns": lambda: (
        len(symdyn.inverse(CART, {"t": [0, 0.5, 1], "x": [0, 1, 2], "theta": [0, 0, 0]}).t) == 3
    ),
    "a motion that joints have, alone": lambda: (
        symdyn.inverse(_with('units = "none"', joint='motion = "t"'), until=1).complete
    ),
    "a table as columns": lambda: table("d", {"x": [0, 1], "y": [1, 2]}) == table("d", [(0, 1), (1, 2)]),
    "a table by its values": lambda: table("d", {0: 1, 1: 2}) == table("d", [(0, 1), (1, 2)]),
    "bounds as a size": lambda: 15 in symdyn.collocation(CART, until=1, bounds={"F": 15}, intervals=1).upper,
}


def _reached() -> symdyn.transcription.Solution:
    pytest.importorskip("casadi", reason="needs IPOPT")
    return symdyn.collocation(CART, until=1, end={"x": 0.1}, cost="F**2", intervals=4).solve()


def _largest(controller: symdyn.Feedback) -> float:
    return float(abs(symdyn.simulate(CART, until=0.1, start={"theta": 0.3}, feedback=controller)["F"]).max())


@pytest.mark.parametrize("words", WORKS)
def test_what_one_writes_who_knows_another_tool_works(words: str) -> None:
    assert WORKS[words]()


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["equations", "a.toml", "--latex"], "give --format latex"),
        (["plot", "a.toml"], "simulate, inverse and sweep write one, --plot FILE"),
        (["animate", "a.toml"], "simulate writes one, --animate FILE"),
        (["linearize", "a.toml", "--from", "F"], "inputs are all drives and inputs of the scene"),
        (["linearize", "a.toml", "--to", "theta"], "give --outputs"),
        (["bode", "a.toml"], "did you mean linearize?"),
        (["simulate", "a.toml", "--noise", "x=1"], "in Python a controller has it: symdyn.Feedback(law, noise=...)"),
        (["sweep", "a.toml", "--noise", "x=1"], "in Python a controller has it: symdyn.Feedback(law, noise=...)"),
        (["identify", "a.toml", "--output-error", "m"], "--output-error is no option; give --by output-error"),
        (["linearize", "a.toml", "--transmissibility", "z"], "give --bode FILE"),
        (["generate", "a.toml", "--language", "c"], "did you mean --target?"),
        (["eom", "a.toml"], "did you mean equations?"),
        (["equilibrium", "a.toml"], "did you mean linearize?"),
        (["trim", "a.toml"], "did you mean linearize?"),
        (["linearize", "a.toml", "--trim", "x"], "did you mean --start?"),
    ],
)
def test_the_shell_guesses_what_is_meant_or_nothing(
    words: list[str], meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(words)
    assert meant in capsys.readouterr().err


@pytest.mark.parametrize(
    ("motion", "told"),
    [
        ("hinge=sin(t)", "hinge is not a coordinate, but a joint: it has theta"),
        ("x=t,theta=sin(t)", 'one of {"x": "t", "theta": "sin(t)"}'),
        ("theta=minjerk(0,1,2)", "a motion has quintic(a, b, T)"),
        ("theta=angle.csv", "theta: a file is given alone, angle.csv"),
    ],
)
def test_motions_as_one_would_write_them_are_told_how(motion: str, told: str) -> None:
    with pytest.raises(SimulateError, match=re.escape(told)):
        symdyn.inverse(CART, [motion], until=1)


def test_weights_as_one_would_write_them_are_told_how() -> None:
    for text, told in (
        ("Q=diag(1,10,0,0)", "write Q=NAME:1;NAME:2"),
        ("Q=x:1,theta:10", "semicolons stand between weights: x:1;theta:10"),
    ):
        with pytest.raises(LinearizeError, match=re.escape(told)):
            read_weights("--lqr", [text], ("Q", "R"))


def test_complex_weights_are_no_real_ones() -> None:
    """The imaginary part was left out with no word of ours."""
    lin = symdyn.linearize(CART)
    for given, told in (({"N": 1j * np.ones((4, 1))}, "N: is no matrix of 4 x 1"), ({"Q": 1j * np.eye(4)}, "Q: is no")):
        with pytest.raises(LinearizeError, match=told):
            lin.lqr(**given)  # type: ignore[arg-type]


def test_equations_are_printed_by_other_formulations_in_python() -> None:
    pendulum = symdyn.example("pendulum")
    page = symdyn.equations(pendulum, "dalembert")
    assert page.text() != symdyn.equations(pendulum).text()
    with pytest.raises(EmitError, match="are printed, by"):
        page.sympy()
    with pytest.raises(EmitError, match=r"did you mean dalembert\?"):
        symdyn.equations(pendulum, "d'alembert")


def test_a_problem_without_a_solution_warns() -> None:
    pytest.importorskip("casadi", reason="needs IPOPT")
    problem = symdyn.collocation(CART, until=0.2, cost="F**2", end={"x": 1}, bounds={"F": (-1, 1)}, intervals=4)
    with pytest.warns(RuntimeWarning, match="no solution was found: .*Infeasible"):
        assert not problem.solve().success


def test_a_plot_may_be_over_another_column_than_time() -> None:
    pytest.importorskip("matplotlib", reason="draws")
    run = symdyn.simulate(CART, until=0.5, start={"theta": 0.3})
    (axis,) = run.plot("x", x="theta").axes
    assert np.array_equal(axis.lines[0].get_xdata(), run["theta"])
    assert "rad" in axis.get_xlabel()
    with pytest.raises(UnknownNameError, match="thet"):
        run.plot("x", x="thet")


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
        assert any("the loop hinge open by 6.19" in note and note.endswith(MIRRORED) for note in notes)
    for meant in (text, text.replace(right, wrong.replace("tip", "child_origin"))):
        assert Numbers(read_text(meant)).closed_position().notes == ()


def test_sympy_prints_rates_with_dots_and_they_stay_symbols_of_their_names() -> None:
    import pickle

    import sympy

    cart = symdyn.equations(CART).sympy()
    assert r"\ddot{x}" in sympy.latex(cart.equations)
    assert sympy.latex(symdyn.equations(CART)) == sympy.latex(cart) == sympy.latex(sympy.Tuple(*cart.equations))
    assert "x\N{COMBINING DIAERESIS}" in sympy.pretty(symdyn.equations(CART), use_unicode=True)
    assert sympy.sympify(cart) == sympy.Tuple(*cart.equations)
    assert sympy.latex(cart["theta_ddot"], symbol_names={cart["theta_ddot"]: "a"}) == "a"
    for name, latex in {"q1_dot": r"\dot{q}_{1}", "q_1_ddot": r"\ddot{q}_{1}", "s_sf_dot": r"\dot{s}_{sf}"}.items():
        assert sympy.latex(sympy_symbol(name, {})) == latex
    ours, plain = cart["x_dot"], sympy.Symbol("x_dot", real=True)
    assert (ours == plain, plain == ours, hash(ours) == hash(plain), str(ours)) == (True, True, True, "x_dot")
    assert (ours - plain, (plain**2).subs(ours, 3), (ours**2).subs(plain, 3), (ours**2).diff(plain)) == (
        0,
        9,
        9,
        2 * ours,
    )
    assert ours not in (sympy.Symbol("x_dot"), sympy.Dummy("x_dot", real=True))
    assert pickle.loads(pickle.dumps(cart.M * cart.qdd)) == cart.M * cart.qdd


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

    failed = symdyn.sweep(block, "c=[5,8]", wrong := {"wrong": lambda run: "1.5"}, until=1)  # type: ignore[arg-type]
    assert "a function takes a run and returns a number" in failed.reasons[1]
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


def test_what_was_silent_is_told(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with pytest.raises(SimulateError, match=r'formulas of the state are forces: forces=\{"F": "-x"\}'):
        symdyn.simulate(CART, feedback={"F": "-x"}, until=1)
    with pytest.raises(ArgumentError, match="did you mean bounds"):
        symdyn.collocation(CART, until=1, limits={"F": 15})  # type: ignore[call-arg]
    upright = symdyn.linearize(CART)
    told = 'V misses theta: measured with variance 1; linearize with outputs=["x"] leaves it out'
    assert upright.kalman({"F": 1}, {"x": 1e-6}).notes == (told,)
    assert told in repr(upright.kalman({"F": 1}, {"x": 1e-6}))
    assert told in repr(upright.lqg(W={"F": 1}, V={"x": 1e-6}))
    assert "misses" not in repr(upright.kalman({"F": 1}, {"x": 1e-6, "theta": 1e-6}))

    assert "no cost: any motion" in repr(symdyn.collocation(CART, until=1, end={"x": 1}, intervals=4))
    assert "no cost" not in repr(symdyn.collocation(CART, until=1, end={"x": 1}, cost="F**2", intervals=4))
    with pytest.raises(SimulateError, match="and no force, whose cost is over time: cost"):
        symdyn.collocation(CART, until=1, end={"x": 1}, final_cost="F**2", intervals=4)

    path = str(tmp_path / "cart.toml")
    Path(path).write_text(symdyn.scene.write_text(CART, "toml").text)
    regulator = upright.lqr({"x": 1, "x_integral": 2}, {"F": 0.1}, N={"x*F": 0.05}, integral="x")
    asked = ["--lqr", "Q=x:1;x_integral:2", "R=F:0.1", "N=x*F:0.05", "integral=x"]
    assert main(["linearize", path, *asked, "--show", "margins", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["lqr"]["K"] == regulator.K.tolist()
    assert main(["linearize", path, *asked, "--show", "margins"]) == 0
    shown = capsys.readouterr().out
    assert f"loop of the regulator, cut open at F, stable: {regulator.margins().words}" in shown
    assert main(["linearize", path, "--lqr", "N=F*x:1"]) == 1
    assert "N: F*x is no state times a drive; write such as x*F" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["simulate", path, "--quantisation", "theta=0.1"])
    assert "in Python a controller has it: symdyn.Feedback(law, quantisation=...)" in capsys.readouterr().err


def test_a_regulator_of_two_drives_has_the_margins_of_each_loop(capsys: pytest.CaptureFixture[str]) -> None:
    values = {"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": 9.81}
    lin = symdyn.linearize(symdyn.example("two_link"), values=values)
    reg, lqg = lin.lqr(), lin.lqg()
    for k, drive in enumerate(reg.inputs):
        j, found = 1 - k, reg.margins(drive)
        b, c = lin.B[:, [k]], reg.K[[k]]
        A = lin.A - lin.B[:, [j]] @ reg.K[[j]]
        w = np.geomspace(1e-2, 1e3, 20001)
        loop = np.array([(c @ np.linalg.solve(1j * x * np.eye(len(A)) - A, b))[0, 0] for x in w])
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
        f"cut open at M2 and closed at the other drives, stable: {reg.margins('M2').words}" in capsys.readouterr().out
    )


def test_a_log_without_forces_is_sent_to_output_error() -> None:
    t = np.linspace(0, 1, 50)
    with pytest.raises(IdentifyError, match="output_error finds parameters where forces are not measured"):
        symdyn.identify(symdyn.example("pendulum"), {"t": t, "q1": np.sin(t)})
    with pytest.raises(SimulateError, match=r'x: each is one of \{"x": "t", "theta": 0\}'):
        symdyn.inverse(CART, "x=t, theta=0", [0, 1])


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


def test_a_small_grid_is_shown_row_by_row(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "block.toml"
    path.write_text(SPRUNG)
    asked = ["sweep", str(path), "--over", "c=[5,8]", "--start", "x=1", "--until", "1", "--measure", "end(x)"]
    assert main(asked) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split()[0] for row in rows if row.split()[-1:] == ["end"]] == ["5", "8"]


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


def test_a_time_in_text_is_answered_with_the_units_of_numbers() -> None:
    with pytest.raises(SimulateError, match="until = '5 s': give a number, in SI"):
        symdyn.simulate(CART, until="5 s")  # type: ignore[arg-type]


def test_a_wheel_that_falls_through_its_plane_is_told_and_one_that_is_held_is_not() -> None:
    free = symdyn.simulate(read_text(ROLLS), until=1)
    held = symdyn.simulate(read_text(ROLLS + 'components = ["along", "normal"]'), until=1, start={"z": 0.15})

    assert free["z"][-1] == pytest.approx(-9.81 / 2)
    assert 'contact track: disc falls by 4.91 m across its plane in this run; "normal" among' in " ".join(free.notes)
    assert held["z"][-1] == pytest.approx(0.15)
    assert "across its plane" not in " ".join(held.notes)
