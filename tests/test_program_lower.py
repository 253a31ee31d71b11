"""Lowering keeps values, binds parameters, folds constants and leaves the equations alone."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from formulas import QUARTER, every_op, one, states
from graphs import Fractions
from mechanisms import random_tree

from symdyn.algebra import constants
from symdyn.algebra.numeric import Batches
from symdyn.dynamics.outputs.derive import derive
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.errors import DerivationError
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.program import Program, lower
from symdyn.scene import Quantity, Scene, read_text
from symdyn.scene.values import Parameter


def values_of(source: Equations | Program, name: str, args: list[np.ndarray], **bound: float) -> list[np.ndarray]:
    function = source[name] if isinstance(source, Equations) else source[name].function
    named = {
        str(symbol.value): array[:, i]
        for a, array in zip(function.arguments, args, strict=True)
        for i, symbol in enumerate(a.symbols)
    } | bound
    symbols = {node: named[str(node.value)] for node in reachable(function.entries) if node.op is Op.SYMBOL}
    return evaluate(function.entries, Batches(), symbols)


@pytest.mark.parametrize("name", ["matrix", "scalar", "rotated"])
def test_lowering_keeps_the_value_of_every_operation(name):
    equations = every_op()
    args = states(equations, name)
    lowered = values_of(lower(equations), name, args)
    for got, wanted in zip(lowered, values_of(equations, name, args, b=0.25), strict=True):
        np.testing.assert_allclose(got, wanted, rtol=1e-13, atol=1e-14)


def test_lowering_keeps_the_equations_of_a_tree_with_bound_parameters():
    equations = derive(random_tree(3, 4, free=False), ("inverse_dynamics", "forward_dynamics"))
    program = lower(equations)
    for name in ("inverse_dynamics", "forward_dynamics"):
        args = states(equations, name)
        wanted = values_of(equations, name, args, m0=1.4, beta=0.8)
        np.testing.assert_allclose(values_of(program, name, args), wanted, rtol=1e-9)


def test_lowering_is_exact_where_the_equations_are_rational():
    g = Graph()
    x, b = g.symbol("x"), g.symbol("b")
    equations = one([(x + b) * (x - b) / (1 + b * x)], [x], Scene("hand", (QUARTER,)))
    program = lower(equations)
    (entry,) = program.outputs
    third = Fraction(1, 3)
    (got,) = evaluate([entry], Fractions(), {program["f"].inputs[0].node: third})
    assert got == (third + Fraction(1, 4)) * (third - Fraction(1, 4)) / (1 + third / 4)


def test_lowering_leaves_the_equations_and_their_graph_as_they_were():
    equations = every_op()
    before = [(node.op, node.args, node.value) for node in equations.graph.nodes]
    program = lower(equations)
    assert [(node.op, node.args, node.value) for node in equations.graph.nodes] == before
    assert all(entry.graph is program.graph is not equations.graph for entry in program.outputs)


def test_a_parameter_with_a_value_is_bound_and_one_without_stays():
    program = lower(every_op())
    names = {str(node.value) for node in reachable(program.outputs) if node.op is Op.SYMBOL}
    assert "mass" in names
    assert "b" not in names


def test_a_constant_keeps_more_than_fifty_digits():
    g = Graph()
    x = g.symbol("x")
    program = lower(one([x * g.cos(g.pi * Fraction(37, 180))], [x]))
    (value,) = [v for node, v in program.constants.items() if node.op is Op.COS]
    with mpmath.workdps(60):
        wanted = mpmath.cos(37 * mpmath.pi / 180)
        assert abs(mpmath.mpf(value.numerator) / value.denominator - wanted) < mpmath.mpf(10) ** -58


def test_a_constant_that_cancels_to_zero_takes_its_products_along():
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    s, c = g.sin(g.pi * Fraction(2, 9)), g.cos(g.pi * Fraction(2, 9))
    program = lower(one([x * (s * s + c * c - 1) + y], [x, y]))
    assert repr(program.outputs) == "(y,)"
    assert program["f"].counts.multiplications == 0


def test_a_tiny_constant_is_not_taken_for_zero():
    g = Graph()
    x = g.symbol("x")
    tiny = g.sqrt(2) * Fraction(1, 10**120)
    program = lower(one([x * tiny], [x]))
    (value,) = [v for node, v in program.constants.items() if node.op is Op.MUL]
    assert abs(float(value * 10**120) - 2**0.5) < 1e-15


@pytest.mark.parametrize("turn", [Fraction(2, 9), Fraction(1, 7), Fraction(3, 11), Fraction(5, 13)])
def test_functions_of_a_hidden_zero_are_those_of_zero(turn):
    """In fixed precision s² + c² - 1 is sometimes above zero and sometimes below: no sign of it counts."""
    g = Graph()
    s, c = g.sin(g.pi * turn), g.cos(g.pi * turn)
    zero = s * s + c * c - 1
    half_turn = g.function(Op.ATAN2, zero, g.constant(-1))
    found = constants([half_turn, g.function(Op.SIGN, zero), g.sqrt(zero), g.function(Op.ABS, zero)])

    assert float(found[half_turn]) == np.pi
    assert {node.op for node, value in found.items() if value == 0} >= {Op.SIGN, Op.SQRT, Op.ABS}


@pytest.mark.parametrize("value", [Fraction(22, 7), Fraction(-1, 10**6), Fraction(999_999, 1_000_000), Fraction(10**9)])
def test_a_simple_fraction_in_disguise_is_found(value):
    g = Graph()
    s, c = g.sin(g.pi * Fraction(2, 9)), g.cos(g.pi * Fraction(2, 9))
    disguised, near = (s * s + c * c) * value, (s * s + c * c) * value + g.constant(Fraction(1, 10**70)) * s

    found = constants([disguised, near])
    assert found[disguised] == value
    assert found[near].denominator > 10**60


@pytest.mark.parametrize("bad", ["root", "logarithm", "hidden pole"])
def test_a_constant_that_is_no_real_number_is_refused(bad):
    g = Graph()
    x, fifth = g.symbol("x"), g.pi * Fraction(1, 5)
    pole = 1 / (g.sin(fifth) ** 2 + g.cos(fifth) ** 2 - 1)
    value = {"root": g.sqrt(-2), "logarithm": g.function(Op.LOG, 0), "hidden pole": pole}[bad]
    with pytest.raises(DerivationError, match=r"zero|not a finite real number"):
        lower(one([x * value], [x]))


def test_a_bound_zero_below_a_fraction_is_refused():
    g = Graph()
    x, m = g.symbol("x"), g.symbol("m")
    scene = Scene("hand", (Parameter("m", Quantity.number(0)),))
    with pytest.raises(DerivationError, match="hand: with its parameters' values f would divide by zero"):
        lower(one([x / m], [x], scene))


def test_a_symbol_that_is_no_argument_is_our_own_mistake():
    g = Graph()
    x, stray = g.symbol("x"), g.symbol("stray")
    with pytest.raises(AssertionError, match=r"f needs.*stray.*none of its arguments"):
        lower(one([x * stray], [x]))


@pytest.mark.long(0)
def test_every_lowered_tree_passes_the_check():
    program = lower(derive(random_tree(2, 4)))
    assert program.checked() is program


def test_a_constant_that_cancels_to_few_digits_is_not_taken_for_zero():
    text = """
    [parameters]
    c = "sqrt(1e28 + 1) - 1e14"
    [bodies.a]
    mass = 1
    com = [0, 0, "-1e14*c"]
    [joints.j]
    type = "revolute"
    parent = "ground"
    child = "a"
    axis = [1, 0, 0]
    """
    (entry,) = lower(derive(read_text(text, "cancel.toml"), ("mass_matrix",))).outputs

    assert abs(float(constants([entry])[entry]) - 0.25) < 1e-15
