"""Files of JavaScript are read back as operations: what they compute is proved, what they must not say is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest
from written_files import altered, two_link_with

from symdyn.emit import emit
from symdyn.program import Program
from symdyn.verify.building import files_of
from symdyn.verify.written import READERS, printed, prove_texts


@pytest.fixture(scope="module")
def two_link() -> Program:
    return two_link_with("inverse_dynamics", "kinetic_energy")


def test_a_function_that_no_file_holds_is_missed(two_link: Program) -> None:
    files = files_of(emit(two_link, "js"))
    text = str(files.contents["two_link.mjs"])
    less = replace(files, contents={"two_link.mjs": text[: text.rindex("/**")]})  # what stands above the last function
    (found,) = prove_texts(printed(two_link, "double"), less, READERS["js"])

    assert (found.passed, found.where) == (False, "no function kinetic_energy was found")


@pytest.mark.parametrize("file", ["two_link.mjs", "two_link.js"])
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("x3 = qdd_1 + qdd_2", "x3 = qdd_1 - qdd_2", "inverse_dynamics, entry 0, line "),
        ("Math.sin(q_1)", "Math.cos(q_1)", "entry 0"),
        ("Math.sin(q_1)", "Math?.sin(q_1)", "is no function that is read here"),
        ("Math.sin(q_1)", "Math.sinh(q_1)", "is no function that is read here"),
        ("Math.sin(q_1)", "Math.sin(q_1, q_2)", "has another number of arguments"),
        ("q_1 = q[0]", "q_1 = q[1]", "entry 0"),
        ("q_1 = q[0]", "q_1 = q[2]", "reads entry 2 of q, which has 2"),
        ("q_1 = q[0]", "q_1 = q[00]", "is no place in an array"),
        ("q_1 = q[0]", "q_1 = q[-1]", "is no place in an array"),
        ("q_1 = q[0]", "q_1 = out[0]", "reads the result"),
        ("const q_2 = q[1];", "const q_1 = q[1];", "has a value already"),
        ("const q_2 = q[1];", "const Math = q[1];", "hides what is called by this name"),
        ("const q_2 = q[1];", "let q_2 = q[1];", "is no statement that is read here"),
        ("const q_2 = q[1];", "const q_2 = q[1], y = 1.0;", "is no statement that is read here"),
        ("const q_2 = q[1];", "", "has no value yet"),
        ("const x3 = qdd_1 + qdd_2;", "const x3 = qdd_1\n + qdd_2 ** 1;", "is no operation that is read here"),
        ("const x3 = qdd_1", "const x3 = 08.5 + qdd_1", "is no decimal number"),
        ("const x3 = qdd_1", "const x3 = -0.0 + qdd_1", "a zero has a sign"),
        ("const x3 = qdd_1", "const x3 = qd[0] > 1 ? 1 : qdd_1", "is no expression that is read here"),
        ("out[0] = ", "out[1] = ", "writes entry 1 of the result again"),
        ("out[0] = ", "q[0] = ", "writes to the argument q"),
        ("out[1] = x5;", "", "never writes entry 1 of the result"),
        (
            "out[1] = x5;",
            "out[1] = x5 + 0.0 * q[0];",
            "reads q after the result was written, which may be the same array",
        ),
        ("  return out;", "  return\n  out;", ""),
        ("  return out;", "  return q;", "does not return out"),
        (
            "(q, qd, qdd, params, out",
            "(qd, q, qdd, params, out",
            "takes qd, q, qdd, params, out = new Float64Array(2), not q, qd, ",
        ),
        ("new Float64Array(2)", "new Float64Array(3)", "not q, qd, qdd, params, out = new Float64Array(2)"),
        ('_check("inverse_dynamics", "q", q, 2)', '_check("inverse_dynamics", "q", q, 3)', ""),
        ("const kinetic_energy = ", "const kinetic = ", ""),
        ("const _check = ", "const Math = 1;\nconst _check = ", "something of this file is called Math"),
        ("const _check = ", "const { Math } = { Math: 1 };\nconst _check = ", "is called Math"),
        ("const _check = ", "function inverse_dynamics() {}\nconst _check = ", "is one of several called inverse"),
        ("value.length !== length", "value.length === length", ""),
    ],
)
def test_a_change_is_found_and_told(two_link: Program, old: str, new: str, told: str, file: str) -> None:
    found = altered(two_link, "js", old, new, file)

    assert not found.passed
    assert told in found.where


def test_comments_and_parentheses_change_nothing(two_link: Program) -> None:
    for old, new in (("const x3 = qdd_1", "/* a */ const x3 = (qdd_1)"), ("out[1] = x5;", "out[1] = x5; // so")):
        assert altered(two_link, "js", old, new, "two_link.mjs").verdict == "proved"
