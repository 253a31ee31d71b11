"""Nanoseconds a state of generated C, 7-axis arm: scalar functions, structure of arrays, array of structures.

Run: python benchmarks/batch.py [--states N] [--machine native|portable] [--real double|float] [--rounds R]
Rounds are interleaved; the table gives medians and the fastest round. The scalar functions run in a C loop, which the
entry for rows is for a handful of states.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
import time
from pathlib import Path
from statistics import median

import numpy as np

from symdyn.build import build
from symdyn.build.compiler import find_compiler
from symdyn.build.on_threads import run_rows
from symdyn.dynamics import derive
from symdyn.program import lower
from symdyn.scene import read

ARM = Path(__file__).parent.parent / "examples" / "arm7.toml"
OUTPUTS = ("inverse_dynamics", "forward_dynamics", "mass_matrix", "velocity_forces", "gravity_forces")
FEW = 4  # states that the entry for rows hands to the scalar function


class Bench:
    """Arrays and C entries of one function."""

    def __init__(self, library: ctypes.CDLL, name: str, lengths: list[int], size: int, dtype: str, states: int) -> None:
        """Draw the states."""
        rng = np.random.default_rng(1)
        self.states, self.size = states, size
        self.rows = [rng.uniform(-2, 2, (states, length)).astype(dtype) for length in lengths]
        self.columns = [np.ascontiguousarray(array.T) for array in self.rows]
        self.out = np.empty(states * size, dtype)
        self._batch, self._rows = (getattr(library, f"{name}{ending}") for ending in ("_batch", "_rows"))
        for call in (self._batch, self._rows):
            call.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p] * (len(lengths) + 1)]
            call.restype = None
        self.places = [*(array.ctypes.data for array in self.rows), self.out.ctypes.data]
        self.column_places = [*(array.ctypes.data for array in self.columns), self.out.ctypes.data]
        self.strides = [length * self.out.itemsize for length in (*lengths, size)]

    def scalar(self) -> float:
        """Return ns a state of the scalar function, the cost of calling from Python taken off."""
        calls = range(0, min(self.states, 4000) - FEW, FEW)
        moved = [[p + k * s for p, s in zip(self.places, self.strides, strict=True)] for k in calls]
        start = time.perf_counter()
        for place in moved:
            self._rows(FEW, *place)
        middle = time.perf_counter()
        for place in moved:
            self._rows(0, *place)
        end = time.perf_counter()
        return 1e9 * ((middle - start) - (end - middle)) / (FEW * len(moved))

    def batch(self) -> float:
        """Return ns a state of the structure of arrays."""
        start = time.perf_counter()
        self._batch(self.states, *self.column_places)
        return 1e9 * (time.perf_counter() - start) / self.states

    def row(self, threads: int = 1) -> float:
        """Return ns a state of the array of structures, on one thread or half of them on each of two."""
        half = self.states // 2
        parts = [(0, half), (half, self.states)] if threads > 1 else [(0, self.states)]
        start = time.perf_counter()
        run_rows(self._rows, self.places, self.strides, parts)
        return 1e9 * (time.perf_counter() - start) / self.states


def main() -> int:
    """Print a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=4_100)
    parser.add_argument("--rounds", type=int, default=101)
    parser.add_argument("--machine", default="native")
    parser.add_argument("--real", default="double")
    options = parser.parse_args()
    start = time.perf_counter()
    module = build(lower(derive(read(ARM), OUTPUTS)), real=options.real, machine=options.machine)
    spent = time.perf_counter() - start
    library = ctypes.CDLL(str(module.path))
    benches = {
        f.name: Bench(
            library, f"arm7_{f.name}", [n for _, n in f.arguments], int(np.prod(f.shape)), f.dtype, options.states
        )
        for f in module.functions
    }
    print(f"{' '.join(find_compiler(machine=options.machine).machine)}, {options.real}; built in {spent:.1f} s")
    print("\nns a state, median (fastest)\n")
    print("| function | scalar | batch | rows | rows, 2 threads |\n|---|---:|---:|---:|---:|")
    kinds = {"scalar": Bench.scalar, "batch": Bench.batch, "rows": Bench.row, "two": lambda b: b.row(2)}
    times: dict[tuple[str, str], list[float]] = {}
    for _ in range(options.rounds):
        for name, bench in benches.items():
            for kind, run in kinds.items():
                times.setdefault((name, kind), []).append(run(bench))
    for name in benches:
        cells = [f"{median(times[name, kind]):.1f} ({min(times[name, kind]):.1f})" for kind in kinds]
        print(f"| {name} | {' | '.join(cells)} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
