"""Places of rest told from places where coordinates are singular.

Where angles are singular these forces may vanish though no body is in balance; such places are named.

    v = J q̇          velocities of all bodies: of a point, and angular
    f = Jᵀ w         generalized forces at rest, of the forces w against those velocities
    J⁺ᵀ f            the part of w that works on what the bodies can do: zero at rest, and only there

There J loses rank, so f says less than w: a rotation that the bodies can make is none that the coordinates can tell.
The part that works is then looked at beside the place, where J has its rank.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.graph import Expr, gradient, tangents
from symdyn.teach.derivations.lagrange.rotations import angular_velocity
from symdyn.teach.lesson import Lesson
from symdyn.teach.shown_state import Chosen

BESIDE = 1e-5  # rad or m
WORKS = 1e-3  # of what works elsewhere: more than this is no rest
TURNED = 1e-6  # of the largest singular value of J: less is a motion that the coordinates do not tell
PLACES = 4


class Judge:
    """Tells places of rest from places where coordinates are singular."""

    def __init__(self, lesson: Lesson, chosen: Chosen, q: Sequence[Expr], forces: Sequence[Expr]) -> None:
        """Look at the forces at rest, and the coordinates q on which they depend, at a few places."""
        self.chosen, self.places, self.forces = chosen, q, forces
        self.q, self.rank = lesson.state.q, 0
        self.J: list[Expr] = []
        for body in lesson.scene.bodies:
            origin = tangents(lesson.placed[body.name].p, lesson.state.velocity)
            self.J += [x for v in (*origin, *angular_velocity(lesson, body)) for x in gradient(v, lesson.state.qd)]
        rng = random.Random(2)
        around = [self._measured(np.array([rng.uniform(-1.5, 1.5) for _ in self.q])) for _ in range(PLACES)]
        self.rank = max((rank for rank, _ in around), default=0)
        self.size = max((work for _, work in around), default=0.0)

    def rests(self, place: Array) -> bool:
        """Tell whether forces whose generalized forces vanish there do no work on anything that the bodies can do."""
        at = dict(zip(self.places, place, strict=True))
        rng, q = random.Random(3), np.array([at.get(q, self.chosen.values[q]) for q in self.q])
        if self._measured(q)[0] >= self.rank:
            return True
        beside = [q + BESIDE * np.array([rng.uniform(0.5, 1) for _ in q]) for _ in range(PLACES)]
        return max(self._measured(one)[1] for one in beside) <= WORKS * self.size

    def _measured(self, q: Array) -> tuple[int, float]:
        """Return the rank of J and the size of what works."""
        n, at = len(self.q), self.chosen.moved(dict(zip(self.q, map(float, q), strict=True)))
        try:
            flat = np.array(at.of(*self.forces, *self.J))
        except (ArithmeticError, ValueError):  # a spring of no length, a pole
            return self.rank, 0.0
        f, J = flat[:n], flat[n:].reshape(-1, n)
        rank = int(np.linalg.matrix_rank(J, tol=TURNED * np.abs(J).max(initial=0.0)))
        return rank, float(np.linalg.norm(np.linalg.pinv(J.T, rcond=1e-9) @ f))
