"""What the rows and columns of matrices stand for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Axis:
    """What the rows or columns of a matrix stand for, and their units."""

    names: tuple[str, ...]
    units: tuple[str, ...]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.names)

    def of(self, places: Sequence[int]) -> Axis:
        """Return some of them."""
        return Axis(tuple(self.names[k] for k in places), tuple(self.units[k] for k in places))
