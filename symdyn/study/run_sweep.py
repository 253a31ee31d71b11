"""The functions `sweep`, runs of one scene at many values, and `open`, a sweep that is on disk."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any, Unpack

from symdyn.arguments import check_arguments, native, with_fields
from symdyn.errors import SimulateError
from symdyn.scene import SceneLike
from symdyn.scene.values import Faults
from symdyn.simulation import Problem, Run
from symdyn.study.distributions import Over
from symdyn.study.job import Job, block as one_block, executor
from symdyn.study.job_of_places import At, places_job
from symdyn.study.job_of_runs import runs_job
from symdyn.study.opened_store import check_store, opened, store_of
from symdyn.study.runs import Runs
from symdyn.study.store import SUFFIX

INTERRUPTED = "interrupted"

HERE = "here"

USUAL = "inverse_dynamics"
"""What is called where places are given, and no function is."""

NUMBERS = re.compile(r"\d[\d.e+-]*")
"""What notes on runs differ in; of those that are alike, the first is told."""

Say = Callable[[str], None]


@with_fields(Problem, Run)
def sweep(
    scene: SceneLike | Problem,
    over: Over = (),
    measure: str | Sequence[str] = (),
    *,
    design: str | None = None,
    count: int | None = None,
    seed: int = 0,
    output: str | Path | None = None,
    scheduler: Any = "here",
    workers: int | None = None,
    block: int | None = None,
    function: str | None = None,
    at: At = None,
    progress: Callable[[float], None] | None = None,
    say: Say | None = None,
    **fields: Unpack[Run.OfProblem],
) -> Runs:
    """Return what comes of many runs of a scene, or of many calls of one of its functions.

    The values of a run follow from its number and the seed alone, so that blocks, workers and interruptions change
    nothing. A sweep that Ctrl-C interrupts returns what was made; with a store as `output`, the same call goes on.

    >>> import symdyn
    >>> runs = symdyn.sweep(symdyn.example("pendulum"), "q1=linspace(0.1,0.3,3)", "max(abs(q1))", until=0.5)
    >>> runs["q1"].tolist(), len(runs["max(abs(q1))"])
    ([0.1, 0.2, 0.3], 3)

    Args:
        scene: the mechanism; or a `Problem`.
        over: a parameter, a coordinate or velocity at the start, or a letter of the forces, and its values, such as
            "m1=linspace(1,2,5)"; nothing takes all parameters that have a tolerance. Texts "NAME=DISTRIBUTION" (see
            `symdyn.study.distributions`), or lists by name.
        measure: kept of a run: formulas of max, min, mean, rms, end, ... as "max(abs(tau2))"; "NAME=FORMULA" names one.
        **fields: of `Problem` and `Run`, the same for every run.
        design: which values meet; None takes a grid of lists, random draws of distributions. A key of `DESIGNS`.
        count: how many runs are drawn; None for 1000.
        seed: of what is drawn.
        output: a .zarr store, which is made, or gone on with where it is there.
        scheduler: here, threads, processes, or the address of a Dask scheduler, tcp://HOST:PORT. Or its Client.
        workers: how many of them; None for one a core.
        block: runs of a block, which is done or is not; None for a part of all.
        function: what is called in place of runs, such as "inverse_dynamics"; measures are formulas of what it returns
            and takes. They are folds over the places `at` which it is called, and `over` may have entries of its
            arguments.
        at: where, such as "q1=0.3,q1_dot=1"; or a .csv file of such columns over t, which folds then go over. Formulas
            in parameters by name, or arrays (S,). What is not given is where the scene starts, at rest.
        progress: called with the share that is done.
        say: called with lines for the user.
        forces: driving forces, as for `simulate`; their formulas may have letters of `over`.
        rtol: relative tolerance of a step; None for 1e-9, of gauss what it takes itself.

    Raises:
        SimulateError: with every fault of the arguments, one line each; a store of another sweep, or a full disk.
        SceneError: values that the scene cannot have.
    """
    problem, run = Problem.requested(sweep, locals())
    count, seed, workers, block = native(int, count, seed, workers, block)
    path = None if output is None else Path(output)
    faults = Faults("")
    if path is not None and path.suffix != SUFFIX:
        faults.add("output", f"{path} is no {SUFFIX} store; leave it out, and write a table with .to_csv(FILE)")
    elif path is not None:
        with faults.noted():
            check_store(path)
    if workers is not None and workers < 1:
        faults.add("workers", f"{workers} is none; give 1 or more")
    if function is not None or at is not None:
        of_runs = [name for name, one in fields.items() if name in vars(run) and one not in (None, False, (), [])]
        for name in (*problem.given, *of_runs):
            faults.add(name.replace("_", " "), "of runs, and a function has none; leave it out")
        job = places_job(problem.scene, function or USUAL, at, over, measure, design, count, seed, block, faults)
        return made(job, path, block is not None, scheduler, workers, progress, say)
    job = runs_job(problem, run, over, measure, design, count, seed, block, faults)
    return made(job, path, block is not None, scheduler, workers, progress, say)


def open(path: str | Path) -> Runs:
    """Return a sweep that is on disk, whole or not.

    Raises:
        SimulateError: there is none, or Zarr is not installed.
    """
    check_arguments(open, locals(), SimulateError)
    return opened(Path(path)).runs()


def made(
    job: Job,
    path: Path | None = None,
    fixed: bool = True,
    scheduler: Any = "here",
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
    say: Say | None = None,
) -> Runs:
    """Return the runs that a job makes, in memory or in a store; `fixed`: a store must have blocks of that size.

    Raises:
        SimulateError: the store is of another sweep or cannot be written, or workers fail.
    """
    say = say or (lambda line: None)
    store, notes = store_of(job, path)
    if store.block != job.block:
        notes += (f"{path} has blocks of {store.block} runs, and goes on with them",) if fixed else ()
        job = replace(job, block=store.block)
    left = store.left()
    if path is not None and len(left) < job.blocks:
        notes += (f"{path}: {job.blocks - len(left)} of {job.blocks} blocks are there already",)
    notes += tuple(f"{path}: {fault}; its block is made again" for fault in left.values() if fault)
    count, kind = job.design.count, job.design.kind
    if kind == "sobol" and count & (count - 1):
        notes += (f"{count} is no power of two, of which Sobol's sequence is most even; {1 << count.bit_length()} is",)
    for note in notes:
        say(note)
    began, seen = perf_counter(), set[str]()
    here = scheduler == HERE if isinstance(scheduler, str) else False
    job = replace(job, threads=workers if here else 1)
    try:
        with executor(scheduler, None if here else workers, say) as found_by:
            for done, (k, found) in enumerate(found_by.results(one_block, job, left), start=1):
                for note in found.notes:
                    if (like := NUMBERS.sub("#", note)) not in seen:
                        seen.add(like)
                        notes += (note,)
                        say(note)
                store.put(job, k, found)
                if progress is not None:
                    progress(1 - (len(left) - done) / job.blocks)
    except KeyboardInterrupt:
        runs = store.runs(notes, perf_counter() - began)
        how = "the same command goes on with the rest" if path is not None else f"-o FILE{SUFFIX} would have kept it"
        told = f"{INTERRUPTED}: {len(runs) - runs.left} of {len(runs)} runs are there; {how}"
        say(told)
        return replace(runs, notes=(*notes, told))
    return store.runs(notes, perf_counter() - began)
