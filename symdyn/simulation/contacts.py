"""What contacts would need in the world: normal forces that push, and friction enough not to slip.

    N, F     multipliers of a contact along the normal, and in the plane

The equations take contacts as two-sided and without slip; both are looked at in what they give.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symdyn.dynamics.loops.closure import Closure, loose_rows
from symdyn.dynamics.loops.numbers import Numbers
from symdyn.scene import Row, Scene
from symdyn.simulation.decisions import closure_of
from symdyn.simulation.multipliers import multipliers

Array = npt.NDArray[np.float64]

NOTHING = 1e-9
"""Forces over the largest that are rounding."""


@dataclass(frozen=True)
class Needed:
    """What a contact needs over a motion.

    Attributes:
        row: of the scene.
        normal: N, shape (N,); it pulls where it is negative.
        friction: |F| / N at least, where the contact pushes; 0 elsewhere, shape (N,).
    """

    row: Row
    normal: Array
    friction: Array


def needed(scene: Scene, t: Array, q: Array, u: Array, a: Array, tau: Array) -> tuple[list[Needed], list[str]]:
    """Return what contacts that hold a height need over a motion, and what is to be said of it.

    Args:
        scene: the mechanism, its parameters bound.
        t: times, s, shape (N,).
        q: positions, shape (N, nq).
        u: velocities, shape (N, nv).
        a: their rates, shape (N, nv).
        tau: driving forces, those of prescribed motions included, shape (N, nv).
    """
    contacts = [row for row in scene.rows if row.touches]
    if not contacts:
        return [], []
    closure, numbers = closure_of(scene)
    places = _places(closure, numbers)
    labels = [numbers.constraints.labels[k] for k in loose_rows(numbers, closure.assembly)]
    shared = {(label.owner, label.number) for label in labels if not label.loop}
    sizes = multipliers(scene, t, q, u, a, tau)
    found, notes = [], []
    for row in contacts:
        mine = {row.components[number]: k for (name, number), k in places.items() if name == row.name}
        if "normal" not in mine or any((row.name, number) in shared for number in range(len(row.components))):
            notes.append(f"contact {row.name}: its forces are not unique, so that nothing is told of them")
            continue
        normal = sizes[:, mine["normal"]]
        plane = np.hypot(
            *(sizes[:, mine[way]] if way in mine else np.zeros_like(normal) for way in ("along", "across"))
        )
        size = float(np.abs(sizes).max(initial=0.0))
        pushes = normal > NOTHING * size
        one = Needed(row, normal, np.where(pushes, plane / np.where(pushes, normal, 1.0), 0.0))
        found.append(one)
        notes += _told(one, t, size)
    return found, notes


def _told(one: Needed, t: Array, size: float) -> list[str]:
    """Return whether a contact would pull, and the friction that it needs."""
    notes, where = [], f"contact {one.row.name}"
    pulls = np.flatnonzero(one.normal < -NOTHING * size)
    if len(pulls):
        worst = int(one.normal.argmin())
        notes.append(
            f"{where}: its normal force would pull at t = {t[pulls[0]]:.6g} s, by up to {-one.normal[worst]:.3g} N at "
            f"t = {t[worst]:.6g} s; {one.row.place.body if one.row.place else ''} would lift off there, which this "
            "model does not know"
        )
    if float(one.friction.max(initial=0.0)) > NOTHING:
        k = int(one.friction.argmax())
        notes.append(f"{where}: not to slip takes a friction coefficient of {one.friction[k]:.3g} at t = {t[k]:.6g} s")
    return notes


def _places(closure: Closure, numbers: Numbers) -> dict[tuple[str, int], int]:
    """Return the place among the kept rows of every contact's row, by its name and number."""
    labels = numbers.constraints.labels
    kept = [(labels[k], place) for place, k in enumerate(closure.kept)]
    return {(label.owner, label.number): place for label, place in kept if not label.loop}
