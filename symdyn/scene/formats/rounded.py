"""Inertias whose entries were rounded, kept possible: a flat body lies on the edge of what a body can have."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symdyn.scene.formats.placing import decimal_text
from symdyn.scene.values.physical import impossible
from symdyn.scene.values.value import Value

SMALLEST = 2.0**-52
LARGEST = 1e-14
"""Relative to the largest entry; what rounding breaks is mended by less, and what is broken by more was so before."""

PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def possible(entries: Sequence[Value]) -> list[Value]:
    """Return xx, yy, zz, xy, xz, yz so that their decimals are those of a body, if rounding is all that is in the way.

    The same small amount added to each moment leaves the axes alone and leads back from beyond the edge: each sum of
    two principal moments grows by twice as much as the third.
    """
    found = list(entries)
    if not _broken(found):
        return found
    largest = max(abs(float(x)) for x in found)
    slack = SMALLEST
    while slack <= LARGEST:
        raised: list[Value] = [float(x) + slack * largest for x in found[:3]]
        if not _broken([*raised, *found[3:]]):
            return [*raised, *found[3:]]
        slack *= 2
    return found


def _broken(entries: Sequence[Value]) -> bool:
    """Whether the decimals of some entries are rounded, and together those of no body."""
    at = {place: Fraction(decimal_text(x)) for place, x in zip(PLACES, entries, strict=True)}
    if all(isinstance(x, Fraction) and x == at[place] for place, x in zip(PLACES, entries, strict=True)):
        return False
    return impossible([[at[min(i, j), max(i, j)] for j in range(3)] for i in range(3)]) is not None
