"""Where a study is kept: a new store, or one that goes on, if it is of the same study."""

from __future__ import annotations

import json
import shutil
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.bounds import BOUNDS
from symdyn.errors import StudyError
from symdyn.extras import install
from symdyn.resources import version
from symdyn.study.job import Job
from symdyn.study.runs import NOT_MADE
from symdyn.study.store import ALL_FILES, HASH, HASHED, KINDS, SEAL, SUFFIX, InMemory, OnDisk, Store, seal

FORMAT = "symdyn.study"


FORMAT_VERSION = 3
"""1 had no checksums, and 2 none of places, so that nobody knows whether what is in it is what was put."""

CODECS = ("bytes", "zstd", "crc32c")
"""What a chunk goes through on its way to the disk."""

META = "zarr.json"
"""Where a group or an array of Zarr says what it is."""

LARGEST_HERE = 5 * 10**8
"""Numbers that a sweep without a store may have; they are held in memory."""


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
    return OnDisk(path, *_opened(path, "r"))


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
    if job.blocks > (most := BOUNDS["blocks of a store"]):
        found = f"{job.design.count} runs are {job.blocks} blocks"
        raise StudyError(f"{path}: {found}; {most} are the most that is kept: give a larger block")
    if not path.exists():
        _make(job, path)
    store = OnDisk(path, *_opened(path, "r+"))
    there, here = _flat(store.about["job"]), _flat(job.identity)
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
        codecs = zarr().codecs
        rows, packed = min(job.block, count), (codecs.ZstdCodec(), codecs.Crc32cCodec())
        shapes = _shapes(count, rows, len(job.design.names), len(job.measures))
        for name, (shape, chunk) in shapes.items():
            fill = np.nan if KINDS[name] == "float64" else NOT_MADE
            group.create_array(name, shape=shape, chunks=chunk, dtype=KINDS[name], fill_value=fill, compressors=packed)
        about = {
            "format": FORMAT,
            "version": FORMAT_VERSION,
            "symdyn": version(),
            "scene": job.scene.name,
            "scene_toml": job.scene_text,
            "names": list(job.design.names),
            "measures": [one.name for one in job.measures],
            "units": job.units,
            "job": json.loads(json.dumps(job.identity)),
            "told": {},
        }
        group.attrs.update(about | {SEAL: seal(about, {name: group[name] for name in KINDS})})
        (aside / path.name).rename(path)
    except OSError as fault:
        if not path.exists():  # else another process made it in the meantime
            raise StudyError(f"{path}: cannot write there ({fault.strerror or fault}); give another file") from None
    finally:
        if aside is not None:
            shutil.rmtree(aside, ignore_errors=True)


def _shapes(count: int, rows: int, names: int, measures: int) -> dict[str, tuple[tuple[int, ...], tuple[int, ...]]]:
    """Return the shape of every array of so many runs in blocks of so many, and that of its chunks."""
    columns = {"values": (names,), "measures": (measures,), "codes": ()}
    found = {name: ((count, *more), (rows, *more)) for name, more in columns.items()}
    width = HASH * len(HASHED)
    return found | {"hashes": ((-(-count // rows), width), (1, width))}


def _opened(path: Path, mode: str) -> tuple[Any, dict[str, Any]]:
    """Return the group that stands at a path, and its arrays by name.

    Raises:
        StudyError: there is none, or it is no store of a sweep.
    """
    if not path.exists():
        raise StudyError(f"{path}: there is no such store; symdyn sweep ... -o {path.name} makes one")
    for said in (path / META, *(path / name / META for name in KINDS)):
        if said.exists() and not said.is_file():
            raise StudyError(f"{path} is no sweep of symdyn, or a spoilt one ({said} is no file); give another file")
        if said.exists() and (size := said.stat().st_size) > (most := BOUNDS["bytes of a store's own description"]):
            told = f"{said} has {size >> 20} MB; {most >> 20} are the most that is read"
            raise StudyError(f"{path} is a spoilt sweep ({told}); give another file, or delete this one")
    with _told(path), zarr().config.set(ALL_FILES):
        group = zarr().open_group(zarr().storage.LocalStore(path, read_only=mode == "r"), mode=mode, zarr_format=3)
        about = dict(group.attrs)
        if about.get("format") != FORMAT or not {*KINDS} <= set(group.array_keys()):
            raise StudyError(f"{path} is no sweep of symdyn; give another file")
        if about.get("version") != FORMAT_VERSION:
            raise StudyError(
                f"{path} is a store of another version of symdyn ({_shown(about.get('symdyn'))}); stores of before "
                "have no checksums of blocks, and nobody knows whether they are whole; give another file, or delete "
                "this one"
            )
        arrays = {name: group[name] for name in KINDS}
        if wrong := _wrong(about, arrays):
            raise StudyError(f"{path} is a spoilt sweep ({wrong}); give another file, or delete this one")
        return group, arrays


def _wrong(about: Mapping[str, Any], arrays: Mapping[str, Any]) -> str:
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
    count, rows = job.get("count"), arrays["codes"].chunks[0]
    if not isinstance(count, int) or not 1 <= rows <= count:
        return "it has no blocks"
    if count > BOUNDS["runs of a sweep"] or count > rows * BOUNDS["blocks of a store"]:
        return f"it says that it has {count} runs in blocks of {rows}; {BOUNDS['blocks of a store']} blocks are read"
    for name, shapes in _shapes(count, rows, len(names), len(measures)).items():
        array = arrays[name]
        if str(array.dtype) != KINDS[name] or (array.shape, array.chunks) != shapes:
            return f"{name} has another shape or kind of numbers than its job"
        if tuple(one["name"] for one in array.metadata.to_dict()["codecs"]) != CODECS:
            return f"the chunks of {name} have no checksums"
    if about.get(SEAL) != seal(about, arrays):
        return "what it says of itself is not what was written"
    return ""


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Say of whatever Zarr finds wrong that it is no store."""
    try:
        with warnings.catch_warnings(action="ignore"):  # of files that it does not know; what is missing is said here
            yield
    except StudyError:
        raise
    except Exception as fault:  # of many kinds, by what is wrong with which file
        raise StudyError(f"{path} is no sweep of symdyn, or a spoilt one ({fault}); give another file") from None


def _flat(reported: Mapping[str, Any], front: str = "") -> dict[str, Any]:
    """Return nested tables as one, for messages."""
    found: dict[str, Any] = {}
    for key, value in reported.items():
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
