"""The same program with the code of this checkout and of another: processes of both take turns.

A machine that is busy for a while is then busy for both, and what is quoted are medians of both sides and of the ratio
of neighbours.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from statistics import median

HERE = Path(__file__).resolve().parent.parent

Numbers = list[float]
"""What a process prints on its last line, as often as it likes to be measured."""


def turns(program: str, words: list[str], other: Path, runs: int, cache: str) -> list[tuple[Numbers, Numbers]]:
    """Return what `python -c program words` prints with either checkout, here and there, after a first run of each.

    Args:
        program: its last line holds numbers.
        words: of the command line behind it.
        other: a checkout of symdyn.
        runs: pairs of processes.
        cache: a folder for what is compiled, by the first runs.
    """
    for root in (HERE, other):
        _ran(root, program, words, cache)
    return [(_ran(HERE, program, words, cache), _ran(other, program, words, cache)) for _ in range(runs)]


def summary(pairs: list[tuple[Numbers, Numbers]], place: int = 0) -> tuple[float, float, float]:
    """Return the median of a number here, of that there, and of their ratios, pair by pair."""
    here, there = ([numbers[place] for numbers in side] for side in zip(*pairs, strict=True))
    return median(here), median(there), median(a / b for a, b in zip(here, there, strict=True))


def _ran(root: Path, program: str, words: list[str], cache: str) -> Numbers:
    ran = subprocess.run(
        [sys.executable, "-c", program, *words],
        env=os.environ | {"PYTHONPATH": str(root), "SYMDYN_CACHE_DIR": cache},
        cwd=cache,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return [float(word) for word in ran.stdout.splitlines()[-1].split()]
