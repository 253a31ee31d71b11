"""What long chains take, in processor time: `python benchmarks/long_chains.py [BODIES ..] [--runs N]`.

A chain of revolute joints about y and z in turn, its bodies numbers. Every figure is the least of several processes:
reading the file, deriving inverse dynamics from the scene that was read, and the whole command `symdyn info`.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

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
from symdyn.scene import read
start = time.process_time()
scene = read(sys.argv[1])
between = time.process_time()
derive(scene, ["inverse_dynamics"])
print(between - start, time.process_time() - between)
"""


def chain(bodies: int) -> str:
    """Return a scene file of so many bodies in a row."""
    parents = ["ground", *(f"b{i}" for i in range(bodies))]
    parts = [BODY.format(i=i, parent=parents[i], y=i % 2, z=1 - i % 2) for i in range(bodies)]
    return 'name = "chain"\ngravity = [0, 0, -9.81]\n' + "".join(parts)


def main() -> None:
    """Print a row a chain."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bodies", nargs="*", type=int, default=[1000, 5000])
    parser.add_argument("--runs", type=int, default=3)
    given = parser.parse_args()
    print(f"{'bodies':>8}{'read, s':>12}{'derive, s':>12}{'info, s':>12}{'info, MB':>12}")
    with tempfile.TemporaryDirectory() as folder:
        for bodies in given.bodies:
            path = Path(folder, f"chain{bodies}.toml")
            path.write_text(chain(bodies), encoding="utf-8")
            found = [(*_alone(path), *_info(path)) for _ in range(given.runs)]
            print(f"{bodies:8}" + "".join(f"{min(column):12.2f}" for column in zip(*found, strict=True)), flush=True)


def _alone(path: Path) -> tuple[float, float]:
    """Return processor seconds of reading and of deriving."""
    ran = subprocess.run([sys.executable, "-c", MEASURE, str(path)], cwd=HERE, capture_output=True, check=True)
    read, derive = ran.stdout.split()
    return float(read), float(derive)


def _info(path: Path) -> tuple[float, float]:
    """Return processor seconds of `symdyn info`, start and end of the process included, and its memory."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "symdyn", "info", str(path)], cwd=HERE, capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, after.ru_maxrss / 1024


if __name__ == "__main__":
    main()
