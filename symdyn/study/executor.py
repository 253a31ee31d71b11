"""What computes the blocks of a study, and the one that does it here.

A block is a function of an importable module, called with a job and a number; it gives the same bytes wherever it runs.
So an executor may lose a worker and do its blocks again, and nobody can tell. What comes back is handed to the caller
one block at a time, each once, in the order in which blocks end; who writes files is the caller.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from symdyn.study.stopping import heard_ctrl_c

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
