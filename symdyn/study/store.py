"""Where results go, block by block: arrays in memory, or a group of Zarr on disk that a sweep goes on with.

A group has `values` (runs, names), `measures` (runs, measures) and `codes` (runs,), a block a chunk, `hashes` of these
(blocks, 3 hashes), and says in its attributes what decides the numbers. A chunk is written aside and renamed, that of
`codes` last; a run without a code was not made, and a block counts only when all its chunks are there, read as they
were written, and are in the place that they were written to (`chunks.py`).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.errors import StudyError
from symdyn.resources import version
from symdyn.study.block_result import BlockResult
from symdyn.study.chunks import AGAIN, HASH, SEAL, Chunks, Hashes, seal
from symdyn.study.job import Job, units_of
from symdyn.study.study import MOST_TOLD, NOT_MADE, Study

SUFFIX = ".zarr"

HASHED = ("values", "measures", "codes")
"""Arrays of results, in the order of their hashes."""

KINDS = {"values": "float64", "measures": "float64", "codes": "uint8", "hashes": "uint8"}
"""Arrays of a group, and what they are made of: plain numbers alone, so that nothing read from a disk is executed."""

LARGEST = 2**28
"""Bytes of an array that is read into memory; of a larger one slices are read when they are asked for."""


class Store(Protocol):
    """What blocks are put into.

    Attributes:
        block: runs of a block.
    """

    block: int

    def left(self) -> Mapping[int, str]:
        """Return the numbers of blocks that are to be made, each with what is spoilt of it, "" where it never was."""

    def put(self, job: Job, k: int, block_result: BlockResult) -> None:
        """Take what came of block k."""

    def study(self, notes: tuple[str, ...] = (), wall: float = 0.0) -> Study:
        """Return what is there."""


class InMemory:
    """Arrays of this process."""

    def __init__(self, job: Job) -> None:
        """Make room for the results of a job."""
        self.job, self.block = job, job.block
        self.measures = np.full((job.design.count, len(job.measures)), np.nan)
        self.codes = np.zeros(job.design.count, dtype=np.uint8)
        self.told: dict[int, str] = {}

    def left(self) -> Mapping[int, str]:
        """Return the numbers of blocks that are not there."""
        return {k: "" for k in range(self.job.blocks) if NOT_MADE in self.codes[slice(*self.job.span(k))]}

    def put(self, job: Job, k: int, block_result: BlockResult) -> None:
        """Take what came of block k."""
        where = slice(*job.span(k))
        self.measures[where], self.codes[where] = block_result.measures, block_result.codes
        self.told = first_of(self.told, block_result.told)

    def study(self, notes: tuple[str, ...] = (), wall: float = 0.0) -> Study:
        """Return what is there."""
        columns = {one.name: self.measures[:, k] for k, one in enumerate(self.job.measures)}
        return Study(
            self.job.scene.name, self.job.design.names, units_of(self.job), self.job.design.values(), columns,
            self.codes, self.told, self.job.told | {"symdyn": version()}, notes, wall,
        )  # fmt: skip


class OnDisk:
    """A group of Zarr."""

    def __init__(self, path: Path, group: Any, arrays: Mapping[str, Any]) -> None:
        """Take an open group and its arrays, those of `KINDS`."""
        self.path, self.group, self.arrays = path, group, arrays
        self.about: Mapping[str, Any] = dict(group.attrs)
        self.hashes = Chunks(path / "hashes", arrays["hashes"])
        sweep = json.dumps(self.about["job"], sort_keys=True)
        self.values, self.measures, self.codes = (
            Chunks(path / name, arrays[name], Hashes(sweep, name, self.hashes, k * HASH))
            for k, name in enumerate(HASHED)
        )
        self.block = int(self.codes.array.chunks[0])
        self.told = {int(number): words for number, words in self.about["told"].items()}

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
            if block_result.told:
                self.told = first_of(self.told, block_result.told)
                about = dict(self.about) | {"told": {str(number): words for number, words in self.told.items()}}
                self.group.attrs.update(about | {SEAL: seal(about, self.arrays)})
            self.codes.put(k, rows[2])
        except OSError as fault:
            raise StudyError(
                f"{self.path}: cannot write there ({fault.strerror or fault}); what is in it stays, and the same "
                "command goes on with it"
            ) from None

    def study(self, notes: tuple[str, ...] = (), wall: float = 0.0) -> Study:
        """Return what is there.

        Raises:
            StudyError: of a block that was made a part is missing, or cannot be read.
        """
        about = dict(self.about["job"]) | {"symdyn": self.about["symdyn"]}
        told = dict(sorted(self.told.items()))
        codes = self.codes[:]
        made = np.flatnonzero(np.maximum.reduceat(codes, np.arange(0, len(codes), self.block)) != NOT_MADE)
        for one in (self.values, self.measures, self.hashes):
            missing = next((k for k in made.tolist() if not one.file(k).is_file()), None)
            if missing is not None:
                raise StudyError(f"{self.path}: a block cannot be read ({one.shown(missing)} is missing); {AGAIN}")
        measures = Columns(_read(self.measures), tuple(self.about["measures"]), codes != NOT_MADE)
        return Study(
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
