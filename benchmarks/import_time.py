"""What `import symdyn` adds to Python's own start, what a first look through each door adds, and what commands take.

Fresh processes take turns, one of each a round, and what is told is the processor time, of the process and of what it
starts, as the median of the rounds: other work on the machine counts for nothing. Of a scene that is new, compiled code
is not in the cache; all else is on a warm disk.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median

from bars import in_time

import symdyn

HERE = Path(__file__).parent.parent
ALONE, IMPORTED = "python", "import symdyn, more than Python alone"
NEW = "first simulate of a new scene"
TWO_LINK, PENDULUM = HERE / "examples" / "two_link.toml", HERE / "examples" / "double_pendulum.toml"

BARS = {
    IMPORTED: 0.015,
    "symdyn equations two_link.toml": 0.12,
    "symdyn info two_link.toml": 0.20,
    "symdyn completion bash": 0.08,
    NEW: 0.6,
    "double pendulum from the shell": 0.8,
    "the same with a plot": 1.2,
}
"""s at most."""


def commands(folder: Path) -> dict[str, list[str]]:
    """Return what Python is called with, by what it is called; {new} is a scene that no run has seen."""
    shell = ["-m", "symdyn"]
    run = ["--until", "10", "--start", "q1=1,q2=2", "-o", str(folder / "a.csv")]
    again = [*shell, "simulate", str(PENDULUM), *run]
    asked = [["equations", str(TWO_LINK)], ["info", str(TWO_LINK)], ["completion", "bash"]]
    lines = [["-c", "import symdyn"], *([*shell, *words] for words in asked), [*shell, "simulate", "{new}", *run]]
    lines += [again, [*again, "--plot", str(folder / "a.svg")]]
    return {ALONE: ["-c", "pass"], **dict(zip(BARS, lines, strict=True))}


def new_scene(folder: Path, number: int) -> Path:
    """Return the file of a double pendulum with a name and a mass that no other run has."""
    path, mass = folder / f"pendulum{os.getpid()}_{number}.toml", f"1.{os.getpid()}{number:02d}"
    text = PENDULUM.read_text(encoding="utf-8").replace('"double_pendulum"', f'"{path.stem}"')
    path.write_text(text.replace("m1 = { value = 1,", f"m1 = {{ value = {mass},"), encoding="utf-8")
    return path


def processor_times(asked: Mapping[str, Sequence[str]], rounds: int, folder: Path) -> dict[str, float]:
    """Return the median time of Python with every command, user's and system's, s; the first round is not counted."""
    found: dict[str, list[float]] = {name: [] for name in asked}
    usual = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    for number in range(rounds + 1):
        scene = str(new_scene(folder, number))
        for name, words in asked.items():
            before = getrusage(RUSAGE_CHILDREN)
            line = [sys.executable, *(word.replace("{new}", scene) for word in words)]
            subprocess.run(line, check=True, capture_output=True, cwd=HERE, env=usual)
            after = getrusage(RUSAGE_CHILDREN)
            found[name].append(after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)
    return {name: median(times[1:]) for name, times in found.items()}


def main() -> None:
    """Print a row a program."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--doors", action="store_true", help="also the first look at every door")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        asked = commands(Path(folder))
        if given.doors:
            asked |= {f"symdyn.{name}": ["-c", f"import symdyn; symdyn.{name}"] for name in symdyn.__all__}
        took = processor_times(asked, given.rounds, Path(folder))
    took[IMPORTED] -= took[ALONE]
    for name, time in took.items():
        if name in BARS:
            bar = in_time(name, BARS[name], time)
            print(f"{bar.text}: {bar.shown} ({bar.wanted}), {bar.verdict}")
        else:
            print(f"{name}: {1e3 * time:.1f} ms")


if __name__ == "__main__":
    main()
