"""Sines of huge, tiny and denormal angles: what big floats give, and where doubles must lose."""

from __future__ import annotations

import math

import pytest
from oracles import assert_digits, oracle

from symdyn.algebra.big import BigFloats
from symdyn.algebra.numeric import Batches, Floats
from symdyn.graph import Graph, evaluate

CASES = oracle("trig_scalars")["cases"]
SINGLE = [angle for angle in CASES if not angle.startswith("sin(")]
(SUM,) = [angle for angle in CASES if angle.startswith("sin(")]
WIDE = BigFloats(700)  # 1 - cos(5e-324) has its first digit 647 places behind the point


@pytest.fixture
def outputs():
    graph = Graph()
    x = graph.symbol("x")
    return x, [graph.sin(x), graph.cos(x), 1 - graph.cos(x)]


@pytest.mark.parametrize("angle", SINGLE)
def test_big_floats_have_thirty_digits_of_every_sine(outputs, angle):
    x, nodes = outputs
    case, value = CASES[angle], WIDE.number(angle)

    found = evaluate(nodes, WIDE, {x: value})

    for number, key in zip(found, ("sin", "cos", "one_minus_cos"), strict=True):
        given = WIDE.number(case[key])
        assert abs(number - given) <= WIDE.number("2e-29") * abs(given)


@pytest.mark.parametrize("angle", [angle for angle in SINGLE if angle != "9007199254740993"])
def test_doubles_have_sines_to_an_ulp_but_lose_one_minus_cosine(outputs, angle):
    x, nodes = outputs
    case, value = CASES[angle], float(angle)

    for algebra in (Floats(), Batches()):
        sine, cosine, rest = (float(found) for found in evaluate(nodes, algebra, {x: value}))
        assert abs(sine - float(case["sin"])) <= math.ulp(float(case["sin"]))
        assert abs(cosine - float(case["cos"])) <= math.ulp(float(case["cos"]))
        exact = float(case["one_minus_cos"])
        if 0 < value < 1e-7:
            assert rest == 0.0  # every digit of 1 - cos x is gone
        else:
            assert abs(rest - exact) <= 4 * 2**-53


def test_an_angle_that_is_no_double_is_another_angle(outputs):
    x, nodes = outputs
    sine = evaluate(nodes, Floats(), {x: float(2**53 + 1)})[0]

    assert sine == pytest.approx(math.sin(2**53), rel=1e-15)
    assert abs(sine - float(CASES["9007199254740993"]["sin"])) > 0.05


def test_sum_of_angles_keeps_its_digits_as_a_product_but_not_as_a_rounded_sum():
    case, graph, big = CASES[SUM], Graph(), BigFloats(50)
    q1, q2 = graph.symbol("q1"), graph.symbol("q2")
    summed = graph.sin(q1 + q2)
    product = graph.sin(q1) * graph.cos(q2) + graph.cos(q1) * graph.sin(q2)

    (exact,) = evaluate([summed], big, {q1: big.number("1e16"), q2: big.number("1")})
    rounded, kept = evaluate([summed, product], Floats(), {q1: 1e16, q2: 1.0})

    assert_digits([exact], [case["exact"]], "1e-29")
    assert rounded == pytest.approx(float(case["double_rounded_sum"]), rel=1e-15)
    assert kept == pytest.approx(float(case["via_product_formula"]), rel=1e-14)
