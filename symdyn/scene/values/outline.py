"""What bodies look like: a row a word, its sizes, and which homogeneous body has the inertia that a body has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Share = tuple[float, float, float]


@dataclass(frozen=True)
class OutlineKind:
    """A word of the key `shape`.

    Attributes:
        sizes: what its lengths are called, m; each by shares c of the principal moments I1 <= I2 <= I3 about the
            centre of mass, of which it is the root of (c1 I1 + c2 I2 + c3 I3) / mass.
        ways: how many directions it extends in, of those of I1, I2, I3 in order.
        half: whether sizes are whole lengths, of which pictures draw half to each side.
        axis: the principal moment about whose axis it is round, or along or across which it lies; None: it has none.
        rolls: whether the rim of what rolls looks like it already.
    """

    sizes: Mapping[str, Share]
    ways: int
    half: bool = False
    axis: int | None = None
    rolls: bool = True


OUTLINES: Mapping[str, OutlineKind] = {
    "rod": OutlineKind({"length": (0, 0, 12)}, 1, half=True, axis=0, rolls=False),
    "disc": OutlineKind({"radius": (0, 0, 2)}, 2, axis=2),
    "ring": OutlineKind({"radius": (0, 0, 1)}, 2, axis=2),
    "ball": OutlineKind({"radius": (0, 0, 5 / 2)}, 3),
    "plate": OutlineKind({"width": (0, 12, 0), "height": (12, 0, 0)}, 2, half=True, axis=2, rolls=False),
    "point": OutlineKind({}, 0),
}
"""Thin rods, discs and plates, a thin ring, a full ball (tables of moments of inertia in any textbook)."""
