"""In which order a kernel computes, and what waits in shared memory so that registers are enough.

A thread has 255 registers of 32 bits, and a block 48 KiB of shared memory on every card of CUDA; what a compiler finds
no register for goes to the stack in the memory of the device. Blocks of 128 threads with 48 KiB take no more of a
processor's shared memory than their registers leave to others; in smaller blocks more can wait of a thread.

A function with many results may be computed in shares, each with all that it needs. Entries of a column of a result,
such as derivatives along one direction, stay together. A share begins with the column that needs most, and takes the
one that has most in common with it, counted in operations, as long as there is room: directions of one leg come
together, which is computed for them once.

A value is made once, so what was kept once is still right when it is fetched again. Whenever there is no register
left, the value goes whose next reader is farthest away; that is the fewest fetches there can be. Its place is free
again when it came back for the last time. What waits is decided here and not by a compiler, which knows no place but
its stack.

Reference: Belady, A study of replacement algorithms for a virtual-storage computer (IBM Systems Journal 5, 1966).
"""

from __future__ import annotations

import sys
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Container, Hashable, Iterator, Sequence
from functools import cache
from heapq import heappop, heappush
from itertools import count

from symdyn.emit.code.schedule import most_alive, schedule, schedule_backwards, schedule_in_turn
from symdyn.emit.code.spelling import Real
from symdyn.frozen import dataclass, replace
from symdyn.graph import Op


@dataclass(frozen=True)
class Line:
    """One line."""

    makes: tuple[Hashable, ...]  # the values that it makes, none where it writes a result
    reads: tuple[Hashable, ...]  # the different values that it reads; what no line makes is an argument
    spare: int = 0  # registers that it needs on the way, as a sine does


@dataclass(frozen=True)
class Move:
    """What happens next."""

    line: int = -1  # which line runs; -1 where a value moves
    value: Hashable = None  # what moves
    place: int = -1  # where it waits; -1 for an argument that is read for the first time
    kept: bool = False  # whether it goes there; else it comes from there


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


def needed_by(lines: Sequence[Line], columns: Sequence[Sequence[int]]) -> list[int]:
    """Return for every line which columns need it, bit by bit; each has the places of the lines that write it."""
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


BLOCKS = (128, 64, 32)
"""Threads of a block that registers are shared out for, the first one that leaves enough memory: with 128 each may have
all that the hardware has for one thread."""

SHARED = 48 * 1024
"""Bytes of shared memory that a block may have on every card without asking."""

REGISTERS = {"double": 92, "float": 130}
"""Values that are held at once by our count, of 127 and 255 that would fit: nvcc needs the others on the way."""

MANY = 100
"""Results from which on a compiler would hold the addresses of columns, in chains from one to the next."""

SPARE = {Op.DIV: 80, Op.SQRT: 80, Op.SIN: 40, Op.COS: 40, Op.EXP: 40, Op.LOG: 40, Op.TANH: 40, Op.ATAN2: 40, Op.POW: 80}
"""Registers that must be left to an operation that is a call for some numbers."""

CALLS = ("double",)
"""Types whose sines of large angles are calls, around which nvcc puts on the stack what is held: those that read
arguments alone come first, while little is. Sines of floats are no calls, and wait in no register where they stand."""

SIZES, WORD = {"double": 8, "float": 4}, 4
"""Bytes of a number, and of a register."""

TWICE = 2
"""Operations that may be computed twice to save a byte that would be spilled: cards that are made for doubles compute
2 to 5 while they move a byte to their memory, and more of floats."""


@dataclass(frozen=True)
class Budget:
    """How a kernel runs.

    Attributes:
        plans: of each part, which lines run and what waits, in places of which each thread of a block has its own.
        block: threads of a block.
        operations: of all parts.
        once: of these, how many there would be if nothing were computed twice.
    """

    plans: tuple[Plan, ...]
    block: int
    operations: int
    once: int

    @property
    def places(self) -> int:
        """Of one thread, as many as the part needs that needs most."""
        return max(plan.places for plan in self.plans)


@dataclass(frozen=True)
class Task:
    """What a kernel computes.

    Attributes:
        lines: in the order of the derivation; those that make nothing write results; `spare` in registers of 32 bits.
        weights: operations of each line.
        columns: places of the lines that write results, by column of the result.
        joints: after how many columns the same joint comes again.
        real: the type.
    """

    lines: Sequence[Line]
    weights: Sequence[int]
    columns: Sequence[Sequence[int]]
    joints: int
    real: Real

    @property
    def most(self) -> int:
        """Places in the shared memory of a block."""
        return SHARED // SIZES[self.real.name]


def budget(task: Task) -> Budget:
    """Return how a kernel runs: whole, or in parts where all that it holds at once has no room.

    What has no room even so, or is cheaper to spill than to compute twice, the compiler has to put somewhere.
    """
    registers = REGISTERS[task.real.name]
    whole = _plan(task, range(len(task.lines)), registers)
    if whole.places * BLOCKS[-1] <= task.most:
        return _room([whole], task)

    @cache
    def has_room(numbers: tuple[int, ...]) -> bool:
        return any(one.places * BLOCKS[-1] <= task.most for one in _plans(task, numbers, registers))

    found = shares(task.lines, task.weights, task.columns, has_room)
    parts = [_plan(task, numbers, registers) for numbers in found]
    again = _room(parts, task).operations - sum(task.weights)
    spared = _spilled(whole, task) - sum(_spilled(part, task) for part in parts)
    chosen = parts if again <= TWICE * spared else [whole]
    return _room([_squeezed(one, task, registers) for one in chosen], task)


def _spilled(result: Plan, task: Task) -> int:
    """Return how many bytes a plan moves to and from places for which a block has no room."""
    return sum(move.place * BLOCKS[-1] >= task.most for move in result.moves) * SIZES[task.real.name]


def _squeezed(result: Plan, task: Task, registers: int) -> Plan:
    """Return a plan that has room; what is too much the compiler has to put somewhere."""
    order = [move.line for move in result.moves if move.line >= 0]
    while result.places * BLOCKS[-1] > task.most:
        registers += result.places - task.most // BLOCKS[-1]
        result = plan(_scaled(task), order, registers)
    return result


def _room(plans: Sequence[Plan], task: Task) -> Budget:
    """Return plans with the largest block that has places for all of them."""
    places = max(plan.places for plan in plans)
    block = next((threads for threads in BLOCKS if places * threads <= task.most), BLOCKS[-1])
    operations = sum(task.weights[move.line] for plan in plans for move in plan.moves if move.line >= 0)
    return Budget(tuple(plans), block, operations, sum(task.weights))


def _scaled(task: Task) -> list[Line]:
    """Return lines that say in values of the type what they need on the way."""
    return [replace(line, spare=line.spare * WORD // SIZES[task.real.name]) for line in task.lines]


def _plan(task: Task, numbers: Sequence[int], registers: int) -> Plan:
    """Return the order of some lines in which the fewest values wait, and among those the fewest moves are made."""
    return min(_plans(task, numbers, registers), key=lambda one: (one.places, len(one.moves)))


def _plans(task: Task, numbers: Sequence[int], registers: int) -> Iterator[Plan]:
    """Yield plans of some lines: that in which the fewest are alive where no value waits, else one an order."""
    lines = _scaled(task)
    merged = {value: lines[number].makes[0] for number in numbers for value in lines[number].makes}
    some = [
        (
            lines[number].makes[0] if lines[number].makes else None,
            list(dict.fromkeys(merged.get(value, value) for value in lines[number].reads)),
        )
        for number in numbers
    ]
    orders = [list(range(len(some))), schedule(some), schedule_backwards(some)]
    alive = [most_alive(some, order) for order in orders]
    if min(alive) <= registers:
        yield plan(lines, [numbers[place] for place in orders[alive.index(min(alive))]], sys.maxsize)
        return
    # where the lines are that write results, joint by joint, the last one first
    where = {number: place for place, number in enumerate(numbers)}
    groups: list[list[int]] = [[] for _ in range(task.joints)]
    for number, column in enumerate(task.columns):
        groups[number % task.joints] += [where[place] for place in column if place in where]
    turn = schedule_in_turn(some, [sorted(group) for group in reversed(groups)])
    orders += [turn, [turn[place] for place in schedule([some[place] for place in turn])]]

    def late(number: int) -> bool:
        line = lines[number]
        return task.real.name not in CALLS or not line.spare or not merged.keys().isdisjoint(line.reads)

    for order in orders:
        yield plan(lines, sorted((numbers[place] for place in order), key=late), registers)
