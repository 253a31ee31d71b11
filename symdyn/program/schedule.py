"""The order of lines in which few values are alive at a time, so that most of them stay in registers.

A value is alive from the line that makes it (an argument: from the line that first reads it) to the last line that
reads it. Of the lines whose values are there, the next is always one that leaves the fewest alive; among equals the
first in the given order. That is greedy list scheduling by register pressure; a line is looked at again only when one
of its values is read for the first time or has one reader left, so the time is nearly linear.

Reference: Goodman and Hsu, Code scheduling and register allocation in large basic blocks (ICS 1988).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Sequence
from heapq import heapify, heappop, heappush

Line = tuple[Hashable | None, Sequence[Hashable]]


def schedule(lines: Sequence[Line]) -> list[int]:
    """Return the places of `lines` in an order of short lives.

    Args:
        lines: the value that each makes, None for one that writes a result, and the different values that it reads;
            what no line makes is an argument.

    Example:
        >>> schedule([("a", ["x"]), ("b", ["y"]), ("c", ["z"]), (None, ["a", "x"]), (None, ["b", "y"])])
        [2, 0, 3, 1, 4]
    """
    makers = {made for made, _ in lines}
    readers: dict[Hashable | None, list[int]] = defaultdict(list)
    for place, (_, read) in enumerate(lines):
        for value in read:
            readers[value].append(place)
    left = {value: len(places) for value, places in readers.items()}
    weights = {value: int(count > 1) for value, count in left.items()}  # values more alive after a line has read it
    prices = [int(made in left) + sum([weights[value] for value in read]) for made, read in lines]
    missing = [sum([value in makers for value in read]) for _, read in lines]
    order: list[int] = []
    done = [False] * len(lines)
    ready = [(prices[place], place) for place, number in enumerate(missing) if not number]
    heapify(ready)

    def weigh(value: Hashable | None, weight: int) -> None:
        """Change what it costs to read a value that is alive now."""
        change, weights[value] = weight - weights[value], weight
        for reader in readers[value]:
            prices[reader] += change
            changed[reader] = None

    while ready:
        cost, place = heappop(ready)
        if done[place] or prices[place] != cost:
            continue  # it was pushed again when its price changed
        done[place] = True
        order.append(place)
        made, read = lines[place]
        changed: dict[int, None] = {}
        for value in read:
            left[value] -= 1
            weight = -int(left[value] == 1)
            if left[value] and weights[value] != weight:
                weigh(value, weight)
        if made in left:
            weigh(made, -int(left[made] == 1))
            for reader in readers[made]:
                missing[reader] -= 1
        for reader in changed:
            if not missing[reader] and not done[reader]:
                heappush(ready, (prices[reader], reader))
    return order
