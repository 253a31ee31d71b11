"""States that functions are measured at: near zero, over the whole range, near singular positions, at large angles.

Those of closed mechanisms are brought onto their loops by Newton's method, and velocities to what the loops allow.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.dynamics import Argument
from symdyn.dynamics.loops import Numbers
from symdyn.dynamics.outputs import DIRECTIONS
from symdyn.errors import DerivationError
from symdyn.program import quaternion_places
from symdyn.scene import Scene, SceneUnits

Array = npt.NDArray[np.float64]

REGIONS = {
    "near zero": "all of the state between 1e-9 and 1e-1 in size, then loops closed",
    "range": "turns within ±pi, slides within ±1 m, velocities and accelerations within ±2, forces within ±5",
    "singular": "as before, at positions found by sampling where M, a Jacobian or loops are nearest to singular",
    "large angles": "turns of 1e3 to 1e6 rad",
}

SEARCH, SEARCH_CLOSED = (2000, 12, 40), (80, 3, 12)
"""Positions that are tried for singular ones, rounds of improving the best, and how many of those there are."""

MOST, FEW = 200, 48
"""States of a closed mechanism beyond the first are repetitions of the second: they are timed only."""

WIDTH = 64
"""Velocities, accelerations and forces that are drawn; more are repetitions."""

STEPS, LONGEST, NEGLIGIBLE = 30, 0.5, 1e-10
"""Newton's steps to close loops, the longest of them in rad or m, and singular values that are none."""

REACH = {"q": 1.0, "qd": 2.0, "qdd": 2.0, "tau": 5.0, "t": 3.0, "inputs": 3.0, "ui": 2.0, "qi": 1.0}
REACH |= dict.fromkeys((*DIRECTIONS.values(), "weights"), 2.0)


@dataclass(frozen=True, eq=False)
class Positions:
    """What is known of a scene's coordinates.

    Attributes:
        units: "rad", "m" or "1" for each.
        singular: positions near singular ones, shape (N, nq), () where none are known.
        loops: those that positions have to close.
    """

    units: tuple[str, ...]
    singular: Array
    loops: Loops | None = None

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
        return self.fitting(q, rng)

    def fitting(self, q: Array, rng: np.random.Generator) -> Array:
        """Return positions with quaternions of unit length and loops closed.

        Quaternions of nearly no length are drawn again; positions from which loops cannot be closed give way to others.
        """
        for k in quaternion_places(self.units):
            e = q[:, k : k + 4]
            e = np.where(np.linalg.norm(e, axis=1, keepdims=True) < 0.1, rng.normal(size=e.shape), e)
            q[:, k : k + 4] = e / np.linalg.norm(e, axis=1, keepdims=True)
        return q if self.loops is None else self.loops.closed(q)


def positions_of(scene: Scene, seed: int = 1) -> Positions:
    """Return a scene's coordinates without any singular positions; free parameters as `draw` gives them."""
    units = SceneUnits(scene).coordinates
    loops = None
    if scene.is_closed:
        numbers = Numbers(scene)
        numbers.free = {p.name: float(x) for p, x in zip(scene.free_parameters, parameters(seed), strict=False)}
        loops = Loops(numbers)
    return Positions(units, np.empty((0, len(units))), loops)


@dataclass(frozen=True)
class Loops:
    """A closed mechanism's loops in numbers, its free parameters given."""

    numbers: Numbers

    def closed(self, q: Array) -> Array:
        """Return positions with loops closed; what Newton's method cannot close is replaced by what it can."""
        found = [self._closed(row) for row in q]
        good = [row for row in found if row is not None]
        if not good:
            return q
        spare = itertools.cycle(good)
        return np.array([next(spare) if row is None else row for row in found])

    def _closed(self, q: Array) -> Array | None:
        for _ in range(STEPS):
            try:
                r, R = self.numbers.residual(q), self.numbers.residual_rates(q)
            except DerivationError:
                return None
            size = float(np.abs(r).max(initial=0.0))
            if size <= 1e-15 * max(1.0, float(np.abs(q).max(initial=0.0))):
                return q
            step = -np.linalg.lstsq(R, r, rcond=NEGLIGIBLE)[0]
            q = self.numbers.moved(q, step * min(1.0, LONGEST / max(np.abs(step).max(initial=0.0), 1e-300)))
        return q if size <= 1e-12 * max(1.0, float(np.abs(q).max(initial=0.0))) else None

    def allowed(self, q: Array, qd: Array) -> Array:
        """Return the velocities nearest to the first of those given that keep the loops closed."""
        found = []
        for row, u in zip(q, qd[:, : self.numbers.state.n], strict=True):
            G = self.numbers.jacobian(row)
            found.append(u - np.linalg.lstsq(G, G @ u, rcond=NEGLIGIBLE)[0])
        return np.array(found).reshape(len(q), -1)


def draw(
    arguments: Sequence[Argument], positions: Positions, region: str, count: int, seed: int, real: str
) -> dict[str, Array]:
    """Return the arguments of `count` states, exact in the real type; one set of free parameters for all."""
    drawn: dict[str, Array] = {}
    state = _states(positions, region, count, seed)
    params = parameters(seed)
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


@lru_cache(maxsize=64)
def _states(positions: Positions, region: str, count: int, seed: int) -> Mapping[str, Array]:
    """Return all that a function may be given, in this order whatever it takes: the same states for all."""
    if positions.loops is not None and count > MOST:
        few = _states(positions, region, FEW, seed)
        return {name: np.resize(value, (count, value.shape[1])) for name, value in few.items()}
    rng = np.random.default_rng([seed, list(REGIONS).index(region)])
    state = {"q": positions.draw(region, count, rng)}
    for name in ("qd", "qdd", "tau", "ui", "qi", "t", *DIRECTIONS.values(), "weights", "inputs"):
        small = _small(rng, (count, WIDTH))
        wide = rng.uniform(-REACH[name], REACH[name], (count, WIDTH))
        state[name] = small if region == "near zero" else wide
    if positions.loops is not None:
        state["qd"] = positions.loops.allowed(state["q"], state["qd"])
    return state


def parameters(seed: int) -> Array:
    """Return values of free parameters, more than any scene has."""
    return np.random.default_rng(seed).uniform(0.5, 1.5, 256)


def _small(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    size: Array = rng.choice([-1.0, 1.0], shape) * 10 ** rng.uniform(-9, -1, shape)
    return size


def near_singular(anywhere: Positions, matrices: Sequence[Callable[[Array], Any]], seed: int) -> Array:
    """Return positions where the smallest singular value of one of the matrices is smallest beside its largest.

    Matrices are functions of positions (N, nq), each with values (N, m, n).
    """
    rng = np.random.default_rng(seed)
    searched, rounds, kept = SEARCH if anywhere.loops is None else SEARCH_CLOSED
    tried = anywhere.draw("range", searched, rng)
    found: list[Array] = []
    for matrix in matrices:
        size = _smallest(matrix, tried)
        order = np.argsort(size)[:kept]
        q, size = tried[order], size[order]
        for step in range(rounds):
            near = anywhere.fitting(q + rng.normal(size=q.shape) * 0.5 ** (1 + step), rng)
            better = _smallest(matrix, near)
            chosen = better < size
            q = np.where(chosen[:, None], near, q)
            size = np.where(chosen, better, size)
        found.append(q[np.argsort(size)])
    if not found:
        return anywhere.singular
    mixed: Array = np.stack(found, axis=1).reshape(-1, len(anywhere.units))
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
