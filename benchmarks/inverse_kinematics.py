"""Closed forms of inverse kinematics: all branches of a pose, held against forward kinematics, beside EAIK alone.

    python benchmarks/inverse_kinematics.py [rounds]

First the output `inverse_kinematics` as C: nanoseconds a pose, one a call and in batch, the least of rounds over 1,024
random poses; of 10^5 random poses, and as many singular ones, the largest error of a branch by forward kinematics, and
the share of branches out of reach. Then, with `pip install "symdyn[ik]"`, microseconds a pose from Python, medians of
interleaved rounds over the same random poses: what `Branches.at` takes more than a solver alone is the error of every
branch by the scene's own pose, the singular values of its Jacobian, limits and order. Beside it stand branches, and the
largest error of those of all poses.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from subprocess import run
from tempfile import TemporaryDirectory

import numpy as np
from bars import Bar

import symdyn
from symdyn.emit import emit, write
from symdyn.program import formulate, lower
from symdyn.table import Table

POSES = 200

ARMS = {
    "puma560": ("tool=0.45, 0.2, 0.1, rpy(0, 0.5, 0.2)", ""),
    "arm7": ("tool=0.4, 0.2, 0.6, rpy(0, 0, 0)", "q3=0.3"),
}
"""A pose of each that it has, and what is held."""


REQUEST, MANY = "inverse_kinematics:tool", 100_000

CLOCK = """
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "puma560.h"
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
int main(void) {
    static double p[12 * 1024], q[12 * 1024], out[48 * 1024];
    double one = 1, many = 1;
    FILE *file = fopen("poses", "rb");
    if (!file || fread(p, 8, 12 * 1024, file) != 12 * 1024) return 1;
    for (int k = 0; k < 1024; k++) for (int i = 0; i < 12; i++) q[i * 1024 + k] = p[k * 12 + i];
    for (int round = 0; round < 200; round++) {
        double t = now();
        for (int k = 0; k < 1024; k++) puma560_inverse_kinematics_tool(p + 12 * k, out + 48 * k);
        if ((t = now() - t) < one) one = t;
        t = now();
        puma560_inverse_kinematics_tool_batch(1024, q, out);
        if ((t = now() - t) < many) many = t;
    }
    printf("%.17g %.17g", one / 1024e-9, many / 1024e-9);
    return 0;
}
"""


def in_c() -> list[Bar]:
    """Return the bars of the PUMA's eight branches as C."""
    scene = symdyn.example("puma560")
    pose, solve = symdyn.lambdify(scene, ["pose:tool", REQUEST])
    rng = np.random.default_rng(0)
    q = rng.uniform(-np.pi, np.pi, (MANY, 6))
    with TemporaryDirectory() as folder:
        write(emit(lower(formulate(scene, [REQUEST])), "c", option="batch").texts, Path(folder))
        Path(folder, "clock.c").write_text(CLOCK)
        pose(q[:1024]).tofile(Path(folder, "poses"))
        sources = [one.name for one in Path(folder).glob("*.c") if one.name != "main.c"]
        run(["cc", "-O3", "-march=native", *sources, "-o", "clock", "-lm"], cwd=folder, check=True)
        told = run([str(Path(folder, "clock"))], cwd=folder, check=True, capture_output=True, text=True)
    one, many = map(float, told.stdout.split())
    singular = q.copy()
    kinds = np.arange(MANY) % 3
    singular[kinds == 0, 4] = 0.0  # the wrist is straight
    singular[kinds == 1, 2] = np.arctan2(0.4318, -0.0203)  # the elbow is folded
    singular[kinds == 2] = np.round(q[kinds == 2] / (np.pi / 2)) * np.pi / 2
    bars = [
        Bar("eight branches of a PUMA, scalar C", "≤ 1000 ns", f"{one:.0f} ns", one <= 1000),
        Bar("eight branches of a PUMA, batch", "≤ 200 ns", f"{many:.0f} ns", many <= 200),
    ]
    for name, at in (("random", q), ("singular", singular)):
        T = pose(at)
        with np.errstate(invalid="ignore"):
            found = solve(T)
        reached = ~np.isnan(found).any(axis=2)
        error = float(np.abs(pose(found[reached]) - np.repeat(T, reached.sum(axis=1), axis=0)).max())
        lost = int((~reached.any(axis=1)).sum())
        text = (
            f"{MANY:,} {name} poses, {100 * (1 - reached.mean()):.2g} % of branches out of reach, poses without: {lost}"
        )
        bars.append(Bar(f"largest error of a branch, {text}", "≤ 1e-12", f"{error:.1e}", error <= 1e-12 and not lost))
    return bars


def main(rounds: int = 9) -> int:
    """Measure and print."""
    bars = in_c()
    told = [(one.text, one.wanted, one.shown, one.verdict) for one in bars]
    print(Table(("of", "wanted", "measured", ""), told, (), "The output inverse_kinematics").text())
    try:
        import eaik.IK_HP  # noqa: F401
    except ImportError:
        print("EAIK is not here; nothing is compared with it")
        return 0
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
    heads = ("arm", "the solver alone, µs", "symdyn, µs", "times", "branches", "largest error")
    print(Table(heads, rows, range(1, 6), "Inverse kinematics, all branches of a pose").text())
    return 0


def _seconds(way: Callable[[], object]) -> float:
    start = time.perf_counter()
    way()
    return time.perf_counter() - start


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
