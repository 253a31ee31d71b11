"""In which order a kernel computes, and what waits in shared memory so that registers are enough.

A thread has 255 registers of 32 bits, and a block 48 KiB of shared memory on every card of CUDA; what a compiler finds
no register for goes to the stack in the memory of the device. Blocks of 128 threads with 48 KiB take no more of a
processor's shared memory than their registers leave to others; in smaller blocks more can wait of a thread.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

from symdyn.emit.code.real import Real
from symdyn.emit.code.schedule import most_alive, schedule, schedule_backwards, schedule_in_turn
from symdyn.emit.targets.gpu.parts import shares
from symdyn.emit.targets.gpu.spill import Line, Plan, plan
from symdyn.graph import Op

BLOCKS = (128, 64, 32)
"""Threads of a block that registers are shared out for, the first one that leaves enough memory: with 128 each may have
all that the hardware has for one thread."""

SHARED = 48 * 1024
"""Bytes of shared memory that a block may have on every card without asking."""

REGISTERS = {"double": 92, "float": 130}
"""Values that are held at once by our count, of 127 and 255 that would fit: nvcc needs the others on the way."""

MANY = 100
"""Results from which on a compiler would hold the addresses of columns, in chains from one to the next."""

SPARE = {Op.DIV: 80, Op.SQRT: 80, Op.SIN: 40, Op.COS: 40, Op.EXP: 40, Op.LOG: 40, Op.TANH: 40, Op.ATAN2: 40}
"""Registers that must be left to an operation that is a call for some numbers."""

SIZES = {"double": 8, "float": 4}
"""Bytes of a number."""

WORD = 4
"""Bytes of a register."""


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
    turn = schedule_in_turn(some, _groups(task, numbers))
    orders += [turn, [turn[place] for place in schedule([some[place] for place in turn])]]
    for order in orders:
        yield plan(lines, _sines_first(lines, [numbers[place] for place in order]), registers)


def _groups(task: Task, numbers: Sequence[int]) -> list[list[int]]:
    """Return where among `numbers` the lines are that write results, joint by joint, the last one first."""
    where = {number: place for place, number in enumerate(numbers)}
    groups: list[list[int]] = [[] for _ in range(task.joints)]
    for number, column in enumerate(task.columns):
        groups[number % task.joints] += [where[place] for place in column if place in where]
    return [sorted(group) for group in reversed(groups)]


def _sines_first(lines: Sequence[Line], order: Sequence[int]) -> list[int]:
    """Return an order in which what is hard to compute and reads arguments alone comes first, while little is held.

    Sines of large angles are calls, around which a compiler puts on the stack what is held.
    """
    made = {value for line in lines for value in line.makes}
    first = [number for number in order if lines[number].spare and made.isdisjoint(lines[number].reads)]
    early = set(first)
    return [*first, *(number for number in order if number not in early)]
