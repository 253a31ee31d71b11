"""How well computed accelerations satisfy the linear equations that they were solved from, whatever their condition.

    tree      M q̈ + h = τ
    closed    M q̈ + h = τ + Gᵀ λ  and  G q̈ + γ = 0, with the λ that fit q̈ best

    backward error    the larger of    |M q̈ + h - τ - Gᵀ λ| / (|M||q̈| + |h| + |τ| + |Gᵀ||λ|)
                                       |G q̈ + γ| / (|G||q̈| + |γ|)

in infinity norms; M, h, G, γ and all of this at 50 digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb_mat

from symdyn.algebra.balls import Balls
from symdyn.bench.reference import BITS, Reference, reference
from symdyn.dynamics import row_of
from symdyn.dynamics.mechanism.prescribed import has_motion
from symdyn.errors import DerivationError
from symdyn.program import Routine, formulate, lower
from symdyn.scene import Scene

Array = npt.NDArray[np.float64]


def linear(scene: Scene, request: str) -> tuple[Routine, ...]:
    """Return the functions that say which equations an output solves; () for none, and where it solves for drives."""
    solved = row_of(request, scene)[0].solves
    if not solved or has_motion(scene):
        return ()
    try:
        return lower(formulate(scene, solved)).routines
    except DerivationError:
        return ()


@dataclass(frozen=True)
class Solve:
    """The linear equations of one state after the other: references of M, h, and of G, γ where loops close."""

    references: tuple[Reference, ...]

    @staticmethod
    def at(routines: tuple[Routine, ...], states: Mapping[str, Array], count: int) -> Solve | None:
        """Return the equations at states; None where some of them have none."""
        at_rest = {**states, "qdd": np.zeros_like(states["qd"])}
        found = tuple(reference(routine.function, at_rest, count) for routine in routines)
        return Solve(found) if found and all(len(one.kept) == count for one in found) else None

    def backward(self, computed: Array, tau: Array, kept: npt.NDArray[np.intp], unit: float) -> list[float]:
        """Return the backward errors of accelerations at the kept states, in roundoffs."""
        with Balls(BITS) as algebra:
            return [self._at(k, computed[k], tau[k], algebra) / unit for k in kept]

    def _at(self, k: int, computed: Array, tau: Array, algebra: Balls) -> float:
        if not np.isfinite(computed).all():
            return float("inf")
        n = len(computed)
        shaped = zip((one.balls[k] for one in self.references), (n, 1, n, 1), strict=False)
        M, h, *rows = (arb_mat(len(balls) // width, width, balls) for balls, width in shaped)
        qdd, given = column(computed, algebra), column(tau, algebra)
        left = M * qdd + h - given
        size = norm(M) * norm(qdd) + norm(h) + norm(given)
        if not rows or not rows[0].nrows():
            return _share(left, size)
        G, gamma = rows
        across = G.transpose()
        of_rows = _share(G * qdd + gamma, norm(G) * norm(qdd) + norm(gamma))
        try:
            multipliers = (G * across).solve(G * left)
        except ZeroDivisionError:  # a change point, or a row too many: any λ may do
            return of_rows
        return max(_share(left - across * multipliers, size + norm(across) * norm(multipliers)), of_rows)


def column(values: Array, algebra: Balls) -> Any:
    """Return doubles as a column of balls."""
    return arb_mat(len(values), 1, [algebra.number(x) for x in values.tolist()])


def norm(matrix: Any) -> float:
    """Return the infinity norm."""
    return max((sum(float(abs(x)) for x in row) for row in matrix.tolist()), default=0.0)


def _share(residual: Any, size: float) -> float:
    found = norm(residual)
    return found / size if size else found
