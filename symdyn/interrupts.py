"""Ctrl-C where it would break what a library begins or ends, or what is written: it waits until that is over."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def interrupts_wait(report: Callable[[], None] = lambda: None, once: bool = False) -> Iterator[Callable[[], bool]]:
    """Let SIGINT wait until the block has ended; then it is a KeyboardInterrupt, as it is elsewhere.

    Only the main thread hears signals; a handler other than Python's own is its owner's business, and stays. `report`
    is called when the first one is heard. With `once` the block, which asks what is yielded whether there was one, says
    what comes of it, and the next one does not wait.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield lambda: False
        return
    heard: list[int] = []

    def hear(number: int, _: Any) -> None:
        heard.append(number)
        if once:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        if len(heard) == 1:
            report()

    signal.signal(signal.SIGINT, hear)
    try:
        yield lambda: bool(heard)
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if heard and not once:
            raise KeyboardInterrupt
