"""`--real dd` in C: 31 digits of every output, the same bits however it is compiled, clean C, refusals in words."""

from __future__ import annotations

import shutil
import subprocess
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from arms import EXAMPLES
from formulas import one, spoken

import symdyn
from symdyn.algebra.big import BigFloats
from symdyn.cli import main
from symdyn.emit import beside, emit, write
from symdyn.emit.code.spelling import halves
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op, evaluate
from symdyn.program import lower, prepare
from symdyn.runtime import build

pytestmark = pytest.mark.usefixtures("optimised")

GCC = shutil.which("gcc") or shutil.which("cc") or shutil.which("clang")
COMPILERS = [
    pytest.param(command.split(), marks=pytest.mark.runs(command.split()[0]))
    for command in ("gcc", "gcc -x c++ -Drestrict=__restrict", "clang")
]
LINT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror"]
FLAGS = (
    ["-O0"],
    ["-O3", "-march=native", "-fopenmp-simd", "-fno-math-errno", "-ffp-contract=fast"],
    ["-O3", "-march=native", "-fopenmp-simd", "-ffp-contract=off"],
    ["-O2", "-march=x86-64-v2"],
)
CASES = [
    ("double_pendulum", "inverse_dynamics"),
    ("arm7", "inverse_dynamics"),
    ("cart_pole", "forward_dynamics"),
    ("puma560", "mass_matrix"),
    ("free_body", "forward_dynamics"),
    ("four_bar", "forward_dynamics"),
]


def drawn(function, count: int, seed: int = 1) -> list[np.ndarray]:
    """Random pairs for every argument, (count, n, 2); low parts as large as they may be."""
    rng = np.random.default_rng(seed)
    high = [rng.uniform(0.2, 2.0, (count, len(a.symbols))) for a in function.arguments]
    return [np.stack([a, rng.uniform(-0.5, 0.5, a.shape) * np.spacing(a)], -1) for a in high]


def worst(function, given: list[np.ndarray], found: np.ndarray) -> float:
    """The largest error of an entry over the largest entry, against 60 digits."""
    numbers, largest = BigFloats(60), mpmath.mpf(0)
    for k in range(len(given[0])):
        values = {
            symbol: numbers.number(high) + numbers.number(low)
            for argument, array in zip(function.arguments, given, strict=True)
            for symbol, (high, low) in zip(argument.symbols, array[k].tolist(), strict=True)
        }
        exact = evaluate(function.entries, numbers, values)
        got = [numbers.number(high) + numbers.number(low) for high, low in found[k].reshape(-1, 2).tolist()]
        scale = max(abs(x) for x in exact)
        largest = max(largest, *(abs(a - b) / scale for a, b in zip(got, exact, strict=True)))
    return float(largest)


@pytest.mark.heavy("arm7", "puma560", "four_bar")
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize(("name", "output"), CASES)
def test_results_have_29_digits_and_more(name, output):
    program = lower(symdyn.dynamics.derive(symdyn.example(name), [output]))
    function = program.routines[0].function
    given = drawn(function, 20)
    found = build(program, real="dd").functions[0](*given)
    assert found.shape == (20, *function.shape, 2)
    assert worst(function, given, found) < 1e-29
    high, low = found[..., 0], found[..., 1]
    assert np.array_equal(high + low, high)


@pytest.mark.long
@pytest.mark.runs("cc")
def test_every_operation_is_as_right_state_by_state_and_in_batches_of_any_length():
    program = lower(spoken("c", "dd"))
    module = build(program, real="dd")
    for name in ("matrix", "scalar", "rotated"):
        function = program[name].function
        given = drawn(function, 35)
        given[2] = given[2][:1]
        call = getattr(module, name)
        found = call(*given)
        assert worst(function, [given[0], given[1], np.repeat(given[2], 35, 0)], found) < 1e-30
        for k in (0, 7, 34):
            assert np.array_equal(call(given[0][k], given[1][k], given[2][0]), found[k])
        for count in (1, 15, 16, 17, 33):
            assert np.array_equal(call(given[0][:count], given[1][:count], given[2]), found[:count])
    assert module.empty(*given).shape == (35, 1, 0, 2)
    assert np.array_equal(module.nothing(*given), np.zeros((35, 2, 2)))


@pytest.mark.runs("cc")
def test_a_wrong_shape_is_told():
    with pytest.raises(ValueError, match=r"matrix: q has shape \(3, 2\); its last dimensions must be \(2, 2\)"):
        build(lower(spoken("c", "dd")), real="dd").matrix(np.zeros((3, 2)), np.zeros((2, 2)), np.zeros((1, 2)))


def test_numbers_of_a_scene_are_those_that_were_written_and_not_their_doubles():
    tenth = Fraction(1, 10)
    high, low = halves(tenth)
    assert abs(Fraction(high) + Fraction(low) - tenth) < Fraction(1, 2**108)
    g = Graph()
    q = g.symbol("q1")
    text = emit(lower(one([q + tenth, q * tenth, q * Fraction(5, 2), q * 4], [q])), "c", "dd")["hand.c"]
    assert f"dd_add(q_1, dd_of({high!r}, {low!r}))" in text
    assert f"dd_mul(dd_of({high!r}, {low!r}), q_1)" in text or f"dd_mul(q_1, dd_of({high!r}, {low!r}))" in text
    assert "dd_times(q_1, 2.5)" in text
    assert "dd_scale(q_1, 4.0)" in text


CALL = """
#include <stdio.h>
#include "puma560.h"
int main(void)
{
    double q[12 * 20], out[72 * 20];
    for (int k = 0; k < 12 * 20; k++) {
        scanf("%la", q + k);
    }
    puma560_mass_matrix_rows(20, q, out);
    for (int k = 0; k < 72 * 20; k++) {
        printf("%a\\n", out[k]);
    }
    return 0;
}
"""


@pytest.mark.wide("compiler0")
@pytest.mark.long
@pytest.mark.parametrize("compiler", COMPILERS)
def test_it_is_as_right_however_it_is_compiled(compiler, tmp_path):
    """Also where compilers fuse products with sums, which would count the low part of a product twice."""
    program = lower(symdyn.dynamics.derive(symdyn.example("puma560"), ["mass_matrix"]))
    function = program.routines[0].function
    sources = emit(program, "c", "dd", option="batch")
    given = drawn(function, 20)
    told = "\n".join(float(x).hex() for x in given[0].ravel())

    def error(flags):
        subprocess.run([*compiler, *flags, "puma560.c", "call.c", "-o", "call", "-lm"], cwd=tmp_path, check=True)
        ran = subprocess.run([tmp_path / "call"], input=told, capture_output=True, text=True, check=True)
        return worst(function, given, np.array([float.fromhex(x) for x in ran.stdout.split()]).reshape(20, 6, 6, 2))

    write(sources, tmp_path)
    (tmp_path / "call.c").write_text(CALL)
    assert max(map(error, FLAGS)) < 1e-30


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("option", ["", "batch", "header-only"])
def test_the_example_beside_it_comes_out_and_the_c_is_clean(compiler, option, tmp_path):
    sources = emit(lower(spoken("c", "dd")), "c", "dd", option=option)
    write({**sources, **beside(sources)}, tmp_path)
    files = [name for name in ("every_op.c", "main.c") if (tmp_path / name).is_file()]
    lint = LINT if "-x" not in compiler else ["-Wall", "-Wextra"]
    subprocess.run([*compiler, *lint, "-O1", *files, "-o", "example", "-lm"], cwd=tmp_path, check=True)
    ran = subprocess.run([tmp_path / "example"], capture_output=True, text=True, check=True)
    assert ran.stdout.count(" right ") == 5
    text = (tmp_path / files[0]).read_text() if option != "header-only" else (tmp_path / "every_op.h").read_text()
    place = tmp_path / ("every_op.h" if option == "header-only" else "every_op.c")
    place.write_text(text.replace("a - (s - t)", "a - (s + t)"))
    subprocess.run([*compiler, "-O1", *files, "-o", "example", "-lm"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "example"], capture_output=True, check=False).returncode == 1


@pytest.mark.long
@pytest.mark.runs("cc")
def test_two_headers_stand_in_one_file(tmp_path):
    for name in ("first", "second"):
        g = Graph()
        q = g.symbol("q1")
        write(emit(lower(one([g.sin(q)], [q], symdyn.Scene(name))), "c", "dd", option="header-only"), tmp_path)
    (tmp_path / "both.c").write_text(
        '#include "first.h"\n#include "second.h"\nint main(void) { double x[2] = {1, 0}, y[2], z[2];\n'
        "first_f(x, y); second_f(x, z); return y[0] != z[0]; }\n"
    )
    subprocess.run([GCC, *LINT, "both.c", "-o", "both", "-lm"], cwd=tmp_path, check=True)
    subprocess.run([tmp_path / "both"], check=True)


@pytest.mark.long
@pytest.mark.runs("cc")
def test_what_depends_on_parameters_alone_is_prepared():
    program = lower(symdyn.dynamics.derive(symdyn.example("two_link"), ["inverse_dynamics"]))
    apart = prepare(program)
    plain, split = build(program, real="dd"), build(apart, real="dd")
    *state, params = drawn(program["inverse_dynamics"].function, 18)
    params = params[:1]
    first = split.inverse_dynamics(*state, split.prepare(params))
    assert np.abs(plain.inverse_dynamics(*state, params) - first)[..., 0].max() < 1e-14
    assert worst(program["inverse_dynamics"].function, [*state, np.repeat(params, 18, 0)], first) < 1e-29


@pytest.mark.runs("cc")
def test_fast_math_is_refused(tmp_path):
    write(emit(lower(spoken("c", "dd")), "c", "dd"), tmp_path)
    said = subprocess.run([GCC, "-ffast-math", "-c", "every_op.c"], cwd=tmp_path, capture_output=True, check=False)
    assert said.returncode != 0
    assert b"compile without -ffast-math" in said.stderr


@pytest.mark.parametrize("op", [Op.EXP, Op.LOG, Op.TANH, Op.ATAN2, Op.POW, Op.SELECT])
def test_functions_that_there_are_none_of_are_refused_in_words(op):
    g = Graph()
    q = g.symbol("q1")
    program = lower(one([g.function(op, *[q, q, g.one][: op.arity])], [q]))
    with pytest.raises(EmitError, match=f"real type dd lacks {op.name.lower()}, which f needs: its functions of 31"):
        emit(program, "c", "dd")


def test_the_command_line_writes_it_and_refuses_it_elsewhere(tmp_path, capsys):
    scene = str(EXAMPLES / "pendulum.toml")
    assert main(["generate", scene, "--target", "c", "--real", "dd", "--batch", "-o", str(tmp_path)]) == 0
    assert "--real dd --batch" in (tmp_path / "pendulum.h").read_text()
    assert "double-doubles" in (tmp_path / "pendulum.h").read_text()
    capsys.readouterr()
    assert main(["generate", scene, "--target", "numpy", "--real", "dd"]) == 1
    assert "takes double or float alone; leave --real out" in capsys.readouterr().err
