"""Symbols and numbers as a reader meets them: told apart, readable, and right where they are raised to a power."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
from hostile import scene_with

from symdyn.algebra.form import Power, Symbol
from symdyn.emit.print.equations_text import equations_text
from symdyn.emit.print.formula_text import Latex
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.scene import parse, read
from symdyn.scene.toml import read_text

EXAMPLES = Path(__file__).parent.parent / "examples"

ROBOT = """<?xml version="1.0"?>
<robot name="r"><link name="base"/><link name="arm"><inertial><origin xyz="0.0123456789 0.0987654321 -0.123456781"/>
<mass value="3.1415926535"/>
<inertia ixx="0.31234567891" ixy="0" ixz="0" iyy="0.32345678901" iyz="0" izz="0.31234567891"/>
</inertial></link><joint name="j1" type="revolute"><parent link="base"/><child link="arm"/>
<origin xyz="0.123456789 0 0.333333333" rpy="0.12345678 0 0"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>
"""


@pytest.mark.mends("5.6")
def test_accelerations_of_a_turned_body_are_dotted_letters_not_words() -> None:
    shown = latex_symbols(read(EXAMPLES / "heavy_top.toml"))

    assert shown["point_wx"] == r"\omega_{x,\mathrm{point}}"
    assert shown["point_wx_dot"] == r"\dot{\omega}_{x,\mathrm{point}}"
    assert not [latex for latex in shown.values() if re.search(r"dot\{\\mathit", latex)]


@pytest.mark.mends("5.6")
def test_a_dot_above_a_word_keeps_clear_of_the_dots_of_its_letters() -> None:
    mathml = pytest.importorskip("symdyn.teach.mathematics")

    assert 'accent="true"' not in mathml.inner(r"\dot{\mathit{slide}}")
    assert 'accent="true"' in mathml.inner(r"\dot{x}")


@pytest.mark.mends("4.digits")
def test_no_number_in_plain_text_has_more_digits_than_a_double_holds(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    path.write_text(ROBOT)
    scene = read(path)

    for group in ("equations", "coefficients", "matrix"):
        text = equations_text(scene, "text", group)
        numbers = re.findall(r"(?<![\w.])\d+\.?\d*", text)
        assert max(len(number.replace(".", "").strip("0")) for number in numbers) <= 15, group
        for line in text.splitlines():
            assert all(parse(side) for side in line.split(" = ")[1:])


@pytest.mark.mends("4.digits")
def test_a_table_of_symbols_shows_what_a_long_formula_is_worth() -> None:
    value = "cos(3/10)**2*(0.1234567891*sin(1/5)**2 + 0.98765432198765)"
    document = equations_text(read_text(scene_with({}).replace("m = {", f'm = {{ value = "{value}",')), document=True)

    (row,) = [line for line in document.splitlines() if line.startswith("  $m$ ")]
    worth = math.cos(0.3) ** 2 * (0.1234567891 * math.sin(0.2) ** 2 + 0.98765432198765)
    assert row.endswith(rf"& \ensuremath{{\approx}} {worth:.6g} \\")


@pytest.mark.parametrize(
    ("latex", "square"),
    [
        pytest.param(r"k^{a}", r"(k^{a})^2", marks=pytest.mark.mends("1.4")),
        pytest.param(r"k'", r"(k')^2", marks=pytest.mark.mends("1.4")),
        pytest.param(r"\alpha\beta", r"(\alpha\beta)^2", marks=pytest.mark.mends("1.4")),
        pytest.param(r"\lambda^{(1)}", r"\bigl(\lambda^{(1)}\bigr)^2", marks=pytest.mark.mends("1.4")),
        (r"\hat{k}_{1}", r"\hat{k}_{1}^2"),
    ],
)
def test_a_symbol_with_an_upper_script_is_raised_in_brackets(latex: str, square: str) -> None:
    assert Latex({"k": latex})(Power(Symbol("k"), 2)) == square
    assert square in equations_text(read_text(scene_with({}, latex)))
