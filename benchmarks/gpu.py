"""Kernels for GPUs: what nvcc makes of them, and how fast they are next to what a card can do.

    python benchmarks/gpu.py --compile [--arch sm_90,...]      registers, shared memory, spills: needs nvcc, no card
    python benchmarks/gpu.py --compile --free                    the same with inertias left open, which are `params`
    python benchmarks/gpu.py --check [--arch sm_90]              results of peers as far as no card is needed: nvcc
    python benchmarks/gpu.py [--arch native]                     times: needs nvcc and a card

Times are of 16 to a million states that lie on the card, medians of 7 rounds by the card's own clock. The limit is the
lower rate of two: of memory, as a kernel that copies finds it, and of arithmetic, as a kernel of multiply-adds finds
it, if every sum were fused with a product. A launch of an empty kernel is told apart. What kernels compute is held
against the equations, and so is what peers do that are installed (`pip install grid-rbd mujoco-mjx "jax[cuda13]"`):
GRiD's kernels, and MJX, whose calls are dispatched from Python. Times have not been measured yet: there was no card.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from symdyn.table import Table

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(Path(__file__).resolve().parent), str(ROOT)]

from bars import Bar, at_most  # noqa: E402
from cases import STATES, Case  # noqa: E402
from gpu_peers import FD, ID, TIMED, Said, checked, compared, given, ran  # noqa: E402
from native import HERE, MissingError  # noqa: E402

import symdyn  # noqa: E402
from symdyn.emit import budgets, emit  # noqa: E402
from symdyn.emit.code import REALS, SINGLE  # noqa: E402
from symdyn.emit.targets.gpu_budget import SIZES, Budget  # noqa: E402
from symdyn.program import Program, formulate, lower  # noqa: E402
from symdyn.scene import with_symbols  # noqa: E402

ARCHITECTURES = "sm_80,sm_90,sm_100"
ROBOTS = ("arm7", "puma560", "quadruped")
OUTPUTS = (ID, FD, "inverse_dynamics_derivatives", "forward_dynamics_derivatives")
FEW, PUBLISHED = 256, {ID: 11.3, "inverse_dynamics_derivatives": 22.6}
"""States, and µs of GRiD 0.6 for so many of a seven-axis arm, on an RTX 5090."""

NUMBERS = ("q", "qd", "qdd", "tau")
"""What the program of times is given, in its order."""

SAID = re.compile(
    r"Compiling entry function '(\w+)'.*?(\d+) bytes spill stores, (\d+) bytes spill loads.*?Used (\d+) registers",
    re.DOTALL,
)
"""What ptxas says of a kernel."""


@dataclass(frozen=True)
class Compiled:
    """One kernel, compiled: its registers, and bytes that it spills (stored and loaded)."""

    robot: str
    real: str
    arch: str
    kernel: str
    registers: int
    spilled: int
    room: Budget


def main() -> int:
    """Print a table in Markdown, and bars."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--compile", action="store_true", help="compile, and run nothing")
    parser.add_argument("--check", action="store_true", help="compare results of peers, and time nothing")
    parser.add_argument("--arch", help="of the card, as nvcc names it; several for --compile, with commas between")
    parser.add_argument("--robots", default=",".join(ROBOTS), help="examples for --compile")
    parser.add_argument("--free", action="store_true", help="leave inertias open for --compile, as params")
    options = parser.parse_args()
    nvcc = shutil.which("nvcc")
    if nvcc is None:
        print("benchmarks: needs nvcc", file=sys.stderr)
        return 1
    if options.compile:
        found = []
        for arch in (options.arch or ARCHITECTURES).split(","):
            for robot in options.robots.split(","):
                for real in SINGLE:
                    found += (here := compiled(nvcc, robot, real, arch, options.free))
                    spilled = max(one.spilled for one in here)
                    print(f"{robot}, {real}, {arch}: {spilled} bytes spilled by a kernel at most", file=sys.stderr)
        print(table(found))
        print("\n".join(f"- {bar.text}: {bar.wanted}, {bar.shown}, {bar.verdict}" for bar in bars(found)))
        return 0
    case = Case(TIMED, symdyn.example(TIMED))
    if options.check:
        for real in SINGLE:
            print("\n".join(checked(case, real, nvcc, options.arch or "sm_90")))
        return 0
    arch = options.arch or ("native" if shutil.which("nvidia-smi") else "sm_90")
    for real in SINGLE:
        try:
            said = times(case, nvcc, real, arch).checked(case, real)
        except MissingError as fault:
            print(f"benchmarks: {fault}; --compile and --check need no card", file=sys.stderr)
            return 1
        print(told(program_of(TIMED), real, said))
        print(compared(case, real, said, nvcc, arch))
    return 0


def program_of(robot: str, free: bool = False) -> Program:
    """Return what is compiled of an example, its inertias left open or not."""
    scene = symdyn.example(robot)
    if free:
        named = with_symbols(scene, "inertia")
        scene = replace(named, parameters=tuple(replace(one, value=None) for one in named.parameters))
    return lower(formulate(scene, OUTPUTS))


def compiled(nvcc: str, robot: str, real: str, arch: str, free: bool = False) -> list[Compiled]:
    """Return what ptxas says of the kernels of an example."""
    program = program_of(robot, free)
    sources = emit(program, "gpu", real)
    runs = dict(zip(sources.functions, budgets(program, REALS[real]), strict=True))
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "kernels.cu").write_text(sources.texts[f"{robot}.cu"], "utf-8")
        command = [nvcc, f"-arch={arch}", "-Xptxas", "-v", "-cubin", "kernels.cu", "-o", "made"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"nvcc refused {robot} in {real} for {arch}: {done.stderr[:500]}")
    found = []
    for name, stores, loads, registers in sorted(SAID.findall(done.stderr)):
        kernel = name.removeprefix(f"{robot}_")
        spilled = int(stores) + int(loads)
        found.append(Compiled(robot, real, arch, kernel, int(registers), spilled, runs[kernel]))
    return found


def table(found: list[Compiled]) -> str:
    """Return all kernels, a line each."""
    heads = (
        "kernel", "type", "for", "registers", "bytes spilled", "threads a block", "values that wait", "shared bytes",
        "parts", "operations", "of all parts",
    )  # fmt: skip
    rows = []
    for one in found:
        places, block = one.room.places, one.room.block
        numbers = (one.spilled, places * block * SIZES[one.real], one.room.once, one.room.operations)
        spilled, shared, once, operations = (f"{number:,}" for number in numbers)
        rows.append(
            (f"{one.robot}, {one.kernel.replace('_', ' ')}", one.real, one.arch, one.registers, spilled, block, places,
             shared, len(one.room.plans), once, operations)
        )  # fmt: skip
    return Table(heads, rows, range(3, 11)).markdown(str) + "\n"


def bars(found: list[Compiled]) -> list[Bar]:
    """Return whether nothing spills, a bar a robot and type."""
    rows = dict.fromkeys((one.robot, one.real) for one in found)
    said = []
    for robot, real in rows:
        most = max(one.spilled for one in found if (one.robot, one.real) == (robot, real))
        said.append(Bar(f"kernels of {robot} in {real}, bytes spilled by any", "0", f"{most:,}", most == 0))
    return said


def times(case: Case, nvcc: str, real: str, arch: str) -> Said:
    """Return what a card takes for the kernels of one arm; MissingError where there is no card."""
    program = program_of(TIMED)
    sources = emit(program, "gpu", real)
    runs = budgets(program, REALS[real])
    listed = []
    for name, routine, run in zip(sources.functions, program.routines, runs, strict=True):
        places = ", ".join(f"a[{NUMBERS.index(one.name)}]" for one in routine.function.arguments)
        listed.append(f"T({TIMED}_{name}, {run.block}, {len(run.plans)}, {len(routine.function.entries)}, {places})")
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        given(case, folder)
        head = f"#define REAL {real}\n#define AXES {case.n}\n#define KERNELS(T) {' '.join(listed)}\n"
        text = f'{sources.texts[f"{TIMED}.cu"]}{head}#include "gpu_times.cu"\n'
        (folder / "times.cu").write_text(text, "utf-8")
        command = [nvcc, "-O3", "-std=c++17", f"-arch={arch}", f"-I{HERE}", "times.cu", "-o", "times"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"nvcc refused the program for {arch}: {done.stderr[:500]}")
        said = ran(["./times"], folder, f"{TIMED}_")
    return replace(said, results=[(name, x.reshape(-1, STATES).T) for name, x in said.results])  # columns


def told(program: Program, real: str, said: Said) -> str:
    """Return what was taken as a table, with the share of the limit that each kernel reaches."""
    seconds = dict(said.seconds)
    at = {name: (n, taken) for (name, n), taken in seconds.items() if name in ("copy", "fused", "nothing")}
    bytes_a_second = 2 * SIZES[real] * at["copy"][0] / at["copy"][1]
    fused_a_second = at["fused"][0] / at["fused"][1]
    about = (
        f"{said.card}, {real}: a launch takes {at['nothing'][1] * 1e6:.2f} µs, memory "
        f"{bytes_a_second / 1e9:.0f} GB/s, {fused_a_second / 1e9:.0f} thousand million multiply-adds a second."
    )
    rows, reached = [], []
    for routine in program.routines:
        function, counts = routine.function, routine.counts
        moved = (len(routine.inputs) + len(function.entries)) * SIZES[real]
        limit = max(moved / bytes_a_second, max(counts.multiplications, counts.additions) / fused_a_second)
        batches = sorted(n for name, n in seconds if name == function.name)
        for n in batches:
            taken = seconds[function.name, n]
            share = limit * n / taken
            rows.append((function.name, f"{n:,}", f"{taken * 1e6:.2f}", f"{taken / n * 1e9:.3f}", f"{share:.0%}"))
        reached.append(Bar(f"{function.name} in {real}, share of the limit", "≥ 70 %", f"{share:.0%}", share >= 0.7))
        rate = moved * n / taken / bytes_a_second
        reached.append(Bar(f"{function.name} in {real}, share of memory's rate", "≥ 50 %", f"{rate:.0%}", rate >= 0.5))
        if function.name in PUBLISHED:
            text, taken = f"{function.name} in {real}, {FEW} states", seconds[function.name, FEW]
            reached.append(at_most(text, PUBLISHED[function.name], taken * 1e6, "µs"))
    heads = ("kernel", "states", "µs", "ns a state", "share of the limit")
    text = Table(heads, rows, range(1, 5)).markdown(str)
    return "\n".join(
        [about, "", text, "", *(f"- {bar.text}: {bar.wanted}, {bar.shown}, {bar.verdict}" for bar in reached), ""]
    )


if __name__ == "__main__":
    sys.exit(main())
