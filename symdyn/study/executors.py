"""What computes the blocks of a study: this process, or workers of Dask, a row of `EXECUTORS` each.

A block is a function of an importable module, called with a job and a number; it gives the same bytes wherever it runs.
So an executor may lose a worker and do its blocks again, and nobody can tell. What comes back is handed to the caller
one block at a time, each once, in the order in which blocks end; who writes files is the caller.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from symdyn.errors import StudyError
from symdyn.extras import install

Block = Callable[[Any, int], Any]
"""A function of a module, (job, number of a block) -> what was found, which can be pickled."""

Say = Callable[[str], None]
"""Takes a line for the user."""


class Executor(Protocol):
    """Something that computes blocks."""

    @property
    def workers(self) -> int:
        """How many blocks it computes at the same time."""

    @property
    def told(self) -> str:
        """Where that is, for messages."""

    def results(self, block: Block, job: Any, numbers: Iterable[int]) -> Iterator[tuple[int, Any]]:
        """Yield number and result of every block, each once, as they end; no more than a few are ever held.

        After Ctrl-C no block is begun any more, those that are under way are still yielded, and then it raises. A
        second Ctrl-C does not wait for them.

        Raises:
            KeyboardInterrupt: after Ctrl-C.
            SymdynError: what a block raised; a StudyError where workers or a scheduler are at fault.
        """


@dataclass(frozen=True)
class Here:
    """This process, one block after the other."""

    workers: int = 1
    told: str = "this process"

    def results(self, block: Block, job: Any, numbers: Iterable[int]) -> Iterator[tuple[int, Any]]:
        """Yield number and result of every block, in their order."""
        with heard_ctrl_c() as stopped:
            for number in numbers:
                yield number, block(job, number)
                if stopped():
                    raise KeyboardInterrupt


@contextmanager
def heard_ctrl_c() -> Iterator[Callable[[], bool]]:
    """Yield what tells whether there was a Ctrl-C; the next one is a KeyboardInterrupt again.

    So what is being written is written to its end. Only the main thread hears signals; a handler other than Python's
    own is its owner's business, and stays.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield lambda: False
        return
    heard: list[int] = []

    def hear(number: int, _: Any) -> None:
        heard.append(number)
        signal.signal(signal.SIGINT, signal.default_int_handler)

    signal.signal(signal.SIGINT, hear)
    try:
        yield lambda: bool(heard)
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


if TYPE_CHECKING:
    from distributed import Client

Opener = Callable[[int | None, Say], AbstractContextManager[Executor]]


@contextmanager
def _here(workers: int | None, say: Say) -> Iterator[Executor]:
    yield Here()


def _threads(workers: int | None, say: Say) -> AbstractContextManager[Executor]:
    from symdyn.study.cluster import on_this_machine

    return on_this_machine(False, workers, say)


def _processes(workers: int | None, say: Say) -> AbstractContextManager[Executor]:
    from symdyn.study.cluster import on_this_machine

    return on_this_machine(True, workers, say)


EXECUTORS: Mapping[str, Opener] = {"here": _here, "threads": _threads, "processes": _processes}
"""By name; whatever is none of these names is the address of a scheduler."""


def executor(
    where: str | Client = "here", workers: int | None = None, say: Say = lambda line: None
) -> AbstractContextManager[Executor]:
    """Return what computes blocks, for a `with` statement, which ends whatever it began.

    >>> from operator import mul
    >>> with executor() as found:
    ...     sorted(found.results(mul, 10, range(3)))
    [(0, 0), (1, 10), (2, 20)]

    Args:
        where: a key of `EXECUTORS`, the address of a Dask scheduler, such as "tcp://10.0.0.1:8786", or a Client, which
            stays open.
        workers: how many threads or processes; None takes one a core. A scheduler has the workers that it has.
        say: takes a line for the user.

    Raises:
        StudyError: no such place, Dask is not installed; on entering, no scheduler there, workers that do not fit.
    """
    if workers is not None and workers < 1:
        raise StudyError(f"workers: {workers} is none; give 1 or more")
    try:
        if isinstance(where, str) and where in EXECUTORS:
            return EXECUTORS[where](workers, say)
        if isinstance(where, str) and "://" not in where:
            known = ", ".join(EXECUTORS)
            raise StudyError(
                f'scheduler: {where!r} is not known; give {known}, or an address such as "tcp://10.0.0.1:8786"'
            )
        if workers is not None:
            raise StudyError("workers: a scheduler has the workers that it has; leave their number out")
        from symdyn.study.cluster import at_address, of_client

        return at_address(where, say) if isinstance(where, str) else of_client(where, say)
    except ModuleNotFoundError as fault:
        raise StudyError(f"scheduler: {fault.name} is not installed; `{install('sweep')}` does that") from fault
