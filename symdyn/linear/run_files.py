"""Runs on disk, as `simulate -o` writes them, read back as states and driving forces over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from zipfile import BadZipFile, ZipFile

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.bounds import BOUNDS
from symdyn.errors import LinearizeError
from symdyn.scene import Scene
from symdyn.simulation import Trajectory
from symdyn.simulation.prescribed.forces import drive_names
from symdyn.simulation.prescribed.numbers_in_time import read_columns


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
    found = read_columns(path)
    return found.t, found.values


def check_arrays(path: Path) -> None:
    """Look how much the arrays of a .npz file are when they are unpacked.

    Raises:
        LinearizeError: more than is read.
        OSError, ValueError: it is no such file.
    """
    most = BOUNDS["bytes of the arrays of a file"]
    try:
        with ZipFile(path) as packed:
            size = sum(one.file_size for one in packed.infolist())
    except BadZipFile as fault:
        raise ValueError(fault) from None
    if size > most:
        raise LinearizeError(f"{path}: holds arrays of {size >> 20} MB; {most >> 20} are the most that is read")


def _npz(path: Path, inputs: Sequence[str]) -> tuple[Array, Mapping[str, Array]]:
    try:
        check_arrays(path)
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: np.asarray(file[name]) for name in ("t", "q", "qd", "tau")}
            names = [str(name) for key in ("coordinates", "velocities") for name in file[key]]
            more = {name: np.asarray(file[name]) for name in inputs if name in file}
    except (OSError, ValueError, KeyError, EOFError) as fault:
        raise LinearizeError(f"{path}: is no run that simulate has written: {fault}") from None
    wide = np.hstack([arrays["q"], arrays["qd"]])
    if wide.shape != (len(arrays["t"]), len(names)) or not np.isfinite(wide).all():
        raise LinearizeError(f"{path}: its rows do not fit its names, or are not finite")
    found = {name: wide[:, k] for k, name in enumerate(names)}
    return arrays["t"], found | more | {f"force {k}": column for k, column in enumerate(arrays["tau"].T)}


READERS = {".csv": _csv, ".npz": _npz}
