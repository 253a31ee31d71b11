"""Run time against error of one function at every accuracy that C is generated for, many states at once.

    python benchmarks/accuracy_levels.py [--states N] [--rounds R] [--robots arm7,puma560] [--outputs mass_matrix]

Rounds are interleaved; times are processor time, ratios those inside a round, medians over rounds. Errors are relative
to the largest entry, against 50 digits, at random states within ±π. What was to be reached stands below the table.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np
from bars import Bar

from symdyn.bench.implementations import Implementation, implementations
from symdyn.bench.reference import draw, positions_of, reference
from symdyn.program import formulate
from symdyn.scene import read
from symdyn.table import Table

EXAMPLES = Path(__file__).parent.parent / "examples"

ROBOTS = ("arm7", "puma560")
OUTPUTS = ("inverse_dynamics", "forward_dynamics", "mass_matrix")

MANY, CALLS = 512, 8
"""States of a call that is timed, and calls between two looks at the clock."""

GAIN, FAR = 1.03, 1e-10
"""How many times as fast as double code of less accuracy must be, and how far it may be off."""


@dataclass(frozen=True)
class Level:
    """One accuracy of one function: nanoseconds a state, times as fast as double, 99th percentile and largest error."""

    one: Implementation
    call: float
    gain: float
    usual: float
    largest: float

    @property
    def name(self) -> str:
        """What a table calls it."""
        return self.one.accuracy or self.one.real


def levels(robot: str, output: str, states: int, rounds: int) -> list[Level]:
    """Return every accuracy of an output, double first."""
    scene = read(EXAMPLES / f"{robot}.toml")
    equations = formulate(scene, (output,))
    made = [
        one
        for one in implementations(equations, 0.0, ("native",), ("double", "float"), extra=2)
        if one.variant.startswith("C batch")
    ]
    positions = positions_of(scene)
    calls: list[Callable[[], object]] = []
    errors: list[np.ndarray] = []
    for one in made:
        arguments = one.routine.function.arguments
        given = draw(arguments, positions, "range", states, 1, one.real)
        known = reference(one.routine.function, given, states)
        gap = known.errors(one.results(given)).max(axis=1) / np.abs(known.high).max(axis=1)
        errors.append(np.sort(gap))
        calls.append(one.prepare(draw(arguments, positions, "range", MANY, 1, one.real))[0])
    times: list[list[float]] = [[] for _ in made]
    order = list(range(len(made)))
    for _ in range(rounds):
        random.shuffle(order)
        for place in order:
            begun = time.process_time()
            for _ in range(CALLS):
                calls[place]()
            times[place].append((time.process_time() - begun) / (CALLS * MANY))
    return [
        Level(
            one,
            1e9 * median(took),
            median(a / b for a, b in zip(times[0], took, strict=True)),
            float(error[round(0.99 * (len(error) - 1))]),
            float(error[-1]),
        )
        for one, took, error in zip(made, times, errors, strict=True)
    ]


def bars(robot: str, output: str, found: list[Level]) -> list[Bar]:
    """Return what was to be reached, and what was."""
    made = []
    for level in found:
        if level.one.accuracy:
            text = f"{robot}, {output}, accuracy {level.name}"
            if output == "inverse_dynamics":
                made.append(
                    Bar(f"{text}: times as fast as double", f"≥ {GAIN:g}", f"{level.gain:.2f}", level.gain >= GAIN)
                )
            made.append(Bar(f"{text}: largest error", f"≤ {FAR:.0e}", f"{level.largest:.1e}", level.largest <= FAR))
    return made


def main() -> int:
    """Print a table in Markdown, and what was to be reached."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--states", type=int, default=2000)
    parser.add_argument("--rounds", type=int, default=301)
    parser.add_argument("--robots", default=",".join(ROBOTS))
    parser.add_argument("--outputs", default=",".join(OUTPUTS))
    given = parser.parse_args()
    reached: list[Bar] = []
    print("| robot | output | accuracy | ns a state | times as fast | error, 99 % | largest |")
    print("|---|---|---|--:|--:|--:|--:|")
    for robot in given.robots.split(","):
        for output in given.outputs.split(","):
            found = levels(robot, output, given.states, given.rounds)
            reached += bars(robot, output, found)
            for one in found:
                cells = f"{one.call:.1f} | {one.gain:.2f} | {one.usual:.1e} | {one.largest:.1e}"
                print(f"| {robot} | {output} | {one.name} | {cells} |", flush=True)
    goals = [(bar.text, bar.wanted, bar.shown, bar.verdict) for bar in reached]
    print("\n" + Table(("goal", "wanted", "measured", ""), goals).markdown(str))
    return 0


if __name__ == "__main__":
    sys.exit(main())
