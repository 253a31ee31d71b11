"""Newton's method for positions of rest, over many starts at once, and what kind of place it led to.

    f(q, λ) = e at u = u̇ = 0      forces that nothing balances, λ of all rows, those of rolling included
    r(q)                           residuals of the position-level rows

    [X f  -Gᵀ] [δξ]     [f]
    [G_h   0 ] [δλ] = - [r]        solved in least squares: where equilibria are not isolated the nearest is taken

Where branches of loops meet, as where the arms of a governor hang down, rows depend on each other: it rests there if
what is left of them balances the forces. Where coordinates are singular, velocities u do not tell every motion that the
bodies can make; f says less than the forces on the bodies, and may vanish though they are pulled. How large
√(fᵀ M⁻¹ f) is beside the place, the size of the accelerations, tells: it goes to zero at rest, and only there.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array, Floats, Form
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.errors import LinearizeError
from symdyn.graph import Expr, evaluate, reachable
from symdyn.linear.modes import Complexes, SecondOrder
from symdyn.linear.prepared import MASS, RANK, Prepared
from symdyn.scene import SceneUnits
from symdyn.simulation import Problem, opened
from symdyn.unlocked import cached_property

STEPS, SMALL = 60, 1e-11
"""Newton steps at most, and the step, rad or m, that is none."""

PUSHED = 8
"""Starts at which it is looked how large forces are, and what has an inertia."""

DEGREES, TURNS = 720, 8
"""Steps of a turn in which changes of sign are looked for, and turns to either side where a spring counts them."""

FARTHEST = 0.7
"""Longest step, rad or m."""

BALANCED = 1e-8
"""Forces over the largest of their parts that are in balance."""

SAME = 1e-6
"""Distance of positions that are one, rad or m."""

NEAR = 1e-4
"""The same where rows lose rank and Newton's steps only halve what is missing; and forces over the largest there."""

FLAT = 1e-8
"""Singular values of the stiffness, over the largest, below which positions next to it are equilibria too."""

BESIDE, WORKS = 1e-5, 1e-3
"""rad or m beside a singular place, and what of the usual acceleration is none there."""


class Search:
    """Newton's method over many positions at once, states of one's own behind coordinates, shape (N, nq + ns)."""

    def __init__(self, prepared: Prepared, start: Array, t: float) -> None:
        self.asked, self.v, self.scene, self.t = prepared, prepared.functions, prepared.scene, t
        self.n, self.letters = len(self.v.u), (*self.v.w.state.q, *self.v.w.states)
        self.block, state, graph = self.v.statics, self.v.w.state, self.v.w.graph
        self.values: dict[Expr, Any] = {graph.symbol(name): x for name, x in opened(self.scene).values.items()}
        self.values[graph.symbol(TIME)] = t
        acting = (*state.tau, *map(graph.symbol, self.v.inputs))
        self.values |= dict(zip(acting, prepared.forces.tabulated(np.asarray(t), len(acting)).tolist(), strict=True))
        parts = self.block.parts
        needed = set(reachable([x for name in "frG" for x in parts[name][1]]))
        self.idle = [q not in needed for q in self.letters]
        self.start = start if len(start) == len(self.letters) else np.append(start, Problem(self.scene).initial.s)
        if self.v.multipliers:  # raises where rows depend on each other at the start
            prepared.place(*self.state(self.start), t)
        self.units = (*SceneUnits(self.scene).coordinates, *(one.unit for one in self.scene.states))
        self.sizes = np.ones(self.n)
        diagonal = np.diag(self.inertia(self.start[None, :])[0])
        self.sizes = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        self.turns, self.numbers = self._turns(), opened(self.scene).numbers()

    def state(self, q: Array) -> tuple[Array, Array]:
        """Return coordinates, and velocities that are zero with states, shapes (nq,) and (nu,)."""
        nq, ns = len(self.scene.coordinates), len(self.scene.states)
        return q[:nq], np.append(np.zeros(self.n - ns), q[nq:])

    def at(self, q: Array, multipliers: Array) -> dict[str, Array]:
        """Return the parts of the equations, shape (N, ...)."""
        values = dict(self.values)
        values |= dict(zip(self.letters, q.T, strict=True))
        values |= dict(zip(self.v.multipliers, multipliers.T, strict=True))
        return self.block.over(values, len(q))

    def inertia(self, q: Array) -> Array:
        """Return mass matrices in the scaled units, shape (N, nv, nv)."""
        values = {**self.values, **dict.fromkeys([*self.v.u, *self.v.a, *self.v.multipliers], 0.0)}
        values |= dict(zip(self.letters, q.T, strict=True))
        return self.v.motion.over(values, len(q))["M"] * self.sizes[:, None] * self.sizes

    def placed(self, exact: Sequence[Mapping[str, Form]]) -> Array:
        """Return positions that are known exactly, shape (N, nq)."""
        graph, found = self.v.w.graph, np.tile(self.start, (len(exact), 1))
        for row, one in zip(found, exact, strict=True):
            for name, form in one.items():
                (x,) = evaluate([form.express(graph)], Floats(), self.values)
                row[self.scene.coordinates.index(name)] = x
        return found

    def scanned(self) -> tuple[float, Array]:
        """Return how far changes of sign were looked for, rad, and where they are; where one angle alone matters."""
        matter = self.matter
        if len(matter) != 1 or self.v.multipliers or self.units[matter[0]] != "rad":
            return 0.0, np.zeros((0, len(self.start)))
        (one,) = matter
        around = 1 if self.turns[one] else 2 * TURNS + 1
        grid = np.tile(self.start, (DEGREES * around + 1, 1))
        grid[:, one] = np.linspace(-np.pi * around, np.pi * around, len(grid))
        f = self.at(grid, np.zeros((len(grid), 0)))["f"]
        f = f[:, (np.diff(f, axis=0) != 0).any(axis=0)]
        return np.pi * around, grid[1:][((f[:-1] * f[1:] < 0) | (f[1:] == 0)).any(axis=1)]

    @property
    def matter(self) -> tuple[int, ...]:
        """Coordinates on which something depends."""
        return tuple(k for k, idle in enumerate(self.idle) if not idle)

    def drawn(self, count: int) -> Array:
        """Return seeded positions; the first is the scene's start."""
        rng, found = random.Random(1), [self.start]
        for _ in range(count - 1):
            found.append(np.array([rng.uniform(-np.pi, np.pi) for _ in self.start]))
        q = np.array(found)
        q[:, self.idle] = self.start[self.idle]
        return self._unit(q)

    def _unit(self, q: Array) -> Array:
        names = list(self.scene.coordinates)
        for group in quaternions(self.scene):
            part = slice(names.index(group[0]), names.index(group[0]) + 4)
            q[:, part] /= np.linalg.norm(q[:, part], axis=1, keepdims=True)
        return q

    def roots(self, q: Array) -> tuple[Array, Array]:
        """Return where starts lead, and which of these places are roots."""
        n, rows = self.n, len(self.v.multipliers)
        multipliers, pushed = np.zeros((len(q), rows)), self._pushed
        for _ in range(STEPS):
            found = self.at(q, multipliers)
            J, F = self._scaled(found)
            fine = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(F).all(axis=1)
            J[~fine], F[~fine] = 0.0, 0.0
            most = np.abs(J).max(axis=(1, 2), initial=1e-300)
            step = -np.einsum("nij,nj->ni", np.linalg.pinv(J, rcond=1e-10 * np.maximum(1.0, pushed / most)), F)
            moved = step[:, :n] * self.sizes
            longest = np.abs(moved).max(axis=1, initial=0.0)
            short = np.minimum(1.0, FARTHEST / np.maximum(longest, 1e-300))[:, None]
            q = self._unit(q + np.einsum("nij,nj->ni", found["H"], moved * short))
            multipliers = multipliers + step[:, n:] * short
            if np.all(longest[fine] <= SMALL):
                break
        found = self.at(q, multipliers)
        J, F = self._scaled(found)
        parts = np.abs(J[:, :n, n:]) * np.abs(multipliers)[:, None, :]
        size = np.abs(J[:, :n, :n]).max(axis=(1, 2), initial=0.0) + parts.max(axis=(1, 2), initial=0.0)
        size = np.maximum(size, self._typical)
        off = np.maximum(np.abs(F[:, :n]).max(axis=1, initial=0.0) / size, np.abs(F[:, n:]).max(axis=1, initial=0.0))
        with np.errstate(invalid="ignore"):
            return q, np.isfinite(q).all(axis=1) & (off <= BALANCED)

    def _scaled(self, result: dict[str, Array]) -> tuple[Array, Array]:
        """Return the Jacobian and the left side of the equations, velocities in units of their sizes."""
        G, d = result["G"] * self.sizes, self.sizes
        holding = list(np.flatnonzero(self.v.holding))
        K = result["K"] * d[:, None] * d
        top = np.concatenate([K, -G.transpose(0, 2, 1)], axis=2)
        below = np.concatenate([G[:, holding], np.zeros((len(G), len(holding), G.shape[1]))], axis=2)
        return np.concatenate([top, below], axis=1), np.concatenate([result["f"] * d, result["r"]], axis=1)

    @property
    def _pushed(self) -> float:
        """Force, in the scaled units, that formulas of `forces` have at some positions; others may cancel it there."""
        q = self.drawn(PUSHED)
        found = self.at(q, np.zeros((len(q), len(self.v.multipliers))))
        return float(np.nan_to_num(np.abs(found["push"] * self.sizes)).max(initial=0.0))

    @property
    def _typical(self) -> float:
        """Force, in the scaled units, that is no rounding: the largest at the start."""
        found = self.at(self.start[None, :], np.zeros((1, len(self.v.multipliers))))
        size = float(np.nan_to_num(np.abs(found["f"] * self.sizes)).max(initial=0.0))
        return max(size, 1e-6)

    def _turns(self) -> list[bool]:
        """Which coordinates are angles that a whole turn brings back, as it does not where a spring counts turns."""
        here = np.array([[0.3 + 0.7 * k for k in range(len(self.start))]])
        none, found = np.zeros((1, len(self.v.multipliers))), []
        before = self.at(here, none)
        for k, unit in enumerate(self.units):
            after = self.at(here + 2 * np.pi * (np.arange(here.shape[1]) == k), none)
            same = all(
                np.allclose(before[name], after[name], rtol=1e-9, atol=1e-9 * (1 + np.abs(before[name]).max(initial=0)))
                for name in "fr"
            )
            found.append(unit == "rad" and same)
        return found

    def wrapped(self, q: Array) -> Array:
        """Return a position with angles within (-π, π] where a turn brings all back, and one of q and -q."""
        found = q.copy()
        for k, (turns, idle) in enumerate(zip(self.turns, self.idle, strict=True)):
            if turns and not idle:
                turned = np.pi - (np.pi - q[k]) % (2 * np.pi)
                found[k] = np.pi if abs(turned + np.pi) < SAME else turned
            if abs(found[k]) < SAME**2:
                found[k] = 0.0
        names = list(self.scene.coordinates)
        for group in quaternions(self.scene):
            part = slice(names.index(group[0]), names.index(group[0]) + 4)
            first = found[part][np.abs(found[part]) > SAME][:1]
            if first.size and first[0] < 0:
                found[part] *= -1
        return found

    def regular(self, q: Array, rank: int | None = None) -> bool:
        """Tell whether a place is none where coordinates are singular, a wheel lies flat or branches of loops meet.

        `rank` is that of `ranks`, where it is known.
        """
        if self.singular(q, int(self.ranks(q[None, :])[0]) if rank is None else rank) or self.numbers.lying_flat(
            self.state(q)[0]
        ):
            return False
        if self.v.multipliers:
            try:
                self.asked.place(*self.state(q), self.t)
            except LinearizeError:
                return False
        return True

    def singular(self, q: Array, rank: int) -> bool:
        """Tell whether coordinates are singular at a place: angles, or what moves a mass elsewhere in a tree."""
        return rank < self._rank or bool(self.numbers.singular_angles(self.state(q)[0]))

    def ranks(self, q: Array) -> Array:
        """Return how many motions of a tree have an inertia, however small, shape (N,); with rows that is not asked."""
        if self.v.multipliers or not len(q):
            return np.full(len(q), self.n)
        M = np.nan_to_num(self.inertia(q))
        diagonal = np.abs(np.diagonal(M, axis1=1, axis2=2))
        d = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        along = np.linalg.eigvalsh(M * d[:, :, None] * d[:, None, :])
        return np.asarray((along > MASS).sum(axis=1))

    @cached_property
    def _rank(self) -> int:
        return int(self.ranks(self.drawn(PUSHED)).max(initial=0))

    def locked(self, q: Array) -> bool:
        """Tell whether forces do no work at a singular place on anything that the bodies can do; of a tree alone."""
        if self.v.multipliers:
            return False
        rng = random.Random(3)
        away = np.array([[rng.uniform(0.5, 1) for _ in q] for _ in range(PUSHED)])
        return bool(self._pulled(q + BESIDE * away).max() <= WORKS * self._pulled(self.drawn(PUSHED)).max())

    def _pulled(self, q: Array) -> Array:
        """Return √(fᵀ M⁻¹ f), the size of accelerations, shape (N,)."""
        f = np.nan_to_num(self.at(q, np.zeros((len(q), 0)))["f"] * self.sizes)
        inverse = np.linalg.pinv(np.nan_to_num(self.inertia(q)), rcond=MASS / 10, hermitian=True)
        return np.asarray(np.sqrt(np.abs(np.einsum("ni,nij,nj->n", f, inverse, f))))

    def crossing(self, q: Array) -> bool:
        """Tell whether rows of loops depend on each other at a place, and what is left of them balances the forces."""
        if any(amiss(self.state(q)[0]) for amiss in (self.numbers.singular_angles, self.numbers.lying_flat)):
            return False
        found = self.at(q[None, :], np.zeros((1, len(self.v.multipliers))))
        f, G = found["f"][0] * self.sizes, found["G"][0] * self.sizes
        if not (len(G) and np.isfinite(G).all() and np.isfinite(f).all()):
            return False
        lengths = np.linalg.norm(G, axis=1, keepdims=True)
        _, values, ways = np.linalg.svd(G / np.where(lengths > 0, lengths, 1.0))
        rank = int(np.sum(values > RANK * values[0]))
        held = ways[:rank]
        left = np.abs(f - held.T @ (held @ f)).max(initial=0.0)
        return bool(rank < len(G) and left <= NEAR * max(np.abs(f).max(initial=0.0), self._typical))

    def same(self, x: Array, y: Array, near: float = SAME) -> bool:
        """Tell whether two places are one."""
        apart = np.abs(x - y)
        turned = np.abs(np.pi - np.abs(apart % (2 * np.pi) - np.pi))
        return bool(np.where(self.turns, turned, apart).max(initial=0.0) < near)

    def sloped(self, q: Array) -> npt.NDArray[np.bool_]:
        """Tell at which positions the equations have slopes, (N,): not where a spring has no length, so no way."""
        J, _ = self._scaled(self.at(q, np.zeros((len(q), len(self.v.multipliers)))))
        return np.asarray(np.isfinite(J).all(axis=(1, 2)))

    def flat(self, q: Array) -> bool:
        """Tell whether there are equilibria next to one, moves of idle coordinates apart."""
        J, _ = self._scaled(self.at(q[None, :], self._multipliers(q)))
        lost = J.shape[2] - int(np.linalg.matrix_rank(J[0], tol=FLAT * np.abs(J[0]).max(initial=1e-300)))
        return bool(lost > sum(self.idle))

    def _multipliers(self, q: Array) -> Array:
        """Return the multipliers that balance the forces at a place of rest, shape (1, rows); zeros at a crossing."""
        found = np.zeros((1, len(self.v.multipliers)))
        if self.v.multipliers and self.regular(q):
            found[0] = self.asked.place(*self.state(q), self.t).point.multipliers
        return found

    def near(self, q: Array) -> SecondOrder:
        """Return inertia, damping and stiffness at a place of rest."""
        n, still = self.n, dict.fromkeys([*self.v.u, *self.v.a, *self.v.multipliers], 0.0)
        values = {**self.values, **still, **dict(zip(self.letters, q.tolist(), strict=True))}
        M, e = self.v.motion.over(values, 1)["M"][0], self.v.slopes.over(values, 1)["e"][0]
        return SecondOrder(M, e[:, n : 2 * n], self.at(q[None, :], self._multipliers(q))["K"][0])

    def eigenvalues(self, q: Array) -> Complexes:
        """Return the eigenvalues of the motion next to a place, of the stiffness where not all of it has an inertia."""
        try:
            return self.asked.at(*self.state(q), self.t).poles
        except LinearizeError:
            return np.linalg.eigvals(self.near(q).K).astype(np.complex128)


def nearest(prepared: Prepared, q: Array, u: Array, t: float = 0.0, whole: bool = True) -> tuple[Array, Array] | None:
    """Return the equilibrium, q and u, that Newton's method leads to from a state, None where it leads nowhere.

    Whole turns are taken away, but for those who compare it with where it began.
    """
    search = Search(prepared, Problem(prepared.scene, prepared.forces).initial.q, t)
    found, good = search.roots(np.append(q, u[len(prepared.scene.velocities) :])[None, :])
    if not (good[0] and search.regular(found[0])):
        return None
    return search.state(search.wrapped(found[0]) if whole else found[0])
