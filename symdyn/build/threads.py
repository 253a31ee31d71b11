"""Many states on several threads: rows are split among Python's own threads, and the C code needs no thread library.

A call through ctypes lets go of the interpreter's lock, so the parts run side by side. Threads live for one call: what
is forked in between has nothing to inherit, and starting one costs far less than the states it is worth starting for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import Thread
from typing import Any

WORTH = 8192
"""States that a thread must have to be worth starting."""

GRAIN = 64
"""Parts start at multiples of so many states, as blocks do: the result does not depend on the number of threads."""


def run_rows(
    call: Callable[..., Any], places: Sequence[int], strides: Sequence[int], count: int, threads: int = 1
) -> None:
    """Call an entry for rows on `count` states, on several threads when there are enough states.

    Args:
        call: takes a number of states, then addresses.
        places: address of each array's first state.
        strides: bytes from one state to the next; 0 for params, which all states share.
        count: number of states.
        threads: at most so many; 1 for none but the caller's.
    """
    parts = split(count, threads)
    if len(parts) == 1:
        call(count, *places)
        return

    faults: list[BaseException] = []

    def work(first: int, last: int) -> None:
        try:
            call(last - first, *(place + first * stride for place, stride in zip(places, strides, strict=True)))
        except BaseException as fault:
            faults.append(fault)

    others = [Thread(target=work, args=part) for part in parts[1:]]
    for one in others:
        one.start()
    work(*parts[0])
    for one in others:
        one.join()
    if faults:
        raise faults[0]


def split(count: int, threads: int) -> list[tuple[int, int]]:
    """Return (first, past the last) state of each part; one part where more are not worth their threads.

    Example:
        >>> split(30000, 2)
        [(0, 15040), (15040, 30000)]
    """
    number = max(1, min(threads, count // WORTH))
    grain = max(1, -(-count // (number * GRAIN))) * GRAIN
    return [(first, min(first + grain, count)) for first in range(0, count, grain)] or [(0, 0)]
