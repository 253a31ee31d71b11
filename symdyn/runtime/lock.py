"""A lock that a child forked while another thread held it finds open, for that thread is not in the child."""

from __future__ import annotations

import os
import threading
from weakref import WeakSet


class Lock:
    """A lock that the thread that holds it may take again."""

    def __init__(self) -> None:
        self.free()
        _ALL.add(self)

    def free(self) -> None:
        """Let nobody hold it."""
        self._lock = threading.RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *fault: object) -> None:
        self._lock.release()


_ALL: WeakSet[Lock] = WeakSet()


def _free_all() -> None:
    for one in _ALL:
        one.free()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_free_all)
