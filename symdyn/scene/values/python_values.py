"""What a user writes in Python wherever a scene wants a number, a direction or a placement; and tables made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from symdyn.scene.values.model import Pose
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.table import Entry

Number = int | float | Fraction | str | Quantity
Three = Sequence[Number]
Placement = Pose | Mapping[str, Three] | Sequence[object]


def entry(kind: str, name: str, **table: object) -> Entry:
    """Return a table of what was given; what is None or at its default was not."""
    given = {key: value for key, value in table.items() if value is not None}
    return Entry(str(name), given, f"{kind}.{name}")
