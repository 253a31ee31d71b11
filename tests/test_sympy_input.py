"""Expressions of SymPy in the place of formulas: the same as their text, wherever Python takes one."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy
from sympy import (
    Abs,
    Derivative,
    E,
    Float,
    Function,
    Max,
    Piecewise,
    Rational,
    Symbol,
    atan2,
    cos,
    exp,
    log,
    pi,
    sign,
    sin,
    sqrt,
    tan,
    tanh,
)
from sympy.physics.mechanics import dynamicsymbols

import symdyn
from symdyn.errors import SceneError, SimulateError
from symdyn.scene import Quantity, body, parse, prismatic, scene, spring
from symdyn.scene.values.formula import FormulaError, formula_text, quantity

k, m, x, y, t = (Symbol(name) for name in "kmxyt")
q1, q2 = dynamicsymbols("q1 q2")

READ: dict[str, tuple[Any, str]] = {
    "half": (m / 2, "m/2"),
    "negative": (-k * x / 2 + 3, "3 - k*x/2"),
    "difference": (k - x, "k - x"),
    "quotient": (k / (m * x), "k/(m*x)"),
    "power": (x**-2, "1/x**2"),
    "root": (sqrt(k / m), "sqrt(k/m)"),
    "one over a root": (1 / sqrt(x), "1/sqrt(x)"),
    "half powers": (k * x ** Rational(3, 2), "k*x**(3/2)"),
    "negative half powers": (k / x ** Rational(5, 2), "k/x**(5/2)"),
    "angle": (pi / 6, "pi/6"),
    "third": (x / 3, "x/3"),
    "functions": (sin(x) * cos(x) * tanh(x), "sin(x)*cos(x)*tanh(x)"),
    "more functions": (exp(x) + log(x) + tan(x), "exp(x) + log(x) + tan(x)"),
    "two arguments": (atan2(y, x), "atan2(y, x)"),
    "powers": (x**y, "x**y"),
    "extremes": (Max(x, 0) + sympy.Min(x, y), "max(x, 0) + min(x, y)"),
    "choices": (Piecewise((x, x > 0), (y, x > -1), (0, True)), "if(x > 0, x, if(x > -1, y, 0))"),
    "hyperbolic": (sympy.sinh(x) + sympy.acos(x), "sinh(x) + acos(x)"),
    "sizes": (Abs(x) * sign(x), "abs(x)*sign(x)"),
    "e": (E * x, "exp(1)*x"),
    "a coordinate": (q1 * k, "q1*k"),
    "a velocity": (-k * q1.diff(), "-k*q1_dot"),
    "an acceleration": (Derivative(q2, t, t), "q2_ddot"),
    "a function of time": (Function("F")(t), "F"),
}


def value(found: Quantity) -> float:
    known = {name: 0.3 + 0.17 * n for n, name in enumerate(sorted(found.symbols))}
    return float(found.at(known) or 0)


@pytest.mark.parametrize("name", READ)
def test_an_expression_is_read_as_its_text_is(name: str) -> None:
    expression, text = READ[name]
    found, same = quantity(expression), parse(text)
    assert sorted(found.symbols) == sorted(same.symbols)
    assert value(found) == pytest.approx(value(same), rel=1e-15)
    assert parse(formula_text(expression)) == found


def test_numbers_stay_exact() -> None:
    assert quantity(Rational(1, 3)).value == Fraction(1, 3)
    assert quantity(sympy.Integer(7)).value == 7
    assert quantity(Float(0.1)).value == Fraction(1, 10)
    assert quantity(Float(1 / 3)) == quantity(1 / 3)
    assert quantity(Float("0.12345678901234567890123456789", 30)).value == Fraction("0.12345678901234567890123456789")


@pytest.mark.parametrize(
    ("expression", "words"),
    [
        (Piecewise((x, x > 0)), "needs a last value"),
        (Function("f")(x, y), "the function f is not known"),
        (Derivative(sin(x) * Function("f")(x), x), "is no rate of a coordinate"),
        (Symbol("a b"), "is no name; give letters"),
        (sympy.Matrix([x]), "usable formula"),
        (x < 1, "a comparison is not a number"),
        (sympy.I * x, "uses I"),
        (sympy.oo, "uses oo"),
    ],
    ids=str,
)
def test_what_formulas_do_not_know_is_refused_in_words(expression: Any, words: str) -> None:
    if words.startswith("uses"):
        assert words.split()[1] in quantity(expression).symbols  # a letter that no scene declares
        return
    with pytest.raises(FormulaError, match=words):
        quantity(expression)


def mechanism(stiff: Any, mass: Any, force: Any) -> symdyn.Scene:
    return scene(
        "mass",
        parameters={"m": 2, "k": 50, "c": 0.3},
        bodies=[body("block", mass=mass)],
        joints=[prismatic("rail", "ground", "block", axis=[1, 0, 0], coordinate="x", drive="F", force=force)],
        springs=[spring("s", joint="rail", stiffness=stiff, free=0)],
        gravity=None,
    )


def test_a_scene_of_expressions_is_the_scene_of_texts() -> None:
    position = dynamicsymbols("x")
    assert mechanism(2 * k, m / 2, -Symbol("c") * position.diff()) == mechanism("2*k", "m/2", "-c*x_dot")


def test_an_expression_that_no_formula_is_has_the_place_of_its_fault() -> None:
    with pytest.raises(SceneError, match=r"bodies.block: mass = .*the function gamma is not known"):
        mechanism(2 * k, sympy.gamma(m), 0)


@pytest.mark.runs("cc")
def test_runs_take_expressions_for_forces_starts_values_and_stops() -> None:
    pendulum = symdyn.example("pendulum")
    texts = symdyn.simulate(
        pendulum, until=1, every=0.1, forces={"tau1": "-2*q1 - q1_dot"}, start={"q1": "pi/6"}, values={"m": "3/2"},
        stops=["q1 - 1/10"],
    )  # fmt: skip
    found = symdyn.simulate(
        pendulum, until=1, every=0.1, forces={"tau1": -2 * q1 - q1.diff()}, start={"q1": pi / 6},
        values={"m": Rational(3, 2)}, stops=[Symbol("q1") - Rational(1, 10)],
    )  # fmt: skip
    assert np.array_equal(found.q, texts.q)
    assert [one.t for one in found.events] == [one.t for one in texts.events]
    with pytest.raises(SimulateError, match=r"forces: tau1: .*the function gamma is not known"):
        symdyn.simulate(pendulum, until=1, forces={"tau1": sympy.gamma(Symbol("q1"))})


@pytest.mark.runs("cc")
def test_motions_outputs_and_measures_are_expressions_too() -> None:
    arm = symdyn.example("pendulum")
    system = symdyn.linearize(arm, outputs=[sin(Symbol("q1")), Symbol("q1_dot") / 2])
    assert system.outputs.names == ("sin(q1)", "q1_dot/2")
    assert pytest.approx(np.array([[1, 0], [0, 0.5]])) == system.C
    told = symdyn.inverse(arm, {"q1": sin(2 * t) / 3}, times=[0, 0.1])
    assert told.q[1, 0] == pytest.approx(np.sin(0.2) / 3)
    runs = symdyn.sweep(arm, ["m=[1, 2]"], measure=[Function("end")(Symbol("q1") ** 2)], until=0.1)
    assert list(runs.measures) == ["end(q1**2)"]
    several = symdyn.ensemble(arm, until=0.1, start={"q1": [0.1, 0.2]}, measures=[Function("end")(Symbol("q1") ** 2)])
    assert list(several.measures) == ["end(q1**2)"]


@pytest.mark.runs("cc")
def test_collocation_takes_expressions() -> None:
    cart = symdyn.example("cart_pole")
    one, other = (
        symdyn.collocation(cart, until=2, intervals=10, cost=cost, end={"x": end})
        for cost, end in (("F**2", "1/2"), (Symbol("F") ** 2, Rational(1, 2)))
    )
    assert np.array_equal(one.guess, other.guess)


@pytest.mark.runs
def test_nobody_imports_sympy_to_see_whether_something_is_of_it() -> None:
    code = "import sys; from symdyn.scene import body; body('b', mass='2.5'); assert 'sympy' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
