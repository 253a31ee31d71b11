"""Files of Rust are read back as operations: what they compute is proved, what they must not say is refused."""

from __future__ import annotations

import pytest
from written_files import altered, two_link_with

from symdyn.program import Program


@pytest.fixture(scope="module")
def two_link() -> Program:
    return two_link_with("inverse_dynamics", "kinetic_energy")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("x3 = qdd_1 + qdd_2", "x3 = qdd_1 - qdd_2", "inverse_dynamics, entry 0, line "),
        ("sincos(&[q_1, q_2])", "sincos(&[q_2, q_1])", "entry 0"),
        ("sincos(&[q_1, q_2])", "sincos(&[q_1; 2])", "is no "),
        ("sincos(&[q_1, q_2])", "sincos(&[q_1])", "is place 1 of a local array of 1"),
        ("(sine1, cosine1)", "(cosine1, sine1)", "entry 0"),
        ("q_1 = q[0]", "q_1 = q[1]", "entry 0"),
        ("q_1 = q[0]", "q_1 = q[2]", "reads entry 2 of q, which has 2"),
        ("q_1 = q[0]", "q_1 = q[00]", "is no place in an array"),
        ("q_1 = q[0]", "q_1 = out[0]", "reads the result"),
        ("let q_1 = q[0]", "let mut q_1 = q[0]", "may change"),
        ("let q_1 = q[0]", "let q = q[0]", "is an argument"),
        ("let q_1 = q[0]", "let q_1 = q[0]; let fma = q_1", "is no name that is given here"),
        ("let q_1 = q[0]", "let q_1 = unsafe { q[0] }", "is no expression that is read here"),
        ("let q_1 = q[0]", "q[0] = 1.0; let q_1 = q[0]", "writes to the argument q"),
        ("let q_1 = q[0];", "", "has no value yet"),
        ("let x3 = qdd_1", "let x3 = 1.0 % qdd_1", "is no operation that is read here"),
        ("let x3 = qdd_1", "let x3 = 1.0f32 + qdd_1", "is no decimal number"),
        ("let x3 = qdd_1", "let x3 = -0.0 + qdd_1", "a zero has a sign"),
        ("let x3 = qdd_1", "return; let x3 = qdd_1", "is no statement that is read here"),
        ("out[0] = ", "out[1] = ", "writes entry 1 of the result again"),
        ("out[1] = x5;", "", "never writes entry 1 of the result"),
        ("out[1] = x5;", "out[1] = x5; out[0]", "is no statement that is read here"),
        (
            "q: &[f64; 2], qd: &[f64; 2], qdd",
            "qd: &[f64; 2], q: &[f64; 2], qdd",
            "takes qd, q, qdd, params, out, not q, qd, ",
        ),
        ("q: &[f64; 2]", "q: &[f64; 3]", "has no q of 2 entries"),
        ("out: &mut [f64; 2]", "out: &mut [f64; 3]", "has no out of 2 entries"),
        ("pub fn kinetic_energy", "pub fn kinetic", ""),
        ("fn fma(", "fn fmb(", "is no function that is read here"),
        ("a * b + c", "a * b - c", ""),
    ],
)
def test_a_change_is_found_and_told(two_link: Program, old: str, new: str, told: str) -> None:
    found = altered(two_link, "rust", old, new)

    assert not found.passed
    assert told in found.where


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("for k in 0..64 {", "for k in 0..63 {", "is no loop over the states of a block"),
        ("= qd[0][k]", "= qd[0][0]", "is no entry of a state"),
        ("= qd[0][k]", "= qd[1][k]", "inverse_dynamics_block, entry 0"),
        ("sincos(&q[0])", "sincos(&q[1])", "inverse_dynamics_block, entry 0"),
        ("(w[0], w[1])", "(w[1], w[0])", "inverse_dynamics_block, entry 0"),
        ("let mut w = [[0.0; 64]", "let mut w = [[1.0; 64]", "is no memory that is read here"),
        ("out[first + k][i] = found[i][k]", "out[first + k][i] = found[i][i]", ""),
    ],
)
def test_a_change_of_a_block_is_found_and_told(two_link: Program, old: str, new: str, told: str) -> None:
    found = altered(two_link, "rust", old, new, option="batch")

    assert not found.passed
    assert told in found.where


def test_comments_and_parentheses_change_nothing(two_link: Program) -> None:
    for old, new in (("let x3 = qdd_1", "/* a */ let x3 = (qdd_1)"), ("out[1] = x5;", "out[1] = x5; // so")):
        assert altered(two_link, "rust", old, new).verdict == "proved"
