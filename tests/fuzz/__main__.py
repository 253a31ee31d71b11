"""`python -m tests.fuzz`: make cases, judge them, minimise and keep what is found, and say how much was tried."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import count
from pathlib import Path

FOUND = Path("build/fuzz")


def main() -> int:
    """Run, and return whether a fault was found."""
    ask = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    ask.add_argument("--seconds", type=float, default=60.0, help="how long to look (default: 60)")
    ask.add_argument("--cases", type=int, help="how many cases, however long they take")
    ask.add_argument("--seed", default="1", help="of the cases (default: 1)")
    ask.add_argument("--first", type=int, default=0, help="number of the first case")
    ask.add_argument("--jobs", type=int, default=os.cpu_count(), help="workers at a time (default: all processors)")
    ask.add_argument("--replay", nargs="+", type=Path, metavar="FILE", help="run these cases again")
    ask.add_argument("--processes", type=int, metavar="N", help="run N cases, each in a process of its own")
    ask.add_argument("--keep", type=Path, default=FOUND, help=f"where finds go (default: {FOUND})")
    given = ask.parse_args()
    programs = os.environ["PATH"]
    os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # before NumPy: workers are forked
    os.environ["PATH"] = os.path.dirname(os.__file__)  # no compilers there: NumPy modules stand in, and no time goes

    from .cases import case
    from .crew import judged
    from .judge import prepare
    from .processes import run
    from .report import Report

    make = partial(case, given.seed)
    if given.processes:
        return run(make, range(given.first, given.first + given.processes), given.jobs, given.keep, programs)
    prepare()
    if given.replay:
        return replay(given.replay)
    end = time.monotonic() + given.seconds
    limit = given.first + given.cases if given.cases else None
    report = Report(given.seed, make)
    numbers = runs(given.first, limit)
    for number, verdict in judged(make, numbers, given.jobs, lambda: limit is None and time.monotonic() > end):
        report.add(number, verdict)
    report.show(given.keep)
    return int(bool(report.finds))


def runs(first: int, limit: int | None) -> Iterator[Sequence[int]]:
    """Yield the numbers of cases, so many for each worker."""
    from .crew import RUN

    for start in count(first, RUN):
        if limit is not None and start >= limit:
            return
        yield range(start, start + RUN if limit is None else min(start + RUN, limit))


def replay(files: Sequence[Path]) -> int:
    """Judge the cases in files and print what is wrong with each; return whether anything is."""
    from .cases import read_case
    from .crew import alone

    found = 0
    for file in files:
        verdict = alone(read_case(file.read_text(encoding="utf-8")))
        found += bool(verdict.sign)
        print(f"{file}: {verdict.sign or 'nothing wrong'}, exit status {verdict.status}, {verdict.seconds:.2f} s")
        print(verdict.words)
    return int(found > 0)


if __name__ == "__main__":
    sys.exit(main())
