"""The NumPy module: alone, polite, broadcasting, strict about shapes."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from formulas import every_op, states

from symdyn.build import run_python
from symdyn.dynamics.equations import Equations
from symdyn.emit import emit, write
from symdyn.errors import EmitError
from symdyn.program import lower


@pytest.fixture(scope="module")
def module():
    return run_python(emit(lower(every_op())))


def test_the_module_runs_with_numpy_alone(tmp_path):
    write(emit(lower(every_op())), tmp_path)
    code = "import every_op, sys; print(every_op.scalar([0, 0], [2, 3], [10])); print('symdyn' in sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["21.0", "False"]


def test_leading_dimensions_broadcast(module):
    q, qd, params = states(every_op(), "matrix", 6)
    q, qd, params = q.reshape(3, 2, 2), qd[:2], params[0]
    batch = module.matrix(q, qd, params)
    assert batch.shape == (3, 2, 2, 3)
    for i in range(3):
        for j in range(2):
            np.testing.assert_allclose(batch[i, j], module.matrix(q[i, j], qd[j], params), rtol=1e-15)
    assert module.scalar(q, qd, params).shape == (3, 2)


def test_one_state_gives_one_result(module):
    q, qd, params = (array[0] for array in states(every_op(), "matrix"))
    assert module.matrix(q, qd, params).shape == (2, 3)
    assert np.ndim(module.scalar(q, qd, params)) == 0
    assert module.rotated(q=q, qd=qd, params=params).shape == (2,)


def test_integers_are_divided_as_numbers(module):
    assert module.scalar(np.array([0, 0]), np.array([1, 1]), np.array([1])) == pytest.approx(0.5 + 1 / 3)


def test_empty_and_zero_results_have_their_shape(module):
    q, qd, params = states(every_op(), "matrix", 4)
    assert module.empty(q, qd, params).shape == (4, 1, 0)
    np.testing.assert_array_equal(module.nothing(q, qd, params), np.zeros((4, 2)))


def test_an_empty_batch_is_a_batch(module):
    assert module.matrix(np.zeros((0, 2)), np.zeros(2), np.ones(1)).shape == (0, 2, 3)


@pytest.mark.parametrize("found", [(3,), (1,), (), (2, 1)])
def test_a_wrong_last_dimension_is_named(module, found):
    with pytest.raises(ValueError, match=r"matrix: qd has shape \(.*\); its last dimension must have length 2"):
        module.matrix(np.zeros(2), np.zeros(found), np.ones(1))


def test_leading_dimensions_that_do_not_broadcast_are_named(module):
    with pytest.raises(ValueError, match=r"matrix: leading dimensions .*q, qd, params do not broadcast"):
        module.matrix(np.zeros((3, 2)), np.zeros((4, 2)), np.ones(1))


def test_nan_goes_in_and_comes_out(module):
    result = module.matrix([0.1, 0.2], [np.nan, 0.3], [1.0])
    assert np.isnan(result[[0, 0, 1, 1], [0, 1, 0, 2]]).all()


def test_the_header_tells_functions_counts_units_and_parameters():
    sources = emit(lower(every_op()), command="symdyn generate every_op.toml")
    assert list(sources) == ["every_op.py"]
    head = sources["every_op.py"].split('"""')[1]
    for words in (
        "symdyn generate every_op.toml",
        "Do not edit",
        "matrix(q, qd, params) -> r, shape (2, 3); N m",
        "by hand; 4 mul, 3 add, 2 sincos",
        "Not used, kept so that all calls look alike: q, qd, params",
        "qd, shape (2,); rad/s",
        "params[0] = mass, kg: of the load",
        "The result has no entries; nothing is written.",
    ):
        assert words in head


def test_all_lists_the_functions(module):
    assert module.__all__ == ["matrix", "scalar", "empty", "nothing", "rotated"]
    assert all("shape (..., 2)" in getattr(module, name).__doc__ for name in module.__all__)


def test_hostile_text_stays_text(tmp_path):
    equations = every_op('a"""b\\')
    first = replace(equations.functions[1], text='ends with a quote " \\ and """ + oops() + """', units='"')
    module = run_python(emit(lower(Equations(equations.scene, equations.graph, (first,))), command="x\n\\N{oops}"))
    assert module.scalar([0, 0], [2, 3], [10]) == 21.0


def test_float_module_works_in_float32():
    module = run_python(emit(lower(every_op()), real="float"))
    q, qd, params = states(every_op(), "matrix")
    result = module.matrix(q, qd, params)
    assert result.dtype == np.float32
    exact = run_python(emit(lower(every_op()))).matrix(q, qd, params)
    np.testing.assert_allclose(result, exact, rtol=1e-5, atol=1e-5)


def test_a_program_without_functions_is_refused():
    equations = every_op()
    with pytest.raises(EmitError, match="every op: there is no function to write"):
        emit(lower(Equations(equations.scene, equations.graph, ())))


def test_unknown_targets_and_types_are_refused():
    program = lower(every_op())
    with pytest.raises(EmitError, match="target 'fortran' is not known; give numpy or c"):
        emit(program, "fortran")
    with pytest.raises(EmitError, match="real type 'half' is not known; give double or float"):
        emit(program, "c", "half")
