"""Arrays of a store, a block a chunk, each chunk a file with a checksum: what is there, and is it what was put.

Zarr takes a chunk without a file for one of fill values, so files are looked for; and it writes none for a chunk of
nothing but fill values, unless it is asked to (`ALL_FILES`), so that a file that is missing is a block that is missing.
Every chunk ends with its CRC-32C, and what the group says of itself stands beside a hash of it (`seal`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Chunks:
    """An array of a store.

    Attributes:
        folder: of the array.
        array: of Zarr, opened with `ALL_FILES`.
    """

    folder: Path
    array: Any

    def file(self, k: int) -> Path:
        """Return where chunk k stands: the rows of block k, all columns."""
        key: str = self.array.metadata.encode_chunk_key((k, *(0 for _ in self.array.shape[1:])))
        return self.folder.joinpath(*key.split("/"))

    def fault(self, k: int) -> str:
        """Return why chunk k cannot be had, "" where it is whole.

        Raises:
            StudyError: a folder stands there, which nothing could be written over.
        """
        file, rows = self.file(k), self.array.chunks[0]
        if file.is_dir():
            raise StudyError(f"{file} is a folder, where a block of a sweep should be; delete it, or take it elsewhere")
        if not file.is_file():
            return f"{self.shown(k)} is missing"
        try:
            self.array[k * rows : (k + 1) * rows]
        except Exception as fault:  # of many kinds, by which codec meets what is spoilt
            return f"{self.shown(k)} is spoilt: {fault}"
        return ""

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
        try:
            return np.asarray(self.array[where])
        except IndexError:  # there is no such row: a loop over rows ends
            raise
        except Exception as fault:  # of many kinds, by which codec meets what is spoilt
            raise StudyError(f"{self.folder.parent}: a block cannot be read ({fault}); {AGAIN}") from None

    def __setitem__(self, where: Any, rows: Any) -> None:
        self.array[where] = rows


def seal(about: Mapping[str, Any], arrays: Mapping[str, Any]) -> str:
    """Return a hash of what a group and its arrays say of themselves.

    Args:
        about: attributes of the group; its own seal does not count.
        arrays: of Zarr, by name.
    """
    kinds = {name: one.metadata.to_dict() for name, one in arrays.items()}
    said = {key: value for key, value in about.items() if key != SEAL}
    return sha256(json.dumps([said, kinds], sort_keys=True, default=str).encode()).hexdigest()
