"""The MATLAB target, run by Octave: columns are states, what is wrong is said by identifiers, and help is help."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from formulas import argument, every_op, function, one, states

from symdyn import example, read
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import Sources, emit, write
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op
from symdyn.program import formulate, lower, prepare
from symdyn.runtime import RUNNERS, run_python
from symdyn.runtime.machine import compile_mex
from symdyn.scene import Scene

PENDULUM = Path(__file__).parent.parent / "examples" / "pendulum.toml"
OCTAVE = shutil.which("octave-cli") or shutil.which("octave")

runs = [pytest.mark.targets, pytest.mark.runs, pytest.mark.skipif(OCTAVE is None, reason="no Octave")]
runs_mex = [*runs, pytest.mark.skipif(shutil.which("mkoctfile") is None, reason="no mkoctfile")]


def octave(sources: Sources, folder: Path, code: str) -> Any:
    """Return what code of Octave puts into `found`, with the package of sources on the path."""
    write(sources, folder)
    return octave_in(folder, code)


def octave_in(folder: Path, code: str) -> Any:
    words = [str(OCTAVE), "--quiet", "--norc", "--path", str(folder), "--eval", f"{code}; disp(jsonencode(found))"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def two_link() -> Sources:
    return emit(lower(formulate(example("two_link"), ("mass_matrix", "kinetic_energy"))), "matlab")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a package and what is compiled for it."""
    folder = tmp_path_factory.mktemp("built")
    write(emit(lower(formulate(example("two_link"), ("mass_matrix",))), "matlab", option="mex"), folder)
    compile_mex(str(folder), "two_link")
    return folder


class TestText:
    def test_a_function_is_a_file_of_a_package_which_says_what_it_holds(self) -> None:
        texts = two_link().texts
        assert [*texts] == [f"+two_link/{name}.m" for name in ("Contents", "mass_matrix", "kinetic_energy")]
        assert texts["+two_link/mass_matrix.m"].startswith(
            "function out = mass_matrix(q, params)\n% MASS_MATRIX  mass "
        )
        assert "\n%   params, 5-by-N; kg, kg, m, m, m/s^2: free parameters" in texts["+two_link/mass_matrix.m"]
        assert "\n%#codegen\n" in texts["+two_link/mass_matrix.m"]

    def test_entries_stand_as_matlab_stores_them(self) -> None:
        text = emit(lower(every_op()), "matlab").texts["+every_op/matrix.m"]
        places = [line.split(" = ")[0] for line in text.splitlines() if line.startswith("  out(")]
        assert places == [f"  out({k}, :)" for k in (1, 3, 5, 2, 4, 6)]
        assert "out = reshape(out, 2, 3, states);" in text

    def test_a_name_that_is_too_long_for_matlab_is_refused(self) -> None:
        g = Graph()
        q = [g.symbol("q1")]
        equations = Equations(Scene("hand"), g, (function("f" * 64, [argument("q", q)], (1,), q),))
        with pytest.raises(EmitError, match="a name of 64 characters; MATLAB knows no more than 63"):
            emit(lower(equations), "matlab")

    def test_a_package_is_called_like_no_word_of_the_language(self) -> None:
        g = Graph()
        q = [g.symbol("q1")]
        assert [*emit(lower(one(q, q, Scene("end"))), "matlab")] == ["+end_/Contents.m", "+end_/f.m"]

    def test_files_that_differ_in_capital_letters_alone_are_refused_on_their_way_to_a_disk(
        self, tmp_path: Path
    ) -> None:
        g = Graph()
        q = [g.symbol("q1")]
        functions = tuple(function(name, [argument("q", q)], (1,), q) for name in ("hand_a", "hand_A"))
        sources = emit(lower(Equations(Scene("hand"), g, functions)), "matlab")
        with pytest.raises(EmitError, match=r"hand_a\.m and \+hand/hand_A\.m differ in capital letters alone"):
            write(sources, tmp_path / "out")
        assert not [*tmp_path.iterdir()]


class TestMex:
    pytestmark = runs_mex

    def test_columns_are_states_and_pages_their_matrices_as_in_text(self) -> None:
        program = lower(every_op())
        module, plain = RUNNERS["matlab"].run(emit(program, "matlab", option="mex")), run_python(emit(program))
        for routine in program.routines:
            name = routine.function.name
            for count in (0, 1, 2, 15, 16, 17, 64, 65, 150):
                given = states(every_op(), name, count)
                mixed = [given[0], given[1], states(every_op(), name, 1)[2][0]]
                for values in (given, mixed):
                    np.testing.assert_allclose(
                        getattr(module, name)(*values), getattr(plain, name)(*values), rtol=1e-13, atol=1e-15
                    )

    def test_what_is_prepared_is_computed_for_many_sets_of_parameters(self) -> None:
        program = prepare(lower(formulate(example("two_link"), ("coriolis_matrix",))))
        module, plain = RUNNERS["matlab"].run(emit(program, "matlab", option="mex")), run_python(emit(program))
        params = np.random.default_rng(1).uniform(1, 2, (40, 5))
        prepared = module.prepare(params)
        np.testing.assert_allclose(prepared, plain.prepare(params), rtol=1e-15)
        q, qd = np.random.default_rng(2).uniform(-1, 1, (2, 40, 2))
        wanted = plain.coriolis_matrix(q, qd, prepared)
        np.testing.assert_allclose(module.coriolis_matrix(q, qd, prepared), wanted, rtol=1e-13, atol=1e-15)

    def test_time_is_one_number_a_state(self, tmp_path: Path) -> None:
        driven = 'units = "none"\n' + PENDULUM.read_text("utf-8").replace('"-b*q1_dot"', '"t**2-b*q1_dot"')
        (tmp_path / "driven.toml").write_text(driven, "utf-8")
        program = lower(formulate(read(tmp_path / "driven.toml"), ("forward_dynamics",)))
        assert "t" in [argument.name for argument in program.routines[0].function.arguments]
        plain = run_python(emit(program))
        for option in ("", "mex"):
            module = RUNNERS["matlab"].run(emit(program, "matlab", option=option))
            lengths = [len(a.symbols) for a in program.routines[0].function.arguments]
            scalar = [a.scalar for a in program.routines[0].function.arguments]
            rng = np.random.default_rng(3)
            given = [rng.uniform(0.5, 1, (20,) if one else (20, n)) for one, n in zip(scalar, lengths, strict=True)]
            np.testing.assert_allclose(module.forward_dynamics(*given), plain.forward_dynamics(*given), rtol=1e-12)

    @pytest.mark.parametrize(
        ("call", "fault"),
        [
            ("two_link.mass_matrix([1; 2])", "arguments two_link.mass_matrix: 1 arguments; give q, params"),
            ("two_link_mex('mass_matrix', p)", "arguments two_link.mass_matrix: 1 arguments and 0 results; it takes 2"),
            ("two_link_mex()", "name give the name of a function first, such as 'mass_matrix'"),
            ("two_link_mex('mass')", "name there is no function mass"),
            ("two_link.mass_matrix([1 2], p)", "rows two_link.mass_matrix: q is 1-by-2; it must have 2 rows, and a "),
            ("two_link.mass_matrix(ones(2, 3, 2), p)", "rows two_link.mass_matrix: q has 3 dimensions; give a matrix "),
            ("two_link.mass_matrix(ones(2, 3), ones(5, 2))", "columns two_link.mass_matrix: params has 2 columns, "),
            ("two_link.mass_matrix(single([1; 2]), p)", "type two_link.mass_matrix: q is of class single; give real "),
            ("two_link.mass_matrix([1; i], p)", "type two_link.mass_matrix: q is complex double; give real numbers, "),
            ("two_link.mass_matrix(sparse([1; 2]), p)", "type two_link.mass_matrix: q is sparse double; give real "),
            ("two_link.mass_matrix({1; 2}, p)", "type two_link.mass_matrix: q is of class cell; give real numbers, "),
        ],
    )
    def test_what_is_wrong_is_said_with_an_identifier(self, call: str, fault: str, built: Path) -> None:
        code = f"p = (1:5)'; try, {call}; catch e, found = [e.identifier ' ' e.message]; end"
        told = octave_in(built, code).replace("two_link_mex: ", "", 1)  # which Octave says first, and MATLAB does not
        assert told.startswith(f"two_link:{fault}")

    def test_the_gateway_has_no_warning(self, tmp_path: Path) -> None:
        write(emit(lower(every_op()), "matlab", option="mex"), tmp_path)
        flags = "-O1 -Wall -Wextra -Wconversion -Wno-sign-conversion -Werror -fopenmp-simd"
        done = subprocess.run(
            ["mkoctfile", "--mex", "every_op_mex.c", "every_op.c"], cwd=tmp_path, env=os.environ | {"CFLAGS": flags},
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert (done.returncode, done.stderr) == (0, "")


class TestOctave:
    pytestmark = runs

    def test_columns_are_states_and_pages_their_matrices(self, tmp_path: Path) -> None:
        code = "q = [1 2 3; 4 5 6]; p = [1; 2; 3; 4; 5]; M = two_link.mass_matrix(q, p);"
        code += (
            "found = {size(M), M(:, :, 2), size(two_link.mass_matrix(q(:, 1), p)), two_link.mass_matrix(q(:, 2), p),"
        )
        code += "size(two_link.kinetic_energy(q, q, p)), size(two_link.mass_matrix(q(:, []), p))}"
        size, second, alone, state, energies, none = octave(two_link(), tmp_path, code)
        assert (size, alone, energies, none) == ([2, 2, 3], [2, 2], [1, 3], [2, 2, 0])
        assert second == state

    def test_one_column_is_the_same_for_all_states_and_parameters_may_differ_by_state(self) -> None:
        program = lower(every_op())
        module, plain = RUNNERS["matlab"].run(emit(program, "matlab")), run_python(emit(program))
        for routine in program.routines:
            name, given = routine.function.name, states(every_op(), routine.function.name, 6)
            for mixed in ([given[0], given[1], given[2][0]], [given[0][0], given[1], given[2]], [a[:0] for a in given]):
                np.testing.assert_allclose(
                    getattr(module, name)(*mixed), getattr(plain, name)(*mixed), rtol=1e-13, err_msg=name
                )
        cube = [a.reshape(2, 3, -1) for a in given]
        np.testing.assert_allclose(module.rotated(*cube), plain.rotated(*cube), rtol=1e-13)

    def test_single_is_computed_in_single(self, tmp_path: Path) -> None:
        code = "q = single([1; 2]); p = (1:5)'; found = {class(two_link.mass_matrix(q, p)),"
        code += "class(two_link.mass_matrix(double(q), single(p))), class(two_link.mass_matrix(double(q), p)),"
        code += "max(abs(double(two_link.mass_matrix(q, p)) - two_link.mass_matrix(double(q), p))(:))}"
        *classes, off = octave(two_link(), tmp_path, code)
        assert classes == ["single", "single", "double"]
        assert 0 < off < 1e-5

    @pytest.mark.parametrize(
        ("call", "fault"),
        [
            ("([1; 2])", "arguments two_link.mass_matrix: 1 arguments; give q, params"),
            ("([1 2], p)", "rows two_link.mass_matrix: q is 1-by-2; it must have 2 rows, and a column for each state"),
            (
                "(ones(2, 3, 2), p)",
                "rows two_link.mass_matrix: q has 3 dimensions; give a matrix with a column for each",
            ),
            ("(ones(2, 3), ones(5, 2))", "columns two_link.mass_matrix: params has 2 columns, others have 3; give one"),
            ("(ones(2, 0), ones(5, 2))", "columns two_link.mass_matrix: params has 2 columns, others have 0; give one"),
            ("(int8([1; 2]), p)", "type two_link.mass_matrix: q is of class int8; give numbers, double or single"),
            ("({1; 2}, p)", "type two_link.mass_matrix: q is of class cell; give numbers, double or single"),
            ("('ab', p)", "type two_link.mass_matrix: q is of class char; give numbers, double or single"),
        ],
    )
    def test_what_is_wrong_is_said_with_an_identifier(self, call: str, fault: str, tmp_path: Path) -> None:
        code = f"p = (1:5)'; try, two_link.mass_matrix{call}; catch e, found = [e.identifier ' ' e.message]; end"
        assert octave(two_link(), tmp_path, code).startswith(f"two_link:{fault}")

    def test_what_is_no_real_number_is_nan_as_everywhere(self) -> None:
        g = Graph()
        q = [g.symbol(f"q{i}") for i in (1, 2)]
        entries = [g.sqrt(q[0]), g.function(Op.LOG, q[1]), g.sqrt(q[1] * q[1]), 1 / q[0]]
        module = RUNNERS["matlab"].run(emit(lower(one(entries, q)), "matlab"))
        found = module.f([[-1.0, -2.0], [4.0, 1.0], [0.0, 0.0], [np.nan, np.inf]])
        wanted = [[np.nan, np.nan, 2, -1], [2, 0, 1, 0.25], [0, -np.inf, 0, np.inf], [np.nan, np.inf, np.inf, np.nan]]
        np.testing.assert_array_equal(found, wanted)

    def test_complex_steps_differentiate_what_is_analytic_and_the_rest_refuses_them(self, tmp_path: Path) -> None:
        code = "q = [1; 2]; p = (1:5)'; h = 1e-30; f = @(d) imag(two_link.kinetic_energy(q + i * h * d, q, p)) / h;"
        code += "g = @(d) (two_link.kinetic_energy(q + 1e-6 * d, q, p) - two_link.kinetic_energy(q - 1e-6 * d, q, p));"
        code += "found = {f([0; 1]), g([0; 1]) / 2e-6}"
        steps, differences = octave(two_link(), tmp_path, code)
        assert steps == pytest.approx(differences, rel=1e-8)
        code = "try, every_op.matrix([1; i], [1; 2], 3), catch e, found = [e.identifier ' ' e.message]; end"
        told = octave(emit(lower(every_op()), "matlab"), tmp_path, code)
        assert told == "every_op:type every_op.matrix: q is complex; give real numbers"

    def test_at_rest_no_velocity_is_an_argument(self, tmp_path: Path) -> None:
        equations = formulate(example("two_link"), ("inverse_dynamics",)).at_rest()
        program = lower(equations)
        assert [one.name for one in program.routines[0].function.arguments] == ["q", "qdd", "params"]
        module, plain = RUNNERS["matlab"].run(emit(program, "matlab")), run_python(emit(program))
        given = [np.full((3, n), 0.5) for n in (2, 2)]
        params = [1.0, 2.0, 3.0, 4.0, 9.81]
        np.testing.assert_allclose(module.inverse_dynamics(*given, params), plain.inverse_dynamics(*given, params))

    def test_help_shows_arguments_parameters_and_cost(self, tmp_path: Path) -> None:
        text = octave(two_link(), tmp_path, "found = get_help_text('two_link.mass_matrix')")
        assert text.startswith(" MASS_MATRIX  mass matrix M(q), symmetric, kinetic energy qd.T M qd / 2\n")
        for part in ("M = two_link.mass_matrix(q, params)", "params(3, :) = h1, m: length of link 1", "crba; 11 mul, "):
            assert part in text
        assert "codegen" not in text

    def test_what_depends_on_parameters_alone_may_be_prepared(self) -> None:
        program = prepare(lower(formulate(example("two_link"), ("mass_matrix",))))
        module, plain = RUNNERS["matlab"].run(emit(program, "matlab")), run_python(emit(program))
        prepared = module.prepare([1.0, 2.0, 3.0, 4.0, 9.81])
        np.testing.assert_allclose(prepared, plain.prepare([1.0, 2.0, 3.0, 4.0, 9.81]), rtol=1e-15)
        np.testing.assert_allclose(
            module.mass_matrix(np.ones((3, 2)), prepared), plain.mass_matrix(np.ones((3, 2)), prepared), rtol=1e-14
        )
