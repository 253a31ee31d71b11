"""What the compiler reports: every batch loop became vector code, on every vector unit it is compiled for."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from arms import EXAMPLES
from formulas import one

from symdyn.dynamics import derive
from symdyn.emit import emit, write
from symdyn.graph import Graph, Op
from symdyn.program import lower
from symdyn.runtime.commands import FLAGS
from symdyn.scene import read

pytestmark = [pytest.mark.runs("gcc"), pytest.mark.usefixtures("optimised")]

MACHINES = {
    "sse2": (["-march=x86-64"], 16),
    "avx2": (["-march=x86-64-v3"], 32),
    "avx512": (["-march=x86-64-v4", "-mprefer-vector-width=512"], 64),
}
REPORTS = {"gcc": ["-fopt-info-vec-optimized"], "clang": ["-Rpass=loop-vectorize"]}
LOOP = re.compile(r"#pragma omp simd[^\n]*\n( *)for .*?\n\1}\n", re.DOTALL)


def loops(text: str) -> list[range]:
    """Return the lines of every loop that a pragma asks to be vector code; a report may name any of them."""
    return [range(text.count("\n", 0, m.start()) + 1, text.count("\n", 0, m.end()) + 1) for m in LOOP.finditer(text)]


def missed(text: str, found: dict[int, int], width: int) -> list[range]:
    """Return the loops without vectors of at least `width` bytes."""
    return [lines for lines in loops(text) if not any(found.get(line, 0) >= width for line in lines)]


def vectorised(compiler: str, flags: list[str], source: Path) -> dict[int, int]:
    """Return by line number the widest vectors, in bytes, of the loops that the compiler says it vectorised."""
    command = [compiler, *FLAGS, *flags, *REPORTS[compiler], source.name, "-o", "library.so", "-lm"]
    ran = subprocess.run(command, cwd=source.parent, capture_output=True, text=True, check=True)
    widths: dict[int, int] = {}
    gcc = re.finditer(r"\.c:(\d+):\d+: optimized: loop vectorized using (\d+) byte", ran.stderr)
    clang = re.finditer(r"\.c:(\d+):\d+: remark: vectorized loop \(vectorization width: (\d+)", ran.stderr)
    for found in gcc if compiler == "gcc" else clang:
        size = int(found[2]) * (1 if compiler == "gcc" else 8)
        widths[int(found[1])] = max(size, widths.get(int(found[1]), 0))
    return widths


def on_this_family(compiler: str) -> bool:
    if shutil.which(compiler) is None:
        return False
    ran = subprocess.run([compiler, "-dumpmachine"], capture_output=True, text=True, check=False)
    return ran.stdout.startswith("x86_64")


@pytest.fixture(scope="module")
def arm():
    outputs = ("inverse_dynamics", "forward_dynamics", "mass_matrix")
    return lower(derive(read(EXAMPLES / "arm7.toml"), outputs))


@pytest.mark.wide("double-avx2-clang", "float-sse2-gcc")
@pytest.mark.parametrize("compiler", REPORTS)
@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("real", ["double", "float"])
def test_every_batch_loop_is_vectorised(arm, compiler, machine, real, tmp_path):
    if not on_this_family(compiler):
        pytest.skip(f"no {compiler} for x86-64")
    flags, width = MACHINES[machine]
    source, _ = write(emit(arm, "c", real, option="batch"), tmp_path)
    asked = loops(source.read_text())
    found = vectorised(compiler, flags, source)

    text = source.read_text()
    assert len(asked) == text.count("#pragma omp simd") > 4 + len(arm.routines), "of sincos, of rows, and of functions"
    assert missed(text, found, width) == []


@pytest.mark.runs("gcc")
def test_calls_of_the_library_leave_the_other_loops_vectorised(tmp_path):
    g = Graph()
    q = [g.symbol(f"q{i}") for i in range(4)]
    slope = g.function(Op.TANH, q[0] * q[1])
    entries = [slope + g.sqrt(1 + q[2] * q[2]) * g.sin(q[3] + k * slope) / (2 + slope) for k in range(4)]
    source, _ = write(emit(lower(one(entries, q)), "c", option="batch"), tmp_path)
    text = source.read_text()
    assert any("tanh(" in part and "#pragma" not in part.split("\n}")[0] for part in text.split("_pass"))
    assert missed(text, vectorised("gcc", MACHINES["avx2"][0], source), 32) == []


@pytest.mark.runs("gcc")
def test_the_report_tells_when_a_loop_is_not_vectorised(arm, tmp_path):
    source, _ = write(emit(arm, "c", option="batch"), tmp_path)
    text = source.read_text()
    source.write_text(text.replace("n[j] = shifted[j]", "n[j] = sin(a[j]) * shifted[j]", 1))
    assert missed(text, vectorised("gcc", MACHINES["avx2"][0], source), 32) == [loops(text)[1]]
