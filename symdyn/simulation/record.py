"""Trajectories on disk: CSV, NumPy's .npz, and moving pictures of the mechanism in one file."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from symdyn import draw
from symdyn.draw import Reel
from symdyn.emit import Contents, write
from symdyn.errors import DrawError, EmitError, SimulateError

if TYPE_CHECKING:
    from symdyn.draw import Told
    from symdyn.simulation.trajectory import Trajectory


def csv_text(trajectory: Trajectory) -> str:
    """Return the table as CSV: a header, then the shortest digits that read back to the same doubles."""
    return trajectory.to_csv()


def write_npz(trajectory: Trajectory, file: IO[bytes]) -> None:
    """Write t, q, qd, qdd, tau, each extra column by its name, the names of columns, and JSON of how it was made.

    Of runs with 31 digits, `low` is what q and qd are beyond their doubles.
    """
    scene = trajectory.scene
    arrays: dict[str, Any] = {name: getattr(trajectory, name) for name in ("t", "q", "qd", "qdd", "tau")}
    arrays |= dict(trajectory.extra) | ({} if trajectory.low is None else {"low": trajectory.low})
    arrays["coordinates"], arrays["velocities"] = np.array(scene.coordinates), np.array(scene.velocities)
    told = about(trajectory) | {"notes": list(trajectory.notes)}
    arrays["about"] = np.array(json.dumps(told, ensure_ascii=False))
    np.savez_compressed(file, **arrays)


def about(trajectory: Trajectory) -> dict[str, Any]:
    """Return how a trajectory was made, and how well laws were kept, for JSON; the same run, the same text."""
    return {
        "scene": trajectory.scene.name,
        "method": trajectory.method,
        "rtol": trajectory.rtol,
        "atol": trajectory.atol,
        "steps": trajectory.steps,
        "evaluations": trajectory.evaluations,
        "stopped": trajectory.stopped,
        "events": [{"formula": e.formula, "t": e.t, "stops": e.stops} for e in trajectory.events],
        "saturations": [asdict(one) for one in trajectory.saturations],
        "held": list(trajectory.held),
        "monitors": dict(trajectory.monitors),
    }


WRITERS: Mapping[str, Callable[[Trajectory], Contents]] = {
    ".csv": csv_text,
    ".npz": lambda trajectory: partial(write_npz, trajectory),
}


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


def record(trajectory: Trajectory, path: Path) -> None:
    """Write a trajectory to a .csv or .npz file.

    Raises:
        SimulateError: another ending, or a file that cannot be written.
    """
    check_record(path)
    write_whole(path, WRITERS[path.suffix.lower()](trajectory))


def film(
    trajectory: Trajectory,
    path: Path,
    reel: Reel | None = None,
    told: Told | None = None,
    note: Callable[[str], None] | None = None,
) -> None:
    """Write the mechanism as it moves; `told` and `note` as of `symdyn.draw.film`.

    Raises:
        SimulateError: an ending that is not known.
        DrawError: a motion that ends where it is not finite, no real value at a position, or a file that cannot be
            written.
    """
    check_film(path, reel)
    shown = reel or Reel()
    draw.film(
        trajectory.scene, trajectory.t, trajectory.q, path,
        fps=shown.fps, size=shown.size, loop=shown.loop, told=told, note=note,
    )  # fmt: skip


def write_whole(path: Path, contents: Contents) -> None:
    """Write a file, all of it or nothing.

    Raises:
        SimulateError: it cannot be written, and why.
    """
    try:
        write({path.name: contents}, path.parent)
    except EmitError as fault:
        raise SimulateError(str(fault)) from None
