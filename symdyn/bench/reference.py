"""What every implementation is measured against, and the states at which.

The truth is the same graph at 50 digits: balls of 170 bits, whose radii are below the 50th digit. Running error bounds
are computed in double, where a few digits of them are enough. mpmath would give the same digits and take several times
as long. How well computed accelerations satisfy the equations that they were solved from is reported whatever their
condition:

    tree      M q̈ + h = τ
    closed    M q̈ + h = τ + Gᵀ λ  and  G q̈ + γ = 0, with the λ that fit q̈ best

    backward error    the larger of    |M q̈ + h - τ - Gᵀ λ| / (|M||q̈| + |h| + |τ| + |Gᵀ||λ|)
                                       |G q̈ + γ| / (|G||q̈| + |γ|)

in infinity norms; M, h, G, γ and all of this at 50 digits.

States are near zero, over the whole range, near singular positions, at large angles. Those of closed mechanisms are
brought onto their loops by Newton's method, and velocities to what the loops allow.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb_mat

from symdyn.algebra import Array, Balls, Bounded, Floats
from symdyn.dynamics import Argument, Function, row_of
from symdyn.dynamics.loops import Numbers
from symdyn.dynamics.outputs import DIRECTIONS
from symdyn.emit.code import REALS
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import evaluate, reachable
from symdyn.program import Routine, formulate, lower, quaternion_places
from symdyn.scene import Scene, SceneUnits

BITS = 170


class _Doubles(Floats):
    """Doubles in the place of big floats, for the bounds."""

    context = SimpleNamespace(mpf=float, cos=math.cos, sin=math.sin, inf=math.inf)

    def constant(self, value: Fraction) -> float:
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
    if not solved or bool(scene.prescribed_velocities):
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

NEGLIGIBLE = 1e-10
"""Singular values that are none."""

REACH = {"q": 1.0, "qd": 2.0, "qdd": 2.0, "tau": 5.0, "t": 3.0, "inputs": 3.0, "internal": 3.0, "ui": 2.0, "qi": 1.0}
REACH |= dict.fromkeys((*DIRECTIONS.values(), "weights", "p"), 2.0)


@dataclass(frozen=True, eq=False)
class Positions:
    """What is known of a scene's coordinates."""

    units: tuple[str, ...]  # "rad", "m" or "1" for each
    singular: Array  # positions near singular ones, shape (N, nq), () where none are known
    loops: Loops | None = None  # those that positions have to close

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
    if scene.is_constrained:
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
        try:
            q = self.numbers.newton(q, ())
            missed = float(np.abs(self.numbers.residual(q)).max(initial=0.0))
        except DerivationError:  # a formula has no value there
            return None
        return q if missed <= 1e-12 * max(1.0, float(np.abs(q).max(initial=0.0))) else None

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
    last = ("p", "dp")  # after all others, whose numbers stay what they were
    along = [name for name in DIRECTIONS.values() if name not in last]
    for name in ("qd", "qdd", "tau", "ui", "qi", "t", *along, "weights", "inputs", "internal", *last):
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
    return np.asarray(rng.choice([-1.0, 1.0], shape) * 10 ** rng.uniform(-9, -1, shape))


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
    return np.asarray(np.stack(found, axis=1).reshape(-1, len(anywhere.units)))


def _smallest(matrix: Callable[[Array], Any], q: Array) -> Array:
    with np.errstate(all="ignore"):
        A = np.asarray(matrix(q), float)
    good = np.isfinite(A).all(axis=(1, 2))
    values = np.full(len(q), np.inf)
    if good.any() and min(A.shape[1:]):
        singular = np.linalg.svd(A[good], compute_uv=False)
        values[good] = singular[:, -1] / np.maximum(singular[:, 0], 1e-300)
    return values
