"""A trajectory as a moving picture of its mechanism, in one file."""

from __future__ import annotations

from pathlib import Path
from typing import IO

from symdyn.draw import animation, moving_picture
from symdyn.errors import SimulateError
from symdyn.simulation.record import write_whole
from symdyn.simulation.trajectory import Trajectory

FILMS = {".html": animation, ".svg": moving_picture}


def check_film(path: Path) -> None:
    """Raise SimulateError for an ending that is not known."""
    if path.suffix.lower() not in FILMS:
        raise SimulateError(f"{path}: animations are written to {' or '.join(FILMS)} files")


def film(trajectory: Trajectory, path: Path) -> None:
    """Write the mechanism as it moves.

    Raises:
        SimulateError: an ending that is not known, or a file that cannot be written.
        DrawError: a motion that ends where it is not finite, or no real value at a position.
    """
    check_film(path)
    text = FILMS[path.suffix.lower()](trajectory.scene, trajectory.t, trajectory.q)

    def write(file: IO[bytes]) -> None:
        file.write(text.encode())

    write_whole(path, write)
