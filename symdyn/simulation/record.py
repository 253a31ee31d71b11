"""Trajectories on disk: CSV, NumPy's .npz; and what files may be of plots and of moving pictures."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from symdyn import draw
from symdyn.draw import Reel
from symdyn.emit import Contents, write
from symdyn.errors import DrawError, EmitError, SimulateError
from symdyn.extras import EXTRAS, install

if TYPE_CHECKING:
    from symdyn.simulation.trajectory import Trajectory


def write_npz(trajectory: Trajectory, file: IO[bytes]) -> None:
    """Write t, q, qd, qdd, tau, each extra column by its name, the names of columns, and JSON of how it was made.

    Of runs with 31 digits, `low` is what q and qd are beyond their doubles.
    """
    scene = trajectory.scene
    arrays: dict[str, Any] = {name: getattr(trajectory, name) for name in ("t", "q", "qd", "qdd", "tau")}
    arrays |= dict(trajectory.extra) | ({} if trajectory.low is None else {"low": trajectory.low})
    arrays["coordinates"], arrays["velocities"] = np.array(scene.coordinates), np.array(scene.velocities)
    told = trajectory.about() | {"notes": list(trajectory.notes)}
    arrays["about"] = np.array(json.dumps(told, ensure_ascii=False))
    np.savez_compressed(file, **arrays)


WRITERS: Mapping[str, Callable[[Trajectory], Contents]] = {
    ".csv": lambda trajectory: trajectory.to_csv(),
    ".npz": lambda trajectory: partial(write_npz, trajectory),
}


PLOTS = (".svg", ".pdf", ".png", ".html")


def check_record(path: Path) -> None:
    """Raise SimulateError for an ending that no table has."""
    if path.suffix.lower() not in WRITERS:
        raise SimulateError(f"{path}: trajectories are written to {' or '.join(WRITERS)} files")


def check_film(path: Path, reel: Reel | None = None) -> None:
    """Raise SimulateError for an ending that no moving picture has, or what such a file cannot be."""
    try:
        draw.check_film(path, reel)
    except DrawError as fault:
        raise SimulateError(str(fault)) from None


def check_plot(path: Path | None = None) -> None:
    """Raise SimulateError where a plot cannot be made: an ending that is not known, or no matplotlib.

    Without a path it is shown, and not written.
    """
    if path is not None and path.suffix.lower() not in PLOTS:
        raise SimulateError(f"{path}: plots are written to {', '.join(PLOTS)} files")
    if not EXTRAS["plot"].there:
        raise SimulateError(f"plots need matplotlib; {install('plot')}")


CHECKS: Mapping[str, Callable[..., None]] = {"table": check_record, "plot": check_plot, "film": check_film}
"""What raises SimulateError where a file cannot be a table of a run, a plot or a film, before anything is computed."""


def record(trajectory: Trajectory, path: Path) -> None:
    """Write a trajectory to a .csv or .npz file.

    Raises:
        SimulateError: another ending, or a file that cannot be written.
    """
    check_record(path)
    write_whole(path, WRITERS[path.suffix.lower()](trajectory))


def write_whole(path: Path, contents: Contents) -> None:
    """Write a file, all of it or nothing.

    Raises:
        SimulateError: it cannot be written, and why.
    """
    try:
        write({path.name: contents}, path.parent)
    except EmitError as fault:
        raise SimulateError(str(fault)) from None
