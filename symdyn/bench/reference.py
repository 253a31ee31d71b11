"""What every implementation is measured against: the same graph at 50 digits, and the linear equations it solves.

Values are balls of 170 bits, whose radii are below the 50th digit; running error bounds are computed in double, where a
few digits of them are enough. mpmath would give the same digits and take several times as long. How well computed
accelerations satisfy the equations that they were solved from is told whatever their condition:

    tree      M q̈ + h = τ
    closed    M q̈ + h = τ + Gᵀ λ  and  G q̈ + γ = 0, with the λ that fit q̈ best

    backward error    the larger of    |M q̈ + h - τ - Gᵀ λ| / (|M||q̈| + |h| + |τ| + |Gᵀ||λ|)
                                       |G q̈ + γ| / (|G||q̈| + |γ|)

in infinity norms; M, h, G, γ and all of this at 50 digits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb_mat

from symdyn.algebra import Balls, Bounded, Floats
from symdyn.dynamics import Function, row_of
from symdyn.emit.code import REALS
from symdyn.errors import DerivationError
from symdyn.graph import evaluate, reachable
from symdyn.program import Routine, formulate, lower
from symdyn.scene import Scene

Array = npt.NDArray[np.float64]

BITS = 170


class _Doubles(Floats):
    """Doubles in the place of big floats, for the bounds."""

    context = SimpleNamespace(mpf=float, cos=math.cos, sin=math.sin, inf=math.inf)

    def constant(self, value: Fraction) -> float:
        """Return the nearest double."""
        return float(value)


@dataclass(frozen=True)
class Reference:
    """Exact results at states.

    Attributes:
        kept: which of the states have one: the function is real and finite there.
        high, low: the result as a sum of two doubles, shape (kept, size).
        bound: running error bounds of one rounding of every operation, shape (kept, size), for double.
        balls: the results, one list a kept state.
    """

    kept: npt.NDArray[np.intp]
    high: Array
    low: Array
    bound: Array
    balls: list[list[Any]]

    def errors(self, computed: Array) -> Array:
        """Return |computed - exact|, shape (kept, size), from results at all states, (N, size) or sums (N, size, 2)."""
        found = np.asarray(computed, float).reshape(len(computed), self.high.shape[1], -1)[self.kept]
        with np.errstate(all="ignore"):
            gap: Array = np.abs((found[..., 0] - self.high) + (found[..., 1:].sum(axis=-1) - self.low))
        return np.where(np.isfinite(found).all(axis=-1), gap, np.inf)


def reference(function: Function, states: Mapping[str, Array], count: int, accuracy: str = "") -> Reference:
    """Return the exact results of a function at `count` states, and error bounds of code of an accuracy."""
    doubles = REALS["double"].rounding(_Doubles(), accuracy)  # type: ignore[arg-type]
    kept, balls, bounds = [], [], []
    order = reachable(function.entries)
    with Balls(BITS) as algebra:
        for k in range(count):
            state = state_of(states, k)
            given = function.values([state[argument.name] for argument in function.arguments])
            try:
                rough = evaluate(function.entries, doubles, {s: Bounded(v, 0.0) for s, v in given.items()}, order)
            except (ValueError, ZeroDivisionError, OverflowError):
                continue
            exact = evaluate(function.entries, algebra, {s: algebra.number(v) for s, v in given.items()}, order)
            if all(ball.is_finite() for ball in exact):
                kept.append(k)
                balls.append(exact)
                bounds.append([float(one.error) for one in rough])
        high = [[float(ball) for ball in row] for row in balls]
        low = [
            [float(b - algebra.number(h)) for b, h in zip(*pair, strict=True)] for pair in zip(balls, high, strict=True)
        ]
    size = len(function.entries)
    shape = (len(kept), size)
    return Reference(
        np.array(kept, dtype=np.intp),
        np.array(high).reshape(shape),
        np.array(low).reshape(shape),
        np.array(bounds).reshape(shape),
        balls,
    )


def state_of(states: Mapping[str, Array], k: int) -> dict[str, Array]:
    """Return one of many states; what all have in common is in each."""
    return {name: value[k] if value.ndim == 2 else value for name, value in states.items()}


def linear(scene: Scene, request: str) -> tuple[Routine, ...]:
    """Return the functions that say which equations an output solves; () for none, and where it solves for drives."""
    solved = row_of(request, scene)[0].solves
    if not solved or bool(scene.led_velocities):
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
