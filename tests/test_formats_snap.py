"""Decimals are read as multiples of π exactly when they are such a multiple, correctly rounded at their own digits."""

import math
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given, strategies as st

from symdyn.scene import parse
from symdyn.scene.formats.inertias import _rotated
from symdyn.scene.formats.placing import DENOMINATORS, PI_50, is_rounding, snap_angle


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("1.5707963", "pi/2"),
        ("+1.57079633", "pi/2"),
        ("3.14159265359", "pi"),
        ("-3.1415927", "-pi"),
        ("6.2831853", "2*pi"),
        ("0.7853981634", "pi/4"),
        ("-2.35619449", "-3*pi/4"),
        ("7.853981634e-1", "pi/4"),
        ("157079633e-8", "pi/2"),
        ("0.52359878", "pi/6"),
        ("1.2217304763960306", "70 deg"),
        ("0.017453293", "pi/180"),
        (repr(math.pi), "pi"),
        ("3.1415926535897931", "pi"),  # %.17g of the double
        ("1.57079632679489655800", "pi/2"),  # %.20f of the double
        ("1.57079632679489661923132169163975144", "pi/2"),
    ],
)
def test_correctly_rounded_multiples_are_snapped(text, formula):
    assert snap_angle(text) == parse(formula)


@pytest.mark.parametrize(
    "text",
    [
        "1.57",
        "3.142",
        "1.570796",  # seven digits say too little
        "0.5235988",  # so do seven behind a zero
        "1.57079632",  # cut off, not rounded
        "1.5707950",
        "3.14158000",
        "1.5707963267948961",  # no double of π/2
        "0.01745329",
        "9.42477796",  # 3 π is no angle that a file means
        "0",
        "0.00000",
        "1e-5",
        "1.5708x",
        "nan",
        "inf",
        "1_5708",
        "1e999999999",
        "0x1.921fb54442d18p0",
        "9" * 100_000,
    ],
)
def test_everything_else_stays_as_it_is_written(text):
    assert snap_angle(text) is None


@pytest.mark.mends("30.numbers.5")
@pytest.mark.parametrize("text", ["1.5708", "1.57080", "-3.1416", "6.28319", "15708e-4", "0.52360", "0.785398"])
def test_a_decimal_of_few_digits_is_no_multiple_of_pi(text):
    assert snap_angle(text) is None


@given(st.sampled_from(DENOMINATORS), st.integers(-12, 12), st.integers(8, 24))
def test_rounding_a_multiple_and_snapping_gives_it_back(denominator, k, digits):
    turns = Fraction(k, denominator)
    if not turns or abs(turns) > 2:
        return
    exact = turns * PI_50
    text = f"{Decimal(exact.numerator) / Decimal(exact.denominator):.{digits - 1}e}"

    assert snap_angle(text) == parse(f"{k}/{denominator}*pi")


@given(st.sampled_from(DENOMINATORS), st.integers(1, 12), st.integers(8, 14), st.sampled_from([-1, 1]))
def test_one_unit_in_the_last_place_beside_a_multiple_is_not_snapped(denominator, k, digits, side):
    exact = Fraction(k, denominator) * PI_50
    if exact > 2 * PI_50:
        return
    rounded = Decimal(f"{float(exact):.{digits - 1}e}")
    beside = rounded + side * Decimal((0, (1,), rounded.as_tuple().exponent))
    assert snap_angle(str(beside)) is None


def test_any_number_can_be_asked_for():
    root = Fraction(math.isqrt(2 * 10**80), 2 * 10**40)

    assert is_rounding("0.70710678", root)
    assert not is_rounding("0.7071068", root)
    assert is_rounding("0.7071", root, fewest_digits=4)
    assert not is_rounding("0.70710677", root)
    assert not is_rounding("half", root)


def test_a_quarter_turn_of_principal_axes_leaves_no_products_of_inertia():
    quarter = (0.7071067811865476, 0.0, 0.0, 0.7071067811865475)
    tidy = _rotated([1.0, 2.0, 3.0], quarter, True)
    assert tidy == {"xx": 2.0, "yy": 1.0, "zz": 3.0, "xy": 0.0, "xz": 0.0, "yz": 0.0}
    assert _rotated([1.0, 2.0, 3.0], quarter, False)["xy"] != 0
