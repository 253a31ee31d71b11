"""Children that a test forks."""

from __future__ import annotations

import os
import signal
import time
import traceback
from collections.abc import Callable

from patience import HANG


def forked(work: Callable[[], object]) -> int:
    """Return a child that ends with 0 if what its work returns is true; it never comes back into the test."""
    child = os.fork()
    if child:
        return child
    status = 1
    try:
        status = 0 if work() else 1
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)


def status_of(child: int) -> int:
    """Return how a child ended; one that does not is killed."""
    patience = time.monotonic() + HANG
    while not (ended := os.waitpid(child, os.WNOHANG))[0]:
        if time.monotonic() > patience:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.01)
    return os.waitstatus_to_exitcode(ended[1])
