"""Shares of a function's results that are computed apart, each with all that it needs, so that each has room.

Entries of a column of a result, such as derivatives along one direction, stay together. A share begins with the column
that needs most, and takes the one that has most in common with it, counted in operations, as long as there is room:
directions of one leg come together, which is computed for them once.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from symdyn.emit.targets.gpu.spill import Line


def needed_by(lines: Sequence[Line], columns: Sequence[Sequence[int]]) -> list[int]:
    """Return for every line which columns need it, bit by bit.

    Args:
        lines: in the order of the derivation.
        columns: places of the lines that write the entries of each.
    """
    makers = {value: place for place, line in enumerate(lines) for value in line.makes}
    found = [0] * len(lines)
    for number, column in enumerate(columns):
        for place in column:
            found[place] |= 1 << number
    for place in reversed(range(len(lines))):
        for value in lines[place].reads:
            if value in makers:
                found[makers[value]] |= found[place]
    return found


def shares(
    lines: Sequence[Line],
    weights: Sequence[int],
    columns: Sequence[Sequence[int]],
    has_room: Callable[[tuple[int, ...]], bool],
) -> list[tuple[int, ...]]:
    """Return which lines each share runs, in the order of the derivation; a column that has no room is one by itself.

    Args:
        lines: in the order of the derivation.
        weights: operations of every line.
        columns: places of the lines that write the entries of each.
        has_room: tells whether some lines can run by themselves.

    Example:
        >>> lines = [Line(("a",), ()), Line(("b",), ()), Line((), ("a",)), Line((), ("a",)), Line((), ("b",))]
        >>> shares(lines, [5, 1, 1, 2, 3], [[2], [3], [4]], lambda some: len(some) < 4)
        [(0, 2, 3), (1, 4)]
        >>> shares(lines, [5, 1, 1, 2, 3], [[2, 3], [4]], lambda some: len(some) < 2)
        [(0, 2, 3), (1, 4)]
    """
    units = [column for column in columns if column]
    needs = needed_by(lines, units)
    alike: Counter[int] = Counter()
    for need, weight in zip(needs, weights, strict=True):
        alike[need] += weight
    left = sorted(range(len(units)), key=lambda column: -operations(alike, 1 << column))
    found = []
    while left:
        order = _in_common(alike, left)
        runs = [lines_of(needs, order[: count + 1]) for count in range(len(order))]
        count = max(_most(runs, has_room), 1)
        found.append(runs[count - 1])
        left = [column for column in left if column not in order[:count]]
    return found


def lines_of(needs: Sequence[int], columns: Sequence[int]) -> tuple[int, ...]:
    """Return the places of the lines that some columns need."""
    share = bits(columns)
    return tuple(place for place, need in enumerate(needs) if need & share)


def operations(alike: Counter[int], share: int) -> int:
    """Return how many operations a share takes, of so many for every set of columns that need the same."""
    return sum(count for need, count in alike.items() if need & share)


def bits(columns: Sequence[int]) -> int:
    """Return columns as bits."""
    return sum(1 << column for column in columns)


def _in_common(alike: Counter[int], columns: Sequence[int]) -> list[int]:
    """Return columns from the first one on, each of those left that has most in common with all before it."""
    order, left = [columns[0]], list(columns[1:])
    while left:
        share = bits(order)
        common = Counter({need: count for need, count in alike.items() if need & share})
        order.append(max(left, key=lambda column: operations(common, 1 << column)))
        left.remove(order[-1])
    return order


def _most(runs: Sequence[tuple[int, ...]], has_room: Callable[[tuple[int, ...]], bool]) -> int:
    """Return how many of `runs` have room, each of which holds those before it, by doubling and halving."""
    least, most, middle = 0, len(runs) + 1, 1
    while most - least > 1:
        least, most = (middle, most) if has_room(runs[middle - 1]) else (least, middle)
        middle = min(2 * least, len(runs)) if most > len(runs) else (least + most) // 2
    return least
