"""Doors of Python say in words what they do not take, what they take, and where something else is."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from reference import CONSTRUCTED, catalogue, members, object_of

import symdyn
from symdyn.cli import main
from symdyn.errors import (
    ArgumentError,
    DerivationError,
    DrawError,
    LinearizeError,
    SimulateError,
    SymdynError,
    UnknownNameError,
)
from symdyn.simulation import Trajectory
from symdyn.transcription import Solution, along

CART = symdyn.example("cart_pole")

BESIDE = (
    *("dynamics.derive", "program.lower", "emit.emit", "runtime.second_derivatives", "scene.with_contacts"),
    *("linear.track", "linear.linearize_at_rest", "linear.linearize_along", "linear.animate_modes"),
    *("transcription.along", "runtime.build", "emit.write", "emit.read_program", "teach.walkthrough", "bench.bench"),
    *("dynamics.unique_reactions", "dynamics.linear_parameters"),
)
"""What pages name beside the reference."""

NAMES = [*(name for names in catalogue().values() for name in names), *(f"symdyn.{name}" for name in BESIDE)]


def called(name: str) -> dict[str, Callable[..., object]]:
    """Return what a user may call of a name: itself, or the methods of what functions return, without an object."""
    one: Any = object_of(name)
    if not inspect.isclass(one):
        return {name: one}
    own = {**members(one), "__call__": vars(one).get("__call__")}
    found = {key: inspect.getattr_static(one, key) for key, each in own.items() if each is not None}
    bound = {key: getattr(one, key) for key, each in found.items() if isinstance(each, classmethod | staticmethod)}
    methods = {key: partial(each, None) for key, each in found.items() if inspect.isfunction(each)}
    loose = {key for key, each in methods.items() if "**" in str(inspect.signature(each))}
    both = {key: each for key, each in (methods | bound).items() if key not in loose}
    return {f"{name}.{key}": each for key, each in both.items()} | (
        {name: one} if one.__name__ in (*CONSTRUCTED, "StateSpace") else {}
    )


CALLED = {key: one for name in NAMES for key, one in called(name).items()}


@pytest.mark.parametrize("name", CALLED)
def test_an_argument_that_is_none_is_told_with_what_is_taken(name: str) -> None:
    with pytest.raises(SymdynError, match=r"(?i)nonsense") as told:
        CALLED[name](nonsense=1)
    assert re.search(r"; (did you mean |there are |it |call it as |give |.* takes )", str(told.value)), str(told.value)


@cache
def run() -> Trajectory:
    return symdyn.simulate(CART, until=0.2, start={"theta": 0.1}, method="dop853")


@cache
def linear() -> symdyn.linear.Linearization:
    return symdyn.linearize(CART)


def solution(z: Callable[[Any], Any], until: float = 0.2, **end: float) -> Solution:
    """Return what a solver might have found: a motion, and the place where it is said to end."""
    given: dict[str, Any] = {"end": end, "end_rates": "free"}
    problem = symdyn.collocation(CART, until, 8, start={"theta": 0.1}, cost="F**2", **given)
    return Solution(problem, z(problem), np.zeros(problem.rows), 0.0, 0.0, True, "made by hand", 0, 0.0)


@cache
def falls() -> Solution:
    """No force, and the pole is asked to be upright at the end."""
    return solution(lambda problem: problem.guess, theta=0.0)


TOLD: dict[str, tuple[type[SymdynError], Callable[[], object]]] = {
    "give a Problem: symdyn.Problem(scene, start={'x': 1})": (
        ArgumentError,
        lambda: symdyn.linear.systems(CART, "l", start={"x": 1}),  # type: ignore[call-arg]
    ),
    "system takes it: lambda m:": (
        ArgumentError,
        lambda: symdyn.linear.root_locus("l", [1, 2], linear, start={"x": 1}),  # type: ignore[call-arg,arg-type]
    ),
    "simulate() got an unexpected keyword argument 'untill'; did you mean until?": (
        ArgumentError,
        lambda: falls().simulated(untill=1),
    ),
    "plot() got an unexpected keyword argument 'ax'; did you mean axes?": (ArgumentError, lambda: falls().plot(ax=1)),
    ".simulated()(0.5) is the motion at any time": (SimulateError, lambda: falls()(0.5)),
    "says no forces; give its .forces, or a formula": (
        SimulateError,
        lambda: symdyn.simulate(CART, until=1, forces=falls()),  # type: ignore[arg-type]
    ),
    "measure: ": (
        SimulateError,
        lambda: symdyn.sweep(CART, "l=[1,2]", linear().step(), until=0.1),  # type: ignore[arg-type]
    ),
    'lin.transfer("x", "F")(1.0) is at any s': (LinearizeError, lambda: linear().bode()(1.0)),
    "this has numbers at .t; numpy.interp(1.0, ": (LinearizeError, lambda: linear().step()(1.0)),
    'lin.transfer("x", "F")(1j) is G at any s': (LinearizeError, lambda: linear()(1j)),
    "system = <Linearization": (
        LinearizeError,
        lambda: symdyn.linear.root_locus("l", [1, 2], linear()),  # type: ignore[arg-type]
    ),
    "simulated runs have point_tip_x, point_tip_y, point_tip_z, found.simulated()": (
        UnknownNameError,
        lambda: falls().run["point_tip"],
    ),
    "no column drive_power; simulated runs have drive_power, ": (
        UnknownNameError,
        lambda: falls()["drive_power"],
    ),
    'V is of outputs, which linearize chooses: outputs=["x", "theta", "x_dot"]': (
        LinearizeError,
        lambda: linear().kalman({"F": 1}, {"x_dot": 1}),
    ),
    'x_dot is not known; known are x, theta; V is of outputs, which linearize chooses: outputs=["x", ': (
        LinearizeError,
        lambda: linear().lqg(None, None, None, {"x_dot": 1}),
    ),
    "-K @ x are its forces, x from its point": (LinearizeError, lambda: linear().lqr()(0.0, [0, 0], [0, 0])),
    "or a Start or None; names are x, theta": (
        SimulateError,
        lambda: symdyn.simulate(CART, until=1, start=run()),  # type: ignore[arg-type]
    ),
    "by zero at t = 0 s, given x = 0, theta = 0.1, x_dot = 0, theta_dot = 0": (
        SimulateError,
        lambda: symdyn.simulate(CART, until=1, start={"theta": 0.1}, feedback=lambda t, q, u: 1 / t),
    ),
}


@pytest.mark.runs("cc")
@pytest.mark.parametrize("told", TOLD)
def test_what_is_no_argument_column_or_function_is_told_with_where_it_is(told: str) -> None:
    error, asked = TOLD[told]
    with pytest.raises(error, match=re.escape(told)):
        asked()


def test_parts_of_a_scene_are_by_name_in_brackets() -> None:
    with pytest.raises(AttributeError, match=r'^Named has no attribute \'mc\'; write \["mc"\]$'):
        _ = CART.parameters.mc  # type: ignore[attr-defined]
    assert dict(CART.parameters)["mc"] is CART.parameters[0]  # type: ignore[call-overload]


LETTERS = {
    "D": '-eq.tau.jacobian(eq.qd)', "B": 'eq.tau.jacobian([eq["F"]])', "Q": "tau", "h": "c + g + k_E", "T": "K",
    "V": "P", "E": "K + P", "J": "G", "Phi": "residual", "lam": "multipliers", "Minv": "M.inv()", "dq": "qd",
    "f": "state_space()", "A": "symdyn.linearize(scene).formulas",
}  # fmt: skip


@pytest.mark.parametrize("letter", LETTERS)
def test_a_letter_of_other_books_is_told_with_ours_which_is_there(letter: str) -> None:
    eq = symdyn.equations(CART).sympy()
    with pytest.raises(AttributeError, match=re.escape(LETTERS[letter])):
        getattr(eq, letter)
    known = {name: getattr(eq, name) for name in dir(eq) if not name.startswith("_")}
    eval(LETTERS[letter], {**known, "eq": eq, "symdyn": symdyn, "scene": CART})


PLOTTED: dict[str, Callable[[], Any]] = {
    "run": run,
    "solution": falls,
    "bode": lambda: linear().bode(),
    "nyquist": lambda: linear().nyquist(),
    "step": lambda: linear().step(),
    "system": linear,
    "regulator": lambda: linear().lqr(),
    "locus": lambda: linear().root_locus("theta", "F"),
    "over a parameter": lambda: symdyn.linear.root_locus("l", [1, 2], symdyn.linear.systems(CART, "l")),
    "uncertainty": lambda: symdyn.uncertainty(CART, {"mc": 0.01}, motion="x=t,theta=0", times=[0, 0.1]),
    "ensemble": lambda: symdyn.ensemble(CART, until=0.1, start={"theta": [0.1, 0.2]}, measures="max(x)"),
}


@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", PLOTTED)
def test_every_plot_draws_into_axes_that_are_given(name: str) -> None:
    pyplot = pytest.importorskip("matplotlib.pyplot")
    noun = PLOTTED[name]()
    usual = [one for one in noun.plot().axes if one.get_label() != "<colorbar>"]
    mine, axes = pyplot.subplots(len(usual), 1, squeeze=False)
    assert noun.plot(axes=axes) is mine
    for own, given in zip(usual, axes.ravel(), strict=True):
        drawn = [[len(x.lines), len(x.collections), len(x.patches)] for x in (own, given)]
        assert drawn[0] == drawn[1]
    for wrong in ([*axes.ravel(), axes[0, 0]], 3):
        with pytest.raises(DrawError, match=r"^axes: give (\d|one) axes of matplotlib, such as pyplot.subplots\("):
            noun.plot(axes=wrong)
    pyplot.close(mine)


@pytest.mark.runs("cc")
def test_a_solution_tells_by_how_much_its_forces_miss_the_end_that_was_asked() -> None:
    (told,) = [one for one in falls().notes if one.startswith("simulated with its forces")]
    end = falls().simulated()["theta"][-1]
    assert f"the motion ends at theta = {end:.4g} rad and not 0: give more intervals" in told
    kept = solution(lambda problem: along(problem, run()), theta=float(run()["theta"][-1]))
    assert abs(kept.simulated()["theta"][-1] - run()["theta"][-1]) < 1e-6
    assert not [one for one in kept.notes if one.startswith("simulated")]


@pytest.mark.runs("cc")
def test_a_solution_is_simulated_to_another_end_and_from_another_start() -> None:
    short, moved = falls().simulated(until=0.1), falls().simulated(start={"x": 0.5}, forces="F=1")
    assert (short.t[-1], moved["x"][0], moved["theta"][0], moved["F"][-1]) == (0.1, 0.5, 0.0, 1.0)


@pytest.mark.runs("cc")
@pytest.mark.parametrize("period", [None, 0.05])
@pytest.mark.parametrize(("limits", "told"), [((-1, 5), "reaches its limits and goes no further, -1 to 5 N"),
                                              ((-9, 2), "reaches its limits and goes no further, -9 to 2 N"),
                                              ((-9, 5), "never reaches its limits, -9 to 5 N")])  # fmt: skip
def test_a_force_that_is_just_at_its_limit_has_reached_it(limits: Any, told: str, period: float | None) -> None:
    law = symdyn.Feedback(lambda t, q, u: -1.0 if t < 0.1 else 2.0, limits={"F": limits}, period=period)
    found = symdyn.simulate(CART, until=0.2, feedback=law, method="dop853")
    assert [one for one in found.notes if one.startswith("F ")] == [f"F {told}"]
    assert found.saturations == ()


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("accelerations", "forward_dynamics"), ("qdd", "forward_dynamics"), ("coriolis", "coriolis_matrix"),
        ("gravity", "gravity_forces"), ("inverse", "inverse_dynamics"), ("energy", "kinetic_energy"),
        ("position", "pose:NAME"), ("torque", "inverse_dynamics"), ("mass", "mass_matrix"), ("J", "jacobian:NAME"),
    ],
)  # fmt: skip
def test_functions_are_found_by_other_words(word: str, told: str) -> None:
    with pytest.raises(DerivationError, match=rf"there is no output '{word}'; did you mean {told}\?"):
        symdyn.lambdify(symdyn.example("cart_pole"), word)


def test_what_is_given_to_another_argument_is_told() -> None:
    with pytest.raises(DrawError, match=r"or file='x\.svg'"):
        symdyn.picture(symdyn.example("cart_pole"), [0, 0], "x.svg")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match=r"'values'; symdyn\.scene\.bind\(scene"):
        symdyn.read("x.toml", values={})  # type: ignore[call-arg]


@pytest.mark.runs("cc")
def test_collocation_takes_values_as_runs_do() -> None:
    scene, values = symdyn.example("two_link"), {"m1": 1, "m2": 2, "h1": 1, "h2": 0.5, "g": 9.81}
    with pytest.raises(SimulateError, match=r"have no value; give them, as in values="):
        symdyn.collocation(scene, 1, 4, end={"q1": 1})
    one = symdyn.collocation(scene, 1, 4, end={"q1": 1}, values=values)
    other = symdyn.collocation(symdyn.Problem(scene, values=values), 1, 4, end={"q1": 1})
    assert one.scene == other.scene
    assert np.array_equal(one.residual(one.guess), other.residual(other.guess))


@pytest.mark.runs("cc")
def test_a_second_run_in_the_same_axes_is_called_so() -> None:
    axes = pytest.importorskip("matplotlib.pyplot").subplots()[1]
    run = symdyn.simulate(symdyn.example("pendulum"), until=0.1)
    for _ in range(3):
        run.plot("q1", axes=axes)
    assert axes.get_legend_handles_labels()[1] == ["$q_1$", "$q_1$ (run 2)", "$q_1$ (run 3)"]


def test_a_parameter_that_no_formula_has_is_noted(tmp_path: Path) -> None:
    path = tmp_path / "p.toml"
    text = symdyn.scene.write_text(symdyn.example("pendulum"), "toml").text
    path.write_text(text)
    assert not [note for note in symdyn.scene.read_noting(path).notes if "no formula" in note]
    path.write_text(text.replace('"-g"', "-9.81"))
    assert "parameters.g: no formula of the scene has it" in symdyn.scene.read_noting(path).notes[0]


@pytest.mark.parametrize(
    ("there", "written"),
    [
        ('gravity = [0, "-g", 0]', 'gravity = "none"'),
        ('"-g"', '"-9.81 + 0*g"'),
        ("\n[points.tip]", '[joints.j2]\ntype = "prismatic"\nparent = "bob"\nchild = "c"\nlocked = true\n'
         'position = "R"\n[bodies.c]\n[parameters.R]\nvalue = 1\n[points.tip]'),
    ],
    ids=["gravity is none", "a factor folds away", "a locked joint"],
)  # fmt: skip
def test_a_parameter_that_the_text_of_a_scene_names_is_used(tmp_path: Path, there: str, written: str) -> None:
    text = symdyn.scene.write_text(symdyn.example("pendulum"), "toml").text
    assert there in text
    (tmp_path / "p.toml").write_text(text.replace(there, written))
    assert not [one for one in symdyn.scene.read_noting(tmp_path / "p.toml").notes if "no formula" in one]


@pytest.mark.parametrize("verb", ["info", "convert"])
def test_a_parameter_for_a_request_is_noted_by_info_alone(tmp_path: Path, capsys: Any, verb: str) -> None:
    text = symdyn.scene.write_text(symdyn.example("pendulum"), "toml").text
    (tmp_path / "p.toml").write_text(text.replace("[parameters]", "[parameters]\nAmp = 2"))
    assert main([verb, str(tmp_path / "p.toml"), *([str(tmp_path / "q.toml")] if verb == "convert" else [])]) == 0
    assert ("parameters.Amp: no formula of the scene has it" in capsys.readouterr().err) == (verb == "info")
