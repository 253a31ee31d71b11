"""From how many states on two threads are faster than one, and whether that is when they are taken.

Run: python benchmarks/two_threads.py [--rounds R] [--real double|float], on a machine with a core to spare: on a busy
one both threads run on one core, and the bar is missed by what starting one costs. Rows of states by the clock, both
ways taking turns; compared is the tenth part of the rounds that was fastest. First as many states as the rule puts on
two threads (`symdyn/runtime/c_module.py`), where two shall not be slower than one by more than 5 %, then half and a
quarter of them, which the rule keeps on one, cut in two all the same.
"""

from __future__ import annotations

import argparse
import ctypes
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from bars import Bar

from symdyn import read
from symdyn.dynamics import derive
from symdyn.program import lower, shared
from symdyn.runtime import CFunction, bind_rows, build
from symdyn.runtime.c_module import GRAIN, WORTH, price, run_rows, split

EXAMPLES = Path(__file__).parent.parent / "examples"
CASES = (
    ("two_link", "mass_matrix"),
    ("two_link", "inverse_dynamics"),
    ("puma560", "inverse_dynamics"),
    ("arm7", "mass_matrix"),
    ("arm7", "inverse_dynamics"),
    ("arm7", "forward_dynamics"),
    ("arm7", "inverse_dynamics_derivatives"),
)
SLOWER = 1.05
"""How many times as long as one thread two may take at most."""


def fewest(one: float) -> int:
    """Return with how many states of a price two threads are taken first."""
    states = -(-2 * WORTH // max(1, int(one)))
    return -(-states // GRAIN) * GRAIN


def seconds(function: CFunction, call: object, states: int, rounds: int) -> tuple[float, float]:
    """Return what one thread and two take on so many states, each by its fastest tenth of the rounds."""
    rng = np.random.default_rng(1)
    sizes, common = [int(np.prod(shape)) for _, shape in function.arguments], shared([n for n, _ in function.arguments])
    arrays = [rng.uniform(-2, 2, (states, size)).astype(function.dtype) for size in sizes]
    out = np.empty((states, int(np.prod(function.shape))), function.dtype)
    places = [*(array.ctypes.data for array in arrays), out.ctypes.data]
    moved = [0 if name == common else size for size, (name, _) in zip(sizes, function.arguments, strict=True)]
    strides = [size * out.itemsize for size in (*moved, out.shape[1])]
    half = states // 2
    ways: Sequence[list[tuple[int, int]]] = [(0, states)], [(0, half), (half, states)]
    times: list[list[float]] = [[], []]
    for _ in range(rounds):
        for parts, found in zip(ways, times, strict=True):
            start = time.perf_counter()
            run_rows(call, places, strides, parts)  # type: ignore[arg-type]
            found.append(time.perf_counter() - start)
    one, two = (sorted(found)[len(found) // 10] for found in times)
    return one, two


def main() -> None:
    """Print a row a function, and the bar."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=301)
    parser.add_argument("--real", default="double", choices=("double", "float"))
    given = parser.parse_args()
    head = f"{'function':40}{'price':>8}{'states':>10}{'one, µs':>10}{'two, µs':>10}"
    print(f"{head}{'two/one':>9}{'of half':>9}{'quarter':>9}{'ps a unit':>11}")
    worst = 0.0
    for scene, name in CASES:
        program = lower(derive(read(EXAMPLES / f"{scene}.toml"), [name]))
        module = build(program, real=given.real, threads=2)
        function = module.functions[0]
        call = bind_rows(ctypes.CDLL(str(module.path)), f"{scene}_{name}_rows", len(function.arguments) + 1)
        each = price(program.routines[0].function, np.dtype(function.dtype).itemsize)
        states = fewest(each)
        assert len(split(states, 2, each)) == 2, "the rule takes two there"
        pairs = [seconds(function, call, some, given.rounds) for some in (states, states // 2, states // 4)]
        ratios = [two / one for one, two in pairs]
        one, two = pairs[0]
        cells = f"{scene + ' ' + name:40}{each:8.0f}{states:10}{1e6 * one:10.0f}{1e6 * two:10.0f}"
        print(cells + "".join(f"{ratio:9.2f}" for ratio in ratios) + f"{1e12 * one / states / each:11.1f}", flush=True)
        worst = max(worst, ratios[0])
    bar = Bar("two threads where they are taken, times one", f"≤ {SLOWER:g}", f"{worst:.2f}", worst <= SLOWER)
    print(f"{bar.text}: {bar.shown} ({bar.wanted}), {bar.verdict}")


if __name__ == "__main__":
    main()
