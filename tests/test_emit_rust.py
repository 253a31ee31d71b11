"""The module of Rust: no_std and clean under two compilers, our own sines to the bit, what `core` lacks to an ulp."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from arms import EXAMPLES, chain
from formulas import argument, function, spoken, states
from mechanisms import random_tree

from symdyn.cli import main
from symdyn.dynamics.outputs.derive import derive
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit import beside, emit, write
from symdyn.graph import Expr, Graph, Op
from symdyn.program import lower
from symdyn.runtime import build, run_python
from symdyn.runtime.c_module import run_rust
from symdyn.scene import Scene, read

pytestmark = [pytest.mark.targets, pytest.mark.runs("rustc")]

RUSTC = [path for path in ("rustc", "/usr/bin/rustc") if shutil.which(path)]
"""That of the path, and the oldest that is to do."""

TYPES = {"double": np.float64, "float": np.float32}


def crate(folder: Path, rustc: str, text: str, *flags: str) -> None:
    """Compile a library of a text that may hold the module beside it, without a word of the compiler."""
    (folder / "use.rs").write_text(text, encoding="utf-8")
    command = [rustc, "--edition=2021", "--crate-type=lib", "-Dwarnings", *flags, "use.rs"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("rustc", RUSTC)
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("flags", [(), ("-Ctarget-cpu=native", "-Copt-level=3"), ("-Cdebug-assertions",)])
def test_every_operation_is_clean_without_the_standard_library(
    rustc: str, real: str, flags: tuple[str, ...], tmp_path: Path
) -> None:
    write(emit(lower(spoken("rust")), "rust", real), tmp_path)
    crate(tmp_path, rustc, "#![no_std]\n#![deny(unsafe_op_in_unsafe_fn)]\nmod every_op;\n", *flags)
    crate(tmp_path, rustc, "mod every_op;\npub use every_op::scalar;\n", *flags)


@pytest.mark.parametrize("rustc", RUSTC)
def test_long_functions_in_parts_prepared_ones_and_static_ones_are_clean(rustc: str, tmp_path: Path) -> None:
    long = emit(lower(derive(chain(90), ("inverse_dynamics",))), "rust")
    write(long, tmp_path)
    assert "inverse_dynamics_part4(" in long["chain90.rs"]
    crate(tmp_path, rustc, "mod chain90;\n")
    for words in (["--prepare"], ["--static"]):
        scene = str(EXAMPLES / "two_link.toml")
        assert main(["generate", scene, "--target", "rust", *words, "-o", str(tmp_path)]) == 0
        crate(tmp_path, rustc, "#![no_std]\nmod two_link;\n")


@pytest.mark.parametrize("rustc", RUSTC)
@pytest.mark.parametrize("real", ["double", "float"])
def test_functions_over_many_states_are_clean(rustc: str, real: str, tmp_path: Path) -> None:
    write(emit(lower(spoken("rust")), "rust", real, option="batch"), tmp_path)
    crate(tmp_path, rustc, "#![no_std]\nmod every_op;\n")
    words = ["--target", "rust", "--batch", "--prepare", "--real", real, "-o", str(tmp_path)]
    assert main(["generate", str(EXAMPLES / "two_link.toml"), *words]) == 0
    crate(tmp_path, rustc, "#![no_std]\nmod two_link;\n", "-Ctarget-cpu=native", "-O")


@pytest.mark.parametrize("real", ["double", "float"])
def test_many_states_are_those_of_one_state_a_call(real: str) -> None:
    equations = spoken("rust")
    code, plain = run_rust(emit(lower(equations), "rust", real, option="batch")), run_python(emit(lower(equations)))
    for count in (2, 63, 64, 65, 150):
        q, qd, _ = states(equations, "matrix", count)
        for name in ("matrix", "scalar", "nothing", "chosen", "rotated"):
            found = getattr(code, name)(q, qd, [1.25])
            tolerance = 1e-13 if real == "double" else 1e-4
            np.testing.assert_allclose(found, getattr(plain, name)(q, qd, [1.25]), rtol=tolerance, atol=tolerance)


def test_many_states_of_long_functions() -> None:
    for scene in (read(EXAMPLES / "arm7.toml"), chain(90)):
        equations = derive(scene, ("inverse_dynamics",))
        given = states(equations, "inverse_dynamics", 70)
        found = run_rust(emit(lower(equations), "rust", option="batch")).inverse_dynamics(*given)
        wanted = run_python(emit(lower(equations))).inverse_dynamics(*given)
        assert np.abs(found - wanted).max() <= 1e-13 * np.abs(wanted).max()


def test_slices_of_other_lengths_are_refused(tmp_path: Path) -> None:
    write(emit(lower(spoken("rust")), "rust", option="batch"), tmp_path)
    call = "every_op::scalar_rows(&[[0.0; 2]; 3], &[[0.0; 2]; LENGTH], &[1.0], &mut [0.0; 3])"
    for length, told in (("3", ""), ("2", "qd and out have as many states")):
        (tmp_path / "main.rs").write_text(f"mod every_op;\nfn main() {{ {call.replace('LENGTH', length)} }}\n")
        subprocess.run(["rustc", "--edition=2021", "main.rs"], cwd=tmp_path, check=True)
        ran = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (ran.returncode == 0) is (not told)
        assert told in ran.stderr


def test_clippy_says_nothing(tmp_path: Path) -> None:
    if shutil.which("clippy-driver") is None:
        pytest.skip("no clippy-driver")
    write(emit(lower(spoken("rust")), "rust"), tmp_path)
    crate(tmp_path, "clippy-driver", "mod every_op;\n")


@pytest.mark.parametrize("option", ["", "batch"])
def test_an_angle_that_is_a_parameter_has_sine_and_cosine_too(option: str, tmp_path: Path) -> None:
    program = lower(derive(random_tree(0), ("inverse_dynamics",)))
    sources = emit(program, "rust", option=option)
    text = sources["random0.rs"]
    assert all(f"fn {name}_of(x: f64)" in text for name in ("sine", "cosine"))
    crate(tmp_path, RUSTC[0], str(text))

    given = [np.full(len(a.symbols), 0.3) for a in program.routines[0].function.arguments]
    ours = run_python(emit(program)).inverse_dynamics(*given)
    np.testing.assert_allclose(run_rust(emit(program, "rust")).inverse_dynamics(*given), ours, rtol=1e-13)


def test_functions_are_those_of_c_short_and_in_parts() -> None:
    for scene, count in ((read(EXAMPLES / "arm7.toml"), 200), (chain(90), 3)):
        equations = derive(scene, ("inverse_dynamics",))
        given = states(equations, "inverse_dynamics", count)
        found = run_rust(emit(lower(equations), "rust")).inverse_dynamics(*given)
        wanted = build(emit(lower(equations), "c")).inverse_dynamics(*given)
        assert np.abs(found - wanted).max() <= 1e-13 * np.abs(wanted).max()


def test_floats_are_floats() -> None:
    equations = spoken("rust")
    given = [a[0] for a in states(equations, "matrix", 1)]
    found = run_rust(emit(lower(equations), "rust", "float")).matrix(*given)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, run_python(emit(lower(equations))).matrix(*given), rtol=2e-5)


@pytest.mark.parametrize("rustc", RUSTC)
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_example_knows_what_must_come_out(rustc: str, real: str, tmp_path: Path) -> None:
    sources = emit(lower(spoken("rust")), "rust", real)
    write({**sources, **beside(sources)}, tmp_path / "every")
    words = ["--prepare", "--real", real, "--functions", "inverse_dynamics,kinetic_energy"]
    scene = str(EXAMPLES / "two_link.toml")
    assert main(["generate", scene, "--target", "rust", *words, "-o", str(tmp_path / "two")]) == 0
    for folder, count in ((tmp_path / "every", 5), (tmp_path / "two", 3)):
        subprocess.run([rustc, "--edition=2021", "-Dwarnings", "main.rs"], cwd=folder, check=True)
        ran = subprocess.run(["./main"], cwd=folder, capture_output=True, text=True, check=False)
        assert (ran.returncode, ran.stdout.count(" right ")) == (0, count)


# Sine and cosine


def sine_and_cosine() -> Equations:
    g = Graph()
    q = g.symbol("q1")
    return Equations(Scene("hand"), g, (function("f", [argument("q", [q])], (2,), [g.sin(q), g.cos(q)]),))


def run_f(equations: Equations, real: str = "double", portable: bool = False) -> Any:
    """Return f of many states, one call each, in Rust, for this machine or without fused operations."""
    with pytest.MonkeyPatch.context() as patch:
        if portable:
            patch.setenv("RUSTC", "rustc -Ctarget-cpu=x86-64-v2")
        code = run_rust(emit(lower(equations), "rust", real))
    (routine,) = lower(equations).routines
    return lambda angles: over(code.f._call, angles, routine.function.shape[0], TYPES[real])


def over(call: Any, arguments: np.ndarray, size: int, dtype: Any) -> np.ndarray:
    """Call a function of C over rows, without what a call of Python's costs besides."""
    rows = np.ascontiguousarray(arguments, dtype)
    out = np.empty((len(rows), size), dtype)
    taken, given, step, width = rows.ctypes.data, out.ctypes.data, rows.strides[0], out.strides[0]
    for k in range(len(rows)):
        call(taken + k * step, given + k * width)
    return out


@pytest.mark.usefixtures("optimised")
@pytest.mark.parametrize("machine", ["native", "portable"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_sines_have_the_bits_of_ours_in_c(machine: str, real: str) -> None:
    """gcc fuses products with sums where it optimises alone, Rust wherever the machine can: else last bits differ."""
    rng = np.random.default_rng(1)
    spans = [3.2, 1e3, 2.0**20]
    angles = np.concatenate([rng.uniform(-span, span, 300_000) for span in spans])
    quarters = rng.integers(-600_000, 600_000, 100_000) * (np.pi / 2)
    small = np.exp(rng.uniform(-740, 0, 100_000)) * rng.choice([-1, 1], 100_000)
    angles = np.concatenate([angles, quarters, small, [0.0, -0.0, 5e-324, -5e-324, 2.0**-240]]).astype(TYPES[real])
    angles = angles[np.abs(angles) < 2**20]
    assert len(angles) > 999_000

    ours = build(lower(sine_and_cosine()), real=real, machine=machine).f(angles[:, None])
    found = run_f(sine_and_cosine(), real, machine == "portable")(angles[:, None])
    bits = "u8" if real == "double" else "u4"
    assert np.array_equal(found.view(bits), ours.view(bits))


@pytest.mark.parametrize("real", ["double", "float"])
def test_huge_angles_are_right_to_one_ulp(real: str) -> None:
    rng, dtype = np.random.default_rng(2), TYPES[real]
    top = np.finfo(dtype).maxexp
    angles = np.ldexp(rng.uniform(0.5, 1, 3000), rng.integers(20, top + 1, 3000)) * rng.choice([-1, 1], 3000)
    closest = [6381956970095103.0 * 2.0**797, 5319372648326541.0 * 2.0**200, np.finfo(float).max] if top > 128 else []
    angles = np.concatenate([angles, [2.0**20, -(2.0**20), 1e22], closest]).astype(dtype)
    assert worst(run_f(sine_and_cosine(), real)(angles[:, None]), angles[:, None], (mpmath.sin, mpmath.cos)) <= 1


def test_what_is_not_finite_gives_not_a_number() -> None:
    with np.errstate(all="ignore"):
        found = run_f(sine_and_cosine())(np.array([[np.nan], [np.inf], [-np.inf], [1.0]]))
    assert np.isnan(found).all(axis=1).tolist() == [True, True, True, False]


def worst(found: np.ndarray, given: np.ndarray, exact: tuple[Any, ...]) -> float:
    """Return the largest error in units of the last place."""
    most = 0.0
    with mpmath.workprec(1300):
        for row, values in zip(found, given, strict=True):
            x = [mpmath.mpf(float(value)) for value in values]
            for value, true in zip(row, (f(*x) for f in exact), strict=True):
                unit = float(np.spacing(abs(type(value)(float(true)))))
                most = max(most, float(abs(mpmath.mpf(float(value)) - true) / mpmath.mpf(unit)))
    return most


# What `core` lacks


def of(*ops: Op, arguments: int = 1) -> Equations:
    g = Graph()
    q: list[Expr] = [g.symbol(f"q{k}") for k in range(1, arguments + 1)]
    entries = [g.function(op, *q) for op in ops]
    return Equations(Scene("hand"), g, (function("f", [argument("q", q)], (len(ops),), entries),))


SPANS = {
    Op.EXP: (mpmath.exp, [(-707.9, 709.7), (-1, 1), (-1e-8, 1e-8)]),
    Op.LOG: (mpmath.log, [(0, 1e-300), (0, 1e-310), (0.5, 2), (0.999, 1.001), (0, 1e300)]),
    Op.TANH: (mpmath.tanh, [(-25, 25), (-0.6, 0.6), (-1e-8, 1e-8), (0.54, 0.56)]),
    Op.SQRT: (mpmath.sqrt, [(0, 1e-310), (0, 4), (0, 1e300)]),
}
ULPS = {Op.EXP: 1.0, Op.LOG: 1.0, Op.TANH: 2.0, Op.SQRT: 0.5}


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("op", SPANS, ids=lambda op: op.name)
def test_elementary_functions_are_right_to_an_ulp(op: Op, real: str) -> None:
    exact, spans = SPANS[op]
    rng, dtype = np.random.default_rng(4), TYPES[real]
    with np.errstate(over="ignore"):
        x = np.concatenate([rng.uniform(*span, 2000) for span in spans]).astype(dtype)
    x = x[np.isfinite(x) & ((x > 0) | (op not in (Op.LOG, Op.SQRT)))]
    if real == "float" and op is Op.EXP:
        x = x[(x > -86.9) & (x < 88.7)]
    found = run_f(of(op), real)(x[:, None])
    assert worst(found, x[:, None], (exact,)) <= (ULPS[op] if real == "double" else 0.5001)


@pytest.mark.parametrize("real", ["double", "float"])
def test_angles_of_points_are_right_to_an_ulp(real: str) -> None:
    rng, dtype = np.random.default_rng(5), TYPES[real]
    points = rng.uniform(-1, 1, (4000, 2)) * np.exp(rng.uniform(-30, 30, (4000, 2)))
    points = np.concatenate([points, rng.uniform(-1, 1, (4000, 2)), [[1, 1], [1, -1], [0.5, 0.5], [1e-300, -1]]])
    points = points.astype(dtype)
    found = run_f(of(Op.ATAN2, arguments=2), real)(points)
    assert worst(found, points, (mpmath.atan2,)) <= (1.5 if real == "double" else 0.5001)


def test_edges_are_those_of_the_c_library() -> None:
    edges = np.array([0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 5e-324, 1e308, -1e308])
    pairs = np.array([[y, x] for y in edges for x in edges])
    with np.errstate(all="ignore"):
        found = run_f(of(Op.ATAN2, arguments=2))(pairs)[:, 0]
        np.testing.assert_array_max_ulp(found, np.arctan2(*pairs.T), 1)
        assert np.array_equal(np.signbit(found)[~np.isnan(found)], np.signbit(np.arctan2(*pairs.T))[~np.isnan(found)])
        for op, same in (
            (Op.LOG, np.log),
            (Op.TANH, np.tanh),
            (Op.SQRT, np.sqrt),
            (Op.ABS, np.abs),
            (Op.SIGN, np.sign),
        ):
            alone = run_f(of(op))(edges[:, None])[:, 0]
            np.testing.assert_array_max_ulp(alone, same(edges), 1)
            if op is not Op.LOG:
                assert np.signbit(alone[:2]).tolist() == [False, op is not Op.ABS]
        exponential = run_f(of(Op.EXP))(np.append(edges, [-708.5, 710.0])[:, None])[:, 0]
        np.testing.assert_array_max_ulp(exponential[:7], np.exp(edges[:7]), 1)
        assert exponential[7:].tolist() == [1.0, np.inf, 0.0, 0.0, np.inf]


def test_square_roots_without_the_machines_are_rounded_as_they_are(tmp_path: Path) -> None:
    text = emit(lower(of(Op.SQRT)), "rust")["hand.rs"]
    (tmp_path / "hand.rs").write_text(text.replace('target_feature = "sse2"', 'target_feature = "none of it"'))
    calls = '#[path = "hand.rs"]\nmod hand;\n#[no_mangle]\npub extern "C" fn root(q: &[f64; 1], out: &mut [f64; 1]) '
    (tmp_path / "calls.rs").write_text(f"{calls}{{ hand::f(q, out) }}\n")
    command = ["rustc", "--edition=2021", "--crate-type=cdylib", "-O", "calls.rs", "-o", "calls.so"]
    subprocess.run(command, cwd=tmp_path, check=True)
    call = ctypes.CDLL(str(tmp_path / "calls.so")).root
    call.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    x = np.random.default_rng(6).integers(0, 0x7FF0_0000_0000_0000, 200_000).view(np.float64)
    x = np.concatenate([x, x * 1e-160, [0.0, -0.0, np.inf, np.nan, -1.0, 5e-324, 4.0]])
    with np.errstate(all="ignore"):
        assert np.array_equal(over(call, x[:, None], 1, np.float64)[:, 0], np.sqrt(x), equal_nan=True)


def test_fused_operations_are_there_only_where_the_target_has_them(tmp_path: Path) -> None:
    write(emit(lower(derive(read(EXAMPLES / "arm7.toml"), ("inverse_dynamics",))), "rust"), tmp_path)
    made = {}
    for cpu in ("x86-64", "x86-64-v3"):
        crate(tmp_path, "rustc", "pub mod arm7;\n", "-O", f"-Ctarget-cpu={cpu}", "--emit=asm")
        made[cpu] = (tmp_path / "use.s").read_text()
    if os.uname().machine == "x86_64":
        assert re.search(r"\bvfn?m(add|sub)", made["x86-64-v3"])
    assert not re.search(r"\bvfn?m(add|sub)|call.*\bfma", made["x86-64"])
