"""Compiled functions agree with the NumPy module and with the graph itself, and have the same manners."""

from __future__ import annotations

import ctypes
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from formulas import every_op, states
from mechanisms import random_tree

from symdyn.algebra.big import BigFloats
from symdyn.dynamics.outputs.derive import derive
from symdyn.emit import emit
from symdyn.errors import BuildError, DerivationError, EmitError
from symdyn.graph import evaluate
from symdyn.program import Program, lower
from symdyn.runtime import build, lambdify, run_python

pytestmark = [pytest.mark.runs("cc"), pytest.mark.usefixtures("optimised")]


@pytest.fixture(scope="module")
def program() -> Program:
    return lower(every_op())


@pytest.fixture(scope="module")
def compiled(program):
    return build(program)


@pytest.fixture(scope="module")
def interpreted(program):
    return run_python(emit(program))


def oracle(program: Program, name: str, args: list[np.ndarray]) -> list[float]:
    """Return the entries of one function for one state, to 50 digits and rounded once."""
    function, algebra = program[name].function, BigFloats(50)
    values = {
        symbol: algebra.number(float(x))
        for a, array in zip(function.arguments, args, strict=True)
        for symbol, x in zip(a.symbols, array, strict=True)
    }
    return [float(x) for x in evaluate(function.entries, algebra, values)]


@pytest.mark.parametrize("name", ["matrix", "scalar", "nothing", "rotated"])
def test_c_and_numpy_agree_with_fifty_digits(name, program, compiled, interpreted):
    args = states(every_op(), name, 8)
    fast, plain = getattr(compiled, name)(*args), getattr(interpreted, name)(*args)
    for i in range(8):
        exact = np.reshape(oracle(program, name, [a[i] for a in args]), fast[i].shape)
        np.testing.assert_allclose(fast[i], exact, rtol=2e-14, atol=1e-15)
        np.testing.assert_allclose(plain[i], exact, rtol=2e-14, atol=1e-15)


def test_c_and_numpy_agree_on_a_tree():
    equations = derive(random_tree(3, 4), ("inverse_dynamics", "forward_dynamics", "k_C", "kinetic_energy"))
    program = lower(equations)
    fast, plain = build(program), run_python(emit(program))
    for function in equations.functions:
        args = states(equations, function.name, 3)
        got, wanted = getattr(fast, function.name)(*args), getattr(plain, function.name)(*args)
        np.testing.assert_allclose(got, wanted, rtol=1e-10, atol=1e-10)


def test_sign_is_zero_at_zero_and_odd(compiled, interpreted):
    args = ([0.1, 0.2], [[1.5, 0.3], [0.0, 0.3], [-1.5, 0.3]], [1.0])
    np.testing.assert_allclose(compiled.matrix(*args), interpreted.matrix(*args), rtol=1e-13, atol=1e-15)


def test_float32_has_the_digits_of_float32(program, compiled):
    single = build(program, real="float")
    args = states(every_op(), "matrix")
    result = single.matrix(*args)
    assert result.dtype == np.float32
    np.testing.assert_allclose(result, compiled.matrix(*args), rtol=1e-5, atol=1e-5)


def test_leading_dimensions_broadcast(compiled, interpreted):
    q, qd, params = states(every_op(), "matrix", 6)
    args = q.reshape(3, 2, 2), qd[:2], params[0]
    np.testing.assert_allclose(compiled.matrix(*args), interpreted.matrix(*args), rtol=1e-13, atol=1e-15)
    assert compiled.scalar(*args).shape == (3, 2)
    assert compiled.empty(*args).shape == (3, 2, 1, 0)
    assert compiled.matrix(np.zeros((0, 2)), np.zeros(2), np.ones(1)).shape == (0, 2, 3)


def test_strided_and_transposed_input_is_read_right(compiled):
    q, qd, params = states(every_op(), "matrix", 6)
    straight = compiled.matrix(q[::2], qd[::2], params[::2])
    np.testing.assert_array_equal(compiled.matrix(np.asfortranarray(q)[::2], qd[::2], params[::2]), straight)


@pytest.mark.parametrize("count", [2, 64, 200])
def test_a_batch_with_one_set_of_params_is_one_call(program, compiled, interpreted, count):
    q, qd, params = states(every_op(), "matrix", count)
    wanted = [interpreted.matrix(q, qd, params[0]), interpreted.matrix(q, qd[0], params[0])]
    calls = []
    counted = replace(
        compiled.matrix,
        _call=lambda *_: pytest.fail("called for one state"),
        _rows=lambda *given: calls.append(given[0]) or compiled.matrix._rows(*given),
    )
    for found, exact in zip((counted(q, qd, params[:1]), counted(q.T.copy().T, qd[0], params[0])), wanted, strict=True):
        np.testing.assert_allclose(found, exact, rtol=1e-13, atol=1e-15)
    assert calls == [count, count]


def test_sources_without_batch_code_run_state_by_state(program, interpreted):
    plain = build(emit(program, "c"))
    args = states(every_op(), "matrix", 20)
    assert plain.matrix._rows is None
    np.testing.assert_allclose(plain.matrix(*args), interpreted.matrix(*args), rtol=1e-13, atol=1e-15)
    one = [*args[:2], args[2][0]]
    np.testing.assert_allclose(plain.matrix(*one), interpreted.matrix(*one), rtol=1e-13, atol=1e-15)


def test_scalars_and_names_work_as_in_numpy(compiled):
    value = compiled.scalar([0, 0], qd=[2, 3], params=[10])
    assert value == 21.0
    assert np.ndim(value) == 0


def test_wrong_arguments_are_named(compiled):
    with pytest.raises(ValueError, match=r"matrix: qd has shape \(3,\); its last dimension must have length 2"):
        compiled.matrix(np.zeros(2), np.zeros(3), np.ones(1))
    with pytest.raises(ValueError, match=r"matrix: leading dimensions .* of q, qd, params do not broadcast"):
        compiled.matrix(np.zeros((3, 2)), np.zeros((4, 2)), np.ones(1))
    with pytest.raises(TypeError, match=r"matrix takes \(q, qd, params\); given were 1 by position"):
        compiled.matrix(np.zeros(2))
    with pytest.raises(TypeError, match=r"given were 3 by position, q by name"):
        compiled.matrix(np.zeros(2), np.zeros(2), np.ones(1), q=np.zeros(2))
    with pytest.raises(AttributeError, match="there is no function 'matrx'; there are matrix, scalar"):
        _ = compiled.matrx


def test_nan_goes_in_and_comes_out(compiled):
    result = compiled.matrix([0.1, 0.2], [np.nan, 0.3], [1.0])
    assert np.isnan(result[[0, 0, 1, 1], [0, 1, 0, 2]]).all()


def test_the_output_may_be_one_of_the_inputs(compiled):
    q, qd, params = (array[0] for array in states(every_op(), "rotated"))
    wanted = compiled.rotated(q, qd, params)
    library = ctypes.CDLL(str(compiled.path))
    place = [array.ctypes.data_as(ctypes.c_void_p) for array in (q, qd, params)]
    library.every_op_rotated(*place, place[0])
    np.testing.assert_array_equal(q, wanted)


def test_sources_of_another_target_are_refused(program):
    with pytest.raises(BuildError, match="sources of target 'numpy' are not of target 'c'"):
        build(emit(program))


def test_lambdify_gives_one_function_or_several():
    scene = random_tree(1, 3)
    inverse = lambdify(scene, "inverse_dynamics")
    forward, mass = lambdify(scene, ("forward_dynamics", "mass_matrix"), target="c")
    rng = np.random.default_rng(0)
    n = len(scene.coordinates)
    q, qd, qdd, params = (rng.uniform(0.5, 1.0, (4, k)) for k in (n, n, n, 2))
    np.testing.assert_allclose(forward(q, qd, inverse(q, qd, qdd, params), params), qdd, rtol=1e-9)
    M = mass(q, params)
    np.testing.assert_allclose(M, np.swapaxes(M, -1, -2), rtol=1e-12)


def test_lambdify_refuses_what_does_not_exist():
    with pytest.raises(DerivationError, match="inverse_dynamcs"):
        lambdify(random_tree(1, 2), "inverse_dynamcs")
    with pytest.raises(EmitError, match=r"target 'cuda' is not known; did you mean gpu. .there are numpy, c"):
        lambdify(random_tree(1, 2), "mass_matrix", target="cuda")


def test_fifty_digits_are_what_the_oracle_has(program):
    with mpmath.workdps(30):
        entry = oracle(program, "scalar", [np.zeros(2), np.array([0.0, 1.0]), np.zeros(1)])
    assert entry == [1 / 3]
