"""A `Problem` says once what several calls are asked, and every public function reads its fields in the same way."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.arguments import _NOUNS
from symdyn.errors import SceneError, SimulateError
from symdyn.identification import output_error
from symdyn.simulation import Problem, Run

CART = symdyn.example("cart_pole")
FIELDS: dict[str, Any] = {"forces": "F=-2*x_dot", "start": {"theta": 0.3}, "start_rates": "x=1", "values": {"l": 0.6}}
PROBLEM = Problem(CART, **FIELDS)

CALLS: dict[str, Callable[..., Any]] = {
    "simulate": lambda scene, **more: symdyn.simulate(scene, until=0.1, **more)["theta"],
    "sensitivity": lambda scene, **more: symdyn.sensitivity(scene, until=0.1, of="x", **more).matrix,
    "linearize": lambda scene, **more: symdyn.linearize(scene, anywhere=True, **more).A,
    "sweep": lambda scene, **more: symdyn.sweep(scene, "mp=[0.1,0.2]", "end(x)", until=0.1, **more)["end(x)"],
    "uncertainty": lambda scene, **more: symdyn.uncertainty(scene, {"mp": 0.01}, until=0.1, **more)["x"],
}
"""What takes all fields, and some number of what it returns."""


@pytest.mark.runs("cc")
@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_a_problem_is_asked_as_its_fields_are(call: Callable[..., Any]) -> None:
    np.testing.assert_array_equal(call(PROBLEM), call(CART, **FIELDS))
    for name, one in FIELDS.items():
        with pytest.raises(SimulateError, match=f"^{name}: the Problem says its own; leave it out, or give a scene$"):
            call(PROBLEM, **{name: one})


@pytest.mark.runs("cc")
def test_what_is_read_is_kept_and_a_whole_state_stays() -> None:
    assert PROBLEM.driving is PROBLEM.driving
    assert PROBLEM.initial.u.tolist() == [1.0, 0.0]
    whole = Problem(PROBLEM.scene, PROBLEM.driving, PROBLEM.initial)
    np.testing.assert_array_equal(CALLS["simulate"](whole), CALLS["simulate"](PROBLEM))
    with pytest.raises(SimulateError, match=r"^start_rates: the start is a whole state, which has velocities; leave "):
        Problem(CART, start=PROBLEM.initial, start_rates={"x": 1})
    with pytest.raises(SimulateError, match=r"(?m)^start: a Start names nothing; give values by name, such as "):
        symdyn.sweep(whole, "theta=[0.1,0.2]", "end(x)", until=0.1)


@pytest.mark.runs("cc")
def test_runs_of_an_ensemble_differ_from_their_problem_in_what_is_given_beside_it() -> None:
    runs = symdyn.ensemble(PROBLEM, until=0.1, start={"x": [0.0, 0.5]}, values={"mp": [0.1, 0.2]})
    for k in range(2):
        one = symdyn.Problem(
            CART, **{**FIELDS, "start": {"theta": 0.3, "x": 0.5 * k}, "values": {"l": 0.6, "mp": 0.1 + k / 10}}
        )
        assert runs.q[k] == pytest.approx(symdyn.simulate(one, until=0.1, rtol=1e-12).q[-1], abs=1e-8)
    with pytest.raises(SimulateError, match=r"^forces: the Problem says its own"):
        symdyn.ensemble(PROBLEM, forces="F=1")


MASS: dict[str, Any] = {"over": "mc=[1,2]", "measure": "M1_1", "function": "mass_matrix"}

REFUSED: dict[str, Callable[[], object]] = {
    "start_rates: it belongs to a run": lambda: symdyn.inverse(PROBLEM, "x=t,theta=0", [0, 1]),
    "forces: drives are unknowns": lambda: symdyn.collocation(PROBLEM, until=1),
    "until: it belongs to a run": lambda: symdyn.uncertainty(CART, {"mp": 1}, motion="x=t", times=[0, 1], until=2),
    "start rates: of runs, and a function": lambda: symdyn.sweep(PROBLEM, **MASS),
    "until: of runs, and a function": lambda: symdyn.sweep(CART, **MASS, until=10),
    "forces: parsed forces have no text": lambda: symdyn.sweep(Problem(CART, PROBLEM.driving), "mc=[1,2]", "end(x)"),
    "start: rest is looked for": lambda: symdyn.linear.linearize_at_rest(PROBLEM),
}


@pytest.mark.parametrize("words", REFUSED)
def test_a_field_without_use_is_refused(words: str) -> None:
    with pytest.raises(SimulateError, match=f"(?m)^{words}"):
        REFUSED[words]()


def test_a_problem_says_what_is_wrong_with_it() -> None:
    with pytest.raises(SimulateError, match=r"^scene = 'arm\.toml': give a Scene\nstart = 3: give values by name"):
        Problem("arm.toml", start=3)  # type: ignore[arg-type]
    with pytest.raises(SimulateError, match=r"^values: mc has 2 numbers, and a run takes one; symdyn\.ensemble"):
        Problem(CART, values={"mc": [1, 2]})
    with pytest.raises(SceneError, match="M"):
        Problem(CART, values={"M": 1})
    with pytest.raises(
        TypeError, match=r"^simulate\(\) got an unexpected keyword argument 'untill'; did you mean until"
    ):
        symdyn.simulate(CART, untill=3)  # type: ignore[call-arg]


@pytest.mark.parametrize("noun", [Problem, Run])
def test_fields_for_checkers_are_those_of_the_nouns(noun: Any) -> None:
    said = {
        name: one.annotation.removeprefix("InitVar[").removesuffix("]" * ("InitVar" in one.annotation))
        for name, one in inspect.signature(noun).parameters.items()
        if name != "scene"
    }

    assert {name: one.__forward_arg__ for name, one in noun.Fields.__annotations__.items()} == said


@pytest.mark.parametrize("function", [symdyn.simulate, symdyn.linearize, symdyn.ensemble, symdyn.sweep, output_error])
def test_signature_and_docstring_show_every_field(function: Callable[..., object]) -> None:
    shown = inspect.signature(function).parameters

    for noun in _NOUNS[function]:
        assert {*inspect.signature(noun).parameters} - {*shown} == set()
    assert [name for name in shown if f"\n    {name}: " not in str(function.__doc__)] == []
    assert "fields" not in str(function.__doc__)
