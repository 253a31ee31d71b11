"""Commands that run, and how they are stopped, with all that they have started."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar


class Commands:
    """Commands that are stopped together: threads that wait for them hear no Ctrl-C."""

    def __init__(self) -> None:
        """Start with none."""
        self._lock, self._running, self._stopped = threading.Lock(), set[subprocess.Popen[bytes]](), False

    @contextmanager
    def holding(self, process: subprocess.Popen[bytes]) -> Iterator[None]:
        """Count a process as one of them inside; it is stopped at once if they were."""
        with self._lock:
            self._running.add(process)
            stopped = self._stopped
        if stopped:
            stop_command(process)
        try:
            yield
        finally:
            with self._lock:
                self._running.discard(process)

    def stop(self) -> None:
        """Stop those that run, and those that come later."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                stop_command(process)


COMMANDS = ContextVar("commands", default=Commands())  # noqa: B039  nobody stops these
"""Of which commands those are that run here."""


def stop_command(process: subprocess.Popen[bytes]) -> None:
    """End a process, which has a group of its own, together with its children."""
    with suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:  # Windows, where a tree of processes is ended by a program of its own
            subprocess.run(("taskkill", "/F", "/T", "/PID", str(process.pid)), capture_output=True, check=False)
            process.kill()
