"""Where a stretch is looked at, and how far what is smooth can bend between the looks.

    f(s) ≈ Σ c_j T_j(s)        -1 ≤ s ≤ 1, from values at s_k = -cos(π k / n)
    |T_j''| ≤ j² (j² - 1) / 3  so that f leaves its chord between two nodes by Σ |c_j| j² (j² - 1)/3 · Δ²/8 at most

The nodes are no multiples of each other: a formula whose period is a part of the stretch does not hide between them.

Reference: Trefethen, Approximation Theory and Approximation Practice (2013), chapters 2 and 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array


@dataclass(frozen=True)
class Looks:
    """Nodes of a stretch.

    Attributes:
        parts: where they are, over its length, ascending from 0 to 1; shape (n + 1,).
        coefficients: what makes c of values at the nodes, shape (n + 1, n + 1).
        bends: what |c_j| adds to how far the interpolant leaves a chord, shape (n + 1,).
    """

    parts: Array
    coefficients: Array
    bends: Array

    def times(self, begin: float, end: float) -> Array:
        """Return the times of the nodes, the ends as they are."""
        found = begin + (end - begin) * self.parts
        found[-1] = end
        return found

    def bend(self, values: Array) -> Array:
        """Return how far formulas can leave their chords, shape (k,), from values (n + 1, k)."""
        return np.asarray(self.bends @ np.abs(self.coefficients @ values))

    def sure(self, values: Array) -> npt.NDArray[np.bool_]:
        """Tell which formulas have no zero in the stretch, shape (k,), from values (n + 1, k); NaN is not sure."""
        signs = np.sign(values)
        alike = np.all(signs == signs[0], axis=0)
        return np.asarray(alike & (np.abs(values).min(axis=0) > self.bend(values)))


def looks(n: int) -> Looks:
    """Return n + 1 nodes, n even."""
    k = np.arange(n + 1)
    halved = np.where((k == 0) | (k == n), 0.5, 1.0)
    angles = np.pi * np.outer(k, n - k) / n
    parts = (1.0 - np.cos(np.pi * k / n)) / 2
    parts[n // 2] = 0.5
    widest = np.sin(np.pi / n)
    return Looks(parts, 2.0 / n * np.cos(angles) * np.outer(halved, halved), widest**2 / 8 * k**2 * (k**2 - 1.0) / 3)


FIRST = looks(4)
"""The looks at every step."""

CLOSER = looks(16)
"""The looks at a stretch where the first were not sure."""
