"""Every URDF of example-robot-data: joints, agreement with Pinocchio or the reason of its refusal, times.

Run: PYTHONPATH=tests python benchmarks/robot_files.py (after: pip install "symdyn[bench]")
Agreement: largest difference at random states relative to the largest entry, read with the file's own digits
(snap=False) and with invalid inertias allowed; forward dynamics is compared by the forces M (qdd - qdd'). Times: the
quicker of two runs in one process, imports aside.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from math import isnan
from pathlib import Path
from typing import TypeVar

from robots import Peer, differences, robot_files, robot_folder

from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import SceneError
from symdyn.program import lower
from symdyn.scene import Scene
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats.urdf import read

T = TypeVar("T")

HEADER = "| file | joints | coordinates | following | verdict: ID, M, FD | warnings | read, ms | to C, ms |"


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """Return what `work` returns and the shorter time of two runs, ms."""
    times = []
    for _ in range(2):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    return result, 1e3 * min(times)


def to_c(scene: Scene) -> int:
    """Derive, lower and print inverse dynamics; return the size of the C, bytes."""
    return sum(len(text) for _, text in emit(lower(derive(scene, ("inverse_dynamics",))), "c").files)


def row(path: Path, folder: Path) -> str:
    """Return the line of a file."""
    file = f"{path.parts[len(folder.parts)].removesuffix('_description')}/{path.name}"
    try:
        reading, reading_time = timed(lambda: read(path, ReadOptions(allow_invalid_inertia=True)))
    except SceneError as error:
        first = error.faults[0].removeprefix(f"{path}: ").replace("|", "\\|")
        more = f" (and {len(error.faults) - 1} more)" if len(error.faults) > 1 else ""
        return f"| {file} | | | | refused: {first}{more} | | | |"
    plain = read(path, ReadOptions(snap=False, allow_invalid_inertia=True)).scene
    found = differences(plain, Peer(path, plain)).values()
    shown = ", ".join("none, M is singular" if isnan(x) else f"{x:.0e}" for x in found)
    scene = reading.scene
    following = sum(joint.coupling is not None for joint in scene.joints)
    invalid = sum("is one that no body has" in note for note in reading.notes)
    warnings = f"{invalid} invalid inertias" if invalid else ""
    _, time_to_c = timed(lambda: to_c(scene))
    counts = f"{len(scene.joints)} | {len(scene.coordinates)} | {following or ''}"
    return f"| {file} | {counts} | {shown} | {warnings} | {reading_time:.0f} | {time_to_c:.0f} |"


def main() -> int:
    """Print a table in Markdown."""
    folder = robot_folder()
    if folder is None:
        print("robots: the package example-robot-data is not installed; pip install 'symdyn[bench]'", file=sys.stderr)
        return 1
    print(HEADER)
    print("|---|--:|--:|--:|---|---|--:|--:|")
    for path in robot_files():
        print(row(path, folder), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
