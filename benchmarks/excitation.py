"""Exciting motions of arms: condition numbers as drawn and as improved, and what they cost.

    OPENBLAS_NUM_THREADS=1 python benchmarks/excitation.py [--starts 4] [--robots puma560,arm7] [--seeds 3]

A row a robot, family and criterion; medians over seeds. Limits: 2 rad to both sides, 2 rad/s; period 10 s, five terms,
1,000 rows. "drawn" is the criterion of the best of 256 motions drawn by Sobol's sequence and scaled into the limits. A
motion of one sine a joint, median of 50, stands above for comparison. Seconds are processor time of the whole call,
deriving and compiling in the first of a robot. The bar: base parameters of both arms at a condition number of 100, the
rule of thumb for measurements, within a minute on one core.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

import symdyn
from symdyn.identification import Excitation, excite

CONDITION, SECONDS = 100.0, 60.0


def undirected(name: str, seed: int) -> float:
    """Return the median condition number of motions that nobody improved: one sine a joint, of random rounds."""
    scene = symdyn.example(name)
    Y, random = symdyn.lambdify(scene, "base_regressor"), np.random.default_rng(seed)
    t = np.arange(1000) * 0.01
    found = []
    for _ in range(50):
        pace = 2 * np.pi / 10 * random.integers(1, 6, len(scene.coordinates))
        size, phase = np.minimum(2.0, 2.0 / pace), random.uniform(0, 2 * np.pi, len(pace))
        angle = t[:, None] * pace + phase
        rows = Y(size * np.sin(angle), size * pace * np.cos(angle), -size * pace**2 * np.sin(angle))
        found.append(np.linalg.cond(rows.reshape(-1, rows.shape[-1])))
    return statistics.median(found)


def main() -> int:
    """Print the table; 1 where a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=4)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--robots", default="puma560,arm7")
    options = parser.parse_args()
    missed = False
    for name in options.robots.split(","):
        print(f"{name:8} one sine a joint: condition {undirected(name, 0):8.1f}")
        for family in Excitation.families:
            for criterion in Excitation.criteria:
                runs, seconds = [], []
                for seed in range(options.seeds):
                    begin = time.process_time()
                    runs.append(excite(symdyn.example(name), family=family, criterion=criterion, starts=options.starts,
                                       seed=seed))  # fmt: skip
                    seconds.append(time.process_time() - begin)
                drawn = statistics.median(min(one.before for one in run.starts) for run in runs)
                print(
                    f"{name:8} {family:8} {criterion:17} drawn {drawn:8.2f}  condition "
                    f"{statistics.median(run.condition for run in runs):6.2f}, of columns of length 1 "
                    f"{statistics.median(run.scaled_condition for run in runs):6.2f}, -ln det "
                    f"{statistics.median(run.determinant for run in runs):8.2f}  {statistics.median(seconds):5.1f} s"
                )
                missed |= criterion == "condition" and max(run.condition for run in runs) > CONDITION
                missed |= max(seconds) > SECONDS
    print(f"bar: condition {CONDITION:g} within {SECONDS:g} s: {'missed' if missed else 'kept'}")
    return int(missed)


if __name__ == "__main__":
    raise SystemExit(main())
