"""Commands that run, and how they are stopped, with all that they have started."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext, suppress
from contextvars import ContextVar


class Stopped(BaseException):
    """A command was stopped because nobody waits for it any longer; it has not failed."""


class Commands:
    """Commands that are stopped together: threads that wait for them hear no Ctrl-C."""

    def __init__(self, within: Commands | None = None) -> None:
        """Start with none; they are stopped with those that they belong to, too."""
        self._lock, self._running, self._stopped = threading.Lock(), set[subprocess.Popen[bytes]](), False
        self._within = within

    @contextmanager
    def holding(self, process: subprocess.Popen[bytes]) -> Iterator[None]:
        """Count a process as one of them inside; it is stopped at once if they were.

        Raises:
            Stopped: it was stopped in the meantime.
        """
        with self._within.holding(process) if self._within else nullcontext():
            yield from self._holding(process)

    def _holding(self, process: subprocess.Popen[bytes]) -> Iterator[None]:
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
                stopped = self._stopped
        if stopped:
            raise Stopped

    def threads(self, most: int | None = None) -> ThreadPoolExecutor:
        """Return threads, at most so many, whose commands are among them."""
        return ThreadPoolExecutor(most, initializer=COMMANDS.set, initargs=(self,))

    def stop(self) -> None:
        """Stop those that run, and those that come later."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                stop_command(process)


COMMANDS = ContextVar("commands", default=Commands())  # noqa: B039  nobody stops these
"""Of which commands those are that run here."""


@contextmanager
def threads() -> Iterator[ThreadPoolExecutor]:
    """Lend threads whose commands are stopped where a fault or Ctrl-C leaves the block, or the starter is stopped."""
    commands = Commands(COMMANDS.get())
    with commands.threads() as pool:
        try:
            yield pool
        except BaseException:
            commands.stop()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def waiting(process: subprocess.Popen[bytes]) -> Iterator[None]:
    """Wait inside for a process with a group of its own, which hears no Ctrl-C: it ends where nobody waits any longer.

    Raises:
        Stopped: it was stopped in the meantime.
    """
    try:
        with COMMANDS.get().holding(process):
            yield
    except Exception:
        raise
    except BaseException:
        stop_command(process)
        raise


def stop_command(process: subprocess.Popen[bytes]) -> None:
    """End a process, which has a group of its own, together with its children."""
    with suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:  # Windows, where a tree of processes is ended by a program of its own
            subprocess.run(("taskkill", "/F", "/T", "/PID", str(process.pid)), capture_output=True, check=False)
            process.kill()
