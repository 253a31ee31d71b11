"""A quadruped whose feet are held as a mask says: one generated function against Pinocchio's constrained dynamics.

    python benchmarks/stances.py [--rounds 25]

Ours is one C function for all 16 stances, Pinocchio's `constraintDynamics`, and `computeConstraintDynamicsDerivatives`
behind it, have a robot for each stance. All stances are compared; stances of no, two and four feet are timed, both in a
loop in C, C++; ns a state, medians of interleaved rounds, and the median of the ratios inside a round.

Ours writes the derivatives of accelerations and of forces; Pinocchio's stay where it puts them. The script ends with 1
where a bar was missed.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
import time
from itertools import product
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parent.parent / "tests")]

from bars import Bar, at_least, at_most, told  # noqa: E402
from cases import EXAMPLES, STATES, Array, Case  # noqa: E402
from harness import Timed, measure  # noqa: E402
from held import FEET, SHANK  # noqa: E402
from native import MissingError, address, compiled, loops  # noqa: E402
from peers import ours_c, pinocchio_cpp, pinocchio_held  # noqa: E402

from symdyn.emit import emit  # noqa: E402
from symdyn.program import formulate, lower  # noqa: E402
from symdyn.scene import read, read_text  # noqa: E402
from symdyn.table import Table  # noqa: E402

OUTPUTS = ("held_dynamics", "held_dynamics_derivatives")

TIMED = ((0, 0, 0, 0), (1, 0, 0, 1), (1, 1, 1, 1))

CLOSE = 1e-12
"""Largest difference of accelerations, forces, and derivatives of both, over the largest entry."""

ALONG_AXES = (1, 2, 0)
"""Our places of a force along x, y, z, of normal, along, across."""


def quadruped() -> Case:
    """Return the quadruped with a contact at every foot."""
    text = (EXAMPLES / "quadruped.toml").read_text("utf-8")
    text += "".join(f'\n[contacts.{leg}]\npoint = "{leg}_foot"\nfriction = 0.8\n' for leg in FEET)
    return Case("quadruped", read_text(text))


class Ours:
    """The compiled function of one output, with what it took to make it."""

    def __init__(self, case: Case, output: str) -> None:
        start = time.perf_counter()
        program = lower(formulate(case.scene, (output,)))
        sources = emit(program, "c")
        self.derived = time.perf_counter() - start
        header, text = sources.files[1], sources.files[0][1]
        n = case.n
        call = "void call(const double *q, const double *qd, const double *given, double *out)\n{\n    "
        call += f"{case.scene.name}_{output}(q, qd, given, given + {n}, out);\n}}\n"
        start = time.perf_counter()
        self.code = ctypes.CDLL(
            str(compiled(text.replace(f'#include "{header[0]}"', header[1]) + call, ours_c.flags()))
        )
        self.compiled = time.perf_counter() - start
        self.bytes = len(text)
        (routine,) = program.routines
        self.counts, self.size = routine.counts, len(routine.function.labels[0]) * (3 * n if "der" in output else 1)


def compare(case: Case, ours: dict[str, Ours], stance: tuple[int, ...], states: dict[str, Array]) -> list[list[Timed]]:
    """Return both, ready to be timed, and what they differ by is asserted."""
    points = tuple((f"{leg}_knee", SHANK) for leg, on in zip(FEET, stance, strict=True) if on)
    free = Case("quadruped", read(EXAMPLES / "quadruped.toml"))
    code, robot, places = pinocchio_held.held(free, points)
    theirs = [np.ascontiguousarray(states[name][:, places[name]]) for name in ("q", "qd", "tau")]
    n, m = case.n, 3 * len(points)
    masks = np.tile(np.array(stance, float), (STATES, 1))
    mine = [states["q"], states["qd"], np.hstack([states["tau"], masks])]
    order, clock, found = places["qd"], loops(), []
    kept = [n + 3 * k + j for k, on in enumerate(stance) if on for j in ALONG_AXES]
    for output, one in ours.items():
        derivatives = output != OUTPUTS[0]
        width = 3 * n if derivatives else 1
        out, back = np.zeros((STATES, one.size)), np.zeros((STATES, (n + m) * width))

        def sweep(sweeps: int, one: Ours = one, out: Array = out) -> float:
            entries, where = ours_c.lengths(mine), [address(a) for a in mine]
            longs = ours_c.longs(STATES, sweeps)
            return clock.time_states(one.code.call, 3, *longs, entries, *ours_c.longs(one.size), *where, address(out))

        def peer(
            sweeps: int, into: object = None, derivatives: bool = derivatives, size: int = (n + m) * width
        ) -> float:
            longs, where = ours_c.longs(size, STATES, sweeps), [address(a) for a in theirs]
            return code.peer_time(robot, int(derivatives), *longs, *where, into)

        sweep(1)
        peer(1, address(back))
        rows = out.reshape(STATES, -1, width)[:, [*order, *kept]]
        given = back.reshape(STATES, n + m, width)
        if derivatives:
            rows = rows.reshape(STATES, n + m, 3, n)[..., order].reshape(STATES, n + m, width)
        for part in (slice(0, n), slice(n, n + m)):
            if part.start < part.stop:
                scale = np.abs(given[:, part]).max(axis=(1, 2))
                off = (np.abs(rows[:, part] - given[:, part]).max(axis=(1, 2)) / scale).max()
                WORST[output] = max(WORST.get(output, 0.0), float(off))
        found.append(
            [
                Timed("quadruped", output, "symdyn", "state", STATES, sweep, lambda out=out: out),
                Timed("quadruped", output, pinocchio_cpp.NAME, "state", STATES, peer, lambda back=back: back),
            ]
        )
    return found


WORST: dict[str, float] = {}


def main(arguments: list[str] | None = None) -> int:
    """Print tables in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rounds", type=int, default=25)
    rounds = parser.parse_args(arguments).rounds
    case = quadruped()
    rng = np.random.default_rng(3)
    q = rng.uniform(-1, 1, (STATES, len(case.scene.coordinates)))
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    states = {"q": q, "qd": rng.uniform(-2, 2, (STATES, case.n)), "tau": rng.uniform(-5, 5, (STATES, case.n))}
    ours = {output: Ours(case, output) for output in OUTPUTS}
    rows: list[tuple[str, ...]] = []
    bars: list[Bar] = []
    try:
        for stance in product((0, 1), repeat=len(FEET)):
            timed = compare(case, ours, stance, states)
            for pair in timed if stance in TIMED else ():
                one, other = measure(pair, rounds, 0.01)
                ratio = np.median(np.array(other.samples) / np.array(one.samples))
                times = (f"{one.median:,.0f}", f"{other.median:,.0f}", f"{ratio:.2f}")
                rows.append((pair[0].output, str(sum(stance)), *times))
                bars.append(at_least(f"{pair[0].output}, {sum(stance)} feet, Pinocchio's time over ours", 2, ratio))
    except MissingError as fault:
        print(f"stances: {fault}", file=sys.stderr)
        return 1
    print(Table(("output", "feet", "symdyn, ns", "Pinocchio, ns", "times"), rows, (1, 2, 3, 4)).markdown(str))
    print()
    sizes = [
        (
            output,
            str(one.counts),
            f"{one.bytes / 1e3:,.0f}",
            f"{one.derived:.1f}",
            f"{one.compiled:.1f}",
            f"{WORST[output]:.0e}",
        )
        for output, one in ours.items()
    ]
    heads = ("output", "operations", "C, kB", "derived, s", "compiled, s", "16 stances differ by")
    print(Table(heads, sizes, (2, 3, 4, 5)).markdown(str))
    bars += [at_most(f"{output}, 16 stances, off Pinocchio's", CLOSE, off) for output, off in WORST.items()]
    return told(bars)


if __name__ == "__main__":
    sys.exit(main())
