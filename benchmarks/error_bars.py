"""Error bars to first order beside the runs that they stand for: `python benchmarks/error_bars.py [--runs N]`.

A four-bar and a slider-crank, three parameters of each uncertain by 0.3 %: standard deviations of its first coordinate
and velocity after 1 s, by `symdyn.uncertainty` and over runs of `symdyn.ensemble`, and the seconds of both. So many
runs leave a standard deviation open by 1 part in the root of twice their number.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import symdyn

SHARE, UNTIL = 0.003, 1.0
SCENES = ("four_bar", "slider_crank")


def main() -> None:
    """Print a row a column."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=400)
    given = parser.parse_args()
    print(f"{given.runs} runs leave {100 / np.sqrt(2 * given.runs):.1f} % open")
    for name in SCENES:
        scene = symdyn.example(name)
        values = {p.name: float(p.value.at({})) for p in scene.parameters if p.value is not None}
        varied = {p: SHARE * x for p, x in list(values.items())[:3]}
        started = time.perf_counter()
        bars = symdyn.uncertainty(scene, varied, until=UNTIL)
        between = time.perf_counter()
        rng = np.random.default_rng(0)
        drawn = {p: rng.normal(values[p], sd, given.runs) for p, sd in varied.items()}
        runs = symdyn.ensemble(scene, until=UNTIL, values=drawn)
        ended = time.perf_counter()
        print(f"{name}, {', '.join(varied)}: {between - started:.1f} s to first order, {ended - between:.1f} s of runs")
        for column, found in ((scene.coordinates[0], runs.q[:, 0]), (scene.velocities[0], runs.qd[:, 0])):
            print(f"  {column:10} {bars[column][-1]:.6g} to first order, {np.std(found, ddof=1):.6g} over the runs")


if __name__ == "__main__":
    main()
