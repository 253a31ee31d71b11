"""Sweeps on Dask: 10^6 parameter sets of a PUMA 560 on two workers, and what a task, a byte and a run cost.

    python benchmarks/sweeps.py [--quick]

Wall time says how long a user waits, CPU time of all processes what it costs; on a machine that does other things too,
only the second one holds. Figures of docs/scale.md are printed by this file.
"""

from __future__ import annotations

import argparse
import gc
import os
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import symdyn
from symdyn.scene import Scene, with_symbols
from symdyn.scene.values import Faults
from symdyn.study import job_of_places
from symdyn.study.cluster import Cluster
from symdyn.study.job import Job, block, executor

STATE = "q1=0.3,q2=-0.5,q3=0.8,q4=0.1,q5=0.4,q6=-0.2,q1_dot=1,q2_dot=-0.5,q3_dot=0.3,q1_ddot=2,q4_ddot=1"

SETS = 1_000_000

ROUNDS = 3


def nothing(job: Any, k: int) -> None:
    """Be a task that costs nothing."""


def bytes_of(job: int, k: int) -> bytes:
    """Return so many bytes."""
    return os.urandom(1) * job


def puma() -> Scene:
    """Return the arm with every number that is not zero or a right angle as a parameter, 40 of them."""
    return with_symbols(symdyn.example("puma560"), "all")


def within(scene: Scene, share: float) -> dict[str, str]:
    """Return what varies all parameters by so much."""
    found = {}
    for one in scene.parameters:
        low, high = sorted(float(one.value.at({}) or 0.0) * k for k in (1 - share, 1 + share))
        found[one.name] = f"uniform({low!r}, {high!r})"
    return found


def job_of(count: int, size: int | None = None) -> Job:
    """Return a study of the largest and the mean torque at one state."""
    arm, faults = puma(), Faults("")
    measures = [f"tau{k}" for k in range(1, 7)]
    return job_of_places.places_job(
        arm, "inverse_dynamics", STATE, within(arm, 0.1), measures, "random", count, 0, size, faults
    )


def consumed(on: Any, job: Job) -> float:
    """Make a study and return the sum of all torques; no more than a few blocks are ever held."""
    return sum(float(found.measures.sum()) for _, found in on.results(block, job, range(job.blocks)))


def timed(work: Callable[[], Any], rounds: int = ROUNDS) -> tuple[float, float]:
    """Return medians of wall and CPU seconds of this process."""
    walls, cpus = [], []
    for _ in range(rounds):
        gc.collect()
        wall, cpu = time.perf_counter(), time.process_time()
        work()
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    return median(walls), median(cpus)


def peak() -> float:
    """Return the most memory that this process ever had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def of_workers(on: Cluster) -> tuple[float, float]:
    """Return CPU seconds of all workers until now, and the most memory of one, MB."""
    found = on.client.run(used).values()
    return sum(cpu for cpu, _ in found), max(most for _, most in found)


def used() -> tuple[float, float]:
    """Return CPU seconds and the most memory of this process, MB."""
    return time.process_time(), peak()


@contextmanager
def two(where: str = "processes") -> Iterator[Cluster]:
    """Yield two workers that have begun."""
    with executor(where, 2) as found:
        found.client.wait_for_workers(2 if where == "processes" else 1)
        yield found  # type: ignore[misc]


def parts(job: Job) -> None:
    """Say what a set costs on one core, by blocks and part by part."""
    values = job.design.values(0, 1000)
    call = job_of_places.called(job.scene, "inverse_dynamics", tuple(job.requested["varied"]["values"]))
    prepared = call.loaded.prepare(values)
    q, qd, qdd = np.random.default_rng(1).uniform(-1, 1, (3, 6))
    each = {
        "drawn (PCG64, 40 uniform)": lambda: job.design.values(0, 1000),
        "prepare, 40 -> 27": lambda: call.loaded.prepare(values),
        "inverse dynamics, a set a state": lambda: call.loaded.inverse_dynamics(q, qd, qdd, prepared),
    }
    for name, work in each.items():
        _, cpu = timed(lambda work=work: [work() for _ in range(200)])
        print(f"  {name:34} {cpu / 200 / 1000 * 1e9:6.0f} ns a set")
    small = job_of(100_000)
    _, cpu = timed(lambda: [block(small, k) for k in range(small.blocks)], 3)
    print(f"  {'all of it, measures too':34} {cpu / 1e5 * 1e9:6.0f} ns a set", flush=True)


def million() -> None:
    """Say how long 10^6 sets take on two workers, and what memory it takes at one size and at ten times that."""
    with two() as on:
        began = time.perf_counter()
        consumed(on, job_of(200_000))
        print(f"  first blocks, extension built or loaded by both: {time.perf_counter() - began:.2f} s")
        for size in (10_000, 50_000):
            some = job_of(SETS, size)
            before, _ = of_workers(on)
            wall, cpu = timed(lambda some=some: consumed(on, some))
            after, most = of_workers(on)
            print(
                f"  blocks of {size:7}: {wall:5.2f} s, CPU: workers {(after - before) / ROUNDS:.2f} s, client and "
                f"scheduler {cpu:.2f} s; most memory: worker {most:.0f} MB, client {peak():.0f} MB",
                flush=True,
            )
        consumed(on, job_of(10 * SETS))
        print(f"  ten times as many: worker {of_workers(on)[1]:.0f} MB, client {peak():.0f} MB", flush=True)


def tasks(quick: bool) -> None:
    """Say what tasks and bytes cost."""
    count = 500 if quick else 2000
    with two() as on:
        for ahead in (2, 16):
            from symdyn.study import cluster

            cluster.AHEAD, kept = ahead, cluster.AHEAD
            before, _ = of_workers(on)
            wall, cpu = timed(lambda: list(on.results(nothing, None, range(count))), 3)
            workers = (of_workers(on)[0] - before) / 3
            print(
                f"  a task of nothing, {ahead:2} a worker under way: {wall / count * 1e3:.2f} ms wall, CPU: client and "
                f"scheduler {cpu / count * 1e3:.2f} ms, workers {workers / count * 1e3:.2f} ms",
                flush=True,
            )
            cluster.AHEAD = kept
        for size in (1000, 100_000, 10_000_000):
            some = 40 if size > 1e6 else 200
            wall, cpu = timed(lambda size=size, some=some: sum(1 for _ in on.results(bytes_of, size, range(some))), 3)
            print(
                f"  a result of {size / 1e6:g} MB: {wall / some * 1e3:.2f} ms wall, CPU here {cpu / some * 1e3:.2f} ms"
            )


def stores(folder: Path) -> None:
    """Say what a block in a store costs: seconds, bytes, files."""
    arm = puma()
    for size in (10_000, 50_000):
        path = folder / f"{size}.zarr"
        began, cpu = time.perf_counter(), time.process_time()
        symdyn.sweep(
            arm, within(arm, 0.1), ["tau2"], function="inverse_dynamics", at=STATE, design="random", count=200_000,
            output=path, block=size,
        )  # fmt: skip
        wall, cpu = time.perf_counter() - began, time.process_time() - cpu
        files = [one for one in path.rglob("*") if one.is_file()]
        total = sum(one.stat().st_size for one in files)
        print(
            f"  200,000 sets of 40 values in blocks of {size}: {wall:.2f} s ({cpu:.2f} s CPU), {total / 2e5:.0f} bytes "
            f"a set, {len(files)} files for {200_000 // size} blocks",
            flush=True,
        )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer tasks")
    options = parser.parse_args()
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, Python {sys.version.split()[0]}")
    print("one core:")
    parts(job_of(SETS))
    print("10^6 parameter sets of the PUMA 560 through prepare and inverse dynamics, two workers:")
    million()
    print("tasks and bytes:")
    tasks(options.quick)
    print("a Zarr store:")
    folder = Path(tempfile.mkdtemp())
    try:
        stores(folder)
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
