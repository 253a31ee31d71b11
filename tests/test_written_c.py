"""C files are read back as operations: what they compute is proved, what they must not say is refused."""

from __future__ import annotations

import re
from dataclasses import replace
from math import nextafter

import pytest
from arms import chain
from written_files import altered, two_link_with

import symdyn
from symdyn.emit import TARGETS, emit
from symdyn.program import Program, prepare as prepare_program
from symdyn.verify.building import files_of
from symdyn.verify.written import READERS, Written, printed, prove_texts

SCENES = ("two_link", "four_bar", "cart_pole")


def program_of(scene: str) -> Program:
    return symdyn.program.lower(symdyn.dynamics.derive(symdyn.example(scene)))


def proved(program: Program, option: str = "", real: str = "double") -> tuple[Written, ...]:
    files = files_of(emit(program, "c", real, option=option))
    return prove_texts(printed(program, real), files, READERS["c"])


@pytest.fixture(scope="module")
def two_link() -> Program:
    return two_link_with("inverse_dynamics", "mass_matrix")


@pytest.mark.long
@pytest.mark.wide("two_link", "four_bar-batch-double")
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("option", ["", *TARGETS["c"].options])
@pytest.mark.parametrize("scene", SCENES)
def test_every_file_of_c_is_proved(scene: str, option: str, real: str) -> None:
    program = program_of(scene)
    for code in (program, prepare_program(program)):
        found = proved(code, option, real)

        assert {one.verdict for one in found} <= {"proved", ""}, found
        names = [routine.function.name for routine in code.routines]
        assert {f"{scene}_{name}" for name in names} <= {one for file in found for one in file.functions}
        text = str(emit(code, "c", real, option=option)[found[0].file])
        blocks = {f"{name}_block" for name in names if f"void {name}_block(" in text}
        assert blocks <= set(found[0].functions)
        assert bool(blocks) == (option == "batch")


@pytest.mark.long(0)
def test_long_functions_are_read_through_their_parts() -> None:
    program = symdyn.program.lower(symdyn.dynamics.derive(chain(90), ["gravity_forces", "inverse_dynamics"]))

    assert "_part1" in str(emit(program, "c")["chain90.c"])
    assert proved(program)[0].verdict == proved(program, "batch")[0].verdict == "proved"


@pytest.mark.long(0)
def test_parts_leave_out_zeros_that_are_there_before() -> None:
    program = symdyn.program.lower(
        symdyn.dynamics.derive(symdyn.example("quadruped"), ["inverse_dynamics_derivatives"])
    )
    cleared = "    memset(r, 0, sizeof r);\n"

    assert not re.search(r"out\[[0-9]+\] = 0;", str(emit(program, "c")["quadruped.c"]).replace("0.0", "0"))
    assert proved(program)[0].verdict == proved(program, "batch")[0].verdict == "proved"
    assert "reads a place of a local array that was not written" in altered(program, "c", cleared, "").where
    assert "sets no array to zero" in altered(program, "c", cleared, cleared.replace("0", "1")).where


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("x3 = qdd_1 + qdd_2", "x3 = qdd_1 - qdd_2", "two_link_inverse_dynamics, entry 0, line "),
        ("s1 = sin(q_1)", "s1 = cos(q_1)", "entry 0"),
        ("q_1 = q[0]", "q_1 = q[1]", "entry 0"),
        ("= q[0]", "= q[2]", "reads entry 2 of q, which has 2"),
        ("out[1] =", "out[0] =", "writes entry 0 of the result again"),
        ("out[1] = x5;", "", "never writes entry 1 of the result"),
        ("q_1 = q[0]", "q_1 = q_1", "has no value yet"),
        ("const double x3", "const float x3", "is not double"),
        ("const double x3", "double x3", "is no array of a known length"),
        ("x3 = qdd_1 + qdd_2", "x3 = qdd_1 % qdd_2", "is no operation that is read here"),
        ("x3 = qdd_1 + qdd_2", "x3 = 1 / 2 * (qdd_1 + qdd_2)", "is no sum or product of whole numbers"),
        ("x3 = qdd_1 + qdd_2", "x3 = (x2, qdd_1 + qdd_2)", "is no expression"),
        ("x3 = qdd_1 + qdd_2", "sin = qdd_1", "hides what is called by this name"),
        ("x3 = qdd_1 + qdd_2", "x2 = qdd_1", "has a value already"),
        ("    out[0] =", "    if (x3 > 1.0) return;\n    out[0] =", "is no statement"),
        ("out[1] = x5;", "out[1] = x5 + 0.0 * q[0];", "after the result was written, which may be the same array"),
        ("void two_link_mass_matrix", "void two_link_matrix", "fixed text"),
        ("#include <math.h>", "#define sin cos", "fixed text"),
        ("{\n    const double q_1", "{\n#define x3 x2\n    const double q_1", "is no statement"),
        ("x3 = qdd_1 + qdd_2;", "x3 = qdd_1 + qdd_2", "is no syntax"),
    ],
)
def test_what_was_changed_is_found_where_it_stands(two_link: Program, old: str, new: str, told: str) -> None:
    found = altered(two_link, "c", old, new)

    assert not found.passed
    assert told in found.where


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("k < 64; k++) {\n        const double s1", "k < 63; k++) {\n        const double s1", "as many states"),
        ("sincos_rows(2, 64, stride, q + 0 *", "sincos_rows(2, 64, stride, q + 1 *", "reads entry 2 of q, which has 2"),
        ("sincos_rows(2, 64, stride, q + 0 *", "sincos_rows(2, 64, stride, qd + 0 *", "is another function"),
        ("sincos_rows(2, 64, stride", "sincos_rows(2, 32, stride", "as many states"),
        ("sincos_rows(2, 64, stride", "sincos_rows(2, 64, reach", "is no entry of a state"),
        ("sincos_rows(2, 64", "sincos_rows(1, 64", "was not written"),
        ("out[0 * reach + k] =", "out[1 * reach + k] =", "again"),
        ("out[1 * reach + k] =", "out[1 * stride + k] =", "is no entry of a state"),
        ("qdd[0 * stride + k]", "qdd[0 * stride]", "is no entry of a state"),
        ("    while (k < n) {", "    while (k <= n) {", "fixed text"),
        ("n[j] * 1.5707963267341256", "n[j] * 1.5707963267341258", "fixed text"),
        ("SYMDYN_ALIGNED double w[6][64]", "SYMDYN_ALIGNED double w[5][64]", "is row 5 of a local array of 5"),
    ],
)
def test_what_was_changed_in_blocks_is_found_too(two_link: Program, old: str, new: str, told: str) -> None:
    found = altered(two_link, "c", old, new, option="batch")

    assert not found.passed
    assert told in found.where


@pytest.mark.parametrize("joints", [4, 12])
def test_which_row_of_a_block_an_entry_is_is_read(joints: int) -> None:
    program = symdyn.program.lower(symdyn.dynamics.derive(chain(joints), ["mass_matrix"]))
    files = files_of(emit(program, "c", option="batch"))
    name = f"chain{joints}.c"
    text = str(files.contents[name])
    table = re.search(r"mass_matrix_places\[[0-9]+\] = \{(.*)\};", text)
    assert table is not None
    numbers = table[1].split(", ")

    def told(*changed: str) -> Written:
        contents = {**files.contents, name: text.replace(table[1], ", ".join(changed))}
        return prove_texts(printed(program, "double"), replace(files, contents=contents), READERS["c"])[0]

    assert told(*numbers).passed
    assert "is another function" in told(numbers[1], *numbers[1:]).where
    assert "has other entries than mass_matrix_places says" in told("999", *numbers[1:]).where
    assert "is no table of places" in told("0x1", *numbers[1:]).where


def test_the_same_function_rounded_otherwise_is_another_file(two_link: Program) -> None:
    found = altered(two_link, "c", "p_h1 * (p_m1 + p_m2) * x1", "(p_m1 + p_m2) * (p_h1 * x1)")

    assert "is the same function by other operations" in found.where


def test_a_comment_may_say_anything(two_link: Program) -> None:
    assert altered(two_link, "c", "Do not edit;", "Edited:").passed


def test_one_unit_in_the_last_place_of_a_constant_is_found() -> None:
    program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example("puma560"), ["gravity_forces"]))
    files = files_of(emit(program, "c"))
    text = str(files.contents["puma560.c"])
    digits = next(re.finditer(r"(?<![\w.])\d+\.\d{3,}(?![\w.])", text[text.index("#include") :]))[0]
    changed = {"puma560.c": text.replace(digits, repr(nextafter(float(digits), 9.0)))}
    found = prove_texts(printed(program, "double"), replace(files, contents=changed), READERS["c"])[0]

    assert found.verdict == "fails"
