"""Arrays of C on the stack: how many bytes, and what becomes of those that are more than a caller allows.

With option "stack=SIZE" a function that needs more takes its work space as an argument, behind the result:

    void <scene>_<function>(const real *q, ..., real *out, real work[<scene>_<function>_work])

It computes the same, number by number. Any place will do: up to a line of the cache of it is left out, so that what is
used begins where a vector may.
"""

from __future__ import annotations

import re

from symdyn.arguments import argument
from symdyn.emit.targets.c.cuts import BatchText, CutText
from symdyn.emit.targets.c.loops import LINE, LoopText, whole
from symdyn.emit.targets.c.pair_runs import PairRunsText
from symdyn.emit.targets.c.writer import LANES
from symdyn.errors import EmitError
from symdyn.frozen import dataclass

STACK = "stack"
"""The option, with a size behind an equals sign; 0 or none for as little as may be."""

SIZE = re.compile(rf"{STACK}(?:=([0-9]{{1,9}})(k?))?")

POINTER = 8
"""Bytes of an index of an array, at most."""


@dataclass(frozen=True)
class Stack:
    """Bytes of arrays that a function and whom it calls have on the stack, those of its deepest way of calls.

    What a compiler spills, and saves of registers, comes on top; it depends on the compiler alone.
    """

    one: int  # of a call for one state
    many: int  # of a call for many states; 0 without batch code
    work: int = 0  # numbers of an argument that stands in for most of them; 0 where there is none
    behind: int = 0  # where in that argument results stand, behind what parts hand on


def allowance(option: str) -> int | None:
    """Return the bytes of arrays that a function may have on the stack; None without that option, 0 without a number.

    Raises:
        EmitError: a size that is none.
    """
    if not option.startswith(STACK):
        return None
    if not (found := SIZE.fullmatch(option)):
        size = option.partition("=")[2]
        raise EmitError(f"{argument(STACK, size)} is no size; give bytes such as 4096, or 16k of 1,024 each")
    return int(found[1] or 0) * (1024 if found[2] else 1)


def stack_of(
    name: str, code: CutText | BatchText | LoopText | None, width: int, batch: bool, most: int | None
) -> Stack:
    """Return the arrays of a function whose numbers take `width` bytes; a `code` of None is one without stages.

    Where that is more than `most`, those whose size grows with the function become an argument.

    Raises:
        EmitError: the others are more than `most`; `name` begins the message.
    """
    if code is None:
        return Stack(0, 0)
    first, rest, beside = _arrays(code, width)
    one = width * (first + rest) + beside
    if most is not None and one > most:
        if beside > most > 0:
            least = argument(STACK, beside)
            raise EmitError(
                f"{name} keeps {beside:,} bytes of arrays whatever work space it is given; {least} would do"
            )
        return Stack(beside, 0, whole(first) + rest + LINE // width, whole(first))
    if isinstance(code, LoopText):
        lanes = code.room.lanes if batch else 0
        many = width * code.room.lockstep + _beside_loop(code, lanes) if lanes else 0
        return Stack(one, max(one, many) if batch else 0)
    return Stack(one, _of_block(code, width, one) if isinstance(code, BatchText) else 0)


def _arrays(code: CutText | BatchText | LoopText, width: int) -> tuple[int, int, int]:
    """Return what one state takes: numbers that parts hand on, numbers of results and work space, other bytes."""
    if isinstance(code, LoopText):
        return 0, code.numbers, _beside_loop(code, 1)
    beside = width * 3 * sum(len(stage.angles) for stage in code.scalar)
    beside += code.solve.places if isinstance(code.solve, PairRunsText) else 0
    return (code.kept or 1, code.solve.size if code.solve else code.size, beside) if code.parts else (0, 0, beside)


def _beside_loop(code: LoopText, lanes: int) -> int:
    """Return bytes that a loop over a table takes beside its work space, of so many states side by side."""
    numbers, pairs = code.place * lanes, code.pairs
    if pairs is None:
        return code.width * numbers
    return code.width * (numbers + pairs.goes + 3) + (len(code.rows.joints) * POINTER if pairs.solved else 0)


def _of_block(code: BatchText, width: int, one: int) -> int:
    """Return what many states take: a block of them with its result, and work space or what copies them."""
    if code.lanes == 0:
        return one + width * (code.length + code.size) if code.size else one
    beside = code.length * code.lanes + code.held * max(code.reach, code.lanes)
    return width * beside + max(width * max(code.rows * code.lanes, 4 * LANES), one)
