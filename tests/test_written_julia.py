"""Julia modules are read back as operations: what they compute is proved, what they must not say is refused."""

from __future__ import annotations

import pytest
from written_files import altered, two_link_with

from symdyn.emit import emit
from symdyn.program import Program
from symdyn.verify.building import files_of
from symdyn.verify.written import READERS, printed, prove_texts

OUTPUTS = ["inverse_dynamics", "mass_matrix", "kinetic_energy"]


@pytest.fixture(scope="module")
def two_link() -> Program:
    return two_link_with(*OUTPUTS)


def test_a_function_writes_its_result_or_returns_one_number(two_link: Program) -> None:
    files = files_of(emit(two_link, "julia"))
    (found,) = prove_texts(printed(two_link, "double"), files, READERS["julia"], files.contents)

    assert (found.verdict, found.where) == ("proved", "")
    assert found.functions == ("inverse_dynamics!", "mass_matrix!", "kinetic_energy")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("x3 = qdd_1 + qdd_2", "x3 = qdd_1 - qdd_2", "inverse_dynamics!, entry 0, line "),
        ("s1, c1 = sincos(q_1)", "c1, s1 = sincos(q_1)", "is another function"),
        ("s1, c1 = sincos(q_1)", "s1, c1, c9 = sincos(q_1)", "is no sine with its cosine"),
        ("s1, c1 = sincos(q_1)", "s1, c1 = sin(q_1), cos(q_1)", "is no sine with its cosine"),
        ("float(@inbounds q[1])", "float(@inbounds q[2])", "is another function"),
        ("float(@inbounds q[1])", "float(@inbounds q[0])", "is no entry of an array of shape (2,)"),
        ("float(@inbounds q[1])", "float(@inbounds q[3])", "is no entry of an array of shape (2,)"),
        ("float(@inbounds q[1])", "float(@inbounds q[1, 1])", "is no entry of an array of shape (2,)"),
        ("float(@inbounds q[1])", "float(@inbounds q[end])", "is no place in an array"),
        ("float(@inbounds q[1])", "float(@inbounds q[1:1])", "is no place in an array"),
        ("float(@inbounds q[1])", "float(@inbounds q)", "is no entry of an array"),
        ("float(@inbounds q[1])", "float(@fastmath q[1])", "is no entry without a look"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 .* p_h2", "is no operation that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 ÷ p_h2", "is no operation that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 \\ p_h2", "is no operation that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 % p_h2", "is no operation that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2^2", "'2' is no expression that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = 2p_m2 * p_h2", "is no expression"),
        ("x4 = p_m2 * p_h2", "x4 = -(p_m2, p_h2)", "is no sign"),
        ("x4 = p_m2 * p_h2", "x4 = 0.5 * p_m2 * p_h2", "is no expression"),
        ("x4 = p_m2 * p_h2", "x4 = T(1.5f0) * p_m2 * p_h2", "is no decimal number"),
        ("x4 = p_m2 * p_h2", "x4 = T(p_m1) * p_m2 * p_h2", "is no decimal number"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2' * p_h2", "is no expression"),
        ("x4 = p_m2 * p_h2", "x4 = (p_m2; p_h2)", "is no expression"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2 > p_h2 ? p_m2 : p_h2", "is no expression"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2\n    * p_h2", "is no s"),
        ("x4 = p_m2 * p_h2", "x4 = p_m2\n    + p_h2", "is no statement"),
        ("x4 = p_m2 * p_h2", "x4 = sinpi(p_m2) * p_h2", "is no function that is read here"),
        ("x4 = p_m2 * p_h2", "x4 = sin.(p_m2) * p_h2", "is no expression"),
        ("x4 = p_m2 * p_h2", "sin = p_m2 * p_h2", "hides what is called by this name"),
        ("x4 = p_m2 * p_h2", "T = p_m2 * p_h2", "hides what is called by this name"),
        ("x4 = p_m2 * p_h2", "x3 = p_m2 * p_h2", "has a value already"),
        ("x4 = p_m2 * p_h2", "x3 += p_m2 * p_h2", "is no statement"),
        ("x4 = p_m2 * p_h2", "x4 = x9 = p_m2 * p_h2", "is no expression"),
        ("x4 = p_m2 * p_h2", "#= x4 = p_m2 * p_h2 =#", "has no value yet"),
        ("x4 = p_m2 * p_h2", "if true; x4 = p_m2 * p_h2; end", "is no statement"),
        ("out[2] = x5", "out[1] = x5", "writes entry 1 of the result again"),
        ("out[2] = x5", "out[3] = x5", "is no entry of an array of shape (2,)"),
        ("out[2] = x5", "out[2] = x5 + @inbounds(q[1])", "is no"),
        ("out[2] = x5", "out[2] = x5 + q[1]", "is no expression"),
        ("out[2] = x5", "out[2] = x5 + float(q[1])", "after the result was written"),
        ("out[2] = x5", "out[2] = x5 + T(-0.0)", "a zero has a sign"),
        ("    @inbounds out[2] = x5\n", "", "never writes entry 2 of the result"),
        ("return out", "return q", "does not return out"),
        ("length(q) == 2 ||", "length(q) >= 2 ||", "is not length(q) == 2"),
        ("length(q) == 2 ||", "length(q) == 2 &&", "is not length(q) == 2"),
        ("size(out) == (2,) ||", "size(out) == (3,) ||", "is not size(out) == (2,)"),
        ("T = float(promote_type(eltype(q), ", "T = float(promote_type(", "is not T = float("),
        ("it must have 2", "it must have 3", "fixed text"),
        ("function inverse_dynamics!(out, q, qd,", "function inverse_dynamics!(out, qd, q,", "takes out, qd, q"),
        ("function inverse_dynamics(q, qd,", "function inverse_dynamics(qd, q,", "takes qd, q"),
        ("(undef, 2), q, qd,", "(undef, 2), qd, q,", "is not return inverse_dynamics!("),
        ("(undef, 2), q, qd,", "(undef, 3), q, qd,", "is not return inverse_dynamics!("),
        ("return inverse_dynamics!(", "return mass_matrix!(", "is not return inverse_dynamics!("),
        ("module two_link\n", "module two_link\nsin(x) = x\n", "is no function, nor words"),
        ("module two_link\n", "module two_link\nfunction sin(x)\n    return x\nend\n", "fixed text"),
        ("module two_link\n", "module two_link\nusing Other\n", "is no function, nor words"),
        ('"""\n    inverse_dynamics!', '"""\n$(exit())    inverse_dynamics!', "is no function, nor words"),
        ("module two_link\n", "sin(x) = x\nmodule two_link\n", "is no file of one module"),
        ("return T(0.5)", "return T(0.25)", "kinetic_energy, entry 0"),
        ("return T(0.5)", "return", "is no syntax"),
        ("return T(0.5)", "return out; T(0.5)", "is no statement"),
        ("out[1, 2] = ", "out[2, 1] = ", "writes entry 2, 1 of the result again"),
        ("out[2, 2] = ", "out[4] = ", "is no entry of an array of shape (2, 2)"),
        ("out[2, 2] = ", "out[2, 2] = -", "mass_matrix!, entry 3"),
    ],
)
def test_what_was_changed_is_found_where_it_stands(two_link: Program, old: str, new: str, told: str) -> None:
    found = altered(two_link, "julia", old, new)

    assert not found.passed
    assert told in found.where


def test_what_changes_nothing_passes(two_link: Program) -> None:
    for old, new in [
        ("# Preview", "# See"),
        ("x4 = p_m2 * p_h2", "x4 = p_h2 * p_m2"),
        ("float(@inbounds q[1])", "(float(@inbounds q[1]))"),  # of the first statement
        ("x4 = p_m2 * p_h2", "x9 = p_m2 # a name more\n    x4 = x9 * p_h2"),
        ("x4 = p_m2 * p_h2", "x4 = (p_m2 *\n        p_h2)"),
        ("x4 = p_m2 * p_h2", "x4 = - -p_m2 * p_h2; #= here =#"),
    ]:
        assert altered(two_link, "julia", old, new).passed, new
