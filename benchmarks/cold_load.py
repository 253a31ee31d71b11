"""Processor time from a scene that no process has seen to a first value: `python benchmarks/cold_load.py`.

Each run is a process of its own, whose compilers are counted too, imports are not. The cache holds what all scenes have
in common, or nothing at all, as on the first day.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from bars import in_time

import symdyn

HERE = Path(__file__).parent.parent

RUN = """
import resource, sys, time
import numpy as np
import symdyn, symdyn.runtime.backends.load_functions, symdyn.dynamics
def spent():
    there = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + there.ru_utime + there.ru_stime
start = spent()
arm = symdyn.load(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None)
loaded = spent() - start
names = arm.inverse_dynamics.operands
arm.inverse_dynamics(*(np.full(len(one.entries), 0.3) for one in names))
print(loaded, spent() - start)
"""

CASES = {"inverse dynamics alone": ["inverse_dynamics"], "all functions, one called": []}


HUMANOID = HERE / "examples" / "gallery" / "humanoid.urdf"


def seconds(scene: Path, more: list[str], cache: str) -> tuple[float, float]:
    """Return what a process spends until its functions are there, and until the first value."""
    where = os.environ | {"SYMDYN_CACHE_DIR": cache, "PYTHONPATH": str(HERE)}
    where.pop("PYTHONDONTWRITEBYTECODE", None)  # Python's own compiled modules are there
    ran = subprocess.run([sys.executable, "-c", RUN, scene, *more], env=where, check=True, capture_output=True)
    loaded, first = map(float, ran.stdout.split())
    return loaded, first


def medians(scene: Path, more: list[str], runs: int) -> list[tuple[float, float]]:
    """Return medians of both times: on the first day, with a scene that is not in the cache, and with one that is."""
    times: list[list[tuple[float, float]]] = [[], [], []]
    for _ in range(runs):
        with tempfile.TemporaryDirectory() as cache:
            times[0].append(seconds(scene, more, cache))
            for path in Path(cache).glob(f"{symdyn.read(scene).name}-*"):
                path.unlink()
            times[1].append(seconds(scene, more, cache))
            times[2].append(seconds(scene, more, cache))
    return [(median(one[0] for one in column), median(one[1] for one in column)) for column in times]


def main() -> None:
    """Print a row a case, then what was set out to be reached."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path, nargs="?", default=HERE / "examples" / "arm7.toml")
    parser.add_argument("--runs", type=int, default=7)
    given = parser.parse_args()
    found = {}
    print(f"{'until there / first value, s':40}{'first day':>16}{'unseen':>16}{'seen':>16}")
    for scene in (given.scene, HUMANOID):
        for name, more in CASES.items():
            found[scene, name] = medians(scene, more, given.runs)
            cells = (f"{loaded:.3f} / {first:.3f}" for loaded, first in found[scene, name])
            print(f"{scene.stem + ', ' + name:40}" + "".join(f"{cell:>16}" for cell in cells), flush=True)
    alone, every = CASES
    for bar in (
        in_time(f"{given.scene.stem}, unseen: first value of inverse dynamics", 0.5, found[given.scene, alone][1][1]),
        in_time("humanoid: all functions there, from the cache", 0.05, found[HUMANOID, every][2][0]),
    ):
        print(f"{bar.text}: {bar.shown} ({bar.wanted}), {bar.verdict}")


if __name__ == "__main__":
    main()
