"""What `import symdyn` adds to Python's own start, and what a first look through each door adds to that.

Fresh processes take turns, one of each a round, and what is told is the smallest time over the rounds, less that of
Python alone: `python benchmarks/import_time.py --rounds 30`.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from collections.abc import Mapping

import symdyn

ALONE = "python"


def programs(doors: bool) -> dict[str, str]:
    """Return what is run, by what it is called."""
    found = {ALONE: "pass", "import symdyn": "import symdyn"}
    return found | {f"symdyn.{name}": f"import symdyn; symdyn.{name}" for name in symdyn.__all__ if doors}


def start_times(code: Mapping[str, str], rounds: int) -> dict[str, float]:
    """Return the smallest time of every program, s."""
    best = dict.fromkeys(code, float("inf"))
    for _ in range(rounds):
        for name, text in code.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", text], check=True)
            best[name] = min(best[name], time.perf_counter() - start)
    return best


def main() -> None:
    """Print a row a program."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--doors", action="store_true", help="also the first look at every door")
    given = parser.parse_args()
    best = start_times(programs(given.doors), given.rounds)
    print(f"{'':24}{'ms':>8}{'more than Python':>18}")
    for name, took in best.items():
        print(f"{name:24}{1e3 * took:8.1f}{1e3 * (took - best[ALONE]):18.1f}")


if __name__ == "__main__":
    main()
