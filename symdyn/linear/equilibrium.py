"""Where a mechanism stays at rest: roots of the forces, by Newton's method from many starts at once.

    f(q, λ) = e at u = u̇ = 0      forces that nothing balances, λ of all rows, those of rolling included
    r(q)                           residuals of the rows that hold positions

    [X f  -Gᵀ] [δξ]     [f]
    [G_h   0 ] [δλ] = - [r]        solved in least squares: where equilibria are not isolated the nearest is taken

Seeds are fixed, so that the same scene gives the same list. Coordinates on which nothing depends stay where the scene
starts. Where angles are singular, forces may vanish though no body is in balance: such places are no equilibria. Where
branches of loops meet, as where the arms of a governor hang down, rows depend on each other: if what is left of them
balances the forces, it rests there, but has no one linear motion; such places are told apart.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.errors import LinearizeError
from symdyn.graph import Expr, reachable
from symdyn.linear.eliminated import RANK
from symdyn.linear.modes import Complexes
from symdyn.linear.prepared import Prepared
from symdyn.scene import SceneUnits
from symdyn.simulation import opened, read_start

STARTS = 200
"""Seeded starts."""

STEPS, SMALL = 60, 1e-11
"""Newton steps at most, and the step, rad or m, that is none."""

PUSHED = 8
"""Starts at which it is looked how large forces are."""

FARTHEST = 0.7
"""Longest step, rad or m."""

BALANCED = 1e-8
"""Forces over the largest of their parts that are in balance."""

SAME = 1e-6
"""Distance of positions that are one, rad or m."""

NEAR = 1e-4
"""The same where rows lose rank and Newton's steps only halve what is missing; and forces over the largest there."""

ALIKE = 1e-5
"""Distance of eigenvalues, over the largest, that are one."""

FLAT = 1e-8
"""Singular values of the stiffness, over the largest, below which positions next to it are equilibria too."""


FAMILY = 12
"""Places with other equilibria next to them that are told: more of them are one surface of rests, seen again."""


@dataclass(frozen=True)
class Equilibrium:
    """A position of rest.

    Attributes:
        q: coordinates, shape (nq,).
        found: how many of the starts led there.
        family: whether others are next to it, along more than coordinates on which nothing depends.
    """

    q: Array
    found: int
    family: bool


@dataclass(frozen=True)
class Equilibria:
    """What was found.

    Attributes:
        places: in the order of their coordinates.
        starts: how many starts were tried.
        lost: how many of them led nowhere.
        singular: how many of them led to where angles are singular, a wheel lies flat, or rows of loops lose rank where
            they balance nothing.
        idle: coordinates on which nothing depends: they may have any value.
        crossings: where it rests too, but branches of loops meet, so that there is no one linear motion.
        more: how many of them led to further places with others next to them; FAMILY of those are told.
    """

    places: tuple[Equilibrium, ...]
    starts: int
    lost: int
    singular: int
    idle: tuple[str, ...]
    crossings: tuple[Equilibrium, ...] = ()
    more: int = 0


def equilibria(prepared: Prepared, t: float = 0.0, starts: int = STARTS) -> Equilibria:
    """Return the positions of rest that seeded starts lead to, at a time, s.

    Raises:
        LinearizeError: a prescribed motion does not rest.
    """
    scene, u = prepared.scene, read_start(prepared.scene).u
    led = ", ".join(f"{scene.velocities[k]} = {u[k]:g}" for k in prepared.functions.w.prescribed.place if u[k])
    if led:
        raise LinearizeError(
            f"{scene.name}: no position of rest: a prescribed motion goes on, {led}; for a steady motion say where, "
            "as in --at NAME=VALUE"
        )
    search = _Search(prepared, t)
    q, good = search.roots(search.drawn(starts))
    clear = np.array([bool(ok) and search.regular(one) for one, ok in zip(q, good, strict=True)])
    places: list[Equilibrium] = []
    spectra: list[Complexes] = []
    more = 0
    for one in (search.wrapped(x) for x in q[clear]):
        family = search.flat(one)
        known = next((k for k, other in enumerate(places) if search.same(one, other.q)), None)
        values = search.eigenvalues(one) if family and known is None else np.zeros(0, dtype=np.complex128)
        if known is None and family:
            some = (k for k, other in enumerate(places) if other.family and _alike(values, spectra[k]))
            known = next(some, None)
        if known is None and family and sum(place.family for place in places) == FAMILY:
            more += 1
        elif known is None:
            places.append(Equilibrium(one, 1, family))
            spectra.append(values)
        else:
            places[known] = replace(places[known], found=places[known].found + 1)
    odd = np.logical_and(good, np.logical_not(clear))
    crossings: list[Equilibrium] = []
    for one in (search.wrapped(x) for x in q[odd] if search.crossing(x)):
        known = next((k for k, other in enumerate(crossings) if search.same(one, other.q, NEAR)), None)
        if known is None:
            crossings.append(Equilibrium(one, 1, False))
        else:
            crossings[known] = replace(crossings[known], found=crossings[known].found + 1)
    return Equilibria(
        _sorted(places), starts, int(np.sum(np.logical_not(good))), int(np.sum(odd)) - sum(x.found for x in crossings),
        tuple(name for name, idle in zip(prepared.scene.coordinates, search.idle, strict=True) if idle),
        _sorted(crossings), more,
    )  # fmt: skip


def _sorted(places: Sequence[Equilibrium]) -> tuple[Equilibrium, ...]:
    return tuple(sorted(places, key=lambda place: [round(float(x), 6) + 0.0 for x in place.q]))


def nearest(prepared: Prepared, q: Array, t: float = 0.0, whole: bool = True) -> Array | None:
    """Return the equilibrium that Newton's method leads to from a position, None where it leads nowhere.

    Whole turns are taken away, but for those who compare it with where it began.
    """
    search = _Search(prepared, t)
    found, good = search.roots(q[None, :])
    if not (good[0] and search.regular(found[0])):
        return None
    return search.wrapped(found[0]) if whole else found[0]


class _Search:
    """Newton's method over many positions at once, shape (N, nq)."""

    def __init__(self, prepared: Prepared, t: float) -> None:
        self.asked, self.v, self.scene, self.t = prepared, prepared.functions, prepared.scene, t
        self.block, state, graph = self.v.statics, self.v.w.state, self.v.w.graph
        self.values: dict[Expr, Any] = {graph.symbol(name): x for name, x in opened(self.scene).values.items()}
        self.values[graph.symbol(TIME)] = t
        acting = (*state.tau, *map(graph.symbol, self.v.inputs))
        self.values |= dict(zip(acting, prepared.forces.tabulated(np.asarray(t), len(acting)).tolist(), strict=True))
        parts = self.block.parts
        needed = set(reachable([x for name in "frG" for x in parts[name][1]]))
        self.idle = [q not in needed for q in state.q]
        self.start = read_start(self.scene).q
        here = prepared.place(self.start, np.zeros(state.n), t)
        self.sizes, self.units = here.sizes, SceneUnits(self.scene).coordinates
        self.turns, self.numbers = self._turns(), opened(self.scene).numbers()

    def at(self, q: Array, multipliers: Array) -> dict[str, Array]:
        """Return the parts of the equations, shape (N, ...)."""
        values = dict(self.values)
        values |= dict(zip(self.v.w.state.q, q.T, strict=True))
        values |= dict(zip(self.v.multipliers, multipliers.T, strict=True))
        return self.block.over(values, len(q))

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
        n, rows = self.v.w.state.n, len(self.v.multipliers)
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

    def regular(self, q: Array) -> bool:
        """Tell whether a place is none where angles are singular, a wheel lies flat or branches of loops meet."""
        if self.numbers.singular_angles(q) or self.numbers.lying_flat(q):
            return False
        try:
            self.asked.place(q, np.zeros(self.v.w.state.n), self.t)
        except LinearizeError:
            return False
        return True

    def crossing(self, q: Array) -> bool:
        """Tell whether rows of loops depend on each other at a place, and what is left of them balances the forces."""
        if self.numbers.singular_angles(q) or self.numbers.lying_flat(q):
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

    def flat(self, q: Array) -> bool:
        """Tell whether there are equilibria next to one, moves of idle coordinates apart."""
        here = self.asked.place(q, np.zeros(self.v.w.state.n), self.t)
        found = self.at(q[None, :], here.point.multipliers[None, :])
        J, _ = self._scaled(found)
        lost = J.shape[2] - int(np.linalg.matrix_rank(J[0], tol=FLAT * np.abs(J[0]).max(initial=1e-300)))
        return bool(lost > sum(self.idle))

    def eigenvalues(self, q: Array) -> Complexes:
        """Return the eigenvalues of the motion next to a place."""
        return self.asked.at(q, np.zeros(self.v.w.state.n), self.t).eigenvalues


def _alike(x: Complexes, y: Complexes) -> bool:
    """Tell whether two sets of eigenvalues are one."""
    if len(x) != len(y):
        return False
    apart, size = np.abs(x[:, None] - y[None, :]), max(float(np.abs(x).max(initial=0.0)), 1e-9)
    return bool(np.max([apart.min(axis=0), apart.min(axis=1)], initial=0.0) < ALIKE * size)
