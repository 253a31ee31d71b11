"""Where results go, block by block: arrays in memory, or a group of Zarr on disk that a sweep goes on with.

A group has `values` (runs, names), `measures` (runs, measures) and `codes` (runs,), a block a chunk, and says in its
attributes what decides the numbers. A chunk is written aside and renamed, that of `codes` last; a run without a code
was not made, so that a block counts only when all of it is there, whenever a process was killed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.errors import StudyError
from symdyn.resources import version
from symdyn.study.found import Found
from symdyn.study.job import Job, units_of
from symdyn.study.study import MOST_TOLD, NOT_MADE, Study

SUFFIX = ".zarr"

LARGEST = 2**28
"""Bytes of an array that is read into memory; of a larger one slices are read when they are asked for."""


class Store(Protocol):
    """What blocks are put into.

    Attributes:
        block: runs of a block.
    """

    block: int

    def left(self) -> tuple[int, ...]:
        """Return the numbers of blocks that are not there."""

    def put(self, job: Job, k: int, found: Found) -> None:
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

    def left(self) -> tuple[int, ...]:
        """Return the numbers of blocks that are not there."""
        return tuple(k for k in range(self.job.blocks) if NOT_MADE in self.codes[slice(*self.job.span(k))])

    def put(self, job: Job, k: int, found: Found) -> None:
        """Take what came of block k."""
        where = slice(*job.span(k))
        self.measures[where], self.codes[where] = found.measures, found.codes
        self.told = first_of(self.told, found.told)

    def study(self, notes: tuple[str, ...] = (), wall: float = 0.0) -> Study:
        """Return what is there."""
        columns = {one.name: self.measures[:, k] for k, one in enumerate(self.job.measures)}
        return Study(
            self.job.scene.name, self.job.design.names, units_of(self.job), self.job.design.values(), columns,
            self.codes, self.told, self.job.told | {"symdyn": version()}, notes, wall,
        )  # fmt: skip


class OnDisk:
    """A group of Zarr."""

    def __init__(self, path: Path, group: Any) -> None:
        """Take an open group."""
        self.path, self.group = path, group
        self.about: Mapping[str, Any] = dict(group.attrs)
        self.block = int(group["codes"].chunks[0])
        self.told = {int(number): words for number, words in self.about["told"].items()}

    def left(self) -> tuple[int, ...]:
        """Return the numbers of blocks that are not there, or cannot be read."""
        codes = self.group["codes"]
        starts = range(0, codes.shape[0], self.block)
        return tuple(k for k, first in enumerate(starts) if not self._whole(codes, first))

    def _whole(self, codes: Any, first: int) -> bool:
        where = slice(first, first + self.block)
        try:
            return NOT_MADE not in codes[where] and all(len(self.group[one][where]) for one in ("values", "measures"))
        except Exception:  # a chunk that a power cut has spoilt, told by whatever decodes it
            return False

    def put(self, job: Job, k: int, found: Found) -> None:
        """Take what came of block k: its codes last.

        Raises:
            StudyError: the disk is full, or the folder is gone.
        """
        first, last = job.span(k)
        try:
            self.group["values"][first:last] = job.design.values(first, last)
            self.group["measures"][first:last] = found.measures
            if found.told:
                self.told = first_of(self.told, found.told)
                self.group.attrs["told"] = {str(number): words for number, words in self.told.items()}
            self.group["codes"][first:last] = found.codes
        except OSError as fault:
            raise StudyError(
                f"{self.path}: cannot write there ({fault.strerror or fault}); what is in it stays, and the same "
                "command goes on with it"
            ) from None

    def study(self, notes: tuple[str, ...] = (), wall: float = 0.0) -> Study:
        """Return what is there."""
        about = dict(self.about["job"]) | {"symdyn": self.about["symdyn"]}
        told = dict(sorted(self.told.items()))
        try:
            measures = Columns(self.group["measures"], tuple(self.about["measures"]))
            values, codes = _read(self.group["values"]), np.asarray(self.group["codes"][:])
        except Exception as fault:  # of many kinds, by which library decodes a chunk; or there is too little memory
            raise StudyError(
                f"{self.path}: a block cannot be read ({fault}); the command that made it makes what is spoilt again"
            ) from None
        return Study(
            self.about["scene"], tuple(self.about["names"]), self.about["units"], values, measures, codes, told, about,
            notes, wall,
        )  # fmt: skip


class Columns(Mapping[str, Array]):
    """Columns of an array of Zarr by name, each read when it is asked for, and kept where all are small."""

    def __init__(self, array: Any, names: tuple[str, ...]) -> None:
        """Take an array, shape (n, columns)."""
        self._array, self._names = _read(array), names

    def __getitem__(self, name: str) -> Array:
        """Return one column, shape (n,)."""
        if name not in self._names:
            raise KeyError(name)
        return np.asarray(self._array[:, self._names.index(name)])

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def _read(array: Any) -> Any:
    return array if array.nbytes > LARGEST else array[:]


def first_of(told: Mapping[int, str], more: Mapping[int, str]) -> dict[int, str]:
    """Return the words of the runs with the lowest numbers."""
    return dict(sorted((dict(told) | dict(more)).items())[:MOST_TOLD])
