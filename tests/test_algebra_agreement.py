"""One graph, many algebras: floats, batches, fractions, big floats and a finite field say the same."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest
from graphs import Fractions
from running import random_fractions

from symdyn.algebra.big import BigFloats
from symdyn.algebra.finite_field import FiniteField, Needs, Redraw
from symdyn.algebra.numeric import Batches, Floats
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.graph.ops import FUNCTIONS
from symdyn.verify.points import bound


def rational_outputs(graph, x, y, z):
    return [
        x + y * z,
        x / (y * y + 1) - 3,
        (x - y) ** 3 / (1 + z**2),
        -x * Fraction(2, 7) + z,
        1 / (1 + 1 / (2 + x * x)),
    ]


@pytest.fixture
def graph():
    return Graph()


@pytest.fixture
def symbols(graph):
    return [graph.symbol(name) for name in "xyz"]


@pytest.mark.parametrize("seed", range(5))
def test_rational_functions_agree_exactly_in_fractions_and_fields_and_closely_in_floats(graph, symbols, seed):
    outputs = rational_outputs(graph, *symbols)
    point = dict(zip(symbols, random_fractions(random.Random(seed), 3), strict=True))
    field = FiniteField(Needs.of(reachable(outputs)).prime(seed), seed, Needs.of(reachable(outputs)))

    exact = evaluate(outputs, Fractions(), point)
    residues = field.evaluate(outputs, {node: field.constant(x) for node, x in point.items()})
    big = BigFloats(50)
    fine = evaluate(outputs, big, {node: big.constant(x) for node, x in point.items()})
    rough = evaluate(outputs, Floats(), {node: float(x) for node, x in point.items()})
    batch = evaluate(outputs, Batches(), {node: np.full(4, float(x)) for node, x in point.items()})

    assert residues == [field.constant(x) for x in exact]
    assert all(abs(a - big.constant(x)) < 1e-47 * (1 + abs(x)) for a, x in zip(fine, exact, strict=True))
    assert rough == pytest.approx([float(x) for x in exact], rel=1e-13, abs=1e-13)
    assert np.array_equal(np.array(batch), np.repeat(np.array(rough)[:, None], 4, axis=1))


@pytest.mark.parametrize("op", sorted(FUNCTIONS), ids=lambda op: op.name)
def test_functions_agree_in_floats_batches_and_big_floats(graph, symbols, op):
    args = symbols[: op.arity]
    node = graph.function(op, *args)
    big = BigFloats(50)
    positive = op in (Op.SQRT, Op.LOG, Op.POW)
    for place in ([0.3, 1.7, 4.1], [2.5, -0.4, 0.2], *([] if positive else [[-1.25, 0.5, 2.0], [-0.75, -2.0, 1.0]])):
        point = dict(zip(symbols, place, strict=False))
        (fine,) = evaluate([node], big, {symbol: big.number(x) for symbol, x in point.items()})
        (rough,) = evaluate([node], Floats(), point)
        (batch,) = evaluate([node], Batches(), {symbol: np.array([x]) for symbol, x in point.items()})

        assert rough == pytest.approx(float(fine), rel=4e-16)
        assert float(batch[0]) == pytest.approx(float(fine), rel=4e-16)


def test_a_missing_value_is_named_in_every_loop(graph, symbols):
    x, y, _ = symbols
    field = FiniteField(Needs.of(reachable([x + y])).prime(1), 1, Needs.of(reachable([x + y])))
    with pytest.raises(KeyError, match="symbol y has no value"):
        evaluate([x + y], Floats(), {x: 1.0})
    with pytest.raises(KeyError, match="symbol y has no value"):
        field.evaluate([x + y], {x: 1})


def test_values_can_be_given_for_inner_nodes(graph, symbols):
    x = symbols[0]

    assert evaluate([graph.sin(x) + x], Floats(), {x: 1.0, graph.sin(x): 0.25}) == [1.25]


def test_fractions_refuse_what_is_not_rational(graph, symbols):
    with pytest.raises(ArithmeticError, match="pi is not rational"):
        evaluate([graph.pi * symbols[0]], Fractions(), {symbols[0]: Fraction(1)})
    with pytest.raises(ArithmeticError, match="sin is not rational"):
        evaluate([graph.sin(symbols[0])], Fractions(), {symbols[0]: Fraction(1)})
    absolute = graph.function(Op.ABS, symbols[0]) + graph.function(Op.SIGN, symbols[0])
    assert evaluate([absolute], Fractions(), {symbols[0]: Fraction(-3, 2)}) == [Fraction(1, 2)]


def test_big_floats_keep_their_precision_to_themselves(graph, symbols):
    import mpmath

    before = mpmath.mp.dps
    small, large = BigFloats(20), BigFloats(80)

    (third,) = evaluate([graph.constant(Fraction(1, 3))], large, {})

    assert mpmath.mp.dps == before
    assert abs(third * 3 - 1) < large.number("1e-79")
    assert small.context.dps == 20
    assert large.pi() != small.pi()


# The finite field


def a_field(outputs, seed=1):
    wanted = Needs.of(reachable(outputs))
    return FiniteField(wanted.prime(seed), seed, wanted)


def test_sines_in_a_field_obey_addition_theorems(graph, symbols):
    x, y, _ = symbols
    sum_, half = x + y, x / 2
    outputs = [graph.sin(sum_), graph.cos(sum_), graph.sin(x), graph.cos(x), graph.sin(y), graph.cos(y)]
    outputs += [graph.sin(half), graph.cos(half)]
    field = a_field(outputs)
    s, c, sx, cx, sy, cy, sh, ch = field.evaluate(outputs, {x: 1234567, y: 89})
    p = field.p

    assert (sx * sx + cx * cx) % p == 1
    assert (sx * cy + cx * sy) % p == s
    assert (cx * cy - sx * sy) % p == c
    assert 2 * sh * ch % p == sx


def test_radicals_in_a_field_square_to_their_radicands(graph):
    radicands = [2, 3, 5, 7, 11, 14, 30, 1009 * 1013, Fraction(2, 3)]
    outputs = [graph.sqrt(n) for n in radicands]
    field = a_field(outputs)

    found = field.evaluate(outputs, {})

    assert [root * root % field.p for root in found] == [field.constant(Fraction(n)) for n in radicands]


def test_unlucky_points_ask_for_another_one(graph, symbols):
    x = symbols[0]
    outputs = [1 / (x - 5), graph.sqrt(x)]
    field = a_field(outputs)
    other = next(n for n in range(2, 1000) if pow(n, (field.p - 1) // 2, field.p) != 1)

    for output, place in zip(outputs, (5, other), strict=True):
        with pytest.raises(Redraw):
            field.evaluate([output], {x: place})


def test_functions_without_an_algebra_depend_on_function_argument_and_seed(graph, symbols):
    x = symbols[0]
    outputs = [graph.function(op, x) for op in (Op.EXP, Op.TANH)]
    field, other = a_field(outputs, 1), FiniteField(a_field(outputs, 1).p, 2, Needs.of(reachable(outputs)))

    values = [*field.evaluate(outputs, {x: 3}), *field.evaluate(outputs, {x: 4})]
    values += other.evaluate(outputs, {x: 3})

    assert len(set(values)) == 6
    assert field.evaluate(outputs, {x: 3}) == values[:2]


def test_sines_need_the_loop_that_knows_their_angles(graph, symbols):
    field = a_field([graph.sin(symbols[0])])
    with pytest.raises(TypeError, match="use evaluate"):
        evaluate([graph.sin(symbols[0])], field, {symbols[0]: 1})


# Degrees


@pytest.mark.parametrize(
    ("difference", "zeros"),
    [
        (lambda g, x, y, z: x**3 - y, 3),
        (lambda g, x, y, z: x**3 * y**2 - z, 5),
        (lambda g, x, y, z: g.sin(3 * x) * g.cos(y), 8),  # a Laurent polynomial of degrees -4 .. 4
        (lambda g, x, y, z: g.sin(x / 2), 2),
        (lambda g, x, y, z: g.sin(Fraction(3, 10)), 6),
        (lambda g, x, y, z: x / (y - z) + y / (x - z), 3),
        (lambda g, x, y, z: (x - y) / (x * x + 1) / (y * y + 1) * (y * y + 1), 3),
        (lambda g, x, y, z: g.pi - g.function(Op.EXP, x), 1),
    ],
)
def test_degree_bound_is_not_below_the_number_of_zeros(graph, symbols, difference, zeros):
    node = difference(graph, *symbols)

    degree = bound([node], [graph.zero], Needs.of(reachable([node]))).degree

    assert zeros <= degree <= 8 * zeros


def test_degree_bound_of_constants_is_zero_and_of_several_is_the_largest(graph, symbols):
    x, y, _ = symbols
    root = graph.sqrt(2)

    assert bound([root], [graph.one], Needs.of(reachable([root]))).degree == 0
    together = bound([x, x * y * x], [y, y], Needs.of(reachable([x])))
    assert together == bound([x * y * x], [y], Needs.of(reachable([x])))
