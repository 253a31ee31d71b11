"""The graph: equal expressions are one node, cheap identities hold at birth, and all of it stays exact."""

from __future__ import annotations

from fractions import Fraction

import pytest
from graphs import LEAVES
from oracles import BIG

from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.graph.ops import ARITY, FUNCTIONS, LinearForm
from symdyn.scene import parse
from symdyn.scene.joints.blocks import as_number


@pytest.fixture
def g():
    return Graph()


@pytest.fixture
def x(g):
    return g.symbol("x")


@pytest.fixture
def y(g):
    return g.symbol("y")


def test_equal_expressions_are_one_node(g, x, y):
    assert x + y is y + x
    assert x * y is y * x
    assert (x + y) * g.sin(x * y) is g.sin(y * x) * (y + x)
    assert g.constant(Fraction(2, 4)) is g.constant(Fraction(1, 2))
    assert g.symbol("x") is x


def test_arguments_come_before_what_uses_them(g, x, y):
    outputs = [(x + y) ** 5 / g.sin(x - y), g.sqrt(x) * g.cos(y)]

    nodes = reachable(outputs)

    assert [node.index for node in nodes] == sorted(node.index for node in nodes)
    assert all(arg.index < node.index for node in nodes for arg in node.args)
    assert all(len(node.args) == ARITY[node.op] for node in nodes)
    assert g.nodes[nodes[-1].index] is nodes[-1]


def test_the_walk_that_is_kept_is_that_of_what_was_asked(g, x, y):
    one, other = [g.sin(x * y)], [x + y]
    walks = reachable(one), reachable(other)
    assert walks == ((x, y, x * y, one[0]), (x, y, other[0]))

    grown = one[0] * other[0]  # the graph has more nodes, the old ones need no more
    assert reachable(other) is walks[1]
    assert reachable(one) == walks[0]
    assert reachable([grown]) == (x, y, x * y, one[0], other[0], grown)
    assert reachable([grown], known={one[0]}) == (x, y, one[0], other[0], grown)
    assert reachable([grown], known={x * y: 1, x: 1}) == (x, y, x * y, one[0], other[0], grown)
    assert reachable([]) == ()


BIRTH = [
    ("x + 0", lambda g, x, y: (x + 0, x)),
    ("0 + x", lambda g, x, y: (0 + x, x)),
    ("x - 0", lambda g, x, y: (x - 0, x)),
    ("0 - x", lambda g, x, y: (0 - x, -x)),
    ("x - x", lambda g, x, y: (x - x, g.zero)),
    ("x + x", lambda g, x, y: (x + x, 2 * x)),
    ("0 x", lambda g, x, y: (0 * x, g.zero)),
    ("1 x", lambda g, x, y: (1 * x, x)),
    ("-1 x", lambda g, x, y: (-1 * x, -x)),
    ("x / x", lambda g, x, y: (x / x, g.one)),
    ("x / 1", lambda g, x, y: (x / 1, x)),
    ("0 / x", lambda g, x, y: (0 / x, g.zero)),
    ("x / 2", lambda g, x, y: (x / 2, x * Fraction(1, 2))),
    ("--x", lambda g, x, y: (g.neg(-x), x)),
    ("x + -y", lambda g, x, y: (x + (-y), x - y)),
    ("-x + y", lambda g, x, y: (-x + y, y - x)),
    ("x - -y", lambda g, x, y: (x - (-y), x + y)),
    ("-x - y", lambda g, x, y: (-x - y, -(x + y))),
    ("-x y", lambda g, x, y: ((-x) * y, -(x * y))),
    ("-x / -y", lambda g, x, y: ((-x) / (-y), x / y)),
    ("y - x after x - y", lambda g, x, y: ((x - y) + (y - x), g.zero)),
    ("x + -2", lambda g, x, y: (x + (-2), x - 2)),
    ("2 (3 x)", lambda g, x, y: (2 * (3 * x), 6 * x)),
    ("2 (x / 2)", lambda g, x, y: (2 * (x / 2), x)),
    ("x^0", lambda g, x, y: (x**0, g.one)),
    ("x^-2", lambda g, x, y: (x**-2, 1 / (x * x))),
    ("x^6", lambda g, x, y: (x**6, (x * x) * ((x * x) * (x * x)))),
    ("sin -x", lambda g, x, y: (g.sin(-x), -g.sin(x))),
    ("cos -x", lambda g, x, y: (g.cos(-x), g.cos(x))),
    ("cos(y - x)", lambda g, x, y: (g.cos(y - x), g.cos(x - y))),
    ("sin(x + pi/2)", lambda g, x, y: (g.sin(x + g.pi / 2), g.cos(x))),
    ("cos(x + pi/2)", lambda g, x, y: (g.cos(x + g.pi / 2), -g.sin(x))),
    ("sin(x + pi)", lambda g, x, y: (g.sin(x + g.pi), -g.sin(x))),
    ("cos(x - 3 pi)", lambda g, x, y: (g.cos(x - 3 * g.pi), -g.cos(x))),
    ("cos(x - 3 pi/2)", lambda g, x, y: (g.cos(x - g.pi * Fraction(3, 2)), -g.sin(x))),
    ("sqrt x sqrt x", lambda g, x, y: (g.sqrt(x) * g.sqrt(x), x)),
    ("sqrt 8", lambda g, x, y: (g.sqrt(8), 2 * g.sqrt(2))),
    ("sqrt 9/4", lambda g, x, y: (g.sqrt(Fraction(9, 4)), g.constant(Fraction(3, 2)))),
    ("sqrt 1/3", lambda g, x, y: (g.sqrt(Fraction(1, 3)), g.sqrt(3) / 3)),
    ("sqrt 0", lambda g, x, y: (g.sqrt(0), g.zero)),
    ("tanh -x", lambda g, x, y: (g.function(Op.TANH, -x), -g.function(Op.TANH, x))),
    ("|-x|", lambda g, x, y: (g.function(Op.ABS, -x), g.function(Op.ABS, x))),
    ("sign -x", lambda g, x, y: (g.function(Op.SIGN, -x), -g.function(Op.SIGN, x))),
    ("sign -3", lambda g, x, y: (g.function(Op.SIGN, -3), g.constant(-1))),
    ("exp 0", lambda g, x, y: (g.function(Op.EXP, 0), g.one)),
    ("log 1", lambda g, x, y: (g.function(Op.LOG, 1), g.zero)),
    ("sum of nothing", lambda g, x, y: (g.total([]), g.zero)),
]


@pytest.mark.parametrize("sides", [row[1] for row in BIRTH], ids=[row[0] for row in BIRTH])
def test_identity_at_birth(g, x, y, sides):
    left, right = sides(g, x, y)

    assert left is right


def test_square_root_of_a_square_is_not_its_base(g, x):
    assert g.sqrt(x * x) is not x


def test_a_node_is_shown_by_its_value_its_name_or_its_operation(g, x, y):
    assert [repr(node) for node in (g.constant(Fraction(1, 2)), x, g.pi)] == ["1/2", "x", "pi"]
    assert repr(x * y) == f"mul(#{x.index}, #{y.index})"


def test_the_root_of_a_negative_fraction_stays(g):
    root = g.sqrt(Fraction(-1, 2))

    assert (root.op, root.args) == (Op.SQRT, (g.constant(Fraction(-1, 2)),))


@pytest.mark.parametrize("denominator", [1, 2, 3, 4, 5, 6, 7, 8, 12, 180])
def test_sines_of_multiples_of_pi_are_right_in_every_quadrant(g, denominator):
    for k in range(-2 * denominator, 4 * denominator + 1):
        turns = Fraction(k, denominator)
        found = evaluate([g.sin(g.pi * turns), g.cos(g.pi * turns)], BIG, {})
        angle = BIG.context.pi * k / denominator

        assert abs(found[0] - BIG.context.sin(angle)) < 1e-55
        assert abs(found[1] - BIG.context.cos(angle)) < 1e-55


@pytest.mark.parametrize("k", range(-24, 25))
def test_sines_of_multiples_of_15_degrees_are_free_of_pi_where_they_can_be(g, k):
    turns = Fraction(k, 12)
    nodes = reachable([g.sin(g.pi * turns)])

    if turns.denominator in (1, 2, 3, 4, 6):
        assert all(node.op not in (Op.SIN, Op.COS, Op.PI) for node in nodes)
    assert g.sin(g.pi * turns) is -g.sin(g.pi * (turns + 1))
    assert g.sin(g.pi * turns) is g.cos(g.pi * (turns - Fraction(1, 2)))


def test_linear_form_reads_an_angle(g, x, y):
    angle = 2 * (x - y / 3) + g.pi * Fraction(5, 4) - Fraction(3, 10) - (x - x * y)

    form = angle.linear_form()

    terms = ((x, Fraction(1)), (y, Fraction(-2, 3)), (x * y, Fraction(1)))
    assert form == LinearForm(Fraction(5, 4), Fraction(-3, 10), tuple(sorted(terms, key=lambda term: term[0].index)))


def test_floats_are_refused(g, x):
    with pytest.raises(TypeError, match=r"0\.1 is a float; give an int, a Fraction or an Expr"):
        x + 0.1


def test_expressions_of_two_graphs_do_not_mix(g, x):
    with pytest.raises(AssertionError, match="an expression of another graph was mixed in"):
        g.sin(Graph().symbol("x"))


def test_division_by_a_constant_zero_is_an_error(g, x):
    with pytest.raises(ZeroDivisionError, match="Fraction"):
        x / 0


def test_arithmetic_is_not_a_function(g, x):
    with pytest.raises(AssertionError, match="ADD is arithmetic"):
        g.function(Op.ADD, x, x)


def test_operations_are_leaves_arithmetic_or_functions():
    arithmetic = {Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG}

    assert set(Op) == LEAVES | arithmetic | FUNCTIONS | {Op.TABLE}
    assert not FUNCTIONS & (LEAVES | arithmetic)


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("sin(a)**2 + cos(a)**2", 1),
        ("(cos(a)*cos(b))**2 + (cos(a)*sin(b))**2 + sin(a)**2", 1),
        ("(sqrt(2)*cos(a))**2 + 2*sin(a)*sin(a)", 2),
        ("sin(a)**4 + 2*sin(a)**2*cos(a)**2 + cos(a)**4 - a*b + b*a", 1),
        ("a - a", 0),
        ("sin(a)**2 + cos(b)**2", None),
        ("sqrt(a)*sqrt(a) + 1", None),
        ("sin(a)**64 + cos(a)**2", None),
        ("sin(a)**2 - cos(a)**2", None),
    ],
)
def test_a_polynomial_in_sines_that_is_one_number_is_known(formula: str, value: int | None) -> None:
    graph = Graph()
    assert as_number(parse(formula).express(graph)) == value
