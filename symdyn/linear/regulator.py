"""Gains from weights: the linear quadratic regulator, and by the dual equation the gain of a Kalman filter.

    w = w0 - K x       least ∫ xᵀ Q x + (w - w0)ᵀ R (w - w0) dt; sampled: the least sum over samples, inputs held
    A - B K            the closed loop
    x̂' = A x̂ + B w + L (y - C x̂)      K = Lᵀ of (Aᵀ, Cᵀ), with covariances W of what disturbs x and V of what disturbs y

Users give weights and variances by name or as matrices, whose rows and columns have names and units (`Axis`).

What is weighted and does not decay by itself must be moved by some input. What stays or swings for ever and has no
weight, such as the place of a wheel on the ground, is left alone, and a note says so.

Reference: Anderson and Moore, Optimal Control: Linear Quadratic Methods (1990), sections 2.3, 3.3 and 8.1.
"""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np

from symdyn.algebra import Array
from symdyn.bounds import BOUNDS
from symdyn.errors import LinearizeError
from symdyn.linear.evolution import sampled
from symdyn.linear.locus import number_in
from symdyn.linear.modes import SIDEWAYS, Complexes, balance, pairs_of, spectrum
from symdyn.linear.transfer import shown, staircase
from symdyn.scene.values import Faults, FormulaError, suggestion

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization


@dataclass(frozen=True)
class Axis:
    """What the rows or columns of a matrix stand for, and their units."""

    names: tuple[str, ...]
    units: tuple[str, ...]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.names)

    def of(self, places: Sequence[int]) -> Axis:
        """Return some of them."""
        return Axis(tuple(self.names[k] for k in places), tuple(self.units[k] for k in places))


Weights: TypeAlias = Mapping[str, float] | Sequence[Sequence[float]] | Array

SYMMETRIC = 1e-9
"""Differences from symmetry, and eigenvalues below zero, over the largest entry of a weight, that are rounding."""


def read_weights(option: str, specified: Sequence[str], names: Sequence[str]) -> dict[str, Any]:
    """Return weights by name of `Q=x:10;theta:100`, numbers being formulas, or of an .npz file.

    Raises:
        LinearizeError: with every fault.
    """
    faults, found = Faults(""), dict[str, Any]()
    for text in specified:
        if text.lower().endswith(".npz"):
            found |= _arrays(text, names, faults)
            continue
        name, equals, rest = (part.strip() for part in text.partition("="))
        if not equals or name not in names:
            faults.add(option, f'"{text}" is no {names[0]}=NAME:1;NAME:2, no {names[1]}=... and no .npz file')
            continue
        if name in found:
            faults.add(option, f"{name} is given twice")
        found[name] = {}
        for part in filter(None, (one.strip() for one in rest.split(";"))):
            key, colon, value = (one.strip() for one in part.rpartition(":"))
            if not colon:
                faults.add(option, f'{name}: "{part}" has no weight; write {part}:1')
                continue
            if key in found[name]:
                faults.add(option, f"{name}: {key} is named twice")
            try:
                found[name][key] = number_in(value)
            except FormulaError as error:
                faults.add(option, f"{name}: {key}: {error}")
    faults.close(LinearizeError)
    return found


def _arrays(name: str, requested: Sequence[str], faults: Faults) -> dict[str, Any]:
    try:
        check_arrays(Path(name))
        with np.load(name, allow_pickle=False) as said:
            found = {key: value for key, value in said.items() if key in requested}
    except (OSError, ValueError, KeyError, EOFError) as error:
        faults.add(name, f"cannot be read as .npz: {error}")
        return {}
    if not found:
        faults.add(name, f"has no array {' or '.join(requested)}")
    return found


ENDING = ".npy"
"""Of the arrays in a .npz file."""


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


def weight(name: str, given: Weights | None, axis: Axis, faults: Faults, definite: bool = False) -> Array:
    """Return a weight as a symmetric matrix; what is wrong with it goes to the faults."""
    n = len(axis)
    if given is None:
        return np.eye(n)
    if isinstance(given, Mapping):
        found = np.zeros(n)
        for key, value in given.items():
            if key not in axis.names:
                faults.add(name, f"{key} is not known; {suggestion(key, axis.names)}")
            elif not np.isfinite(value) or value < 0 or (definite and value == 0):
                faults.add(
                    name, f"{key}: {value:g} is no weight; give one {'above zero' if definite else 'of 0 or more'}"
                )
            else:
                found[axis.names.index(key)] = value
        if definite:
            found = np.where([one in given for one in axis.names], found, 1.0)
        return np.diag(found)
    try:
        M = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        M = np.zeros(0)
    largest = float(np.abs(M).max(initial=0.0))
    if M.shape != (n, n) or not np.isfinite(M).all():
        faults.add(name, f"is no matrix of {n} x {n} finite numbers, for {', '.join(axis.names)}")
        return np.eye(n)
    if np.abs(M - M.T).max(initial=0.0) > SYMMETRIC * largest:
        faults.add(name, "is not symmetric")
    sizes, ways = np.linalg.eigh((M + M.T) / 2)
    if n and (sizes[0] < -SYMMETRIC * largest or (definite and sizes[0] <= SYMMETRIC * largest)):
        kind, most = "definite" if definite else "semidefinite", axis.names[int(np.abs(ways[:, 0]).argmax())]
        faults.add(name, f"is not positive {kind}: it has the eigenvalue {sizes[0]:.6g}, mostly of {most}")
    return np.asarray((M + M.T) / 2)


FEEDING = "the formulas of --forces depend on the state: gains act beside them, give them to simulate, too"
MOVING = "the point is neither of rest nor of a steady motion: nothing holds the mechanism there, gains neither"
SPINNING = (
    "states and drives along axes of a body are in axes that do not spin with it: a controller has to turn them; "
    "simulate reads gains in axes of the body, at one orientation of it"
)
"""What is said of gains beside forces that feed back, at a point where velocities change, and in axes that turn."""


@dataclass(frozen=True)
class Regulator:
    """Feedback of the state.

    Attributes:
        system: what it was found for.
        inputs: the drives, which it acts by; all inputs of a scene without any.
        K: shape (inputs, nx).
        poles: eigenvalues of the closed loop, 1/s; of a sampled one those of Φ - Γ K.
        period: seconds between samples; None is none.
        notes: what a user should know.
    """

    system: Linearization
    inputs: tuple[str, ...]
    K: Array
    poles: Complexes
    period: float | None = None
    notes: tuple[str, ...] = ()

    def gains(self) -> dict[str, object]:
        """Return what `symdyn simulate --feedback` reads."""
        one = self.system
        names = [*map(str, one.scene.drives), *(letter.name for letter in one.scene.inputs)]
        point = dict(zip(one.scene.coordinates, one.point.q.tolist(), strict=True))
        point |= dict(zip(one.scene.velocities, one.point.u.tolist(), strict=True))
        held = np.concatenate([one.point.tau, one.point.inputs]) - (one.feeding or 0.0)
        found: dict[str, object] = {
            "K": self.K.tolist(),
            "states": list(one.states.names),
            "inputs": list(self.inputs),
            "x0": point,
            "u0": {name: float(held[names.index(name)]) for name in self.inputs},
        }
        return found if self.period is None else found | {"period": self.period}

    def text(self) -> str:
        """Return the gains as JSON text, a row of K a line."""
        said = {name: json.dumps(value, allow_nan=False) for name, value in self.gains().items()}
        rows = ",\n    ".join(json.dumps(row) for row in self.K.tolist())
        said["K"] = f"[\n    {rows}\n  ]"
        return "{\n" + ",\n".join(f'  "{name}": {value}' for name, value in said.items()) + "\n}\n"

    def lines(self) -> list[str]:
        """Return a formula in deviations of the states for each input, one line each."""
        return [f"{name} = {self._terms(row)}" for name, row in zip(self.inputs, self.K, strict=True)]

    def _terms(self, row: Array) -> str:
        parts = [f"{-x:+.6g} {name}" for x, name in zip(row, self.system.states.names, strict=True) if abs(x) > 1e-12]
        return " ".join(parts).replace("+", "+ ").replace("-", "- ").replace("e- ", "e-").replace("e+ ", "e+") or "0"

    def as_json(self) -> dict[str, object]:
        """Return it for JSON, poles and notes beside the gains."""
        return self.gains() | {"poles": pairs_of(self.poles), "notes": list(self.notes)}


@dataclass(frozen=True)
class Observer:
    """The gain of a Kalman filter, L, shape (nx, ny), and the poles of A - L C; of a sampled one of Φ - L C."""

    system: Linearization
    L: Array
    poles: Complexes
    period: float | None = None
    notes: tuple[str, ...] = ()

    def as_json(self) -> dict[str, object]:
        """Return it for JSON."""
        return {
            "L": self.L.tolist(), "states": list(self.system.states.names),
            "outputs": list(self.system.outputs.names), "poles": pairs_of(self.poles),
        }  # fmt: skip


def lqr(
    one: Linearization, Q: Weights | None = None, R: Weights | None = None, period: float | None = None
) -> Regulator:
    """Return the linear quadratic regulator of a system.

    Args:
        one: the system.
        Q: weights of states by name, others 0, or a matrix, shape (nx, nx), positive semidefinite; 1 each without.
        R: of drives likewise, positive definite, others 1; other inputs are no controls where there are drives.
        period: seconds between samples, for gains of a sampled controller.

    Raises:
        LinearizeError: with every fault: a name that is not known, a weight that is none; a mode that is weighed,
            does not decay, and that no input moves.
    """
    if not one.inputs.names:
        raise LinearizeError(f"{one.scene.name}: nothing drives it; declare a drive, or an input: [inputs.u]")
    drives = [k for k, name in enumerate(one.inputs.names) if name in one.scene.drives]
    used = drives or list(range(len(one.inputs)))
    inputs = one.inputs.of(used)
    faults = Faults("")
    heavy = weight("Q", Q, one.states, faults)
    light = weight("R", R, inputs, faults, definite=True)
    _close(faults)
    A, B = _steps(one, period)
    K, poles, notes = _gain(one.A, one.B[:, used], A, B[:, used], heavy, light, period, WORDS["lqr"], one.states.names)
    if one.feeding:
        notes = (*notes, FEEDING)
    if one.kind == "moving":
        notes = (*notes, MOVING)
    if one.spin.any():
        notes = (*notes, SPINNING)
    return Regulator(one, inputs.names, K, poles, period, notes)


def kalman(
    one: Linearization, W: Weights | None = None, V: Weights | None = None, period: float | None = None
) -> Observer:
    """Return the gain of the Kalman filter of a system, a predictor where it is sampled.

    Args:
        one: the system.
        W: variances of what disturbs the rates of states by name, or inputs, by which they come in; others 0; or a
            matrix, shape (nx, nx); 1 for each input, or each state where there is no input, without.
        V: variances of outputs by name, which must be above zero, or a matrix, shape (ny, ny); 1 each without.
        period: seconds between samples.

    Raises:
        LinearizeError: with every fault, as of `lqr`: a mode that does not decay and that no output shows.
    """
    faults = Faults("")
    A, B = _steps(one, period)
    disturbed = _disturbed(W, one, B, faults)
    noise = weight("V", V, one.outputs, faults, definite=True)
    _close(faults)
    K, poles, notes = _gain(one.A.T, one.C.T, A.T, one.C.T, disturbed, noise, period, WORDS["kalman"], one.states.names)
    return Observer(one, K.T, poles, period, notes)


def _steps(one: Linearization, period: float | None) -> tuple[Array, Array]:
    if period is None:
        return one.A, one.B
    found = sampled(one, period)
    return found.A, found.B


def _disturbed(W: Weights | None, one: Linearization, B: Array, faults: Faults) -> Array:
    if not isinstance(W, Mapping):
        if W is None and one.inputs.names:
            return B @ B.T
        return weight("W", W, one.states, faults)
    names = (*one.states.names, *one.inputs.names)
    both = weight("W", W, Axis(names, ("",) * len(names)), faults)
    n = len(one.states)
    return both[:n, :n] + B @ both[n:, n:] @ B.T


@dataclass(frozen=True)
class RegulatorWords:
    """How faults speak: the weight of what is minimised, what it lacks, and how a mode is out of reach."""

    weight: str
    forgets: str
    beyond: str


WORDS = {
    "lqr": RegulatorWords("Q", "gives no weight to", "no input moves"),
    "kalman": RegulatorWords("W", "lets nothing disturb", "no output shows"),
}


def _gain(
    A: Array, B: Array, step: Array, held: Array, Q: Array, R: Array, period: float | None,
    words: RegulatorWords, names: tuple[str, ...],
) -> tuple[Array, Complexes, tuple[str, ...]]:  # fmt: skip
    """Return K, the poles, and notes; `step` and `held` are A and B, or those of a sampled system."""
    from scipy.linalg import solve_continuous_are, solve_discrete_are  # late: it takes long to load

    scale = balance(A)
    A, B, Q = A * scale[None, :] / scale[:, None], B / scale[:, None], Q * scale[None, :] * scale[:, None]
    step, held = step * scale[None, :] / scale[:, None], held / scale[:, None]
    size = float(np.linalg.norm(A, 2)) or 1.0
    seen, unseen = staircase(A.T, Q)
    basis, notes = np.eye(len(A)), tuple[str, ...]()
    drifting = _lasting(unseen.T @ A @ unseen, size)
    if any(value.real <= SIDEWAYS * size for value in drifting):
        if drifting[0].real > SIDEWAYS * size:
            raise LinearizeError(
                f"{words.weight} {words.forgets} the mode {shown(drifting[0])}, of {_named(unseen, names)}, which "
                "grows; name those there"
            )
        basis, notes = seen, (f"left alone: {_named(unseen, names)}; {words.weight} {words.forgets} them",)
    if not basis.shape[1]:
        raise LinearizeError(f"{words.weight} {words.forgets} anything that has to be; give weights by name")
    part, way = basis.T @ A @ basis, basis.T @ B
    beside = staircase(part, way)[1]
    stuck = _lasting(beside.T @ part @ beside, size)
    if stuck:
        raise LinearizeError(
            f"{words.beyond} the mode {shown(stuck[0])}, of {_named(basis @ beside, names)}, and it does not decay; "
            f"leave those out of {words.weight}, or let something reach them"
        )
    part, way, cost = basis.T @ step @ basis, basis.T @ held, basis.T @ Q @ basis
    try:
        P = (solve_continuous_are if period is None else solve_discrete_are)(part, way, (cost + cost.T) / 2, R)
        light, heavy = (R, way.T @ P) if period is None else (R + way.T @ P @ way, way.T @ P @ part)
        K = np.linalg.solve(light, heavy)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise LinearizeError(f"the Riccati equation has no solution that stabilises: {error}") from None
    poles = np.linalg.eigvals(part - way @ K).astype(np.complex128)
    if not np.isfinite(K).all() or not np.all((poles.real < 0) if period is None else (np.abs(poles) < 1)):
        raise LinearizeError(
            "not all poles of what was found decay; weights differ by too much, or a mode is next to one out of reach"
        )
    return K @ basis.T / scale[None, :], poles[np.argsort(-poles.real, kind="stable")], notes


def _lasting(A: Array, size: float) -> list[complex]:
    """Return eigenvalues that do not decay, those that grow fastest first."""
    found = spectrum(A, size)
    return [*(mode.value for mode in found.modes if mode.value.real >= -SIDEWAYS * size), *[0j] * found.zeros]


def _named(space: Array, names: tuple[str, ...]) -> str:
    """Return the names of the states that take part in a space of balanced states."""
    share = np.linalg.norm(space, axis=1)
    return ", ".join(name for name, x in zip(names, share, strict=True) if x > 0.1 * share.max(initial=0.0))


def _close(faults: Faults) -> None:
    faults.close(LinearizeError)
