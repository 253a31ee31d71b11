"""Ctrl-C while blocks are under way: the first one says that no more shall begin, the second one ends it all."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def heard_ctrl_c() -> Iterator[Callable[[], bool]]:
    """Yield what tells whether there was a Ctrl-C; the next one is a KeyboardInterrupt again.

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
