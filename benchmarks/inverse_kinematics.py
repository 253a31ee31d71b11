"""Closed forms of inverse kinematics: all branches of a pose, held against forward kinematics, beside EAIK alone.

    python benchmarks/inverse_kinematics.py [rounds]

Microseconds a pose, medians of interleaved rounds over the same random poses; `pip install "symdyn[ik]"` brings EAIK.
What `Branches.at` takes more than EAIK is the error of every branch by the scene's own pose, the singular values of its
Jacobian, limits and order. Beside it stand branches, and the largest error of those of all poses.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from statistics import median

import numpy as np

import symdyn
from symdyn.table import Table

POSES = 200

ARMS = {
    "puma560": ("tool=0.45, 0.2, 0.1, rpy(0, 0.5, 0.2)", ""),
    "arm7": ("tool=0.4, 0.2, 0.6, rpy(0, 0, 0)", "q3=0.3"),
}
"""A pose of each that it has, and what is held."""


def main(rounds: int = 9) -> int:
    """Measure and print."""
    rows = []
    for name, (path, held) in ARMS.items():
        scene = symdyn.example(name)
        first = symdyn.inverse_kinematics(scene, path, held or ())
        pose, rng = symdyn.lambdify(scene, "pose:tool"), np.random.default_rng(0)
        q = rng.uniform(-3, 3, (POSES, len(scene.coordinates)))
        if held:
            q[:, 2] = 0.3
        poses = [np.vstack([pose(one), [0, 0, 0, 1]]) for one in q]
        solved = first._solver._solved
        ways: tuple[Callable[[], object], ...] = (
            lambda solved=solved, poses=poses: [solved(T[:3, :3], T[:3, 3]) for T in poses],
            lambda first=first, poses=poses: [first.at(T) for T in poses],
        )
        times = [[_seconds(way) for way in ways] for _ in range(rounds)]
        found = [first.at(T) for T in poses]
        count, error = median(len(one.q) for one in found), max(float(one.error.max()) for one in found)
        alone, ours = (1e6 * median(column) / POSES for column in zip(*times, strict=True))
        rows.append((name, f"{alone:.1f}", f"{ours:.0f}", f"{ours / alone:.1f}", f"{count:g}", f"{error:.1e}"))
    heads = ("arm", "EAIK alone, µs", "symdyn, µs", "times", "branches", "largest error")
    print(Table(heads, rows, range(1, 6), "Inverse kinematics, all branches of a pose").text())
    return 0


def _seconds(way: Callable[[], object]) -> float:
    start = time.perf_counter()
    way()
    return time.perf_counter() - start


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
