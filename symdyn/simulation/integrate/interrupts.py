"""Ctrl-C while a library of compiled code runs Python: it would end as an error of the library, or in nobody's ears."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_wait() -> Iterator[None]:
    """Let SIGINT wait until the block has ended; then it is a KeyboardInterrupt, as it is elsewhere.

    Only the main thread hears signals; a handler other than Python's own is its owner's business, and stays.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    heard: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if heard:
            raise KeyboardInterrupt
