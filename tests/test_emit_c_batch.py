"""Functions over many states: the same numbers as state by state, sines to one ulp, clean C, nothing out of bounds."""

from __future__ import annotations

import ctypes
import math
import re
import shutil
import subprocess
import warnings
from dataclasses import replace
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from arms import EXAMPLES, chain
from formulas import argument, every_op, function, one, states
from mechanisms import random_tree

from symdyn.cli import main
from symdyn.dynamics.outputs import Counts
from symdyn.dynamics.outputs.derive import derive
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import emit, write
from symdyn.emit.targets.c.cuts import STACK, VECTOR, _lanes
from symdyn.emit.targets.c.plan import (
    LONGEST,
    LONGEST_LOOP,
    LONGEST_OF_VECTOR,
    PIECE,
    Pass,
    SineCosine,
    longest_loop,
    plan,
)
from symdyn.emit.targets.c.writer import COSINE, HALF_PI, SINE
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op
from symdyn.program import lower
from symdyn.runtime import build
from symdyn.runtime.c_module import GRAIN, WORTH, price, run_rows, split
from symdyn.scene import Scene, read

pytestmark = [pytest.mark.runs("cc"), pytest.mark.usefixtures("optimised")]

GCC = shutil.which("gcc") or shutil.which("cc") or shutil.which("clang")
LINT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror", "-c", "-o", "lint.o"]
COUNTS = (0, 1, 3, 16, 17, 63, 64, 65, 130, 256)
TYPES = {"double": np.float64, "float": np.float32}


def sine_and_cosine() -> Equations:
    g = Graph()
    q = g.symbol("q1")
    return one([g.sin(q), g.cos(q)], [q])


@pytest.fixture(scope="module", params=["double", "float"])
def real(request):
    return request.param


@pytest.fixture(scope="module", params=["native", "portable"])
def sincos(request, real):
    """Sines and cosines of an array by the generated routine, shape (n, 2)."""
    call = build(lower(sine_and_cosine()), real=real, machine=request.param).f

    def run(angles):
        return call(np.reshape(np.asarray(angles, TYPES[real]), (-1, 1)))

    return run


def worst_ulps(found, angles) -> float:
    worst = 0.0
    with mpmath.workprec(300):
        for pair, angle in zip(found, angles, strict=True):
            x = mpmath.mpf(float(angle))
            for value, exact in zip(pair, (mpmath.sin(x), mpmath.cos(x)), strict=True):
                unit = float(np.spacing(abs(type(value)(float(exact)))))
                worst = max(worst, float(abs(mpmath.mpf(float(value)) - exact) / mpmath.mpf(unit)))
    return worst


def near_multiples(count: int, limit: float, dtype) -> np.ndarray:
    """Numbers next to multiples of π/2: there the reduced angle is tiny."""
    rng = np.random.default_rng(3)
    multiples = np.concatenate([np.arange(-40, 41), rng.integers(-int(limit / 1.6), int(limit / 1.6), count)])
    with mpmath.workprec(300):
        nearest = np.array([float(int(k) * mpmath.pi / 2) for k in multiples]).astype(dtype)
    return np.concatenate([nearest, np.nextafter(nearest, dtype(0)), np.nextafter(nearest, dtype(2**30))])


@pytest.mark.wide(2)
@pytest.mark.parametrize("span", [3.2, 1e3, 2.0**20])
def test_sines_are_right_to_one_ulp(sincos, real, span):
    angles = np.random.default_rng(1).uniform(-span, span, 1500).astype(TYPES[real])
    assert worst_ulps(sincos(angles), angles) <= 1


def test_sines_are_right_to_one_ulp_next_to_multiples_of_a_quarter_turn(sincos, real):
    angles = near_multiples(600, 2.0**20, TYPES[real])
    angles = angles[np.abs(angles) < 2**20]
    assert worst_ulps(sincos(angles), angles) <= 1


@pytest.mark.parametrize("copied", [0, 500, 20_000])
@pytest.mark.parametrize("work", [0, 1000, 20_000, 40_000])
def test_a_block_of_states_has_room_on_the_stack_or_there_is_none(copied, work):
    lanes = _lanes(copied, work)

    assert lanes * (copied + work) <= STACK
    assert lanes or VECTOR * (copied + work) > STACK


def test_the_closest_doubles_to_multiples_of_a_quarter_turn_lose_nothing():
    with mpmath.workprec(120):
        multiples = sorted(range(1, 667_000, 50), key=lambda k: abs(float(k * np.pi / 2) - k * mpmath.pi / 2))[:40]
    angles = np.array([k * np.pi / 2 for k in multiples])
    assert worst_ulps(build(lower(sine_and_cosine())).f(angles[:, None]), angles) <= 1


def test_small_angles_keep_their_digits_and_zero_its_sign(sincos, real):
    tiny = float(np.finfo(TYPES[real]).smallest_subnormal)
    angles = np.array([0.0, -0.0, tiny, -tiny, 1e-30, -1e-20, 1e-8, 1e-5] * 8, TYPES[real])
    found = sincos(angles)
    assert np.array_equal(np.signbit(found[:, 0]), np.signbit(angles))
    assert worst_ulps(found, angles) <= 1


def test_one_huge_angle_in_a_block_spoils_nothing(sincos, real):
    angles = np.linspace(-3, 3, 200).astype(TYPES[real])
    angles[[5, 70, 199]] = [2**20, 1e22, -3e30]
    assert worst_ulps(sincos(angles), angles) <= 1


def many_angles(count: int) -> Equations:
    g = Graph()
    q = [g.symbol(f"q{i}") for i in range(count)]
    return one([f(x) for x in q for f in (g.sin, g.cos)], q)


@pytest.mark.wide(7)
@pytest.mark.parametrize("count", [2, 7, 8, 9, 17])
def test_many_angles_are_taken_as_one_is(count, real):
    call, single = (build(lower(each), real=real).f for each in (many_angles(count), sine_and_cosine()))
    angles = np.random.default_rng(4).uniform(-7, 7, (150, count)).astype(TYPES[real])
    apart = [single(np.ascontiguousarray(column)[:, None]) for column in angles.T]
    assert np.array_equal(call(angles), np.hstack(apart))


@pytest.mark.wide(3)
@pytest.mark.parametrize("count", [2, 9])
def test_huge_and_tiny_ones_among_many_spoil_nothing(count, real):
    call = build(lower(many_angles(count)), real=real).f
    angles = np.random.default_rng(5).uniform(-7, 7, (70, count)).astype(TYPES[real])
    angles[3, 0], angles[66, -1], angles[5, 1] = 3e7, -1e22, 1e-30
    assert worst_ulps(call(angles).reshape(-1, 2), angles.ravel()) <= 1


def test_what_is_not_finite_gives_not_a_number_there_alone(sincos, real):
    angles = np.linspace(-3, 3, 100).astype(TYPES[real])
    angles[[1, 50, 99]] = [np.nan, np.inf, -np.inf]
    with np.errstate(all="ignore"):
        found = sincos(angles)
    assert np.isnan(found).all(axis=1).nonzero()[0].tolist() == [1, 50, 99]
    assert np.isfinite(np.delete(found, [1, 50, 99], axis=0)).all()


FLAGS_PROGRAM = """
#include <fenv.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include "hand.h"
int main(void)
{
    volatile double big = 1e300, zero = 0.0;
    double q[64], out[128];
    for (int k = 0; k < 64; k++) q[k] = (k % 3 == 0) ? big : (k % 3 == 1) ? -1e-3 * k : (k == 2) ? 0.0 : big;
    feclearexcept(FE_ALL_EXCEPT);
    hand_f_batch(64, q, out);
    int huge = fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
    for (int k = 0; k < 64; k++) q[k] = (k % 5 == 0) ? __builtin_nan("") : 0.1 * k + zero;
    feclearexcept(FE_ALL_EXCEPT);
    hand_f_rows(64, q, out);
    int quiet = fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
    for (int k = 0; k < 64; k++) q[k] = 0.1 * k;
    feclearexcept(FE_ALL_EXCEPT);
    hand_f_rows(61, q, out);
    int ordinary = fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW | FE_UNDERFLOW);
    for (int k = 0; k < 64; k++) q[k] = (k % 2 ? -1.0 : 1.0) * pow(10.0, -4.8 * k);
    feclearexcept(FE_ALL_EXCEPT);
    hand_f_batch(64, q, out);
    int small = fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW | FE_UNDERFLOW);
    printf("%d %d %d %d", huge, quiet, ordinary, small);
    return 0;
}
"""


@pytest.mark.parametrize("flags", [["-march=native"], []])
def test_no_floating_point_flag_is_raised_that_the_numbers_do_not_deserve(flags, tmp_path):
    source, _ = write(emit(lower(sine_and_cosine()), "c", option="batch"), tmp_path)
    (tmp_path / "main.c").write_text(FLAGS_PROGRAM)
    command = [GCC, "-O3", "-fopenmp-simd", *flags, "main.c", source.name, "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    ran = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert ran.stdout == "0 0 0 0"


def test_a_batch_in_numpy_warns_of_nothing():
    call = build(lower(derive(random_tree(3, 4, free=False), ("inverse_dynamics",)))).inverse_dynamics
    rng = np.random.default_rng(2)
    args = [rng.uniform(-3, 3, (77, *shape)) for _, shape in call.arguments]
    args[0][5] = 1e9
    with warnings.catch_warnings(), np.errstate(all="raise"):
        warnings.simplefilter("error")
        assert np.isfinite(call(*args)).all()


def test_the_polynomials_are_within_a_small_part_of_an_ulp():
    with mpmath.workprec(200):
        for real, bits in (("double", 57), ("float", 36)):
            for z in [mpmath.mpf(i) / 500 * (mpmath.pi / 4) ** 2 for i in range(1, 501)]:
                y = mpmath.sqrt(z)
                sine = y + y**3 * sum(c * z**p for p, c in enumerate(SINE[real]))
                cosine = 1 - z / 2 + z**2 * sum(c * z**p for p, c in enumerate(COSINE[real]))
                assert abs(sine / mpmath.sin(y) - 1) < mpmath.mpf(2) ** -bits
                assert abs(cosine - mpmath.cos(y)) < mpmath.mpf(2) ** -bits
        assert abs(sum(map(mpmath.mpf, HALF_PI)) - mpmath.pi / 2) < mpmath.mpf(2) ** -150
    for part in HALF_PI[:3]:
        assert (part / np.spacing(part) / 2**20).is_integer(), "times 20 bits it is exact"


# The same numbers, many at once


def call_c(program, built, name, suffix, args, shape):
    """Call a C entry by hand; `out` is surrounded by guards."""
    library = ctypes.CDLL(str(built.path))
    dtype = args[0].dtype
    size = int(np.prod(shape))
    out = np.full(size + 32, 7.0, dtype)
    call = getattr(library, f"{name}{suffix}")
    call.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p] * (len(args) + 1)]
    call.restype = None
    count = shape[-1] if suffix == "_batch" else shape[0]
    call(count, *(array.ctypes.data for array in args), out[16:].ctypes.data)
    assert (out[:16] == 7).all(), "nothing is written before the result"
    assert (out[size + 16 :] == 7).all(), "nothing is written after the result"
    return out[16 : size + 16].reshape(shape)


@pytest.fixture(scope="module")
def operations(real):
    program = lower(every_op())
    return program, build(program, real=real)


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", ["matrix", "scalar", "nothing", "rotated"])
def test_every_operation_agrees_with_the_scalar_function(operations, real, name, count):
    program, built = operations
    *args, params = [array.astype(TYPES[real]) for array in states(every_op(), name, count)]
    params = np.array([1.25], TYPES[real])
    scalar = [np.ravel(getattr(built, name)(*(a[k] for a in args), params)) for k in range(count)]
    size = len(program[name].function.entries)
    expected = np.reshape(scalar, (count, size))
    rows = call_c(program, built, f"every_op_{name}", "_rows", [*args, params], (count, size))
    columns = [np.ascontiguousarray(a.T) for a in args]
    batch = call_c(program, built, f"every_op_{name}", "_batch", [*columns, params], (size, count))
    tolerance = 4e-15 if real == "double" else 4e-6
    assert np.allclose(rows, expected, rtol=tolerance, atol=tolerance)
    assert np.allclose(batch.T, expected, rtol=tolerance, atol=tolerance)


@pytest.mark.wide(3)
@pytest.mark.parametrize("seed", range(3))
def test_trees_agree_with_the_scalar_functions(seed):
    program = lower(derive(random_tree(seed, 5), ("inverse_dynamics", "forward_dynamics", "mass_matrix", "k_D")))
    built = build(program)
    rng = np.random.default_rng(seed)
    for routine in program.routines:
        function = getattr(built, routine.function.name)
        *args, params = [rng.uniform(0.5, 1.5, (70, *shape)) for _, shape in function.arguments]
        rows = function(*args, params[0])
        each = np.array([function(*(a[k] for a in args), params[0]) for k in range(70)])
        assert np.allclose(rows, each, rtol=1e-9, atol=1e-11 * np.abs(each).max())


@pytest.mark.wide(3)
@pytest.mark.parametrize("joints", [4, 12])
@pytest.mark.parametrize("count", [31, 32, 33, 100, 256, 300, 512])
def test_matrices_are_copied_from_what_loops_write_once(joints, count):
    program = lower(derive(fork(joints), ("mass_matrix",)))
    built = build(program)
    q = np.random.default_rng(1).uniform(-2, 2, (count, joints))
    expected = np.array([np.ravel(built.mass_matrix(one)) for one in q])
    name = f"fork{joints}_mass_matrix"
    rows = call_c(program, built, name, "_rows", [q], (count, joints**2))
    batch = call_c(program, built, name, "_batch", [np.ascontiguousarray(q.T)], (joints**2, count))
    assert np.allclose(rows, expected, rtol=1e-12, atol=1e-12)
    assert np.array_equal(rows, batch.T)


def test_loops_write_every_different_entry_once():
    text = emit(lower(derive(fork(12), ("mass_matrix",))), "c", option="batch")["fork12.c"]
    written = [int(place) for place in re.findall(r"out\[([0-9]+) \* reach \+ k\] =", text)]
    assert sorted(written) == list(range(6 * 7 - 1)), "half a matrix of six each, the last entries equal, and no zero"


def fork(joints: int) -> Scene:
    """Return two chains that hang on the ground: their mass matrix is half zeros."""
    one, half = chain(joints), joints // 2
    return replace(
        one,
        name=f"fork{joints}",
        joints=tuple(replace(j, parent="ground") if k == half else j for k, j in enumerate(one.joints)),
    )


@pytest.mark.wide("90")
@pytest.mark.parametrize("joints", [40, 90])
def test_long_functions_in_parts_agree_with_fifty_digits(joints):
    from symdyn.verify.accuracy import measure

    program = lower(derive(chain(joints), ("inverse_dynamics",)))
    plain = emit(program, "c")
    assert "_part2(" in plain[f"chain{joints}.c"] or joints < 90
    assert "_part2(" in emit(program, "c", option="batch")[f"chain{joints}.c"] or joints < 90
    built = build(program)
    assert all(
        one.passed for one in measure(program, {"c": built, "rows": Rows(built), "plain": build(plain)}, states=3)
    )


@pytest.mark.slow
def test_a_long_scalar_function_may_write_over_its_arguments():
    built = build(lower(derive(chain(80), ("inverse_dynamics",))))
    q, qd, qdd = np.random.default_rng(1).uniform(-1, 1, (3, 80))
    expected = built.inverse_dynamics(q, qd, qdd)
    built.inverse_dynamics._call(q.ctypes.data, qd.ctypes.data, qdd.ctypes.data, q.ctypes.data)
    assert np.array_equal(q, expected)


def test_a_result_too_large_for_blocks_is_computed_state_by_state(monkeypatch):
    monkeypatch.setattr("symdyn.emit.targets.c.cuts.STACK", 1000)
    g = Graph()
    q = [g.symbol(f"q{i}") for i in range(2)]
    program = lower(one([g.sin(q[0]) * k + q[1] for k in range(50)], q))
    built = build(program)
    args = np.random.default_rng(1).uniform(-1, 1, (9, 2))
    expected = np.sin(args[:, :1]) * np.arange(50) + args[:, 1:]
    rows = call_c(program, built, "hand_f", "_rows", [args], (9, 50))
    batch = call_c(program, built, "hand_f", "_batch", [np.ascontiguousarray(args.T)], (50, 9))
    assert np.allclose(rows, expected, rtol=1e-14, atol=1e-14)
    assert np.array_equal(rows, batch.T)


def test_a_long_routine_is_cut_into_loops_that_compile_in_linear_time():
    sizes = {}
    for joints in (30, 90):
        program = lower(derive(chain(joints), ("inverse_dynamics",)))
        stages = plan(program["inverse_dynamics"], program.constants).stages
        sizes[joints] = [len(stage.steps) for stage in stages if isinstance(stage, Pass)]
    assert len(sizes[30]) == 1, "short ones stay one loop"
    assert len(sizes[90]) > 2
    assert max(sizes[90]) <= PIECE


def test_a_loop_over_states_stays_whole_where_one_state_is_computed_in_parts(monkeypatch):
    program = lower(derive(read(EXAMPLES / "arm7.toml"), ("inverse_dynamics_derivatives",)))
    name = "inverse_dynamics_derivatives"

    whole = emit(program, "c", option="batch")["arm7.c"]
    monkeypatch.setattr("symdyn.emit.targets.c.plan.WIDEST_LOOP", 7 * 21 - 1)
    cut = emit(program, "c", option="batch")["arm7.c"]

    loops = [text.count("#pragma omp simd\n    for (size_t k = 0; k < 32;") for text in (whole, cut)]
    assert loops[0] == 1
    assert loops[1] > 4
    parts = [re.findall(rf"SYMDYN_PART static void {name}_part\d+\(.*?\n}}\n", text, re.S) for text in (whole, cut)]
    assert len(parts[0]) > 4
    assert parts[0] == parts[1], "the function of one state is the same"


def test_loops_are_cut_where_little_is_used_again():
    assert longest_loop((17, 17), 2000, 399) == LONGEST
    assert longest_loop((17, 17), 2000, 401) == LONGEST_LOOP
    assert longest_loop((17, 60), 2000, 401) == LONGEST, "too wide for one loop"
    assert longest_loop((17,), 2000, 401) == LONGEST_OF_VECTOR


# Accuracy of batches


class Rows:
    """A module whose functions are called on a block of equal states."""

    def __init__(self, module):
        self._module = module

    def __getattr__(self, name):
        def call(*args):
            found = getattr(self._module, name)(*(np.tile(a, (40, 1)) for a in args[:-1]), *self._last(name, args))
            assert all(np.array_equal(found[0], one) for one in found[:32])
            return found[0]

        return call

    def _last(self, name, args):
        shared = getattr(self._module, name).arguments[-1][0] == "params"
        return [args[-1] if shared else np.tile(args[-1], (40, 1))]


@pytest.mark.wide(3)
@pytest.mark.parametrize("turns", [0.0, 1e3, 1e4, 1e6])
def test_batches_are_as_accurate_as_the_yardstick_allows(turns, monkeypatch):
    from symdyn.program.tunable import RANGES
    from symdyn.verify import accuracy

    program = lower(derive(random_tree(1, 4), ("inverse_dynamics", "forward_dynamics", "mass_matrix")))
    built = build(program)
    if turns:
        monkeypatch.setitem(RANGES, "q", turns)
    for found in accuracy.measure(program, {"scalar": built, "rows": Rows(built)}, states=4):
        assert found.passed, found


# The text


@pytest.mark.wide(3)
@pytest.mark.parametrize("equations", [every_op, lambda: derive(random_tree(2, 4), ("inverse_dynamics", "k_C"))])
@pytest.mark.parametrize("extra", [[], ["-fopenmp-simd"]])
def test_batch_code_is_clean_c99(equations, extra, real, tmp_path):
    source, _ = write(emit(lower(equations()), "c", real, option="batch"), tmp_path)
    ran = subprocess.run([GCC, *LINT, *extra, source.name], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.stderr == ""


def test_long_batch_code_is_clean_c99(tmp_path):
    source, _ = write(emit(lower(derive(chain(80), ("inverse_dynamics",))), "c", option="batch"), tmp_path)
    ran = subprocess.run([GCC, *LINT, source.name], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.stderr == ""


def test_without_batch_the_text_is_what_it_was():
    program = lower(every_op())
    plain, many = emit(program, "c", command="x"), emit(program, "c", command="x", option="batch")
    assert "_batch" not in "".join(plain.values())
    assert "sincos" not in plain["every_op.c"][plain["every_op.c"].index("#include") :]
    assert "void every_op_matrix_rows(size_t n, const double *q" in many["every_op.h"]


def test_a_function_called_as_batch_code_of_another_is_refused():
    g = Graph()
    q = g.symbol("q1")
    named = [function(name, [argument("q", [q])], (1,), [q]) for name in ("f", "f_rows")]
    with pytest.raises(EmitError, match="function f_rows would be called as batch code of f is; rename it"):
        emit(lower(Equations(Scene("hand"), g, tuple(named))), "c", option="batch")


def test_library_calls_stand_in_loops_of_their_own():
    program = lower(every_op())
    stages = plan(program["matrix"], program.constants).stages
    vector = [s for s in stages if isinstance(s, Pass) and s.plain]
    opaque = (Op.SIN, Op.COS, Op.TANH, Op.EXP, Op.LOG, Op.ATAN2)
    assert sum(isinstance(s, SineCosine) for s in stages) == 2
    assert not any(step.node.op in opaque for s in vector for step in s.steps)


def test_generate_writes_batch_code_and_says_how(tmp_path, capsys):
    scene = str(EXAMPLES / "two_link.toml")
    words = ["generate", scene, "--target", "c", "--functions", "mass_matrix", "--batch", "-o", str(tmp_path)]
    assert main(words) == 0
    text = (tmp_path / "two_link.c").read_text()
    assert "symdyn generate two_link.toml --target c --functions mass_matrix --batch" in text
    assert "void two_link_mass_matrix_rows(size_t n" in text


# Threads


def test_threads_give_the_same_numbers():
    program = lower(derive(random_tree(1, 3, free=False), ("forward_dynamics",)))
    one_thread, three = build(program), build(program, threads=3)
    rng = np.random.default_rng(4)
    count = 3 * WORTH // int(price(program.routines[0].function)) + 2 * GRAIN + 1
    args = [rng.uniform(-1, 1, (count, *shape)) for _, shape in one_thread.forward_dynamics.arguments]
    assert np.array_equal(one_thread.forward_dynamics(*args), three.forward_dynamics(*args))


@pytest.mark.parametrize("count", [0, 1, 5000, 16384, 100001])
@pytest.mark.parametrize("threads", [1, 2, 7])
def test_parts_cover_all_states_once(count, threads):
    parts = split(count, threads, price=2000)
    assert parts[0][0] == 0
    assert all(a[1] == b[0] for a, b in pairwise(parts))
    assert parts[-1][1] == count
    assert len(parts) <= threads


def test_a_fault_in_a_thread_is_raised():
    def call(count, place):
        if place:
            raise RuntimeError("in a thread")

    with pytest.raises(RuntimeError, match="in a thread"):
        run_rows(call, [0], [8], [(0, 10000), (10000, 20000)])


class Counted:
    """Stands before an entry for rows, and notes how many states each call takes."""

    def __init__(self, call):
        self.call, self.states = call, []

    def __call__(self, count, *places):
        self.states.append(count)
        self.call(count, *places)


@pytest.mark.wide(3)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", ["mass_matrix", "forward_dynamics"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_two_threads_are_taken_where_states_times_their_price_are_worth_it(name, real):
    program = lower(derive(random_tree(1, 3, free=False), (name,)))
    function = build(program, real=real, threads=2).functions[0]
    each = price(program.routines[0].function, np.dtype(function.dtype).itemsize)
    enough = math.ceil(2 * WORTH / each)
    for count, parts in ((enough - 1, 1), (enough, 2)):
        calls = Counted(function._rows)
        args = [np.zeros((count, *shape), function.dtype) for _, shape in function.arguments]
        replace(function, _rows=calls)(*args)
        assert (len(calls.states), sum(calls.states)) == (parts, count)


def test_a_state_is_priced_by_its_operations_and_its_numbers():
    program = lower(derive(random_tree(1, 3, free=False), ("mass_matrix", "forward_dynamics")))
    M, forward = (one.function for one in program.routines)
    assert price(M) == Counts.of(M).cost + 10 * (3 + 9)
    assert price(forward) == Counts.of(forward).cost + 10 * (4 * 3)
    assert price(M, itemsize=4) == price(M) / 2


def test_scene_names_open_the_names_of_batch_functions():
    equations = every_op()
    renamed = Equations(replace(equations.scene, name="math"), equations.graph, equations.functions)
    assert "void math__scalar_batch(size_t n" in emit(lower(renamed), "c", option="batch")["math_.h"]
