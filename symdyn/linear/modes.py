"""Modes of ẋ = A x: eigenvalues, those that are zero told apart before rounding can move them.

    T⁻¹ A T = [N  R]        N nilpotent, of the size of all zero eigenvalues; A' has none
              [0  A']       v = T (z, y) is the shape of λ ≠ 0: A' y = λ y, (λ - N) z = R y

A double zero, as of what drifts freely, is moved by rounding to the root of it, 1e-8; so zeros are taken out first:
what A maps to nothing spans a space, A acts on what is left beside it, and so on while something is mapped to nothing.
States have different units, so A is balanced before sizes are compared.

Reference: Kublanovskaya's staircase; Golub and Van Loan, Matrix Computations (2013), 7.6.5 and 7.5.7 (balancing).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array

Complexes = npt.NDArray[np.complex128]

NOTHING = 1e-9
"""Singular values of the balanced A over its largest that are zero."""

PARTED = 1e-6
"""Distance of eigenvalues over the largest that rounding makes of one that is multiple."""

SIDEWAYS = 1e-9
"""Real parts over the size of the largest eigenvalue that are zero."""

ROUNDING = 1e-14
"""Entries over the largest that rounding leaves where there is nothing."""

ROUNDS = 12
"""Times that all states are balanced at most."""


def pairs_of(values: Iterable[complex]) -> list[list[float]]:
    """Return complex numbers for JSON, real and imaginary parts."""
    return [[float(value.real), float(value.imag)] for value in values]


@dataclass(frozen=True, eq=False)
class Mode:
    """One way of moving, of an eigenvalue that is not zero, or of a pair of conjugate ones.

    Attributes:
        value: eigenvalue λ, 1/s; of a pair the one with positive imaginary part.
        shape: what moves in it, shape (nx,), its largest entry 1; of complex entries the angle is the phase.
    """

    value: complex
    shape: Complexes

    @property
    def oscillates(self) -> bool:
        """Whether it is a pair."""
        return self.value.imag > 0

    @property
    def frequency(self) -> float:
        """Natural frequency |λ|/2π, Hz, of a pair and of a real eigenvalue alike."""
        return abs(self.value) / (2 * math.pi)

    @property
    def damping(self) -> float:
        """Damping ratio -Re λ/|λ|: 1 of what decays without oscillating, -1 of what grows so."""
        return -self.value.real / abs(self.value)


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The eigenvalues of A.

    Attributes:
        zeros: how many are zero.
        still: what A maps to nothing, a column each, shape (nx, nullity).
        modes: the others, those that grow fastest first.
        size: the largest of them, 1/s; 0 if all are zero.
    """

    zeros: int
    still: Array
    modes: tuple[Mode, ...]
    size: float

    @property
    def growing(self) -> tuple[Mode, ...]:
        """Those that grow."""
        return tuple(mode for mode in self.modes if mode.value.real > SIDEWAYS * self.size)

    @property
    def decaying(self) -> tuple[Mode, ...]:
        """Those that decay."""
        return tuple(mode for mode in self.modes if mode.value.real < -SIDEWAYS * self.size)


def spectrum(A: Array, whole: float = 0.0) -> Spectrum:
    """Return the eigenvalues of A, shape (nx, nx), 1/s; zero is what is nothing beside the size of the `whole`."""
    n = len(A)
    scale = balance(A)
    left = A * scale[None, :] / scale[:, None]  # D⁻¹ A D
    size = float(np.abs(left).max(initial=whole))
    Q, zeros, still = np.eye(n), 0, np.zeros((n, 0))
    while zeros < n:
        part = left[zeros:, zeros:]
        _, values, rows = np.linalg.svd(part)
        lost = int(np.sum(values <= NOTHING * max(size, 1e-300)))
        if not lost:
            break
        turn = np.eye(n)
        turn[zeros:, zeros:] = np.vstack([rows[len(rows) - lost :], rows[: len(rows) - lost]]).T
        left, Q = turn.T @ left @ turn, Q @ turn
        left[zeros:, zeros : zeros + lost] = 0.0
        still = scale[:, None] * Q[:, :lost] if not zeros else still
        zeros += lost
    values, below = np.linalg.eig(left[zeros:, zeros:]) if zeros < n else (np.zeros(0), np.zeros((0, 0)))
    values = _as_one(np.asarray(values, dtype=np.complex128))
    N, R = left[:zeros, :zeros], left[:zeros, zeros:]
    modes = []
    for value, y in zip(values, below.T, strict=True):
        if value.imag < 0:
            continue
        shifted = value * np.eye(zeros) - N
        try:
            z = np.linalg.solve(shifted, R @ y)
        except np.linalg.LinAlgError:  # an eigenvalue that doubles cannot tell from zero beside the others
            z = np.linalg.lstsq(shifted, R @ y, rcond=None)[0]
        shape = scale * (Q @ np.concatenate([z, y]))
        modes.append(Mode(complex(value), np.asarray(shape / shape[np.abs(shape).argmax()], dtype=np.complex128)))
    top = max((abs(mode.value) for mode in modes), default=0.0)
    modes.sort(key=lambda mode: (-round(mode.value.real / top, 9), abs(mode.value)))
    return Spectrum(zeros, still, tuple(modes), top)


def _as_one(values: Complexes) -> Complexes:
    """Return eigenvalues, those of one that rounding parts about the imaginary axis at what they are in the mean.

    A double eigenvalue with one shape, as of a body that turns and drifts, is found to the root of rounding,
    the mean of the two to rounding itself.
    """
    top, found = float(np.abs(values).max(initial=0.0)), values.copy()
    for value in values:
        near = np.abs(values - value) <= PARTED * top
        mean = values[near].mean()
        if np.count_nonzero(near) > 1 and abs(mean.real) <= SIDEWAYS * top:
            found[near] = complex(0.0, mean.imag)
    return found


def balance(A: Array) -> Array:
    """Return scales d, powers of two, shape (nx,), that make rows and columns of D⁻¹ A D of one size."""
    d, left = np.ones(len(A)), np.abs(A) * (1 - np.eye(len(A)))
    left[left <= ROUNDING * np.abs(A).max(initial=0.0)] = 0.0  # it would be blown up
    for _ in range(ROUNDS):
        changed = False
        for k in range(len(A)):
            column, row = float(np.linalg.norm(left[:, k])), float(np.linalg.norm(left[k]))
            if not (column > 0 and row > 0 and math.isfinite(column) and math.isfinite(row)):
                continue
            factor = 2.0 ** round(math.log2(row / column) / 2)
            if factor != 1.0:
                changed = True
                d[k] *= factor
                left[:, k] *= factor
                left[k] /= factor
        if not changed:
            break
    return d


def untouched(A: Array, among: Sequence[int]) -> list[int]:
    """Return the states, of some, on which no rate depends."""
    scale = balance(A)
    left = np.abs(A * scale[None, :] / scale[:, None])
    size = left.max(initial=0.0)
    return [k for k in among if left[:, k].max(initial=0.0) <= NOTHING * size]
