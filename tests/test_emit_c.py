"""The C files: clean under a strict compiler, in double and in float, with any name and text."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from arms import chain
from formulas import every_op
from mechanisms import random_tree

import symdyn
from symdyn.dynamics.outputs.derive import derive
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import Sources, emit, write
from symdyn.program import formulate, lower
from symdyn.runtime import build, run_python

pytestmark = [pytest.mark.runs(), pytest.mark.usefixtures("optimised")]

GCC = shutil.which("gcc") or shutil.which("cc") or shutil.which("clang")
LINT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror", "-c", "-o", "lint.o"]

needs_compiler = pytest.mark.runs("cc")


def lint(sources: Sources, folder) -> str:
    source, _ = write(sources, folder)
    ran = subprocess.run([GCC, *LINT, source.name], cwd=folder, capture_output=True, text=True, check=False)
    return ran.stderr


@needs_compiler
@pytest.mark.parametrize("real", ["double", "float"])
def test_every_operation_is_clean_c99(real, tmp_path):
    assert lint(emit(lower(every_op()), "c", real), tmp_path) == ""


@needs_compiler
@pytest.mark.parametrize("real", ["double", "float"])
def test_a_tree_is_clean_c99(real, tmp_path):
    equations = derive(random_tree(2, 4), ("inverse_dynamics", "forward_dynamics", "mass_matrix", "k_C", "pose:b3"))
    assert lint(emit(lower(equations), "c", real), tmp_path) == ""


@needs_compiler
@pytest.mark.parametrize("real", ["double", "float"])
def test_a_long_function_in_parts_is_clean_c99(real, tmp_path):
    sources = emit(lower(derive(chain(90), ("inverse_dynamics", "gravity_forces"))), "c", real)
    assert "_part4(" in sources["chain90.c"]
    assert lint(sources, tmp_path) == ""


@needs_compiler
def test_hostile_names_and_text_are_clean_c99(tmp_path):
    equations = every_op("math")
    nasty = 'ends */ int x; /* with "??/ \\ \u202e and\x07'
    functions = tuple(replace(f, text=nasty, units="*/") for f in equations.functions)
    sources = emit(lower(Equations(equations.scene, equations.graph, functions)), "c", command=nasty)
    assert list(sources) == ["math_.c", "math_.h"]
    assert lint(sources, tmp_path) == ""


@pytest.mark.runs("g++")
def test_the_header_serves_cpp(tmp_path):
    source, header = write(emit(lower(every_op()), "c"), tmp_path)
    main = "int main() { double x[2] = {0.0, 0.0}; every_op_scalar(x, x, x, x); return x[0] == 0.0 ? 0 : 1; }"
    caller = f'#include "{header.name}"\n#include "{header.name}"\n{main}\n'
    (tmp_path / "call.cpp").write_text(caller)
    subprocess.run([GCC, "-std=c99", "-c", source.name, "-o", "f.o"], cwd=tmp_path, check=True)
    subprocess.run(["g++", "-Wall", "-Werror", "call.cpp", "f.o", "-lm", "-o", "call"], cwd=tmp_path, check=True)
    subprocess.run(["./call"], cwd=tmp_path, check=True)


def test_float_code_has_no_double_in_it():
    text = emit(lower(every_op()), "c", "float")["every_op.c"]
    code = text[text.index("*/") :]
    assert "double" not in code
    assert "sinf(" in code
    assert "0.33333334f" in code


def test_the_header_names_unused_arguments_and_empty_results():
    head = emit(lower(every_op()), "c")["every_op.h"]
    assert "void every_op_empty(const double *q, const double *qd, const double *params, double *out);" in head
    assert " *   q[2]  not used" in head
    assert " *   out[0]  r, shape (1, 0)  nothing is written" in head


def test_every_output_is_written_zeros_too():
    text = emit(lower(every_op()), "c")["every_op.c"]
    body = text[text.index("void every_op_nothing") :]
    assert "out[0] = 0.0;\n    out[1] = 0.0;" in body


def test_the_sign_helper_is_there_only_when_it_is_called():
    equations = every_op()
    scalar = Equations(equations.scene, equations.graph, (equations["scalar"],))
    assert "sign_of" in emit(lower(equations), "c")["every_op.c"]
    assert "sign_of" not in emit(lower(scalar), "c")["every_op.c"]


@pytest.mark.runs("cc")
def test_parts_that_hand_nothing_on_have_work_space_all_the_same(monkeypatch):
    for where, least in (("cuts.LONGEST", 5), ("cuts.SPLIT", 0), ("plan.PIECE", 5)):
        monkeypatch.setattr(f"symdyn.emit.targets.c.{where}", least)
    program = lower(formulate(symdyn.example("free_body"), ("mass_matrix",)))
    state = [0.1, 0.2, 0.3, 0.5, 0.5, 0.5, 0.5]

    sources = emit(program, "c", option="batch")
    assert "    double w[1];\n" in sources["free_body.c"]
    wanted = run_python(emit(program)).mass_matrix(state)
    np.testing.assert_allclose(build(sources).mass_matrix(state), wanted)
