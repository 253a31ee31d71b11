"""Rows of a batch on several threads of Python's own: the C code needs no thread library.

A call through ctypes lets go of the interpreter's lock, so the parts run side by side. Threads live for one call: what
is forked in between has nothing to inherit. The caller works too, and another thread is started only for so much work
that it pays, which is told by states times what one of them costs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from math import prod
from typing import Any

from symdyn.dynamics import Function
from symdyn.dynamics.outputs import Counts
from symdyn.program import shared

WORTH = 12_500_000
"""Price of what a thread must have to be worth starting: 180 µs on the fastest core that was measured, so that a call
may cost as much again on two threads and is no slower than on one (`benchmarks/two_threads.py`)."""

NUMBER = 10
"""Price of a number that is read or written, in multiplications, as operations are priced."""

GRAIN = 64
"""Parts start at multiples of so many states, as blocks do: the result does not depend on the number of threads."""


def price(function: Function, itemsize: int = 8) -> float:
    """Return what one state of a function costs: its operations, and the numbers of its own, of `itemsize` bytes each.

    Vectors hold twice as many numbers of half the size. The two parts of a double-double are priced as one number: what
    takes longer than it is priced at is only put on threads later than it might be.
    """
    common = shared([one.name for one in function.arguments])
    own = [prod(one.shape) for one in function.arguments if one.name != common]
    numbers = sum(own) + prod(function.shape)
    return (Counts.of(function).cost + NUMBER * numbers) * itemsize / 8


def split(states: int, threads: int, price: float) -> list[tuple[int, int]]:
    """Return (first, past the last) state of each part; one part where more are not worth their threads.

    Args:
        states: how many there are.
        threads: at most so many parts.
        price: of one state, see `price`.

    Example:
        >>> split(30000, 2, price=1000)
        [(0, 15040), (15040, 30000)]
        >>> split(30000, 2, price=100)
        [(0, 30000)]
    """
    number = max(1, min(threads, int(states * price / WORTH)))
    grain = max(1, -(-states // (number * GRAIN))) * GRAIN
    return [(first, min(first + grain, states)) for first in range(0, states, grain)] or [(0, 0)]


def run_rows(
    call: Callable[..., Any],
    places: Sequence[int],
    strides: Sequence[int],
    parts: Sequence[tuple[int, int]],
    held: object = None,
) -> None:
    """Call an entry for rows on every part of the states, each on a thread of its own, the first on the caller's.

    Where no thread can be started, as when Python ends, the caller does what is left.

    Args:
        call: takes a number of states, then addresses.
        places: address of each array's first state.
        strides: bytes from one state to the next; 0 for params, which all states share.
        parts: (first, past the last) state of each.
        held: the arrays, which stay until all threads are done, also those that a second Ctrl-C does not wait for.
    """

    def work(part: tuple[int, int], _held: object = held) -> None:
        first, last = part
        call(last - first, *(place + first * stride for place, stride in zip(places, strides, strict=True)))

    if len(parts) == 1:
        work(parts[0])
        return
    begun: list[Future[None]] = []
    with ThreadPoolExecutor(len(parts) - 1) as pool:
        with suppress(RuntimeError):
            for part in parts[1:]:
                begun.append(pool.submit(work, part))
        for part in (parts[0], *parts[1 + len(begun) :]):
            work(part)
        for one in begun:
            one.result()  # raises what it has raised
