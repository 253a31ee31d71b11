"""Children that a test forks."""

from __future__ import annotations

import os
import signal
import time


def status_of(child: int) -> int:
    """Return how a child ended; one that does not is killed."""
    patience = time.monotonic() + 30
    while not (ended := os.waitpid(child, os.WNOHANG))[0]:
        if time.monotonic() > patience:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.01)
    return os.waitstatus_to_exitcode(ended[1])
