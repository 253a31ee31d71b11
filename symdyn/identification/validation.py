"""How well driving forces are predicted: errors joint by joint, of what was fitted and of what was held back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array


@dataclass(frozen=True)
class Fit:
    """How well one driving force is predicted by base parameters.

    Attributes:
        drive: its name.
        unit: "N m" or "N".
        size: root mean square of the force as measured.
        error: root mean square of measured less predicted, in the band.
        before: the same with the scene's own values; NaN where it has none.
        held_back: the same as `error`, on data that were not fitted; NaN where there are none.
    """

    drive: str
    unit: str
    size: float
    error: float
    before: float
    held_back: float

    @property
    def percent(self) -> float:
        """Error in parts of the force, %."""
        return 100 * self.error / self.size if self.size else float("nan")

    @property
    def held_back_percent(self) -> float:
        """Error on data that were not fitted, %."""
        return 100 * self.held_back / self.size if self.size else float("nan")


def blocks(count: int, share: float, most: int = 4) -> list[tuple[slice, bool]]:
    """Return contiguous parts of `count` samples, and whether each is held back; `share` of all are.

    >>> [(part.start, part.stop, back) for part, back in blocks(100, 0.25, 2)]
    [(0, 37, False), (37, 50, True), (50, 87, False), (87, 100, True)]
    """
    if share <= 0:
        return [(slice(0, count), False)]
    found = []
    for k in range(most):
        low, high = count * k // most, count * (k + 1) // most
        at = low + int((high - low) * (1 - share))
        found += [(slice(low, at), False), (slice(at, high), True)]
    return found


def mean_square(residuals: Array) -> float:
    """Return the root mean square, NaN of nothing."""
    return float(np.sqrt(np.mean(residuals**2))) if len(residuals) else float("nan")
