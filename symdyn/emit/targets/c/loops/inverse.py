"""What the template of inverse dynamics as a loop is given."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics.recursive.joint_table import JointRow, JointTable
from symdyn.emit.code.operators import Printer
from symdyn.emit.targets.c.loops.rows import Room, Rows, room, rows_of
from symdyn.scene import Scene

MOTION, FORCE = 18, 6
"""Rows of work space of a motion, and of a force with its moment."""

Kind = tuple[bool, bool]


@dataclass(frozen=True)
class InverseText:
    """Inverse dynamics as a loop.

    Attributes:
        rows, room: the tables and the work space.
        kinds: (slides, turned by a matrix) of the kinds of joints there are, turns first.
        turns: how many of these are turns.
        sincos, parts: as of functions in stages: it takes sines by a routine of our own, and is not in parts.
    """

    rows: Rows
    room: Room
    kinds: tuple[Kind, ...]
    turns: int
    sincos: bool = True
    parts: tuple[()] = ()
    template: str = "c/loop.c.jinja"
    guarded: bool = False
    made_of: tuple[str, ...] = ("outward", "inward")

    @property
    def slides(self) -> bool:
        """Whether a joint slides."""
        return self.turns < len(self.kinds)


def inverse_text(table: JointTable, scene: Scene, printer: Printer, width: int) -> InverseText:
    """Return what the template needs of a table of a scene; a number takes `width` bytes."""
    kinds = tuple(sorted({_kind(row) for row in table.rows}))
    rows = rows_of(table, scene, printer, [kinds.index(_kind(row)) for row in table.rows])
    joints = len(table.rows)
    space = room(joints, width, FORCE * (joints + 1) + MOTION * rows.places)
    return InverseText(rows, space, kinds, sum(not slides for slides, _ in kinds))


def _kind(row: JointRow) -> Kind:
    return row.slides, len(row.fixed) > 2
