"""Arrays of a store, a block a chunk, each chunk a file with a checksum: what is there, and is it what was put.

Zarr takes a chunk without a file for one of fill values, so files are looked for; and it writes none for a chunk of
nothing but fill values, unless it is asked to (`ALL_FILES`), so that a file that is missing is a block that is missing.
Every chunk ends with its CRC-32C, and what the group says of itself stands beside a hash of it (`seal`). A chunk may be
whole and of another block or sweep: its hash with its place (`Place.mark`) stands in the array of hashes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import StudyError

ALL_FILES = {"array.write_empty_chunks": True}
"""Configuration of Zarr under which arrays are opened."""

SEAL = "seal"
"""The attribute of a group that has the hash of all others."""

AGAIN = "the command that made it makes what is spoilt again"


HASH = 32
"""Bytes of the hash of a chunk."""


@dataclass(frozen=True)
class Hashes:
    """Hashes of the chunks of an array, each with the sweep, the array and the block that it belongs to.

    Attributes:
        sweep: what decides the numbers of the store, as text.
        name: of the array.
        chunks: where hashes are, a row a block.
        column: of `chunks`, where those of this array begin.
    """

    sweep: str
    name: str
    chunks: Chunks
    column: int

    def of(self, k: int, rows: NDArray[Any]) -> NDArray[np.uint8]:
        """Return the hash of the rows of block k, shape (HASH,)."""
        place = json.dumps([self.sweep, self.name, k, rows.shape]).encode()
        return np.frombuffer(sha256(place + np.ascontiguousarray(rows).tobytes()).digest(), dtype=np.uint8)

    def there(self, k: int) -> NDArray[np.uint8] | None:
        """Return the hash that was kept, None where there is none."""
        if not self.chunks.file(k).is_file():
            return None
        return np.asarray(self.chunks[k, self.column : self.column + HASH])


@dataclass(frozen=True)
class Chunks:
    """An array of a store.

    Attributes:
        folder: of the array.
        array: of Zarr, opened with `ALL_FILES`.
        hashes: of its chunks; None of the array of hashes.
    """

    folder: Path
    array: Any
    hashes: Hashes | None = None
    _whole: set[int] = field(default_factory=set, compare=False)

    def file(self, k: int) -> Path:
        """Return where chunk k stands: the rows of block k, all columns."""
        key: str = self.array.metadata.encode_chunk_key((k, *(0 for _ in self.array.shape[1:])))
        return self.folder.joinpath(*key.split("/"))

    def fault(self, k: int) -> str:
        """Return why chunk k cannot be had, "" where it is whole and in its place.

        Raises:
            StudyError: a folder stands there, or a pipe, which nothing could be written over.
        """
        file, rows = self.file(k), self.array.chunks[0]
        if file.exists() and not file.is_file():
            what = "a folder" if file.is_dir() else "no file"
            raise StudyError(f"{file} is {what}, where a block of a sweep should be; delete it, or take it elsewhere")
        if not file.is_file():
            return f"{self.shown(k)} is missing"
        if (size := file.stat().st_size) > self.most:
            return f"{self.shown(k)} is spoilt: it has {size} bytes, and a block {self.most} at most"
        try:
            found = np.asarray(self.array[k * rows : (k + 1) * rows])
            kept = None if self.hashes is None else self.hashes.there(k)
        except Exception as fault:  # of many kinds, by which codec meets what is spoilt
            return f"{self.shown(k)} is spoilt: {fault}"
        if self.hashes is not None and kept is not None and not np.array_equal(kept, self.hashes.of(k, found)):
            return f"{self.shown(k)} is spoilt: it is whole, and not what was put there"
        return ""

    @property
    def most(self) -> int:
        """Bytes that a chunk has at most: what does not compress grows by less than a hundredth."""
        size = int(np.prod(self.array.chunks)) * int(self.array.dtype.itemsize)
        return size + size // 100 + 4096

    def shown(self, k: int) -> str:
        """Return the place of chunk k below the store."""
        return self.file(k).relative_to(self.folder.parent).as_posix()

    def __len__(self) -> int:
        return int(self.array.shape[0])

    def __getitem__(self, where: Any) -> NDArray[Any]:
        """Return some of it, read when it is asked for.

        Raises:
            StudyError: a chunk is spoilt, or there is too little memory.
        """
        for k in self._touched(where):
            if self.file(k).exists() and k not in self._whole:
                if fault := self.fault(k):
                    raise StudyError(f"{self.folder.parent}: a block cannot be read ({fault}); {AGAIN}")
                self._whole.add(k)
        try:
            return np.asarray(self.array[where])
        except IndexError:  # there is no such row: a loop over rows ends
            raise
        except Exception as fault:  # of many kinds, by which codec meets what is spoilt
            raise StudyError(f"{self.folder.parent}: a block cannot be read ({fault}); {AGAIN}") from None

    def _touched(self, where: Any) -> range:
        """Return the blocks of which an index takes something, or more."""
        first, size = where[0] if isinstance(where, tuple) and where else where, self.array.chunks[0]
        numbers = range(len(self))
        if isinstance(first, (int, np.integer, slice)):
            taken = numbers[first] if isinstance(first, slice) else numbers[int(first) :][:1] or numbers[:0]
            numbers = range(min(taken[0], taken[-1]), max(taken[0], taken[-1]) + 1) if taken else taken
        return range(numbers[0] // size, numbers[-1] // size + 1) if numbers else range(0)

    def put(self, k: int, rows: NDArray[Any]) -> None:
        """Write the rows of block k."""
        size = self.array.chunks[0]
        self.array[k * size : (k + 1) * size] = rows
        self._whole.discard(k)


def seal(about: Mapping[str, Any], arrays: Mapping[str, Any]) -> str:
    """Return a hash of what a group and its arrays say of themselves.

    Args:
        about: attributes of the group; its own seal does not count.
        arrays: of Zarr, by name.
    """
    kinds = {name: one.metadata.to_dict() for name, one in arrays.items()}
    said = {key: value for key, value in about.items() if key != SEAL}
    return sha256(json.dumps([said, kinds], sort_keys=True, default=str).encode()).hexdigest()
