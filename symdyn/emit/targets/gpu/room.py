"""In which order a kernel computes, and what waits in shared memory so that registers are enough.

A thread has 255 registers of 32 bits, and a block 48 KiB of shared memory on every card of CUDA; what a compiler finds
no register for goes to the stack in the memory of the device. Blocks of 128 threads with 48 KiB take no more of a
processor's shared memory than their registers leave to others; in smaller blocks more can wait of a thread.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

from symdyn.emit.code.real import Real
from symdyn.graph import Op
from symdyn.program.schedule import most_alive, schedule, schedule_backwards, schedule_in_turn
from symdyn.program.waiting import Line, Plan, plan

BLOCKS = (128, 64, 32)
"""Threads of a block that registers are shared out for, the first one that leaves enough memory: with 128 each may have
all that the hardware has for one thread."""

SHARED = 48 * 1024
"""Bytes of shared memory that a block may have on every card without asking."""

REGISTERS = {"double": 100, "float": 150}
"""Values that are held at once by our count, of 127 and 255 that would fit: nvcc needs the others on the way."""

MANY = 100
"""Results from which on a compiler would hold the addresses of columns, in chains from one to the next."""

SPARE = {Op.DIV: 50, Op.SQRT: 50, Op.SIN: 40, Op.COS: 40, Op.EXP: 40, Op.LOG: 40, Op.TANH: 40, Op.ATAN2: 40}
"""Registers that must be left to an operation that is a call for some numbers."""

SIZES = {"double": 8, "float": 4}
"""Bytes of a number."""

WORD = 4
"""Bytes of a register."""


@dataclass(frozen=True)
class Room:
    """How a kernel runs: its lines and what waits, in places of which each thread of a block has its own."""

    plan: Plan
    block: int


def room(lines: Sequence[Line], groups: Sequence[Sequence[int]], real: Real) -> Room:
    """Return the order in which the fewest values wait, and among those the fewest are alive at once.

    Args:
        lines: in the order of the derivation; those that make nothing write results; `spare` in registers of 32 bits.
        groups: places of the lines that write results, by joint, the last one first.
        real: the type.
    """
    merged = {value: line.makes[0] for line in lines for value in line.makes}
    some = [
        (line.makes[0] if line.makes else None, list(dict.fromkeys(merged.get(value, value) for value in line.reads)))
        for line in lines
    ]
    orders = [list(range(len(some))), schedule(some), schedule_backwards(some)]
    alive = [most_alive(some, order) for order in orders]
    registers, size = REGISTERS[real.name], SIZES[real.name]
    most = SHARED // size
    lines = [replace(line, spare=line.spare * WORD // size) for line in lines]
    if min(alive) <= registers:
        return Room(plan(lines, orders[alive.index(min(alive))], sys.maxsize), BLOCKS[0])
    turn = schedule_in_turn(some, groups)
    orders += [turn, [turn[number] for number in schedule([some[number] for number in turn])]]
    orders = [_sines_first(lines, order) for order in orders]
    plans = [plan(lines, order, registers) for order in orders]
    best = min(range(len(orders)), key=lambda number: (plans[number].places, len(plans[number].moves)))
    found = plans[best]
    while found.places * BLOCKS[-1] > most:  # what is too much even so, the compiler has to put somewhere
        registers += found.places - most // BLOCKS[-1]
        found = plan(lines, orders[best], registers)
    block = next(threads for threads in BLOCKS if found.places * threads <= most)
    return Room(found, block)


def _sines_first(lines: Sequence[Line], order: Sequence[int]) -> list[int]:
    """Return an order in which what is hard to compute and reads arguments alone comes first, while little is held.

    Sines of large angles are calls, around which a compiler puts on the stack what is held.
    """
    made = {value for line in lines for value in line.makes}
    first = [number for number in order if lines[number].spare and made.isdisjoint(lines[number].reads)]
    early = set(first)
    return [*first, *(number for number in order if number not in early)]
