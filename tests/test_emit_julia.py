"""The Julia target: text that no Julia runs here, parsed by a grammar of others."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from formulas import every_op
from hostile import in_julia

from symdyn.dynamics import available
from symdyn.emit import emit, write
from symdyn.program import formulate, lower, prepare
from symdyn.scene import read

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.toml"))


@pytest.mark.long
@pytest.mark.wide("double_pendulum", "gripper2")
@pytest.mark.parametrize("path", EXAMPLES[::4], ids=lambda path: path.stem)
def test_a_module_is_julia_to_the_grammar(path: Path, tmp_path: Path) -> None:
    scene = read(path)
    equations = formulate(scene, available(scene)[0])
    for k, program in enumerate((lower(equations), prepare(lower(equations)), lower(equations.at_rest()))):
        (file,) = write(emit(program, "julia"), tmp_path / str(k))
        assert in_julia(file) == []


def text() -> str:
    return emit(lower(every_op()), "julia").texts["every_op.jl"]


def test_the_header_says_that_nothing_has_run_it() -> None:
    assert "# Preview: no Julia has run this text; `symdyn verify` proves " in text()


def test_results_go_into_arrays_that_are_there_or_are_made() -> None:
    made = text()
    assert "\nfunction matrix!(out, q, qd, params)\n" in made
    assert "    size(out) == (2, 3) || throw(DimensionMismatch(" in made
    assert "    return matrix!(Array{T}(undef, 2, 3), q, qd, params)\n" in made
    assert "function scalar!" not in made


def test_no_literal_makes_a_double_of_another_type() -> None:
    code = text().split("\nmodule every_op\n")[1]
    literals = re.findall(r"(.{2})\b\d+\.\d", code)
    assert len(literals) > 4
    assert {*literals} == {"T("}


def test_sine_and_cosine_of_one_angle_are_taken_together() -> None:
    assert "    s1 = sin(q_1)\n    c1_2 = cos(q_1 + q_2)\n" in text()
    program = lower(formulate(read(EXAMPLES[0].with_name("two_link.toml")), ("inverse_dynamics", "mass_matrix")))
    both, cosine = emit(program, "julia").texts["two_link.jl"].split("function mass_matrix!")
    assert "    s1, c1 = sincos(q_1)\n    s2, c2 = sincos(q_2)\n    x1 = " in both
    assert "    c2 = cos(q_2)\n" in cosine
