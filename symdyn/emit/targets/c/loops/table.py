"""What the template of a loop is given: the rows of its table as C, and how much room its motions and forces take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.dynamics.recursive.joint_table import JointRow, JointTable
from symdyn.emit.code.operators import Printer
from symdyn.program.table_numbers import MOMENTS, table_in_order
from symdyn.scene import Scene

LINE = 64
"""Bytes of the states side by side: one vector of the widest kind. Two and four ran no faster from 256 joints on."""

STACK = 576 * 1024
"""Bytes of work space that states side by side may take: those of 1,024 joints. More joints halve the states."""

GROUP = 8
"""Sines are taken of a multiple of so many angles."""

MOTION, FORCE, TILE = 18, 6, 32
"""Rows of work space of a motion, of a force with its moment, and of entries of states that lie apart."""

NUMBERS = 9
"""Numbers of a row before those of its body: two of a turn, three of a shift, two of a turn, rise and rotor."""

Kind = tuple[bool, bool]


@dataclass(frozen=True)
class LoopText:
    """One function as a loop.

    Attributes:
        joints, matrices: rows of the tables as C, and of fixed turns that are not about x.
        ground: acceleration of the ground, as C.
        kinds: (slides, turned by a matrix) of the kinds of joints there are, turns first.
        turns: how many of these are turns.
        turned: whether a joint stands turned at zero.
        motions: how many motions wait at most.
        work: numbers of work space of one state.
        lanes: states side by side; 0 where they would not fit on the stack.
        work_abreast: numbers of their work space.
        sincos, parts: as of functions in stages: it takes sines by a routine of our own, and is not in parts.
    """

    joints: tuple[str, ...]
    matrices: tuple[str, ...]
    ground: str
    kinds: tuple[Kind, ...]
    turns: int
    turned: bool
    motions: int
    work: int
    lanes: int
    work_abreast: int
    sincos: bool = True
    parts: tuple[()] = ()


def loop_text(table: JointTable, scene: Scene, printer: Printer, width: int) -> LoopText:
    """Return what the template needs of a table of a scene; a number takes `width` bytes."""
    kinds = tuple(sorted({_kind(row) for row in table.rows}))
    literals = map(printer.literal, table_in_order(table, scene))
    ground = _braces([next(literals) for _ in table.ground])
    rows, matrices = [], 0
    places, most = _places([row.parent for row in table.rows])
    for row, (come, go) in zip(table.rows, places, strict=True):
        whole = (row.parent, come, go, kinds.index(_kind(row)), matrices, int(not row.at_zero))
        matrices += len(row.fixed) > 2
        numbers = [next(literals) for _ in range(NUMBERS)]
        rows.append(_braces([*map(str, whole), *numbers, _braces([next(literals) for _ in range(MOMENTS)])]))
    lanes = LINE // width
    while lanes and _work(len(rows), most, lanes) * width > STACK:
        lanes //= 2
    lanes = lanes if lanes > 1 else 0
    return LoopText(
        joints=tuple(rows),
        matrices=tuple(_braces([next(literals) for _ in range(9)]) for _ in range(matrices)),
        ground=ground,
        kinds=kinds,
        turns=sum(not slides for slides, _ in kinds),
        turned=any(not row.at_zero for row in table.rows),
        motions=most,
        work=_work(len(rows), most, 1),
        lanes=lanes,
        work_abreast=_work(len(rows), most, lanes),
    )


def _kind(row: JointRow) -> Kind:
    return row.slides, len(row.fixed) > 2


def _braces(texts: Sequence[str]) -> str:
    return f"{{{', '.join(texts)}}}"


def _work(joints: int, motions: int, lanes: int) -> int:
    """Return how many numbers wait: sines, cosines, forces of all joints, motions of those that carry more."""
    angles = -(-joints * lanes // GROUP) * GROUP
    return 2 * angles + (FORCE * (joints + 1) + MOTION * motions + TILE * (lanes > 1)) * lanes


def _places(parents: Sequence[int]) -> tuple[list[tuple[int, int]], int]:
    """Return where each joint finds the motion of its parent and leaves its own, and how many places there are.

    A place is used again when the last joint that is carried from there has read it. The ground has the first.
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
