"""A mechanism next to a place of rest, to first order: M δq̈ + D δq̇ + K δq = 0.

M = ∂²K/∂q̇²    K = ∂(k_G + k_E - Q)/∂q    D = -∂Q/∂q̇        all at the place, q̇ = 0
(K - ω² M) v = 0                            frequencies ω and shapes v, as long as nothing damps
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import generalized_forces
from symdyn.graph import Expr, gradient, substitute
from symdyn.teach.derivations.afterwards.equilibria import RestPlace, Rests
from symdyn.teach.lesson import Lesson
from symdyn.teach.shown_state import Chosen

STILL = 1e-9
"""ω² over the largest, or an inertia, that is none."""

Nodes = list[list[Expr]]


@dataclass(frozen=True)
class FirstOrder:
    """The matrices at a place of rest.

    Attributes:
        moved: the coordinates that have an inertia there, which alone the matrices are of.
        nodes: M and K as functions of parameters, at a place that is known exactly; of the position elsewhere.
        M, K, D: the same and the damping in numbers, shape (n, n).
        at: where all coordinates are, shape (nq,).
    """

    moved: tuple[int, ...]
    nodes: tuple[Nodes, Nodes]
    M: Array
    K: Array
    D: Array
    at: Array

    @property
    def symmetric(self) -> bool:
        """Whether the forces have a potential."""
        return bool(np.abs(self.K - self.K.T).max() <= 1e-9 * np.abs(self.K).max(initial=1e-300))

    @property
    def modes(self) -> list[tuple[float, Array]]:
        """ω², ascending, and shapes, their largest entry 1; for forces with a potential, without damping."""
        L = np.linalg.cholesky(self.M)
        inverse = np.linalg.inv(L)
        squares, shapes = np.linalg.eigh(inverse @ (self.K + self.K.T) / 2 @ inverse.T)
        most, found = float(np.abs(squares).max(initial=0.0)), []
        for square, y in zip(squares, shapes.T, strict=True):
            v = inverse.T @ y
            v = np.where(np.abs(v) > STILL * np.abs(v).max(), v, 0.0)
            found.append((0.0 if abs(square) <= STILL * most else float(square), v / v[np.abs(v).argmax()]))
        return found

    @property
    def eigenvalues(self) -> list[complex]:
        """Of the motion with damping, 1/s, those that grow fastest first; of a pair the one above, of zeros one."""
        n = len(self.M)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(self.M, np.hstack([self.K, self.D]))]])
        values = [complex(x) for x in np.linalg.eigvals(A)]
        size = max(map(abs, values), default=0.0)
        near = [complex(*(0.0 if abs(part) < 1e-7 * size else part for part in (x.real, x.imag))) for x in values]
        return sorted({x for x in near if x.imag >= 0}, key=lambda x: (-x.real, x.imag))


def first_order(lesson: Lesson, rests: Rests, place: RestPlace, chosen: Chosen) -> FirstOrder | None:
    """Return the motion next to a place for the values of the lesson; None where an inertia is not positive there."""
    state, graph, n = lesson.state, lesson.graph, lesson.state.n
    still = dict.fromkeys(state.qd, graph.zero)
    M = [gradient(p, state.qd) for p in lesson.momenta]
    K = [gradient(f, state.q) for f in rests.rest.forces]
    acting = generalized_forces(lesson.scene, graph)
    D = [substitute([-x for x in gradient(force, state.qd)], still) for force in acting]
    here = {q: float(x) for q, x in zip(rests.rest.q, place.at, strict=True)}
    values = chosen.moved({**here, **dict.fromkeys(state.qd, 0.0)})
    inertia, stiffness, damping = (
        np.array(values.of(*(x for row in rows for x in row))).reshape(n, n) for rows in (M, K, D)
    )
    moved = tuple(k for k in range(n) if np.abs(inertia[k]).max() > STILL * np.abs(inertia).max(initial=0.0))
    part = np.ix_(moved, moved)
    along = np.linalg.eigvalsh(inertia[part])
    if not moved or not along[0] > STILL * np.abs(along).max():
        return None
    exact = {} if place.exact is None else dict(zip(rests.rest.q, place.exact, strict=True))
    nodes = [[substitute([row[k] for k in moved], exact) for row in (rows[i] for i in moved)] for rows in (M, K)]
    at = np.array([here.get(q, float(chosen.values[q])) for q in state.q])
    return FirstOrder(moved, (nodes[0], nodes[1]), inertia[part], stiffness[part], damping[part], at)
