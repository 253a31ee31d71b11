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
from hashlib import sha256
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

LARGEST_HERE = 5 * 10**8
"""Numbers that a sweep without a store may have; they are held in memory."""

KINDS = {"values": "float64", "measures": "float64", "codes": "uint8"}
"""Arrays of a group, and what they are made of: plain numbers alone, so that nothing read from a disk is executed."""


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
        count, columns = job.design.count, len(job.design.names) + len(job.measures)
        if count * columns > LARGEST_HERE:
            raise StudyError(
                f"{count} runs of {columns} columns do not fit into memory; keep them on disk, -o FILE{SUFFIX}"
            )
        return InMemory(job), ()
    check_store(path)
    if not path.exists():
        _make(job, path)
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
        group = zarr().create_group(zarr().storage.LocalStore(aside / path.name))
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
        if not path.exists():  # else another process made it in the meantime
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
        group = zarr().open_group(zarr().storage.LocalStore(path, read_only=mode == "r"), mode=mode, zarr_format=3)
        about = dict(group.attrs)
        if about.get("format") != FORMAT or not {*KINDS} <= set(group.array_keys()):
            raise StudyError(f"{path} is no sweep of symdyn; give another file")
        if about.get("version") != FORMAT_VERSION:
            raise StudyError(f"{path} is of another version of symdyn ({about.get('symdyn')}); read it with that one")
        if wrong := _wrong(about, group):
            raise StudyError(f"{path} is a spoilt sweep ({wrong}); give another file, or delete this one")
        return group


def _wrong(about: Mapping[str, Any], group: Any) -> str:
    """Return what in a group does not fit, "" for nothing: somebody may have changed it, or it is none of ours."""
    words = {"names": list, "measures": list, "units": dict, "told": dict, "job": dict, "scene": str, "symdyn": str}
    for key, kind in (words | {"scene_toml": str}).items():
        if not isinstance(about.get(key), kind):
            return f"it does not say {key}"
    names, measures, units, job = about["names"], about["measures"], about["units"], about["job"]
    if not all(isinstance(one, str) and one.isprintable() for one in (about["scene"], *names, *measures)):
        return "a name is none"
    if names != job.get("names") or not isinstance(job.get("measures"), dict) or measures != list(job["measures"]):
        return "its columns are not those of its job"
    if not all(isinstance(units.get(one), str) for one in (*names, *measures)):
        return "a column has no unit"
    if not all(one.isdecimal() and isinstance(said, str) for one, said in about["told"].items()):
        return "what it tells of runs is no text"
    if sha256(about["scene_toml"].encode()).hexdigest() != job.get("scene_sha256"):
        return "its scene is not the one that its hash is of"
    count, rows = job.get("count"), group["codes"].chunks[0]
    if not isinstance(count, int) or not 1 <= rows <= count:
        return "it has no blocks"
    for name, numbers in KINDS.items():
        array, columns = group[name], {"values": (len(names),), "measures": (len(measures),)}.get(name, ())
        if str(array.dtype) != numbers or array.shape != (count, *columns) or array.chunks != (rows, *columns):
            return f"{name} has another shape or kind of numbers than its job"
    return ""


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
