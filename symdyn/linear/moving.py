"""Modes as motions that can be drawn: q(t) = q₀ moved by Re(a v e^{iφ(t)}), at a size that is seen.

What oscillates goes round once in `MODE_PERIOD`, however fast it is; what does not goes out and comes back. Growth and
decay are left out, and loops are closed at every moment: a shape is shown, and not a run. Positions on which no
velocity depends, as where a bicycle is and where it heads, do not tell the size, and stay where they would go far: the
picture is that of who rides along.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import Reel, Stage, film
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import LinearizeError
from symdyn.linear.modes import Mode, untouched
from symdyn.simulation import CHECKS, opened

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization

MODE_PERIOD, MOMENTS = 2.0, 61
"""Seconds that one round is shown in, and moments of it."""

ANGLE, PART = 0.3, 0.12
"""The largest displacement: of an angle, rad, and of a length over the size of the mechanism."""

FAR = 2.0
"""Times that displacement beyond which a position on which nothing depends stays."""

MOVES = 1e-6
"""Displacements over the largest state of a mode below which nothing is seen to move."""


def motion(one: Linearization, mode: Mode) -> tuple[Array, Array]:
    """Return times, s, shape (N,), and coordinates, shape (N, nq), of one round of a mode.

    Raises:
        LinearizeError: no position that is a state moves in it.
    """
    shape, units = mode.shape[: one.positions], one.states.units[: one.positions]
    if not np.abs(shape).max(initial=0.0) > MOVES * np.abs(mode.shape).max(initial=0.0):
        raise LinearizeError(f"{one.scene.name}: in the mode {mode.value:.6g} only velocities change; it has no shape")
    length = Stage(one.scene, one.point.q[None]).extent
    limits = np.array([ANGLE if unit == "rad" else PART * length for unit in units])
    along = _ridden(one)
    rest = [k for k in range(one.positions) if k not in along and shape[k]] or list(range(one.positions))
    shape = shape / float((np.abs(shape) / limits)[rest].max())
    shape = np.where(np.abs(shape) <= FAR * limits, shape, 0.0)
    turn = np.linspace(0.0, 2 * math.pi, MOMENTS)
    course = np.exp(1j * turn) if mode.oscillates else (1 - np.cos(turn)) / 2
    shifts = np.real(np.outer(course, shape))
    numbers, point = opened(one.scene).numbers(), one.point.q
    labels = COLUMNS["q"](Workspace(one.scene))
    held = [labels.index(name) for name in (*one.states.names[: one.positions], *one.dropped)]
    found = [numbers.newton(numbers.normalised(point + one.moves @ shift), held) for shift in shifts]
    return turn / (2 * math.pi) * MODE_PERIOD, np.array(found)


def _ridden(one: Linearization) -> list[int]:
    """Return positions on which no velocity depends, nor any position but these."""
    found: list[int] = []
    while True:
        rest = [k for k in range(len(one.states)) if k not in found]
        positions = [i for i, k in enumerate(rest) if k < one.positions]
        more = [rest[i] for i in untouched(one.A[np.ix_(rest, rest)], positions)]
        if not more:
            return found
        found += more


def shown(one: Linearization) -> list[Mode]:
    """Return the modes in which something moves."""
    return [mode for mode in one.modes if np.abs(mode.shape[: one.positions]).max(initial=0.0) > MOVES]


def files(one: Linearization, path: Path, reel: Reel | None = None) -> list[tuple[Path, Mode]]:
    """Return the file of every mode that can be shown: the one given, numbered where there are several.

    Raises:
        LinearizeError: nothing moves in any mode.
        SimulateError: an ending that no moving picture has.
    """
    CHECKS["film"](path, reel)
    modes = shown(one)
    if not modes:
        raise LinearizeError(f"{one.scene.name}: --animate: no mode has a shape; all eigenvalues are zero")
    if len(modes) == 1:
        return [(path, modes[0])]
    return [(path.with_name(f"{path.stem}-{k + 1}{path.suffix}"), mode) for k, mode in enumerate(modes)]


def animate_modes(
    one: Linearization, path: Path, reel: Reel | None = None, note: Callable[[str], None] | None = None
) -> Sequence[tuple[Path, Mode]]:
    """Write every mode as a film, of a kind that `symdyn.draw.film` writes, and return which is where.

    `note` takes what is not shown, once.

    Raises:
        LinearizeError, SimulateError: as of `files`.
        DrawError: a file that cannot be written.
    """
    found, shown = files(one, path, reel), reel or Reel()
    for place, mode in found:
        film(one.scene, *motion(one, mode), place, fps=shown.fps, size=shown.size, loop=shown.loop, note=note)
        note = None
    return found
