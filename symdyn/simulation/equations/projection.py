"""Bringing a state back to its constraints: quaternions of unit length, closed loops, velocities that the rows allow.

    r, G        residuals and kept rows of the loops and of the scene, compiled
    q̇ = H u     a step δ along the velocities moves q by H δ

Positions first, by Newton's method with the shortest steps, δ = -G⁺ r; then velocities, u - G⁺ G u. Both converge
quadratically, so that one step is the last where what it takes away is `SMALL`. What has a prescribed motion is not
moved. Where loops hold dependent coordinates in proportion, these follow the independent ones.

Reference: Eich, Convergence results for a coordinate projection method applied to mechanical systems (1993).
"""

from __future__ import annotations

import numpy as np

from symdyn.algebra import Array
from symdyn.simulation.equations.system import StateEquations

STEPS = 8

SMALL = 1e-8
"""What is off by less, of its size, is off by rounding after one step of Newton's."""

NEGLIGIBLE = 1e-9
"""Singular values of G below it, over the largest, are zero: redundant rows, and what a change point loses."""


class Projection:
    """Returns the nearest state that keeps all constraints, None where they are kept well enough.

    Attributes:
        limit: of residuals, of velocities against rows over the fastest one or 1, and of the squared length of
            quaternions less one.
        active: whether there is anything to keep.
    """

    def __init__(self, system: StateEquations, limit: float) -> None:
        """Prepare the projection of a system's states."""
        self.system, self.limit = system, limit
        held = set(system.scene.led_velocities)
        self._loose = np.array([k for k in range(system.nv) if k not in held], dtype=int)
        self.active = bool(system.quaternions) or system.closed

    def __call__(self, x: Array, slack: float = 1.0) -> Array | None:
        """Return the projected state, shape (nx,), where it has drifted further than `slack` times the limit."""
        if not self.active or self.drift(x) <= slack * self.limit:
            return None
        return self.projected(x)

    def drift(self, x: Array) -> float:
        """Return how far the constraints are missed, velocities over the fastest one or 1."""
        lengths = [abs(float(x[part] @ x[part]) - 1.0) for part in self.system.quaternions]
        off = max(lengths, default=0.0)
        if self.system.closed:
            missed = self.system.evaluate("constraint_residual", 0.0, x), self.system.evaluate("row_rates", 0.0, x)
            fastest = max(1.0, float(np.abs(x[self.system.nq : self.system.nq + self.system.nv]).max(initial=0.0)))
            off = max(off, np.abs(missed[0]).max(initial=0.0), np.abs(missed[1]).max(initial=0.0) / fastest)
        return float(off)

    def projected(self, x: Array) -> Array:
        """Return x moved onto the constraints."""
        x = self._normalised(x)
        if not self.system.closed:
            return x
        nq, nv = self.system.nq, self.system.nv
        if self.system.linear:  # whatever G is: at a change point it says little
            return np.concatenate([*self.system.on_manifold(x[:nq], x[nq : nq + nv]), x[nq + nv :]])
        for _ in range(STEPS):
            r, G = self._rows(x)
            off = np.abs(r).max(initial=0.0)
            if off <= 0.01 * self.limit:
                break
            step = np.zeros(nv)
            step[self._loose] = -_least(G[:, self._loose], r)
            x = x.copy()
            x[:nq] += self.system.calls["movement"](x[:nq], step)
            x = self._normalised(x)
            if off <= SMALL:
                break
        G = self.system.jacobian(0.0, x)
        for _ in range(2):  # once more for what rounding has left
            u = x[nq : nq + nv]
            missed = G @ u
            x[nq + self._loose] -= _least(G[:, self._loose], missed)
            if np.abs(missed).max(initial=0.0) <= SMALL * max(1.0, np.abs(u).max(initial=0.0)):
                break
        return x

    def _rows(self, x: Array) -> tuple[Array, Array]:
        """Return r, shape (m,), and G, shape (m, nv)."""
        return self.system.evaluate("constraint_residual", 0.0, x), self.system.jacobian(0.0, x)

    def _normalised(self, x: Array) -> Array:
        x = x.copy()
        for part in self.system.quaternions:
            x[part] /= np.linalg.norm(x[part])
        return x


def _least(G: Array, b: Array) -> Array:
    """Return the shortest of all x that come closest to G x = b."""
    return np.asarray(np.linalg.lstsq(G, b, rcond=NEGLIGIBLE)[0], dtype=np.float64)
