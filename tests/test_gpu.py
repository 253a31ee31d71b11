"""Kernels for CUDA and OpenCL: as C++ right to the bit, compiled by nvcc, run by PyOpenCL; and their examples."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import sysconfig
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cuda_on_host import compiled, launcher, run
from formulas import every_op, states

from symdyn.dynamics import derive
from symdyn.emit import Sources, beside, emit, write
from symdyn.errors import BuildError, MissingProgram
from symdyn.program import Program, in_lines, lower, prepare
from symdyn.program.routine import shared
from symdyn.runtime import RUNNERS, build, run_python
from symdyn.scene import example
from symdyn.verify.written import READERS, printed, prove_texts
from symdyn.verify.written.proof import Files

OUTPUTS = (
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
)


def program(name: str) -> Program:
    if name == "every_op":
        return lower(every_op())
    scene, _, way = name.partition(" ")
    made = lower(derive(example(scene), OUTPUTS))
    return prepare(made) if way else made


def with_library_angles(sources: Sources) -> Sources:
    """Return C that takes angles of points by the library's function, as kernels do, in place of its own."""
    changed = [(name, re.sub(r"(?<!double )atan2_of\(", "atan2(", text)) for name, text in sources.texts.items()]
    return replace(sources, files=tuple(changed))


def given(routine: Any, n: int, real: str) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return arguments of n states as rows and as columns; what is shared is one set in both."""
    rng = np.random.default_rng(1)
    dtype = {"double": np.float64, "float": np.float32}[real]
    common = shared([a.name for a in routine.function.arguments])
    rows, columns = [], []
    for a in routine.function.arguments:
        x = rng.uniform(0.2, 2.0, (1 if a.name == common else n, len(a.symbols))).astype(dtype)
        rows.append(x)
        columns.append(np.ascontiguousarray(x.T))
    return rows, columns


@pytest.mark.wide("every_op-double", "two_link-float")
@pytest.mark.runs("g++", "gcc")
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("name", ["every_op", "two_link", "two_link prepared", "four_bar", "arm7"])
def test_a_kernel_as_cpp_computes_what_scalar_c_does_to_the_bit(
    name: str, real: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = program(name)
    sources = emit(made, "gpu", real)
    stem = next(iter(sources)).removesuffix(".cu")
    names = [f"{stem}_{one}" for one in sources.functions]
    library = launcher(sources.texts[f"{stem}.cu"], tmp_path, names, [len(r.function.arguments) for r in made.routines])
    monkeypatch.setenv("CC", "gcc -ffp-contract=off -O1 -mno-fma")
    c = build(with_library_angles(emit(in_lines(made), "c", real)), machine="portable")

    n = 300
    for one, kernel, routine in zip(sources.functions, names, made.routines, strict=True):
        rows, columns = given(routine, n, real)
        size = len(routine.function.entries)
        out = np.full((size + 1, n), np.nan, rows[0].dtype if rows else np.float64)
        found = run(library, kernel, n, columns, out)
        wanted = np.array([getattr(c, one)(*(x[k % len(x)] for x in rows)) for k in range(n)]).reshape(n, size)
        np.testing.assert_array_equal(found[:size].T, wanted, err_msg=one)
        assert np.isnan(found[size]).all(), "nothing is written beyond the result"


@pytest.mark.wide(2)
@pytest.mark.runs("g++")
@pytest.mark.parametrize("threads", [24, 32])
def test_blocks_of_any_size_up_to_the_bound_give_the_same_bits(threads: int, tmp_path: Path) -> None:
    scene = example("puma560")
    made = lower(derive(scene, ["forward_dynamics_derivatives"]))
    text = emit(made, "gpu").texts["puma560.cu"]
    assert "waiting_places" in text
    name, n = "puma560_forward_dynamics_derivatives", 100
    _, columns = given(made.routines[0], n, "double")
    found = []
    for count in (None, threads):
        folder = tmp_path / str(count)
        folder.mkdir()
        library = launcher(text, folder, [name], [3], count)
        found.append(run(library, name, n, columns, np.full((108, n), np.nan)))
    np.testing.assert_array_equal(found[1], found[0])
    assert np.isfinite(found[0]).all()


@pytest.mark.long(0)
def test_what_waits_is_read_back_and_a_wrong_place_is_seen() -> None:
    made = lower(derive(example("arm7"), ["forward_dynamics_derivatives"]))
    sources = emit(made, "gpu")
    text = sources.texts["arm7.cu"]
    fetched = re.findall(r"= (waiting\[\d+ \* (\d+)\]);", text)
    assert len(fetched) > 100
    assert int(fetched[0][1]) in (32, 64, 128)
    wrong = (
        text.replace(f"= {fetched[50][0]};", f"= {fetched[51][0]};", 1),
        text.replace(f"= {fetched[50][0]};", "= waiting[1];", 1),
        text.replace("waiting_places + threadIdx.x", "waiting_places"),
        re.sub(r"(waiting_places\[)\d+", r"\g<1>5", text, count=1),
        text.replace("again(n) + k", "again(k) + k", 1),
        text.replace(f"__launch_bounds__({fetched[0][1]})", "__launch_bounds__(256)"),
        text.replace("__shared__ ", ""),
    )
    program = printed(made, "double")
    for one in (text, *wrong):
        files = Files("gpu", "", "arm7", sources.functions, {"arm7.cu": one})
        (told,) = prove_texts(program, files, READERS["gpu"])
        assert told.passed == (one == text), told.where


@pytest.mark.parametrize(("real", "size"), [("double", 8), ("float", 4)])
def test_the_bytes_that_are_told_hold_what_waits(real: str, size: int) -> None:
    text = emit(lower(derive(example("arm7"), ["forward_dynamics_derivatives"])), "gpu", real).texts["arm7.cu"]
    (told,) = re.findall(r"wait in (\d+) bytes", text)
    ((places, block),) = re.findall(r"waiting_places\[(\d+) \* (\d+)\];", text)

    assert int(told) == int(places) * int(block) * size


@pytest.mark.wide("two_link-double", "four_bar-float")
@pytest.mark.runs("g++")
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("name", ["two_link", "two_link prepared", "four_bar"])
def test_the_example_is_right_and_tells_a_wrong_sign(name: str, real: str, tmp_path: Path) -> None:
    sources = emit(program(name), "gpu", real)
    stem = next(iter(sources)).removesuffix(".cu")
    kernels, main = sources.texts[f"{stem}.cu"], beside(sources)[f"{stem}_main.cu"]
    for text, status in ((kernels, 0), (re.sub(r"(out\[0 \* n \+ k\] = )", r"\1-", kernels), 1)):
        (tmp_path / f"{stem}.cu").write_text(text, encoding="utf-8")
        done = subprocess.run([compiled(main, tmp_path)], capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stdout + done.stderr
        assert ("WRONG" in done.stdout) == bool(status)
        assert done.stdout.count("\n") == len(sources.functions)


def test_both_spellings_hold_the_same_lines_and_floats_hold_no_double() -> None:
    sources = emit(program("four_bar"), "gpu", "float")
    cuda, opencl = (sources.texts[f"four_bar{ending}"] for ending in (".cu", ".cl"))

    def lines(text: str) -> list[str]:
        body = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
        return [line for line in body.splitlines() if re.match(r" +(const float \w+ =|out\[)", line)]

    plain = [re.sub(r"\b(sin|cos|sqrt)f\(", r"\1(", line) for line in lines(cuda)]
    assert [line for line in lines(opencl) if "sincos" not in line] == plain
    assert len(plain) > 100
    numbers = re.findall(r"(?<![\w.])(\d+\.\d+(?:e[+-]?\d+)?)(\w?)", "\n".join(lines(cuda)))
    assert {suffix for _, suffix in numbers} == {"f"}
    assert not re.search(r"\bdouble\b|fp64", re.sub(r"/\*.*?\*/", "", opencl, flags=re.DOTALL))


def test_sine_and_cosine_of_one_angle_are_taken_together() -> None:
    text = emit(program("two_link"), "gpu").texts["two_link.cl"]

    assert "const double s1 = sincos(q_1, &c1);" in text
    assert not re.search(r"= (sin|cos)\(q_1\);\n.*= (sin|cos)\(q_1\);", text)


def nvcc() -> str:
    """Return the path of nvcc: the system's, or that of the package nvidia-cuda-nvcc."""
    packages = Path(sysconfig.get_paths()["purelib"]) / "nvidia"
    found = shutil.which("nvcc") or next((str(path) for path in packages.glob("*/bin/nvcc")), None)
    if found is None:
        pytest.skip("no nvcc; pip install nvidia-cuda-nvcc nvidia-cuda-runtime")
    return found


@pytest.mark.targets
@pytest.mark.runs
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("name", ["every_op", "two_link prepared", "four_bar", "puma560", "arm7"])
def test_nvcc_compiles_kernels_and_the_example_without_a_word(name: str, real: str, tmp_path: Path) -> None:
    compiler = nvcc()
    sources = emit(program(name), "gpu", real)
    stem = next(iter(sources)).removesuffix(".cu")
    write({**sources, **beside(sources)}, tmp_path)
    for file, flags in ((f"{stem}.cu", ["-cubin", "-Xptxas", "-v"]), (f"{stem}_main.cu", ["-c"])):
        command = [compiler, "-arch=sm_90", "-Werror", "all-warnings", *flags, file, "-o", "made"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        told = [line for line in done.stderr.splitlines() if "bytes spill" in line]
        if "-v" in flags:
            assert told
            assert all(" 0 bytes spill stores, 0 bytes spill loads" in line for line in told)


@pytest.mark.targets
@pytest.mark.runs
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("name", ["two_link", "two_link prepared"])
def test_the_example_of_opencl_is_right_and_tells_a_wrong_sign(name: str, real: str, tmp_path: Path) -> None:
    opencl(program(name), real)
    sources = emit(program(name), "gpu", real)
    write({**sources, **beside(sources)}, tmp_path)
    for status in (0, 1):
        command = [sys.executable, "two_link_main.py"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stdout + done.stderr
        assert done.stdout.count("\n") == len(sources.functions)
        text = (tmp_path / "two_link.cl").read_text(encoding="utf-8")
        (tmp_path / "two_link.cl").write_text(text.replace("] = x", "] = -x"), encoding="utf-8")


def opencl(made: Program, real: str = "double") -> Any:
    try:
        return RUNNERS["gpu"].run(emit(made, "gpu", real))
    except MissingProgram as missing:
        pytest.skip(str(missing))


@pytest.mark.targets
@pytest.mark.runs
@pytest.mark.parametrize("count", [1, 2, 127, 1000])
def test_opencl_takes_any_number_of_states_and_params_of_one_or_of_each(count: int) -> None:
    made = lower(every_op())
    module, plain = opencl(made), run_python(emit(made))
    q, qd, params = states(every_op(), "matrix", count)
    for some in (params, params[0]):
        np.testing.assert_allclose(module.matrix(q, qd, some), plain.matrix(q, qd, some), rtol=1e-13, atol=1e-14)
    assert module.empty(q, qd, params).shape == (count, 1, 0)


@pytest.mark.targets
@pytest.mark.runs
def test_what_opencl_refuses_is_told_in_its_own_words() -> None:
    sources = emit(lower(every_op()), "gpu")
    opencl(lower(every_op()))
    broken = tuple((name, str(text).replace("const ulong k", "const ulong")) for name, text in sources.files)
    with pytest.raises(BuildError, match="OpenCL refused the code"):
        RUNNERS["gpu"].run(type(sources)(sources.program, "gpu", "double", "", sources.functions, broken))
