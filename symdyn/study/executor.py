"""What computes the blocks of a study, the one that does it here, and Ctrl-C while blocks are under way.

A block is a function of an importable module, called with a job and a number; it gives the same bytes wherever it runs.
So an executor may lose a worker and do its blocks again, and nobody can tell. What comes back is handed to the caller
one block at a time, each once, in the order in which blocks end; who writes files is the caller.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

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
    def place(self) -> str:
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
    place: str = "this process"

    def results(self, block: Block, job: Any, numbers: Iterable[int]) -> Iterator[tuple[int, Any]]:
        """Yield number and result of every block, in their order."""
        with heard_ctrl_c() as stopped:
            for number in numbers:
                yield number, block(job, number)
                if stopped():
                    raise KeyboardInterrupt


@contextmanager
def heard_ctrl_c() -> Iterator[Callable[[], bool]]:
    """Yield what tells whether there was a Ctrl-C: then no more shall begin; the next one ends it all.

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
