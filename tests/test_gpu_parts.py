"""Kernels in parts: each part computes its share of the results, launched on any number of rows of blocks."""

from __future__ import annotations

import itertools
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cuda_on_host import compiled, launcher, run
from hypothesis import given as drawn, strategies as st
from test_gpu import given, opencl

import symdyn
from symdyn.emit import beside, emit, write
from symdyn.emit.code.spelling import REALS
from symdyn.emit.targets import gpu_budget as rooms_of
from symdyn.emit.targets.emit_program import Entries
from symdyn.emit.targets.gpu import budgets
from symdyn.emit.targets.gpu_budget import Line, shares
from symdyn.program import Program, formulate, lower
from symdyn.runtime import build, run_python
from symdyn.verify.written import READERS, printed, prove_texts
from symdyn.verify.written.proof import Files

SLOPES = "forward_dynamics_derivatives"


@pytest.fixture
def little(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a block have so little shared memory that two joints less than six have no room at once."""
    monkeypatch.setattr(rooms_of, "SHARED", 32 * 30 * 8)
    monkeypatch.setattr(rooms_of, "TWICE", 1000)


def puma(*requests: str) -> Program:
    return lower(formulate(symdyn.example("puma560"), requests or (SLOPES,)))


@pytest.mark.wide("99")
@pytest.mark.long(1)
@pytest.mark.usefixtures("little")
@pytest.mark.runs("g++", "gcc")
@pytest.mark.parametrize("rows", [1, 2, 99])
def test_parts_compute_what_scalar_c_does_to_the_bit_on_any_number_of_rows(
    rows: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program, name, n = puma(), f"puma560_{SLOPES}", 70
    text = emit(program, "gpu").texts["puma560.cu"]
    (room,) = budgets(program, REALS["double"])
    assert 1 < len(room.plans) == int(re.search(r"part < (\d+);", text)[1])
    assert room.places * room.block * 8 <= rooms_of.SHARED
    arguments = "n, a0, a1, a2, out"
    text += f"""
extern "C" void run_rows(unsigned blocks, size_t n, double *a0, double *a1, double *a2, double *out)
{{ {name}<<<dim3(blocks, {rows}), {room.block}>>>({arguments}); }}
"""
    library = launcher(text, tmp_path, [name], [3])
    monkeypatch.setenv("CC", "gcc -ffp-contract=off -O1 -mno-fma")
    c = getattr(build(emit(program, "c"), machine="portable"), SLOPES)
    states, columns = given(program.routines[0], n, "double")
    size = len(program.routines[0].function.entries)
    wanted = np.array([c(*(x[k] for x in states)) for k in range(n)]).reshape(n, size)
    for kernel in ("rows", name):
        out = run(library, kernel, n, columns, np.full((size + 1, n), np.nan))
        np.testing.assert_array_equal(out[:size].T, wanted)
        assert np.isnan(out[size]).all()


@pytest.mark.slow
@pytest.mark.long(0)
@pytest.mark.usefixtures("little")
@pytest.mark.runs("g++")
def test_examples_and_launchers_give_every_part_a_row(tmp_path: Path) -> None:
    sources = emit(puma(), "gpu")
    parts = len(budgets(sources.program, REALS["double"])[0].plans)
    made = Entries.of(sources).files["puma560.cu"]
    assert re.search(rf"<<<dim3\(\(unsigned\)\(\(n \+ 31\) / 32\), {parts}\), 32, 0,", made)
    assert f"<<<dim3((n + 31) / 32, {parts}), 32>>>(n, q, qd, tau, out);" in sources.texts["puma560.cu"]
    main = beside(sources)["puma560_main.cu"]
    assert f"<<<dim3((n + 31) / 32, {parts}), 32>>>" in main
    kernels = sources.texts["puma560.cu"]
    for text, status in ((kernels, 0), (kernels.replace("part == 1", "part == 9", 1), 1)):
        (tmp_path / "puma560.cu").write_text(text, encoding="utf-8")
        assert subprocess.run([compiled(main, tmp_path)], capture_output=True, check=False).returncode == status


@pytest.mark.long(0)
@pytest.mark.usefixtures("little")
def test_parts_are_read_and_what_is_wrong_with_them_is_seen() -> None:
    program = puma()
    sources = emit(program, "gpu")
    files = sources.texts
    for name, step in (("puma560.cu", "part += gridDim.y"), ("puma560.cl", "part += get_num_groups(1)")):
        text = files[name]
        (head,) = re.findall(r"    for \(u.*\{", text)
        wrong = (
            text.replace(step, "part += 1"),
            text.replace("part == 1)", "part == 0)", 1),
            re.sub(r"part < (\d)", "part < 9", text, count=1),
            re.sub(r"(if \(part == 0\) \{\n)", r"\1            const double z = x1;\n", text, count=1),
            re.sub(r"(if \(part == 1\) \{\n)", r"\1            const double z = waiting[0 * 32];\n", text, count=1),
            re.sub(r"(if \(part == 1\) \{\n)", r"\1            out[0 * symdyn_again(n) + k] = 0.0;\n", text, count=1),
            text.replace("if (part == 0) {\n", f"if (part == 0) {{\n{head} }}\n", 1),
        )
        for one in (text, *wrong):
            assert (one == text) == (one not in wrong), "every fault changes the text"
            given_files = Files("gpu", "", "puma560", sources.functions, {name: one})
            told = prove_texts(printed(program, "double"), given_files, READERS["gpu"])
            assert [x.passed for x in told] == [one == text], [x.where for x in told]


@pytest.mark.long(0)
def test_columns_without_room_leave_a_kernel_whole_where_that_costs_less(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rooms_of, "SHARED", 32 * 8 * 8)
    program = puma()
    (room,) = budgets(program, REALS["double"])
    assert len(room.plans) == 1
    assert room.places <= 8
    assert room.operations == room.once


@pytest.mark.long(0)
def test_a_kernel_is_cut_no_smaller_than_the_smallest_block_needs(
    little: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rooms_of, "SHARED", 32 * 50 * 8)
    (room,) = budgets(puma(), REALS["double"])
    assert len(room.plans) > 1
    assert 64 * room.places > 32 * 50 >= 32 * room.places


@pytest.mark.long(0)
def test_what_is_cheaper_to_spill_is_not_computed_twice(little: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rooms_of, "TWICE", 0)
    (room,) = budgets(puma(), REALS["double"])
    assert len(room.plans) == 1


@pytest.mark.slow
def test_parts_of_one_leg_come_together() -> None:
    program = lower(formulate(symdyn.example("quadruped"), (SLOPES,)))
    (room,) = budgets(program, REALS["float"])
    assert len(room.plans) == 2
    assert room.operations < 1.2 * room.once
    assert budgets(program, REALS["float"])[0] is room, "nothing is looked for twice"


@drawn(
    st.lists(st.lists(st.integers(0, 30), max_size=4), min_size=1, max_size=30),
    st.integers(1, 6),
    st.integers(1, 40),
)
def test_shares_hold_every_column_once_with_all_that_it_needs(reads: list[list[int]], width: int, most: int) -> None:
    lines = [Line((i,), tuple(dict.fromkeys(x for x in some if x < i))) for i, some in enumerate(reads)]
    lines += [Line((), (i % len(reads),)) for i in range(2 * width)]
    columns = [[len(reads) + column, len(reads) + width + column] for column in range(width)]
    found = shares(lines, [1] * len(lines), columns, lambda some: len(some) <= most)
    writes = [[place for place in share if not lines[place].makes] for share in found]
    assert sorted(itertools.chain(*writes)) == sorted(itertools.chain(*columns))
    for share, written in zip(found, writes, strict=True):
        assert len(share) <= most or written in columns, "what has no room is one column"
        there = {value for place in share for value in lines[place].makes}
        assert all(value in there for place in share for value in lines[place].reads)


@pytest.mark.usefixtures("little")
@pytest.mark.targets
@pytest.mark.runs
def test_the_example_of_opencl_in_parts_is_right_and_so_is_one_row(tmp_path: Path) -> None:
    program = puma()
    module, plain = opencl(program), run_python(emit(program))
    states, _ = given(program.routines[0], 40, "double")
    found, wanted = (getattr(one, SLOPES)(*states) for one in (module, plain))
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10)
    sources = emit(program, "gpu")
    write({**sources, **beside(sources)}, tmp_path)
    text = (tmp_path / "puma560_main.py").read_text(encoding="utf-8")
    parts = len(budgets(sources.program, REALS["double"])[0].plans)
    assert f"(queue, (1024, {parts}), (32, 1), " in text
    done = subprocess.run(
        [sys.executable, "puma560_main.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.runs("g++")
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_quadruped_in_parts_has_the_bits_of_the_whole(
    real: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, n, found = f"quadruped_{SLOPES}", 40, []
    for twice in (rooms_of.TWICE, -1):
        monkeypatch.setattr(rooms_of, "TWICE", twice)
        program = lower(formulate(symdyn.example("quadruped"), (SLOPES,)))
        text = emit(program, "gpu", real).texts["quadruped.cu"]
        assert ("part < " in text) == (twice > 0)
        folder = tmp_path / str(twice)
        folder.mkdir()
        states, columns = given(program.routines[0], n, real)
        out = np.full((972, n), np.nan, states[0].dtype)
        found.append(run(launcher(text, folder, [name], [3]), name, n, columns, out))
    assert np.isfinite(found[0]).all()
    np.testing.assert_array_equal(*found)


@pytest.mark.slow
@pytest.mark.targets
@pytest.mark.runs
@pytest.mark.skipif(shutil.which("nvcc") is None, reason="no nvcc")
@pytest.mark.parametrize(("real", "arch"), [("double", "sm_90"), ("float", "sm_80")])
def test_nvcc_spills_nothing_of_the_quadruped(real: str, arch: str, tmp_path: Path) -> None:
    requests = "inverse_dynamics", "forward_dynamics", "inverse_dynamics_derivatives", SLOPES
    write(emit(lower(formulate(symdyn.example("quadruped"), requests)), "gpu", real), tmp_path)
    flags = ["-Werror", "all-warnings", "-Xptxas", "-v"]
    command = ["nvcc", f"-arch={arch}", *flags, "-cubin", "quadruped.cu", "-o", "made"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    told = [line for line in done.stderr.splitlines() if "bytes spill" in line]
    assert told
    assert all(" 0 bytes spill stores, 0 bytes spill loads" in line for line in told)
