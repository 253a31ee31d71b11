"""What linearising costs: `python benchmarks/linearize.py`.

The quadruped with its trunk held has 12 coordinates: the first call derives, the others look at new points; medians of
RUNS, s. The cart-pole with formulas is timed from the shell, beside a verb that prints equations
and Python alone, in rounds of one each: medians of the time by the clock and of processor time, s.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

import symdyn
from symdyn.scene import Scene, read_text

EXAMPLES = Path(__file__).parent.parent / "examples"

RUNS, ROUNDS = 15, 7

WHOLE, SHELL = 0.2, 0.7
"""Bars, s: of the quadruped after the first call, and of the cart-pole from the shell."""


def held_quadruped() -> Scene:
    """Return the quadruped with its trunk fixed to the ground."""
    text = (EXAMPLES / "quadruped.toml").read_text(encoding="utf-8")
    head, joint, rest = text.partition("[joints.base]")
    base = '\ntype = "fixed"\nparent = "ground"\nchild = "trunk"\n\n'
    return read_text(head + joint + base + rest.partition("\n\n")[2])


def linearised(scene: Scene) -> tuple[float, float]:
    """Return seconds of the first call, and the median of calls at other points."""
    spent = []
    for run in range(RUNS + 1):
        at = {name: repr(0.1 * k + 0.01 * run) for k, name in enumerate(scene.coordinates)}
        begin = time.perf_counter()
        symdyn.linearize(scene, start=at, anywhere=True)
        spent.append(time.perf_counter() - begin)
    return spent[0], statistics.median(spent[1:])


def shell() -> dict[str, tuple[float, float]]:
    """Return seconds by the clock and of the processor, by command."""
    cart = str(EXAMPLES / "cart_pole.toml")
    commands = {
        "symdyn linearize cart_pole.toml": [sys.executable, "-m", "symdyn", "linearize", cart],
        "symdyn equations cart_pole.toml": [sys.executable, "-m", "symdyn", "equations", cart],
        "python -c pass": [sys.executable, "-c", "pass"],
    }
    spent: dict[str, list[tuple[float, float]]] = {name: [] for name in commands}
    for _ in range(ROUNDS):
        for name, words in commands.items():
            before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
            subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
            clock, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
            used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            spent[name].append((clock, used))
    return {
        name: (statistics.median(c for c, _ in some), statistics.median(u for _, u in some))
        for name, some in spent.items()
    }


def main() -> None:
    """Print the figures beside their bars."""
    first, later = linearised(held_quadruped())
    print(f"quadruped, trunk held: first call {first:.3f} s, then {later:.4f} s (bar {WHOLE} s)")
    for name, (clock, used) in shell().items():
        bar = f" (bar {SHELL} s)" if "linearize" in name else ""
        print(f"{name}: {clock:.3f} s, processor {used:.3f} s{bar}")


if __name__ == "__main__":
    main()
