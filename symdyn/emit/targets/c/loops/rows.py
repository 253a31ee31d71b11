"""The rows of a table of joints as C, and how much room loops over it take: what all loops have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.dynamics import TableLoop
from symdyn.emit.code.operators import Printer
from symdyn.scene import Scene

LINE = 64
"""Bytes of the states side by side: one vector of the widest kind. Two and four ran no faster from 256 joints on."""

STACK = 576 * 1024
"""Bytes of work space that states side by side may take: those of 1,024 joints. More joints halve the states."""

GROUP = 8
"""Sines are taken of a multiple of so many angles."""

TILE = 32
"""Rows of work space of entries of states that lie apart."""

NUMBERS = 9
"""Numbers of a row before those of its body: two of a turn, three of a shift, two of a turn, rise and rotor."""


@dataclass(frozen=True)
class Rows:
    """The tables of a loop.

    Attributes:
        joints, matrices: rows of the tables as C, and of fixed turns that are not about x.
        ground: acceleration of the ground, as C.
        turned: whether a joint stands turned at zero.
        places: how many places there are for what waits for others.
    """

    joints: tuple[str, ...]
    matrices: tuple[str, ...]
    ground: str
    turned: bool
    places: int


@dataclass(frozen=True)
class Room:
    """Work space, in numbers.

    Attributes:
        one: of one state.
        lanes: states side by side; 0 where they would not fit on the stack.
        lockstep: of these, all at once.
    """

    one: int
    lanes: int
    lockstep: int


def rows_of(
    loop: TableLoop, scene: Scene, printer: Printer, kinds: Sequence[int], more: Sequence[Sequence[int]] = ()
) -> Rows:
    """Return the rows of the table of a loop; `kinds` are their kinds by number, `more` what else is told of them."""
    table = loop.table
    literals = map(printer.literal, table.in_order(scene))
    ground = braces([next(literals) for _ in table.ground])
    rows, matrices = [], 0
    places, most = _places([row.parent for row in table.rows])
    for i, (row, (come, go)) in enumerate(zip(table.rows, places, strict=True)):
        whole = (row.parent, come, go, kinds[i], matrices, int(not row.at_zero), *(more[i] if more else ()))
        matrices += len(row.fixed) > 2
        numbers = [next(literals) for _ in range(NUMBERS)]
        rows.append(braces([*map(str, whole), *numbers, braces([next(literals) for _ in range(table.MOMENTS)])]))
    turns = tuple(braces([next(literals) for _ in range(9)]) for _ in range(matrices))
    return Rows(tuple(rows), turns, ground, any(not row.at_zero for row in table.rows), most)


def room(joints: int, width: int, rows: int) -> Room:
    """Return the work space of sines and cosines of all joints and of so many rows; a number takes `width` bytes."""

    def work(lanes: int) -> int:
        return 2 * (-(-joints * lanes // GROUP) * GROUP) + (rows + TILE * (lanes > 1)) * lanes

    lanes = LINE // width
    while lanes and work(lanes) * width > STACK:
        lanes //= 2
    lanes = lanes if lanes > 1 else 0
    return Room(work(1), lanes, work(lanes))


def braces(texts: Sequence[str]) -> str:
    """Return a list of C."""
    return f"{{{', '.join(texts)}}}"


def _places(parents: Sequence[int]) -> tuple[list[tuple[int, int]], int]:
    """Return where each joint finds what its parent left and leaves its own, and how many places there are.

    A place is used again when the last joint that is carried from there has read it. The ground has the first. On the
    way back the same places do for what joints hand to their parents.
    """
    last = {parent: i for i, parent in enumerate(parents, 1)}
    place, free, most = {0: 0}, list[int](), 1
    found = []
    for i, parent in enumerate(parents, 1):
        if not free:
            free.append(most)
            most += 1
        place[i] = free.pop()
        found.append((place[parent], place[i]))
        if last[parent] == i and parent:
            free.append(place[parent])
        if i not in last:
            free.append(place[i])
    return found, most
