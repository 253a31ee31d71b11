"""Lines and their names: readable, never too wide, never twice the same."""

from __future__ import annotations

from formulas import argument, every_op, function, one
from mechanisms import random_tree

from symdyn.dynamics.outputs.derive import derive
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import emit
from symdyn.graph import Expr, Graph, Op
from symdyn.program import Routine, lower
from symdyn.scene import Scene
from symdyn.scene.values import Parameter


def routine(entries: list[Expr], symbols: list[Expr]) -> Routine:
    return lower(one(entries, symbols))["f"]


def test_what_is_used_once_stands_inside_its_line():
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    assert routine([(x + y) * (x - y)], [x, y]).steps == ()


def test_what_is_used_twice_is_computed_once():
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    total = x + y
    assert [step.name for step in routine([total * x, total * y], [x, y]).steps] == ["x1"]


def test_a_sign_is_no_line_of_its_own():
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    (step,) = routine([-(x * y), g.function(Op.EXP, -(x * y))], [x, y]).steps
    assert step.node.op is Op.MUL


def test_sines_carry_the_number_of_their_joint():
    g = Graph()
    a, b = g.symbol("alpha"), g.symbol("beta")
    entries = [g.sin(a) * g.cos(a + b), g.cos(a) * g.sin(a - b), g.sin(2 * b)]
    names = {step.name: step.node.op for step in routine(entries, [a, b]).steps}
    assert names == {"s1": Op.SIN, "c1": Op.COS, "c1_2": Op.COS, "sa1": Op.SIN, "sa2": Op.SIN}


def test_two_forms_of_one_sum_are_one_sine():
    g = Graph()
    a, b, c = (g.symbol(name) for name in "abc")
    first, second = (a + b) + c, a + (b + c)
    assert first is not second
    assert [step.name for step in routine([g.sin(first), g.sin(second)], [a, b, c]).steps] == ["s1_2_3"]


def test_no_line_grows_too_wide_and_no_name_is_given_twice():
    program = lower(derive(random_tree(3, 5)))
    (text,) = emit(program).values()
    assert max(len(line) for line in text.split("def ")[2].splitlines()) < 140
    for part in program.routines:
        names = [step.name for step in part.inputs + part.steps]
        assert len(set(names)) == len(names)


def test_parameters_keep_their_names_whatever_these_are():
    g = Graph()
    q, names = g.symbol("q1"), ["x1", "double", "s1", "y0", "α"]
    symbols = [g.symbol(name) for name in names]
    f = function("f", [argument("q", [q]), argument("params", symbols)], (1,), [g.sin(q) * g.total(symbols)])
    equations = Equations(Scene("hand", tuple(Parameter(name) for name in names)), g, (f,))
    names_now = [step.name for step in lower(equations)["f"].inputs]
    assert names_now == ["q_1", "p_x1", "p_double", "p_s1", "p_y0", "p_u03b1"]


def test_unused_arguments_are_known():
    program = lower(every_op())
    assert program["nothing"].unused == ("q", "qd", "params")
    assert program["scalar"].unused == ("q",)
    assert program["matrix"].unused == ()
