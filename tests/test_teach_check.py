"""`check-derivation`: what symdyn prints is right, and each kind of mistake is named."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from calls import counted
from hypothesis import given, settings, strategies as st

from symdyn.algebra.form import Form, Function, Number, Sum, Symbol
from symdyn.cli import main
from symdyn.emit.print.equations_text import equations_text
from symdyn.emit.print.formula_text import Latex, text_of
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.errors import DerivationError, TeachError
from symdyn.graph import Graph, Op
from symdyn.scene import Quantity, Scene, read, read_text
from symdyn.teach.languages import language_of, languages
from symdyn.teach.student.answer import Answer, in_words
from symdyn.teach.student.derivation_check import check_derivation
from symdyn.teach.student.differences import KINDS, differences
from symdyn.teach.student.statements import find_target, read_formula, read_statements
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove

EXAMPLES = Path(__file__).parent.parent / "examples"

BOOK = r"""
$$K = \frac{1}{2} m_1 h_1^2 \dot{q}_1^2 + \frac{1}{2} m_2 \left[h_1^2 \dot{q}_1^2 + h_2^2 (\dot{q}_1^2 +
2\dot{q}_1 \dot{q}_2 + \dot{q}_2^2) + (2h_1 h_2 c q_2) (\dot{q}_1^2 + \dot{q}_1 \dot{q}_2)\right] \quad (5.32)$$
$$k_{z11} = (m_1 + m_2) h_1^2 + m_2 h_2^2 + 2m_2 h_1 h_2 c q_2 \quad (5.45)$$
$$k_{z22} = m_2 h_2^2 \quad (5.49)$$ $$k_{z12} = k_{z22} + m_2 h_1 h_2 c q_2 \quad (5.52)$$
"""  # the textbook's example 5.28, in its own notation


@pytest.fixture(scope="module")
def two_link() -> Scene:
    return read(EXAMPLES / "two_link.toml")


def told(text: str, scene: Scene, **options: object) -> str:
    return shown(check_derivation(text, scene, **options))  # type: ignore[arg-type]


def shown(answers: Iterable[Answer]) -> str:
    return "\n".join(line for answer in answers for line in in_words(answer))


# What symdyn prints, it reads


@pytest.mark.wide(5)
@pytest.mark.long
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "pendulum", "double_pendulum"])
@pytest.mark.parametrize("group", ["equations", "coefficients", "textbook"])
@pytest.mark.parametrize("angles", ["long", "short"])
def test_printed_equations_are_right(name: str, group: str, angles: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")

    text = equations_text(scene, "latex", group, angles)
    answers = check_derivation(text.partition("Multipliers:")[0], scene)  # what follows are the rows of loops

    assert len(answers) >= len(scene.velocities)
    assert all(answer.verdict == Verdict.PROVED for answer in answers)


def test_a_whole_document_and_plain_text_are_right(two_link: Scene) -> None:
    for text in (equations_text(two_link, "latex", document=True), equations_text(two_link, "text")):
        answers = check_derivation(text, two_link)

        assert {"tau1", "tau2"} <= {answer.name for answer in answers}
        assert all(answer.verdict == Verdict.PROVED for answer in answers)


def test_names_of_code_are_read_as_code_writes_them() -> None:
    renamed = re.sub(r"\ba\b(?! )", "a__b", re.sub(r"\bm\b(?! =)", "lambda_", ROD))
    scene = read_text(renamed.replace("m = {", "lambda_ = {").replace("a = {", "a__b = {"), "rod.toml")

    answers = check_derivation(equations_text(scene, "text"), scene)

    assert answers
    assert all(answer.verdict == Verdict.PROVED for answer in answers)


@pytest.mark.long
def test_decimals_that_are_rounded_are_right_to_their_digits() -> None:
    scene = read(EXAMPLES / "scara.toml")

    answers = check_derivation(equations_text(scene, "latex", "coefficients"), scene)

    assert all(answer.right for answer in answers)
    assert "k_z11: right to the digits written" in [line for answer in answers for line in in_words(answer)]


@pytest.mark.parametrize(
    ("written", "right"),
    [
        ("1.33", True),
        ("1.3333", True),
        ("1.3332", False),
        ("1.34", False),
        ("1.3", True),
        ("1", False),
        ("1.0001", False),
    ],
)
def test_the_digits_decide_whether_a_decimal_is_right(written: str, right: bool) -> None:
    scene = read_text(ROD, "rod.toml")

    (answer,) = check_derivation(f"k_z11 = {written}*m*a^2", scene)

    assert answer.right is right


ROD = """
[parameters]
m = { positive = true }
a = { positive = true }

[bodies.rod]
mass = "m"
com = ["a", 0, 0]
inertia = [0, "m*a**2/3", "m*a**2/3"]
inertia_about = "com"

[joints.hinge]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 0, 1]
"""


def test_the_textbooks_own_notation_is_read(two_link: Scene) -> None:
    assert [answer.verdict for answer in check_derivation(BOOK, two_link)] == [Verdict.PROVED] * 4


# Many ways to write what is right


@pytest.mark.parametrize(
    "text",
    [
        "k_z12 = m2*h2**2 + m2*h1*h2*cos(q2)",
        "kz12 = m2 h2 (h2 + h1 c2)",
        r"k_{z,12} = m_{2}h_{2}\left[h_2+h_1\cos{q_2}\right]",
        "k_z12 = m₂·h₂² + m₂h₁h₂cos(q₂)",
        r"k_{z12} = m_2h_2^2 + m_2h_1h_2c q_2",
        r"k_z12 = \frac12 (2 m_2 h_2^2 + 2 m_2 h_1 h_2 \cos q_2)",
        "k_z12 = m2 h2^2 + m2 h1 h2 (cos(q1) cos(q1+q2) + sin q1 sin(q1 + q2))",
        "k_z12 = k_z22 + m2 h1 h2 cos q2",
        "k_G1 = m1 g h1 sin q1 + m2 g (h1 sin q1 + h2 s12)  % by hand\nk_G2 = m2 g h2 s12 # and this",
        "M_1 = k_z11 q̈₁ + k_z12 q̈₂ + k_C1 q̇₁q̇₂ + k_D12 q̇₂² + k_G1",
        "2 M_2 = 2 k_z21 q1'' + 2 k_z22 q2'' + 2 k_D21 q1'^2 + 2 k_G2",
        "k_D11 = k_D22 = 0",
        "P = m_1 g h_1 (1 - \\cos q_1) + m_2 g (h_1 + h_2 - h_1 \\cos q_1 - h_2 \\cos(q_1+q_2))",
    ],
)
def test_equivalent_forms_are_right(text: str, two_link: Scene) -> None:
    assert all(answer.right for answer in check_derivation(text, two_link))


# Each kind of mistake has its words


@pytest.mark.long
@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("k_z22 = m_1 h_2^2", "wrong symbol: m1*h2**2 should be m2*h2**2: m2 in place of m1"),
        ("k_z11 = (m1+m1) h1^2 + m2 h2^2 + 2 m2 h1 h2 c2", "m1*h1**2 should be m2*h1**2: m2 in place of m1"),
        ("k_z11 = (m1+m2) h1^2 + m2 h2 + 2 m2 h1 h2 c2", "wrong power: m2*h2 should be m2*h2**2"),
        ("k_z12 = m2 h2^2 - m2 h1 h2 c2", "wrong sign: -m2*h1*h2*cos(q2) should be m2*h1*h2*cos(q2)"),
        ("k_z11 = (m1+m2) h1^2 + m2 h2^2 + m2 h1 h2 c2", "yours is 0.5 times that"),
        ("k_z12 = m2 h2^2 + m2 h1 h2 s2", "wrong function: m2*h1*h2*sin(q2) should be m2*h1*h2*cos(q2)"),
        ("k_G2 = m2 g h2 sin q2", "wrong angle: m2*h2*g*sin(q2) should be m2*h2*g*sin(q1 + q2)"),
        ("k_z12 = m2 h2^2", "missing: m2*h1*h2*cos(q2)"),
        ("k_z22 = m2 h2^2 + 3 m1 h1^2", "does not belong here: 3*m1*h1**2"),
        ("k_C1 = 2 m_2 h_1 h_2 s q_2", "all of it has the opposite sign (the textbook's (5.40)"),
        ("M_2 = k_z21 \\ddot q_1 + k_z22 \\ddot q_2 + m2 h1 h2 s2 \\dot q_2^2 + k_G2", "q1_dot in place of q2_dot"),
        ("M_1 = k_z11 q1'' + k_z12 q2'' + k_D12 q2'^2 + k_G1", "missing: -2*m2*h1*h2*q1_dot*q2_dot*sin(q2)"),
        ("k_z11 = 1/cos(q1)", "its terms cannot be told apart"),
        ("0*M_1 = 0*q1''", "missing: -M2"),
    ],
)
def test_a_mistake_is_named(text: str, words: str, two_link: Scene) -> None:
    answers = check_derivation(text, two_link)

    assert not all(answer.right for answer in answers)
    assert words in shown(answers)


def test_one_mistake_is_told_once(two_link: Scene) -> None:
    text = "k_G1 = (m1 + m2) h1 g s1 - m2 h2 g s12"

    assert told(text, two_link).splitlines() == [
        "k_G1: different: the sign of gravity: P grows with the height, -∂P/∂q is what the weight does, and L = K - P "
        "(mass 2)",
        "  wrong sign: -m2*h2*g*sin(q1 + q2) should be m2*h2*g*sin(q1 + q2)",
    ]


@pytest.mark.long(0)
def test_the_books_signs_are_right_when_asked_for(two_link: Scene) -> None:
    text = r"M_1 = k_{z11}\ddot q_1 + k_{z12}\ddot q_2 - k_{C1}\dot q_1\dot q_2 - k_{D12}\dot q_2^2 + k_{G1}"

    for own, book in ((text, True), ("k_C1 = 2 m_2 h_1 h_2 s q_2", True)):
        assert all(answer.right for answer in check_derivation(own, two_link, book=book))
        assert not all(answer.right for answer in check_derivation(own, two_link))


def test_an_equation_without_drive_is_found() -> None:
    scene = read(EXAMPLES / "cart_pole.toml")

    text = r"2 l \ddot\theta = 3 (g \sin\theta + \cos\theta \, \ddot x)"

    assert told(text, scene) == "equation 2: right; it is the scene's equation times a factor"


def test_numbers_of_the_scene_are_right_in_place_of_their_symbols() -> None:
    cart = read(EXAMPLES / "cart_pole.toml")  # g = 9.81
    right = told("k_G2 = -1/2 m_p g l sin(theta)", cart)
    assert right.startswith("k_G2: right (proved")
    assert told("k_G2 = -1/2 m_p 9.81 l sin(theta)", cart) == "k_G2: right, with the scene's number for g"
    assert told("k_G2 = -1/2 m_p 9.82 l sin(theta)", cart).startswith("k_G2: different")
    assert told("k_G2 = -1/2 m_c g l sin(theta)", cart).startswith("k_G2: different")


# Rows of constraints


HINGE = r"""
\begin{align}
a \cos\phi + b \cos(\phi + \psi) &= d + c \cos\chi \\
-a \dot\phi \sin\phi - b (\dot\phi + \dot\psi) \sin(\phi + \psi) + c \dot\chi \sin\chi &= 0 \\
- 2 a \dot\phi \cos\phi - 2 b (\dot\phi + \dot\psi) \cos(\phi + \psi) + 2 c \dot\chi \cos\chi &= 0 \\
a (\ddot\phi \cos\phi - \dot\phi^2 \sin\phi) + b (\ddot\phi + \ddot\psi) \cos(\phi + \psi)
  - b (\dot\phi + \dot\psi)^2 \sin(\phi + \psi) &= c \ddot\chi \cos\chi - c \dot\chi^2 \sin\chi
\end{align}
"""  # by hand, in the axes of the ground


@pytest.fixture(scope="module")
def four_bar() -> Scene:
    return read(EXAMPLES / "four_bar.toml")


@pytest.mark.wide("four_bar", "rsup-latex")
@pytest.mark.long
@pytest.mark.parametrize("format", ["latex", "text"])
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "rsup", "spatial_slider_crank"])
def test_printed_rows_are_right(name: str, format: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    answers = check_derivation(equations_text(scene, format), scene)

    names = [answer.name for answer in answers]
    rows = sum(name.endswith(f"row {k}") for name in names for k in range(1, 9))
    assert rows >= 6
    assert all(answer.right for answer in answers)


@pytest.mark.long
def test_rows_by_hand_are_right_in_any_axes(four_bar: Scene) -> None:
    assert [line.partition(":")[0::2] for line in told(HINGE, four_bar).split("\n")] == [
        (f"{level} row", " right: it vanishes wherever the loops are closed (in numbers, at assembled positions)")
        for level in ("position", "velocity", "velocity", "acceleration")
    ]
    row = "c*sin(phi + psi - chi)*phi_dot + d*sin(phi + psi)*phi_dot"
    rest = "(d*sin(phi + psi) + c*sin(phi + psi - chi) - a*sin(psi))*psi_dot - c*sin(phi + psi - chi)*chi_dot"
    assert (
        told(f"d*({row} + {rest}) = 0", four_bar) == "velocity row 1: right; it is the scene's equation times a factor"
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "a*sin(phi) + b*sin(phi+psi) = d*sin(chi)",
            "along y, axes of the ground: different\n  wrong symbol: -d*sin(chi)",
        ),
        ("a*cos(phi) + b*cos(psi) = d + c*cos(chi)", "wrong angle: b*cos(psi) should be b*cos(phi + psi)"),
        (
            "a*cos(phi) + b*cos(phi+psi) = c*cos(chi)",
            "position of hinge along x, axes of the ground: different\n  missing: -d",
        ),
        ("a*phi'*cos(phi) + b*phi'*cos(phi+psi) = c*chi'*cos(chi)", "missing: b*psi_dot*cos(phi + psi)"),
        ("a*phi'*sin(phi) + b*(phi'+psi')*cos(phi+psi) = c*chi'*cos(chi)", "wrong function: a*phi_dot*sin(phi)"),
        ("a - a = 0", "different"),
        ("0*phi' = 0", "different"),
    ],
)
def test_a_mistake_in_a_row_is_named(text: str, words: str, four_bar: Scene) -> None:
    assert words in told(text, four_bar)


@pytest.mark.long
def test_equal_lengths_are_no_equal_symbols() -> None:
    scene = read(EXAMPLES / "four_bar.toml")
    alike = tuple(replace(p, value=Quantity.number(3)) if p.name == "c" else p for p in scene.parameters)
    same = replace(scene, parameters=alike)  # b = c = 3
    assert check_derivation("a*sin(phi) + b*sin(phi+psi) = c*sin(chi)", same)[0].right
    assert "b in place of c" in told("a*sin(phi) + c*sin(phi+psi) = c*sin(chi)", same)


# What cannot be read


@pytest.mark.parametrize(
    ("text", "where", "message"),
    [
        ("k_z11 = m1 + (h2", "1:14", "this ( is not closed"),
        ("k_z22 = m2 h2^2\nk_z11 = m1 + h7", "2:14", "h7 is no symbol of two_link; did you mean h"),
        (r"k_z11 = \cos q_2^2", "1:17", "does the exponent belong to cos or to its angle"),
        (r"k_z11 = \foo", "1:9", r"\foo is not known here"),
        (r"k_z11 = \left[ m_1 \right)", "1:26", ") closes [; ] is expected"),
        ("m1 h1", "1:1", "the left-hand side is missing"),
        ("k_z11 = m1^h1", "1:12", "an exponent is an integer"),
        ("k_z11 = m1 h1^2 +", "1:18", "the formula breaks off"),
        ("k_z11 = m1/0", "1:11", "division by zero"),
        ("k_z11 = __import__('os')", "1:9", "an index is missing"),
        ("k_z11 = m1 ? h1", "1:12", "'?' has no place in a formula"),
        ("k_z11 = mgh", "1:9", "mgh is no symbol of two_link"),
        (r"k_z11 = \frac{m_1}", "1:19", "breaks off"),
        (r"k_z11 = \dot m_1", "1:14", "m1 has no such derivative"),
        ("k_z33 = m1", "1:1", "k_z33 is no symbol"),
        ("k_z11 = sin", "1:9", "sin of what"),
    ],
)
def test_a_fault_has_its_place(text: str, where: str, message: str, two_link: Scene) -> None:
    with pytest.raises(TeachError) as fault:
        read_statements(text, two_link, "homework.tex")

    first, shown, caret = str(fault.value).split("\n")
    assert first.startswith(f"homework.tex:{where}: ")
    assert message in first
    line, column = map(int, where.split(":"))
    assert shown == f"  {text.splitlines()[line - 1]}"
    assert caret == " " * (column + 1) + "^"


@pytest.mark.parametrize(
    "text",
    [
        *("(" * 5000, "m1^32" * 2000, "9" * 3000, "a" * 40_000, "m1m2" * 9000, "m1 " * 30_000, "-" * 3000, "{" * 3000),
        *("9**9**9", "9^{9^{9}}", "m1^999999999", "1e999", "1e40*1e40", "((9^{32})^{32})^{32}", "m1\0", "\ud800"),
        "=" * 99,
    ],
    ids=lambda text: ascii(text[:12]),
)
def test_hostile_texts_are_refused_soon(text: str, two_link: Scene) -> None:
    with counted() as calls, pytest.raises(TeachError):
        read_statements(f"k_z11 = {text}", two_link)
    assert calls.number < 1_000_000


@pytest.mark.long
@pytest.mark.wide(3)
@pytest.mark.parametrize(
    "text",
    [
        *("(m1 + m2 + h1 + h2 + g)^{32}", "(((1 + m1)^{32})^{32})^{32}", "((9 m1)^{32})^{32}"),
        *("(sin q1 + cos q2 + sin q2 + cos q1 + m1)^{32}", "(1 + q1)^{32} " * 40, "sin(" * 50 + "q1" + ")" * 50),
        *(r"\frac{1}{1 + " * 50 + "m1" + "}" * 50, "cos(" + " + ".join(["q1", "q2"] * 40) + ")"),
    ],
    ids=lambda text: text[:12],
)
def test_formulas_that_grow_are_answered_soon_and_briefly(text: str, two_link: Scene) -> None:
    with counted() as calls:
        answer = told(f"k_z11 = {text}", two_link)
    assert answer.startswith("k_z11: different")
    assert max(map(len, answer.split("\n"))) < 1500
    assert calls.number < 3_000_000


def test_coordinates_by_number_are_read(two_link: Scene) -> None:
    assert told(r"k_{G,2} = m_2 g h_2 \sin(\theta_1 + \theta_2)", two_link).startswith("k_G2: right")
    cart = read(EXAMPLES / "cart_pole.toml")
    own = read_formula(r"\ddot x + \dot\theta", cart)
    assert read_formula(r"\ddot q_1 + \dot{q}_2", cart) == own


SIGNS = (
    r"m1 m_2 h1 q_1 \dot q' \ddot{q}_2 \frac {2} { } ( ) [ ] \left( \right) \sin cos c_{12} s ^ ^2 ** * / + - = 2 0,5"
)
MARKS = (
    r"1e3 _ _{1} \\ & $ \begin{align} \end{align} \underbrace \lvert \rvert \sqrt \, k_z11 M_1 tau2 K θ̇ ½ ² ₁ % # , . ;"
)
PIECES = (*SIGNS.split(), *MARKS.split(), "é", "\x00", "\n", " ")


@pytest.mark.long
@settings(max_examples=60)
@given(st.lists(st.sampled_from(PIECES), max_size=14))
def test_any_text_is_read_or_refused(pieces: list[str]) -> None:
    scene = read(EXAMPLES / "two_link.toml")
    for text in ("k_z11 = " + " ".join(pieces), "".join(pieces)):
        with suppress(TeachError):
            read_statements(text, scene, "x")


LEAVES = st.sampled_from(["m1", "h2", "q1", "q2_dot", "q1_ddot"]).map(Symbol) | st.integers(1, 9).map(
    lambda n: Number(Fraction(n, 4))
)
FORMS = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner, min_size=2, max_size=3).map(Form.sum)
        | st.lists(inner, min_size=2, max_size=3).map(Form.product)
        | st.tuples(inner, st.integers(2, 3)).map(lambda pair: pair[0].power(pair[1]))
        | inner.map(lambda form: Form.product((Number.MINUS_ONE, form)))
        | st.tuples(st.sampled_from([Op.SIN, Op.COS]), inner).map(lambda pair: Function(pair[0], (pair[1],)))
    ),
    max_leaves=8,
)


@pytest.mark.long
@settings(max_examples=60)
@given(FORMS)
def test_what_is_printed_is_read_back(form: Form) -> None:
    scene = read(EXAMPLES / "two_link.toml")
    printed = [text_of(form), Latex(latex_symbols(scene), None).unbroken(form)]

    graph = Graph()
    nodes = [read_formula(text, scene).express(graph) for text in printed]
    right = form.express(graph)
    findings = prove(
        [Claim(text, "read", "form", (node,), (right,)) for text, node in zip(printed, nodes, strict=True)]
    )

    assert all(finding.verdict != Verdict.DIFFERENT for finding in findings[1]), printed


# The table of words, and the verb


def test_languages_say_the_same_things() -> None:
    from string import Formatter

    places = {
        language: {key: {name for _, name, _, _ in Formatter().parse(text) if name} for key, text in table.items()}
        for language in languages()
        for table in [language_of(language).answers]
    }

    assert places["sk"] == places["en"]
    assert set(KINDS) <= set(places["en"])


def test_exit_status_tells_right_from_different_from_unreadable(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene, file = str(EXAMPLES / "two_link.toml"), tmp_path / "mine.txt"
    for text, status in (("k_z22 = m2 h2^2", 0), ("k_z22 = m1 h2^2", 1), ("k_z22 = m3 h2^2", 2)):
        file.write_text(text, encoding="utf-8")

        assert main(["check-derivation", str(file), scene, "--language", "sk"]) == status
    output = capsys.readouterr()
    assert "nesprávny symbol: m1*h2**2 má byť m2*h2**2: m2 namiesto m1" in output.out
    assert output.err.startswith("symdyn: mine.txt:1:9: m3 is no symbol of two_link")
    file.write_bytes(b"\xff\xfe\x00")
    assert main(["check-derivation", str(file), scene]) == 2
    assert main(["check-derivation", str(tmp_path / "none.txt"), scene]) == 2
    file.write_text("m2 h2^2", encoding="utf-8")
    assert main(["check-derivation", str(file), scene, "--what", "k_z22"]) == 0
    assert main(["check-derivation", str(file), scene, "--what", "k_z99"]) == 2


def test_a_target_is_found_by_any_spelling(two_link: Scene) -> None:
    assert find_target("k_{C,1,12}", two_link) == find_target("k_C1", two_link) == find_target("kC112", two_link)


def test_a_part_that_stands_in_many_places_is_looked_at_once() -> None:
    form: Form = Symbol("m1")
    for _ in range(200):  # 2^200 places
        form = Sum((form, form))

    with pytest.raises(DerivationError, match="too many terms"):
        differences(form, Number.ZERO, read(EXAMPLES / "pendulum.toml"))


@pytest.mark.parametrize(("term", "fits"), [("m R^2 phi'", True), ("m R phi'", False), ("m R^2 phi'^2", False)])
def test_units_are_told_beside_a_prescribed_motion(term: str, fits: bool) -> None:
    """A unit is found from a point and the same one in other units, both on the prescribed motion."""
    hoop = read(Path(__file__).parent / "data/found/hoop_driven.toml")

    (answer,) = check_derivation(f"dL/dtheta_dot = m R^2 theta' + {term}", hoop)

    assert ("units do not fit" in "".join(in_words(answer))) is not fits
