"""How long lessons take, whole processes with cold Python: `python benchmarks/walkthroughs.py`.

A row is a command, its median of five runs in seconds, the bar that it is held to, and kilobytes of its files. Last
come the parts of one lesson, in a process that is warm.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from symdyn.errors import SymdynError
from symdyn.scene import read
from symdyn.teach import rendered, walkthrough
from symdyn.teach.render import FORMATS

ROOT = Path(__file__).parent.parent
EXAMPLES = ROOT / "examples"
TEXTS, ALL = "md,html,notebook,latex", "md,html,notebook,latex,pdf"
RUNS = 5
COMMANDS = (  # scene, formats, seconds at most
    ("two_link", TEXTS, 1.5),
    ("two_link", ALL, 2.5),
    ("spatial_3r", TEXTS, 3.0),
    ("spatial_3r", ALL, 4.0),
    ("arm7", TEXTS, 2.0),  # refused
)


def main() -> int:
    """Print the rows; exit status 1 where a bar is missed."""
    missed = 0
    for scene, formats, most in COMMANDS:
        spent, size, said = _command(scene, formats)
        missed += spent > most
        mark = "missed" if spent > most else "held"
        print(f"{scene:12} {formats:28} {spent:5.2f} s   bar {most:3.1f} {mark:6}   {size:5.0f} kB   {said}")
    for scene in ("two_link", "cart_pole", "spatial_3r"):
        print(_parts(scene))
    return int(missed > 0)


def _command(scene: str, formats: str) -> tuple[float, float, str]:
    """Return the median of some runs, s, the size of the files, kB, and what it said on stderr."""
    taken, size, said = [], 0.0, ""
    for _ in range(RUNS):
        with tempfile.TemporaryDirectory() as folder:
            words = ["walkthrough", str(EXAMPLES / f"{scene}.toml"), "--format", formats, "-o", folder]
            start = time.perf_counter()
            done = subprocess.run(
                [sys.executable, "-m", "symdyn", *words], capture_output=True, text=True, check=False, cwd=ROOT
            )
            taken.append(time.perf_counter() - start)
            size = sum(path.stat().st_size for path in Path(folder).iterdir()) / 1000
            said = f"refused: {done.stderr[:60].strip()}..." if done.returncode else ""
    return statistics.median(taken), size, said


def _parts(scene: str) -> str:
    """Return how long one lesson takes to derive and to write in each format."""
    start = time.perf_counter()
    document = walkthrough(read(EXAMPLES / f"{scene}.toml"))
    line = f"{scene:12} derive {time.perf_counter() - start:5.2f} s"
    for format in FORMATS:
        start = time.perf_counter()
        try:
            rendered(document, format)
        except SymdynError as fault:
            line += f"   {format}: {fault}"
        else:
            line += f"   {format} {time.perf_counter() - start:5.2f} s"
    return line


if __name__ == "__main__":
    sys.exit(main())
