"""The header of C++: clean under strict compilers, C's own numbers, floats, duals of a stranger, Eigen."""

from __future__ import annotations

import ctypes
import os
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES, chain
from formulas import argument, every_op, function, states

from symdyn.cli import main
from symdyn.dynamics.outputs.derive import derive
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import Sources, beside, emit, write
from symdyn.graph import Graph
from symdyn.program import lower
from symdyn.runtime import build, run_python
from symdyn.runtime.c_module import run_cpp
from symdyn.scene import Scene, read

pytestmark = [pytest.mark.runs("g++"), pytest.mark.usefixtures("optimised")]

STRICT = ["-std=c++17", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror"]

EIGEN = [os.environ.get("EIGEN3_INCLUDE_DIR", ""), "/usr/include/eigen3", "/usr/local/include/eigen3"]
"""Folders that may hold Eigen; CMake knows the variable, too."""

DUAL = """
namespace stranger {
struct Dual {
    double v, d;
    Dual(double value = 0.0, double slope = 0.0) : v(value), d(slope) {}
};
inline Dual operator+(Dual a, Dual b) { return {a.v + b.v, a.d + b.d}; }
inline Dual operator-(Dual a, Dual b) { return {a.v - b.v, a.d - b.d}; }
inline Dual operator-(Dual a) { return {-a.v, -a.d}; }
inline Dual operator*(Dual a, Dual b) { return {a.v * b.v, a.d * b.v + a.v * b.d}; }
inline Dual operator/(Dual a, Dual b) { return {a.v / b.v, (a.d * b.v - a.v * b.d) / (b.v * b.v)}; }
inline bool operator<(Dual a, Dual b) { return a.v < b.v; }
inline bool operator>(Dual a, Dual b) { return a.v > b.v; }
inline Dual sin(Dual a) { return {std::sin(a.v), a.d * std::cos(a.v)}; }
inline Dual cos(Dual a) { return {std::cos(a.v), -a.d * std::sin(a.v)}; }
inline Dual sqrt(Dual a) { return {std::sqrt(a.v), a.d / (2 * std::sqrt(a.v))}; }
inline Dual exp(Dual a) { return {std::exp(a.v), a.d * std::exp(a.v)}; }
inline Dual log(Dual a) { return {std::log(a.v), a.d / a.v}; }
inline Dual pow(Dual a, Dual b)
{
    const double z = std::pow(a.v, b.v);
    return {z, z * (b.v * a.d / a.v + b.d * std::log(a.v))};
}
inline Dual tanh(Dual a) { return {std::tanh(a.v), a.d * (1 - std::tanh(a.v) * std::tanh(a.v))}; }
inline Dual abs(Dual a) { return a.v < 0 ? -a : a; }
inline Dual atan2(Dual y, Dual x)
{
    return {std::atan2(y.v, x.v), (y.d * x.v - y.v * x.d) / (x.v * x.v + y.v * y.v)};
}
}
"""


def compiled(text: str, folder: Path, *flags: str, compiler: str = "g++") -> ctypes.CDLL:
    """Return a library of a text that includes the header beside it, compiled without a word of the compiler."""
    (folder / "use.cpp").write_text(text, encoding="utf-8")
    command = [compiler, *STRICT, *flags, "-shared", "-fPIC", "use.cpp", "-o", "use.so"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return ctypes.CDLL(str(folder / "use.so"))


def uses(sources: Sources, *types: str) -> str:
    """Return text that makes functions of every template, for numbers of these types."""
    (header,) = sources
    space = header.removesuffix(".hpp")
    lines = [f'#include "{header}"', DUAL]
    for routine, name in zip(sources.program.routines, sources.functions, strict=True):
        for k, real in enumerate(types):
            taken = [
                real if one.scalar else f"std::array<{real}, {len(one.symbols)}>" for one in routine.function.arguments
            ]
            named = [f"const {one} &x{i}" for i, one in enumerate(taken)]
            given = ", ".join(f"x{i}" for i in range(len(taken)))
            lines.append(f"auto use_{name}_{k}({', '.join(named)}) {{ return {space}::{name}({given}); }}")
    return "\n".join(lines) + "\n"


def numbers(*arrays: np.ndarray) -> list[ctypes.c_void_p]:
    return [ctypes.c_void_p(array.ctypes.data) for array in arrays]


@pytest.mark.parametrize("compiler", ["g++", pytest.param("clang++", marks=pytest.mark.runs("clang++"))])
def test_every_operation_is_clean_for_any_number(compiler: str, tmp_path: Path) -> None:
    sources = emit(lower(every_op()), "cpp")
    write(sources, tmp_path)
    compiled(uses(sources, "double", "float", "stranger::Dual"), tmp_path, "-O0", compiler=compiler)


@pytest.mark.wide("g++")
@pytest.mark.parametrize("compiler", ["g++", pytest.param("clang++", marks=pytest.mark.runs("clang++"))])
def test_angles_together_and_long_functions_in_parts_are_clean(compiler: str, tmp_path: Path) -> None:
    tree = emit(lower(derive(read(EXAMPLES / "arm7.toml"), ("inverse_dynamics", "mass_matrix"))), "cpp")
    long = emit(lower(derive(chain(90), ("inverse_dynamics",))), "cpp")
    write(tree, tmp_path)
    write(long, tmp_path)
    assert "own::sincos_row<" in next(iter(tree.texts.values()))
    assert "own::inverse_dynamics_part3(" in next(iter(long.texts.values()))
    text = uses(tree, "double", "float", "stranger::Dual") + uses(long, "double").replace(DUAL, "").replace(
        "use_", "use_long_"
    )
    compiled(text, tmp_path, "-O0", compiler=compiler)


def test_words_of_a_stranger_are_clean(tmp_path: Path) -> None:
    equations = every_op("double")
    nasty = 'ends */ int x; /* with "??/ \\ \u202e and\x07 @file \\'
    functions = tuple(replace(f, text=nasty, units="*/") for f in equations.functions)
    sources = emit(lower(Equations(equations.scene, equations.graph, functions)), "cpp", command=nasty)
    write(sources, tmp_path)
    assert "namespace double_ {" in sources["double_.hpp"]
    compiled('#include "double_.hpp"\n', tmp_path)


def test_doubles_are_those_of_c(tmp_path: Path) -> None:
    program = lower(derive(read(EXAMPLES / "arm7.toml"), ("inverse_dynamics",)))
    ours = build(emit(program, "c", option="batch"), compiler="gcc")
    given = states(derive(read(EXAMPLES / "arm7.toml"), ("inverse_dynamics",)), "inverse_dynamics", 200)
    found = run_cpp(emit(program, "cpp")).inverse_dynamics(*given)
    wanted = np.array([ours.inverse_dynamics(*(a[k] for a in given)) for k in range(200)])
    assert np.abs(found - wanted).max() <= 4 * np.spacing(np.abs(wanted).max())


def test_huge_angles_and_what_is_no_number_are_as_in_c() -> None:
    g = Graph()
    q = [g.symbol(f"q{k}") for k in range(1, 4)]
    entries = [f(x) for x in q for f in (g.sin, g.cos)]
    equations = Equations(Scene("hand"), g, (function("f", [argument("q", q)], (6,), entries),))
    call = run_cpp(emit(lower(equations), "cpp")).f
    angles = np.random.default_rng(3).uniform(-9, 9, (500, 3))
    angles[:40] = [1e-300, -0.0, 2.0**19]
    angles[40:80, 1] = [2.0**20, -1e300] * 20
    found = call(angles)
    exact = np.stack([f(angles[:, k]) for k in range(3) for f in (np.sin, np.cos)], axis=-1)
    assert np.all(np.abs(found - exact) <= np.spacing(np.abs(exact)))
    assert np.array_equal(np.signbit(found[:40]), np.signbit(exact[:40]))
    with np.errstate(invalid="ignore"):
        lost = call([[np.nan, 1.0, np.inf], [0.5, 1.0, 2.0]])
    assert np.isnan(lost[0]).tolist() == [True, True, False, False, True, True]
    assert np.isfinite(lost[1]).all()


def test_every_operation_in_float_and_in_duals(tmp_path: Path) -> None:
    equations = every_op()
    sources, plain = emit(lower(equations), "cpp"), run_python(emit(lower(equations)))
    write(sources, tmp_path)
    body = """
extern "C" void floats(const float *q, const float *qd, const float *p, float *out)
{
    every_op::raw::matrix(q, qd, p, out);
}
extern "C" void duals(const double *q, const double *qd, const double *p, const double *to, double *out)
{
    using stranger::Dual;
    const auto r = every_op::matrix(std::array<Dual, 2>{Dual(q[0], to[0]), Dual(q[1], to[1])},
                                 {Dual(qd[0], to[2]), Dual(qd[1], to[3])}, {Dual(p[0], to[4])});
    for (std::size_t i = 0; i < r.size(); i++) {
        out[i] = r[i].v;
        out[r.size() + i] = r[i].d;
    }
}
"""
    library = compiled(f'#include "every_op.hpp"\n{DUAL}{body}', tmp_path, "-O0")
    given = [a[0] for a in states(equations, "matrix", 1)]
    wanted = plain.matrix(*given)

    single = np.empty(6, "float32")
    library.floats(*numbers(*(a.astype("float32") for a in given), single))
    np.testing.assert_allclose(single.reshape(2, 3), wanted, rtol=2e-5)

    to, out = np.array([0.3, -0.5, 0.7, 0.2, 0.9]), np.empty(12)
    library.duals(*numbers(*given, to, out))
    step = 1e-6
    moved = [plain.matrix(given[0] + h * to[:2], given[1] + h * to[2:4], given[2] + h * to[4:]) for h in (step, -step)]
    np.testing.assert_allclose(out[:6].reshape(2, 3), wanted, rtol=1e-13)
    np.testing.assert_allclose(out[6:].reshape(2, 3), (moved[0] - moved[1]) / (2 * step), rtol=1e-7, atol=1e-8)


def test_duals_of_a_stranger_find_our_derivatives(tmp_path: Path) -> None:
    equations = derive(read(EXAMPLES / "arm7.toml"), ("inverse_dynamics", "inverse_dynamics_derivatives"))
    sources = emit(lower(equations), "cpp")
    write(sources, tmp_path)
    body = """
extern "C" void column(const double *x, int k, double *out)
{
    using stranger::Dual;
    std::array<Dual, 7> a[3];
    for (int i = 0; i < 21; i++) {
        a[i / 7][std::size_t(i % 7)] = Dual(x[i], i == k ? 1.0 : 0.0);
    }
    const auto tau = arm7::inverse_dynamics(a[0], a[1], a[2]);
    for (std::size_t i = 0; i < 7; i++) {
        out[i] = tau[i].d;
    }
}
"""
    library = compiled(f'#include "arm7.hpp"\n{DUAL}{body}', tmp_path, "-O0")
    state = np.random.default_rng(5).uniform(-2, 2, 21)
    found, one = np.empty((7, 21)), np.empty(7)
    for k in range(21):
        library.column(*numbers(state), k, *numbers(one))
        found[:, k] = one
    wanted = run_python(emit(lower(equations))).inverse_dynamics_derivatives(*state.reshape(3, 7))
    np.testing.assert_allclose(found, wanted.reshape(7, 21), rtol=1e-12, atol=1e-12)


def test_lengths_and_types_are_checked_and_a_result_may_take_an_arguments_place(tmp_path: Path) -> None:
    write(emit(lower(every_op()), "cpp"), tmp_path)
    head = '#include "every_op.hpp"\n#include "every_op.hpp"\nconst std::array<double, 2> two{}; '
    library = compiled(
        head + 'extern "C" void turn(double *q) { const double m = 2; every_op::raw::rotated(q, q, &m, q); }', tmp_path
    )
    q = np.array([0.5, 0.25])
    wanted = run_python(emit(lower(every_op()))).rotated(q.copy(), q, [2.0])
    library.turn(*numbers(q))
    np.testing.assert_allclose(q, wanted, rtol=1e-15)

    calls = {
        "every_op::scalar(two, two, {1.0})": True,
        "every_op::scalar(two, two, {1.0, 2.0})": False,
        "every_op::scalar(two, std::array<double, 3>{}, {1.0})": False,
        "every_op::scalar(two, std::array<float, 2>{}, {1.0})": False,
    }
    for call, right in calls.items():
        (tmp_path / "call.cpp").write_text(f"{head}double x = {call};\n")
        command = ["g++", "-std=c++17", "-fsyntax-only", "call.cpp"]
        assert (subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode == 0) is right


def test_nothing_is_allocated_and_only_the_c_library_is_called(tmp_path: Path) -> None:
    sources = emit(lower(every_op()), "cpp")
    write(sources, tmp_path)
    compiled(uses(sources, "double", "float"), tmp_path, "-O0")
    told = subprocess.check_output(["nm", "-u", "use.so"], cwd=tmp_path, text=True)
    called = {line.split()[-1].split("@")[0].removesuffix("f") for line in told.splitlines()}
    own = {name for name in called if not name.startswith("_")} - {"sincos", "memcpy"}
    assert own <= {"sin", "cos", "sqrt", "exp", "log", "tanh", "atan2", "pow"}


@pytest.mark.slow
def test_vectors_and_maps_of_eigen(tmp_path: Path) -> None:
    folder = next((path for path in EIGEN if Path(path, "Eigen", "Core").is_file()), "")
    if not folder:
        pytest.skip("no Eigen; apt-get install libeigen3-dev")
    equations = every_op()
    write(emit(lower(equations), "cpp"), tmp_path)
    body = """
extern "C" void matrix(const double *q, const double *qd, double m, double *out)
{
    const Eigen::Map<const Eigen::Vector2d> place(q);
    const Eigen::RowVector2f speed{float(qd[0]), float(qd[1])};
    const Eigen::Matrix<double, 1, 1> mass(m);
    const Eigen::Matrix<double, 2, 3> found = every_op::matrix(place, speed, mass);
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>{out} = found;
    out[6] = every_op::scalar(place, 2 * place, mass);
    Eigen::Map<Eigen::Vector2d>{out + 7} = every_op::rotated(place, place, mass);
    static_assert(decltype(every_op::empty(place, place, mass))::ColsAtCompileTime == 0);
    const Eigen::VectorXd far = place;
    const Eigen::RowVectorXd beside = place.transpose();
    out[9] = every_op::scalar(far, 2 * beside, mass);
    out[10] = every_op::scalar(far, Eigen::VectorXd(3), mass);
    out[11] = every_op::rotated(Eigen::VectorXd(1), place, mass).norm();
}
"""
    first = '#include "every_op.hpp"\n#include <Eigen/Core>\n#include "every_op.hpp"\n'
    library = compiled(first + body, tmp_path, "-O0", "-DNDEBUG", "-isystem", folder)
    q, qd, out = np.array([0.5, 0.7]), np.array([1.5, 0.25]), np.empty(12)
    library.matrix.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p]
    library.matrix(q.ctypes.data, qd.ctypes.data, 1.25, out.ctypes.data)
    plain = run_python(emit(lower(equations)))
    np.testing.assert_allclose(out[:6].reshape(2, 3), plain.matrix(q, qd, [1.25]), rtol=1e-13)
    np.testing.assert_allclose(out[6], plain.scalar(q, 2 * q, [1.25]), rtol=1e-14)
    np.testing.assert_allclose(out[7:9], plain.rotated(q, q, [1.25]), rtol=1e-14)
    assert out[9] == out[6]
    assert np.isnan(out[10:]).all(), "a vector of another size: Eigen's assertion, or NaN where that is off"
    given = "Eigen::VectorXd(3), Eigen::VectorXd(2), Eigen::VectorXd(1)"
    aborts = f"{first}int main() {{ return int(every_op::scalar({given})); }}"
    (tmp_path / "aborts.cpp").write_text(aborts)
    subprocess.run(["g++", "-std=c++17", "-isystem", folder, "aborts.cpp", "-o", "aborts"], cwd=tmp_path, check=True)
    told = subprocess.run(["./aborts"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert told.returncode
    assert "a vector has another size than scalar takes" in told.stderr


def test_prepared_parameters_and_a_static_scene(tmp_path: Path) -> None:
    scene = str(EXAMPLES / "two_link.toml")
    for words in (["--prepare"], ["--static"]):
        assert main(["generate", scene, "--target", "cpp", *words, "-o", str(tmp_path)]) == 0
        compiled('#include "two_link.hpp"\n', tmp_path)


def many(sources: Sources, real: str, *names: str) -> str:
    """Return text that hands out functions over many states, of both layouts."""
    (header,) = sources
    lines = [f'#include "{header}"', 'extern "C" {']
    for routine in sources.program.routines:
        name, arguments = routine.function.name, routine.function.arguments
        for ending in ("_batch", "_rows"):
            taken = "".join(f"const {real} *{one.name}, " for one in arguments)
            given = "".join(f"{one.name}, " for one in arguments)
            call = f"{header.removesuffix('.hpp')}::raw::{name}{ending}(n, {given}out);"
            lines.append(f"void {name}{ending}(std::size_t n, {taken}{real} *out) {{ {call} }}")
    return "\n".join([*lines, "}\n"])


@pytest.mark.parametrize("real", ["double", pytest.param("float", marks=pytest.mark.runs("clang++"))])
def test_many_states_are_those_of_one_state_a_call(real: str, tmp_path: Path) -> None:
    equations = every_op()
    dtype, tolerance = {"double": ("f8", 1e-13), "float": ("f4", 1e-4)}[real]
    sources = emit(lower(equations), "cpp", option="batch")
    write(sources, tmp_path)
    compiler = "g++" if real == "double" else "clang++"
    library = compiled(many(sources, real), tmp_path, "-O0", compiler=compiler)
    plain = run_python(emit(lower(equations)))
    for count in (0, 1, 31, 32, 33, 70):
        q, qd, p = (a.astype(dtype) for a in states(equations, "matrix", count))
        p = np.full(1, 1.25, dtype)
        for name, size in (("matrix", 6), ("scalar", 1), ("nothing", 2), ("rotated", 2), ("empty", 0)):
            rows, columns = np.full((count, size), 7, dtype), np.full((size, count), 7, dtype)
            across = [np.ascontiguousarray(a.T) for a in (q, qd)]
            getattr(library, f"{name}_rows")(ctypes.c_size_t(count), *numbers(q, qd, p, rows))
            getattr(library, f"{name}_batch")(ctypes.c_size_t(count), *numbers(*across, p, columns))
            wanted = np.reshape(getattr(plain, name)(q, qd, p) if size else [], (count, size))
            np.testing.assert_allclose(rows, wanted, rtol=tolerance, atol=tolerance)
            assert np.array_equal(rows, columns.T)


def test_many_states_of_a_prepared_scene(tmp_path: Path) -> None:
    words = ["--target", "cpp", "--batch", "--prepare", "--functions", "inverse_dynamics", "-o", str(tmp_path)]
    assert main(["generate", str(EXAMPLES / "two_link.toml"), *words]) == 0
    use = '#include "two_link.hpp"\nauto prepare = two_link::raw::prepare_rows<double>;\n'
    compiled(f"{use}auto tau = two_link::raw::inverse_dynamics_rows<double>;\n", tmp_path, "-O0")


@pytest.mark.targets
def test_many_states_of_long_functions_in_parts_too() -> None:
    for scene in (read(EXAMPLES / "arm7.toml"), chain(90)):
        equations = derive(scene, ("inverse_dynamics",))
        given = states(equations, "inverse_dynamics", 70)
        found = run_cpp(emit(lower(equations), "cpp", option="batch")).inverse_dynamics(*given)
        wanted = run_python(emit(lower(equations))).inverse_dynamics(*given)
        assert np.abs(found - wanted).max() <= 1e-13 * np.abs(wanted).max()


def test_the_example_knows_what_must_come_out(tmp_path: Path) -> None:
    sources = emit(lower(every_op()), "cpp")
    write({**sources, **beside(sources)}, tmp_path / "every")
    words = ["--prepare", "--functions", "inverse_dynamics,kinetic_energy"]
    scene = str(EXAMPLES / "two_link.toml")
    assert main(["generate", scene, "--target", "cpp", *words, "-o", str(tmp_path / "two")]) == 0
    for folder, count in ((tmp_path / "every", 5), (tmp_path / "two", 3)):
        subprocess.run(["g++", *STRICT, "main.cpp", "-o", "main"], cwd=folder, check=True)
        ran = subprocess.run(["./main"], cwd=folder, capture_output=True, text=True, check=False)
        assert (ran.returncode, ran.stdout.count(" right ")) == (0, count)
    header = tmp_path / "two" / "two_link.hpp"
    header.write_text(header.read_text(encoding="utf-8").replace(" + ", " - "), encoding="utf-8")
    subprocess.run(["g++", "-std=c++17", "main.cpp", "-o", "main"], cwd=header.parent, check=True)
    assert subprocess.run(["./main"], cwd=header.parent, capture_output=True, check=False).returncode == 1
