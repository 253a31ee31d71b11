"""Blocks on Dask: a bounded number of them under way, the job sent once, lost workers made up for.

Measured beside `dask.delayed` of all blocks at once (1,000 results of 1 MB, two workers): that takes 1.3 times as long,
the client grows by 16 MB and here by 6, and workers hold what is not fetched yet.
"""

from __future__ import annotations

import logging
import multiprocessing
import queue
import signal
import threading
import warnings
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from itertools import islice
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import dask
import distributed
from distributed.scheduler import KilledWorker, NoValidWorkerError

from symdyn.errors import StudyError, quoted
from symdyn.frozen import dataclass
from symdyn.interrupts import interrupts_wait
from symdyn.resources import version

if TYPE_CHECKING:
    from symdyn.study.job import Block, Say

Task = distributed.Future[Any]

AHEAD = 2
"""Blocks under way for each worker: one is computed, one waits, so that no worker does."""

PATIENCE = 10.0
"""Seconds after which a scheduler that does not answer is not there."""

LOOK = 1.0
"""Seconds after which it is looked whether workers are left; a scheduler that is asked for each block has less time."""


@dataclass(frozen=True)
class Cluster:
    """The workers of a scheduler; see `Executor`."""

    client: distributed.Client
    place: str
    say: Say

    @property
    def workers(self) -> int:
        """Threads of all workers, as they are at this moment."""
        return sum(self.client.nthreads().values())

    def results(self, block: Block, job: Any, numbers: Iterable[int]) -> Iterator[tuple[int, Any]]:
        """Yield number and result of every block as they end.

        The job is what a task returns, and no data of this process: it goes to the scheduler once, and is made again
        where workers lost it.
        """
        name = f"symdyn-{uuid4().hex}"
        given = self.client.submit(_job, job, version(), key=f"{name}-job", pure=False)
        left, ended = iter(numbers), queue.SimpleQueue[Task]()
        under_way: dict[Any, tuple[int, Task]] = {}

        def begin(most: int) -> None:
            some = list(islice(left, max(0, most)))
            keys = [f"{name}-{number}" for number in some]
            for number, task in zip(some, self.client.map(block, [given] * len(some), some, key=keys), strict=True):
                under_way[task.key] = number, task
                task.add_done_callback(ended.put)

        told, most = False, AHEAD * max(1, self.workers)
        try:
            with interrupts_wait(once=True) as stopped:
                begin(most)
                while under_way:
                    some = _all_that_ended(ended)
                    if not some:
                        most = AHEAD * max(1, self._look())
                    found = [under_way.pop(task.key)[0] for task in some]
                    if not stopped():
                        self._still_there()
                        begin(most - len(under_way))
                    elif under_way and not told:
                        told = True
                        self.say(f"blocks under way are waited for ({len(under_way)}); Ctrl-C again gives them up")
                    yield from zip(found, self._gathered(some, found), strict=True)
                if stopped():
                    raise KeyboardInterrupt
        finally:
            if under_way:
                self.client.cancel([task for _, task in under_way.values()], force=True)

    def _look(self) -> int:
        """Return how many workers there are, and say so if there is none; StudyError where the scheduler is gone."""
        self._still_there()
        try:
            found = self.workers
        except (OSError, RuntimeError) as fault:
            raise StudyError(_gone(self.place)) from fault
        if not found:
            self.say(f"{self.place}: there is no worker; it goes on when one comes, and Ctrl-C keeps what is done")
        return found

    def _still_there(self) -> None:
        if self.client.status != "running":
            raise StudyError(_gone(self.place))

    def _gathered(self, tasks: list[Task], numbers: list[int]) -> list[Any]:
        """Return what tasks returned, all fetched at once."""
        if all(task.status == "finished" for task in tasks):
            with suppress(CancelledError, OSError):  # lost in between: then one by one
                return list(self.client.gather(tasks))
        return [self._result(task, number) for task, number in zip(tasks, numbers, strict=True)]

    def _result(self, future: Task, number: int) -> Any:
        """Return what a task returned; StudyError where it has no result, and why."""
        try:
            return future.result()
        except KilledWorker as fault:
            raise StudyError(
                f"block {number}, or one beside it: every worker that had it was killed, {fault.allowed_failures + 1} "
                "in turn; if they ran out of memory, make blocks smaller"
            ) from fault
        except NoValidWorkerError as fault:
            raise StudyError(f"block {number}: no worker may compute it ({fault})") from fault
        except ModuleNotFoundError as fault:
            lacks = f"a worker has no {fault.name}; install what this process has where workers run"
            raise StudyError(f"{self.place}: {lacks}") from fault
        except (CancelledError, OSError) as fault:
            raise StudyError(_gone(self.place)) from fault


def _all_that_ended(ended: queue.SimpleQueue[Task]) -> list[Task]:
    """Return the tasks that have ended; none if none does for a while."""
    try:
        some = [ended.get(timeout=LOOK)]
    except queue.Empty:
        return []
    while not ended.empty():
        some.append(ended.get())
    return some


def _gone(reported: str) -> str:
    return f"{reported}: the connection is lost; what is done is kept, and the same call goes on, there or elsewhere"


def _job(job: Any, made_by: str) -> Any:
    """Return a job in the worker that keeps it; StudyError from another version, whose numbers may be others."""
    if made_by != version():
        raise StudyError(f"a worker has symdyn {version()}, and the study is made by {made_by}; install one of both")
    return job


@contextmanager
def of_client(client: distributed.Client, say: Say) -> Iterator[Cluster]:
    """Yield the workers of a client that the user opened, which stays open.

    Raises:
        StudyError: a worker has not what this process has.
    """
    if not isinstance(client, distributed.Client):
        raise StudyError(f"scheduler = {quoted(client)}: give a name, an address, or a Client of Dask")
    told = str(client.scheduler.address) if client.scheduler else "the cluster"
    if client.asynchronous:
        raise StudyError("scheduler: this Client is asynchronous; give one that waits, or the address")
    found = Cluster(client, told, say)
    _check(found)
    yield found


def _check(cluster: Cluster) -> None:
    """Raise StudyError where a worker that is there has another version than this process, or none."""
    versions = cluster.client.run(version, on_error="return")
    faults = []
    for worker, told in versions.items():
        if isinstance(told, Exception):  # of the class Exception alone where it cannot be pickled there
            faults.append(f"{worker}: this worker cannot import symdyn ({told}); install {version()} where it runs")
        elif told != version():
            faults.append(f"{worker}: this worker has symdyn {told}, and here is {version()}; install one of both")
    if faults:
        raise StudyError(sorted(faults))


@contextmanager
def at_address(address: str, say: Say) -> Iterator[Cluster]:
    """Yield the workers of a scheduler somewhere.

    Raises:
        StudyError: no scheduler answers there, or a worker has not what this process has.
    """
    with _quiet(), warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError, RuntimeError) as fault:
            reason = str(fault).splitlines()[0] if str(fault) else type(fault).__name__
            raise StudyError(
                f"scheduler: nothing answers at {address} ({reason}); begin one by `dask scheduler` there and workers "
                f"by `dask worker {address}`, or give threads or processes"
            ) from fault
    if any(issubclass(one.category, distributed.versions.VersionMismatchWarning) for one in heard):
        say(f"{address}: versions of packages differ there (`Client.get_versions(check=True)` lists them)")
    with client, of_client(client, say) as found:
        yield found


@contextmanager
def on_this_machine(processes: bool, workers: int | None, say: Say) -> Iterator[Cluster]:
    """Yield workers that are begun now, and ended afterwards; Ctrl-C waits until they are.

    Raises:
        StudyError: this is a worker process that reads the user's file again.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):  # as multiprocessing itself finds out
        raise StudyError(
            'scheduler: processes read the file that begins them; put what it does under `if __name__ == "__main__":`'
        )
    from dask.system import CPU_COUNT

    count = workers or CPU_COUNT
    kinds = {"n_workers": count, "threads_per_worker": 1, "preload": __name__}
    threads = {"n_workers": 1, "threads_per_worker": count}
    unseen = {"distributed.worker.profile.enabled": False}  # else every block is looked at each 10 ms
    with dask.config.set(unseen), _closed_in_peace() as begun:
        with interrupts_wait(lambda: say("workers are being begun; it ends when they are there")), kept_from_children():
            cluster = begun.enter_context(
                distributed.LocalCluster(
                    processes=processes,
                    dashboard_address="127.0.0.1:0",  # with None, Dask warns where another cluster has its usual port
                    silence_logs=logging.CRITICAL,
                    **(kinds if processes else threads),
                )
            )
            client = begun.enter_context(distributed.Client(cluster, set_as_default=False))
        yield Cluster(client, f"{count} {'processes' if processes else 'threads'} of this machine", say)


@contextmanager
def _closed_in_peace() -> Iterator[ExitStack]:
    """Yield what is closed in the end, while Ctrl-C waits."""
    begun = ExitStack()
    try:
        yield begun
    finally:
        with interrupts_wait():
            begun.close()


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep a library's log, with its tracebacks, from the user's terminal while it connects."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(before)


@contextmanager
def kept_from_children() -> Iterator[None]:
    """Keep SIGINT from the threads and processes that are begun in the block; a terminal sends it to all of them."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # which lets a thread hear SIGINT again when it begins its process
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C, which a terminal sends to all processes, to the one that gives out blocks.

    A worker process that we begin calls it first; workers of an address are as their owner has them.
    """
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
