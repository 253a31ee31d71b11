"""A mechanism next to a place of rest, to first order in what moves it: M δξ̈ + D δξ̇ + K δξ = 0.

M = ∂e/∂u̇    D = ∂e/∂u    K = X e        all at the place, at u = u̇ = 0
(K - ω² M) v = 0                         frequencies ω and shapes v, as long as nothing damps
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symdyn.algebra import Array
from symdyn.linear.modes import Spectrum, spectrum
from symdyn.unlocked import cached_property

STILL = 1e-9
"""Of ω² over the largest, of an inertia, of what keeps K from being symmetric: less is none."""


@dataclass(frozen=True, eq=False)
class SecondOrder:
    """The matrices at a place of rest, of displacements along velocities.

    Attributes:
        M: inertia, shape (n, n).
        D: damping, shape (n, n).
        K: stiffness, shape (n, n).
    """

    M: Array
    D: Array
    K: Array

    @property
    def moved(self) -> tuple[int, ...]:
        """The velocities against which there is an inertia; others decide no motion."""
        size = np.abs(self.M).max(initial=0.0)
        return tuple(k for k, row in enumerate(self.M) if np.abs(row).max() > STILL * size)

    def of(self, some: tuple[int, ...]) -> SecondOrder:
        """Return the matrices of some velocities alone."""
        part = np.ix_(some, some)
        return SecondOrder(self.M[part], self.D[part], self.K[part])

    @property
    def moves(self) -> bool:
        """Whether every motion has a positive inertia, without which there are no modes."""
        along = np.linalg.eigvalsh(self.M)
        return bool(len(along) and along[0] > STILL * np.abs(along).max())

    @property
    def symmetric(self) -> bool:
        """Whether the forces have a potential."""
        return bool(np.abs(self.K - self.K.T).max(initial=0.0) <= STILL * np.abs(self.K).max(initial=1e-300))

    @property
    def kind(self) -> str:
        """What the potential energy says, after Lagrange and Dirichlet: "stable" where it is least, else "unstable".

        "undecided" where second derivatives do not tell, or forces have no potential.
        """
        least, size = np.linalg.eigvalsh((self.K + self.K.T) / 2).min(initial=np.inf), np.abs(self.K).max(initial=0.0)
        if not self.symmetric or not size or abs(least) <= STILL * size:
            return "undecided"
        return "stable" if least > 0 else "unstable"

    @cached_property
    def spectrum(self) -> Spectrum:
        """Eigenvalues of the motion with damping."""
        n = len(self.M)
        below = -np.linalg.solve(self.M, np.hstack([self.K, self.D]))
        return spectrum(np.block([[np.zeros((n, n)), np.eye(n)], [below]]))

    @property
    def modes(self) -> tuple[tuple[float, Array], ...]:
        """ω², ascending, and shapes, shape (n,), their largest entry 1, as long as nothing damps; of symmetric K."""
        n = len(self.M)
        K = (self.K + self.K.T) / 2
        free = replace(self, K=K, D=np.zeros((n, n))).spectrum
        found = [(0.0, way) for way in free.still[:n].T]
        for mode in free.modes:
            if mode.oscillates or mode.value.real > 0:
                way = mode.shape[:n]
                found.append((float((-(mode.value**2)).real), (way / way[np.abs(way).argmax()]).real))
        shapes = [(square, _clean(way)) for square, way in found]
        return tuple(sorted(shapes, key=lambda one: (one[0], int(np.abs(one[1]).argmax()))))


def _clean(way: Array) -> Array:
    """Return a shape with its largest entry 1, and without what is rounding."""
    way = np.where(np.abs(way) > STILL * np.abs(way).max(), way, 0.0)
    return np.asarray(way / way[np.abs(way).argmax()]) + 0.0  # -0 is 0
