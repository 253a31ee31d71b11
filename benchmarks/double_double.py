"""Double-doubles in C: how far they are off, and how many times as long as doubles they take in batch.

    python benchmarks/double_double.py [--rounds 21]

A row a function: errors of the largest over 200 states, relative to the largest entry, against 60 digits, and times of
1,024 states in columns, both kinds in turns; process time, medians, ratios inside a round. Exit status 1 where a bar is
missed: 1e-29, and 25 times. Below, runs with rtol 1e-28: how far a pendulum of point mass is off its elliptic function
(bar: 1e-27), and what ten seconds of a double pendulum take.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
import time
from collections.abc import Callable
from statistics import median

import mpmath
import numpy as np
from numpy.typing import NDArray

import symdyn
from symdyn.algebra import BigFloats
from symdyn.dynamics import Function
from symdyn.emit.code import stem
from symdyn.graph import evaluate
from symdyn.runtime import build
from symdyn.scene import read_text

CASES = (
    ("double_pendulum", "inverse_dynamics"),
    ("arm7", "inverse_dynamics"),
    ("arm7", "forward_dynamics"),
    ("puma560", "mass_matrix"),
    ("quadruped", "forward_dynamics"),
    ("four_bar", "forward_dynamics"),
)
STATES, CHECKED = 1024, 200
LARGEST, LONGEST, SWUNG = 1e-29, 25.0, 1e-27
TURN = 0.02
"""Seconds that one kind runs for in a round."""

Array = NDArray[np.float64]


def main() -> int:
    """Print the table; return 1 where a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=21)
    rounds = parser.parse_args().rounds
    missed = 0
    print(f"{'scene':16} {'function':18} {'double':>9} {'dd':>9} {'double':>9} {'dd':>9} {'ratio':>6}")
    for scene, output in CASES:
        off, times, ratio = measured(scene, output, rounds)
        missed += off[1] > LARGEST or ratio > LONGEST
        told = f"{off[0]:9.1e} {off[1]:9.1e} {times[0]:6.1f} ns {times[1]:6.1f} ns {ratio:6.1f}"
        print(f"{scene:16} {output:18} {told}", flush=True)
    off = swung()
    missed += off > SWUNG
    print(f"pendulum, 3 s, rtol 1e-28: off its elliptic function by {off:.1e}")
    run = symdyn.simulate(symdyn.example("double_pendulum"), until=10.0, start="q1=2,q2=1", rtol=1e-28)
    print(f"double pendulum, 10 s, rtol 1e-28: {run.steps} steps in {run.wall:.3f} s, {run.preparing:.2f} s to prepare")
    said = f"{missed} missed" if missed else "reached"
    print(f"bars: error of dd <= {LARGEST:g}, ratio <= {LONGEST:g}, pendulum <= {SWUNG:g}: {said}")
    return 1 if missed else 0


PENDULUM = """
name = "point"
gravity = [0, -9.81, 0]
[bodies.rod]
mass = 1
com = [0, -1, 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 0, 1]
start = "2/3"
"""


def swung() -> float:
    """Return how far a pendulum is off sin(q/2) = k sn(K - w t), k = sin(1/3)."""
    run = symdyn.simulate(read_text(PENDULUM), until=3.0, rtol=1e-28, every=3.0)
    assert run.low is not None
    with mpmath.workdps(45):
        k, w = mpmath.sin(mpmath.mpf(1) / 3), mpmath.sqrt(mpmath.mpf("9.81"))
        wanted = 2 * mpmath.asin(k * mpmath.ellipfun("sn", mpmath.ellipk(k**2) - 3 * w, k=k))
        return float(abs(mpmath.mpf(float(run.q[-1, 0])) + float(run.low[-1, 0]) - wanted))


def measured(scene: str, output: str, rounds: int) -> tuple[tuple[float, float], tuple[float, float], float]:
    """Return errors and times a state, ns, of double and dd, and the ratio of the times."""
    program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example(scene), [output]))
    function = program.routines[0].function
    rng = np.random.default_rng(1)
    high = [rng.uniform(-2.0, 2.0, (len(a.symbols), STATES)) for a in function.arguments]
    pairs = [np.stack([a, rng.uniform(-0.5, 0.5, a.shape) * np.spacing(np.abs(a))], 1) for a in high]
    off, runs = [], []
    for real, given in (("double", [a[:, None] for a in high]), ("dd", pairs)):
        library = ctypes.CDLL(str(build(program, real=real).path))
        call = library[f"{stem(program.scene.name)}_{function.name}_batch"]
        columns = [np.ascontiguousarray(a.reshape(-1, STATES)) for a in given]
        parts = 1 if real == "double" else 2
        out = np.empty((len(function.entries), parts, STATES))
        runs.append(bound(call, columns, out))
        runs[-1]()
        off.append(error(function, given, out))
    samples = [(turn(runs[0]), turn(runs[1])) for _ in range(rounds)]
    times = median(a for a, _ in samples), median(b for _, b in samples)
    return (off[0], off[1]), times, median(b / a for a, b in samples)


def bound(call: Callable[..., None], columns: list[Array], out: Array) -> Callable[[], None]:
    """Return a call with its arguments."""
    places = [ctypes.c_void_p(a.ctypes.data) for a in (*columns, out)]
    kept = (columns, out)
    return lambda: call(ctypes.c_size_t(len(kept[1][0, 0])), *places)


def error(function: Function, given: list[Array], out: Array) -> float:
    """Return the largest error of an entry over the largest entry, of (entries, parts, states)."""
    numbers, worst = BigFloats(60), mpmath.mpf(0)
    for k in range(CHECKED):
        values = {
            symbol: sum(map(numbers.number, array[i, :, k].tolist()))
            for argument, array in zip(function.arguments, given, strict=True)
            for i, symbol in enumerate(argument.symbols)
        }
        exact = evaluate(function.entries, numbers, values)
        found = [sum(map(numbers.number, parts)) for parts in out[:, :, k].tolist()]
        worst = max(worst, max(abs(a - b) for a, b in zip(found, exact, strict=True)) / max(map(abs, exact)))
    return float(worst)


def turn(call: Callable[[], None]) -> float:
    """Return nanoseconds a state."""
    count, begin = 0, time.process_time_ns()
    while (spent := time.process_time_ns() - begin) < TURN * 1e9:
        call()
        count += 1
    return spent / count / STATES


if __name__ == "__main__":
    sys.exit(main())
