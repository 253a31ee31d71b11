"""What the rows and columns of results stand for, in words; a result is as long as its labels are many."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.scene import Scene

Axis = Callable[[Workspace], tuple[str, ...]]

COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")
"""Entries of a wrench, by the names that tables and headers have for them."""

TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Entries of a twist, or of its rates."""


def fixed(*names: str) -> Axis:
    """Return rows or columns that are the same for every scene."""
    return lambda _: names


def velocities(w: Workspace) -> tuple[str, ...]:
    """Return a label for each velocity, or the force that does work on it."""
    return w.scene.velocities


def coordinates(w: Workspace) -> tuple[str, ...]:
    """Return a label for each coordinate."""
    return w.scene.coordinates


def pairs(w: Workspace) -> tuple[str, ...]:
    """Return a label for each pair of velocities j < k, in lexicographic order."""
    return tuple(f"{one} {other}" for one, other in combinations(w.scene.velocities, 2))


def prescribed(w: Workspace) -> tuple[str, ...]:
    """Return a label for each velocity whose motion is prescribed."""
    return tuple(w.scene.velocities[k] for k in w.prescribed.place)


def kept_rows(w: Workspace) -> tuple[str, ...]:
    """Return a label for each row that closes loops, those that others imply left out."""
    decisions = w.loops.decisions
    return tuple(decisions.names[k] for k in decisions.independent_rows)


def joints(w: Workspace) -> tuple[str, ...]:
    """Return a label for each joint, then for each loop."""
    return joints_of(w.scene)


def joints_of(scene: Scene) -> tuple[str, ...]:
    """Return the names of joints, then of loops."""
    return tuple(joint.name for joint in (*scene.joints, *scene.loops))


def flagged_entries(rows: Sequence[str], columns: Sequence[str], flags: Sequence[bool]) -> str:
    """Return the flagged entries of a matrix, row by row, such as "fz, mx, my of A, B and C"; "" for none."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for k, row in enumerate(rows):
        here = flags[len(columns) * k : len(columns) * (k + 1)]
        found = tuple(name for name, flag in zip(columns, here, strict=True) if flag)
        if found:
            groups.setdefault(found, []).append(row)
    return "; ".join(f"{', '.join(found)} of {_listed(names)}" for found, names in groups.items())


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
