"""What every joint type tells the algorithms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symdyn.graph import Expr
from symdyn.spatial import Transform, Vec


@dataclass(frozen=True)
class JointKind:
    """One joint type.

    Attributes:
        class_t: how many of the six relative freedoms it takes away (textbook's connection of class t).
        nv: number of velocities, 6 - class_t.
        units: unit of each coordinate ("rad" or "m"), shape (nv,).
        motion: placement of the moved joint frame in the joint frame, from the unit axis and the coordinates.
        subspace: motion subspace S in the moved joint frame: pairs (angular, linear), shape (nv,), from the unit axis.
    """

    class_t: int
    units: tuple[str, ...]
    motion: Callable[[Vec, tuple[Expr, ...]], Transform]
    subspace: Callable[[Vec], tuple[tuple[Vec, Vec], ...]]

    @property
    def nv(self) -> int:
        """Number of velocities."""
        return 6 - self.class_t
