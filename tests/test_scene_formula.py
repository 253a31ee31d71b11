"""The formula parser: exact, canonical, bounded, and deaf to everything that is no formula."""

import math
import re
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from calls import counted
from hypothesis import given, settings, strategies as st

from symdyn.graph import Graph, Op
from symdyn.scene.values.formula import FormulaError, parse, quantity
from symdyn.scene.values.grammar import C_KEYWORDS, FORMULA_NAMES, check_name
from symdyn.scene.values.quantity import Quantity, spell
from symdyn.scene.values.unit import Unit


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1/3", Fraction(1, 3)),
        ("0.333", Fraction(333, 1000)),
        ("0.1 + 0.2", Fraction(3, 10)),
        ("1e-3", Fraction(1, 1000)),
        ("-2**2", Fraction(-4)),
        ("2**-3", Fraction(1, 8)),
        ("+(7 - 2)*3/5", Fraction(3)),
        ("123456789012345678901234567890.5", Fraction("123456789012345678901234567890.5")),
        ("sqrt(9/4)", Fraction(3, 2)),
        ("4**0.5 + 4**(1/2)", Fraction(4)),
        ("abs(-2) + sign(-3) + cos(0) + exp(0) + sin(0) + tanh(0) + log(1)", Fraction(3)),
        ("  \n 1 +\t1 ", Fraction(2)),
    ],
)
def test_rational_formulas_fold_to_exact_constants(text, value):
    assert parse(text) == Quantity.number(value)


@pytest.mark.parametrize(
    "text", ["pi/2", "0.5*pi", "pi*0.5", "90 deg", "45*2 deg", "deg(90)", "180/2 deg", "90*deg", "--90 deg"]
)
def test_a_right_angle_is_one_quantity_however_it_is_written(text):
    assert parse(text) == Quantity(Op.MUL, (Quantity.number(Fraction(1, 2)), Quantity.PI))


def test_the_suffix_deg_binds_like_a_product():
    assert parse("a + 30 deg") == parse("a + pi/6")
    assert parse("(a + 30) deg") == parse("deg(a + 30)")
    assert parse("-90 deg") == parse("-pi/2")


def test_constants_move_to_the_front_of_products():
    assert parse("m1*h1**2/12") == parse("1/12*m1*h1**2") == parse("m1*(h1*h1/12)")
    assert parse("2*m*3") == parse("6*m") == parse("m*6")
    assert parse("-(-x)") == Quantity.symbol("x")
    assert parse("0*x") == Quantity.number(0)


@pytest.mark.parametrize(
    "text",
    [
        "3 m*l",
        "3 mm + l",
        "3 mm - l*sin(l)",
        "2 kg m*l",
        "3 m/s*l",
        "3 N*l/g",
        "5 m^2/l",
        "2 N m*sin(l)",
        "3 m*rho",
    ],
)
def test_what_is_said_of_a_quantity_in_a_formula_works_word_for_word(text: str) -> None:
    """The number becomes a letter, of the value and the unit that stood there; or all of it is letters."""
    with pytest.raises(FormulaError) as caught:
        parse(text)
    said = re.search(
        r'such as a = "(.+)" in parameters, and write (.+?)(?: \(.*\))?; of symbols alone write (.+)', str(caught.value)
    )
    assert said is not None
    named, formula, letters = said.groups()

    assert parse(named).unit
    assert parse(formula) == parse(text.replace(named, "a"))
    assert set(parse(letters).symbols) == set(re.findall(r"[a-z]+(?![a-z(])", text, re.IGNORECASE)) - {"sin"}


def test_numbers_of_python_are_exact():
    assert quantity(0.1) == quantity(np.float64(0.1)) == quantity(Decimal("0.1")) == Quantity.number(Fraction(1, 10))
    assert quantity(np.int64(3)) == quantity(3) == Quantity.number(3)
    assert quantity(Fraction(1, 3)) == parse("1/3")
    assert quantity(-1.5e-7) == Quantity.number(Fraction("-1.5e-7"))


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        *((one, "") for one in ("sin 2t", "sin 2*q1", "sin w t", "sin q1/2", "sin x cos y", "sin x**2")),
        ("ln 2q1", ""), ("arcsin x", ""),
        *((one, "**") for one in ("sin^-1(x)", "sin^2 q1", "q1^2t", "e^2t", "sin(q1)^2cos(q1)", "x^2;y")),
        ("sin x - cos 2t", ""), ("2 - sin q1", "2 - sin(q1)"), ("3 q1^2 t", "3*q1**2*t"), ("3*2^x t", "3*2**x*t"),
        ("10%*x", "a*x"), ("(2 + sin x)*t", "(2 + sin(x))*t"),
    ],
)  # fmt: skip
def test_no_product_is_offered_that_may_mean_something_else(text: str, cure: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text)
    offered = re.findall(r"write ([^;]+)", str(caught.value))
    assert offered == [cure] * bool(cure)
    assert cure in ("", "**") or parse(cure)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "it is empty"),
        ("m1*", "breaks off at its end"),
        ("1 2", "breaks off"),
        ("30 deg 2", "is no unit"),
        ("12 kg + 3 kg", "a unit stands behind a number alone"),
        ("3 furlongz", "furlongz is no unit"),
        ("3 deg C", "zero of its own"),
        ("x^2", r"\^ is not a power; write x\*\*2"),
        ("x // 2", "// is not known; write /"),
        ("x % 2", "'%' has no place"),
        ("1,5", "write decimals with a point"),
        ("a.b", "a dot may stand inside a number only"),
        ("x < y", r"write if\(x < y, 1, 0\)"),
        ("if(x > 0, 1)", "if takes a condition and 2 values"),
        ("if(x == 0, 1, 2)", "'=' has no place"),
        ("if(x > 0, 1, 2) and y", "a condition is not a number"),
        ("max(x)", "max takes 2 or more arguments"),
        ("asin(2)", r"asin\(2\) is not real; take it of a number from -1 to 1"),
        ("(-2)**1.5", r"\(-2\)\*\*\(3/2\) is not real"),
        ("0**-1.5", "divides by zero"),
        ("f(x)", "the function f is not known"),
        ("sinus(x)", "did you mean sin"),
        ("sin", r"write sin\(x\)"),
        ("sin(x, y)", "sin takes 1 argument"),
        ("atan2(x)", "atan2 takes 2 arguments"),
        ("sin(x=1)", "'=' has no place"),
        ("(x)(y)", "write \\* for a product"),
        ("x**65", "integer up to 64"),
        ("9**9**9", "integer up to 64"),
        ("0x10", "not a decimal number"),
        ("1_000", "not a decimal number"),
        ("3j", "not a decimal number"),
        ("1/0", "divides by zero"),
        ("x/(1 - 1)", "divides by zero"),
        ("0**-1", "divides by zero"),
        ("sqrt(-2)", r"sqrt\(-2\) is not real"),
        ("log(0)", "not real"),
        ("inf", "not a finite number"),
        ("NaN", "not a finite number"),
        ("1e400", "beyond"),
        ("1e999999999", "beyond what a double can hold"),
        ("1e308*10", "beyond the largest double"),
        ("10**-64**1*1e-300**64", "too many digits"),
        ("((10**64)**64)**64", "too many digits"),
        ("((x**64)**64)**64", "too many terms"),
        ("(" * 3000, "breaks off|nests"),
        ("-" * 9000 + "1", "nests too deep"),
        ("+".join("a" * 200), "nests deeper than 150"),
        ("1" * 10_001, "10001 characters; 10000 are allowed"),
        ("ａ", "has no place"),
        ("__import__('os')", "has no place"),
        ("x if y else z", "a choice is a function; write if"),
        ("lambda: 1", "has no place"),
        ("not x", "only numbers, names"),
    ],
)
def test_what_is_no_formula_is_refused_with_a_reason(text, message):
    with counted() as calls, pytest.raises(FormulaError, match=message):
        parse(text)
    assert calls.number < 100_000


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (True, "true or false; give a number"),
        (None, "is nothing"),
        (math.nan, "not a finite number"),
        (-math.inf, "not a finite number"),
        (Decimal("1e999999999"), "beyond what a double can hold"),
        (10**400, "beyond the largest double"),
        ([1], "is a list"),
        ({}, "is a table"),
        (1j, "is a complex"),
    ],
)
def test_what_is_no_number_is_refused(value, message):
    with pytest.raises(FormulaError, match=message):
        quantity(value)


@pytest.mark.parametrize(
    "text", ["tan(x)", "atan2(y, x)", "x**-2", "sqrt(x)*exp(-y)", "deg(x)", "x**7", "(x - y)/(x + y)"]
)
def test_formulas_have_the_value_that_python_gives_them(text):
    values = {"x": 0.7, "y": -1.3}
    known = {"tan": math.tan, "atan2": math.atan2, "sqrt": math.sqrt, "exp": math.exp, "deg": math.radians}
    expected = eval(text, {"__builtins__": {}}, known | values)

    assert parse(text).at(values) == pytest.approx(expected, rel=1e-15)


def test_a_formula_on_the_graph_keeps_exact_angles():
    graph = Graph()

    assert parse("cos(90 deg)").express(graph) is graph.zero
    assert parse("sin(pi/6)").express(graph) is graph.constant(Fraction(1, 2))


NAMES = st.sampled_from(["x", "y", "m1", "pi"])
NUMBERS = st.one_of(st.integers(0, 99).map(str), st.decimals(0, 10, places=3).map(str))
FORMULAS = st.recursive(
    NAMES | NUMBERS,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        st.tuples(st.sampled_from(["sin", "cos", "exp", "sqrt", "-", "tan"]), inner).map(lambda t: f"{t[0]}({t[1]})"),
        st.tuples(inner, st.sampled_from(["2", "-1", "3", "0.5"])).map(lambda t: f"({t[0]})**{t[1]}"),
    ),
    max_leaves=8,
)


@pytest.mark.long(0)
@settings(max_examples=80)
@given(FORMULAS)
def test_spelling_is_the_inverse_of_parsing(text):
    try:
        formula = parse(text)
    except FormulaError:
        return
    assert parse(spell(formula)) == formula


@pytest.mark.long
@settings(max_examples=100)
@given(st.one_of(st.text(max_size=60), st.text(alphabet="xy019.e+-*/()[], \ndegpi", max_size=40)))
def test_no_text_raises_anything_but_a_formula_error(text):
    try:
        outcome = spell(parse(text))
    except FormulaError as error:
        outcome = str(error)
    assert outcome


@pytest.mark.parametrize("name", ["m1", "I1xx", "theta", "x", "M1", "arm_2", "sigma", "tau1", "q1", "gamma", "y0"])
def test_plain_names_are_good(name):
    assert check_name(name) is None


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("", "empty"),
        ("1m", "plain identifier"),
        ("left-arm", "such as left_arm"),
        ("größe", "plain identifier"),
        ("m 1", "such as m_1"),
        ("_m", "begins with _"),
        ("q1_dot", "velocity"),
        ("q1_ddot", "acceleration"),
        ("lambda", "keyword of Python; try lambda1"),
        ("m" * 61, "61 characters"),
        ("a\n", "plain identifier"),
        (3, "not text but of type int"),
        *((name, "keyword of C|keyword of Python") for name in C_KEYWORDS),
        *((name, "function or constant of formulas") for name in FORMULA_NAMES),
        ("t", "the time in formulas and runs; rename it, such as t_0"),
    ],
)
def test_names_that_no_target_can_print_are_refused(name, fault):
    assert re.search(fault, check_name(name, letter=True))


def test_a_long_text_that_begins_like_a_value_is_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each beginning of it was read as a text of its own: the time doubled with every operator."""
    asked, read = [], Unit.read
    monkeypatch.setattr(Unit, "read", lambda text: asked.append(text) or read(text))
    with pytest.raises(FormulaError):
        parse("-1.797e+308cos(-atan2(sqrt(5), 2))*" + "*".join(["(x*y + 2)"] * 40))
    assert len(asked) < 100
