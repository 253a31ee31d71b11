"""Cycles of generated C with ARM's vectors, estimated: cross-compiled, and its loops read by llvm-mca.

    python benchmarks/neon.py [--core neoverse-v1] [--ghz 2.6] [--docs docs]

Nothing is run here: llvm-mca knows how long operations of a core take and which units do them, and assumes that all
data is in the nearest cache. `tests/test_neon.py` runs the same code in an emulator. Needs aarch64-linux-gnu-gcc and
llvm-mca 17 or later, which describes the core; on Debian: gcc-aarch64-linux-gnu, libc6-dev-arm64-cross, llvm-19.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

from symdyn.table import Table

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT)]

import symdyn  # noqa: E402
from symdyn.emit import emit  # noqa: E402
from symdyn.emit.targets.c.writer import CHAINS  # noqa: E402
from symdyn.program import Program  # noqa: E402

COMPILER = "aarch64-linux-gnu-gcc"
MCA = (*(f"llvm-mca-{number}" for number in range(22, 16, -1)), "llvm-mca")
MARKS = (
    "<!-- What follows, up to the next mark, is written by `python benchmarks/neon.py --docs docs`. -->",
    "<!-- end -->",
)

ROBOTS = ("arm7", "puma560")
OUTPUTS = ("inverse_dynamics", "forward_dynamics", "mass_matrix")

MACHINE = ("-march=armv8.2-a",)
"""NEON, which all of these cores have, and not the longer vectors of some."""

PAIR = 2
"""Doubles in a vector of NEON."""

ROUNDS = 100
"""Turns of a loop that llvm-mca follows."""


def main() -> int:
    """Print a table in Markdown, or put it into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--core", default="neoverse-v1")
    parser.add_argument("--ghz", type=float, default=2.6, help="its clock, for the column in ns")
    parser.add_argument("--docs", help="folder whose performance.md gets the table")
    options = parser.parse_args()
    analyser = next((name for name in MCA if shutil.which(name)), None)
    if analyser is None or shutil.which(COMPILER) is None:
        print(f"benchmarks: needs {COMPILER} and llvm-mca 17 or later", file=sys.stderr)
        return 1
    text = table(analyser, options.core, options.ghz)
    if not options.docs:
        print(text)
        return 0
    page = Path(options.docs) / "performance.md"
    head, _, rest = page.read_text("utf-8").partition(MARKS[0])
    page.write_text(f"{head}{MARKS[0]}\n\n{text}\n\n{MARKS[1]}{rest.partition(MARKS[1])[2]}", "utf-8")
    return 0


def table(analyser: str, core: str, ghz: float) -> str:
    """Return what is estimated of every robot and output."""
    version = re.search(r"version ([0-9.]+)", said(analyser, "--version"))
    rows = []
    about = (
        f"Estimated, not measured: gcc {said(COMPILER, '-dumpfullversion').strip()} with `-O3 {' '.join(MACHINE)}`, "
        f"loops read by llvm-mca {version[1] if version else ''}, data in the nearest cache, {ghz:g} GHz.\n\n"
    )
    for robot in ROBOTS:
        for output in OUTPUTS:
            program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example(robot), [output]))
            loop, turn = cycles(program, output, analyser, core)
            angles = program[output].counts.sincos * turn
            rows.append((f"{robot}, {output}", f"{loop:.0f}", f"{angles:.0f}", f"{(loop + angles) / ghz:.0f}"))
    heads = (f"batch, a state on {core}", "cycles of the loop", "of sines and cosines", "ns")
    return about + Table(heads, rows, (1, 2, 3)).markdown(str)


def cycles(program: Program, output: str, analyser: str, core: str) -> tuple[float, float]:
    """Return cycles of one state in the loops of a function, and of one sine with its cosine."""
    sources = emit(program, "c", option="batch").files
    header, text = sources[1], sources[0][1]
    joined = str(text).replace(f'#include "{header[0]}"', str(header[1]))
    flags = ["-O3", *MACHINE, "-ffp-contract=fast", "-fopenmp-simd", "-fno-math-errno"]
    assembly = said(COMPILER, *flags, "-xc", "-S", "-o", "-", "-", given=joined)
    passes = re.findall(rf"^{output}_pass[0-9]+[.\w]*:.*?\.size", assembly, re.DOTALL | re.MULTILINE)
    halves = re.findall(r"^(?:remainders|series)[.\w]*:.*?\.size", assembly, re.DOTALL | re.MULTILINE)
    loop = sum(turns(one, analyser, core) for one in passes) / PAIR
    return loop, sum(turns(one, analyser, core) for one in halves) / (PAIR * CHAINS)


def turns(function: str, analyser: str, core: str) -> float:
    """Return cycles of one turn of the loop of a function that has the most vectors."""
    lines = function.splitlines()
    labels = {line[:-1]: place for place, line in enumerate(lines) if re.fullmatch(r"\.L\w+:", line)}
    loops = []
    for place, line in enumerate(lines):
        found = re.match(r"\s+(?:b[a-z.]+|cbn?z\s+\w+,)\s+(\.L\w+)", line)
        if found and labels.get(found[1], place) < place:
            body = [one for one in lines[labels[found[1]] : place + 1] if not re.match(r"\s*\.", one)]
            loops.append((sum(".2d" in one for one in body), -len(body), "\n".join(body)))
    body = max(loops)[2].replace(f"\t{max(loops)[2].split()[-1]}", "\t.")
    words = [analyser, "-mtriple=aarch64-linux-gnu", f"-mcpu={core}", f"-iterations={ROUNDS}"]
    found = re.search(r"Total Cycles:\s+(\d+)", said(*words, given=body))
    assert found is not None, "llvm-mca gives the number of cycles"
    assert ".2d" in body, "the loop is vector code"
    return int(found[1]) / ROUNDS


def said(*words: str, given: str = "") -> str:
    """Return what a program prints."""
    return subprocess.run(words, input=given, capture_output=True, text=True, check=True).stdout


if __name__ == "__main__":
    sys.exit(main())
