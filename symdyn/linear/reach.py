"""Which modes inputs move and outputs show: a staircase for the ranks, and the test of Popov, Belevitch and Hautus.

    V, W     orthonormal: [V W]ᵀ A [V W] = [A_v *; 0 A_w], [V W]ᵀ B = [B_v; 0]; what B reaches, and what is left
    σ(λ)     the smallest singular value of [A_v - λ, B_v]: how far the mode of λ is from one that no input moves

States have different units: A is balanced, D⁻¹ A D, and B and C are scaled to the size of A, before sizes are compared.
Of observability all is the same with Aᵀ and Cᵀ.

Reference: Van Dooren, The generalized eigenstructure problem in linear system theory, IEEE Trans. Aut. Control 26
(1981); Eising, Between controllable and uncontrollable, Systems & Control Letters 4 (1984), for σ.

Runs on disk, as `simulate -o` writes them, read back as states and driving forces over time.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np

from symdyn.algebra import Array
from symdyn.bounds import BOUNDS
from symdyn.errors import LinearizeError
from symdyn.linear.modes import balance, pairs_of, spectrum
from symdyn.rounding import in_digits
from symdyn.scene import Scene
from symdyn.simulation import Trajectory
from symdyn.simulation.prescribed import Columns, drive_names

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization


NOTHING = 1e-9
"""Singular values over the size of the balanced A below which nothing is reached."""

SAID, NAMED = 0.1, 4
"""Parts of a mode, of the largest, that are named, and how many at most."""


@dataclass(frozen=True)
class Mark:
    """How far the mode of an eigenvalue is from being hidden.

    Attributes:
        value: eigenvalue, 1/s.
        margin: σ(λ) over the size of A, on what is reached; 0 of a mode that is hidden.
        states: names of the states that take part most in what no input moves, or no output shows.
    """

    value: complex
    margin: float
    states: tuple[str, ...]

    @property
    def hidden(self) -> bool:
        """Whether no input moves it, or no output shows it."""
        return self.margin == 0.0


@dataclass(frozen=True)
class Reach:
    """What all inputs together move, or all outputs together show.

    Attributes:
        rank: of how many states.
        order: how many states there are.
        marks: one an eigenvalue, those that are zero as one, nearest to hidden first.
    """

    rank: int
    order: int
    marks: tuple[Mark, ...]

    @property
    def margin(self) -> float:
        """How far the rank is from being less: the least margin of what is not hidden; 0 of a rank of zero."""
        return min((one.margin for one in self.marks if not one.hidden), default=0.0)

    @property
    def hidden(self) -> tuple[Mark, ...]:
        """Modes that no input moves, or no output shows."""
        return tuple(one for one in self.marks if one.hidden)

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON."""
        marks = [
            {"eigenvalue": pairs_of([m.value])[0], "margin": m.margin, "hidden": m.hidden, "states": list(m.states)}
            for m in self.marks
        ]
        return {"rank": self.rank, "order": self.order, "margin": self.margin, "modes": marks}


def controllability(one: Linearization) -> Reach:
    """Return what the inputs move."""
    A, B, _, _ = balanced(one)
    return _reach(A, B, one.states.names)


def observability(one: Linearization) -> Reach:
    """Return what the outputs show."""
    A, _, C, _ = balanced(one)
    return _reach(A.T, C.T, one.states.names)


def _reach(A: Array, B: Array, names: tuple[str, ...]) -> Reach:
    size, B = float(np.linalg.norm(A, 2)) or 1.0, alike(A, B)
    V, W = staircase(A, B)
    marks = [Mark(value, 0.0, states) for value, _, states in _least(A, B[:, :0], W, names, size)]
    marks += [Mark(*one) for one in _least(A, B, V, names, size)]
    return Reach(V.shape[1], len(A), tuple(sorted(marks, key=lambda mark: mark.margin)))


def _least(
    A: Array, B: Array, space: Array, names: tuple[str, ...], size: float
) -> list[tuple[complex, float, tuple[str, ...]]]:
    """Return the eigenvalues in a space, σ of [A - λ, B] there over the size of A, and who takes part in it most."""
    part, way = space.T @ A @ space, space.T @ B
    found = spectrum(part, size)
    told = []
    for value in [*(mode.value for mode in found.modes), *([0j] if found.zeros else [])]:
        rows, sizes, _ = np.linalg.svd(np.hstack([part - value * np.eye(len(part)), way]))
        many = max(1, int(np.sum(sizes <= NOTHING * size)))
        share = np.linalg.norm(space @ rows[:, -many:], axis=1)
        most = [k for k in np.argsort(-share, kind="stable") if share[k] > SAID * share.max()]
        told.append((value, float(sizes[-1]) / size, tuple(names[k] for k in most[:NAMED])))
    return told


def balanced(one: Linearization) -> tuple[Array, Array, Array, Array]:
    """Return D⁻¹ A D, D⁻¹ B, C D and the diagonal of D."""
    scale = balance(one.A)
    return one.A * scale[None, :] / scale[:, None], one.B / scale[:, None], one.C * scale[None, :], scale


def alike(A: Array, B: Array) -> Array:
    """Return B with columns as long as A is large, those that are zero left out of it."""
    lengths = np.linalg.norm(B, axis=0)
    return np.asarray(B * ((float(np.linalg.norm(A, 2)) or 1.0) / np.where(lengths > 0, lengths, 1.0)))


def staircase(A: Array, B: Array) -> tuple[Array, Array]:
    """Return V, shape (n, rank), and W: what B reaches of balanced states, and what is beside it."""
    size = float(np.linalg.norm(A, 2)) or 1.0
    n, V, step = len(A), np.zeros((len(A), 0)), alike(A, B)
    while V.shape[1] < n and step.shape[1]:
        step = step - V @ (V.T @ step)
        rows, sizes, _ = np.linalg.svd(step, full_matrices=False)
        fresh = rows[:, sizes > NOTHING * size]
        fresh = fresh - V @ (V.T @ fresh)
        fresh = np.linalg.qr(fresh)[0] if fresh.shape[1] else fresh
        V, step = np.hstack([V, fresh]), A @ fresh
    W = np.linalg.svd(V, full_matrices=True)[0][:, V.shape[1] :] if V.shape[1] else np.eye(n)
    return V, W


def minimal(A: Array, B: Array, C: Array) -> tuple[Array, Array, Array]:
    """Return A, B, C on the states that B reaches and C shows; all of balanced states."""
    V, _ = staircase(A, B)
    A, B, C = V.T @ A @ V, V.T @ B, C @ V
    V, _ = staircase(A.T, C.T)
    return V.T @ A @ V, V.T @ B, C @ V


def shown(value: complex) -> str:
    """Return an eigenvalue, pole or zero as text: a pair once."""
    x, y = float(value.real), float(value.imag)
    if y == 0:
        return in_digits(x, 6)
    return f"{in_digits(x, 6)} ± {in_digits(abs(y), 6)}i" if abs(x) > NOTHING * abs(y) else f"±{in_digits(abs(y), 6)}i"


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
