"""States that functions are measured at: near zero, over the whole range, near singular positions, at large angles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.dynamics import Argument

Array = npt.NDArray[np.float64]

REGIONS = {
    "near zero": "all of the state between 1e-9 and 1e-1 in size",
    "range": "turns within ±pi, slides within ±1 m, velocities and accelerations within ±2, forces within ±5",
    "singular": "as before, at positions found by sampling where M or a Jacobian is nearest to singular",
    "large angles": "turns of 1e3 to 1e6 rad",
}

SEARCHED, ROUNDS, KEPT = 2000, 12, 40
"""Positions that are tried for singular ones, rounds of improving the best, and how many of those there are."""

REACH = {"q": 1.0, "qd": 2.0, "qdd": 2.0, "tau": 5.0, "t": 3.0, "ui": 2.0, "qi": 1.0}


@dataclass(frozen=True)
class Positions:
    """What is known of a scene's coordinates.

    Attributes:
        units: "rad", "m" or "1" for each.
        singular: positions near singular ones, shape (N, nq), () where none are known.
    """

    units: tuple[str, ...]
    singular: Array

    def draw(self, region: str, count: int, rng: np.random.Generator) -> Array:
        """Return positions of a region, shape (count, nq)."""
        n = len(self.units)
        if region == "singular" and len(self.singular):
            return self.singular[np.arange(count) % len(self.singular)]
        turning = np.array([unit == "rad" for unit in self.units], bool)
        q = rng.uniform(-1, 1, (count, n)) * np.where(turning, np.pi, 1)
        if region == "near zero":
            q = _small(rng, (count, n))
        if region == "large angles":
            q = np.where(turning, np.sign(q) * 10 ** rng.uniform(3, 6, (count, n)), q)
        return self.normalised(q, rng)

    def normalised(self, q: Array, rng: np.random.Generator) -> Array:
        """Return positions with quaternions of unit length; those of nearly no length are drawn again."""
        for k in quaternions(self.units):
            e = q[:, k : k + 4]
            e = np.where(np.linalg.norm(e, axis=1, keepdims=True) < 0.1, rng.normal(size=e.shape), e)
            q[:, k : k + 4] = e / np.linalg.norm(e, axis=1, keepdims=True)
        return q


def quaternions(units: Sequence[str]) -> list[int]:
    """Return where quaternions begin: four numbers without a unit."""
    found, k = [], 0
    while k < len(units):
        found += [k] if units[k] == "1" else []
        k += 4 if units[k] == "1" else 1
    return found


def draw(
    arguments: Sequence[Argument], positions: Positions, region: str, count: int, seed: int, real: str
) -> dict[str, Array]:
    """Return the arguments of `count` states, exact in the real type; one set of free parameters for all."""
    rng = np.random.default_rng([seed, list(REGIONS).index(region)])
    drawn: dict[str, Array] = {}
    state = {"q": positions.draw(region, count, rng)}
    for name in ("qd", "qdd", "tau", "ui", "qi", "t"):  # in this order whatever the function takes: the same states
        width = 64
        reach = REACH[name]
        small = _small(rng, (count, width))
        wide = rng.uniform(-reach, reach, (count, width))
        state[name] = small if region == "near zero" else wide
    params = np.random.default_rng(seed).uniform(0.5, 1.5, 256)
    for argument in arguments:
        size = len(argument.symbols)
        if argument.name in state:
            values = state[argument.name]
            values = values[:, :size] if values.shape[1] >= size else np.resize(values, (count, size))
        else:
            values = params[:size] if size <= len(params) else np.resize(params, size)
        values = np.ascontiguousarray(values)
        drawn[argument.name] = values.astype(np.float32).astype(np.float64) if real == "float" else values
    return drawn


def _small(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    size: Array = rng.choice([-1.0, 1.0], shape) * 10 ** rng.uniform(-9, -1, shape)
    return size


def near_singular(units: Sequence[str], matrices: Sequence[Callable[[Array], Any]], seed: int) -> Array:
    """Return positions where the smallest singular value of one of the matrices is smallest beside its largest.

    Args:
        units: of the coordinates.
        matrices: functions of positions (N, nq), each with values (N, m, n).
        seed: of the search.
    """
    rng = np.random.default_rng(seed)
    anywhere = Positions(tuple(units), np.empty((0, len(units))))
    found: list[Array] = []
    for matrix in matrices:
        q = anywhere.draw("range", SEARCHED, rng)
        size = _smallest(matrix, q)
        order = np.argsort(size)[:KEPT]
        q, size = q[order], size[order]
        for step in range(ROUNDS):
            tried = anywhere.normalised(q + rng.normal(size=q.shape) * 0.5 ** (1 + step), rng)
            better = _smallest(matrix, tried)
            chosen = better < size
            q = np.where(chosen[:, None], tried, q)
            size = np.where(chosen, better, size)
        found.append(q[np.argsort(size)])
    if not found:
        return anywhere.singular
    mixed: Array = np.stack(found, axis=1).reshape(-1, len(units))
    return mixed


def _smallest(matrix: Callable[[Array], Any], q: Array) -> Array:
    with np.errstate(all="ignore"):
        A = np.asarray(matrix(q), float)
    good = np.isfinite(A).all(axis=(1, 2))
    values = np.full(len(q), np.inf)
    if good.any() and min(A.shape[1:]):
        singular = np.linalg.svd(A[good], compute_uv=False)
        values[good] = singular[:, -1] / np.maximum(singular[:, 0], 1e-300)
    return values
