"""Files of Python are read back as operations: what they compute is proved, what they must not say is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest
from written_files import altered, two_link_with

import symdyn
from symdyn.emit import TARGETS, emit
from symdyn.program import Program, prepare as prepare_program
from symdyn.verify.building import files_of
from symdyn.verify.written import READERS, Written, printed, prove_texts

PYTHON = ("numpy", "casadi", "heyoka")


def known(program: Program, target: str, option: str = "", real: str = "double") -> tuple[Written, ...]:
    files = files_of(emit(program, target, real, option=option))
    return prove_texts(printed(program, real), files, READERS[target], files.contents)


@pytest.mark.long
@pytest.mark.wide("two_link", "four_bar-casadi")
@pytest.mark.parametrize("target", PYTHON)
@pytest.mark.parametrize("scene", ["two_link", "four_bar", "cart_pole", "puma560"])
def test_every_file_is_proved(scene: str, target: str) -> None:
    program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example(scene)))
    for code in (program, prepare_program(program)):
        for option in ("", *TARGETS[target].options):
            for real in TARGETS[target].reals:
                for one in known(code, target, option, real):
                    assert (one.verdict, one.where) == ("proved", "")
                    assert len(one.functions) == len(code.routines)


@pytest.fixture(scope="module")
def two_link() -> Program:
    return two_link_with("inverse_dynamics", "mass_matrix")


@pytest.mark.parametrize("target", PYTHON)
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("x3 = qdd_1 + qdd_2", "x3 = qdd_1 - qdd_2", "_inverse_dynamics, entry 0, line "),
        ("sin(q_1)", "cos(q_1)", "entry 0"),
        ("q_1 = q[0]", "q_1 = q[1]", "entry 0"),
        ("q_1 = q[0]", "q_1 = q[2]", "reads entry 2 of q, which has 2"),
        ("q_1 = q[0]", "q_1 = q[-1]", "is no place in an array"),
        ("q_1 = q[0]", "q_1 = q[0:1]", "is no place in an array"),
        ("q_1 = q[0]", "q_1 = tau[0]", "has no value yet"),
        ("q_1 = q[0]", "q_1 = q", "is no real number"),
        ("q_1 = q[0]", "q_1 = q_1", "has no value yet"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 / p_h2", "is another function"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 ** p_h2", "is no operation that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 // p_h2", "is no operation that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 @ p_h2", "is no operation that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = ~p_m2 * p_h2", "is no sign of a number"),
        ("x4 = p_m2 * p_h2", "x4 = 1 * p_m2 * p_h2", "is no expression that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = 1.0j * p_m2 * p_h2", "is no decimal number"),
        ("x4 = p_m2 * p_h2", "x4 = 1_0.0 * p_m2 * p_h2", "is no decimal number"),
        ("x4 = p_m2 * p_h2", "x4 = 1e999 * p_m2 * p_h2", "is too large for the type"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 * p_h2 / (q_1 - q_1)", "divides by zero"),
        ("x4 = p_m2 * p_h2", "x4 = (p_m2, p_h2)", "is no expression that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 * p_h2 if q_1 else p_m2", "is no expression that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = (x9 := p_m2) * p_h2", "is no expression that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = max(p_m2, p_h2)", "is no function that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = x5 = p_m2 * p_h2", "is no expression that is read here"),
        ("x4 = p_m2 * p_h2", "x4, x5 = p_m2 * p_h2", "is no assignment that is read here"),
        ("x4 = p_m2 * p_h2", "x4: float = p_m2 * p_h2", "is no assignment that is read here"),
        ("x4 = p_m2 * p_h2", "x4 += p_m2 * p_h2", "is no statement that is read here"),
        ("x4 = p_m2 * p_h2", "x3 = p_m2 * p_h2", "has a value already"),
        ("x4 = p_m2 * p_h2", "q = p_m2 * p_h2", "has a value already"),
        ("x4 = p_m2 * p_h2", "del x3", "is no statement that is read here"),
        ("x4 = p_m2 * p_h2", "if x3 > 0: x4 = p_m2 * p_h2", "is no statement that is read here"),
        ("x4 = p_m2 * p_h2", "global x4", "is no statement that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 * p_h2\n    return (x3, x3)", "is no statement that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = (p_m2 * p_h2", "is no syntax"),
        ("        x5,\n    )", "    )", "has 1 entries, not 2"),
        ("        x5,\n    )", "        x5\n    )[::-1]", "does not return a tuple"),
        ("        x5,\n    )", "        x5, *q\n    )", "has 3 entries, not 2"),
        ("        x5,\n    )", "        *q\n    )", "is no expression that is read here"),
        ("qd, qdd, params):\n    q_1", "qdd, qd, params):\n    q_1", "takes "),
        ("qdd, params):\n    q_1", "qdd, params=None):\n    q_1", "takes "),
        ("def _inverse_dynamics(", "async def _inverse_dynamics(", "is no plain function"),
        ("def _inverse_dynamics(", "@abs\ndef _inverse_dynamics(", "is not the one plain function"),
        ("def _inverse_dynamics(", "def _inverse_dynamic(", "fixed text"),
        ("def _inverse_dynamics(", "_inverse_dynamics = 3\n\ndef _inverse_dynamics(", "is not the one plain"),
        ('"inverse_dynamics"', '"mass_matrix"', "fixed text"),
    ],
)  # fmt: skip
def test_what_was_changed_is_found_there(two_link: Program, target: str, old: str, new: str, told: str) -> None:
    if target == "numpy" and "q_1" in old and "params" in old:
        old, new = (text.replace("    q_1", "    sin = of.sin") for text in (old, new))
    found = altered(two_link, target, old, new)

    assert not found.passed
    assert told in found.where


@pytest.mark.parametrize(
    ("target", "old", "new", "told"),
    [
        ("numpy", "sin = of.sin", "sin = of.cos", "is another function"),
        ("numpy", "sin = of.sin", "sin = on.sin", "is no function that is read here"),
        ("numpy", "sin = of.sin", "sin = of.sinh", "is no function that is read here"),
        ("numpy", "sin = of.sin", "x9 = of.sin", "is no function that is read here"),
        ("numpy", "sin = of.sin", "abs = of.sin", "hides what is called by this name"),
        ("numpy", "x4 = p_m2 * p_h2", "sin = p_m2", "has a value already"),
        ("numpy", "sin = math.sin", "sin = math.cos", "fixed text"),
        ("numpy", "cos = numpy.cos", "cos = numpy.sin", "fixed text"),
        ("casadi", "casadi.sin(q_1)", "casadi.sinh(q_1)", "is no function that is read here"),
        ("casadi", "casadi.sin(q_1)", "casadi.sin(q_1, q_2)", "has another number of arguments"),
        ("casadi", "casadi.sin(q_1)", "casadi.sin(*q_1)", "is no expression that is read here"),
        ("casadi", "casadi.sin(q_1)", "numpy.sin(q_1)", "is no function that is read here"),
        ("casadi", "x4 = p_m2 * p_h2", "casadi = p_m2 * p_h2", "hides what is called by this name"),
        ("casadi", "import casadi\n", "import numpy as casadi\nimport casadi\n", "is not imported, or something else"),
        ("casadi", "import casadi\n", "casadi = 3\n", "is not imported, or something else"),
        ("casadi", '{"q": 2, "qd": 2, "qdd": 2', '{"qd": 2, "q": 2, "qdd": 2', "fixed text"),
        ("heyoka", "heyoka.sin(q_1)", "heyoka.erf(q_1)", "is no function that is read here"),
    ],
)
def test_functions_are_those_of_the_package(two_link: Program, target: str, old: str, new: str, told: str) -> None:
    found = altered(two_link, target, old, new)

    assert not found.passed
    assert told in found.where


@pytest.mark.parametrize("target", PYTHON)
def test_what_changes_nothing_passes(two_link: Program, target: str) -> None:
    for old, new in [
        ("x4 = p_m2 * p_h2", "x4 = p_h2 * p_m2"),
        ("x4 = p_m2 * p_h2", "x9 = p_m2  # a name more\n    x4 = x9 * p_h2"),
        ("x4 = p_m2 * p_h2", "x4 = (  # in lines\n        p_m2\n        * p_h2\n    )"),
        ("x4 = p_m2 * p_h2", "x4 = --p_m2 * p_h2"),
        ("        x5,\n    )", "        x5\n    )"),
    ]:
        assert altered(two_link, target, old, new).passed, new


def test_a_builtin_is_one_unless_the_module_has_the_name(two_link: Program) -> None:
    files = files_of(emit(two_link, "numpy"))
    ((name, text),) = files.contents.items()
    for begun, told in (("", "is another function"), ("import abs\n", "is no function that is read here")):
        changed = begun.join(
            str(text).replace("c2 = cos(q_2)", "c2 = cos(q_2) * abs(1.0)", 1).partition("import math\n")
        )
        (found,) = prove_texts(printed(two_link, "double"), replace(files, contents={name: changed}), READERS["numpy"])
        assert told in found.where


def test_a_nest_too_deep_is_refused(two_link: Program) -> None:
    deep = "(" * 5000 + "p_m2" + ")" * 5000
    assert "nests its expressions too deeply" in altered(two_link, "numpy", "x4 = p_m2", f"x4 = {deep}").where
