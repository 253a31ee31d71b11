"""Units: their table, against factors typed from other sources, and their grammar."""

import math
from fractions import Fraction
from pathlib import Path

import pytest

from symdyn.scene.values.unit import Unit

SI_BROCHURE = {
    # BIPM, The International System of Units, 9th edition; NIST SP 811 (2008), appendix B; typed by hand.
    # name: (numerator and denominator of the factor, power of pi, kg, m, s, A, K, mol, cd)
    "m": ("1", 0, 0, 1, 0, 0),
    "pm": ("1e-12", 0, 0, 1, 0, 0),
    "nm": ("1e-9", 0, 0, 1, 0, 0),
    "um": ("1e-6", 0, 0, 1, 0, 0),
    "mm": ("0.001", 0, 0, 1, 0, 0),
    "cm": ("0.01", 0, 0, 1, 0, 0),
    "dm": ("0.1", 0, 0, 1, 0, 0),
    "km": ("1000", 0, 0, 1, 0, 0),
    "in": ("0.0254", 0, 0, 1, 0, 0),
    "ft": ("0.3048", 0, 0, 1, 0, 0),
    "kg": ("1", 0, 1, 0, 0, 0),
    "g": ("0.001", 0, 1, 0, 0, 0),
    "mg": ("1e-6", 0, 1, 0, 0, 0),
    "ug": ("1e-9", 0, 1, 0, 0, 0),
    "ng": ("1e-12", 0, 1, 0, 0, 0),
    "t": ("1000", 0, 1, 0, 0, 0),
    "lb": ("0.45359237", 0, 1, 0, 0, 0),
    "oz": ("0.028349523125", 0, 1, 0, 0, 0),
    "s": ("1", 0, 0, 0, 1, 0),
    "ms": ("0.001", 0, 0, 0, 1, 0),
    "us": ("1e-6", 0, 0, 0, 1, 0),
    "ns": ("1e-9", 0, 0, 0, 1, 0),
    "ps": ("1e-12", 0, 0, 0, 1, 0),
    "min": ("60", 0, 0, 0, 1, 0),
    "h": ("3600", 0, 0, 0, 1, 0),
    "rad": ("1", 0, 0, 0, 0, 0),
    "mrad": ("0.001", 0, 0, 0, 0, 0),
    "urad": ("1e-6", 0, 0, 0, 0, 0),
    "deg": ("1/180", 1, 0, 0, 0, 0),
    "°": ("1/180", 1, 0, 0, 0, 0),
    "arcmin": ("1/10800", 1, 0, 0, 0, 0),
    "arcsec": ("1/648000", 1, 0, 0, 0, 0),
    "gon": ("1/200", 1, 0, 0, 0, 0),
    "rev": ("2", 1, 0, 0, 0, 0),
    "turn": ("2", 1, 0, 0, 0, 0),
    "rpm": ("1/30", 1, 0, 0, -1, 0),
    "rps": ("2", 1, 0, 0, -1, 0),
    "Hz": ("1", 0, 0, 0, -1, 0),
    "mHz": ("0.001", 0, 0, 0, -1, 0),
    "kHz": ("1000", 0, 0, 0, -1, 0),
    "MHz": ("1e6", 0, 0, 0, -1, 0),
    "GHz": ("1e9", 0, 0, 0, -1, 0),
    "N": ("1", 0, 1, 1, -2, 0),
    "uN": ("1e-6", 0, 1, 1, -2, 0),
    "mN": ("0.001", 0, 1, 1, -2, 0),
    "cN": ("0.01", 0, 1, 1, -2, 0),
    "daN": ("10", 0, 1, 1, -2, 0),
    "kN": ("1000", 0, 1, 1, -2, 0),
    "MN": ("1e6", 0, 1, 1, -2, 0),
    "kgf": ("9.80665", 0, 1, 1, -2, 0),
    "lbf": ("4.4482216152605", 0, 1, 1, -2, 0),
    "Nm": ("1", 0, 1, 2, -2, 0),
    "uNm": ("1e-6", 0, 1, 2, -2, 0),
    "mNm": ("0.001", 0, 1, 2, -2, 0),
    "kNm": ("1000", 0, 1, 2, -2, 0),
    "MNm": ("1e6", 0, 1, 2, -2, 0),
    "Ncm": ("0.01", 0, 1, 2, -2, 0),
    "Nmm": ("0.001", 0, 1, 2, -2, 0),
    "Ns": ("1", 0, 1, 1, -1, 0),
    "mNs": ("0.001", 0, 1, 1, -1, 0),
    "kNs": ("1000", 0, 1, 1, -1, 0),
    "Nms": ("1", 0, 1, 2, -1, 0),
    "mNms": ("0.001", 0, 1, 2, -1, 0),
    "kNms": ("1000", 0, 1, 2, -1, 0),
    "J": ("1", 0, 1, 2, -2, 0),
    "uJ": ("1e-6", 0, 1, 2, -2, 0),
    "mJ": ("0.001", 0, 1, 2, -2, 0),
    "kJ": ("1000", 0, 1, 2, -2, 0),
    "MJ": ("1e6", 0, 1, 2, -2, 0),
    "GJ": ("1e9", 0, 1, 2, -2, 0),
    "W": ("1", 0, 1, 2, -3, 0),
    "uW": ("1e-6", 0, 1, 2, -3, 0),
    "mW": ("0.001", 0, 1, 2, -3, 0),
    "kW": ("1000", 0, 1, 2, -3, 0),
    "MW": ("1e6", 0, 1, 2, -3, 0),
    "GW": ("1e9", 0, 1, 2, -3, 0),
    "Pa": ("1", 0, 1, -1, -2, 0),
    "mPa": ("0.001", 0, 1, -1, -2, 0),
    "hPa": ("100", 0, 1, -1, -2, 0),
    "kPa": ("1000", 0, 1, -1, -2, 0),
    "MPa": ("1e6", 0, 1, -1, -2, 0),
    "GPa": ("1e9", 0, 1, -1, -2, 0),
    "bar": ("1e5", 0, 1, -1, -2, 0),
    "mbar": ("100", 0, 1, -1, -2, 0),
    "A": ("1", 0, 0, 0, 0, 1),
    "nA": ("1e-9", 0, 0, 0, 0, 1),
    "uA": ("1e-6", 0, 0, 0, 0, 1),
    "mA": ("0.001", 0, 0, 0, 0, 1),
    "kA": ("1000", 0, 0, 0, 0, 1),
    "C": ("1", 0, 0, 0, 1, 1),
    "nC": ("1e-9", 0, 0, 0, 1, 1),
    "uC": ("1e-6", 0, 0, 0, 1, 1),
    "mC": ("0.001", 0, 0, 0, 1, 1),
    "V": ("1", 0, 1, 2, -3, -1),
    "nV": ("1e-9", 0, 1, 2, -3, -1),
    "uV": ("1e-6", 0, 1, 2, -3, -1),
    "mV": ("0.001", 0, 1, 2, -3, -1),
    "kV": ("1000", 0, 1, 2, -3, -1),
    "ohm": ("1", 0, 1, 2, -3, -2),
    "uohm": ("1e-6", 0, 1, 2, -3, -2),
    "mohm": ("0.001", 0, 1, 2, -3, -2),
    "kohm": ("1000", 0, 1, 2, -3, -2),
    "Mohm": ("1e6", 0, 1, 2, -3, -2),
    "Ω": ("1", 0, 1, 2, -3, -2),
    "uΩ": ("1e-6", 0, 1, 2, -3, -2),
    "mΩ": ("0.001", 0, 1, 2, -3, -2),
    "kΩ": ("1000", 0, 1, 2, -3, -2),
    "MΩ": ("1e6", 0, 1, 2, -3, -2),
    "F": ("1", 0, -1, -2, 4, 2),
    "pF": ("1e-12", 0, -1, -2, 4, 2),
    "nF": ("1e-9", 0, -1, -2, 4, 2),
    "uF": ("1e-6", 0, -1, -2, 4, 2),
    "mF": ("0.001", 0, -1, -2, 4, 2),
    "H": ("1", 0, 1, 2, -2, -2),
    "nH": ("1e-9", 0, 1, 2, -2, -2),
    "uH": ("1e-6", 0, 1, 2, -2, -2),
    "mH": ("0.001", 0, 1, 2, -2, -2),
    "T": ("1", 0, 1, 0, -2, -1),
    "nT": ("1e-9", 0, 1, 0, -2, -1),
    "uT": ("1e-6", 0, 1, 0, -2, -1),
    "mT": ("0.001", 0, 1, 0, -2, -1),
    "Wb": ("1", 0, 1, 2, -2, -1),
    "uWb": ("1e-6", 0, 1, 2, -2, -1),
    "mWb": ("0.001", 0, 1, 2, -2, -1),
    "1": ("1", 0, 0, 0, 0, 0),
    "%": ("0.01", 0, 0, 0, 0, 0),
    "count": ("1", 0, 0, 0, 0, 0),
    "counts": ("1", 0, 0, 0, 0, 0),
}
"""Name: the exact factor, the power of pi in it, and the exponents of kg, m, s and A."""

ROUNDED = {"slug": (14.593903, 1e-7), "psi": (6894.757, 1e-7)}
"""NIST SP 811, appendix B.8, to the digits that stand there."""

ELSEWHERE = {"K", "mK", "mol", "mmol", "cd"}


def test_every_unit_is_what_the_brochure_says() -> None:
    from symdyn.scene.values.unit import units

    assert set(units()) == set(SI_BROCHURE) | set(ROUNDED) | ELSEWHERE
    for name, (factor, turns, *exponents) in SI_BROCHURE.items():
        unit = Unit.read(name)
        assert (unit.scale, unit.turns) == (Fraction(factor), turns), name
        assert unit.dimension.exponents == (*exponents, 0, 0, 0), name
        assert unit.size == pytest.approx(float(Fraction(factor)) * math.pi**turns, rel=1e-15), name
    for name, (factor, digits) in ROUNDED.items():
        assert Unit.read(name).size == pytest.approx(factor, rel=digits), name
    assert [Unit.read(name).dimension.exponents.index(1) for name in ("K", "mol", "cd")] == [4, 5, 6]


@pytest.mark.parametrize(
    ("text", "scale", "turns", "si", "dimension"),
    [
        ("kN/m", "1000", 0, "N/m", "N/m"),
        ("N m s/rad", "1", 0, "N m s/rad", "N m s"),
        ("m**2", "1", 0, "m**2", "m^2"),
        ("cm²", "1/10000", 0, "m^2", "m^2"),
        ("g mm^2", "1/1000000000", 0, "kg m^2", "kg m^2"),
        ("N*mm", "1/1000", 0, "N m", "N m"),
        ("N·m", "1", 0, "N·m", "N m"),
        ("km/h", "5/18", 0, "m/s", "m/s"),
        ("m/s/s", "1", 0, "m/s/s", "m/s^2"),
        ("s^-1", "1", 0, "s^-1", "1/s"),
        ("kN/(m s^2)", "1000", 0, "N/(m s^2)", "kg/s^4"),
        ("rev/min", "1/30", 1, "rad/s", "1/s"),
        ("mN m/deg", "9/50", -1, "N m/rad", "N m"),
        ("µm", "1/1000000", 0, "m", "m"),
        ("%", "1/100", 0, "1", "1"),
        ("(km/h)^2", "25/324", 0, "m^2/s^2", "m^2/s^2"),
        ("kg/(mm s)^2", "1000000", 0, "kg/(m^2 s^2)", "kg/(m^2 s^2)"),
        ("(N m/rad)**(-1)", "1", 0, "(N m/rad)**(-1)", "s^2/(kg m^2)"),
    ],
)
def test_products_powers_and_quotients_are_read(text: str, scale: str, turns: int, si: str, dimension: str) -> None:

    unit = Unit.read(text)

    assert (unit.scale, unit.turns, unit.si, unit.dimension.text) == (Fraction(scale), turns, si, dimension)
    assert Unit.read(unit.si).is_coherent
    assert Unit.read(unit.si).dimension == unit.dimension == Unit.read(unit.dimension.text).dimension


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("furlongz", "furlongz is no unit"),
        ("mmm", r"did you mean mm\?"),
        ("metres", r"did you mean m\?"),
        ("kph", r"did you mean km/h\?"),
        ("cc", r"did you mean cm\^3\?"),
        ("deg C", "zero of its own"),
        ("degF", "zero of its own"),
        ("°C", "zero of its own"),
        ("N/m s", "two ways"),
        ("N/", "breaks off"),
        ("*m", "nothing before"),
        ("N (m", "lacks a bracket"),
        ("N m)", "breaks off"),
        ("m^99", "beyond 9"),
        ("m^", "breaks off|is no unit"),
        ("", "is empty"),
        ("m " * 40, "is no unit"),
        ("10", "is no unit"),
        ("m 2", "is no unit"),
        ("N.m", "write N m$"),
        ("kg.m^2", r"write kg m\^2$"),
        ("N-m", "write N m$"),
        ("[N m]", "write N m$"),
        ("kgm2", r"did you mean kg m\^2\?"),
        ("kgm^2", r"did you mean kg m\^2\?"),
        ("NM", r"did you mean N m\?"),
        ("Kg", r"did you mean kg\?"),
        ("mph", r"1 mph is 1.609344 km/h"),
        ("RPM", r"did you mean rpm\?"),
        ("Ohm", r"did you mean ohm\?"),
        ("milimeter", r"did you mean mm\?"),
        ("lbs", r"did you mean lb\?"),
        ("-", "write 1, or leave it out"),
        ("[-]", "write 1, or leave it out"),
        ("none", "write 1, or leave it out"),
        ("dimensionless", "write 1, or leave it out"),
        ("m^12", "beyond 9"),
        ("m^1000", "beyond 9"),
        ("(m/s)^12", "beyond 9"),
        ("m^1.5", "no whole number, 1.5"),
        ("N*" * 30 + "m", "has 61 characters"),
    ],
)
def test_what_is_no_unit_is_refused_in_words(text: str, words: str) -> None:
    from symdyn.scene.values.unit import UnitError

    with pytest.raises(UnitError, match=words):
        Unit.read(text)


RATES = {"deg/s": 1, "deg/ms": 1000, "deg/min": Fraction(1, 60)}


def test_deg_is_a_factor_before_every_letter_that_is_called_like_a_unit() -> None:
    from symdyn.scene import Quantity, parse
    from symdyn.scene.values.folding import div, mul
    from symdyn.scene.values.grammar import check_name
    from symdyn.scene.values.quantity import FormulaError
    from symdyn.scene.values.unit import units

    apply = {"*": mul, "/": div}
    for name in units():
        letter = name.isascii() and check_name(name) is None
        for sign in "*/":
            text = f"3 deg{sign}{name}"
            if sign == "/" and f"deg/{name}" in RATES:
                assert parse(text) == mul(parse(f"{RATES[f'deg/{name}']}"), parse("pi/60")), text
            elif letter:
                assert parse(text) == apply[sign](parse("deg(3)"), Quantity.symbol(name)), text
                assert parse(text.replace(" deg", "deg")) == parse(text), text
                assert not parse(text).unit, text
            elif name in ("1", "deg"):
                assert parse(text) == parse(f"deg(3){sign}{name}"), text
            else:
                with pytest.raises(FormulaError):
                    parse(text)


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("-1/3 deg*t", "-pi/540*t"),
        ("30 deg*t + 5 deg", "pi/6*t + pi/36"),
        ("30 deg*t/s", "pi/6*t/s"),
        ("30 deg/s*t", "pi/6/s*t"),
        ("30 deg/s2", "pi/6/s2"),
        ("30 deg*s", "pi/6*s"),
        ("360 deg/T", "2*pi/T"),
        ("90 deg/2", "pi/4"),
        ("2e1deg*m", "pi/9*m"),
    ],
)
def test_a_formula_that_begins_with_degrees_is_one(text: str, formula: str) -> None:
    from symdyn.scene import parse

    assert (parse(text), parse(text).unit) == (parse(formula), "")


@pytest.mark.parametrize("unit", ["deg/s", "deg/s^2", "deg/s**2", "deg / s²", "deg/min", "deg/s/s", "deg/ms", "°/s"])
def test_rates_in_degrees_are_units(unit: str) -> None:
    from symdyn.scene import parse

    assert parse(f"30 {unit}").unit == unit


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("3 m^12", "beyond 9"),
        ("3 m^1000", "beyond 9"),
        ("2 m^1.5", "no whole number"),
        ("3 kg.m^2", r"write kg m\^2$"),
        ("3 kgm^2", r"did you mean kg m\^2\?"),
        ("3 " + "m^2 " * 20, "has 79 characters"),
        ("2*x^2", r"write 2\*x\*\*2"),
        ("5 deg + x^2", r"write 5 deg \+ x\*\*2"),
    ],
)
def test_a_value_is_told_what_is_wrong_with_its_unit(text: str, words: str) -> None:
    from symdyn.scene import parse
    from symdyn.scene.values.quantity import FormulaError

    with pytest.raises(FormulaError, match=words):
        parse(text)


def test_a_value_may_have_a_power_of_a_bracket() -> None:
    from symdyn.scene import parse

    assert parse("3 (km/h)^2") == parse("3 km^2/h^2") == parse("75/324")


def test_every_unit_that_a_word_stands_for_is_one() -> None:
    from symdyn.scene.values.unit import SPELLED

    for word, unit in SPELLED.items():
        assert Unit.read(unit.partition(" (")[0]), word


@pytest.mark.parametrize("unit", ["mm", "deg", "rpm", "lbf/in", "1/deg"])
@pytest.mark.parametrize("value", ["500", "pi/4", "sqrt(2)", "54/pi", "1/2 + pi", "pi*sqrt(2)", "2*pi", "pi**2", "0"])
def test_a_value_goes_into_si_and_back_exactly(value: str, unit: str) -> None:
    from symdyn.scene import parse
    from symdyn.scene.values.unit import in_si, out_of_si

    there = in_si(parse(value), Unit.read(unit))

    assert out_of_si(there, Unit.read(unit)) == parse(value)
    assert in_si(out_of_si(parse(value), Unit.read(unit)), Unit.read(unit)) == parse(value)


def test_cycles_are_refused_where_radians_are_asked_for_with_both_readings() -> None:

    said = Unit.read("Hz").misfit(Unit.read("rad/s"), "3")

    assert said is not None
    assert "3 cycles a second, 6*pi rad/s = 18.8496" in said
    assert "did you mean 3 rad/s?" in said
    assert Unit.read("kHz").misfit(Unit.read("Hz")) is None
    assert Unit.read("rpm").misfit(Unit.read("Hz")) is not None
    assert Unit.read("rpm").misfit(Unit.read("rad/s")) is None
    assert Unit.read("kg").misfit(Unit.read("m"), "3") == "is in kg, and m is asked for"


def test_the_page_names_every_unit() -> None:
    from symdyn.scene.values.unit import ROWS

    page = (Path(__file__).parent.parent / "docs" / "units.md").read_text(encoding="utf-8")

    for unit, prefixes in ROWS:
        assert f"`{unit.text}`" in page, unit.text
        for prefix in prefixes.split():
            line = next(line for line in page.splitlines() if line.startswith("|") and f"`{unit.text}`" in line)
            assert f"`{prefix}`" in line or f"`{prefix}{unit.text}`" in line or "usual prefixes" in line, prefix
