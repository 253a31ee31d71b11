"""A crew of forked workers: each judges a run of cases and is replaced, sooner if it dies."""

from __future__ import annotations

import json
import os
import resource
import selectors
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .cases import Case
from .judge import Verdict, judge, limit_memory

RUN = 400
"""Cases of a worker; what they leave in its memory ends with it."""

SILENCE = 900.0
"""Seconds after which a worker that says nothing hangs: it waits for something, or the machine is very busy."""


@dataclass
class Worker:
    """A process and what it has to do; `at` is the case that it is about."""

    process: int
    todo: Sequence[int]
    lines: int
    folder: Path
    at: int = 0
    heard: float = field(default_factory=time.monotonic)
    rest: bytes = b""


def judged(
    make: Callable[[int], Case], numbers: Iterator[Sequence[int]], jobs: int, ready: Callable[[], bool] = lambda: False
) -> Iterator[tuple[int, Verdict]]:
    """Yield number and verdict, in any order, until the numbers end or `ready` says so.

    Args:
        make: gives the case of a number.
        numbers: runs of numbers, one for a worker.
        jobs: workers at a time.
        ready: asked now and then whether it is enough.
    """
    with selectors.DefaultSelector() as ears:
        while True:
            while len(ears.get_map()) < jobs and not ready():
                run = next(numbers, None)
                if run is None:
                    break
                worker = _hired(make, run)
                ears.register(worker.lines, selectors.EVENT_READ, worker)
            if not ears.get_map():
                return
            for key, _ in ears.select(timeout=1.0):
                worker = key.data
                data = os.read(worker.lines, 1 << 16)
                worker.heard = time.monotonic()
                yield from _heard(worker, data)
                if not data:
                    ears.unregister(worker.lines)
                    yield from _dismissed(worker, make, ears)
            for worker in [key.data for key in ears.get_map().values()]:
                if time.monotonic() - worker.heard > SILENCE:
                    os.kill(worker.process, signal.SIGKILL)


def alone(case: Case) -> Verdict:
    """Return the verdict on one case in a worker of its own."""
    ((_, verdict),) = judged(lambda _: case, iter([[0]]), 1)
    return verdict


def _hired(make: Callable[[int], Case], run: Sequence[int]) -> Worker:
    """Fork a worker for a run of cases."""
    ours, theirs = os.pipe()
    folder = Path(tempfile.mkdtemp(prefix="fuzz-", dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None))
    process = os.fork()
    if not process:
        os.close(ours)
        _work(make, run, theirs, folder)
    os.close(theirs)
    return Worker(process, run, ours, folder)


def _work(make: Callable[[int], Case], run: Sequence[int], lines: int, folder: Path) -> None:
    """Judge the cases and tell of each; ends the process."""
    try:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.environ["SYMDYN_CACHE_DIR"] = str(folder / "cache")
        limit_memory()
        for k, number in enumerate(run):
            _tell(lines, {"at": k})
            _tell(lines, {"number": number, "verdict": vars(judge(make(number), folder))})
    except BaseException:  # of the fuzzer, not of a case
        traceback.print_exc()
    finally:
        os._exit(0)


def _tell(lines: int, what: dict[str, object]) -> None:
    data = json.dumps(what).encode() + b"\n"
    while data:
        data = data[os.write(lines, data) :]


def _heard(worker: Worker, data: bytes) -> Iterator[tuple[int, Verdict]]:
    """Yield the verdicts of what a worker said."""
    *whole, worker.rest = (worker.rest + data).split(b"\n")
    for line in whole:
        told = json.loads(line)
        if "at" in told:
            worker.at = told["at"]
        else:
            worker.at += 1
            yield told["number"], Verdict(**told["verdict"])


def _dismissed(
    worker: Worker, make: Callable[[int], Case], ears: selectors.BaseSelector
) -> Iterator[tuple[int, Verdict]]:
    """Yield the verdict on the case that a worker died of, if it did, and hire another one for those behind it."""
    os.close(worker.lines)
    _, status, used = os.wait4(worker.process, 0)
    shutil.rmtree(worker.folder, ignore_errors=True)
    if worker.at >= len(worker.todo):
        return
    code = os.waitstatus_to_exitcode(status)
    number, *behind = worker.todo[worker.at :]
    how = signal.Signals(-code).name if code < 0 else f"exit {code}"
    verb, spent = make(number).argv[0], used.ru_utime + used.ru_stime
    yield number, Verdict(verb, f"died of {how}", "", code, spent, False)
    if behind:
        another = _hired(make, behind)
        ears.register(another.lines, selectors.EVENT_READ, another)
