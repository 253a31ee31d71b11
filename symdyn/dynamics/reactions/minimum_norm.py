"""(5.18) row by row, and solved in numbers by singular values: the least reactions, and which of them are unique.

A x + b = 0    six equations a body, every component of every joint
N              null space of A: self-equilibrated reactions, which no motion tells
R = T x + R⁰   the reactions of all joints, [force; moment] by joint; R⁰ what drives that are known and elements do
L              characteristic length: a moment of size M counts as a force M / L

It is solved in numbers alone, at one place after the other, with pivots that the numbers there choose: no choice is
made beforehand that could fail at another place.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.graph import Expr, evaluate

if TYPE_CHECKING:
    from symdyn.dynamics.reactions.dalembert import Equilibrium

RANK = 1e-9
"""Singular values this much below the largest are zero, at positions that close the loops to the last digits."""

LOOSE = 1e-7
"""Rows of N above it are not zero, a moment counting as a force."""

Flags = np.ndarray[Any, np.dtype[np.bool_]]


@dataclass(frozen=True)
class Least:
    """The least x with A x + b = 0, as far as that can be met.

    Attributes:
        x: sizes of the unknowns, N or N m.
        free: which of them are not unique.
        rank: of A.
        missed: the largest part of the equilibrium that nothing balances, N.
        load: the largest entry of b, N.
        R: reactions, shape (joints + loops, 6).
        unique: which of their entries are, the same shape.
    """

    x: Array
    free: Flags
    rank: int
    missed: float
    load: float
    R: Array
    unique: Flags


class InNumbers:
    """A system (5.18), ready to be looked at anywhere."""

    def __init__(self, system: Equilibrium) -> None:
        """Prepare it."""
        hanging, self.system = system.hanging, system
        zeros = [hanging.graph.zero] * 6 * (len(hanging.joints) + len(hanging.loops))
        balance, shown = system.rows(), system.wrench_rows(zeros)
        self._size = len(balance)
        places = [(r, c) for r, row in enumerate([*balance, *shown]) for c in row]
        self._rows, self._columns = np.array(places, dtype=int).reshape(-1, 2).T
        self._entries = [entry for row in [*balance, *shown] for entry in row.values()]
        self._height = self._size + len(shown)
        self._acts = [x for one in system.unknowns for part in one.acts[0][1] for x in part]

    def matrices(self, values: Mapping[Expr, float]) -> tuple[Array, Array, Array, Array]:
        """Return A, b, T, R⁰ at values of all symbols."""
        whole = np.zeros((self._height, len(self.system.unknowns) + 1))
        whole[self._rows, self._columns] = evaluate(self._entries, Floats(), values)
        A, T = whole[: self._size], whole[self._size :]
        return A[:, :-1], -A[:, -1], T[:, :-1], -T[:, -1]

    def sizes(self, values: Mapping[Expr, float], length: float) -> tuple[Array, Array]:
        """Return what every unknown does in its own joint at unit size, shape (unknowns, 6), and its size, N."""
        acts = np.array(evaluate(self._acts, Floats(), values)).reshape(-1, 6)
        found = np.hypot(np.linalg.norm(acts[:, :3], axis=1), np.linalg.norm(acts[:, 3:], axis=1) / length)
        return acts, np.where(found > 0, found, 1.0)

    def missed(self, values: Mapping[Expr, float], R: Array, length: float) -> float:
        """Return by how much reactions, shape (6 joints,), miss, whatever the unknowns, over the largest load."""
        A, b, T, still = self.matrices(values)
        _, scales = self.sizes(values, length)
        rows = _as_forces(len(b) + len(R), length)
        whole = np.vstack([A, T]) * rows[:, None] / scales
        right = np.concatenate([-b, R - still]) * rows
        left = whole @ np.linalg.lstsq(whole, right, rcond=RANK)[0] - right
        return float(np.abs(left).max(initial=0.0)) / (float(np.abs(right).max(initial=0.0)) or 1.0)

    def least(self, values: Mapping[Expr, float], length: float) -> Least:
        """Return the least solution at values of all symbols, for a characteristic length."""
        A, b, T, still = self.matrices(values)
        _, scales = self.sizes(values, length)
        rows = _as_forces(len(b), length)
        scaled, right = (A * rows[:, None]) / scales, rows * b
        U, s, Vt = np.linalg.svd(scaled, full_matrices=True)
        rank = int((s > RANK * s.max(initial=0.0)).sum())
        y = -Vt[:rank].T @ ((U[:, :rank].T @ right) / s[:rank])
        missed = float(np.abs(scaled @ y + right).max(initial=0.0))
        N = Vt[rank:].T
        shown = (T / scales) @ N * _as_forces(len(T), length)[:, None]
        return Least(
            y / scales,
            np.linalg.norm(N, axis=1) > LOOSE,
            rank,
            missed,
            float(np.abs(right).max(initial=0.0)),
            (T @ (y / scales) + still).reshape(-1, 6),
            (np.linalg.norm(shown, axis=1) <= LOOSE).reshape(-1, 6),
        )


def _as_forces(rows: int, length: float) -> Array:
    """Return what makes rows of [force; moment] comparable: moments count as forces, shape (rows,)."""
    return np.tile([1.0] * 3 + [1.0 / length] * 3, rows // 6)
