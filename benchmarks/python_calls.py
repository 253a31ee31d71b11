"""What a call from Python costs: one state, a hundred, a million, by each of the ways to get a function.

Run: python benchmarks/python_calls.py [SCENE ...]
All ways are timed in interleaved rounds on the same states; a figure is the median over the rounds, ns a state, with
the quartiles. At a million states the result goes into an array that is there already, where a way allows it, and
"C rows" is a C function like the one behind `load`, called once on the same arrays: what is above it is the price of
Python.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median, quantiles

import numpy as np
from bars import Bar

import symdyn
from symdyn.emit import emit
from symdyn.program import formulate
from symdyn.runtime import build, build_extension, run_python
from symdyn.scene import Scene

EXAMPLES = Path(__file__).parent.parent / "examples"

SCENES = ("two_link", "puma560", "arm7")

FUNCTION = "inverse_dynamics"

COUNTS = {1: 2000, 100: 200, 1_000_000: 1}
"""Calls in one measurement, by number of states."""

ROUNDS = 9

Arrays = list[np.ndarray]


def ways(scene: Scene) -> dict[str, Callable[[Arrays, np.ndarray], object]]:
    """Return the ways to call the function, by name: each takes arguments and an array for the result."""
    program = symdyn.program.lower(formulate(scene, (FUNCTION,)))
    numpy_call = run_python(emit(program)).inverse_dynamics
    c_call = build(program).inverse_dynamics
    path, module = build_extension(emit(program, "ufunc"))
    loaded, ufunc = symdyn.load(scene, FUNCTION).inverse_dynamics, module.inverse_dynamics
    rows = getattr(ctypes.CDLL(str(path)), f"{scene.name}_f64_{FUNCTION}_rows")
    rows.restype = None

    def call_rows(arguments: Arrays, out: np.ndarray) -> None:
        places = [ctypes.c_void_p(array.ctypes.data) for array in (*arguments, out)]
        rows(ctypes.c_size_t(len(np.atleast_2d(out))), *places)

    return {
        "lambdify (NumPy)": lambda arguments, out: numpy_call(*arguments, out),
        "build (ctypes)": lambda arguments, out: c_call(*arguments),
        "load": lambda arguments, out: loaded(*arguments, out=out),
        "load, new result": lambda arguments, out: loaded(*arguments),
        "ufunc target": lambda arguments, out: ufunc(*arguments, out),
        "C rows": call_rows,
    }


def states(scene: Scene, count: int) -> Arrays:
    """Return arguments of inverse dynamics for so many states; one set of parameters."""
    rng, n = np.random.default_rng(1), len(scene.coordinates)
    shape = (n,) if count == 1 else (count, n)
    free = len(scene.free_parameters)
    return [*rng.uniform(-2.0, 2.0, (3, *shape)), *([rng.uniform(0.5, 1.5, free)] if free else [])]


def measure(scene: Scene) -> dict[str, dict[int, tuple[float, float, float]]]:
    """Return lower quartile, median and upper quartile, ns a state, by way and number of states."""
    known = ways(scene)
    found: dict[str, dict[int, tuple[float, float, float]]] = {name: {} for name in known}
    for count, calls in COUNTS.items():
        arguments = states(scene, count)
        out = np.empty_like(arguments[0])
        times: dict[str, list[float]] = {name: [] for name in known}
        for turn in range(ROUNDS + 1):
            for name, call in known.items():
                start = time.perf_counter()
                for _ in range(calls):
                    call(arguments, out)
                if turn:  # the first round warms up
                    times[name].append((time.perf_counter() - start) / (calls * count) * 1e9)
        for name, row in times.items():
            low, middle, high = quantiles(row, n=4)
            found[name][count] = (low, middle, high)
    return found


FEW = (2, 4, 8, 10, 16, 17, 32)
"""Numbers of states for which one call of a NumPy module is held against as many calls."""

SMALL = 10
"""States up to which one call shall not take longer than as many calls."""


def few(scene: Scene, rounds: int = 41) -> dict[int, float]:
    """Return the time of one call over that of single calls with the same states, median of pairs, by number."""
    call = run_python(emit(symdyn.program.lower(formulate(scene, (FUNCTION,))))).inverse_dynamics
    found = {}
    for count in FEW:
        given = states(scene, count)
        ratios = []
        for _ in range(rounds):
            start = time.perf_counter()
            call(*given)
            between = time.perf_counter()
            for k in range(count):
                call(*(a if a.ndim == 1 else a[k] for a in given))
            ratios.append((between - start) / (time.perf_counter() - between))
        found[count] = median(ratios)
    return found


def main(words: Sequence[str]) -> int:
    """Print a table in Markdown for each scene."""
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument("scenes", nargs="*", metavar="SCENE", default=list(SCENES), help="names of examples")
    for name in ask.parse_args(words).scenes:
        scene = symdyn.read(EXAMPLES / f"{name}.toml")
        print(f"\n{name}, {FUNCTION}: ns a state, median (quartiles)\n")
        print("| way | " + " | ".join(f"N = {count:,}" for count in COUNTS) + " |")
        print("|---|" + "---:|" * len(COUNTS))
        found = measure(scene)
        for way, row in found.items():
            cells = [f"{middle:,.4g} ({low:,.4g} – {high:,.4g})" for low, middle, high in row.values()]
            print(f"| {way} | " + " | ".join(cells) + " |")
        many = max(COUNTS)
        ratio = found["load"][many][1] / found["C rows"][many][1]
        small = few(scene)
        short = ", ".join(f"{count}: {ratio:.2f}" for count, ratio in small.items())
        print(f"\nNumPy module, one call over as many single ones, by number of states: {short}")
        worst = max(ratio for count, ratio in small.items() if count <= SMALL)
        bar = Bar(
            f"NumPy module, one call with 2 to {SMALL} states, times single calls", "≤ 1", f"{worst:.2f}", worst <= 1
        )
        print(f"{bar.text}: {bar.shown} ({bar.wanted}), {bar.verdict}")
        print(f"\nload / C rows at N = {many:,}: {ratio:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
