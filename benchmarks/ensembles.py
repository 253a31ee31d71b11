"""Many runs at once: double pendulums, beside heyoka's batches and its own ensemble at equal error.

    python benchmarks/ensembles.py [--runs 100000] [--rounds 5] [--workers 2]

Two point masses of 1 kg on massless rods of 1 m, 9.81 m/s², a damper's torque at the second joint, started at rest from
angles drawn evenly from -π to π with a seed. The goals come first: so many runs of 10 s with the largest torque of
each, and ten times as many of 1 s, wall and processor time of the whole call once it is compiled.

Then one core, in turn, round after round, processor time a run and medians of ratios: ours, a loop in Python over
heyoka's `taylor_adaptive_batch` of 8 lanes with our equations, and its `ensemble_propagate_until_batch`. heyoka is at
1e-9; ours is at the coarsest tolerance of a list whose median error at the end is no larger. The reference is heyoka at
1e-16; ends that chaos has drawn apart weigh nothing in a median.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from statistics import median
from typing import Any

import heyoka as hy
import numpy as np
import numpy.typing as npt

import symdyn
from symdyn.scene import bind
from symdyn.simulation import read_forces
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.integrate.heyoka_expressions import parameters, translate
from symdyn.study.runs import ENDED

SCENE = bind(symdyn.example("two_link"), {"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": "9.81"})
FORCES, MEASURE = "M2=-0.1*q2_dot", "max(abs(M2))"
LANES, THEIRS = 8, 1e-9
OURS = (1e-9, 3e-10, 1e-10, 3e-11, 1e-11, 3e-12, 1e-12, 3e-13, 1e-13)

Array = npt.NDArray[np.float64]


def starts(runs: int) -> Array:
    """Return angles, shape (2, runs)."""
    return np.random.default_rng(1).uniform(-np.pi, np.pi, (2, runs))


def ours(q: Array, until: float, rtol: float = THEIRS, measure: tuple[str, ...] = (), workers: int = 1) -> Any:
    """Return the ensemble."""
    start = {"q1": q[0], "q2": q[1]}
    return symdyn.ensemble(SCENE, forces=FORCES, until=until, start=start, measures=measure, rtol=rtol, workers=workers)


def batch(tol: float) -> Any:
    """Return heyoka's integrator of our equations."""
    system = state_equations(SCENE, read_forces(SCENE, FORCES))
    variables, entries = translate(system)
    ta = hy.taylor_adaptive_batch(list(zip(variables[:4], entries[:4], strict=True)), np.zeros((4, LANES)), tol=tol)
    ta.pars[:] = parameters(system)[: len(ta.pars), None]
    return ta


def looped(ta: Any, q: Array, until: float) -> Array:
    """Return ends, shape (runs, 4), by a loop over batches."""
    found = np.empty((q.shape[1], 4))
    for k in range(0, q.shape[1], LANES):
        ta.set_time(0.0)
        ta.state[:2], ta.state[2:] = q[:, k : k + LANES], 0.0
        ta.propagate_until(until)
        found[k : k + LANES] = ta.state.T
    return found


def its_own(ta: Any, q: Array, until: float) -> Array:
    """Return the same by heyoka's ensemble."""

    def begun(one: Any, k: int) -> Any:
        one.set_time(0.0)
        one.state[:2], one.state[2:] = q[:, k * LANES : (k + 1) * LANES], 0.0
        return one

    found = hy.ensemble_propagate_until_batch(ta, until, q.shape[1] // LANES, begun)
    return np.vstack([one[0].state.T for one in found])


def spent(run: Callable[[], Any], runs: int) -> float:
    """Return processor time, µs a run."""
    begin = time.process_time()
    run()
    return (time.process_time() - begin) / runs * 1e6


def equal_error(until: float, rounds: int) -> None:
    """Print times of one core at equal error."""
    q = starts(2000)
    reference = looped(batch(1e-16), q, until)

    def error(found: Array) -> float:
        return float(np.median(np.abs(found - reference).max(axis=1)))

    ta = batch(THEIRS)
    bar = error(looped(ta, q, until))
    for rtol in OURS:
        run = ours(q, until, rtol)
        off = error(np.hstack([run.q, run.qd]))
        if off <= bar:
            break
    few, many = q[:, :400], starts(20_000)
    ways = {
        "ours": (lambda: ours(many, until, rtol), 20_000),
        "heyoka, loop of batches": (lambda: looped(ta, q, until), 2000),
        "heyoka, its ensemble": (lambda: its_own(ta, few, until), 400),
    }  # fmt: skip
    assert np.array_equal(its_own(ta, few, until), looped(ta, few, until))
    taken: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, (run_, count) in ways.items():
            taken[name].append(spent(run_, count))
    print(f"\n{until:g} s, median error {bar:.1e} of heyoka at {THEIRS:g}, {off:.1e} of ours at {rtol:g}; one core")
    for name, times in taken.items():
        ratio = median(x / y for x, y in zip(times, taken["ours"], strict=True))
        print(f"    {name:26} {median(times):8.2f} µs a run  {ratio:6.2f} times ours")


def main() -> None:
    """Print the goals and the comparison."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    for runs, until, measure in (
        (options.runs, 10.0, (MEASURE,)), (10 * options.runs, 1.0, ()), (10 * options.runs, 1.0, (MEASURE,)),
    ):  # fmt: skip
        q = starts(runs)
        ours(q[:, :8], until, measure=measure)
        wall, busy = time.perf_counter(), time.process_time()
        found = ours(q, until, measure=measure, workers=options.workers)
        wall, busy = time.perf_counter() - wall, time.process_time() - busy
        assert (found.codes == ENDED).all()
        told = f", {MEASURE}" if measure else ", ends"
        print(
            f"{runs} runs of {until:g} s at {THEIRS:g}{told}: {wall:.2f} s on {options.workers} workers, "
            f"{busy:.2f} s of processor time, {busy / runs * 1e6:.2f} µs a run, "
            f"{found.about['steps'] / runs:.0f} steps a run",
            flush=True,
        )
    for until in (10.0, 1.0):
        equal_error(until, options.rounds)


if __name__ == "__main__":
    main()
