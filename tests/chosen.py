"""Which cases of a function are run when: all by `make slow`, some by `make test`, few by `make quick`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import pytest

QUICK = 2
"""Cases of a function that a quick run takes at most."""

UNMET = pytest.StashKey[list[str]]()
"""Names in marks that no case has: one that is misspelt would leave out all."""


def by_function(items: Iterable[pytest.Item]) -> dict[str, list[pytest.Item]]:
    found: dict[str, list[pytest.Item]] = {}
    for item in items:
        found.setdefault(item.nodeid.partition("[")[0], []).append(item)
    return found


def spared(cases: Sequence[pytest.Item]) -> list[pytest.Item]:
    """Return the cases of a function that `make slow` alone takes, by its marks `wide` and `heavy`."""
    heavy, wide = (cases[0].get_closest_marker(mark) for mark in ("heavy", "wide"))
    found = [item for item in cases if heavy and is_called(item, heavy.args)]
    if wide and isinstance(wide.args[0], int):
        found += [item for place, item in enumerate(cases) if place % wide.args[0]]
    elif wide:
        found += [item for item in cases if not is_called(item, wide.args)]
    return found


def unmet(cases: Sequence[pytest.Item]) -> list[str]:
    """Return what the marks `wide` and `heavy` of a function name and none of its cases is called."""
    names = [name for mark in ("heavy", "wide") for one in cases[0].iter_markers(mark) for name in one.args]
    return [
        f"{cases[0].nodeid}: {name}"
        for name in names
        if isinstance(name, str) and not any(is_called(item, [name]) for item in cases)
    ]


def is_called(item: pytest.Item, names: Iterable[str]) -> bool:
    """Return whether the parameters of a case, between which strokes stand, hold one of some names."""
    parameters = item.nodeid.partition("[")[2].removesuffix("]")
    return any(f"-{name}-" in f"-{parameters}-" for name in names)


def quick(cases: Sequence[pytest.Item]) -> list[pytest.Item]:
    """Return the cases of a function that a quick run takes: of many, some from the first to the last."""
    found = [item for item in cases if not {"slow", "targets", "runs"} & {mark.name for mark in item.iter_markers()}]
    most = QUICK
    if long := cases[0].get_closest_marker("long"):
        most = long.args[0] if long.args else int(len(cases) > 1)
    if len(found) <= most:
        return found
    return [found[k * (len(found) - 1) // max(most - 1, 1)] for k in range(most)]
