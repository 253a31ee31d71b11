"""The order of lines in which few values are alive at a time, so that most of them stay in registers.

A value is alive from the line that makes it (an argument: from the line that first reads it) to the last line that
reads it. Of the lines whose values are there, the next is always one that leaves the fewest alive; among equals the
first in the given order. That is greedy list scheduling by register pressure; a line is looked at again only when one
of its values is read for the first time or has one reader left, so the time is nearly linear.

Reference: Goodman and Hsu, Code scheduling and register allocation in large basic blocks (ICS 1988).
"""

from __future__ import annotations

from collections import Counter, defaultdict
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
    left = Counter(value for _, read in lines for value in read)
    readers: dict[Hashable, list[int]] = defaultdict(list)
    for place, (_, read) in enumerate(lines):
        for value in read:
            readers[value].append(place)
    missing = [sum(value in makers for value in read) for _, read in lines]
    alive: set[Hashable] = set()
    order: list[int] = []
    done = [False] * len(lines)

    def weight(value: Hashable) -> int:
        """Return how many more values are alive after a line has read this one."""
        return int(left[value] > 1) - int(value in alive)

    def price(place: int) -> int:
        made, read = lines[place]
        return int(left[made] > 0) + sum(map(weight, read))

    prices: dict[int, int] = {place: price(place) for place, number in enumerate(missing) if not number}
    ready = [(cost, place) for place, cost in prices.items()]
    heapify(ready)
    while ready:
        cost, place = heappop(ready)
        if prices.get(place) != cost:
            continue  # it was pushed again when its price changed, or is done
        del prices[place]
        done[place] = True
        order.append(place)
        made, read = lines[place]
        changed: dict[int, None] = {}
        for value in read:
            before = weight(value)
            left[value] -= 1
            (alive.add if left[value] else alive.discard)(value)
            if weight(value) != before:
                changed.update(dict.fromkeys(readers[value]))
        if left[made]:
            alive.add(made)
            for reader in readers[made]:
                missing[reader] -= 1
            changed.update(dict.fromkeys(readers[made]))
        for reader in changed:
            if not missing[reader] and not done[reader]:
                prices[reader] = price(reader)
                heappush(ready, (prices[reader], reader))
    return order
