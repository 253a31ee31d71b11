"""Bytes of arrays that a function of C has on the stack, as the file tells them: those of its deepest way of calls.

What a compiler spills of single numbers, and saves of registers, comes on top; it depends on the compiler alone.
"""

from __future__ import annotations

from symdyn.emit.targets.c.cuts import BatchText, CutText
from symdyn.emit.targets.c.loops import LoopText, PairRunsText
from symdyn.emit.targets.c.writer import LANES
from symdyn.frozen import dataclass

POINTER = 8
"""Bytes of an index of an array, at most."""


@dataclass(frozen=True)
class Stack:
    """Bytes of arrays.

    Attributes:
        one: of a call for one state.
        many: of a call for many states; 0 without batch code.
    """

    one: int
    many: int


def stack_of(code: CutText | BatchText | LoopText | None, width: int, batch: bool) -> Stack:
    """Return the arrays of a function whose numbers take `width` bytes; None is one without stages."""
    if isinstance(code, LoopText):
        one = _looped(code, 1)
        return Stack(one, max(one, _looped(code, code.room.lanes)) if batch else 0)
    one = _single(code, width) if code else 0
    return Stack(one, _block(code, width, one) if isinstance(code, BatchText) else 0)


def _looped(code: LoopText, lanes: int) -> int:
    """Return what a loop over a table takes, of so many states side by side."""
    if lanes == 0:
        return 0
    work = (code.room.one if lanes == 1 else code.room.lockstep) + code.place * lanes
    if (pairs := code.pairs) is None:
        return code.width * work
    joints = len(code.rows.joints)
    factors = joints * (code.width + POINTER) if pairs.solved else 0
    return code.width * (work + pairs.goes + 3 + pairs.solved * joints) + factors


def _single(code: CutText | BatchText, width: int) -> int:
    """Return what one state takes: sines, what parts hand on, and a loop over pairs."""
    numbers = 3 * sum(len(stage.angles) for stage in code.scalar)
    if code.parts:
        numbers += (code.kept or 1) + (code.solve.size if code.solve else code.size)
    if isinstance(code.solve, PairRunsText):
        return width * (numbers + code.solve.work) + code.solve.places
    return width * numbers


def _block(code: BatchText, width: int, one: int) -> int:
    """Return what many states take: a block of them with its result, and work space or what copies them."""
    if code.lanes == 0:
        return one + width * (code.length + code.size) if code.size else one
    beside = code.length * code.lanes + code.held * max(code.reach, code.lanes)
    return width * beside + max(width * max(code.rows * code.lanes, 4 * LANES), one)
