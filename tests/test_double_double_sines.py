"""Sines and cosines of double-doubles: their error is bounded by balls from the numbers of the code, and measured.

u = 2^-53      a pair is hi + lo; size bounds |hi|, low bounds |lo|, error what it is off by
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import factorial

import mpmath
import numpy as np
import pytest
from flint import arb, ctx, fmpq
from formulas import one

from symdyn.emit.targets.c.double_double import (
    COSINE_IN_DOUBLE,
    COSINE_TERMS,
    PI,
    SINE_IN_DOUBLE,
    SINE_TERMS,
    half_pi,
    sincos_numbers,
)
from symdyn.graph import Graph
from symdyn.program import lower
from symdyn.runtime import build

pytestmark = pytest.mark.usefixtures("optimised")

CLAIMED = arb(2) ** -101
U = arb(2) ** -53


@pytest.fixture(autouse=True)
def precise():
    before, ctx.prec = ctx.prec, 400
    yield
    ctx.prec = before


def ball(value: Fraction) -> arb:
    return arb(fmpq(value.numerator, value.denominator))


# The bound


@dataclass(frozen=True)
class Pair:
    size: arb
    low: arb
    error: arb

    @property
    def whole(self) -> arb:
        return self.size + self.low


def rounded(value: Fraction) -> Pair:
    size = abs(ball(value)) * (1 + U)
    return Pair(size, U * size, U * U * size)


def times(a: Pair, b: Pair) -> Pair:
    """`dd_mul_loose`: the product of the low parts is left out, two cross terms and two sums are rounded."""
    size, cross = a.size * b.size * (1 + U), (a.low * b.size + a.size * b.low) * (1 + U) ** 2
    inherited = a.error * (b.whole + b.error) + b.error * a.whole
    made = a.low * b.low + U * a.size * b.low + U * cross + U * (U * size + cross)
    return Pair(size, (U * size + cross) * (1 + U), inherited + made)


def plus(a: Pair, b: Pair) -> Pair:
    """A sum whose high parts are added exactly, and the low ones with two roundings."""
    size, low = (a.size + b.size) * (1 + U), a.low + b.low
    return Pair(
        size, (U * size + low * (1 + U)) * (1 + U), a.error + b.error + U * low + U * (U * size + low * (1 + U))
    )


def series(first: int, short: int, last: int, step: int, z: Pair) -> Pair:
    """The series in z with coefficients 1/(2m + step)!, all terms of one sign, which no alternating one exceeds.

    From `short` on in doubles: coefficients, products and sums are rounded, and z is its high part.
    """
    size = error = arb(0)
    for m in range(last, short - 1, -1):
        term, more = ball(Fraction(1, factorial(2 * m + step))), size * z.whole * (1 + U)
        error = error * z.whole + size * (z.low + z.error) + U * more + U * term + U * (more + term) * (1 + U)
        size = (term + more) * (1 + U)
    tail = Pair(size * z.whole, arb(0), error * z.whole + size * (z.low + z.error) + U * size * z.whole)
    found = plus(rounded(Fraction(1, factorial(2 * (short - 1) + step))), tail)
    for m in range(short - 2, first - 1, -1):
        found = plus(rounded(Fraction(1, factorial(2 * m + step))), times(z, found))
    return found


def reduction() -> tuple[arb, arb]:
    """What y is off by, as a part of itself, by two sums of 3 u²/(1 - 4u) each; and beside that, as it is."""
    parts = [Fraction(part) for part in half_pi()]
    rest = 2**20 * (abs(ball(PI / 2 - sum(parts))) + 3 * U * U * ball(parts[3]))
    one = 3 * U * U / (1 - 4 * U)
    return 2 * one + one * one, rest + one * 2**20 * ball(parts[3])


def bounds() -> tuple[arb, arb]:
    """The largest relative errors of sine and cosine of a y up to π/4 and a little, reduction included."""
    edge = ball(PI / 4) * (1 + arb(2) ** -10)
    part, _ = reduction()
    z = Pair(edge**2 * (1 + 8 * U), U * edge**2, 5 * U * U * edge**2)
    y = Pair(arb(1), U, arb(0))  # in parts of |y|
    sine = plus(y, times(y, times(z, series(1, SINE_IN_DOUBLE, SINE_TERMS, 1, z))))
    cut = edge ** (2 * SINE_TERMS + 2) / ball(Fraction(factorial(2 * SINE_TERMS + 3)))
    of_sine = (sine.error + cut) * edge / edge.sin() + part
    h = Pair(arb(1), U + z.low / 2 * (1 + U), U * (U + z.low) + z.error / 2)
    cosine = plus(h, times(times(z, z), series(2, COSINE_IN_DOUBLE, COSINE_TERMS, 0, z)))
    cut = edge ** (2 * COSINE_TERMS + 2) / ball(Fraction(factorial(2 * COSINE_TERMS + 2)))
    return of_sine, (cosine.error + cut) / edge.cos() + edge * edge.tan() * part


def test_the_error_of_both_is_bounded():
    assert all(bound < CLAIMED for bound in bounds())
    assert all(bound > U * U for bound in bounds())  # it is no bound of nothing


def test_next_to_multiples_of_a_quarter_turn_what_is_lost_is_below_the_claim():
    assert reduction()[1] < arb(2) ** -180
    assert abs(ball(PI) - arb.pi()) < arb(10) ** -100
    for part in half_pi()[:3]:  # twenty bits times one are exact
        mantissa = int(Fraction(part) * 2**120)
        assert mantissa >> ((mantissa & -mantissa).bit_length() - 1) < 2**33


def test_the_numbers_are_those_of_the_series():
    numbers = sincos_numbers()
    for name, first, short, step in (("sine", 1, SINE_IN_DOUBLE, 1), ("cosine", 2, COSINE_IN_DOUBLE, 0)):
        pairs = numbers[name]["pairs"][::-1]
        assert len(pairs) == short - first
        for m, text in enumerate(pairs, first):
            found = sum(Fraction(float(part)) for part in text.split(", "))
            wanted = Fraction((-1) ** m, factorial(2 * m + step))
            assert abs(found / wanted - 1) < Fraction(1, 2**106)


# The measurement


@pytest.fixture(scope="module", params=["native", "portable"])
def sincos(request):
    """Sines and cosines of pairs (n, 2) by the generated routine, shape (n, 2, 2)."""
    g = Graph()
    q = g.symbol("q1")
    call = build(lower(one([g.sin(q), g.cos(q)], [q])), real="dd", machine=request.param).f
    return lambda angles: call(np.reshape(angles, (-1, 1, 2)))


def pairs(high: np.ndarray, seed: int = 1) -> np.ndarray:
    high = np.asarray(high, float)
    return np.stack([high, np.random.default_rng(seed).uniform(-0.5, 0.5, len(high)) * np.spacing(np.abs(high))], 1)


def worst(found: np.ndarray, angles: np.ndarray) -> float:
    largest = mpmath.mpf(0)
    with mpmath.workprec(400):
        for row, angle in zip(found, angles, strict=True):
            x = mpmath.fsum(map(float, angle))
            for value, exact in zip(row, (mpmath.sin(x), mpmath.cos(x)), strict=True):
                off = abs(mpmath.fsum(map(float, value)) - exact) - mpmath.mpf(2) ** -180
                largest = max(largest, off / (abs(exact) or 1))
        return float(largest)


@pytest.mark.wide(2)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("span", [0.8, 3.2, 1e3, 2.0**20])
def test_sines_are_right_to_31_digits(sincos, span):
    angles = pairs(np.random.default_rng(2).uniform(-span, span, 400))
    assert worst(sincos(angles), angles) < 2.0**-101


@pytest.mark.runs("cc")
def test_sines_next_to_multiples_of_a_quarter_turn_are_right_to_31_digits(sincos):
    multiples = np.concatenate([np.arange(-40, 41), np.random.default_rng(3).integers(-660_000, 660_000, 200)])
    with mpmath.workprec(300):
        exact = [int(k) * mpmath.pi / 2 for k in multiples]
        high = [float(x) for x in exact]
        angles = np.array([(a, float(x - a)) for a, x in zip(high, exact, strict=True)])
    assert worst(sincos(angles), angles) < 2.0**-101
    doubles = np.stack([angles[:, 0], np.zeros(len(angles))], 1)
    assert worst(sincos(doubles), doubles) < 2.0**-101


@pytest.mark.runs("cc")
def test_small_angles_keep_their_digits(sincos):
    angles = pairs([1e-3, -1e-10, 1e-30, 1e-150, -1e-280, 0.0])
    found = sincos(angles)
    assert worst(found[:5], angles[:5]) < 2.0**-101
    assert found[5].tolist() == [[0, 0], [1, 0]]


@pytest.mark.runs("cc")
def test_what_is_too_large_or_no_number_gives_no_number_there_alone(sincos):
    angles = np.zeros((40, 2))
    angles[:, 0] = np.linspace(-3, 3, 40)
    angles[[1, 17, 20, 39], 0] = [2.0**20, np.nan, -np.inf, 1e300]
    found = sincos(angles)
    assert np.isnan(found[[1, 17, 20, 39], :, 0]).all()
    assert np.isfinite(np.delete(found, [1, 17, 20, 39], 0)).all()
    assert np.isfinite(sincos(np.array([[np.nextafter(2.0**20, 0), 0.0]]))).all()
