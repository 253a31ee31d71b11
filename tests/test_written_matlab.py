"""MATLAB files are read back as operations: what they compute is proved, what they must not say is refused."""

from __future__ import annotations

from math import prod

import pytest
from written_files import altered, two_link_with

import symdyn
from symdyn.emit import emit
from symdyn.graph import Graph
from symdyn.program import Program, prepare as prepare_program
from symdyn.verify.building import files_of
from symdyn.verify.written import READERS, printed, prove_texts
from symdyn.verify.written.reading import Read


@pytest.fixture(scope="module")
def two_link() -> Program:
    return two_link_with("inverse_dynamics", "mass_matrix")


@pytest.mark.long(0)
@pytest.mark.wide("two_link", "four_bar")
@pytest.mark.parametrize("scene", ["two_link", "four_bar", "cart_pole", "puma560"])
def test_every_file_of_matlab_is_proved(scene: str) -> None:
    program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example(scene)))
    for code in (program, prepare_program(program)):
        files = files_of(emit(code, "matlab"))
        found = prove_texts(printed(code, "double"), files, READERS["matlab"], files.contents)

        assert [one.where for one in found if not one.passed] == []
        assert [name for one in found for name in one.functions] == list(files.functions)


def test_a_matrix_stands_column_by_column() -> None:
    def by_rows(*shape: int) -> tuple[int, ...]:
        entries = tuple(Graph().constant(place) for place in range(prod(shape)))
        read = Read("f", "f", entries, tuple(range(prod(shape)))).by_rows(shape)
        assert [one.value for one in read.entries] == [*read.lines]
        return read.lines

    assert by_rows(2, 3) == (0, 2, 4, 1, 3, 5)
    assert by_rows(2, 2, 2) == (0, 4, 2, 6, 1, 5, 3, 7)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("x3 = qdd_1 + qdd_2", "x3 = qdd_1 - qdd_2", "inverse_dynamics, entry 0, line "),
        ("s1 = sin(q_1)", "s1 = cos(q_1)", "is another function"),
        ("q_1 = q(1, :)", "q_1 = q(2, :)", "is another function"),
        ("q_1 = q(1, :)", "q_1 = q(0, :)", "is row 0 of q, which has 2"),
        ("q_1 = q(1, :)", "q_1 = q(3, :)", "is row 3 of q, which has 2"),
        ("q_1 = q(1, :)", "q_1 = q(:, 1)", "is no row of an array"),
        ("q_1 = q(1, :)", "q_1 = q(1)", "is no row of an array"),
        ("q_1 = q(1, :)", "q_1 = q(1, 1)", "is no whole row"),
        ("q_1 = q(1, :)", "q_1 = q(end, :)", "is no row of an array"),
        ("x4 = p_m2 .* p_h2", "x4 = p_m2 * p_h2", "takes no rows number by number"),
        ("x4 = p_m2 .* p_h2", "x4 = p_m2 .\\ p_h2", "takes no rows number by number"),
        ("x4 = p_m2 .* p_h2", "x4 = p_m2 .^ p_h2", "takes no rows number by number"),
        ("x4 = p_m2 .* p_h2", "x4 = p_m2' .* p_h2", "is no expression"),
        ("x4 = p_m2 .* p_h2", "x4 = p_m2 .* p_h2i", "has no value yet"),
        ("x4 = p_m2 .* p_h2", "x4 = 2i .* p_m2 .* p_h2", "is no decimal number"),
        ("x4 = p_m2 .* p_h2", "x4 = [p_m2 .* p_h2]", "is no expression"),
        ("x4 = p_m2 .* p_h2", "x4 = [p_m2 .* p_h2", "is no syntax"),
        ("x4 = p_m2 .* p_h2;", "x4 = p_m2 .* p_h2, ", "does not end with a semicolon"),
        ("x4 = p_m2 .* p_h2;", "x4 = p_m2 .* p_h2\n", "does not end with a semicolon"),
        ("x4 = p_m2 .* p_h2;", "x4 = p_m2 .* ... p_h2;\n p_m2;", "is another function"),
        ("x4 = p_m2 .* p_h2;", "%{\nx4 = p_m2 .* p_h2;\n%}", "has no value yet"),
        ("x4 = p_m2 .* p_h2", "x4 = sum(p_m2) .* p_h2", "is no function that is read here"),
        ("x4 = p_m2 .* p_h2", "sin = p_m2 .* p_h2", "hides what is called by this name"),
        ("x4 = p_m2 .* p_h2", "x3 = p_m2 .* p_h2", "has a value already"),
        ("x4 = p_m2 .* p_h2", "q = p_m2 .* p_h2", "has a value already"),
        ("x4 = p_m2 .* p_h2;", "x4 = p_m2 .* p_h2; clear x4;", "is no statement"),
        ("x4 = p_m2 .* p_h2;", "if 1, x4 = p_m2 .* p_h2; end;", "is no statement"),
        ("out(2, :) = x5", "out(1, :) = x5", "writes entry 1 of the result again"),
        ("out(2, :) = x5", "out(2, :) = x5 + -0.0", "a zero has a sign"),
        ("out(2, :) = x5", "out(3, :) = x5", "is row 3 of out, which has 2"),
        ("out(2, :) = x5;", "", "never writes entry 2 of the result"),
        ("zeros(2, states", "zeros(3, states", "is no result"),
        ("zeros(2, states", "ones(2, states", "is no result"),
        ("'like'", "'lik'", "fixed text"),
        ("columns_of('q', q, 2", "columns_of('q', q, 1", "fixed text"),
        ("states = 1;", "states = 2;", "does not count states"),
        ("function out = inverse_dynamics", "function out = inverse_dynamic", "none of the functions"),
        ("(q, qd, qdd, params)", "(qd, q, qdd, params)", "takes qd, q, qdd, params"),
        ("if size(value, 1) ~= rows", "if size(value, 1) == rows", "fixed text"),
        ("\nend\n", "\nend\n\nfunction y = sin(x)\n  y = x;\nend\n", "is no function that is read here"),
        ("\nend\n", "\nend\n\nfunction y = sum(x)\n  y = x;\nend\n", "fixed text"),
    ],
)
def test_what_was_changed_is_found_where_it_stands(two_link: Program, old: str, new: str, told: str) -> None:
    found = altered(two_link, "matlab", old, new, "+two_link/inverse_dynamics.m")

    assert not found.passed
    assert told in found.where


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("out(3, :) =", "out(2, :) =", "writes entry 2 of the result again"),
        ("out(4, :) = ", "out(4, :) = -", "entry 3"),
        ("reshape(out, 2, 2, states)", "reshape(out, 4, 1, states)", "is not of shape (2, 2)"),
        ("  out = reshape(out, 2, 2, states);\n", "", "returns no result of shape (2, 2)"),
    ],
)
def test_what_was_changed_of_a_matrix_is_found(two_link: Program, old: str, new: str, told: str) -> None:
    found = altered(two_link, "matlab", old, new, "+two_link/mass_matrix.m")

    assert not found.passed
    assert told in found.where


def test_what_changes_nothing_passes(two_link: Program) -> None:
    for old, new in [
        ("% Check an argument", "% See to an argument"),
        ("x4 = p_m2 .* p_h2", "x4 = p_h2 .* p_m2"),
        ("x4 = p_m2 .* p_h2;", "x9 = p_m2; % a name more\n  x4 = x9 .* p_h2;"),
        ("x4 = p_m2 .* p_h2", "x4 = p_m2 ... goes on\n    .* p_h2"),
        ("x4 = p_m2 .* p_h2", "x4 = - -p_m2 .* p_h2"),
    ]:
        assert altered(two_link, "matlab", old, new, "+two_link/inverse_dynamics.m").passed, new
