"""Where the blocks of a study are computed, a row of `EXECUTORS` each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import TYPE_CHECKING

from symdyn.errors import StudyError
from symdyn.extras import install
from symdyn.study.executor import Executor, Here, Say

if TYPE_CHECKING:
    from distributed import Client

Opener = Callable[[int | None, Say], AbstractContextManager[Executor]]


def _local(processes: bool, workers: int | None, say: Say) -> AbstractContextManager[Executor]:
    from symdyn.study.cluster import on_this_machine

    return on_this_machine(processes, workers, say)


EXECUTORS: Mapping[str, Opener] = {
    "here": lambda workers, say: nullcontext(Here()),
    "threads": partial(_local, False),
    "processes": partial(_local, True),
}
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
