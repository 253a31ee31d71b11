"""How many operations an output takes, about: told from its row and the scene's tree alone, before anything is derived.

    d_k      velocities from the ground to velocity k, itself included; of a chain of n joints 1, 2, ... n
    size     s Σ_k (c_1 + 2 c_2 d_k + 3 c_3 d_k² + ...) + 3 e Σ_k d_k², of a chain about s (c_1 n + c_2 n² + ...) + e n³

The constants are those of joints with full inertias that turn every way, s = 1. Simpler joints take less, all outputs
about as many times less as inverse dynamics, whose count says how simple they are. What is solved with a full matrix is
not simpler for that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import fsum

from symdyn.scene import Scene

PLENTY = 2_000_000
"""Operations that are written as lines at most: some 4 GB and minutes of derivation and compiling."""


@dataclass(frozen=True)
class Size:
    """About how many operations an output takes.

    Attributes:
        constants: c_1, c_2, ... of the legend, weighed operations as `Counts.cost` has them.
        solved: e of the legend.
    """

    constants: tuple[float, ...]
    solved: float = 0.0

    def times(self, factor: float) -> Size:
        """Return the size of so many of them."""
        return Size(tuple(factor * c for c in self.constants), factor * self.solved)

    def columns(self, factor: float) -> Size:
        """Return the size of a column for each velocity, each so many times as large as this, which solves nothing."""
        return Size((0.0, *self.times(factor).constants))

    def of(self, depths: Sequence[int], simple: float = 1.0) -> float:
        """Return the operations for a tree by its depths, shape (nv,), and s."""
        derived = fsum((k + 1) * c * float(d) ** k for k, c in enumerate(self.constants) for d in depths)
        return simple * derived + 3 * self.solved * fsum(float(d) ** 2 for d in depths)


LINEAR = Size((250.0,))
"""That of what goes through the tree once."""

INVERSE = Size((200.0,))
"""That of inverse dynamics, by which the simplicity of joints is measured."""


def depths_of(scene: Scene) -> list[int]:
    """Return d_k of every velocity, in the order of velocities, shape (nv,)."""
    depth: dict[str, int] = {}
    found = []
    for joint in scene.joints:
        below = depth.get(joint.parent, 0) + len(joint.rates)
        depth[joint.child] = below
        found += [below] * len(joint.rates)
    return found
