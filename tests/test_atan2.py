"""The angle of a point in generated C: its error is proved and measured, its edges are those of C's library."""

from __future__ import annotations

import math
import re
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from flint import arb, arb_poly, ctx, fmpq
from formulas import one

import symdyn
from symdyn.emit import emit
from symdyn.graph import Graph, Op
from symdyn.program import lower
from symdyn.runtime import build

g = Graph()
Y, X = g.symbol("y"), g.symbol("x")


def sources(option: str = "batch") -> symdyn.emit.Sources:
    return emit(lower(one([g.function(Op.ATAN2, Y, X)], [Y, X], symdyn.Scene("angle"))), "c", option=option)


def numbers(of: str) -> list[arb]:
    (line,) = re.findall(rf"const double {of} = (.*);", sources().texts["angle.c"])
    return [arb(exact(Fraction(float(text)))) for text in re.findall(r"-?0\.[0-9]+", line)]


def exact(value: Fraction) -> fmpq:
    return fmpq(value.numerator, value.denominator)


def test_the_polynomial_is_within_a_fifth_of_a_roundoff() -> None:
    """Of (atan u)/u = 1 + z P(z), z = u², |u| ≤ 1/3 and a little, by balls over pieces."""
    pieces, last, worst = 200, Fraction(11112, 100000), arb(0)
    with ctx.workprec(200):
        even, odd = numbers("even"), [*numbers("odd"), arb(0)]
        series = [arb((-1) ** (j + 1)) / (2 * j + 3) for j in range(40)]  # what is left out is below z^40
        off = [a - b for a, b in zip([x for pair in zip(even, odd, strict=True) for x in pair], series, strict=False)]
        off += [-x for x in series[10:]]
        for k in range(pieces):
            middle, radius = (arb(exact(last * x / (2 * pieces))) for x in (2 * k + 1, 1))
            around = arb_poly([0, *off])(arb_poly([middle, 1]))  # powers of z less the middle
            bound = sum((abs(x) * radius**j for j, x in enumerate(around.coeffs())), (middle + radius) ** 40)
            worst = max(worst, bound.upper())

        assert arb(2) ** -60 < worst < arb(2) ** -53 / 5


@pytest.mark.runs("cc")
@pytest.mark.parametrize("option", ["", "batch"])
def test_angles_are_right_to_an_ulp_and_a_half(option: str) -> None:
    rng = np.random.default_rng(5)
    points = rng.uniform(-1, 1, (1500, 2)) * np.exp(rng.uniform(-8, 8, (1500, 2)))
    ends = [[1, 1], [0.3, 1], [0.5, 1], [1e-300, -1], [1e308, 1e308], [5e-324, 1e-323], [4e-310, -9e-310]]
    points = np.concatenate([points, rng.uniform(-1, 1, (1500, 2)), ends])
    call = build(sources(option)).f
    found = call(points) if option else np.array([call(point) for point in points])

    with mpmath.workdps(40):
        for (y, x), angle in zip(points.tolist(), found[:, 0].tolist(), strict=True):
            wanted = mpmath.atan2(y, x)
            assert abs(angle - wanted) <= 1.6 * math.ulp(float(wanted)), (y, x)


@pytest.mark.runs("cc")
def test_edges_are_those_of_the_library() -> None:
    ends = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan, 5e-324, -5e-324, 1.7e308, -2.3e-308]
    points = np.array([(y, x) for y in ends for x in ends])
    found = build(sources()).f(points)[:, 0]
    wanted = np.arctan2(points[:, 0], points[:, 1])

    assert np.array_equal(np.signbit(found)[~np.isnan(wanted)], np.signbit(wanted)[~np.isnan(wanted)])
    np.testing.assert_allclose(found, wanted, rtol=4e-16, atol=0)
