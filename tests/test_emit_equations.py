"""Printed equations say what the graph says, fit the page, and look the same every time."""

from __future__ import annotations

import math
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from patience import HANG

from symdyn import lambdify
from symdyn.algebra.form import Function, Number, Power, Product, Sum, Symbol
from symdyn.algebra.numeric import Floats
from symdyn.dynamics.closed_forms.closed_form import closed_form
from symdyn.dynamics.mechanism.lagrange import Energies
from symdyn.emit.print.breaking import BREAK, LINE, break_lines, latex_width
from symdyn.emit.print.equations_text import FORMATS, GROUPS, equations_text
from symdyn.emit.print.formula_text import Latex, shorthands, significant, text_of
from symdyn.emit.print.printed_names import PrintName, latex_symbols, latex_unit
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, Graph, Op, evaluate, reachable
from symdyn.scene import Quantity, Scene, parse, read
from symdyn.scene.scene_files import Starter
from symdyn.scene.toml import read_text
from symdyn.scene.values import Parameter

EXAMPLES = Path(__file__).parent.parent / "examples"
SMALL = ["pendulum", "two_link", "cart_pole", "double_pendulum", "scara"]


def example(name: str) -> Scene:
    return read(str(EXAMPLES / f"{name}.toml"))


def number_of(name: str) -> float:
    """Return a value for a symbol that depends on its name only."""
    return 0.2 + sum(ord(letter) * (k + 3) for k, letter in enumerate(name)) % 97 / 60


def float_values(nodes: list[Expr]) -> list[float]:
    values = {x: number_of(str(x.value)) for x in reachable(nodes) if x.op is Op.SYMBOL}
    return evaluate(nodes, Floats(), values)


def paragraphs(text: str) -> list[str]:
    return re.sub(r"\n +", " ", text).splitlines()


@pytest.mark.parametrize("name", SMALL)
def test_text_read_back_has_the_values_of_the_graph(name: str) -> None:
    scene, graph = example(name), Graph()
    forces = Energies.of(scene, graph).driving_forces()  # drive = left-hand side - Q
    printed = [line.split(" = ") for line in paragraphs(equations_text(scene, "text"))]
    assert len(printed) == len(scene.moving)
    for joint, (left, right), force in zip(scene.moving, printed, forces, strict=True):
        drive = Quantity.symbol(joint.drive) if joint.drive else Quantity.number(0)
        balance = parse(left).express(graph) - parse(right).express(graph) + drive.express(graph)
        shown, derived = float_values([balance, force])
        assert shown == pytest.approx(derived, rel=1e-9, abs=1e-9)


def test_coefficients_read_back_have_their_values() -> None:
    closed, graph = closed_form(example("puma560")), Graph()
    lines = [line.split(" = ") for line in paragraphs(equations_text(closed, "text", "coefficients"))]
    printed = {name: expression for *names, expression in lines for name in names}
    for i in range(closed.n):
        for j in range(closed.n):
            for kind, name in (("k_z", f"k_z{i + 1}{j + 1}"), ("k_D", f"k_D{i + 1}{j + 1}")):
                nodes = [closed.form(kind, i, j).express(graph), parse(printed[name]).express(graph)]
                expected, shown = float_values(nodes)
                assert shown == pytest.approx(expected, rel=1e-12), name


def execute(text: str) -> dict[str, Any]:
    """Return what a SymPy program defines, read as its reader would: after `from sympy import *`."""
    space: dict[str, Any] = {}
    exec("from sympy import *", space)
    known = set(space)
    exec(text, space)
    return {name: value for name, value in space.items() if name not in known or name in "IESN"}


def value_of_sympy(expression: Any) -> float:
    import sympy

    symbols = sorted(expression.free_symbols, key=str)
    return sympy.lambdify(symbols, expression, "math")(*(number_of(str(x)) for x in symbols))


@pytest.mark.long
@pytest.mark.parametrize("group", ["equations", "textbook"])
def test_sympy_text_executed_has_the_values_of_the_graph(group: str) -> None:
    scene, graph = example("scara"), Graph()
    forces = Energies.of(scene, graph).driving_forces()
    defined = execute(equations_text(scene, "sympy", group))
    for i, force in enumerate(forces, 1):
        value = value_of_sympy(defined[f"equation{i}"].lhs)
        assert value == pytest.approx(float_values([force])[0], rel=1e-12)


def renamed(names: dict[str, str]) -> Scene:
    """Return the two-link arm with other names for its parameters."""
    text = (EXAMPLES / "two_link.toml").read_text(encoding="utf-8")
    for old, new in names.items():
        text = re.sub(rf"\b{old}\b", new, text)
    return read_text(text, "renamed.toml")


NAMESAKES = [
    {"m1": "I", "m2": "E", "h1": "S", "h2": "N"},
    {"m1": "Eq", "m2": "Rational", "h1": "symbols", "h2": "equation1", "M1": "Matrix", "g": "k_z11"},
]


@pytest.mark.parametrize("names", NAMESAKES, ids=["I, E, S, N", "words of the program"])
def test_sympy_text_gives_back_every_coefficient_whatever_parameters_are_called(names: dict[str, str]) -> None:
    import sympy

    scene = renamed(names)
    closed = closed_form(scene)
    defined = execute(equations_text(closed, "sympy", "coefficients"))
    for i in range(2):
        for j in range(2):
            name = "k_z11_" if "g" in names and (i, j) == (0, 0) else f"k_z{i + 1}{j + 1}"
            assert defined[name] == closed.sympy("k_z", i, j)
            assert defined[f"k_D{i + 1}{j + 1}"] == closed.sympy("k_D", i, j)
    assert sympy.Symbol(names["m1"], positive=True) in defined["k_G1"].free_symbols
    assert sympy.Symbol(names["m2"], positive=True) in defined["k_G2"].free_symbols


def test_sympy_text_keeps_numbers_exact() -> None:
    import sympy

    closed = closed_form(example("scara"))
    defined = execute(equations_text(closed, "sympy", "coefficients"))

    assert defined["k_z11"] == closed.sympy("k_z", 0, 0)
    assert not defined["k_z11"].atoms(sympy.Float)


def test_sympy_matrices_executed_are_the_coefficients() -> None:
    closed = closed_form(example("two_link"))
    defined = execute(equations_text(closed, "sympy", "matrix"))

    assert [[defined["M"][i, j] for j in (0, 1)] for i in (0, 1)] == [
        [closed.sympy("k_z", i, j) for j in (0, 1)] for i in (0, 1)
    ]
    assert list(defined["g_"]) == [closed.sympy("k_G", i) for i in (0, 1)]  # g is a parameter
    assert defined["equation"].rhs == defined["tau"]


def braked(name: str) -> Scene:
    """Return an example with a long force in its first joint."""
    scene = example(name)
    force = " - ".join(f"d{k}*tanh(q1_dot/{k + 1})*exp(-q2_dot**2/{k + 2})" for k in range(12))
    parameters = (*(Parameter(f"d{k}") for k in range(12)), *scene.parameters)
    first, *others = scene.joints
    return replace(scene, joints=(replace(first, forces=(parse(force),)), *others), parameters=parameters)


@pytest.mark.parametrize("group", GROUPS)
def test_no_line_of_text_is_wider_than_a_terminal(group: str) -> None:
    page = equations_text(braked("scara"), "text", group)

    assert ("d11*tanh(" in page) == (group != "coefficients")
    assert max(map(len, page.splitlines())) <= 110


@pytest.mark.parametrize("group", ["equations", "textbook"])
def test_a_long_force_fits_the_page(group: str) -> None:
    lines = equations_text(braked("two_link"), "latex", group).splitlines()

    assert any("d_{11}" in line for line in lines)
    for line in lines:
        if "underbrace" not in line:
            assert latex_width(line.removesuffix(r" \\")) < LINE + 15, line


@pytest.mark.long
def test_equations_that_nobody_could_read_are_refused_with_the_way_out() -> None:
    with pytest.raises(DerivationError, match=r"symdyn generate writes .*\.sympy\('k_z', 0, 0\) gives a single"):
        equations_text(read_text(Starter("chain").from_template("chain", 20), "chain.toml"), "text")


def test_coefficients_name_what_vanishes() -> None:
    lines = equations_text(example("two_link"), "text", "coefficients").splitlines()

    assert lines[0] == "k_z11 = (m1 + m2)*h1**2 + m2*h2**2 + 2*m2*h1*h2*cos(q2)"
    assert "k_C2_12 = 0" in lines
    assert "k_D11 = k_D22 = 0" in lines


def test_the_textbook_grouping_is_that_of_5_40() -> None:
    text = equations_text(example("two_link"), group="textbook")

    assert r"\underbrace{((m_1 + m_2) h_1^2 + m_2 h_2^2 + 2 m_2 h_1 h_2 \cos q_2)}_{k_{z,11}}\, \ddot q_1" in text
    assert r"- \underbrace{2 m_2 h_1 h_2 \sin q_2}_{-k_{C,1,12}}\, \dot q_1 \dot q_2" in text
    assert r"\underbrace{m_2 h_1 h_2 \sin q_2}_{k_{D,21}}\, \dot q_1^2" in text


def test_short_notation_writes_sines_by_joint_number() -> None:
    text = equations_text(example("two_link"), "text", "coefficients", "short")

    assert "k_G2 = m2*" in text
    assert "*s12" in text
    assert "sin" not in re.sub("#.*", "", text)
    assert "S_{12}" in equations_text(example("two_link"), "latex", "matrix", "short")  # c_2 is an entry of c


LETTERED = """
[parameters]
m = { value = 2 }
c2 = { value = 3 }
s1 = { value = 0.4 }
[bodies.upper]
mass = "m"
com = ["s1", 0, 0]
[bodies.lower]
mass = "m"
com = ["s1", 0, 0]
[joints.hip]
type = "revolute"
parent = "ground"
child = "upper"
axis = [0, 1, 0]
coordinate = "q1"
[joints.knee]
type = "revolute"
parent = "upper"
child = "lower"
axis = [0, 1, 0]
origin = ["s1", 0, 0]
coordinate = "q2"
damping = "c2"
"""


@pytest.mark.parametrize("group", GROUPS)
def test_short_notation_leaves_a_scene_its_letters_and_says_what_its_own_are(group: str) -> None:
    scene = read_text(LETTERED, "lettered")
    text = equations_text(scene, "text", group, "short")
    legend = dict(line[2:].split(" = ") for line in text.splitlines() if line.startswith("#"))
    moved = {"q1": 0.3, "q2": -0.8, "q1_dot": 1.1, "q2_dot": 0.7, "q1_ddot": -0.4, "q2_ddot": 2.0}
    known = {"m": 2.0, "c2": 3.0, "s1": 0.4, **moved, "sin": math.sin, "cos": math.cos}
    drives = lambdify(scene, "inverse_dynamics")(*np.reshape([*moved.values()], (3, 2)))
    known |= dict(zip(("tau1", "tau2"), drives, strict=True))
    known |= {name: eval(form, known) for name, form in legend.items()}

    words = {*re.findall(r"[A-Za-z]\w*", re.sub("#.*", "", text))}
    assert {"S2", "C2", "C12"} <= words
    assert {word for word in words if re.fullmatch(r"[SC]\d+", word)} == {*legend}
    for form, mark in (("latex", "% "), ("sympy", "# ")):
        lines = equations_text(scene, form, group, "short").splitlines()
        assert len([line for line in lines if line.startswith(mark)]) == len(legend), form
    if group == "equations":
        for line in paragraphs(text)[:2]:
            left, right = line.split(" = ")
            assert eval(left, known) == pytest.approx(eval(right, known), abs=1e-12)


def test_short_notation_without_letters_left_is_written_out() -> None:
    for name in ("S4", "S_4"):
        scene = read_text(LETTERED.replace("m = {", f"{name} = {{").replace('"m"', f'"{name}"'), "lettered")
        text = equations_text(scene, "text", angles="short")

        assert "sin(q2)" in text
        assert "#" not in text


def test_short_notation_tells_joints_of_two_digits_apart() -> None:
    q1, q11, q12 = (Symbol(f"q{k}") for k in (1, 11, 12))
    forms = [Function(Op.SIN, (angle,)) for angle in (Sum((q1, q12)), Sum((q11, Symbol("q2"))))]
    found = shorthands(Sum(tuple(forms)), {"q1": 1, "q2": 2, "q11": 11, "q12": 12}, "sc")

    assert [str(one.name) for one in found.values()] == ["s1_12", "s11_2"]


def test_passive_joints_and_declared_forces_stand_on_the_right() -> None:
    scene = example("two_link")
    shoulder, elbow = scene.joints
    damped = replace(elbow, drives=(None,), forces=(parse("-d*q2_dot"),))
    free = replace(shoulder, drives=(None,))
    scene = replace(scene, joints=(free, damped), parameters=(*scene.parameters, Parameter("d")))
    first, second = paragraphs(equations_text(scene, "text"))

    assert first.endswith(" = 0")
    assert second.endswith(" = -d*q2_dot")


PRINTED = {
    "q1": "q_1",
    "I1xx": "I_{1,xx}",
    "Ixx1": "I_{1,xx}",
    "theta1": r"\theta_1",
    "alpha0": r"\alpha_0",
    "al0": "a_{l,0}",
    "mp": "m_p",
    "mass2": r"\mathit{mass}_2",
    "omega_max": r"\omega_{\mathrm{max}}",
    "m12": "m_{12}",
    "lc1": "l_{c,1}",
    "stiffness": r"\mathit{stiffness}",
    "g": "g",
}


@pytest.mark.parametrize("name", PRINTED)
def test_names_of_code_become_symbols_of_print(name: str) -> None:
    assert str(PrintName.of_code(name)) == PRINTED[name]


def test_accents_sit_on_the_head_of_a_symbol() -> None:
    symbols = latex_symbols(example("two_link"))

    assert symbols["q1_dot"] == r"\dot q_1"
    assert symbols["q2_ddot"] == r"\ddot q_2"


def test_two_names_never_look_alike() -> None:
    scene = Scene("s", (Parameter("m1"), Parameter("m_1"), Parameter("k", latex=r"\kappa")))

    assert latex_symbols(scene) == {"m1": "m_1", "m_1": r"\mathtt{m\_1}", "k": r"\kappa"}


def test_units_stand_upright() -> None:
    assert latex_unit("kg m^2") == r"\mathrm{kg}\,\mathrm{m}^{2}"
    assert latex_unit("m/s^2") == r"\mathrm{m}/\mathrm{s}^{2}"
    assert latex_unit("m/s²") == latex_unit("m/s^2")
    assert latex_unit("kg·m²/(rad s⁻¹)") == r"\mathrm{kg}\,\mathrm{m}^{2}/(\mathrm{rad}\,\mathrm{s}^{-1})"
    assert latex_unit("%") == r"\mathrm{\%}"


def test_a_unit_that_is_no_product_of_powers_stands_as_text() -> None:
    assert latex_unit("counts_per_turn") == r"\text{counts\_per\_turn}"
    assert latex_unit("€/kg") == r"\text{?/kg}"


A, B, Q = Symbol("a"), Symbol("b"), Symbol("q1")
SPELLED = [
    (Product((Number(parse("-1/2").value), A, B)), "-0.5*a*b", r"-\tfrac{1}{2} a b"),
    (Power(Sum((A, B)), 2), "(a + b)**2", "(a + b)^2"),
    (Product((A, Power(B, -1))), "a/b", r"\frac{a}{b}"),
    (Power(B, -2), "1/b**2", r"\frac{1}{b^2}"),
    (Product((A, Power(Product((B, Q)), -1))), "a/(b*q1)", r"\frac{a}{b q_1}"),
    (Power(Product((Sum((A, B)), Sum((B, Q)))), -1), "1/((a + b)*(b + q1))", r"\frac{1}{(a + b) (b + q_1)}"),
    (Power(Function(Op.SIN, (Sum((Q, A)),)), 2), "sin(q1 + a)**2", r"\sin^2(q_1 + a)"),
    (Product((Number(parse("-1").value), Sum((A, B)), Q)), "-(a + b)*q1", "-(a + b) q_1"),
    (Sum((A, Product((Number(parse("-1").value), Sum((A, B)))))), "a - (a + b)", "a - (a + b)"),
    (Function(Op.SQRT, (A,)), "sqrt(a)", r"\sqrt{a}"),
]


@pytest.mark.parametrize(("form", "text", "latex"), SPELLED, ids=[text for _, text, _ in SPELLED])
def test_brackets_and_signs_are_right(form: Product | Power | Sum, text: str, latex: str) -> None:
    spelled = text_of(form)
    assert spelled == text
    assert Latex({})(form).replace(BREAK, "") == latex
    assert float_values([parse(spelled).express(Graph())]) == pytest.approx(
        float_values([parse(text).express(Graph())])
    )


def test_numbers_are_rounded_to_significant_digits() -> None:
    assert significant(parse("0.123456789").value, 6) == "0.123457"
    assert significant(parse("0.9999999").value, 6) == "1"
    assert significant(parse("0.0000123456789").value, 3) == "1.23e-5"


def test_lines_break_outside_brackets_where_they_can() -> None:
    text = f"aaaaaaaaaaaaaa {BREAK}+ bb(c {BREAK}+ d) {BREAK}+ e"

    assert break_lines(text, 24, 20, len) == ["aaaaaaaaaaaaaa", "+ bb(c + d) + e"]
    assert break_lines(text, 40, 20, len) == ["aaaaaaaaaaaaaa + bb(c + d) + e"]


@pytest.mark.parametrize("name", ["two_link", "scara", "puma560"])
@pytest.mark.parametrize("group", GROUPS)
def test_every_line_fits_the_page(name: str, group: str) -> None:
    body = equations_text(example(name), "latex", group)
    lines = [line for line in body.splitlines() if not line.startswith((r"\begin", r"\end", "where", "%"))]

    assert lines
    for line in lines:
        if "bmatrix" not in line and "underbrace" not in line:
            assert latex_width(line.removesuffix(r" \\")) < LINE + 15, line


@pytest.mark.runs("pdflatex")
@pytest.mark.parametrize(
    ("name", "group"), [("two_link", "textbook"), ("double_pendulum", "matrix"), ("puma560", "coefficients")]
)
def test_documents_compile_without_overfull_lines(name: str, group: str, tmp_path: Path) -> None:
    text = equations_text(example(name), group=group, document=True)
    (tmp_path / "page.tex").write_text(text, encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False, timeout=HANG)
    log = done.stdout.decode("utf-8", "replace")

    assert done.returncode == 0, log[-2000:]
    assert "Overfull" not in log
    assert (tmp_path / "page.pdf").stat().st_size > 10_000


def test_a_document_lists_every_symbol_with_its_unit() -> None:
    text = equations_text(example("two_link"), document=True)

    assert r"$m_1$ & point mass at the end of link 1 & $\mathrm{kg}$" in text
    assert r"$q_2$ & coordinate of joint elbow, revolute & $\mathrm{rad}$" in text
    assert r"$M_1$ & driving torque of joint shoulder & $\mathrm{N}\,\mathrm{m}$" in text


def test_closed_forms_print_like_their_scene() -> None:
    scene = example("two_link")

    assert equations_text(closed_form(scene)) == equations_text(scene)


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ({"format": "pdf"}, "format 'pdf' is not known; there are latex, text, sympy"),
        ({"group": "all"}, "group 'all' is not known; there are equations, coefficients, textbook, matrix"),
        ({"angles": "tiny"}, "angles 'tiny' is not known; there are long, short"),
        ({"format": "text", "document": True}, "a document is written in LaTeX, not as text"),
    ],
)
def test_unknown_choices_say_what_would_work(choice: dict[str, str], message: str) -> None:
    with pytest.raises(EmitError, match=re.escape(message)):
        equations_text(example("pendulum"), **choice)  # type: ignore[arg-type]


SCRIPT = """
import sys
from symdyn.emit.print.equations_text import FORMATS, GROUPS, equations_text
from symdyn.scene import read
for name in sys.argv[1:]:
    scene = read(name)
    for group in GROUPS:
        print(equations_text(scene, 'latex', group, document=True), equations_text(scene, 'text', group))
print('sympy' in sys.modules, 'numpy' in sys.modules)
"""


def run_script(seed: str) -> str:
    files = [str(EXAMPLES / f"{name}.toml") for name in ("two_link", "scara")]
    environment = {**os.environ, "PYTHONHASHSEED": seed}
    command = [sys.executable, "-c", SCRIPT, *files]
    return subprocess.run(command, capture_output=True, text=True, check=True, env=environment, timeout=HANG).stdout


@pytest.mark.slow
@pytest.mark.runs
def test_the_same_bytes_under_any_hash_seed_and_no_sympy_for_latex() -> None:
    first = run_script("1")

    assert first == run_script("2")
    assert first.splitlines()[-1] == "False False"


@pytest.mark.parametrize("format_", FORMATS)
@pytest.mark.parametrize("group", GROUPS)
def test_every_format_has_every_grouping(format_: str, group: str) -> None:
    assert "h1" in equations_text(example("two_link"), format_, group).replace("h_1", "h1")
