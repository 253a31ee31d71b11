"""Places where coordinates are singular: there generalized forces may vanish though no body is in balance.

    v = J q̇          velocities of all bodies: of a point, and angular
    f = Jᵀ w         generalized forces at rest, of the forces w against those velocities
    J⁺ᵀ f            the part of w that works on what the bodies can do: zero at rest, and only there

Where angles are singular J loses rank, so f says less than w: a rotation that the bodies can make is none that the
coordinates can tell. The part that works is then looked at beside the place, where J has its rank.
"""

from __future__ import annotations

import random

import numpy as np

from symdyn.graph import Expr, gradient, tangents
from symdyn.teach.lesson import Lesson
from symdyn.teach.shown_state import Chosen
from symdyn.teach.velocities import angular_velocity

BESIDE = 1e-5  # rad or m
WORKS = 1e-3  # of what works elsewhere: more than this is no rest
TURNED = 1e-6  # of the largest singular value of J: less is a motion that the coordinates do not tell
PLACES = 4


class Judge:
    """Tells places of rest from places where coordinates are singular."""

    def __init__(self, lesson: Lesson, rest: list[Expr], chosen: Chosen) -> None:
        """Collect J; `rest` are the generalized forces at rest, negative."""
        state = lesson.state
        velocities = [v for body in lesson.scene.bodies for v in _velocity(lesson, body.name)]
        self.rest, self.chosen, self.q, self.rank = rest, chosen, state.q, 0
        self.J = [gradient(velocity, state.qd) for velocity in velocities]
        rng = random.Random(2)
        around = [self._measured(np.array([rng.uniform(-1.5, 1.5) for _ in state.q])) for _ in range(PLACES)]
        self.rank = max((rank for rank, _ in around), default=0)
        self.size = max((work for _, work in around), default=0.0)

    def rests(self, place: dict[Expr, float]) -> bool:
        """Tell whether forces whose generalized forces vanish there do no work on anything that the bodies can do."""
        rng, q = random.Random(3), np.array([place.get(q, self.chosen.values[q]) for q in self.q])
        if self._measured(q)[0] >= self.rank:
            return True
        beside = [q + BESIDE * np.array([rng.uniform(0.5, 1) for _ in q]) for _ in range(PLACES)]
        return max(self._measured(one)[1] for one in beside) <= WORKS * self.size

    def _measured(self, q: np.ndarray) -> tuple[int, float]:
        """Return the rank of J and the size of what works."""
        n, values = len(self.q), {**self.chosen.values, **dict(zip(self.q, map(float, q), strict=True))}
        at = Chosen(values, self.chosen.q, self.chosen.parameters)
        try:
            flat = np.array(at.of(*self.rest, *(x for row in self.J for x in row)))
        except (ArithmeticError, ValueError):  # a spring of no length, a pole
            return self.rank, 0.0
        f, J = flat[:n], flat[n:].reshape(-1, n)
        if not np.isfinite(flat).all():
            return self.rank, 0.0
        rank = int(np.linalg.matrix_rank(J, tol=TURNED * np.abs(J).max(initial=0.0)))
        return rank, float(np.linalg.norm(np.linalg.pinv(J.T, rcond=1e-9) @ f))


def _velocity(lesson: Lesson, name: str) -> list[Expr]:
    """Return the velocity of the origin of a body's frame, and its angular velocity."""
    body = next(body for body in lesson.scene.bodies if body.name == name)
    return [*tangents(lesson.placed[name].p, lesson.state.velocity), *angular_velocity(lesson, body)]
