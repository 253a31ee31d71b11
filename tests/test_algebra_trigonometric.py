"""The ring of trigonometric polynomials decides zero, and forms made from it keep their value."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from fractions import Fraction

import pytest

from symdyn.algebra.compact import Compactor
from symdyn.algebra.form import Function, Sum
from symdyn.algebra.numeric import Floats
from symdyn.algebra.sums_of_angles import MANY_ANGLES, AngleGroup
from symdyn.algebra.trigonometric import Polynomial, TrigonometricRing
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, Op, evaluate, reachable, tangents

G = Graph()
Q1, Q2, Q3, M, L = (G.symbol(name) for name in ("q1", "q2", "q3", "m", "l"))
PI, S, C, ROOT = G.pi, G.sin, G.cos, G.sqrt
RADIAN, DEGREE = G.constant(Fraction(3, 10)), PI / 180

ZEROS = {
    "addition formula": C(Q1 + Q2) - C(Q1) * C(Q2) + S(Q1) * S(Q2),
    "half an angle": C(Q1) - 2 * C(Q1 / 2) * C(Q1 / 2) + 1,
    "gear ratio 2:3": C(2 * Q1 / 3) * C(Q1) - (C(5 * Q1 / 3) + C(Q1 / 3)) / 2,
    "sixty degrees": S(Q1 + PI / 3) - S(Q1) / 2 - ROOT(3) / 2 * C(Q1),
    "fifteen degrees": S(Q1 + PI / 12) - (ROOT(6) + ROOT(2)) / 4 * S(Q1) - (ROOT(6) - ROOT(2)) / 4 * C(Q1),
    "a numeric angle": S(Q1 + RADIAN) * S(Q1 + RADIAN) + C(Q1 + RADIAN) * C(Q1 + RADIAN) - 1,
    "an angle parameter": C(Q1 + M) - C(Q1) * C(M) + S(Q1) * S(M),
    "one degree more": S(Q1 + DEGREE) - S(Q1) * C(DEGREE) - C(Q1) * S(DEGREE),
    "a degree squared": S(DEGREE) * S(DEGREE) + C(DEGREE) * C(DEGREE) - 1,
    "a complement": C(3 * PI / 8) - S(PI / 8),
    "beyond a quarter turn": C(Q1 + 3 * PI / 8) - S(PI / 8) * C(Q1) + C(PI / 8) * S(Q1),
    "degrees and radians together": C(DEGREE + RADIAN) - C(DEGREE) * C(RADIAN) + S(DEGREE) * S(RADIAN),
    "gear ratio 1:100": C(101 * Q1) - C(100 * Q1) * C(Q1) + S(100 * Q1) * S(Q1),
    "roots of composites": ROOT(6) - ROOT(2) * ROOT(3),
    "an irrational denominator": 1 / (1 + ROOT(2)) - ROOT(2) + 1,
    "an irrational cosine below": 1 / C(PI / 8) * C(PI / 8) - 1,
    "inverse of a product": 1 / (M * L) - (1 / M) * (1 / L),
    "reducible fractions": 1 / (M + L) - M / (M * M + M * L),
    "partial fractions": L / ((M + L) * (M + 2 * L)) - 1 / (M + L) + 1 / (M + 2 * L),
    "root of a parameter": 1 / ROOT(M) - ROOT(M) / M,
    "polynomial in a bare coordinate": (Q1 + S(Q1)) * (Q1 - S(Q1)) - Q1 * Q1 + 1 - C(Q1) * C(Q1),
}


def over_ring(node: Expr) -> tuple[TrigonometricRing, Polynomial]:
    ring = TrigonometricRing([node], (Q1, Q2, Q3))
    return ring, evaluate([node], ring, ring.values([node]))[0]


@pytest.mark.parametrize("name", ZEROS)
def test_what_vanishes_as_a_function_is_zero_in_the_ring(name: str) -> None:
    ring, value = over_ring(ZEROS[name])

    assert ring.is_zero(value)


@pytest.mark.parametrize("name", ZEROS)
def test_what_does_not_vanish_is_not_zero(name: str) -> None:
    ring, value = over_ring(ZEROS[name] + S(Q1) * Fraction(1, 10**9))

    assert not ring.is_zero(value)


UNKNOWN = {
    "36 degrees": C(PI / 5) - (1 + ROOT(5)) / 4,
    "22.5 degrees": 4 * C(PI / 8) * C(PI / 8) - 2 - ROOT(2),
    "twice one degree": S(2 * DEGREE) - 2 * S(DEGREE) * C(DEGREE),
    "twice 0.3 rad": C(2 * RADIAN) - 2 * C(RADIAN) * C(RADIAN) + 1,
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_relations_between_odd_constant_angles_stay_as_terms_whose_value_is_zero(name: str) -> None:
    ring, value = over_ring(UNKNOWN[name])

    assert not ring.is_zero(value)
    assert float_value(Compactor(ring)(value).express(G)) == pytest.approx(0, abs=1e-14)


def test_every_odd_angle_has_a_sine_of_its_own_and_usual_angles_have_none() -> None:
    node = S(Q1 + DEGREE) + S(2 * Q1 + 7 * DEGREE) + C(Q2 + RADIAN) + C(Q2 + RADIAN * 7 / 5) + S(Q2 + PI / 12)
    ring, _ = over_ring(node)
    sines = [(g.node, g.unit) for g in ring.generators if g.kind == "sin"]

    assert sorted(unit for atom, unit in sines if atom is PI) == [Fraction(1, 180), Fraction(7, 180)]
    assert sorted(unit for atom, unit in sines if atom is None) == [Fraction(3, 10), Fraction(21, 50)]
    assert sorted(str(atom) for atom, _ in sines if atom not in (None, PI)) == ["q1", "q2"]


def test_coefficients_of_one_coordinate_share_a_sine_while_they_are_small_multiples() -> None:
    ring, _ = over_ring(S(Q1) + S(3 * Q1 / 2) + S(100 * Q1) + S(99 * Q1))

    assert [g.unit for g in ring.generators if g.kind == "sin"] == [Fraction(1, 2), 99]


def test_a_product_that_nobody_could_read_is_refused_before_it_is_made() -> None:
    total = G.total(G.symbol(f"a{k}") for k in range(20))
    fourth = total * total * (total * total)
    with pytest.raises(DerivationError, match=r"too long to be of use: .* symdyn generate writes NumPy and C"):
        over_ring(fourth * fourth)


def random_node(rng: random.Random, depth: int) -> Expr:
    """Return a random trigonometric polynomial with multiples of π, roots, sums of angles and bare coordinates."""
    leaves: list[Callable[[], Expr]] = [
        lambda: S(rng.choice([Q1, Q1 + Q2, Q2 - Q3, 2 * Q3 + PI / 3, Q2 / 2, Q2 + DEGREE, 20 * Q2])),
        lambda: C(rng.choice([Q1, Q2 + Q3, Q1 + Q2 + Q3, Q3 + PI / 4, Q2 / 2 - Q1])),
        lambda: rng.choice([M, L, Q3, ROOT(3), 1 / M, PI]),
        lambda: G.constant(Fraction(rng.randint(-5, 5), rng.randint(1, 4))),
    ]
    if depth == 0:
        return rng.choice(leaves)()
    a, b = random_node(rng, depth - 1), random_node(rng, depth - 1)
    return rng.choice([a + b, a - b, a * b])


def float_value(node: Expr) -> float:
    numbers = {Q1: 0.7, Q2: -1.3, Q3: 2.1, M: 1.7, L: 0.6}
    values = {x: numbers[x] for x in reachable([node]) if x.op is Op.SYMBOL}
    return evaluate([node], Floats(), values)[0]


@pytest.mark.parametrize("seed", range(12))
def test_a_derivative_in_the_ring_is_the_derivative_on_the_graph(seed: int) -> None:
    node = random_node(random.Random(seed), 4)
    slope = tangents([node], {Q2: G.one})[0]
    ring = TrigonometricRing([node, slope], (Q1, Q2, Q3))
    value, expected = evaluate([node, slope], ring, ring.values([node, slope]))

    assert ring.is_zero(ring.derivative(value, Q2) - expected)


def test_half_a_total_angle_turns_half_as_fast() -> None:
    angles = [G.symbol(f"a{k}") for k in range(MANY_ANGLES + 1)]
    below = tuple((1, one) for one in [None, *angles[:-1]])
    node = S(G.total(angles) / 2)
    slope = tangents([node], {angles[0]: G.one})[0]
    ring = TrigonometricRing([node, slope], angles, [AngleGroup(tuple(angles), (), below)])
    value, expected = evaluate([node, slope], ring, ring.values([node, slope]))

    assert ring.is_zero(ring.derivative(value, angles[0]) - expected)


@pytest.mark.parametrize("seed", range(12))
def test_a_compact_form_has_the_value_it_was_made_from(seed: int) -> None:
    node = random_node(random.Random(100 + seed), 5)
    ring, value = over_ring(node)
    sums = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (0, 1, 1), (1, 1, 1))
    compact = Compactor(ring, [AngleGroup((Q1, Q2, Q3), sums)])(value).express(G)

    assert float_value(compact) == pytest.approx(float_value(node), rel=1e-9, abs=1e-9)


def compact_terms(node: Expr, *sums: tuple[int, ...]) -> tuple[object, ...]:
    ring, value = over_ring(node)
    return Compactor(ring, [AngleGroup((Q1, Q2, Q3), ((1, 0, 0), (0, 1, 0), (0, 0, 1), *sums))])(value).terms


def test_products_of_sines_become_one_cosine_of_the_sum() -> None:
    terms = compact_terms(C(Q1) * C(Q2) - S(Q1) * S(Q2), (1, 1, 0))

    assert len(terms) == 1
    assert isinstance(terms[0], Function)
    assert isinstance(terms[0].args[0], Sum)


def test_three_angles_become_one_sine_of_their_sum() -> None:
    assert len(compact_terms(S(Q1 + Q2 + Q3), (1, 1, 0), (0, 1, 1), (1, 1, 1))) == 1


def test_opposed_axes_give_differences() -> None:
    assert len(compact_terms(C(Q1 - Q2) * M, (1, -1, 0))) == 1


def test_one_minus_the_square_of_a_cosine_is_the_square_of_a_sine() -> None:
    assert len(compact_terms(M - M * C(Q1) * C(Q1))) == 1


@pytest.mark.parametrize("node", [G.function(Op.EXP, Q1), 1 / C(Q1), ROOT(Q1 * Q1 + 1), S(Q1 * Q1)], ids=str)
def test_a_function_of_a_coordinate_is_refused_with_its_name(node: Expr) -> None:
    with pytest.raises(DerivationError, match=r"expression in q1 is no trigonometric polynomial"):
        over_ring(node)


def test_the_sine_of_a_coordinate_times_a_parameter_is_a_generator_of_its_own() -> None:
    ring, value = over_ring(S(Q1 * M) ** 2 + C(Q1 * M) ** 2 + S(2 * Q1 * M))
    slope = Compactor(ring)(ring.derivative(value, Q1)).express(G)

    assert float_value(slope) == pytest.approx(2 * 1.7 * math.cos(2 * 1.7 * 0.7))


def test_a_function_of_a_parameter_is_a_generator_of_its_own() -> None:
    node = G.function(Op.EXP, M) * S(Q1)
    ring, value = over_ring(node)

    assert float_value(Compactor(ring)(value).express(G)) == pytest.approx(math.exp(1.7) * math.sin(0.7))


def test_the_root_of_a_negative_number_is_refused() -> None:
    with pytest.raises(DerivationError, match=r"sqrt\(-2\) is not real"):
        over_ring(ROOT(-2))


def test_division_by_what_cancels_to_zero_is_an_error() -> None:
    with pytest.raises(ZeroDivisionError, match="divides by zero"):
        over_ring(L / ((M + L) * (M + L) - M * M - 2 * M * L - L * L))
