"""Where values stand while a function is read: arrays, pointers into them, indices.

An index is whole numbers times 1, times k, the number of a state in a block, times `stride` and times `reach`, how far
columns of arguments and of the result are apart: `q[2 * stride + k]` is entry 2 of state k.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from symdyn.frozen import dataclass
from symdyn.graph import Expr

Spelled = Callable[[int], str]
"""How a language counts entries of a result: a place from 0 on, as its files say it."""


class Fault(Exception):  # noqa: N818  the reader adds the line
    """What is done to memory has no meaning; carries the words."""


@dataclass(frozen=True)
class Index:
    """units + lanes k + strides stride + reaches reach."""

    units: int
    lanes: int = 0
    strides: int = 0
    reaches: int = 0

    def __add__(self, other: Index) -> Index:
        return Index(
            self.units + other.units,
            self.lanes + other.lanes,
            self.strides + other.strides,
            self.reaches + other.reaches,
        )

    def __mul__(self, other: Index) -> Index:
        if self.plain:
            times = self.units
            return Index(times * other.units, times * other.lanes, times * other.strides, times * other.reaches)
        if other.plain:
            return other * self
        raise Fault("is no entry of a state")

    @property
    def plain(self) -> bool:
        return not (self.lanes or self.strides or self.reaches)


class Memory(Protocol):
    """An array."""

    def load(self, index: Index) -> Expr:
        """Return an entry."""

    def store(self, index: Index, value: Expr, line: int) -> None:
        """Write an entry."""


@dataclass(frozen=True)
class Pointer:
    """A place in an array, or where a row of it begins."""

    memory: Memory
    index: Index = Index(0)

    def plus(self, index: Index) -> Pointer:
        """Return the place so many entries on."""
        return Pointer(self.memory, self.index + index)

    def load(self, index: Index) -> Expr:
        """Return the entry so many places on."""
        return self.memory.load(self.index + index)

    def store(self, index: Index, value: Expr, line: int) -> None:
        """Write the entry so many places on."""
        self.memory.store(self.index + index, value, line)


class MemoryInputs:
    """An argument: a number an entry, or a column of states an entry."""

    def __init__(self, name: str, entries: Sequence[Expr], columns: bool = False) -> None:
        """Hold the entries of one state; among `columns` entry i stands at i * stride + k."""
        self.name, self.entries, self.columns = name, entries, columns
        self.readable = True

    def load(self, index: Index) -> Expr:
        """Return an entry of state k."""
        if not self.readable:
            raise Fault(f"reads {self.name} after the result was written, which may be the same array")
        place = place_of(index, self.columns)
        if not 0 <= place < len(self.entries):
            raise Fault(f"reads entry {place} of {self.name}, which has {len(self.entries)}")
        return self.entries[place]

    def store(self, index: Index, value: Expr, line: int) -> None:
        raise Fault(f"writes to the argument {self.name}")


class Result:
    """What a function returns through its last argument: every entry is written once, none is read."""

    def __init__(
        self,
        size: int,
        columns: bool = False,
        before: Sequence[MemoryInputs] = (),
        reaching: bool = False,
        spelled: Spelled = str,
    ) -> None:
        """Wait for `size` entries; the arrays `before` may be the same one, and are not read from then on.

        Columns that are `reaching` stand at i * reach + k, others at i * stride + k.
        """
        self.columns, self.before, self.reaching, self.spelled = columns, before, reaching, spelled
        self.entries: list[Expr | None] = [None] * size
        self.lines = [0] * size

    def load(self, index: Index) -> Expr:
        raise Fault("reads the result")

    def store(self, index: Index, value: Expr, line: int) -> None:
        """Write an entry of state k."""
        place = place_of(index, self.columns, self.reaching)
        if not 0 <= place < len(self.entries):
            raise Fault(f"writes entry {self.spelled(place)} of a result that has {len(self.entries)}")
        if self.entries[place] is not None:
            raise Fault(f"writes entry {self.spelled(place)} of the result again")
        self.entries[place], self.lines[place] = value, line
        for given in self.before:
            given.readable = False

    def first(self) -> tuple[tuple[Expr, ...], tuple[int, ...]]:
        """Return the first entries and where each was written, up to one that was not; none after it was."""
        count = self.entries.index(None) if None in self.entries else len(self.entries)
        if any(entry is not None for entry in self.entries[count:]):
            raise Fault(f"never writes entry {count} of the result")
        return tuple(entry for entry in self.entries if entry is not None), tuple(self.lines[:count])

    def whole(self) -> tuple[tuple[Expr, ...], tuple[int, ...]]:
        """Return all entries and where each was written."""
        missing = [place for place, entry in enumerate(self.entries) if entry is None]
        if missing:
            raise Fault(f"never writes entry {self.spelled(missing[0])} of the result")
        return tuple(entry for entry in self.entries if entry is not None), tuple(self.lines)


class Work:
    """A local array: entries, or a row of states at each of which state k is looked at."""

    def __init__(self, size: int, row: bool = False, filled: Expr | None = None) -> None:
        """Have `size` entries, `filled` or not written yet; of a `row` the entry of state k is looked at alone."""
        self.size, self.row = size, row
        self.entries: dict[int, Expr] = {} if filled is None else dict.fromkeys(range(size), filled)

    def load(self, index: Index) -> Expr:
        """Return what was written there last."""
        place = self._place(index)
        if place not in self.entries:
            raise Fault("reads a place of a local array that was not written")
        return self.entries[place]

    def store(self, index: Index, value: Expr, line: int) -> None:
        """Write a place, again or for the first time."""
        self.entries[self._place(index)] = value

    def _place(self, index: Index) -> int:
        if self.row:
            if index != Index(0, 1):
                raise Fault("is not the place of state k in its row")
            return 0
        place = place_of(index, columns=False)
        if not 0 <= place < self.size:
            raise Fault(f"is place {place} of a local array of {self.size}")
        return place


@dataclass(frozen=True)
class Rows:
    """Rows of states, one after the other."""

    rows: tuple[Pointer, ...]

    def row(self, index: Index) -> Pointer:
        place = place_of(index, columns=False)
        if not 0 <= place < len(self.rows):
            raise Fault(f"is row {place} of a local array of {len(self.rows)}")
        return self.rows[place]


def place_of(index: Index, columns: bool, reaching: bool = False) -> int:
    """Return which entry an index is: of one state, or of state k among columns, `reach` or `stride` apart."""
    if columns and reaching and index == Index(0, 1, 0, index.reaches):
        return index.reaches
    if columns and not reaching and index == Index(0, 1, index.strides):
        return index.strides
    if not columns and index.plain:
        return index.units
    raise Fault("is no entry of a state")
