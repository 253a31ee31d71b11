"""Measuring many implementations side by side: one sample of each in turn, round after round.

A machine that is busy for a while is then busy for all of them, and what is quoted are medians over rounds and medians
of the ratios inside a round. The order turns by one place each round, so that nobody always follows the same one.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import median, quantiles

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

PAGE, LINE = 4096, 64
"""Bytes of a page of memory and of a line of the cache."""

CLOSE = 1e-10
"""Largest relative difference between implementations of one function that are timed together."""


@dataclass(frozen=True)
class Timed:
    """One implementation of one output of one robot, ready to be called.

    Attributes:
        case: name of the robot.
        output: name of the output.
        peer: who made it, as in tables.
        way: how it is called: "state" (one state a call, in C), "batch" (many states a call), "threads" (the same on
            two threads) or "python" (calls from Python).
        states: states of one sweep.
        sweep: takes a number of sweeps and returns the seconds that they take.
        result: returns the results of the first states, one row each, in our order of coordinates.
        own_clock: whether `sweep`'s own seconds count, because another process or several threads do the work, or
            because it first brings arrays to a new place: copying the results of M of 32 joints takes longer than M.
    """

    case: str
    output: str
    peer: str
    way: str
    states: int
    sweep: Callable[[int], float] = field(repr=False)
    result: Callable[[], Array] = field(repr=False)
    own_clock: bool = False


@dataclass(frozen=True)
class Measured:
    """Times of one implementation, ns a state, one a round."""

    timed: Timed
    samples: tuple[float, ...]

    @property
    def median(self) -> float:
        """The median, ns a state."""
        return median(self.samples)

    @property
    def quartiles(self) -> tuple[float, float]:
        """The lower and the upper quartile, ns a state."""
        if len(self.samples) < 2:
            return self.samples[0], self.samples[0]
        low, _, high = quantiles(self.samples, n=4, method="inclusive")
        return low, high


def moved(array: Array, to: random.Random) -> Array:
    """Return a copy at another place in memory, at any cache line of a page.

    Columns at power-of-two strides fall on the same lines of the first cache, and how many of them do depends on where
    each array begins: a place that is left to the allocator is luck for a whole run. Every sample draws new ones.
    """
    room = np.empty(array.nbytes + 2 * PAGE, dtype=np.uint8)
    start = -room.ctypes.data % PAGE + LINE * to.randrange(PAGE // LINE)
    found = room[start : start + array.nbytes].view(np.float64).reshape(array.shape)
    found[...] = array
    return found


def python_sweep(call: Callable[[], object]) -> Callable[[int], float]:
    """Return a sweep that calls a Python function; the loop's own 20 ns or so are part of it."""

    def sweep(sweeps: int) -> float:
        turns = range(sweeps)
        start = time.thread_time()
        for _ in turns:
            call()
        return time.thread_time() - start

    return sweep


def measure(timed: Sequence[Timed], rounds: int, seconds: float) -> list[Measured]:
    """Return the times of implementations that are compared with each other.

    Args:
        timed: at least one.
        rounds: samples of each.
        seconds: how long one sample should take.
    """
    sweeps = [_sweeps(one, seconds) for one in timed]
    samples: list[list[float]] = [[] for _ in timed]
    for turn in range(rounds):
        for i in (k % len(timed) for k in range(turn, turn + len(timed))):
            took = _seconds(timed[i], sweeps[i])
            samples[i].append(1e9 * took / (sweeps[i] * timed[i].states))
    return [Measured(one, tuple(times)) for one, times in zip(timed, samples, strict=True)]


def _seconds(timed: Timed, sweeps: int) -> float:
    """Return what some sweeps take: processor time, to which others do not add; for threads that of the longer one.

    The address call from Python that is part of it takes a microsecond or two of the milliseconds of a sample.
    """
    start = time.thread_time()
    elapsed = timed.sweep(sweeps)
    return elapsed if timed.own_clock else time.thread_time() - start


def _sweeps(timed: Timed, seconds: float) -> int:
    """Return how many sweeps fill a sample; the first calls, which fill caches, are not measured."""
    sweeps = 1
    while True:
        took = _seconds(timed, sweeps)
        if took >= seconds / 4:
            return max(1, round(sweeps * seconds / took))
        sweeps *= 4 if took <= 0 else max(2, min(64, int(seconds / took)))
