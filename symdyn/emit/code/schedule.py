"""Orders in which few values are alive at a time, so that most of them stay in registers.

A value is alive from the line that makes it (an argument: from the line that first reads it) to the last line that
reads it. From the beginning: of the lines whose values are there, the next is always one that leaves the fewest alive;
among equals the first in the given order. From the end: of the lines whose values have no other reader left, the one
before is always one that needs the fewest more; among equals the last in the given order. Both are greedy list
scheduling by register pressure; a line is looked at again only when its price changes, so the time is nearly linear.
Neither is always better: what is read by many from afar (velocities of all bodies, by all derivatives) is made late
only from the end, and what comes down to few values (inertias, from tip to base) is used up early only from the
beginning.

Reference: Goodman and Hsu, Code scheduling and register allocation in large basic blocks (ICS 1988).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Sequence
from heapq import heapify, heappop, heappush

Line = tuple[Hashable | None, Sequence[Hashable]]


def schedule(lines: Sequence[Line]) -> list[int]:
    """Return the places of `lines` in an order of short lives, found from the beginning.

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


def schedule_backwards(lines: Sequence[Line]) -> list[int]:
    """Return the places of `lines`, as `schedule` takes them, in an order of short lives that is found from the end.

    Example:
        >>> schedule_backwards([("a", ["x"]), ("b", ["y"]), ("c", ["z"]), (None, ["a", "x"]), (None, ["b", "y"])])
        [0, 3, 1, 4, 2]
    """
    makers = {made: place for place, (made, _) in enumerate(lines) if made is not None}
    readers: dict[Hashable, list[int]] = defaultdict(list)
    for place, (_, read) in enumerate(lines):
        for value in read:
            readers[value].append(place)
    left = {value: len(places) for value, places in readers.items()}
    weights = {value: int(value in makers or count > 1) for value, count in left.items()}  # what reading it costs
    missing = [left.get(made, 0) if made is not None else 0 for made, _ in lines]
    prices = [sum([weights[value] for value in read]) for _, read in lines]
    done = [False] * len(lines)
    ready = [(prices[place], -place) for place, number in enumerate(missing) if not number]
    heapify(ready)
    order: list[int] = []
    while ready:
        price, turned = heappop(ready)
        place = -turned
        if done[place] or prices[place] != price:
            continue  # it was pushed again when its price changed
        done[place] = True
        order.append(place)
        for value in lines[place][1]:
            left[value] -= 1
            maker = makers.get(value)
            weight = -int(maker is None and left[value] == 1)  # an argument is there from the line that is first
            change, weights[value] = weight - weights[value], weight
            for reader in readers[value] if change else ():
                prices[reader] += change
                if not missing[reader] and not done[reader]:
                    heappush(ready, (prices[reader], -reader))
            if maker is not None:
                prices[maker] -= int(left[value] == len(readers[value]) - 1)
                missing[maker] = left[value]
                if not left[value]:
                    heappush(ready, (prices[maker], -maker))
    return order[::-1]


def most_alive(lines: Sequence[Line], order: Sequence[int]) -> int:
    """Return how many values are alive at once, at most, when `lines` run in an order.

    Example:
        >>> most_alive([("a", ["x"]), ("b", ["y"]), (None, ["a", "b"])], [0, 1, 2])
        3
    """
    left: dict[Hashable, int] = defaultdict(int)
    for _, read in lines:
        for value in read:
            left[value] += 1
    alive: set[Hashable] = set()
    most = 0
    for place in order:
        made, read = lines[place]
        alive.update(read)
        most = max(most, len(alive) + (made is not None))
        for value in read:
            left[value] -= 1
            if not left[value]:
                alive.discard(value)
        if made is not None and left[made]:
            alive.add(made)
    return most


def schedule_in_turn(lines: Sequence[Line], groups: Sequence[Sequence[int]]) -> list[int]:
    """Return the places of `lines`, as `schedule` takes them, in an order that finishes some results before others.

    Lines that a group of results needs and none before it did come next, in the best of three orders: the given one
    and those of `schedule` and `schedule_backwards`.

    Args:
        lines: as `schedule` takes them.
        groups: places of all lines that write results, those of one group together, the first one first.

    Example:
        >>> lines = [("a", ["x"]), ("b", ["y"]), (None, ["a"]), (None, ["a", "b"])]
        >>> schedule_in_turn(lines, [[2], [3]]), schedule_in_turn(lines, [[3], [2]])
        ([0, 2, 1, 3], [0, 1, 3, 2])
    """
    makers = {made: place for place, (made, _) in enumerate(lines) if made is not None}
    done: set[int] = set()
    found: list[int] = []
    for group in groups:
        needed: set[int] = set()
        stack = list(group)
        while stack:
            place = stack.pop()
            if place not in needed and place not in done:
                needed.add(place)
                stack += [makers[value] for value in lines[place][1] if value in makers]
        places = sorted(needed)
        some = [lines[place] for place in places]
        orders = (range(len(some)), schedule(some), schedule_backwards(some))
        found += [places[number] for number in min(orders, key=lambda order: most_alive(some, order))]
        done |= needed
    return found
