"""The extension module: NumPy's own broadcasting, casting and errors around the C that was generated."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from formulas import every_op, states
from mechanisms import random_tree
from patience import HANG

from symdyn.cli import main
from symdyn.dynamics.outputs.derive import derive
from symdyn.emit import emit
from symdyn.errors import BuildError, EmitError
from symdyn.program import Program, lower
from symdyn.runtime import library as extension, run_python
from symdyn.runtime.cache import cache_folder
from symdyn.runtime.compiler import find_compiler
from symdyn.runtime.library import build_extension

pytestmark = pytest.mark.runs("cc")

NAMES = ("matrix", "scalar", "nothing", "rotated")
COUNTS = (1, 3, 15, 16, 17, 300)  # around the number of states from which rows are called, and over a block of copies


@pytest.fixture(scope="module")
def program() -> Program:
    return lower(every_op())


@pytest.fixture(scope="module")
def compiled(program):
    return build_extension(emit(program, "ufunc"))[1]


@pytest.fixture(scope="module")
def plain(program):
    return run_python(emit(program))


def close(found, wanted) -> None:
    np.testing.assert_allclose(found, wanted, rtol=2e-13, atol=1e-14)


def test_core_dimensions_are_frozen_and_both_types_have_a_loop(compiled):
    assert isinstance(compiled.matrix, np.ufunc)
    assert compiled.matrix.signature == "(2),(2),(1)->(2,3)"
    assert compiled.scalar.signature == "(2),(2),(1)->()"
    assert compiled.matrix.types == ["fff->f", "ddd->d"]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("count", COUNTS)
def test_batches_of_any_length_agree_with_the_numpy_module(name, count, compiled, plain):
    q, qd, params = states(every_op(), name, count)
    wanted = getattr(plain, name)(q, qd, params)
    close(getattr(compiled, name)(q, qd, params), wanted)
    close(getattr(compiled, name)(q, qd, params[0]), getattr(plain, name)(q, qd, params[0]))
    close(getattr(compiled, name)(q[0], qd[0], params[0]), wanted[0])


@pytest.mark.parametrize("count", COUNTS)
def test_operands_may_lie_anyhow_in_memory(count, compiled, plain):
    q, qd, params = states(every_op(), "matrix", 2 * count)
    wanted = plain.matrix(q[::2], qd[1::2], params[0])
    close(compiled.matrix(np.asfortranarray(q)[::2], qd[1::2], params[0]), wanted)
    close(compiled.matrix(q[::2], np.flip(np.flip(qd[1::2], -1).copy(), -1), params[0]), wanted)
    close(compiled.matrix(q[::2].astype(">f8"), qd[1::2], np.repeat(params[0], 2)[::2]), wanted)
    close(compiled.matrix(q[::2], qd[1], params[::2]), plain.matrix(q[::2], qd[1], params[::2]))
    close(compiled.matrix(q[0], qd[1::2], params[0]), plain.matrix(q[0], qd[1::2], params[0]))


@pytest.mark.parametrize("count", COUNTS)
def test_the_result_goes_where_out_says(count, compiled, plain):
    q, qd, every = states(every_op(), "matrix", count)
    for params in (every, every[0]):
        wanted = plain.matrix(q, qd, params)
        for out in (np.empty((count, 2, 3)), np.empty((3, 2, count)).T, np.empty((count, 4, 6))[:, ::2, ::2]):
            assert compiled.matrix(q, qd, params, out=out) is out
            close(out, wanted)


def test_one_state_may_be_written_to_out(compiled, plain):
    q, qd, params = (array[0] for array in states(every_op(), "matrix"))
    out, value = np.empty((2, 3)), np.empty(())
    assert compiled.matrix(q, qd, params, out) is out
    assert compiled.scalar(q, qd, params, out=value) is value
    close(out, plain.matrix(q, qd, params))
    close(value, plain.scalar(q, qd, params))


def test_out_may_be_an_operand(compiled, plain):
    for count in (1, 20):
        q, qd, params = states(every_op(), "rotated", count)
        wanted = plain.rotated(q, qd, params)
        compiled.rotated(q, qd, params, out=q)
        close(q, wanted)
    both = np.arange(4.0)
    wanted = plain.rotated(both[:2], both[1:3], [1.0])
    compiled.rotated(both[:2], both[1:3], np.ones(1), out=both[2:])
    close(both[2:], wanted)


def test_leading_dimensions_broadcast(compiled, plain):
    q, qd, params = states(every_op(), "matrix", 6)
    for args in ((q.reshape(3, 2, 2), qd[:2], params[0]), (q[:, None], qd, params[:, None]), (q, qd[0], params)):
        close(compiled.matrix(*args), plain.matrix(*args))
    assert compiled.scalar(q.reshape(3, 2, 2), qd[:2], params[0]).shape == (3, 2)
    assert compiled.matrix(np.zeros((0, 2)), np.zeros(2), np.ones(1)).shape == (0, 2, 3)


def test_lists_integers_and_float32_work_as_in_numpy(compiled):
    value = compiled.scalar([0, 0], [2, 3], [10])
    assert value == 21.0
    assert type(value) is np.float64
    single = compiled.scalar(*(np.array(x, "f") for x in ([0, 0], [2, 3], [10])))
    assert single == 21.0
    assert type(single) is np.float32


def test_float32_has_the_digits_of_float32(compiled):
    for count in (1, 40):
        args = states(every_op(), "matrix", count)
        args = [*args[:2], args[2][0]]
        result = compiled.matrix(*(a.astype("f") for a in args))
        assert result.dtype == np.float32
        np.testing.assert_allclose(result, compiled.matrix(*args), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("found", [(3,), (1,), (2, 1), (40, 3)])
def test_a_wrong_length_is_numpys_own_error(compiled, found):
    with pytest.raises(ValueError, match=r"mismatch in its core dimension 0, with gufunc signature \(2\),\(2\),\(1\)"):
        compiled.matrix(np.zeros(2), np.zeros(found), np.ones(1))


def test_calls_that_numpy_refuses_are_refused_in_its_words(compiled):
    q = np.zeros(2)
    with pytest.raises(ValueError, match="does not have enough dimensions"):
        compiled.matrix(np.float64(0), q, np.ones(1))
    with pytest.raises(TypeError, match="takes from 3 to 4 positional arguments but 2 were given"):
        compiled.matrix(q, q)
    with pytest.raises(TypeError, match="unexpected keyword argument 'mass'"):
        compiled.matrix(q, q, np.ones(1), mass=q)
    with pytest.raises(ValueError, match="mismatch in its core dimension"):
        compiled.matrix(q, q, np.ones(1), out=np.empty((3, 2)))
    with pytest.raises(ValueError, match="read-only"):
        compiled.rotated(q, q, np.ones(1), out=np.broadcast_to(0.0, 2))


@pytest.mark.parametrize("count", [1, 40])
def test_nan_goes_in_and_comes_out_without_a_word(count, compiled):
    q = np.tile([np.nan, 0.3], (count, 1))[0 if count == 1 else slice(None)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isnan(compiled.rotated(q, q, np.ones(1))).all()
        assert np.isnan(compiled.scalar(q, q, np.ones(1))).all()


@pytest.mark.parametrize("count", [1, 40])
def test_what_is_not_finite_is_numpys_to_report(count):
    module = build_extension(emit(lower(derive(random_tree(3, 2, False), ("inverse_dynamics",))), "ufunc"))[1]
    n = len(random_tree(3, 2, False).coordinates)
    q = np.full((count, n), np.inf)[0 if count == 1 else slice(None)]
    with pytest.warns(RuntimeWarning, match="invalid value encountered in inverse_dynamics"):
        assert np.isnan(module.inverse_dynamics(q, q, q)).all()
    with np.errstate(all="raise"), pytest.raises(FloatingPointError, match="invalid value"):
        module.inverse_dynamics(q, q, q)
    with np.errstate(all="raise"):
        assert np.isfinite(module.inverse_dynamics(*np.ones((3, *q.shape)))).all()


def test_subclasses_are_asked_first(compiled):
    class Polite(np.ndarray):
        def __array_ufunc__(self, ufunc, method, *inputs, **kwargs):
            return f"asked about {ufunc.__name__}"

    assert compiled.scalar(np.zeros(2).view(Polite), np.zeros(2), np.ones(1)) == "asked about scalar"


def test_docstrings_name_operands_with_shapes_and_units(compiled):
    text = compiled.matrix.__doc__
    for words in ("matrix(q, qd, params, /, out=None) -> r", "qd: ", "shape (..., 2); rad/s", "(..., 2, 3); N m"):
        assert words in text


def test_hostile_text_stays_text():
    equations = every_op('a"""b\\')
    first = replace(equations.functions[1], text='quotes " \\ */ ??/ µ\n" oops(', units='"')
    hostile = lower(replace(equations, functions=(first,)))
    module = build_extension(emit(hostile, "ufunc", command="*/ x\n\\"))[1]
    assert 'quotes " \\ */ ??/ µ' in module.scalar.__doc__
    assert module.scalar([0, 0], [2, 3], [10]) == 21.0


def test_a_tree_agrees_with_the_numpy_module():
    equations = derive(random_tree(3, 4), ("inverse_dynamics", "forward_dynamics", "mass_matrix", "kinetic_energy"))
    program = lower(equations)
    fast, slow = build_extension(emit(program, "ufunc"))[1], run_python(emit(program))
    for function in equations.functions:
        args = states(equations, function.name, 40)
        for given in (args, [*args[:-1], args[-1][0]]):
            got, wanted = getattr(fast, function.name)(*given), getattr(slow, function.name)(*given)
            np.testing.assert_allclose(got, wanted, rtol=1e-10, atol=1e-10)


def test_what_has_no_entries_is_left_out_and_said_so(program, compiled):
    assert not hasattr(compiled, "empty")
    assert "has no empty operands: empty" in emit(program, "ufunc")["every_op_ufunc.c"]


def test_a_constant_too_large_for_float_leaves_double_alone():
    equations = every_op()
    function = equations.functions[1]
    entry = function.entries[0] * equations.graph.constant(10**40)
    program = lower(replace(equations, functions=(replace(function, entries=(entry,)),)))
    module = build_extension(emit(program, "ufunc"))[1]
    assert module.scalar.types == ["ddd->d"]
    assert module.scalar(np.zeros(2, "f"), np.array([2, 3], "f"), np.array([10], "f")) == 21e40


def test_the_same_program_gives_the_same_bytes(program):
    assert emit(program, "ufunc").files == emit(lower(every_op()), "ufunc").files


def test_one_real_type_is_not_a_choice(program):
    with pytest.raises(
        EmitError, match=r"real type 'float': target ufunc \(.*double and float in one.*\) takes double alone"
    ):
        emit(program, "ufunc", "float")


def test_the_sources_compile_without_a_warning(program):
    strict = shlex.join((*find_compiler().command, "-Wall", "-Wextra", "-Wconversion", "-Werror"))
    assert build_extension(emit(program, "ufunc"), strict)[1].scalar([0, 0], [2, 3], [10]) == 21.0


def test_sources_of_another_target_are_refused(program):
    with pytest.raises(BuildError, match="sources of target 'c' are not of target 'ufunc'"):
        build_extension(emit(program, "c"))


def test_missing_headers_are_named_with_the_way_out(program, monkeypatch, tmp_path):
    monkeypatch.setattr(extension, "INCLUDE", tmp_path)
    with pytest.raises(BuildError, match=r"there is no Python\.h, .*`symdyn generate SCENE --target numpy`"):
        build_extension(emit(program, "ufunc"))


@pytest.mark.slow
def test_another_numpy_is_another_library(program, monkeypatch):
    first = build_extension(emit(program, "ufunc"))[0]
    assert build_extension(emit(program, "ufunc"))[0] == first
    monkeypatch.setattr(extension.np, "__version__", "99.0")
    assert build_extension(emit(program, "ufunc"))[0] != first


def test_a_spoilt_extension_is_compiled_again(program, monkeypatch, tmp_path):
    good = build_extension(emit(program, "ufunc"))[0]
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path))
    (tmp_path / good.name).write_bytes(b"not a library")
    assert build_extension(emit(program, "ufunc"))[1].scalar([0, 0], [2, 3], [10]) == 21.0


BUILD = """
import numpy as np
from formulas import every_op
from symdyn.runtime.library import build_extension
from symdyn.emit import emit
from symdyn.program import lower
module = build_extension(emit(lower(every_op()), "ufunc"))[1]
print(module.scalar([0, 0], np.tile([2.0, 3.0], (20, 1)), [10]).sum())
"""


@pytest.mark.slow
def test_processes_that_build_at_once_all_succeed(monkeypatch, tmp_path):
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "cache"))
    environment = {**os.environ, "PYTHONPATH": f"{Path(__file__).parent}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}
    command = [sys.executable, "-c", BUILD]
    every = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    assert [process.communicate(timeout=HANG)[0].strip() for process in every] == ["420.0"] * 2
    assert len(list(cache_folder().iterdir())) == 1


def test_threads_run_at_once_and_agree(compiled):
    from concurrent.futures import ThreadPoolExecutor

    q, qd, params = states(every_op(), "matrix", 5000)
    wanted = compiled.matrix(q, qd, params[0])
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: compiled.matrix(q, qd, params[0]), range(8)):
            np.testing.assert_array_equal(found, wanted)


def test_generate_writes_the_sources_with_the_command_that_builds_them(tmp_path, capsys):
    scene = Path(__file__).parent.parent / "examples" / "two_link.toml"
    words = ["--target", "ufunc", "--functions", "mass_matrix", "--prepare", "-o", str(tmp_path)]
    assert main(["generate", str(scene), *words]) == 0
    names = [Path(line).name for line in capsys.readouterr().out.splitlines()]
    assert names == [f"two_link_{name}" for name in ("ufunc.c", "f32.c", "f32.h", "f64.c", "f64.h")]

    text = (tmp_path / "two_link_ufunc.c").read_text()
    stated = text[text.index("to build it by hand:") : text.index("*/")].replace("\n *", "\n")
    command = stated.partition(":")[2].strip().replace("python3", shlex.quote(sys.executable))
    command = command.replace("cc ", shlex.join(find_compiler().command) + " ", 1)
    subprocess.run(command, shell=True, cwd=tmp_path, check=True, capture_output=True)
    call = (
        "import two_link_ufunc as m; print(m.mass_matrix([0.0, 0.0], m.prepare([1.0, 1.0, 1.0, 1.0, 9.81])).tolist())"
    )
    ran = subprocess.run([sys.executable, "-c", call], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[[5.0, 2.0], [2.0, 1.0]]"
