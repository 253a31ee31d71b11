"""Processor time from a scene that no process has seen to a first value: `python benchmarks/cold_load.py`.

Each run is a process of its own, whose compilers are counted too, imports are not. The cache holds what all scenes have
in common, or nothing at all, as on the first day.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent.parent

RUN = """
import resource, sys, time
import numpy as np
import symdyn, symdyn.build.backends.door, symdyn.dynamics
def spent():
    there = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + there.ru_utime + there.ru_stime
start = spent()
arm = symdyn.load(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None)
names = arm.inverse_dynamics.operands
arm.inverse_dynamics(*(np.full(len(one.entries), 0.3) for one in names))
print(spent() - start)
"""

CASES = {"inverse dynamics alone": ["inverse_dynamics"], "all functions, one called": []}


def seconds(scene: Path, more: list[str], cache: str) -> float:
    """Return what a process spends."""
    where = os.environ | {"SYMDYN_CACHE_DIR": cache, "PYTHONPATH": str(HERE)}
    ran = subprocess.run([sys.executable, "-c", RUN, scene, *more], env=where, check=True, capture_output=True)
    return float(ran.stdout)


def main() -> None:
    """Print a row a case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path, nargs="?", default=HERE / "examples" / "arm7.toml")
    parser.add_argument("--runs", type=int, default=7)
    given = parser.parse_args()
    print(f"{given.scene.stem:28}{'first day':>12}{'unseen':>12}{'seen':>12}   s, medians")
    for name, more in CASES.items():
        times: list[list[float]] = [[], [], []]
        for _ in range(given.runs):
            with tempfile.TemporaryDirectory() as cache:
                times[0].append(seconds(given.scene, more, cache))
                for path in Path(cache).glob(f"{given.scene.stem}-*"):
                    path.unlink()
                times[1].append(seconds(given.scene, more, cache))
                times[2].append(seconds(given.scene, more, cache))
        print(f"{name:28}" + "".join(f"{statistics.median(column):12.2f}" for column in times), flush=True)


if __name__ == "__main__":
    main()
