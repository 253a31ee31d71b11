"""The functions `sweep`, runs of one scene at many values, and `open`, a sweep that is on disk.

A store is new, or one that goes on, if it is of the same study.
"""

from __future__ import annotations

import json
import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any, Unpack

import numpy as np

from symdyn.arguments import checked, native, with_fields
from symdyn.bounds import BOUNDS
from symdyn.emit import check_folder
from symdyn.errors import SimulateError, StudyError, alike
from symdyn.extras import install
from symdyn.resources import version
from symdyn.scene import SceneLike
from symdyn.scene.values import Faults
from symdyn.simulation import Problem, Run
from symdyn.study.distributions import Over, check_unbound
from symdyn.study.job import Job, Wanted, block as one_block, executor
from symdyn.study.job_of_places import At, places_job
from symdyn.study.job_of_runs import runs_job
from symdyn.study.runs import NOT_MADE, Runs
from symdyn.study.store import ALL_FILES, HASH, HASHED, KINDS, SEAL, SUFFIX, InMemory, OnDisk, Store, seal

FORMAT = "symdyn.study"

FORMAT_VERSION = 4
"""1 had no checksums, 2 none of points, so that a changed store would be read; 3 had `reasons` by another name."""

CODECS = ("bytes", "zstd", "crc32c")
"""What a chunk goes through on its way to the disk."""

META = "zarr.json"
"""Where a group or an array of Zarr says what it is."""

LARGEST_HERE = 5 * 10**8
"""Numbers that a sweep without a store may have; they are held in memory."""


def check_store(path: Path) -> None:
    """Raise StudyError where nothing can be kept: Zarr is missing, no folder, or something else stands there."""
    zarr()
    check_folder(path, StudyError)
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
        differs = "; ".join(
            f"{key} is {_shown(there.get(key))} there, {_shown(here.get(key))} here" for key in keys[:5]
        )
        raise StudyError(f"{path} holds another sweep ({differs}); give another file, or delete this one")
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
            "reasons": {},
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
    """Return the group that stands at a path, and its arrays by name; StudyError where it is no store of a sweep."""
    if not path.exists():
        raise StudyError(f"{path}: there is no such store; symdyn sweep ... -o {path.name} makes one")
    for said in (path / META, *(path / name / META for name in KINDS)):
        if said.exists() and not said.is_file():
            raise StudyError(f"{path} is no sweep of symdyn, or a spoilt one ({said} is no file); give another file")
        if said.exists() and (size := said.stat().st_size) > (most := BOUNDS["bytes of a store's own description"]):
            large = f"{said} has {size >> 20} MB; {most >> 20} are the most that is read"
            raise StudyError(f"{path} is a spoilt sweep ({large}); give another file, or delete this one")
    with _told(path), zarr().config.set(ALL_FILES):
        group = zarr().open_group(zarr().storage.LocalStore(path, read_only=mode == "r"), mode=mode, zarr_format=3)
        about = dict(group.attrs)
        if about.get("format") != FORMAT or not {*KINDS} <= set(group.array_keys()):
            raise StudyError(f"{path} is no sweep of symdyn; give another file")
        if about.get("version") != FORMAT_VERSION:
            raise StudyError(
                f"{path} is a store of another version of symdyn ({_shown(about.get('symdyn'))}), which this "
                "one does not read; give another file, or delete this one"
            )
        arrays = {name: group[name] for name in KINDS}
        if wrong := _wrong(about, arrays):
            raise StudyError(f"{path} is a spoilt sweep ({wrong}); give another file, or delete this one")
        return group, arrays


def _wrong(about: Mapping[str, Any], arrays: Mapping[str, Any]) -> str:
    """Return what in a group does not fit, "" for nothing: it may have been changed, or is none of ours."""
    words = {"names": list, "measures": list, "units": dict, "reasons": dict, "job": dict, "scene": str, "symdyn": str}
    for key, kind in (words | {"scene_toml": str}).items():
        if not isinstance(about.get(key), kind):
            return f"it has no {key}"
    names, measures, units, job = about["names"], about["measures"], about["units"], about["job"]
    if not all(isinstance(one, str) and one.isprintable() for one in (about["scene"], *names, *measures)):
        return "a name is none"
    if names != job.get("names") or not isinstance(job.get("measures"), dict) or measures != list(job["measures"]):
        return "its columns are not those of its job"
    if not all(isinstance(units.get(one), str) for one in (*names, *measures)):
        return "a column has no unit"
    if not all(one.isdecimal() and isinstance(said, str) for one, said in about["reasons"].items()):
        return "a reason why a run failed is no text"
    if sha256(about["scene_toml"].encode()).hexdigest() != job.get("scene_sha256"):
        return "its scene is not the one that its hash is of"
    count, rows = job.get("count"), arrays["codes"].chunks[0]
    if not isinstance(count, int) or not 1 <= rows <= count:
        return "it has no blocks"
    if count > BOUNDS["runs of a sweep"] or count > rows * BOUNDS["blocks of a store"]:
        return f"it claims {count} runs in blocks of {rows}; {BOUNDS['blocks of a store']} blocks are read"
    for name, shapes in _shapes(count, rows, len(names), len(measures)).items():
        array = arrays[name]
        if str(array.dtype) != KINDS[name] or (array.shape, array.chunks) != shapes:
            return f"{name} has another shape or kind of numbers than its job"
        if tuple(one["name"] for one in array.metadata.to_dict()["codecs"]) != CODECS:
            return f"the chunks of {name} have no checksums"
    if about.get(SEAL) != seal(about, arrays):
        return "its description is not the one that was written"
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


INTERRUPTED = "interrupted"

HERE = "here"

USUAL = "inverse_dynamics"
"""What is called where places are given, and no function is."""

Say = Callable[[str], None]


@with_fields(Problem, Run)
def sweep(
    scene: SceneLike | Problem,
    over: Over = (),
    measure: Wanted = (),
    *,
    feedback: object = None,
    design: str | None = None,
    count: int | None = None,
    seed: int = 0,
    output: str | Path | None = None,
    scheduler: Any = "here",
    workers: int | None = None,
    block: int | None = None,
    function: str | None = None,
    at: At = None,
    progress: Callable[[float], None] | None = None,
    say: Say | None = None,
    **fields: Unpack[Run.OfProblem],
) -> Runs:
    """Return what comes of many runs of a scene, or of many calls of one of its functions.

    The values of a run follow from its number and the seed alone, so that blocks, workers and interruptions change
    nothing. A sweep that Ctrl-C interrupts returns what was made; with a store as `output`, the same call goes on.

    >>> import symdyn
    >>> runs = symdyn.sweep(symdyn.example("pendulum"), "q1=linspace(0.1,0.3,3)", "max(abs(q1))", until=0.5)
    >>> runs["q1"].tolist(), len(runs["max(abs(q1))"])
    ([0.1, 0.2, 0.3], 3)

    Args:
        scene: the mechanism; or a `Problem`.
        over: a parameter, a coordinate or velocity at the start, or a symbol in the forces, and its values, such as
            "m1=linspace(1,2,5)"; nothing takes all parameters that have a tolerance. Texts "NAME=DISTRIBUTION" (see
            `symdyn.study.distributions`), or lists by name.
        measure: kept of a run: formulas of max, min, mean, rms, end, ... as "max(abs(tau2))"; "NAME=FORMULA" names one.
            Or functions that take a run of `simulate` and return a number; a mapping names what it has.
        **fields: of `Problem` and `Run`, the same for every run.
        feedback: a controller of all runs, as for `simulate`: gains found at one value, say, at all of them.
        design: which values meet; None takes a grid of lists, random draws of distributions. A key of `DESIGNS`.
        count: how many runs are drawn; None for 1000.
        seed: of what is drawn.
        output: a .zarr store, which is made, or gone on with where it is there.
        scheduler: here, threads, processes, or the address of a Dask scheduler, tcp://HOST:PORT. Or its Client.
        workers: how many of them; None for one a core.
        block: runs of a block, which is done or is not; None for a part of all.
        function: what is called in place of runs, such as "inverse_dynamics"; measures are formulas of what it returns
            and takes, statistics over the points `at` which it is called; `over` may have entries of its arguments.
        at: where, such as "q1=0.3,q1_dot=1"; or a .csv file of such columns over t, a point a line. Formulas
            in parameters by name, or arrays (S,). What is not given is where the scene starts, at rest.
        progress: called with the share that is done.
        say: called with lines for the user.
        forces: driving forces, as for `simulate`; their formulas may have symbols of `over`.
        rtol: relative tolerance of a step; None for 1e-9, of gauss what it takes itself.

    Raises:
        SimulateError: with every fault of the arguments, one line each; a store of another sweep, or a full disk.
        SceneError: values that the scene cannot have.
    """
    problem, run = Problem.requested(sweep, locals())
    count, seed, workers, block = native(int, count, seed, workers, block)
    path = None if output is None else Path(output)
    faults = Faults("")
    if path is not None and path.suffix != SUFFIX:
        faults.add("output", f"{path} is no {SUFFIX} store; leave it out, and write a table with .to_csv(FILE)")
    elif path is not None:
        with faults.noted():
            check_store(path)
    check_unbound(over, fields.get("values"), faults)
    if workers is not None and workers < 1:
        faults.add("workers", f"{workers} is none; give 1 or more")
    if function is not None or at is not None:
        unsaid = {k for k, x in fields.items() if x is None or x is False or (isinstance(x, tuple | list) and not x)}
        of_runs = [name for name in fields if name in vars(run) and name not in unsaid]
        for name in (*problem.given, *of_runs, *(() if feedback is None else ("feedback",))):
            faults.add(name.replace("_", " "), "of runs, and a function has none; leave it out")
        job = places_job(problem.scene, function or USUAL, at, over, measure, design, count, seed, block, faults)
    else:
        job = runs_job(problem, run, over, measure, feedback, design, count, seed, block, faults)
    return made(job, path, block is not None, scheduler, workers, progress, say)


@checked(SimulateError)
def open(path: str | Path) -> Runs:
    """Return a sweep that is on disk, whole or not.

    Raises:
        SimulateError: there is none, or Zarr is not installed.
    """
    return opened(Path(path)).runs()


def made(
    job: Job,
    path: Path | None = None,
    fixed: bool = True,
    scheduler: Any = "here",
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
    say: Say | None = None,
) -> Runs:
    """Return the runs that a job makes, in memory or in a store; `fixed`: a store must have blocks of that size.

    Raises:
        SimulateError: the store is of another sweep or cannot be written, workers or a measure's function fail always.
    """
    say = say or (lambda line: None)
    store, notes = store_of(job, path)
    if store.block != job.block:
        notes += (f"{path} has blocks of {store.block} runs, and goes on with them",) if fixed else ()
        job = replace(job, block=store.block)
    left = store.left()
    if path is not None and len(left) < job.blocks:
        notes += (f"{path}: {job.blocks - len(left)} of {job.blocks} blocks are there already",)
    notes += tuple(f"{path}: {fault}; its block is made again" for fault in left.values() if fault)
    count, kind = job.design.count, job.design.kind
    if kind == "sobol" and count & (count - 1):
        notes += (f"{count} is no power of two, of which Sobol's sequence is most even; {1 << count.bit_length()} is",)
    if kind == "saltelli":
        notes += (f"{count // (len(job.design.over) + 2)} groups, a power of two, of names + 2 runs each",)
    for note in notes:
        say(note)
    began, of_runs = perf_counter(), tuple[str, ...]()
    here = scheduler == HERE if isinstance(scheduler, str) else False
    job = replace(job, threads=workers if here else 1)
    try:
        with executor(scheduler, None if here else workers, say) as found_by:
            for done, (k, found) in enumerate(found_by.results(one_block, job, left), start=1):
                before, of_runs = len(of_runs), alike((*of_runs, *found.notes))
                for note in of_runs[before:]:
                    say(note)
                store.put(job, k, found)
                if progress is not None:
                    progress(1 - (len(left) - done) / job.blocks)
    except KeyboardInterrupt:
        runs = store.runs((*notes, *of_runs), perf_counter() - began)
        how = "the same command goes on with the rest" if path is not None else f"-o FILE{SUFFIX} would have kept it"
        told = f"{INTERRUPTED}: {len(runs) - runs.left} of {len(runs)} runs are there; {how}"
        say(told)
        return replace(runs, notes=(*notes, *of_runs, told))
    runs = store.runs((*notes, *of_runs), perf_counter() - began)
    if runs.failed == len(runs) and runs.reasons.get(0, "").startswith("measure "):
        raise SimulateError(f"all {len(runs)} runs failed; the first: {runs.reasons[0]}")
    return runs
