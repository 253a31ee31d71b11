"""Shares of a function's results that are computed apart, each with all that it needs, so that each has room.

A column of a result, such as derivatives along one direction, is never divided. A share begins with the column that
needs most, and takes the one that has most in common with it, counted in operations, as long as there is room:
directions of one leg come together, which is computed for them once.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from symdyn.program.waiting import Line


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


def shares(needs: Sequence[int], weights: Sequence[int], width: int, has_room: Callable[[int], bool]) -> list[int]:
    """Return shares of the columns, each as bits; [] where a column has no room even by itself.

    Args:
        needs: of every line the columns that need it, as `needed_by` gives them.
        weights: operations of every line.
        width: how many columns there are.
        has_room: tells whether a share can be computed by itself.

    Example:
        >>> shares([0b011, 0b100, 0b001, 0b010, 0b100], [5, 1, 1, 2, 3], 3, lambda share: share.bit_count() < 3)
        [3, 4]
        >>> shares([0b011, 0b100, 0b001, 0b010, 0b100], [5, 1, 1, 2, 3], 3, lambda share: not share & 0b100)
        []
    """
    alike: Counter[int] = Counter()
    for need, weight in zip(needs, weights, strict=True):
        alike[need] += weight
    single = [operations(alike, 1 << column) for column in range(width)]
    left = sorted(range(width), key=lambda column: -single[column])
    found = []
    while left:
        order = _in_common(alike, single, left)
        count = _most(len(order), lambda some, order=order: has_room(bits(order[:some])))  # type: ignore[misc]
        if not count:
            return []
        found.append(bits(order[:count]))
        left = [column for column in left if not found[-1] >> column & 1]
    return found


def operations(alike: Counter[int], share: int) -> int:
    """Return how many operations a share takes, of so many for every set of columns that need the same."""
    return sum(count for need, count in alike.items() if need & share)


def bits(columns: Sequence[int]) -> int:
    """Return columns as bits."""
    return sum(1 << column for column in columns)


def _in_common(alike: Counter[int], single: Sequence[int], columns: Sequence[int]) -> list[int]:
    """Return columns from the first one on, each of those left that has most in common with all before it."""
    order, left = [columns[0]], list(columns[1:])
    while left:
        share = bits(order)
        common = Counter({need: count for need, count in alike.items() if need & share})
        order.append(max(left, key=lambda column: operations(common, 1 << column)))
        left.remove(order[-1])
    return order


def _most(count: int, has_room: Callable[[int], bool]) -> int:
    """Return the largest number up to `count` that has room, if all below it do, by doubling and halving."""
    least, most, middle = 0, count + 1, 1
    while most - least > 1:
        least, most = (middle, most) if has_room(middle) else (least, middle)
        middle = min(2 * least, count) if most > count else (least + most) // 2
    return least
