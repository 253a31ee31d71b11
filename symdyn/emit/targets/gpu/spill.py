"""Which values wait elsewhere while registers are needed by others, when lines run in a given order.

A value is made once, so what was kept once is still right when it is fetched again. Whenever there is no register
left, the value goes whose next reader is farthest away; that is the fewest fetches there can be. Its place is free
again when it came back for the last time. What waits is decided here and not by a compiler, which knows no place but
its stack.

Reference: Belady, A study of replacement algorithms for a virtual-storage computer (IBM Systems Journal 5, 1966).
"""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Container, Hashable, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush
from itertools import count


@dataclass(frozen=True)
class Line:
    """One line.

    Attributes:
        makes: the values that it makes, none where it writes a result.
        reads: the different values that it reads; what no line makes is an argument.
        spare: registers that it needs on the way, as a sine does.
    """

    makes: tuple[Hashable, ...]
    reads: tuple[Hashable, ...]
    spare: int = 0


@dataclass(frozen=True)
class Move:
    """What happens next.

    Attributes:
        line: which line runs; -1 where a value moves.
        value: what moves.
        place: where it waits; -1 for an argument that is read for the first time.
        kept: whether it goes there; else it comes from there.
    """

    line: int = -1
    value: Hashable = None
    place: int = -1
    kept: bool = False


@dataclass(frozen=True)
class Plan:
    """Lines and moves in running order, and how many places there must be."""

    moves: tuple[Move, ...]
    places: int


def plan(lines: Sequence[Line], order: Sequence[int], registers: int) -> Plan:
    """Return how `lines` run in an order, and which values wait meanwhile, so that no more than `registers` are held.

    A line holds what it reads and what it makes, however many registers that takes.

    Example:
        >>> lines = [Line(*one) for one in [("a", "x"), ("b", "y"), ("c", "b"), ("", "c"), ("", "a")]]
        >>> [("keep " if one.kept else "") + one.value for one in plan(lines, range(5), 1).moves if one.line < 0]
        ['x', 'keep a', 'y', 'a']
        >>> plan(lines, range(5), 1).places, plan(lines, range(5), 2).places
        (1, 0)
    """
    moves = _moves(lines, order, registers)
    left = Counter(move.value for move in moves if move.place == WAITED and not move.kept)
    where: dict[Hashable, int] = {}
    free: list[int] = []
    for number, move in enumerate(moves):
        if move.kept:
            where[move.value] = heappop(free) if free else len(where)
        elif move.place == WAITED:
            left[move.value] -= 1
        else:
            continue
        moves[number] = replace(move, place=where[move.value])
        if not left[move.value]:
            heappush(free, where.pop(move.value))
    return Plan(tuple(moves), max((move.place for move in moves), default=-1) + 1)


WAITED = 0
"""A place that is not settled yet."""


def _moves(lines: Sequence[Line], order: Sequence[int], registers: int) -> list[Move]:
    """Return lines and moves in running order; of what waited, no place is said."""
    readers: dict[Hashable, deque[int]] = defaultdict(deque)
    for time, number in enumerate(order):
        for value in lines[number].reads:
            readers[value].append(time)
    held: dict[Hashable, int] = {}
    kept: set[Hashable] = set()
    moves: list[Move] = []
    heap: list[tuple[int, int, Hashable]] = []  # by next reader, the farthest first; what is no longer so is skipped

    def hold(value: Hashable, since: int) -> None:
        held[value] = since
        heappush(heap, (-readers[value][0], since, value))

    def leave(free: int, needed: Container[Hashable]) -> None:
        """Let values wait, but those that are needed, until so many registers are free."""
        passed = []
        while len(held) + free > registers and heap:
            entry = heappop(heap)
            time, since, farthest = entry
            if held.get(farthest) != since or -time != readers[farthest][0]:
                continue
            if farthest in needed:
                passed.append(entry)
                continue
            del held[farthest]
            if farthest not in kept:
                kept.add(farthest)
                moves.append(Move(value=farthest, place=WAITED, kept=True))
        for entry in passed:
            heappush(heap, entry)

    since = count()
    for number in order:
        line = lines[number]
        for value in line.reads:
            if value not in held:
                leave(1, line.reads)
                hold(value, next(since))
                moves.append(Move(value=value, place=WAITED if value in kept else -1))
        leave(line.spare, line.reads)
        moves.append(Move(line=number))
        for value in line.reads:
            readers[value].popleft()
            if readers[value]:
                hold(value, held[value])
            else:
                del held[value]
        for value in line.makes:
            if readers[value]:
                leave(1, line.makes)
                hold(value, next(since))
    return moves
