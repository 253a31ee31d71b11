"""Times of calls, measured in turn round after round, so that a machine that is busy for a while is so for all."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median


@dataclass(frozen=True)
class Timed:
    """A call, and how many states it computes."""

    call: Callable[[], object]
    states: int


def nanoseconds(timed: Sequence[Timed], rounds: int, seconds: float) -> list[float]:
    """Return the processor time of every call in ns a state: the median of `rounds` samples of `seconds` each."""
    turns = [_turns(one, seconds) for one in timed]
    samples: list[list[float]] = [[] for _ in timed]
    for _ in range(rounds):
        for one, count, found in zip(timed, turns, samples, strict=True):
            found.append(1e9 * _took(one, count) / (count * one.states))
    return [median(found) for found in samples]


def _took(timed: Timed, turns: int) -> float:
    call, every = timed.call, range(turns)
    start = time.thread_time()
    for _ in every:
        call()
    return time.thread_time() - start


def _turns(timed: Timed, seconds: float) -> int:
    """Return how many calls fill a sample; the first ones, which fill caches, are not measured."""
    turns = 1
    while True:
        took = _took(timed, turns)
        if took >= seconds / 4:
            return max(1, round(turns * seconds / took))
        turns *= 4 if took <= 0 else max(2, min(64, int(seconds / took)))
