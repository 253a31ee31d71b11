"""What `import symdyn` adds to Python's own start, and what a first look through each door adds to that.

Fresh processes take turns, one of each a round, and what is told is the smallest time over the rounds, less that of
Python alone: `python benchmarks/import_time.py --rounds 30`. Then a double pendulum from the shell, with all that is
compiled in the cache: the smallest time of the whole command.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from bars import Bar, in_time

import symdyn

ALONE = "python"


def programs(doors: bool) -> dict[str, tuple[str, ...]]:
    """Return what Python is called with, by what it is called."""
    found = {ALONE: "pass", "import symdyn": "import symdyn"}
    found |= {f"symdyn.{name}": f"import symdyn; symdyn.{name}" for name in symdyn.__all__ if doors}
    return {name: ("-c", text) for name, text in found.items()}


def start_times(commands: Mapping[str, Sequence[str]], rounds: int) -> dict[str, float]:
    """Return the smallest time of Python with every command, s."""
    best = dict.fromkeys(commands, float("inf"))
    for _ in range(rounds):
        for name, words in commands.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, *words], check=True, capture_output=True)
            best[name] = min(best[name], time.perf_counter() - start)
    return best


def shell(rounds: int) -> list[Bar]:
    """Return how long a run of a double pendulum takes, without and with a plot."""
    scene = Path(symdyn.__file__).parent.parent / "examples" / "double_pendulum.toml"
    with tempfile.TemporaryDirectory() as folder:
        run = ["-m", "symdyn", "simulate", str(scene), "--until", "10", "--start", "q1=1,q2=2", "-o", f"{folder}/a.csv"]
        plain, plotted = "double pendulum from the shell", "the same with a plot"
        best = start_times({plain: run, plotted: [*run, "--plot", f"{folder}/a.svg"]}, rounds + 1)
    return [in_time(plain, 0.8, best[plain]), in_time(plotted, 1.2, best[plotted])]


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
    imported = in_time("import symdyn, more than Python alone", 0.02, best["import symdyn"] - best[ALONE])
    for bar in (imported, *shell(given.rounds)):
        print(f"{bar.text}: {bar.shown} ({bar.wanted}), {bar.verdict}")


if __name__ == "__main__":
    main()
