"""The NumPy module: alone, polite, broadcasting, strict about shapes."""

from __future__ import annotations

import subprocess
import sys
import tracemalloc
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from formulas import argument, every_op, one, states

from symdyn.dynamics import derive
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import emit, write
from symdyn.emit.code.spelling import REALS
from symdyn.emit.targets import player
from symdyn.emit.targets.python_modules import BLOCK, player_text
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op
from symdyn.program import lower
from symdyn.runtime import run_python
from symdyn.scene import read


@pytest.fixture(scope="module")
def module():
    return run_python(emit(lower(every_op())))


@pytest.mark.runs
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


def test_arguments_without_entries_have_batches_as_well():
    g = Graph()
    program = lower(one([g.one], [g.symbol("x")]))
    function = replace(program.routines[0].function, arguments=(argument("q", []),))
    f = run_python(emit(replace(program, routines=(replace(program.routines[0], function=function),)))).f
    np.testing.assert_array_equal(f(np.zeros((3, 0))), np.ones((3, 1)))


def test_an_empty_batch_is_a_batch(module):
    assert module.matrix(np.zeros((0, 2)), np.zeros(2), np.ones(1)).shape == (0, 2, 3)


@pytest.mark.parametrize("found", [(3,), (1,), (), (2, 1)])
def test_a_wrong_last_dimension_is_named(module, found):
    with pytest.raises(ValueError, match=r"matrix: qd has shape \(.*\); its last dimension must have length 2"):
        module.matrix(np.zeros(2), np.zeros(found), np.ones(1))


@pytest.mark.parametrize("value", [np.array([1j, 0.5]), ["a", "b"], [None, 1.0]])
def test_what_is_no_real_number_is_refused(module, value):
    with pytest.raises(TypeError, match=r"matrix: q has type .*; give real numbers"):
        module.matrix(value, np.zeros(2), np.ones(1))


def test_a_result_is_put_only_where_it_keeps_its_digits(module):
    args = [np.zeros(2), np.zeros(2), np.ones(1)]
    with pytest.raises(TypeError, match="rotated: out has type int64; it must hold float64"):
        module.rotated(*args, out=np.zeros(2, np.int64))
    with pytest.raises(TypeError, match=r"rotated: out is a list; give an array of shape \(2,\)"):
        module.rotated(*args, out=[0.0, 0.0])
    assert module.rotated(*args, out=np.zeros(2, np.float32)).dtype == np.float32


def test_leading_dimensions_that_do_not_broadcast_are_named(module):
    with pytest.raises(ValueError, match=r"matrix: leading dimensions .*q, qd, params do not broadcast"):
        module.matrix(np.zeros((3, 2)), np.zeros((4, 2)), np.ones(1))


def test_nan_goes_in_and_comes_out(module):
    result = module.matrix([0.1, 0.2], [np.nan, 0.3], [1.0])
    assert np.isnan(result[[0, 0, 1, 1], [0, 1, 0, 2]]).all()


def test_a_batch_over_several_blocks_is_what_its_states_are(module):
    q, qd, params = states(every_op(), "matrix", BLOCK + 7)
    for given in (params, params[0], params[:1]):
        batch = module.matrix(q, qd, given)
        for k in (0, BLOCK - 1, BLOCK, BLOCK + 6):
            one = module.matrix(q[k], qd[k], given[k] if len(given) > 1 else np.ravel(given))
            np.testing.assert_allclose(batch[k], one, rtol=1e-14)


def test_one_state_is_computed_in_plain_floats(module, monkeypatch):
    monkeypatch.setattr(module, "_blocks", None)
    assert module.matrix([0.1, 0.2], [1.0, 0.3], [1.0]).shape == (2, 3)


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("common", range(7))
def test_a_few_states_are_to_the_bit_what_each_is_alone(real, common, monkeypatch):
    module = run_python(emit(lower(every_op()), real=real))
    monkeypatch.setattr(module, "_blocks", None)
    given = [a.astype("f" if real == "float" else "d") for a in states(every_op(), "matrix", 16)]
    given = [a[0] if common >> k & 1 else a for k, a in enumerate(given)]
    for name in ("matrix", "scalar", "rotated"):
        f = getattr(module, name)
        alone = [f(*(a if a.ndim == 1 else a[k] for a in given)) for k in range(16)]
        np.testing.assert_array_equal(f(*given), alone)


@pytest.mark.parametrize("count", [None, 3, 40])
def test_the_result_goes_where_out_says(module, count):
    q, qd, params = (a[0] if count is None else a for a in states(every_op(), "matrix", count or 1))
    wanted = module.matrix(q, qd, params)
    out = np.empty(wanted.shape[::-1]).T
    assert module.matrix(q, qd, params, out=out) is out
    np.testing.assert_array_equal(out, wanted)
    turned = module.rotated(q, qd, params)
    assert module.rotated(q, qd, params, out=q) is q
    np.testing.assert_array_equal(q, turned)
    with pytest.raises(ValueError, match=r"matrix: out has shape \(3, 2\); it must have shape \((3, |40, )?2, 3\)"):
        module.matrix(q, qd, params, out=np.empty((3, 2)))
    out.flags.writeable = False
    with pytest.raises(ValueError, match="matrix: out is read-only"):
        module.matrix(q, qd, params, out=out)


UNREAL = [  # where math raises: sin inf, log 0, sqrt of less than 0, overflow of exp, 1/0, 0/0
    ("sin", np.inf, np.nan),
    ("sin", np.nan, np.nan),
    ("log", 0.0, -np.inf),
    ("log", -1.0, np.nan),
    ("sqrt", -1.0, np.nan),
    ("exp", 1e4, np.inf),
    ("tanh", -np.inf, -1.0),
    ("sign", np.nan, np.nan),
    ("sign", -0.5, -1.0),
    ("abs", -np.inf, np.inf),
    ("inverse", 0.0, np.inf),
    ("square", 1e200, np.inf),
]


@pytest.mark.parametrize(("name", "value", "wanted"), UNREAL)
@pytest.mark.parametrize("count", [None, 3, 40])
def test_nothing_is_raised_or_warned_about_where_a_result_is_not_finite(name, value, wanted, count):
    g = Graph()
    x = g.symbol("x")
    entry = {"inverse": lambda: 1 / x, "square": lambda: x * x}.get(name) or (lambda: g.function(Op[name.upper()], x))
    f = run_python(emit(lower(one([entry()], [x])))).f
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = f([value] if count is None else [[value]] * count)
    np.testing.assert_array_equal(result, np.full_like(result, wanted))


PUMA = Path(__file__).parent.parent / "examples" / "puma560.toml"


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("common", range(7))
def test_a_batch_is_to_the_bit_what_the_text_gives_for_arrays(real, common):
    """Bit k of `common` says that all states share argument k, which then stays a number."""
    module = run_python(emit(lower(every_op()), real=real))
    given = [a.astype("f" if real == "float" else "d") for a in states(every_op(), "matrix", 29)]
    given = [a[0] if common >> k & 1 else a for k, a in enumerate(given)]
    for name in ("matrix", "scalar", "rotated"):
        batch = getattr(module, name)(*given)
        entries = getattr(module, f"_{name}")(module._Arrays, *[list(a.T) for a in given])
        for place, entry in enumerate(entries):
            np.testing.assert_array_equal(batch.reshape(-1, len(entries))[:, place], entry)


def test_entries_that_are_arguments_constants_or_given_twice_come_out_of_a_batch():
    g = Graph()
    x, y = g.symbol("x"), g.symbol("y")
    f = run_python(emit(lower(one([x, x * y, g.one / 3, x * y, y, -y], [x, y])))).f
    np.testing.assert_array_equal(f([[2.0, 5.0], [3.0, 7.0]]), [[2, 10, 1 / 3, 10, 5, -5], [3, 21, 1 / 3, 21, 7, -7]])


def test_a_batch_takes_one_work_space_and_leaves_nothing_behind():
    module = run_python(emit(lower(derive(read(PUMA), ("inverse_dynamics",)))))
    given = list(np.random.default_rng(1).uniform(-2, 2, (3, 4 * BLOCK, 6)))
    out = module.inverse_dynamics(*given)
    tape = module._record(module._inverse_dynamics, ((6, True),) * 3)
    assert tape.rows < len(tape.each) / 4
    tracemalloc.start()
    try:
        module.inverse_dynamics(*given, out=out)
        left, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < out.nbytes + 8 * BLOCK * (tape.rows + 1)
    assert left < BLOCK


def test_threads_do_not_share_a_work_space():
    module = run_python(emit(lower(derive(read(PUMA), ("inverse_dynamics",)))))
    given = list(np.random.default_rng(1).uniform(-2, 2, (3, 8, 2 * BLOCK, 6)))
    wanted = [module.inverse_dynamics(*state) for state in zip(*given, strict=True)]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(module.inverse_dynamics, *given))
    np.testing.assert_array_equal(found, wanted)


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
    assert module.__all__ == ["matrix", "scalar", "empty", "nothing", "chosen", "rotated"]
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


def test_what_is_too_large_for_float32_is_infinite_without_a_warning():
    x = Graph().symbol("x")
    f = run_python(emit(lower(one([x * x, x], [x])), real="float")).f
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for found in (f([1e30]), f([[1e30]])[0]):
            np.testing.assert_array_equal(found, np.array([np.inf, 1e30], "f"))


def test_a_program_without_functions_is_refused():
    equations = every_op()
    with pytest.raises(EmitError, match="every op: there is no function to write"):
        emit(lower(Equations(equations.scene, equations.graph, ())))


def test_unknown_targets_and_types_are_refused():
    program = lower(every_op())
    with pytest.raises(EmitError, match="target 'fortran' is not known; there are numpy, c"):
        emit(program, "fortran")
    with pytest.raises(EmitError, match="real type 'half' is not known; there are double, float"):
        emit(program, "c", "half")


def test_a_module_holds_the_player_but_for_its_number_type():
    whole = Path(player.__file__).read_text(encoding="utf-8")
    text = player_text(REALS["double"], BLOCK)
    assert whole.rstrip("\n").endswith(text)
    assert text in emit(lower(every_op()))["every_op.py"]
    assert player_text(REALS["float"], BLOCK) in emit(lower(every_op()), real="float")["every_op.py"]


@pytest.mark.parametrize("block", [1, 3, 1000])
def test_the_player_computes_the_same_in_blocks_of_any_size(block):
    room = dict(vars(player))
    exec(player_text(REALS["double"], block), room)
    x, y = np.random.default_rng(1).uniform(1, 2, (2, 27, 2))
    found = room["_run"](lambda _, x, y: (x[0] * y[1], -y[0], 2.0), "f", (3,), None, ("x", x, 2), ("y", y[0], 2))
    np.testing.assert_array_equal(found, np.stack([x[:, 0] * y[0, 1], np.full(27, -y[0, 0]), np.full(27, 2.0)], axis=1))
