"""Points looked at together are the points one by one, and flint's numbers are mpmath's."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

from symdyn.algebra.big import BigFloats, Midpoints, RealBalls, RunningErrors
from symdyn.algebra.finite_field import FiniteField, Needs, Redraw
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.verify.points import Bounds, FirstPoints, bound
from symdyn.verify.written.field import Uninterpreted

SEEDS = [[11, 12], [21, 22]]


def scene_like():
    """Return nodes with all that a field knows: sines of sums, roots of constants, quotients, pi, a function."""
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    half = g.constant(Fraction(1, 2))
    z = g.sin(x + half * y + g.pi / 5) * g.sqrt(g.constant(7)) + (x - 3) / (y * y + 1) - g.pi
    return x, y, [z, -z * z, g.cos(x * y), g.function(Op.EXP, x - y) + z]


def test_points_together_are_the_points_one_by_one() -> None:
    x, y, nodes = scene_like()
    wanted = Needs.of(reachable(nodes))
    primes = [wanted.prime(seed) for seed in (1, 2)]
    first = FirstPoints(wanted, primes, SEEDS)
    found = first.values(nodes)

    for field, j, k in first.places:
        one = FiniteField(primes[k], SEEDS[j][k], wanted)
        point = {s: random.Random(f"{one.seed}:{s.value}").randrange(one.p) for s in (x, y)}
        assert field.p == primes[k]
        assert first.at(found, j, k) == one.evaluate(nodes, point)
    assert [(j, k) for _, j, k in first.places] == [(0, 0), (1, 0), (0, 1), (1, 1)]


def test_a_zero_below_at_one_point_is_unlucky_for_all() -> None:
    g = Graph()
    x = g.symbol("x")
    wanted = Needs.of(reachable([x]))
    primes = [wanted.prime(seed) for seed in (1, 2)]
    place = random.Random(f"{SEEDS[1][1]}:x").randrange(primes[1])

    with pytest.raises(Redraw):
        FirstPoints(wanted, primes, SEEDS).values([1 / (x - place)])


def test_sums_that_round_alike_are_one_operation_and_others_are_not() -> None:
    g = Graph()
    field, a, b = Uninterpreted(10007, 1, Needs.of([g.one])), 3, 5
    less_a, less_b = -a % field.p, -b % field.p
    total, difference = field.operation(Op.ADD, (a, b)), field.operation(Op.SUB, (a, b))

    assert total == field.operation(Op.ADD, (b, a)) == field.operation(Op.ADD, (less_a, less_b))
    assert difference == field.operation(Op.ADD, (less_b, a)) == field.operation(Op.SUB, (b, a))
    assert total != difference


def test_bounds_of_several_claims_are_those_of_each_where_nothing_is_divided() -> None:
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    claims = [([g.sin(x) * y], [x * x]), ([g.cos(x) + g.sin(y)], [g.sin(x) * y * y]), ([y], [x])]
    wanted = Needs.of(reachable([node for sides in claims for side in sides for node in side]))
    bounds = Bounds(wanted)

    assert [bounds.of(*claim) for claim in claims] == [bound(*claim, wanted) for claim in claims]


def test_arguments_of_functions_that_may_be_taken_for_one_another_count() -> None:
    g = Graph()
    x = g.symbol("x")
    one, cube, other = (g.function(Op.EXP, argument) for argument in (x, x * x * x, 2 * x))
    wanted = Needs.of(reachable([cube, one, other]))
    alone, steep, two = (bound([node], [g.zero], wanted).degree for node in (one, cube, one + other))

    value = bound([x], [g.zero], wanted).degree  # that of a function is an independent one, too

    assert steep - value == 3 * (alone - value) > 0
    assert two - value == 2**2 * (alone - value)


def test_a_divisor_of_several_nodes_counts_as_one() -> None:
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    quotient = y / (x * x * x + 1)
    wanted = Needs.of(reachable([quotient]))

    assert bound([quotient], [quotient], wanted).degree <= bound([quotient], [2 * y / (x * x * x + 1)], wanted).degree


OPERATIONS = [op for op in Op if op in BigFloats().functions]


@pytest.mark.parametrize("op", OPERATIONS, ids=lambda op: op.name)
def test_running_errors_over_flint_are_those_over_mpmath(op: Op) -> None:
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    node = g.function(op, *((x, y, x * y)[: op.arity] if op.arity > 1 else (x * y + x,)))
    outputs = [node * x - y / node, node]
    fast, slow, point = Midpoints(50), BigFloats(50), {x: 0.7, y: 1.9}

    with fast:
        errors = RunningErrors(fast, 1e-16, 1e-15)
        mine = evaluate(outputs, errors, {s: errors.exact(fast.number(v)) for s, v in point.items()})
        mine = [(slow.number(one.value.str(60, radius=False)), float(one.error)) for one in mine]
    errors = RunningErrors(slow, 1e-16, 1e-15)
    theirs = evaluate(outputs, errors, {s: errors.exact(slow.number(v)) for s, v in point.items()})
    for (value, error), other in zip(mine, theirs, strict=True):
        assert abs(value - other.value) <= 1e-47 * abs(other.value)
        assert error == pytest.approx(float(other.error), rel=1e-12)


@pytest.mark.parametrize("numbers", [Midpoints(50), RealBalls(50)], ids=["midpoints", "balls"])
def test_what_is_not_real_raises(numbers) -> None:
    g = Graph()
    x = g.symbol("x")
    with numbers:
        for node in (g.sqrt(x), g.function(Op.LOG, x)):
            with pytest.raises(ValueError, match="not real"):
                evaluate([node], numbers, {x: numbers.number(-1.0)})
        with pytest.raises(OverflowError, match="too large"):
            evaluate([g.sin(x)], numbers, {x: numbers.number(2.0) ** 2_000_000})


def test_balls_divide_by_nothing_that_may_be_zero() -> None:
    numbers = RealBalls(50)
    with numbers:
        third = numbers.constant(Fraction(1, 3))
        with pytest.raises(ZeroDivisionError, match="rounding error"):
            numbers.div(third, third * 3 - 1)


def test_bounds_outlast_what_doubles_hold() -> None:
    """Errors are doubles where these hold them; on the way over 1e400 none is lost."""
    numbers = Midpoints(50)
    with numbers:
        errors = RunningErrors(numbers, 2.0**-53, 2.0**-50)
        factor = errors.constant(Fraction(10) ** 200)
        back = errors.div(errors.mul(factor, factor), errors.constant(Fraction(10) ** 300))
        assert float(back.value) == pytest.approx(1e100)
        assert float(back.error) == pytest.approx(5 * 2.0**-53 * 1e100)
