"""Differentiation and substitution: every partial against numbers, forward and reverse against each other."""

from __future__ import annotations

from fractions import Fraction

import pytest
from formulas import CURVE
from graphs import LEAVES
from hypothesis import given, settings, strategies as st

from symdyn.algebra.big import BigFloats
from symdyn.dynamics.outputs.tree_formulations import turns
from symdyn.graph import (
    Graph,
    Op,
    evaluate,
    gradient,
    operands,
    reachable,
    substitute,
    tangents,
)
from symdyn.graph.differentiate import PARTIALS
from symdyn.graph.ops import ARITY, FUNCTIONS

BIG = BigFloats(60)
STEP = BIG.number("1e-20")
PLACES = {"x": BIG.number("0.7"), "y": BIG.number("-1.3"), "z": BIG.number("0.4")}


def build(graph, op, args):
    arithmetic = {Op.ADD: graph.add, Op.SUB: graph.sub, Op.MUL: graph.mul, Op.DIV: graph.div, Op.NEG: graph.neg}
    if op is Op.TABLE:
        return graph.lookup(CURVE, *args)
    return arithmetic[op](*args) if op in arithmetic else graph.function(op, *args)


def value(node, places):
    graph = node.graph
    return evaluate([node], BIG, {graph.symbol(name): place for name, place in places.items()})[0]


def slope(node, name, places=PLACES):
    """Return ∂node/∂name as a central difference."""
    ahead, behind = ({**places, name: places[name] + sign * STEP} for sign in (1, -1))
    return (value(node, ahead) - value(node, behind)) / (2 * STEP)


@pytest.mark.parametrize("op", sorted(set(Op) - LEAVES), ids=lambda op: op.name)
def test_partial_derivatives_are_what_differences_tell(op):
    graph = Graph()
    symbols = [graph.symbol(name) for name in ("x", "y", "z")[: ARITY[op]]]
    node = build(graph, op, symbols)
    assert node.op is op

    partials = PARTIALS[op](node, *symbols)

    assert len(partials) == ARITY[op]
    for partial, symbol in zip(partials, symbols, strict=True):
        assert abs(value(partial, PLACES) - slope(node, symbol.value)) < 1e-35


@pytest.mark.parametrize("op", [Op.ABS, Op.SIGN, Op.TANH, Op.ATAN2, Op.SIN, Op.COS, Op.EXP], ids=lambda op: op.name)
def test_partial_derivatives_hold_left_of_zero_too(op):
    graph = Graph()
    symbols = [graph.symbol(name) for name in ("y", "x")[: ARITY[op]]]
    node = build(graph, op, symbols)

    for partial, symbol in zip(PARTIALS[op](node, *symbols), symbols, strict=True):
        assert abs(value(partial, PLACES) - slope(node, symbol.value)) < 1e-35


# Small random expressions, defined everywhere: divisors and roots stay away from zero

UNARY = [op for op in sorted(FUNCTIONS) if ARITY[op] == 1 and op not in (Op.ABS, Op.SIGN)]


def combine(children):
    pairs = st.tuples(st.sampled_from([Op.ADD, Op.SUB, Op.MUL, Op.DIV]), children, children)
    return pairs | st.tuples(st.sampled_from([Op.NEG, *UNARY]), children)


RECIPES = st.recursive(st.sampled_from(["x", "y", "z", Fraction(2), Fraction(-1, 3), "pi"]), combine, max_leaves=8)


def cook(graph, recipe):
    """Return a recipe as a node; x/y becomes x/(2 + y²), sqrt x becomes sqrt(1 + x²), exp x becomes exp(sin x)."""
    if isinstance(recipe, Fraction):
        return graph.constant(recipe)
    if isinstance(recipe, str):
        return graph.pi if recipe == "pi" else graph.symbol(recipe)
    op, *args = (recipe[0], *(cook(graph, arg) for arg in recipe[1:]))
    if op is Op.DIV:
        args[1] = 2 + args[1] * args[1]
    if op in (Op.SQRT, Op.LOG):
        args[0] = 1 + args[0] * args[0]
    if op is Op.EXP:
        args[0] = graph.sin(args[0])
    return build(graph, op, args)


@settings(max_examples=100)
@given(RECIPES)
def test_reverse_and_forward_agree_with_differences(recipe):
    graph = Graph()
    symbols = [graph.symbol(name) for name in PLACES]
    node = cook(graph, recipe)

    backward = [value(entry, PLACES) for entry in gradient(node, symbols)]
    forward = [value(tangents([node], {symbol: graph.one})[0], PLACES) for symbol in symbols]
    measured = [slope(node, name) for name in PLACES]

    size = 1 + max(abs(x) for x in measured)
    for a, b, c in zip(backward, forward, measured, strict=True):
        assert abs(a - b) < 1e-45 * size
        assert abs(a - c) < 1e-25 * size**3


# Turns


def turned(angle, x, y):
    graph = angle.graph
    c, s = graph.cos(angle), graph.sin(angle)
    return c * x - s * y, s * x + c * y


def multiplications(nodes):
    return sum(node.op is Op.MUL for node in reachable(nodes))


@pytest.mark.long
@settings(max_examples=60)
@given(RECIPES, RECIPES, RECIPES, st.booleans())
def test_what_has_turned_has_the_same_derivatives_by_its_angle_as_by_its_operands(angle, x, y, back):
    """Also where what turns depends on the angle, is a sine of it, or is the same in both components."""
    graph = Graph()
    symbols = [graph.symbol(name) for name in PLACES]
    angle, x, y = (cook(graph, one) for one in (angle, x, y))
    found = turned(symbols[0] - angle, *turned(-angle if back else angle, x, y))
    node = graph.sin(found[0]) * found[1] - found[0]

    for read in (operands, turns([node])):
        backward = [value(entry, PLACES) for entry in gradient(node, symbols, read)]
        forward = [value(tangents([node], {symbol: graph.one}, read)[0], PLACES) for symbol in symbols]
        measured = [slope(node, name) for name in PLACES]
        size = 1 + max(abs(x) for x in measured)
        for a, b, c in zip(backward, forward, measured, strict=True):
            assert abs(a - b) < 1e-40 * size
            assert abs(a - c) < 1e-25 * size**3


def test_a_turn_is_differentiated_for_six_multiplications():
    graph = Graph()
    q, x, y, dq, dx, dy, a, b = (graph.symbol(name) for name in ("q", "x", "y", "dq", "dx", "dy", "a", "b"))
    pair = turned(q, x, y)
    sides, seeds = turned(q, dx, dy), {q: dq, x: dx, y: dy}

    assert tangents(pair, seeds, turns(pair)) == [sides[0] - pair[1] * dq, sides[1] + pair[0] * dq]
    assert multiplications([*pair, *tangents(pair, seeds, turns(pair))]) == 4 + 6
    assert multiplications([*pair, *tangents(pair, seeds)]) == 4 + 8 + 2

    phi = a * pair[0] + b * pair[1]
    assert multiplications([*pair, *gradient(phi, [q, x, y], turns([phi]))]) == 4 + 6
    assert multiplications([*pair, *gradient(phi, [q, x, y])]) == 4 + 8 + 2


@pytest.mark.parametrize("sign", [1, -1])
def test_a_single_product_and_a_negative_partner_are_read_too(sign):
    graph = Graph()
    q, x, dq = (graph.symbol(name) for name in ("q", "x", "dq"))
    lone = [graph.cos(q) * x, sign * graph.sin(q) * x]
    turned_back = [graph.sin(q) * dq - graph.cos(q) * x, -(graph.cos(q) * dq) - graph.sin(q) * x]

    assert tangents(lone, {q: dq}, turns(lone)) == [-(graph.sin(q) * x) * dq, sign * (graph.cos(q) * x) * dq]
    assert tangents(turned_back, {q: x}, turns(turned_back)) == [-turned_back[1] * x, turned_back[0] * x]


def test_what_has_no_partner_is_differentiated_by_its_operands():
    graph = Graph()
    q, x, y = (graph.symbol(name) for name in ("q", "x", "y"))
    for node in (graph.cos(q) * x - graph.sin(q) * y, graph.cos(q) * x + graph.sin(y) * x, graph.cos(q) * x + y):
        assert tangents([node], {q: x, y: q}, turns([node])) == tangents([node], {q: x, y: q})

    two_angles = [graph.cos(q) * x - graph.sin(y) * x, graph.sin(q) * x + graph.cos(y) * x]
    assert tangents(two_angles, {y: x}, turns(two_angles)) == tangents(two_angles, {y: x})


@settings(max_examples=60)
@given(RECIPES, RECIPES)
def test_substitution_commutes_with_evaluation(recipe, inner):
    graph = Graph()
    node, replacement = cook(graph, recipe), cook(graph, inner)
    replaced = substitute([node], {graph.symbol("x"): replacement})[0]

    expected = value(node, {**PLACES, "x": value(replacement, PLACES)})

    assert abs(value(replaced, PLACES) - expected) < 1e-40 * (1 + abs(expected))


@settings(max_examples=40)
@given(RECIPES)
def test_a_copy_on_another_graph_is_the_same_function(recipe):
    node, other = cook(Graph(), recipe), Graph()

    (copy,) = substitute([node], {}, other)

    assert copy.graph is other
    assert abs(value(copy, PLACES) - value(node, PLACES)) < 1e-45 * (1 + abs(value(node, PLACES)))


def test_substitution_simplifies_at_birth():
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")

    assert substitute([x * graph.sin(y) + y], {x: graph.zero}) == [y]
    assert substitute([graph.sin(x + y)], {x: graph.pi / 2}) == [graph.cos(y)]
    assert substitute([x + y, x * y], {}) == [x + y, x * y]
    assert substitute([], {}) == []


def test_substitution_replaces_a_node_that_is_no_symbol_and_all_at_once():
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")

    assert substitute([graph.sin(x) * y], {graph.sin(x): x}) == [x * y]
    assert substitute([x - y], {x: y, y: x}) == [y - x]


def test_a_gradient_can_be_taken_with_respect_to_an_inner_node():
    graph = Graph()
    x = graph.symbol("x")
    s = graph.sin(x)

    assert gradient(s * s + x, [s, x])[0] is 2 * s
    assert gradient(graph.cos(x), [graph.symbol("elsewhere")]) == [graph.zero]
    assert tangents([graph.one, x], {x: s}) == [graph.zero, s]
    assert tangents([], {}) == []
