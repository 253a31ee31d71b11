"""Joining of two lists of one thing by their names, such as columns of a fit and unknowns of a file, in any order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence


def places_of(requested: Sequence[str], there: Sequence[str]) -> list[int]:
    """Return where each wanted name stands among those that are there, shape (len(wanted),); both have the same names.

    >>> places_of(["fv1", "fc1"], ["fc1", "fv1"])
    [1, 0]
    """
    assert Counter(requested) == Counter(there), f"two lists of one thing part: {[*requested]} and {[*there]}"
    place = {name: k for k, name in enumerate(there)}
    assert len(place) == len(there), f"a name stands twice: {[*there]}"
    return [place[name] for name in requested]
