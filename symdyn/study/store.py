"""Where results go, block by block: arrays in memory, or a group of Zarr on disk that a sweep goes on with.

A group has `values` (runs, names), `measures` (runs, measures) and `codes` (runs,), a block a chunk, and says in its
attributes what decides the numbers. A chunk is written aside and renamed, that of `codes` last; a run without a code
was not made, so that a block counts only when all of it is there, whenever a process was killed.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.errors import StudyError
from symdyn.extras import install
from symdyn.resources import version
from symdyn.study.found import Found
from symdyn.study.job import Job, units_of
from symdyn.study.study import MOST_TOLD, NOT_MADE, Study

FORMAT = "symdyn.study"

FORMAT_VERSION = 1

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
        try:
            return NOT_MADE not in codes[first : first + self.block]
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
        measures = Columns(self.group["measures"], tuple(self.about["measures"]))
        told = dict(sorted(self.told.items()))
        return Study(
            self.about["scene"], tuple(self.about["names"]), self.about["units"], _read(self.group["values"]), measures,
            np.asarray(self.group["codes"][:]), told, about, notes, wall,
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


def check_store(path: Path) -> None:
    """Raise StudyError where nothing can be kept: Zarr is missing, no folder, or something else stands there."""
    zarr()
    if not path.parent.is_dir():
        raise StudyError(f"{path}: there is no folder {path.parent}")
    if path.exists():
        _opened(path, "r")


def opened(path: Path) -> OnDisk:
    """Return a store that is there, to be read.

    Raises:
        StudyError: there is none, or it is no store of a sweep.
    """
    return OnDisk(path, _opened(path, "r"))


def store_of(job: Job, path: Path | None) -> tuple[Store, tuple[str, ...]]:
    """Return where the results of a job go, a store that is there already among them, and what to say of it.

    Raises:
        StudyError: a store of other numbers, or one that cannot be made.
    """
    if path is None:
        return InMemory(job), ()
    check_store(path)
    if not path.exists():
        _make(job, path)
        return OnDisk(path, _opened(path, "r+")), ()
    store = OnDisk(path, _opened(path, "r+"))
    there, here = _flat(store.about["job"]), _flat(job.told)
    if there != here:
        keys = [key for key in here | there if here.get(key) != there.get(key)]
        told = "; ".join(f"{key} is {_shown(there.get(key))} there, {_shown(here.get(key))} here" for key in keys[:5])
        raise StudyError(f"{path} holds another sweep ({told}); give another file, or delete this one")
    notes = []
    if store.about["symdyn"] != version():
        notes.append(f"{path} was begun by symdyn {store.about['symdyn']}; this is {version()}")
    return store, tuple(notes)


def _make(job: Job, path: Path) -> None:
    """Make an empty store aside, and rename it: one that is there is whole."""
    count = job.design.count
    aside = None
    try:
        aside = Path(tempfile.mkdtemp(prefix=".symdyn-", dir=path.parent))
        group = zarr().create_group(str(aside / path.name))
        rows = min(job.block, count)
        for name, shape, kind, fill in (
            ("values", (count, len(job.design.names)), "f8", np.nan),
            ("measures", (count, len(job.measures)), "f8", np.nan),
            ("codes", (count,), "u1", NOT_MADE),
        ):
            group.create_array(name, shape=shape, chunks=(rows, *shape[1:]), dtype=kind, fill_value=fill)
        group.attrs.update(
            {
                "format": FORMAT,
                "version": FORMAT_VERSION,
                "symdyn": version(),
                "scene": job.scene.name,
                "scene_toml": job.scene_text,
                "names": list(job.design.names),
                "measures": [one.name for one in job.measures],
                "units": units_of(job),
                "job": json.loads(json.dumps(job.told)),
                "told": {},
            }
        )
        (aside / path.name).rename(path)
    except OSError as fault:
        raise StudyError(f"{path}: cannot write there ({fault.strerror or fault}); give another file") from None
    finally:
        if aside is not None:
            shutil.rmtree(aside, ignore_errors=True)


def _opened(path: Path, mode: str) -> Any:
    """Return the group that stands at a path.

    Raises:
        StudyError: there is none, or it is no store of a sweep.
    """
    if not path.exists():
        raise StudyError(f"{path}: there is no such store; symdyn sweep ... -o {path.name} makes one")
    with _told(path):
        group = zarr().open_group(str(path), mode=mode)
        about = dict(group.attrs)
        if about.get("format") != FORMAT or not {"values", "measures", "codes"} <= set(group.array_keys()):
            raise StudyError(f"{path} is no sweep of symdyn; give another file")
        if about.get("version") != FORMAT_VERSION:
            raise StudyError(f"{path} is of another version of symdyn ({about.get('symdyn')}); read it with that one")
        return group


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Say of whatever Zarr finds wrong that it is no store."""
    try:
        yield
    except StudyError:
        raise
    except Exception as fault:  # of many kinds, by what is wrong with which file
        raise StudyError(f"{path} is no sweep of symdyn, or a spoilt one ({fault}); give another file") from None


def _flat(told: Mapping[str, Any], front: str = "") -> dict[str, Any]:
    """Return nested tables as one, for messages."""
    found: dict[str, Any] = {}
    for key, value in told.items():
        if isinstance(value, Mapping):
            found |= _flat(value, f"{front}{key} ")
        else:
            found[f"{front}{key}"] = value
    return found


def _shown(value: object) -> str:
    text = "not given" if value is None else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def zarr() -> Any:
    """Return the package.

    Raises:
        StudyError: it is not installed.
    """
    try:
        import zarr as found
    except ImportError:
        raise StudyError(f"keeping a sweep in a {SUFFIX} store needs zarr; {install('sweep')}") from None
    return found
