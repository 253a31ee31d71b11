"""What one call costs."""

from __future__ import annotations

from formulas import every_op, one

from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.outputs import Counts
from symdyn.graph import Graph, Op
from symdyn.program import lower


def test_a_shared_product_counts_once_and_a_sign_never():
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    (f,) = one([x * y + x, -(x * y), x * y - y], [x, y]).functions
    assert Counts.of(f) == Counts(multiplications=1, additions=2)


def test_sine_and_cosine_of_one_angle_are_one_pair():
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    (f,) = one([g.sin(x), g.cos(x), g.cos(y), g.sin(x + y)], [x, y]).functions
    assert Counts.of(f) == Counts(additions=1, sincos=3)


def test_a_price_without_a_function_is_that_of_its_counts():
    function = every_op().functions[0]
    state = [symbol for argument in function.arguments for symbol in argument.symbols]

    assert cost(function.entries, state) == Counts.of(function).cost


def test_what_has_no_symbol_costs_nothing():
    g = Graph()
    x = g.symbol("x")
    (f,) = one([g.sqrt(2) * g.sin(g.pi / 7) / g.pi + 1, x / g.sqrt(3)], [x]).functions
    assert Counts.of(f) == Counts(divisions=1)


def test_other_functions_are_counted_apart():
    g = Graph()
    x = g.symbol("x")
    (f,) = one([g.function(Op.TANH, x), g.sqrt(x), g.function(Op.ATAN2, x, g.one)], [x]).functions
    assert Counts.of(f) == Counts(others=3)


def test_binding_a_parameter_never_costs_more():
    equations = every_op()
    program = lower(equations)
    for function in equations.functions:
        before, after = Counts.of(function), program[function.name].counts
        assert (after.multiplications, after.divisions) <= (before.multiplications, before.divisions)


def test_counts_read_as_words():
    assert str(Counts(5, 4)) == "5 mul, 4 add"
    assert str(Counts(5, 4, 1, 2, 3)) == "5 mul, 4 add, 1 div, 2 sincos, 3 other"
