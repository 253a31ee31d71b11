"""Text means what the graph means: parentheses, digits, names."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy
import pytest
from hypothesis import example, given, strategies as st

from symdyn.algebra.numeric import Batches
from symdyn.emit.code.identifiers import function_names, stem
from symdyn.emit.code.spelling import REALS, SINGLE, digits, find_real, nearest
from symdyn.emit.targets.python_modules import NUMPY
from symdyn.errors import EmitError
from symdyn.graph import Expr, Graph, Op, evaluate

DOUBLE, FLOAT = REALS["double"], REALS["float"]


def random_formula(seed: int, size: int = 25) -> tuple[Graph, Expr, dict[Expr, str]]:
    """Return a graph, a node on it and the names of its symbols; nodes are appended raw, without identities."""
    rng = random.Random(seed)
    g = Graph()
    names = {g.symbol(name): name for name in "abc"}
    pool = [*names, g.constant(3), g.constant(Fraction(-1, 2))]
    for _ in range(size):
        op = rng.choice([Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.NEG, Op.SIN, Op.ATAN2])
        args = tuple(rng.choice(pool[-6:] + list(names)) for _ in range(1 if op in (Op.NEG, Op.SIN) else 2))
        pool.append(g._append(args, op, args, None))
    return g, pool[-1], names


@pytest.mark.parametrize("seed", range(60))
def test_printed_formulas_are_evaluated_in_the_order_of_the_graph(seed):
    _, node, names = random_formula(seed)
    known = {n: n.value for n in node.graph.nodes if n.op is Op.CONSTANT}
    text = NUMPY.printer(DOUBLE).code(node, names, known)
    assert "--" not in text
    values = {name: numpy.float64(x) for name, x in zip("abc", (0.7, -1.3, 2.9), strict=True)}
    with numpy.errstate(all="ignore"):
        got = eval(text, {"sin": numpy.sin, "atan2": numpy.arctan2}, values)
        (wanted,) = evaluate([node], Batches(), {symbol: values[name] for symbol, name in names.items()})
    numpy.testing.assert_array_equal(got, wanted)


fractions = st.fractions() | st.builds(
    lambda m, e: Fraction(m) * Fraction(2) ** e, st.integers(), st.integers(-160, 60)
)


@given(fractions)
@example(Fraction(1, 3) * Fraction(1, 2**1070))
@example(Fraction(2**54 + 1))
def test_a_constant_is_rounded_to_the_nearest_double(value):
    assert nearest(value, DOUBLE) == float(value)


@given(fractions)
@example(1 + Fraction(1, 2**24) + Fraction(1, 2**60))
@example(Fraction(1, 2**150) + Fraction(1, 2**200))
def test_a_constant_is_rounded_once_to_the_nearest_float(value):
    if abs(value) >= 2**127:
        return
    got = Fraction(nearest(value, FLOAT))
    single = numpy.float32(float(got))
    assert Fraction(float(single)) == got
    for neighbour in (numpy.nextafter(single, numpy.float32("inf")), numpy.nextafter(single, numpy.float32("-inf"))):
        assert abs(got - value) <= abs(Fraction(float(neighbour)) - value)


def test_rounding_twice_would_have_been_wrong():
    value = 1 + Fraction(1, 2**24) + Fraction(1, 2**60)
    assert nearest(value, FLOAT) == 1 + 2**-23
    assert numpy.float32(float(value)) == 1


@given(fractions)
def test_digits_read_back_as_the_number_they_were(value):
    for real in map(find_real, SINGLE):
        if abs(value) >= 2 ** (real.top - 1):
            continue  # near there it may be too large for the type, which other tests show
        text = digits(value, real)
        assert nearest(Fraction(text), real) == nearest(value, real)
        assert "." in text or "e" in text


def test_digits_near_the_largest_float_do_not_round_beyond_it():
    largest = Fraction(2) ** 128 - Fraction(2) ** 104
    assert nearest(Fraction(digits(largest, FLOAT)), FLOAT) == largest


def test_digits_are_as_few_as_possible():
    assert digits(Fraction(1, 10), FLOAT) == digits(Fraction(1, 10), DOUBLE) == "0.1"
    assert digits(Fraction(1, 3), FLOAT) == "0.33333334"
    assert digits(Fraction(40), FLOAT) == "40.0"


def test_a_constant_too_large_for_the_type_is_refused():
    assert nearest(Fraction(2) ** 200, DOUBLE) == 2.0**200
    with pytest.raises(EmitError, match="too large for the real type float"):
        digits(Fraction(2) ** 200, FLOAT)
    with pytest.raises(EmitError, match="too large for the real type double"):
        digits(Fraction(2) ** 1024 - 1, DOUBLE)


@pytest.mark.parametrize(
    ("scene", "name"),
    [
        ("two_link", "two_link"),
        ("two link", "two_link"),
        ("7-axis", "m7_axis"),
        ("numpy", "numpy_"),
        ("math", "math_"),
        ("class", "class_"),
        ("random", "random_"),
        ("", "scene"),
        ("žeriav", "u017eeriav"),
    ],
)
def test_a_scene_name_becomes_a_file_name_that_hides_nothing(scene, name):
    assert stem(scene) == name


def test_two_functions_never_share_a_name():
    assert function_names(["pose_a", "pose_b-c"]) == ["pose_a", "pose_b_c"]
    with pytest.raises(EmitError, match="pose_a b and pose_a-b would both be called pose_a_b"):
        function_names(["pose_a b", "pose_a-b"])
