"""What large mechanisms take, in processor time: `python benchmarks/large_mechanisms.py [BODIES ..] [--loops N ..]`.

Chains of revolute joints about y and z in turn, their bodies numbers: reading the file, deriving inverse dynamics from
the scene that was read, C from there, the whole command `symdyn info`, and `symdyn generate` of forward dynamics. Rows
of four-bars, N closed loops: reading, and deriving forward dynamics, loops assembled and decided. Every figure is the
least of several processes. Then inverse and forward dynamics of chains as C that is a loop over a table, and as lines:
from the file to a result, and a call (`--tables N ..`). What was set out to be reached stands below.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import loops_over_tables
from bars import Bar, in_time, told
from loops_over_tables import ENVIRONMENT

from symdyn.scene import Starter

HERE = Path(__file__).resolve().parent.parent

BODY = """
[bodies.b{i}]
mass = 1
com = [0.1, 0, 0]
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"

[joints.j{i}]
type = "revolute"
parent = "{parent}"
child = "b{i}"
axis = [0, {y}, {z}]
origin = [0.2, 0, 0]
"""

MEASURE = """
import sys, time
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.program import lower
from symdyn.scene import read
times = [time.process_time()]
scene = read(sys.argv[1])
times.append(time.process_time())
equations = derive(scene, [sys.argv[2]])
times.append(time.process_time())
if len(sys.argv) > 3:
    emit(lower(equations), "c")
    times.append(time.process_time())
print(*(b - a for a, b in zip(times, times[1:])))
"""


TO_C = {64: 0.15, 256: 0.6, 1024: 3.0}
"""Seconds at most from the scene to C, by the bodies of a chain."""

WRITTEN = {256: 1.0, 1024: 3.0}
"""Seconds at most of `symdyn generate` of forward dynamics, files beside C included, by the bodies of a chain."""

LOOPS = {200: 2.0, 1000: 15.0}
"""Seconds at most of deriving, by the loops of a row."""


def chain(bodies: int) -> str:
    """Return a scene file of so many bodies in a row."""
    parents = ["ground", *(f"b{i}" for i in range(bodies))]
    parts = [BODY.format(i=i, parent=parents[i], y=i % 2, z=1 - i % 2) for i in range(bodies)]
    return 'name = "chain"\ngravity = [0, 0, -9.81]\n' + "".join(parts)


def main() -> None:
    """Print a row a chain."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bodies", nargs="*", type=int, default=[64, 256, 1024, 5000])
    parser.add_argument("--loops", nargs="*", type=int, default=[10, 40, 200, 1000])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--tables", nargs="*", type=int, default=[64, 256, 1024])
    given = parser.parse_args()
    bars: list[Bar] = []
    with tempfile.TemporaryDirectory() as folder:
        print(f"{'bodies':>8}{'read, s':>12}{'derive, s':>12}{'C, s':>12}{'info, s':>12}{'info, MB':>12}")
        for bodies in given.bodies:
            path = Path(folder, f"chain{bodies}.toml")
            path.write_text(chain(bodies), encoding="utf-8")
            info = "info", str(path)
            times = [(*_alone(path, "inverse_dynamics", "c"), *_command(*info)) for _ in range(given.runs)]
            least = _show(times, bodies)
            if bodies in TO_C:
                bars.append(in_time(f"chain of {bodies}, from the scene to C", TO_C[bodies], least[1] + least[2]))
            if bodies in WRITTEN:
                words = "generate", str(path), "--target", "c", "--functions", "forward_dynamics", "-o", folder
                seconds = min(_command(*words)[0] for _ in range(given.runs))
                bars.append(in_time(f"chain of {bodies}, forward dynamics generated", WRITTEN[bodies], seconds))
        print(f"\n{'loops':>8}{'read, s':>12}{'derive, s':>12}")
        for loops in given.loops:
            path = Path(folder, f"row{loops}.toml")
            path.write_text(Starter("row").from_template("n_four_bar", loops), encoding="utf-8")
            least = _show([_alone(path, "forward_dynamics") for _ in range(given.runs)], loops)
            if loops in LOOPS:
                bars.append(in_time(f"row of {loops} loops, derived", LOOPS[loops], least[1]))
        paths = {joints: Path(folder, f"table{joints}.toml") for joints in given.tables}
        for joints, path in paths.items():
            path.write_text(chain(joints), encoding="utf-8")
        short = Path(folder, "short.toml")
        short.write_text(chain(loops_over_tables.SHORT), encoding="utf-8")
        bars += loops_over_tables.loops(paths, short) if paths else []
        told(bars)


def _show(found: Sequence[tuple[float, ...]], size: int) -> list[float]:
    """Print the least of every figure, and return them."""
    least = [min(column) for column in zip(*found, strict=True)]
    print(f"{size:8}" + "".join(f"{one:12.2f}" for one in least), flush=True)
    return least


def _alone(path: Path, *words: str) -> tuple[float, ...]:
    """Return processor seconds of reading, of deriving and, if asked, of C."""
    command = [sys.executable, "-c", MEASURE, str(path), *words]
    ran = subprocess.run(command, cwd=HERE, env=ENVIRONMENT, capture_output=True, check=True)
    return tuple(map(float, ran.stdout.split()))


def _command(*given: str) -> tuple[float, float]:
    """Return processor seconds of a command, start and end of the process included, and its memory, MB."""
    words = [sys.executable, "-m", "symdyn", *given]
    process = subprocess.Popen(words, cwd=HERE, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, spent = os.wait4(process.pid, 0)  # of this process alone: memory of all children is that of the largest
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, words)
    return spent.ru_utime + spent.ru_stime, spent.ru_maxrss / 1024


if __name__ == "__main__":
    main()
