"""Runs on disk, as `simulate -o` writes them, read back as states and driving forces over time."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np

from symdyn.algebra import Array
from symdyn.bounds import BOUNDS
from symdyn.errors import LinearizeError
from symdyn.scene import Scene
from symdyn.simulation import Trajectory
from symdyn.simulation.prescribed import Columns, drive_names

NUMBERS, NAMES = ("t", "q", "qd", "tau"), ("coordinates", "velocities")
"""Arrays of a .npz file that simulate writes: those of numbers, and those of names."""

WRITTEN, ENDING = (*NUMBERS, *NAMES), ".npy"


def read_run(scene: Scene, path: Path) -> Trajectory:
    """Return the run in a .csv or .npz file: coordinates and velocities of a scene, and its driving forces if told.

    Raises:
        LinearizeError: no such file, another ending, or columns that are not the scene's.
        SimulateError: with every fault of a CSV file.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise LinearizeError(f"{path}: runs are read from {' or '.join(READERS)} files, as simulate -o writes them")
    if not path.is_file():
        raise LinearizeError(f"{path}: there is no such file")
    t, columns = reader(path, [one.name for one in scene.inputs])
    missing = [name for name in (*scene.coordinates, *scene.velocities) if name not in columns]
    if missing:
        raise LinearizeError(
            f"{path}: has no column {', '.join(missing)}; a run of {scene.name} has t, coordinates, velocities, drives"
        )
    still = np.zeros(len(t))
    q = np.stack([columns[name] for name in scene.coordinates], axis=-1)
    u = np.stack([columns[name] for name in scene.velocities], axis=-1)
    forces = (columns.get(f"force {k}", columns.get(name, still)) for k, name in enumerate(drive_names(scene)))
    tau = np.stack(list(forces), axis=-1)
    lacking = [one.name for one in scene.inputs if one.name not in columns]
    if lacking:
        raise LinearizeError(f"{path}: has no column {', '.join(lacking)}, which {scene.name} is given over time")
    given = {one.name: columns[one.name] for one in scene.inputs}
    return Trajectory(scene, t, q, u, np.zeros_like(u), tau, given)


def _csv(path: Path, inputs: Sequence[str]) -> tuple[Array, Mapping[str, Array]]:
    found = Columns.read(path)
    return found.t, found.values


def check_arrays(path: Path, needed: Sequence[str] = ()) -> None:
    """Look at the names and sizes of the arrays of a .npz file before any of them is unpacked.

    Args:
        path: of the file.
        needed: names of arrays that must be there.

    Raises:
        LinearizeError: more than is read.
        OSError, ValueError: it is no such file, lacks an array, or an array says that it has more than is there.
    """
    most = BOUNDS["bytes of the arrays of a file"]
    try:
        with ZipFile(path) as packed:
            inside = {one.filename.removesuffix(ENDING): one for one in packed.infolist()}
            if (size := sum(one.file_size for one in packed.infolist())) > most:
                raise LinearizeError(f"{path}: holds arrays of {size >> 20} MB; {most >> 20} are the most that is read")
            if missing := [name for name in needed if name not in inside]:
                raise ValueError(f"it has no {', '.join(missing)}")
            for name, one in inside.items():
                if one.filename.endswith(ENDING) and _told(packed, one) > one.file_size:
                    raise ValueError(f"{name} says that it has more numbers than are there")
    except (BadZipFile, zlib.error, NotImplementedError, RuntimeError) as fault:
        raise ValueError(fault) from None


def _told(packed: ZipFile, one: ZipInfo) -> int:
    """Return the bytes that an array of a .npz file says it has."""
    with packed.open(one) as file:
        newer = np.lib.format.read_magic(file) != (1, 0)
        read = np.lib.format.read_array_header_2_0 if newer else np.lib.format.read_array_header_1_0
        shape, _, kind = read(file)
    return math.prod(shape) * kind.itemsize


def _npz(path: Path, inputs: Sequence[str]) -> tuple[Array, Mapping[str, Array]]:
    try:
        check_arrays(path, WRITTEN)
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: np.asarray(file[name]) for name in NUMBERS}
            names = [str(name) for key in NAMES for name in file[key]]
            more = {name: np.asarray(file[name]) for name in inputs if name in file}
    except (OSError, ValueError, KeyError, EOFError) as fault:
        raise LinearizeError(f"{path}: is no run that simulate has written: {fault}") from None
    wide = np.hstack([arrays["q"], arrays["qd"]])
    if wide.shape != (len(arrays["t"]), len(names)) or not np.isfinite(wide).all():
        raise LinearizeError(f"{path}: its rows do not fit its names, or are not finite")
    found = {name: wide[:, k] for k, name in enumerate(names)}
    return arrays["t"], found | more | {f"force {k}": column for k, column in enumerate(arrays["tau"].T)}


READERS = {".csv": _csv, ".npz": _npz}
