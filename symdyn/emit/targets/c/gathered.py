"""Results of many entries in batch code: which rows of a block the loops write, and which entry is which of them.

Where a block's states go to columns a power of two apart, and always where entries lie state by state, the result of a
block is written into rows of work space and copied. Half of a mass matrix is the other half, and much of a tree's is
zero: such entries are copied from the row that is there already. A copy of 64 states at a time is several times as
fast as one of 32, since caches fetch ahead along long pieces only; rows are a line of the cache further apart than
they are long, so that not all of them fall on the same few places of the nearest cache.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symdyn.emit.code.real import REALS
from symdyn.program import Program, Routine

LANES = REALS["double"].lanes
"""States in a block, of all types but double-doubles."""

LINE = 64
"""Bytes of a line of the cache."""

WAYS = 8
"""How many columns a power of two apart find a place in a cache at once; results of more go through rows."""

NEAREST = 32 * 1024
"""Bytes of a result of a block up to which its loops may write all entries, each to its own column."""


@dataclass(frozen=True)
class Gathered:
    """What becomes of the result of a block.

    Attributes:
        rows: of a block: entries that are written, and one of zeros where there are some.
        zeros: whether the last row holds zeros.
        written: entries that loops write, with their rows.
        places: of each entry, the row that it is; () where every entry has its own.
        direct: whether loops write all entries, so that they may write where the result has to go.
        wide: whether the result has so many entries that columns a power of two apart are not written directly.
    """

    rows: int
    zeros: bool
    written: Mapping[int, int]
    places: tuple[int, ...]
    direct: bool
    wide: bool

    def reach(self, states: int, width: int) -> int:
        """Return how far rows of so many states of `width` bytes are apart; where room is scarce, no further."""
        return states + LINE // width if self.wide and states == LANES else states

    def states(self, lanes: int, width: int, room: int) -> int:
        """Return how many states are copied at once: more than the `lanes` of one block, if `room` bytes hold them."""
        states = LANES if self.wide else lanes
        while states > lanes and self.rows * self.reach(states, width) * width > room:
            states //= 2
        return states


def gathered(routine: Routine, program: Program, width: int) -> Gathered:
    """Return what becomes of the result of a block, an entry of one state taking `width` bytes."""
    entries = routine.function.entries
    size, wide = len(entries), len(entries) > WAYS
    first = {entry: place for place, entry in reversed(tuple(enumerate(entries)))}
    own = {place: place for place in range(size)}
    if not wide or len(first) == size:
        return Gathered(size, False, own, (), direct=True, wide=wide)
    if size * LANES * width <= NEAREST:
        return Gathered(size, False, own, tuple(first[entry] for entry in entries), direct=True, wide=True)
    kept = [place for place in sorted(first.values()) if program.constants.get(entries[place]) != 0]
    row = {entries[place]: number for number, place in enumerate(kept)}
    zeros = len(row) < len(first)
    places = tuple(row.get(entry, len(row)) for entry in entries)
    written = {place: row[entries[place]] for place in kept}
    return Gathered(len(row) + zeros, zeros, written, places, direct=False, wide=True)
