"""The search for an exciting motion in numbers: coefficients in, criterion and what leaves its bounds out, with slopes.

    z       coefficients, shape (k, n): k functions of time for each of n coordinates, in parts of half their room
    A       stacked rows of the base regressor over the noise of each drive and √N, shape (N, n, p)
    g       how far each bounded number is outside, in parts of half its room, shape (N, bounds); <= 0 inside

Minimised is criterion(A) + 1/(2 ρ) Σ (max(0, λ + ρ g)² - λ²)/N, an augmented Lagrangian whose multipliers λ and weight
ρ grow from round to round, by L-BFGS. Slopes are exact: of A by the regressor's own backward derivative, of forces by
that of inverse dynamics, of points by their Jacobians; each is one call for all N instants.

Reference: Nocedal and Wright, Numerical optimization (2006), 17.4.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.identification.bounds import Bound
from symdyn.identification.excitation import Basis, Criterion
from symdyn.runtime import Loaded, load
from symdyn.scene import Scene

ROUNDS, STEPS = 6, 40
"""Rounds of multipliers, and steps of L-BFGS in each."""

WEIGHT, HEAVIER = 100.0, 2.0
"""Of what is outside: at first, and times as much in every round."""

SAME = 1e-9
"""Singular value of the regressor at random places, over the largest, of a direction that no motion tells."""

PLACES = 200


@dataclass(frozen=True)
class Motion:
    """A motion at N instants.

    Attributes:
        q, u, a: positions, velocities, accelerations, shape (N, n) each.
    """

    q: Array
    u: Array
    a: Array


class Functions:
    """The compiled functions of a scene that the search calls.

    Attributes:
        bounds: what must be kept.
        noise: standard deviation of each drive's force, shape (n,).
        directions: combinations of base parameters that motions tell, shape (columns, p).
    """

    def __init__(self, scene: Scene, bounds: Sequence[Bound], noise: Array, seed: int) -> None:
        """Derive and compile."""
        points = sorted({one.index // 3 for one in bounds if one.kind == "point"})
        self.points = {k: scene.points[k].name for k in points}
        self.forced = any(one.kind == "force" for one in bounds)
        names = ["base_regressor", "base_regressor_vjp", "inverse_dynamics"]
        names += ["inverse_dynamics_vjp"] if self.forced else []
        names += [f"{what}:{name}" for name in self.points.values() for what in ("pose", "jacobian")]
        self.calls: Loaded = load(scene, names)
        self.bounds, self.noise = tuple(bounds), noise
        n = len(scene.velocities)
        drawn = np.random.default_rng(seed).uniform(-1, 1, (3, PLACES, n))
        Y = self.calls["base_regressor"](*(drawn * np.pi))
        size, V = np.linalg.svd(Y.reshape(-1, Y.shape[-1]))[1:]
        rank = int((size > SAME * size[0]).sum()) if size.size and size[0] > 0 else 0
        self.directions, self.fewer = V[:rank].T, rank < len(V)

    def rows(self, motion: Motion) -> Array:
        """Return A."""
        Y = self.calls["base_regressor"](motion.q, motion.u, motion.a)
        scale = np.sqrt(len(motion.q)) * self.noise[:, None]
        return np.asarray(np.matmul(Y, self.directions) / scale if self.fewer else Y / scale)

    def back(self, motion: Motion, slope: Array) -> tuple[Array, Array, Array]:
        """Return slopes by q, u and a, shape (N, n) each, of a number whose slope by A is given."""
        N, n = motion.q.shape
        weights = (np.matmul(slope, self.directions.T) if self.fewer else slope) / self.noise[:, None] / np.sqrt(N)
        found = self.calls["base_regressor_vjp"](motion.q, motion.u, motion.a, weights.reshape(N, -1))
        return found[:, :n], found[:, n : 2 * n], found[:, 2 * n :]

    def forces(self, motion: Motion) -> Array:
        """Return driving forces, shape (N, n)."""
        return np.asarray(self.calls["inverse_dynamics"](motion.q, motion.u, motion.a))

    def bounded(self, motion: Motion) -> Array:
        """Return the numbers that have bounds, shape (N, bounds)."""
        known = {"position": motion.q, "velocity": motion.u, "acceleration": motion.a}
        known |= {"force": self.forces(motion)} if self.forced else {}
        if self.points:
            known["point"] = np.zeros((len(motion.q), 3 * (max(self.points) + 1)))
            for k, name in self.points.items():
                known["point"][:, 3 * k : 3 * k + 3] = self.calls[f"pose:{name}"](motion.q)[..., 3]
        return np.stack([known[one.kind][:, one.index] for one in self.bounds], axis=1)

    def bounded_back(self, motion: Motion, slope: Array) -> tuple[Array, Array, Array]:
        """Return slopes by q, u and a of a number whose slope by what has bounds is given, shape (N, bounds)."""
        N, n = motion.q.shape
        parts = {kind: np.zeros((N, n)) for kind in ("position", "velocity", "acceleration", "force")}
        parts["point"] = np.zeros((N, 3 * (max(self.points, default=-1) + 1)))
        for k, one in enumerate(self.bounds):
            parts[one.kind][:, one.index] += slope[:, k]
        q, u, a = parts["position"], parts["velocity"], parts["acceleration"]
        if self.forced:
            found = self.calls["inverse_dynamics_vjp"](motion.q, motion.u, motion.a, parts["force"])
            q, u, a = q + found[:, :n], u + found[:, n : 2 * n], a + found[:, 2 * n :]
        for k, name in self.points.items():
            J = self.calls[f"jacobian:{name}"](motion.q)[:, :3]
            q = q + np.einsum("ki,kij->kj", parts["point"][:, 3 * k : 3 * k + 3], J)
        return q, u, a


class Search:
    """The minimum that is looked for, at N instants of a period."""

    def __init__(self, functions: Functions, basis: Basis, criterion: Criterion) -> None:
        """Keep what does not change: coordinates are middle + half Φ z."""
        self.functions, self.basis, self.criterion = functions, basis, criterion
        bounds = functions.bounds
        rooms = sorted((one for one in bounds if one.kind == "position"), key=lambda one: one.index)
        self.middle = np.array([(one.low + one.high) / 2 for one in rooms])
        self.half = np.array([one.size for one in rooms])
        size = np.array([one.size for one in bounds])
        self.ends = [(np.array([getattr(one, end) for one in bounds]), sign / size) for end, sign in
                     (("high", 1.0), ("low", -1.0))]  # fmt: skip

    def motion(self, z: Array, basis: Basis | None = None) -> Motion:
        """Return the motion of coefficients (k, n), or of several, (P, k, n), at P times as many instants."""
        one = basis or self.basis
        found = [np.matmul(part, z * self.half) for part in (one.position, one.rate, one.second)]
        return Motion(*(part.reshape(-1, len(self.half)) for part in (found[0] + self.middle, *found[1:])))

    def outside(self, motion: Motion) -> Array:
        """Return g, above and then below, shape (N, 2 bounds); -inf where there is no end."""
        x = self.functions.bounded(motion)
        return np.hstack([(x - end) * scale for end, scale in self.ends])

    def value(self, z: Array) -> float:
        """Return the criterion as a user is shown it."""
        return self.criterion.value(self.functions.rows(self.motion(z)))

    def slope(self, z: Array, multipliers: Array, weight: float, margin: float) -> tuple[float, Array]:
        """Return what is minimised, and its slope by z, (k, n)."""
        motion = self.motion(z)
        value, slope = self.criterion.slope(self.functions.rows(motion))
        pressed = np.maximum(0.0, multipliers + weight * (self.outside(motion) + margin))
        N, half = len(pressed), len(self.functions.bounds)
        value += float((pressed**2 - multipliers**2).sum()) / (2 * weight * N)
        pushed = (pressed[:, :half] * self.ends[0][1] + pressed[:, half:] * self.ends[1][1]) / N
        parts = zip(self.functions.back(motion, slope), self.functions.bounded_back(motion, pushed), strict=True)
        q, u, a = (one + other for one, other in parts)
        found = self.basis.position.T @ q + self.basis.rate.T @ u + self.basis.second.T @ a
        return value, found * self.half

    def minimum(self, z: Array, margin: float, report: Callable[[float], None] = lambda part: None) -> Array:
        """Return coefficients next to z at which no number is nearer to a bound than `margin`, as far as that goes."""
        from scipy.optimize import minimize

        multipliers = np.zeros((len(self.basis.position), 2 * len(self.functions.bounds)))
        weight = WEIGHT
        for turn in range(ROUNDS):
            options: Any = {"maxiter": STEPS, "maxcor": 20}
            more = (z.shape, multipliers, weight, margin)
            z = minimize(self._flat, z.ravel(), more, "L-BFGS-B", True, options=options).x.reshape(z.shape)
            multipliers = np.maximum(0.0, multipliers + weight * (self.outside(self.motion(z)) + margin))
            weight *= HEAVIER
            report((turn + 1) / ROUNDS)
        return z

    def _flat(self, x: Array, shape: tuple[int, int], *more: Any) -> tuple[float, Array]:
        value, slope = self.slope(x.reshape(shape), *more)
        return value, slope.ravel()
