"""Where results go, block by block: arrays in memory, or a group of Zarr on disk that a sweep goes on with.

A group has `values` (runs, names), `measures` (runs, measures) and `codes` (runs,), a block a chunk, `hashes` of these
(blocks, 3 hashes), and says in its attributes what decides the numbers. A chunk is written aside and renamed, that of
`codes` last; a run without a code was not made, and a block counts only when all its chunks are there, read as they
were written, and are in the place that they were written to.

Zarr takes a chunk without a file for one of fill values, so files are looked for; and it writes none for a chunk of
nothing but fill values, unless it is asked to (`ALL_FILES`), so that a file that is missing is a block that is missing.
Every chunk ends with its CRC-32C, and what the group says of itself stands beside a hash of it (`seal`). A chunk may be
whole and of another block or sweep: its hash with its place (`Hashes.of`) stands in the array of hashes.

Measured beside `xarray.Dataset.to_zarr(region=)`: that takes twice as long (23 ms a block of 50,000 runs, here 11), and
of 27 damages to its chunks (deleted, cut, bits turned, another block's) it reads 11 as numbers, and none is read here.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.errors import StudyError
from symdyn.frozen import dataclass, field
from symdyn.resources import version
from symdyn.study.job import BlockResult, Job
from symdyn.study.runs import MOST_TOLD, NOT_MADE, Runs

ALL_FILES = {"array.write_empty_chunks": True}
"""Configuration of Zarr under which arrays are opened."""

SEAL = "seal"
"""The attribute of a group that has the hash of all others."""

AGAIN = "the command that made it makes what is spoilt again"


HASH = 32
"""Bytes of the hash of a chunk."""


@dataclass(frozen=True)
class Hashes:
    """Hashes of the chunks of an array, each with the sweep, the array and the block that it belongs to."""

    sweep: str  # what decides the numbers of the store, as text
    name: str  # of the array
    chunks: Chunks  # where hashes are, a row a block
    column: int  # of `chunks`, where those of this array begin

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
    """An array of a store."""

    folder: Path  # of the array
    array: Any  # of Zarr, opened with `ALL_FILES`
    hashes: Hashes | None = None  # of its chunks; None of the array of hashes
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


SUFFIX = ".zarr"

HASHED = ("values", "measures", "codes")
"""Arrays of results, in the order of their hashes."""

KINDS = {"values": "float64", "measures": "float64", "codes": "uint8", "hashes": "uint8"}
"""Arrays of a group, and what they are made of: plain numbers alone, so that nothing read from a disk is executed."""

LARGEST = 2**28
"""Bytes of an array that is read into memory; of a larger one slices are read when they are asked for."""


class Store(Protocol):
    """What blocks are put into."""

    block: int  # runs of a block

    def left(self) -> Mapping[int, str]:
        """Return the numbers of blocks that are to be made, each with what is spoilt of it, "" where it never was."""

    def put(self, job: Job, k: int, block_result: BlockResult) -> None:
        """Take what came of block k."""

    def runs(self, notes: tuple[str, ...] = (), wall: float = 0.0) -> Runs:
        """Return what is there."""


class InMemory:
    """Arrays of this process."""

    def __init__(self, job: Job) -> None:
        self.job, self.block = job, job.block
        self.measures = np.full((job.design.count, len(job.measures)), np.nan)
        self.codes = np.zeros(job.design.count, dtype=np.uint8)
        self.reasons: dict[int, str] = {}

    def left(self) -> Mapping[int, str]:
        """Return the numbers of blocks that are not there."""
        return {k: "" for k in range(self.job.blocks) if NOT_MADE in self.codes[slice(*self.job.span(k))]}

    def put(self, job: Job, k: int, block_result: BlockResult) -> None:
        """Take what came of block k."""
        where = slice(*job.span(k))
        self.measures[where], self.codes[where] = block_result.measures, block_result.codes
        self.reasons = first_of(self.reasons, block_result.reasons)

    def runs(self, notes: tuple[str, ...] = (), wall: float = 0.0) -> Runs:
        """Return what is there."""
        columns = {one.name: self.measures[:, k] for k, one in enumerate(self.job.measures)}
        return Runs(
            self.job.scene.name, self.job.design.names, self.job.units, self.job.design.values(), columns,
            self.codes, self.reasons, self.job.identity | {"symdyn": version()}, notes, wall,
        )  # fmt: skip


class OnDisk:
    """A group of Zarr."""

    def __init__(self, path: Path, group: Any, arrays: Mapping[str, Any]) -> None:
        self.path, self.group, self.arrays = path, group, arrays
        self.about: Mapping[str, Any] = dict(group.attrs)
        self.hashes = Chunks(path / "hashes", arrays["hashes"])
        sweep = json.dumps(self.about["job"], sort_keys=True)
        self.values, self.measures, self.codes = (
            Chunks(path / name, arrays[name], Hashes(sweep, name, self.hashes, k * HASH))
            for k, name in enumerate(HASHED)
        )
        self.block = int(self.codes.array.chunks[0])
        self.reasons = {int(number): words for number, words in self.about["reasons"].items()}

    def left(self) -> Mapping[int, str]:
        """Return the numbers of blocks that are to be made, each with what is spoilt of it, "" where it never was.

        Raises:
            StudyError: a folder stands where a chunk should be.
        """
        found = ((k, self._fault(k)) for k in range(-(-len(self.codes) // self.block)))
        return {k: fault for k, fault in found if fault is not None}

    def _fault(self, k: int) -> str | None:
        """Return what is wrong with a block, "" where it was never made, None where it is whole."""
        faults = [one.fault(k) for one in (self.hashes, self.codes, self.values, self.measures)]
        if not self.codes.file(k).is_file():  # it is written last
            return ""
        if not any(faults) and NOT_MADE in self.codes[k * self.block : (k + 1) * self.block]:
            return f"{self.codes.shown(k)} lacks runs"
        return next(filter(None, faults), None)

    def put(self, job: Job, k: int, block_result: BlockResult) -> None:
        """Take what came of block k: its codes last.

        Raises:
            StudyError: the disk is full, or the folder is gone.
        """
        first, last = job.span(k)
        try:
            chunks = (self.values, self.measures, self.codes)
            came = (job.design.values(first, last), block_result.measures, block_result.codes)
            rows = [np.asarray(numbers, one.array.dtype) for one, numbers in zip(chunks, came, strict=True)]
            marks = [one.hashes.of(k, numbers) for one, numbers in zip(chunks, rows, strict=True) if one.hashes]
            self.values.put(k, rows[0])
            self.measures.put(k, rows[1])
            self.hashes.put(k, np.concatenate(marks)[None])
            if block_result.reasons:
                self.reasons = first_of(self.reasons, block_result.reasons)
                about = dict(self.about) | {"reasons": {str(number): words for number, words in self.reasons.items()}}
                self.group.attrs.update(about | {SEAL: seal(about, self.arrays)})
            self.codes.put(k, rows[2])
        except OSError as fault:
            raise StudyError(
                f"{self.path}: cannot write there ({fault.strerror or fault}); what is in it stays, and the same "
                "command goes on with it"
            ) from None

    def runs(self, notes: tuple[str, ...] = (), wall: float = 0.0) -> Runs:
        """Return what is there.

        Raises:
            StudyError: of a block that was made a part is missing, or cannot be read.
        """
        about = dict(self.about["job"]) | {"symdyn": self.about["symdyn"]}
        told = dict(sorted(self.reasons.items()))
        codes = self.codes[:]
        made = np.flatnonzero(np.maximum.reduceat(codes, np.arange(0, len(codes), self.block)) != NOT_MADE)
        for one in (self.values, self.measures, self.hashes):
            missing = next((k for k in made.tolist() if not one.file(k).is_file()), None)
            if missing is not None:
                raise StudyError(f"{self.path}: a block cannot be read ({one.shown(missing)} is missing); {AGAIN}")
        measures = Columns(_read(self.measures), tuple(self.about["measures"]), codes != NOT_MADE)
        return Runs(
            self.about["scene"], tuple(self.about["names"]), self.about["units"], _read(self.values), measures, codes,
            told, about, notes, wall,
        )  # fmt: skip


class Columns(Mapping[str, Array]):
    """Columns of an array of Zarr by name, each read when it is asked for, and kept where all are small."""

    def __init__(self, array: Array | Chunks, names: tuple[str, ...], made: NDArray[np.bool_]) -> None:
        """Take an array, shape (n, columns), and which of its rows were made, shape (n,)."""
        self._array, self._names, self._made = array, names, made

    def __getitem__(self, name: str) -> Array:
        """Return one column, shape (n,); NaN where no run was made."""
        if name not in self._names:
            raise KeyError(name)
        return np.where(self._made, self._array[:, self._names.index(name)], np.nan)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def _read(chunks: Chunks) -> Any:
    return chunks if chunks.array.nbytes > LARGEST else chunks[:]


def first_of(reported: Mapping[int, str], more: Mapping[int, str]) -> dict[int, str]:
    """Return the words of the runs with the lowest numbers."""
    return dict(sorted((dict(reported) | dict(more)).items())[:MOST_TOLD])
