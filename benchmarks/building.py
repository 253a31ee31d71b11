"""Time to build the recursive graphs: inverse dynamics of a 7-axis arm, of a 30-joint tree, of long chains.

Run: python benchmarks/building.py
Each time is the median of several builds in one process, imports aside.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

from symdyn.dynamics import derive
from symdyn.scene import Scene, Starter, body, read, read_text, revolute, scene, with_symbolic_inertia

EXAMPLES = Path(__file__).parent.parent / "examples"


def timed(work: Callable[[], object], runs: int = 9) -> float:
    """Return the median time of `work`, s."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return median(times)


def tree(n: int) -> Scene:
    """Return a binary tree of n revolute joints with full inertias and oblique placements."""
    bodies = [
        body(f"b{i}", mass=i, com=[0.1, 0.2, 0.3], inertia=[[2, 0.1, 0.2], [0.1, 3, 0.3], [0.2, 0.3, 4]], about="com")
        for i in range(1, n + 1)
    ]
    joints = [
        revolute(
            f"j{i}",
            parent="ground" if i == 1 else f"b{i // 2}",
            child=f"b{i}",
            axis=[0, 0, 1],
            origin={"xyz": [0.1, 0.2, 0.3], "rpy": ["pi/2", "0.3", "pi/6"]},
        )
        for i in range(1, n + 1)
    ]
    return scene(f"tree{n}", bodies=bodies, joints=joints)


def main() -> int:
    """Print a table in Markdown."""
    arm = with_symbolic_inertia(read(EXAMPLES / "arm7.toml"))
    scenes = {
        "7-axis arm, ten symbolic parameters a link": arm,
        "tree of 30 joints, full inertias, oblique frames": tree(30),
        "chain of 100 links": read_text(Starter("chain").from_template("chain", 100), "chain.toml"),
    }
    outputs = ("inverse_dynamics", "mass_matrix", "forward_dynamics")
    print("| scene | " + " | ".join(f"{name}, ms" for name in outputs) + " |")
    print("|---|" + "---:|" * len(outputs))
    for name, one in scenes.items():
        times = [f"{1e3 * timed(lambda one=one, output=output: derive(one, (output,))):.1f}" for output in outputs]
        print(f"| {name} | " + " | ".join(times) + " |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
